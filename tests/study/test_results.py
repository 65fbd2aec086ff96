"""Result files: what is written is read, and what is not readable says why."""

import json
from pathlib import Path

import pytest
from made_results import figure, study, whole_study

from glimt.errors import GlimtError
from glimt.study import results

ROOT = Path(__file__).resolve().parents[2]


def test_what_is_written_is_read(tmp_path):
    made = whole_study()
    path = tmp_path / "new folder" / "results.json"
    results.write(path, made)
    assert results.read(path) == made
    assert [file.name for file in path.parent.iterdir()] == ["results.json"]


def test_every_frame_that_was_timed_is_kept():
    made = figure(3, {"pixels": {100: 1.0, 200: 2.0, 400: 4.0}}, rounds=6)
    assert all(len(point.times_ms) == 6 for point in made.series[0].points)
    assert made.series[0].points[1].times_ms[0][0] == pytest.approx(2.0, rel=0.02)


def test_the_schema_in_the_documents_is_that_of_the_code():
    assert (ROOT / "docs" / "study.schema.json").read_text(encoding="utf-8") == results.schema()


def test_the_schema_describes_a_result():
    described = json.loads(results.schema())["$defs"]
    data = json.loads(whole_study().model_dump_json())
    point = data["figures"][0]["series"][0]["points"][0]
    assert set(point) == set(described["Point"]["properties"])
    assert set(described["Point"]["required"]) <= set(point)


def saved(tmp_path, data):
    path = tmp_path / "results.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data), encoding="utf-8")
    return path


def test_a_file_of_an_older_version_is_brought_up_to_date(tmp_path, monkeypatch):
    data = json.loads(study().model_dump_json())
    data["study"] = 0
    data["machine"]["cpu"] = data["machine"].pop("processor")

    def upgrade(old):
        machine = {key: value for key, value in old["machine"].items() if key != "cpu"}
        return {**old, "study": 1, "machine": {**machine, "processor": old["machine"]["cpu"]}}

    path = saved(tmp_path, data)
    with pytest.raises(GlimtError, match="has format 0, which this glimt no longer reads; run the study again"):
        results.read(path)
    monkeypatch.setitem(results._UPGRADES, 0, upgrade)
    assert results.read(path) == study()


@pytest.mark.parametrize(("change", "message"), [
    (lambda data: {**data, "study": 2}, "has format 2, this glimt reads up to 1; upgrade glimt"),
    (lambda data: {key: value for key, value in data.items() if key != "study"}, "is no result of `glimt study`"),
    (lambda data: {**data, "engine": "tpu"}, "engine: Input should be 'cpu' or 'gpu'"),
    (lambda data: {**data, "figures": [{"number": "x"}]}, "figures.0.number: Input should be a valid integer"),
    (lambda data: {**data, "more": 1}, "more: Extra inputs are not permitted"),
    (lambda data: [data], "is no result of `glimt study`"),
    (lambda data: "{", "cannot be read as a result of a study"),
])
def test_what_is_no_result_says_why(tmp_path, change, message):
    path = saved(tmp_path, change(json.loads(study().model_dump_json())))
    with pytest.raises(GlimtError) as error:
        results.read(path)
    assert message in str(error.value)
    assert str(path) in str(error.value)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(GlimtError, match="cannot be read"):
        results.read(tmp_path / "nix.json")


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(GlimtError, match="cannot be written"):
        results.write(tmp_path / "file" / "results.json", study())

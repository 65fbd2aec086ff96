"""Results as files, against each other, and as tables in a document."""

import json

import pytest

from glimt.bench import results, tables
from glimt.errors import GlimtError

MACHINE = {"processor": "some", "features": ["avx2"], "lanes": 8, "cores": 4, "python": "3", "numba": "0", "glimt": "0"}
MS = {"median": 2.0, "p10": 1.0, "p90": 3.0}
ROWS = {
    "rays": {"mesh": "ball", "triangles": 12, "kind": "primary", "threads": 1, "mrays": {"glimt": 3.0, "way": 2.0},
             "best": "way", "ratio": 1.5, "differing": 0.0},
    "frames": {"row": "room", "title": "a room", "size": [40, 30], "samples": 1, "bounces": 0, "threads": 1,
               "rays": {"primary": 1200, "shadow": 800, "mirror": 0}, "frame_ms": MS, "embree_ms": MS, "mrays": 1.0,
               "yardstick": {"primary": {"rays": 3, "configuration": "way"},
                             "shadow": {"rays": 1, "configuration": "other way"}},
               "differing": {"primary": 4.0, "shadow": 8.0}, "ratio": 0.5, "processor_ratio": 0.6, "speedup": 1.0,
               "embree_speedup": 1.0},
    "growth": {"series": "lights", "count": 2, "threads": 1, "frame_ms": MS, "ratio": 1.25},
}


@pytest.fixture(params=list(ROWS))
def result(request):
    return {"benchmark": request.param, "version": 1, "machine": MACHINE, "rows": [ROWS[request.param]], "threads": 1,
            "mesh": "ball", "instance_triangles": 320, "missing": [{"row": "statues", "reason": "no bunny"}],
            "fits": {"lights": {"ms": 0.5, "at_first": 1.0, "per": "each", "r2": 0.9}}}


def test_a_result_is_kept_and_compared(result, tmp_path):
    path = tmp_path / "result.json"
    results.save(path, result)
    again = results.read(path)
    assert again == json.loads(json.dumps(result))
    assert "| +0 % |" in results.compare(again, again)
    slower = again | {"rows": [row | {"ratio": 2 * row["ratio"]} for row in again["rows"]]}
    assert "| +100 % |" in results.compare(again, slower)


def test_a_table_has_its_numbers_and_the_machine(result):
    text = tables.table(result)
    assert "some (avx2), 8 lanes, 4 cores" in text
    assert "Left out: statues (no bunny)." in text
    expected = {"rays": "| 1.50 |", "frames": "| 0.50 (0.60) | 1.00 (1.00) | 5.0 |", "growth": "| 1.25 |"}
    assert expected[result["benchmark"]] in text


def test_nothing_in_common_is_said(result):
    key = results.KINDS[result["benchmark"]].keys[0]
    other = result | {"rows": [row | {key: "another"} for row in result["rows"]]}
    with pytest.raises(GlimtError, match="no row in common"):
        results.compare(result, other)


def test_different_benchmarks_are_not_compared(result):
    other = result | {"benchmark": "rays" if result["benchmark"] != "rays" else "growth"}
    with pytest.raises(GlimtError, match=f"glimt bench {result['benchmark']}.*cannot be compared"):
        results.compare(result, other)


@pytest.mark.parametrize("content", ["", "{}", "[1]", '{"benchmark": "rays", "version": 99, "rows": []}',
                                     '{"benchmark": "sprints", "version": 1, "rows": []}', '{"benchmark": ["rays"]}',
                                     '{"benchmark": "frames", "version": 1, "rows": 3}'])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "result.json"
    path.write_text(content)
    with pytest.raises(GlimtError, match=r"result\.json"):
        results.read(path)


@pytest.mark.parametrize("row", [3, {}, {"mesh": "ball", "kind": "primary", "threads": 1},
                                 {"mesh": "ball", "kind": "primary", "threads": 1, "ratio": "fast"},
                                 {"mesh": "ball", "kind": "primary", "threads": 1, "ratio": 0}])
def test_damaged_rows_are_refused(tmp_path, row):
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"benchmark": "rays", "version": 1, "rows": [row]}))
    with pytest.raises(GlimtError, match=r"result\.json"):
        results.read(path)


def test_a_table_is_written_between_its_marks_again_and_again(tmp_path):
    path = tmp_path / "notes.md"
    path.write_text("before\n<!-- frames -->\nold\n<!-- /frames -->\nafter\n", encoding="utf-8")
    for text in ("| × |", "| new |"):
        tables.write_into(path, "frames", text)
        assert path.read_text(encoding="utf-8") == f"before\n<!-- frames -->\n\n{text}\n\n<!-- /frames -->\nafter\n"


@pytest.mark.parametrize("content", ["nothing", "<!-- frames -->", "<!-- /frames --> <!-- frames -->"])
def test_a_document_without_a_place_is_left_alone(tmp_path, content):
    path = tmp_path / "notes.md"
    path.write_text(content)
    with pytest.raises(GlimtError, match=r"notes\.md: has no lines"):
        tables.write_into(path, "frames", "text")
    assert path.read_text() == content
    with pytest.raises(GlimtError, match=r"other\.md"):
        tables.write_into(tmp_path / "other.md", "frames", "text")

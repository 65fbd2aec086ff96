"""A study figure by figure: kept as it goes, gone on with, and refused when it is another one."""

import json
from pathlib import Path

import pytest

from glimt.errors import GlimtError
from glimt.study import run as study_run
from glimt.study.experiments import Setting
from glimt.study.results import FILE_NAME, read
from glimt.study.run import Order, run

SCENE = """
[render]
background = 0.3
[[sphere]]
center = [0, 0, 0]
radius = 1
[[light]]
type = "point"
position = [3, 3, 3]
radius = 4
"""


@pytest.fixture
def order(tmp_path):
    scene = tmp_path / "ball.toml"
    scene.write_text(SCENE)
    return Order(scene, tmp_path / "out", [3, 7], engine="cpu", threads=1, quick=True, seconds=0.05)


@pytest.fixture
def frames(monkeypatch):
    """Return the labels of the settings that are rendered, as they come."""
    made = []

    class Logged(study_run.Frames):
        def __init__(self, setting: Setting, engine, threads):
            super().__init__(setting, engine, threads)
            made.append(setting.label)

    monkeypatch.setattr(study_run, "Frames", Logged)
    return made


def interrupt_in(monkeypatch, number, rounds):
    """Have Ctrl-C come in one figure after so many rounds."""
    usual, calls = study_run.measure_frames, []

    def measure(runs, seconds, progress):
        calls.append(1)
        if len(calls) == number:
            count = [0]

            def once(run=runs[-1]):
                count[0] += 1
                if count[0] > 4 * rounds:
                    raise KeyboardInterrupt
                return 0.001

            once.film, once.stages = runs[-1].film, [{}]
            return usual([*runs[:-1], once], 1.0, progress)
        return usual(runs, seconds, progress)

    monkeypatch.setattr(study_run, "measure_frames", measure)


def test_a_study_from_scene_to_file(order):
    told = []
    result, complete = run(order, lambda *what: told.append(what))
    assert complete
    assert [figure.number for figure in result.figures] == [3, 7]
    assert read(order.folder / FILE_NAME) == result
    assert result.scene.spheres == 1
    assert result.base == "400×400 pixels, one sample each, no bounces, lights: 1 point, 0 vertices, 1 sphere"
    pixels = result.figures[0].series[0]
    assert [point.rays.primary for point in pixels.points] == [point.x for point in pixels.points]
    assert pixels.verdict
    texts, shares, left = zip(*told, strict=True)
    assert texts[0] == "figure 3: pixels"
    assert texts[-1] == "figure 7: threads"
    assert list(shares) == sorted(shares)
    assert shares[-1] == 1
    assert left[-1] == 0


def test_what_is_there_is_not_lost(order):
    run(order._replace(figures=[7]))
    with pytest.raises(GlimtError, match="is there already; give --resume to go on with it, --overwrite"):
        run(order)
    assert [figure.number for figure in read(order.folder / FILE_NAME).figures] == [7]
    run(order._replace(figures=[3], overwrite=True))
    assert [figure.number for figure in read(order.folder / FILE_NAME).figures] == [3]


def test_going_on_measures_only_what_is_missing(order, frames):
    first, _ = run(order._replace(figures=[7]))
    frames.clear()
    result, complete = run(order._replace(resume=True))
    assert complete
    assert [figure.number for figure in result.figures] == [3, 7]
    assert result.figures[1] == first.figures[0]
    assert frames == ["100×100", "200×200", "400×400", "566×566", "800×800"]


def test_going_on_with_nothing_begins(order):
    assert run(order._replace(figures=[7], resume=True))[1]


def test_ctrl_c_keeps_finished_figures_and_whole_rounds(order, monkeypatch):
    interrupt_in(monkeypatch, 2, 3)
    result, complete = run(order)
    assert not complete
    assert [(figure.number, figure.complete) for figure in result.figures] == [(3, True), (7, False)]
    assert result.figures[1].rounds == 3
    assert read(order.folder / FILE_NAME) == result
    again, complete = run(order._replace(resume=True))
    assert complete
    assert again.figures[0] == result.figures[0]
    assert again.figures[1].complete
    assert again.figures[1].rounds >= 5


def test_ctrl_c_before_a_figure_has_anything(order, monkeypatch):
    interrupt_in(monkeypatch, 1, 1)
    result, complete = run(order)
    assert (result.figures, complete) == ([], False)


@pytest.mark.parametrize(("change", "message"), [
    ({"quick": False}, "was measured with quick True, not False"),
    ({"brute_force": True}, "was measured with brute force False, not True"),
    ({"threads": 2}, "was measured with other threads"),
])
def test_another_study_is_not_gone_on_with(order, change, message):
    run(order._replace(figures=[7]))
    with pytest.raises(GlimtError, match=message):
        run(order._replace(resume=True, **change))


def test_a_changed_scene_is_another_study(order):
    run(order._replace(figures=[7]))
    Path(order.scene).write_text(SCENE.replace("radius = 1", "radius = 2"))
    with pytest.raises(GlimtError, match="another scene, or its files have changed"):
        run(order._replace(resume=True))


def test_a_damaged_file_says_so(order):
    order.folder.mkdir()
    (order.folder / FILE_NAME).write_text(json.dumps({"study": 1}))
    with pytest.raises(GlimtError, match="is no result of `glimt study`"):
        run(order._replace(resume=True))


def test_figures_that_a_scene_cannot_have_say_why(order):
    result, complete = run(order._replace(figures=[6, 8]))
    assert complete
    assert [figure.notes for figure in result.figures] == [["the scene has no meshes"]] * 2
    assert [figure.series for figure in result.figures] == [[], []]


def test_settings_beyond_a_limit_are_left_out_with_the_reason(order, monkeypatch):
    class Limited(study_run.Frames):
        def __init__(self, setting, engine, threads):
            if setting.x > 100_000:
                raise GlimtError("too large for this machine")
            super().__init__(setting, engine, threads)

    monkeypatch.setattr(study_run, "Frames", Limited)
    figure = run(order._replace(figures=[3]))[0].figures[0]
    assert [point.label for point in figure.series[0].points] == ["100×100", "200×200"]
    assert figure.notes == [f"pixels, {side}×{side}: too large for this machine" for side in (400, 566, 800)]


def test_a_figure_of_the_other_engine_says_so():
    figure = study_run._measure(7, study_run.Study(None, "gpu"), None, 1.0, lambda share: None)
    assert figure.notes == ["the GPU engine has nothing to vary here"]

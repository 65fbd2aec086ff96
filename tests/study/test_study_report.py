"""Reports: everything in one file, nothing from the scene taken for markup, and two studies side by side."""

import base64
import io
import re

import numpy as np
import pytest
from made_results import figure, study, whole_study
from PIL import Image

from glimt.study import output, plots
from glimt.study.experiments import FIGURES
from glimt.study.report import comparison, report


@pytest.fixture(scope="module")
def page():
    return report(whole_study())


def test_all_figures_with_plots_verdicts_and_numbers(page):
    result = whole_study()
    for number, kind in FIGURES.items():
        assert f"Figure {number}. {kind.title}" in page
    assert page.count("<img ") == len(FIGURES)
    from html import escape
    assert all(escape(series.verdict) in page for each in result.figures for series in each.series)
    assert page.count("<details>") == sum(len(each.series) for each in result.figures)
    assert "SHA-256 0000" in page


def test_the_page_needs_nothing_else(page):
    assert "<script" not in page
    assert not re.search(r"(src|href)='(?!data:|#)", page)
    assert "http" not in re.sub(r"data:[^']*'", "", page)


def test_plots_are_svg_images(page):
    data = re.findall(r"data:image/svg\+xml;base64,([^']+)'", page)
    assert all(base64.b64decode(each).startswith(b"<?xml") for each in data)
    assert b"<svg" in base64.b64decode(data[0])


def test_names_are_not_markup(page):
    assert "made &lt;scene&gt;" in page
    assert "<scene>" not in page


def test_the_same_result_gives_the_same_plots():
    assert plots.svg([("", whole_study().figures[1])]) == plots.svg([("", whole_study().figures[1])])


def test_png_images_of_all_figures(tmp_path):
    path = output.write_report(tmp_path / "out", whole_study())
    assert path == tmp_path / "out" / "report.html"
    images = sorted(file.name for file in path.parent.glob("*.png"))
    assert images == sorted(f"figure-{number}-{kind.name}.png" for number, kind in FIGURES.items())
    for name in images:
        with Image.open(path.parent / name) as image:
            assert image.size[0] == 1200
            assert len(np.unique(np.asarray(image.convert("L").resize((60, 40))))) > 5


def test_the_plot_shows_every_frame_and_every_series():
    def marks(*names, rounds=8):
        made = figure(3, {name: {10**k: 2.0 * 10**k for k in range(2, 6)} for name in names}, rounds=rounds)
        return plots.svg([("", made)]).count("<use ")

    few, more_frames, more_series = marks("a"), marks("a", rounds=16), marks("a", "b")
    assert more_frames - few == 4 * 8
    assert more_series - few >= 4 * 8 + 4


def test_left_out_and_interrupted_are_said():
    page = report(study(figure(3, {"a": {1: 1.0, 10: 2.0}}, complete=False, rounds=3, notes=["b: too large"])))
    assert "interrupted after 3 rounds" in page
    assert "b: too large" in page


def test_two_studies_side_by_side():
    page = comparison([("old", whole_study()), ("new", whole_study(0.5))])
    assert page.count("<img ") == len(FIGURES)
    assert "<h1>old and new</h1>" in page
    ratios = [float(text) for text in re.findall(r"<td>(\d\.\d\d)</td></tr>", page)]
    assert len(ratios) > 50
    assert all(0.49 <= ratio <= 0.51 for ratio in ratios)
    assert "different scenes" not in page


def test_comparing_what_is_not_alike():
    other = study(figure(3, {"pixels": {10_000: 1.0, 40_000: 2.0, 90_000: 3.0}}))
    other.scene.sha256 = "1" * 64
    page = comparison([("a", whole_study()), ("b", other)])
    assert "The two studies are about different scenes." in page
    assert "Figure 5 is only in a." in page
    page = comparison([("b", other), ("a", whole_study())])
    assert "Figure 5 is only in a." in page


@pytest.mark.parametrize(("before", "after", "names"), [
    ("old.json", "new.json", ("old", "new")),
    ("a/results.json", "b/results.json", ("a", "b")),
    ("x/a/results.json", "y/a/results.json", ("x/a/results.json", "y/a/results.json")),
])
def test_names_that_tell_results_apart(before, after, names):
    from pathlib import Path
    assert output.names_of(Path(before), Path(after)) == names


def test_an_image_is_a_png():
    with Image.open(io.BytesIO(plots.png([("", whole_study().figures[0])]))) as image:
        assert image.format == "PNG"

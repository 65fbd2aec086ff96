"""Sentences that follow from the numbers."""

import pytest
from made_results import figure

from glimt.study.verdicts import tell

PIXELS = [10**4 * 2**k for k in range(8)]
LADDER = [990 * 4**k for k in range(7)]


def said(*arguments, series=0, **options):
    return figure(*arguments, **options).series[series].verdict


def test_pixels_as_the_paper_found():
    text = said(3, {"pixels": {x: 1e-4 * x for x in PIXELS}}, rays={x: 2 * x for x in PIXELS})
    assert text.startswith("Frame time grows as pixels^1.00 (1.00–1.00): linear, ")
    assert " and 99.9 (99.8–100.0) ms for each 1,000,000 pixels (R² 1.000), as the paper found." in text
    assert "Against counted rays it is a line (R² 1.000): the rays explain it; Mrays/s: 20" in text


def test_pixels_that_grow_otherwise():
    text = said(3, {"pixels": {x: 1e-2 * x**0.6 for x in PIXELS}}, rays={x: 2 * x for x in PIXELS})
    assert "pixels^0.60 (0.60–0.60): more slowly than linear" in text
    assert "the paper's linear law does not hold here" in text
    assert "as the paper found" not in text


def test_vertices_with_trees_and_without():
    text = said(6, {"the same surfaces cut finer": {x: 7 * (x / 990) ** 0.12 for x in LADDER}})
    assert "as vertices^0.12 (0.12–0.12)" in text
    assert "the paper's linear law does not hold, the tree removes it" in text
    assert "The rays of a frame hardly change" in text
    text = said(6, {"cut finer, brute force": {x: 0.05 * x for x in LADDER}})
    assert "vertices^1.00 (1.00–1.00): linear, " in text
    assert " and 49983.2 (" in text
    assert "as the paper found, which tests everything as well" in text


@pytest.mark.parametrize("name", ["objects added, the outermost last", "objects added, brute force"])
def test_the_jump_when_the_outer_box_comes_into_view(name):
    times = {x: 1 + x / 900 + 4 * (x > 900) for x in (90, 180, 270, 360, 450, 540, 630, 720, 810, 900, 930, 960, 990)}
    text = said(6, {name: times}, rays={x: 160_000 * (1 + 2 * (x > 900)) for x in times})
    assert text.startswith("Frame time jumps by 4.0")
    assert "at 930 vertices" in text
    assert "as the paper found" in text


def test_mirrors_that_few_rays_meet():
    text = said(4, {"the scene's own mirrors": dict(enumerate([5, 8, 8.1, 8.1, 8.1, 8.1, 8.1, 8.1]))})
    assert "Frame time goes from 5.0" in text
    assert "nearly all of it with the first of the bounces" in text
    assert "few rays meet one mirror after the other" in text


def test_lights_by_their_slope():
    text = said(5, {"point lights": {x: 4 + 1.25 * x for x in range(0, 17, 2)}},
                rays={x: 10_000 * (1 + x) for x in range(0, 17, 2)})
    assert text.startswith("Frame time grows with lights: linear, 4.00 (3.99–4.01) ms and 1.25 (1.25–")
    assert "ms for each light (R² 1.000), as the paper found." in text


def test_a_time_that_stays():
    assert said(8, {"instances": {10**k: 5.0 for k in range(5)}}).startswith(
        "Frame time does not depend on instances: 5.00")


def test_groups_are_told_apart_only_when_they_differ():
    found = figure(2, {"tiles": {64: 5.0, 256: 5.01, 1024: 5.02}, "packets": {1: 8.0, 2: 5.05, 4: 5.0}})
    assert found.series[0].verdict.startswith("No difference is seen beyond the noise: all are within 0.")
    assert found.series[1].verdict.startswith("It matters: best is 4 (2 as good); 1 takes 1.6")
    assert figure(2, {"tiles": {64: 5.0, 256: 5.4}}).series[0].verdict.startswith("It matters little: all are within ")
    noisy = figure(2, {"tiles": {64: 5.0, 256: 5.6}}, noise=0.5)
    assert "No difference is seen" in noisy.series[0].verdict


def test_threads_by_what_they_gain():
    text = said(7, {"threads": {1: 10.0, 2: 5.2, 4: 5.3}})
    assert text.startswith("As compared to one: 2 threads 1.9")
    assert "At 2, each thread does 96% of what one does alone." in text


def test_adaptive_samples_against_the_full_grid():
    curves = {"n×n samples": {1: 5.0, 4: 20.0, 9: 45.0, 16: 80.0}, "adaptive": {4.3: 40.0}}
    made = figure(9, curves, rays={1: 10, 4: 40, 9: 90, 16: 160, 4.3: 43})
    made.series[0].points[3].label = "4×4"
    tell(made)
    assert made.series[1].verdict == ("Adaptive sampling traces 27% of the rays of 4×4 samples, 4.3 samples a pixel, "
                                      "in 50% of the time.")


def test_stages_by_the_largest():
    text = said(10, {"stages": {0: 5.0, 1: 9.0}}, stages=(0.1, 0.2, 0.5, 0.1, 0.1))
    assert text == "Most time goes to: 0: shade 50%; 1: shade 50%."
    assert "not timed" in said(10, {"stages": {0: 5.0, 1: 9.0}})


def test_rays_that_do_not_explain_it():
    rays = {x: 160_000 + 30_000 * (k % 2) for k, x in enumerate(LADDER)}
    text = said(6, {"cut finer": {x: 7 * (x / 990) ** 0.3 for x in LADDER}}, rays=rays)
    assert "Counted rays alone do not explain it" in text


def test_a_line_with_a_start_is_one_though_its_exponent_is_less():
    """A frame of a few pixels still wakes up threads."""
    text = said(3, {"pixels": {x: 1 + 2e-5 * x for x in PIXELS}}, rays={x: 3 * x for x in PIXELS})
    assert "linear, 1.00 (1.00–1.00) ms and 20.0" in text
    assert "as the paper found" in text


def test_mirrors_everywhere_that_cost_more_and_more():
    text = said(4, {"every surface a mirror": {x: 4 + 10 * x + 0.4 * x * x for x in range(11)}})
    assert text.startswith("Frame time grows with bounces: linear, ")
    assert "as the paper found" in text

"""Results of studies that nobody measured: planted times with little noise."""

import numpy as np

from glimt.engines import EngineOptions
from glimt.film import Counters
from glimt.layout import STAGES
from glimt.scene.scene import Scene
from glimt.study.experiments import FIGURES, Setting
from glimt.study.figures import make_figure
from glimt.study.measuring import Measurement
from glimt.study.results import Machine, SceneFacts, StudyResult


def figure(number, curves, *, rays=None, stages=None, noise=0.002, rounds=8, complete=True, notes=()):
    """Return a figure of curves {name: {x: milliseconds}}; rays: {x: number of a frame's camera rays}."""
    random = np.random.default_rng(5)
    settings = {name: [Setting(float(x), f"{x:,}", Scene(), EngineOptions(brute_force="brute force" in name))
                       for x in points] for name, points in curves.items()}
    ms = np.array([value for points in curves.values() for value in points.values()])
    times = 1e-3 * ms * np.exp(random.normal(0, noise, (rounds, len(ms))))
    counters = [Counters((rays or {}).get(x, 160_000)) for points in curves.values() for x in points]
    shares = [dict(zip(STAGES, stages, strict=True)) if stages else {} for _ in ms]
    measured = Measurement([[[value] for value in row] for row in times.tolist()], counters, shares, complete)
    return make_figure(number, settings, measured, list(notes))


def study(*figures, **changes):
    """Return the result of a study with such figures."""
    facts = {
        "study": 1, "command": "glimt study", "created": "2026-01-02T03:04:05+00:00", "engine": "cpu", "quick": False,
        "brute_force": False, "confidence": 0.95, "base": "400×400 pixels",
        "scene": SceneFacts(name="made <scene>", sha256="0" * 64, triangles=330, spheres=4, lights=2),
        "machine": Machine(processor="made", features=["avx2"], lanes=8, cores=2, threads=2, clock_mhz=2000.0,
                           adapter=None, system="none", versions={"glimt": "0"})}
    return StudyResult(**{**facts, **changes}, figures=list(figures))


def whole_study(factor=1.0, **changes):
    """Return a study with all figures; times are `factor` as long as those of another."""
    lines = {4: 3.0, 5: 1.5, 7: 1.0, 9: 5.0}
    made = [figure(number, {"a": {x: factor * (4 + slope * x) for x in range(0 if number < 6 else 1, 11)}})
            for number, slope in lines.items()]
    made.append(figure(3, {"pixels": {10**4 * 2**k: factor * 2.0**k for k in range(8)}}))
    made.append(figure(6, {"objects added": {90 * k: factor * (1 + k / 9 + 5 * (k > 8)) for k in range(1, 12)},
                           "cut finer": {990 * 4**k: factor * 7 * 4 ** (0.12 * k) for k in range(7)}}))
    made.append(figure(8, {"instances": {10**k: factor * (3.0 + 4 * k) for k in range(5)}}))
    made.append(figure(2, {"tiles": {64: factor * 5.0, 256: factor * 5.0}, "packets": {1: factor * 8, 4: factor * 5}}))
    made.append(figure(10, {"stages": {0: factor * 5.0, 1: factor * 9.0}}, stages=(0.1, 0.2, 0.5, 0.1, 0.1)))
    assert {each.number for each in made} == set(FIGURES)
    return study(*sorted(made, key=lambda each: each.number), **changes)

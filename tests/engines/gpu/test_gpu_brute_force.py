"""Without trees the GPU finds the same: every ray tests everything."""

from dataclasses import replace

import numpy as np
import pytest
from both_engines import on_gpu

import closed_meshes
import glimt
from glimt import linalg
from glimt.engines import EngineOptions
from glimt.engines.gpu.engine import GpuEngine

pytestmark = pytest.mark.usefixtures("software_gpu")
FORCE = EngineOptions(brute_force=True)


@pytest.fixture(scope="module")
def scene():
    """Return two meshes, one of them placed twice, spheres, a mirror and two lights."""
    gold = glimt.Material(diffuse=(0.6, 0.4, 0.1), specular=0.5, reflectivity=0.4)
    ball = closed_meshes.icosphere(2)
    scene = glimt.Scene(settings=glimt.RenderSettings(61, 45, 1, 2, background=0.2, ambient=0.1))
    scene.add(glimt.Mesh([[-3, -1, -3], [3, -1, -3], [3, -1, 3], [-3, -1, 3]], [[0, 2, 1], [0, 3, 2]]))
    for x in (-1.2, 0.9):
        place = linalg.compose(linalg.translation((x, -0.2, x / 3)), linalg.rotation((1, 2, 3), 40 * x),
                               linalg.scaling((0.8, 0.5, 0.7)))
        scene.add(glimt.Instance(ball, place, gold))
    scene.add(glimt.Sphere((0, 0.5, -1), 0.6, gold))
    scene.add(glimt.PointLight(position=(1, 4, 2), radius=6), glimt.DirectionalLight(direction=(1, -2, -0.5)))
    scene.camera = glimt.Camera((0.5, 1, 4), (0, 0, 0), fov_deg=50)
    return scene


def test_the_same_film_to_the_bit(scene):
    usual, forced = on_gpu(scene).render(), on_gpu(scene, options=FORCE).render()
    np.testing.assert_array_equal(forced.sums, usual.sums)
    assert forced.counters == usual.counters
    assert forced.counters.mirror > 0


def test_every_leaf_is_visited_by_every_ray(scene):
    """Camera rays of the closest hit stop nowhere: 80 leaves and more for each ray, where trees need a few."""
    still = replace(scene, settings=replace(scene.settings, max_bounces=0))
    engine = GpuEngine(counting=True)
    renderer = on_gpu(still, engine, options=FORCE)
    renderer.render()
    packed = renderer._packed
    blocks = packed.spans.view(np.int32).reshape(-1, 2)[:, 1].sum()
    assert engine.visits["nodes"].sum() == 0
    assert engine.visits["blocks"][0] == 61 * 45 * blocks
    on_gpu(still, engine).render()
    assert engine.visits["blocks"][0] < 61 * 45 * blocks / 20


def test_trees_come_back(scene):
    """One engine may be given scenes with and without."""
    engine = GpuEngine()
    forced = on_gpu(scene, engine, options=FORCE).render().sums.copy()
    np.testing.assert_array_equal(on_gpu(scene, engine).render().sums, forced)

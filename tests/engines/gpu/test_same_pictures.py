"""Both engines make the same pictures and debug views of the examples and of real scenes, and find the same hits."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from both_engines import FEW, assert_same_counts, assert_same_picture, on_cpu, on_gpu, sized

import glimt
from glimt.layout import MISS

EXAMPLES = sorted((Path(__file__).resolve().parents[3] / "examples").glob("*.toml"))
REAL = Path(__file__).resolve().parents[4] / "shared" / "scenes"
SCENES = [*EXAMPLES, *sorted(REAL.rglob("*.obj"))]
MODES = list(itertools.product((1, 2, 3), range(5)))
"""Samples along a pixel's side, and bounces."""
SHOWN_IN_ALL_MODES = {"mirrors", "stone_room", "box-complex-material"}
CLOSE = 1e-5
"""Of distances, relative: what float32 operations in another order round off."""

pytestmark = [pytest.mark.usefixtures("software_gpu"),
              pytest.mark.filterwarnings("ignore::glimt.GlimtWarning")]  # test_obj_real says which are expected


def _modes(number, path):
    """Return two modes for a scene, others for the next one; all for a few."""
    if path.stem in SHOWN_IN_ALL_MODES:
        return MODES
    return [MODES[2 * number % len(MODES)], MODES[(2 * number + 8) % len(MODES)]]


@pytest.mark.parametrize(("path", "modes"), [(path, _modes(k, path)) for k, path in enumerate(SCENES)],
                         ids=[path.stem for path in SCENES])
def test_pictures_and_rays(path, modes):
    scene = sized(glimt.load(path))
    cpu, gpu = on_cpu(scene), on_gpu(scene)
    for samples, max_bounces in modes:
        cpu.scene = gpu.scene = sized(scene, samples=samples, max_bounces=max_bounces)
        wanted, got = cpu.render(), gpu.render()
        assert_same_picture(got.image(), wanted.image())
        assert_same_counts(got.counters, wanted.counters)
        assert (got.sums[..., 3] == samples**2).all()


@pytest.mark.parametrize("path", SCENES, ids=[path.stem for path in SCENES])
def test_debug_views(path):
    scene = sized(glimt.load(path))
    cpu, gpu = on_cpu(scene), on_gpu(scene)

    def both(view):
        return gpu.render_debug(view).values, cpu.render_debug(view).values

    (ids, wanted_ids), (depth, wanted_depth) = both("instances"), both("depth")
    same = (ids.view(np.int32) == wanted_ids.view(np.int32)).all(-1)
    assert (~same).mean() <= FEW
    off = np.abs(depth - wanted_depth)[same].max(-1) / wanted_depth[same, 0].clip(1e-30)
    assert (off > CLOSE).mean() <= FEW
    assert off.max() < 10 * CLOSE  # seen at a grazing angle
    tied = ~same & (ids[..., 3] == wanted_ids[..., 3])
    np.testing.assert_allclose(depth[tied], wanted_depth[tied], rtol=CLOSE)
    for view in ("normals", "barycentrics", "shadows"):
        got, wanted = both(view)
        off = np.abs(got - wanted)[same].max(-1)
        assert (off > 1e-3).mean() <= FEW, view
        if view != "shadows":  # the narrowest triangles are a few roundings wide
            assert off.max() < 0.02, view
    nodes, wanted = both("nodes")
    if len(scene.objects) == 1:  # rays of the GPU enter it at once: no node of the scene's tree is visited
        wanted = np.stack([wanted[..., 0] - wanted[..., 2], wanted[..., 1], np.ones_like(wanted[..., 2])], 2)
    np.testing.assert_array_equal(nodes[..., 3], ids[..., 3])
    shares = nodes[..., :3].sum((0, 1)) / wanted[..., :3].sum((0, 1)).clip(1)
    assert ((shares > 0.8) & (shares < (1.2, 1.4, 1.2))).all(), shares  # children come in a coarser order there


def _rays(scene, random, count):
    """Return (7, n) rays between points around the objects, of other lengths than 1, some of which end early."""
    lo, hi = scene.bounds()
    size = np.max(hi - lo)
    origins, ends = random.uniform(lo - size / 2, hi + size / 2, (count, 3)), random.uniform(lo, hi, (count, 3))
    t_max = np.where(np.arange(count) % 5, np.inf, random.uniform(0, 1, count))
    return np.concatenate([origins, (ends - origins) * random.uniform(0.5, 2, (count, 1)), t_max[:, None]],
                          1).T.astype(np.float32)


@pytest.mark.parametrize("path", SCENES, ids=[path.stem for path in SCENES])
def test_hits_and_picks(path):
    scene = sized(glimt.load(path))
    cpu, gpu = on_cpu(scene), on_gpu(scene)
    for x, y in ((48, 36), (30.5, 50.25), (70, 20), (5, 5), (12, 60.5)):
        wanted, got = cpu.pick(x, y), gpu.pick(x, y)
        assert (got is None) == (wanted is None)
        if wanted is not None:
            assert got.object is wanted.object
            assert got.distance == pytest.approx(wanted.distance, rel=CLOSE)
            assert (got.object_index, got.triangle, got.material) == \
                (wanted.object_index, wanted.triangle, wanted.material)
    rays = _rays(scene, np.random.default_rng(1), 2000)
    got, wanted = gpu._engine.find_hits(rays), cpu._engine.find_hits(rays)
    met, wanted_met = got.inst != MISS, wanted.inst != MISS
    assert (met != wanted_met).mean() <= FEW
    both = met & wanted_met
    assert both.sum() > 20
    assert np.isinf(got.t[~met]).all()
    np.testing.assert_allclose(got.t[both], wanted.t[both], rtol=CLOSE, atol=1e-7)  # rounding of origins adds to it
    same = both & (got.inst == wanted.inst) & (got.prim == wanted.prim)
    assert (both & ~same).mean() < 0.02  # triangles in one plane are as near as each other, but for rounding
    for name in ("u", "v"):
        off = np.abs(getattr(got, name) - getattr(wanted, name))[same]
        assert (off > 1e-3).mean() <= FEW

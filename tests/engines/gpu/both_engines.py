"""One scene on both engines, and what counts as the same."""

import functools
import os
from dataclasses import replace
from unittest import mock

import numpy as np

import glimt.renderer
from glimt.engines.gpu.engine import GpuEngine
from glimt.renderer import Renderer

STEP = 3 / 255
"""Pixels that differ by no more are the same: a developed colour is a code of 255."""
FEW = 1e-3
"""The share of pixels, or of rays, that may go another way: those that just miss an edge by rounding."""


@functools.cache
def shared_engine():
    """Return an engine that scenes may be given one after another; its kernels are compiled once."""
    with mock.patch.dict(os.environ, GLIMT_GPU="software"):
        return GpuEngine()


def on_gpu(scene, engine=None, **options):
    """Return a Renderer with an engine that is there already."""
    with mock.patch.object(glimt.renderer, "get_engine", return_value=engine or shared_engine()):
        return Renderer(scene, engine="gpu", **options)


def on_cpu(scene):
    """Return a Renderer of the other engine."""
    return Renderer(scene, engine="cpu")


def sized(scene, width=96, height=72, samples=1, max_bounces=0):
    """Return the scene with small pictures of so many samples and bounces."""
    return replace(scene, settings=replace(scene.settings, width=width, height=height, samples=samples,
                                           max_bounces=max_bounces))


def assert_same_picture(got, wanted):
    """Compare two images (h, w, 3) uint8: few pixels differ, and those on an edge of the second, which hides it."""
    differs = _apart(got, wanted)
    assert differs.mean() <= FEW
    assert not (differs & ~_edges(wanted)).any()


def assert_same_counts(got, wanted):
    """Compare the counters of two films."""
    for name, one, other in zip(got._fields, got, wanted, strict=True):
        assert abs(one - other) <= FEW * other + 2, name


def _apart(a, b):
    """Return which pixels differ by more than STEP."""
    return np.abs(a.astype(np.int32) - b).max(-1) > 255 * STEP


def _edges(image):
    """Return which pixels differ from one beside or across from them."""
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)), "edge")
    height, width = image.shape[:2]
    return np.any([_apart(image, padded[y:y + height, x:x + width]) for y in range(3) for x in range(3)], 0)

"""Rays through the CPU engine's traversal: packed as lanes, answered as arrays."""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from glimt.engines.cpu.kernels.query import NO_SOURCES, find_blocked, find_hits
from glimt.layout import MISS

HIT = np.dtype([("t", "f4"), ("u", "f4"), ("v", "f4"), ("prim", "i4"), ("inst", "i4")])
"""A ray's answer; inst and prim are MISS where it meets nothing (t is inf) or was not asked (t is -inf)."""

THREADS = os.cpu_count() or 1
_GRANULE = 16


def closest(packed, origins, directions, active=None):
    """Return the HIT of each ray as a record array.

    Parameters
    ----------
    packed : PackedScene
    origins : (n, 3) float32, or one (3,) for all, which then take the way of camera rays
    directions : (n, 3) float32
    active : (n,) bool, optional
        Rays to ask; the others are idle lanes among them.
    """
    rays, count = _rays(origins, directions, np.inf, active), len(directions)
    floats, ids = np.zeros((3, rays.shape[1]), np.float32), np.full((2, rays.shape[1]), MISS, np.int32)
    _over_threads(lambda chunk: find_hits(packed, rays, NO_SOURCES, np.ndim(origins) == 1, floats, ids, chunk))
    hits = np.recarray(count, HIT)
    ids[0] = packed.numbers_in_mesh(*ids)
    for name, values in zip(HIT.names, [*floats, *ids], strict=True):
        hits[name] = values[:count]
    return hits


def blocked(packed, origins, directions, t_max=np.inf, active=None):
    """Return which rays meet something before `t_max`, (n,) bool; other arguments as for `closest`."""
    rays, count = _rays(origins, directions, t_max, active), len(directions)
    answers = np.zeros(rays.shape[1], np.float32)
    _over_threads(lambda chunk: find_blocked(packed, rays, NO_SOURCES, np.ndim(origins) == 1, answers, chunk))
    return answers[:count] > 0


def _rays(origins, directions, t_max, active):
    """Return (7, n) rays, filled up with idle ones."""
    count = len(directions)
    rays = np.zeros((7, -(-count // _GRANULE) * _GRANULE), np.float32)
    if np.ndim(origins) == 1:
        rays[:3], rays[:3, 0] = np.nan, origins  # none but the first is read
    else:
        rays[:3, :count] = np.asarray(origins, np.float32).T
    rays[3:6, :count] = np.asarray(directions, np.float32).T
    rays[6, :count] = np.broadcast_to(np.asarray(t_max, np.float32), count)
    if active is not None:
        rays[6, :count][~np.asarray(active, bool)] = 0
    return rays


def _over_threads(run):
    chunk = np.zeros(1, np.int64)
    with ThreadPoolExecutor(THREADS) as pool:
        for job in [pool.submit(run, chunk) for _ in range(THREADS)]:
            job.result()

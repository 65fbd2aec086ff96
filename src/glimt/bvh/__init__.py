"""Boxes to nodes: binned-SAH trees, eight children wide. Nothing here knows what is in a box."""

from glimt.bvh.build import build
from glimt.bvh.refit import refit
from glimt.bvh.stats import TreeStats, tree_stats
from glimt.bvh.wide import WideTree

__all__ = ["TreeStats", "WideTree", "build", "refit", "tree_stats"]

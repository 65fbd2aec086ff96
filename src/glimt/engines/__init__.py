"""Engines turn a packed scene into a film."""

from glimt.engines.engine import Engine, Hits, Progress, begin_preparing, get_engine

__all__ = ["Engine", "Hits", "Progress", "begin_preparing", "get_engine"]

"""Engines turn a packed scene into a film."""

from glimt.engines.engine import Engine, Progress, get_engine

__all__ = ["Engine", "Progress", "get_engine"]

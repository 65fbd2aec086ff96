"""Engines turn a packed scene into a film."""

from glimt.engines.choice import Choice, choose_engine
from glimt.engines.engine import Engine, Hits, Progress, begin_preparing, get_engine

__all__ = ["Choice", "Engine", "Hits", "Progress", "begin_preparing", "choose_engine", "get_engine"]

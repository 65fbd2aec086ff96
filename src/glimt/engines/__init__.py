"""Engines turn a packed scene into a film."""

from glimt.engines.choice import Choice, choose_engine
from glimt.engines.engine import Engine, Hits, Progress, begin_preparing, get_engine
from glimt.engines.options import DEFAULT_OPTIONS, EngineOptions

__all__ = [
    "DEFAULT_OPTIONS", "Choice", "Engine", "EngineOptions", "Hits", "Progress", "begin_preparing", "choose_engine",
    "get_engine",
]

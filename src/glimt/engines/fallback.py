"""An engine that is replaced by another one when it fails, in the middle of whatever it was asked."""

import threading
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from glimt.debug_view import DebugView
from glimt.engines.engine import Engine, Hits, Progress, Samples
from glimt.errors import EngineError, GlimtWarning
from glimt.film import Film
from glimt.packed import PackedScene

_Answer = TypeVar("_Answer")


class FallbackEngine:
    """Does what one engine does, and what another does once the first has raised an `EngineError`.

    What the first one failed in is begun again by the other, which is at work from then on.

    Parameters
    ----------
    engine : Engine
    make_other : function
        Returns the engine that takes over.
    on_failure : function
        Is told what happened to the first one; once, after the other one has taken over.
    """

    def __init__(self, engine: Engine, make_other: Callable[[], Engine], on_failure: Callable[[str], None]) -> None:
        self._engine, self._tell = engine, on_failure
        self._make_other: Callable[[], Engine] | None = make_other  # None once it was called
        self._uploaded: tuple[PackedScene, int] | None = None
        self._replacing = threading.Lock()

    @property
    def threads(self) -> int:
        """How many threads the engine at work may use."""
        return self._engine.threads

    @property
    def description(self) -> str:
        """What computes now."""
        return self._engine.description

    @property
    def uses_clearances(self) -> bool:
        """See `Engine.uses_clearances`."""
        return self._engine.uses_clearances

    def prepare(self, progress: Progress | None = None) -> None:
        """See `Engine.prepare`."""
        self._ask(lambda engine: engine.prepare(progress))

    def is_ready(self, samples: Samples, shows: DebugView | None = None) -> bool:
        """See `Engine.is_ready`."""
        return self._ask(lambda engine: engine.is_ready(samples, shows))

    def keep_films(self) -> Any:
        """See `Engine.keep_films`; the engine that takes over has its own in memory."""
        return self._ask(lambda engine: engine.keep_films())

    def upload(self, scene: PackedScene, light_count: int) -> None:
        """See `Engine.upload`."""
        self._uploaded = scene, light_count
        self._ask(lambda engine: engine.upload(scene, light_count))

    def render(self, view: NDArray[np.float32], size: tuple[int, int], samples: Samples, max_bounces: int,
               progress: Progress | None = None, film: Film | None = None) -> Film:
        """See `Engine.render`."""
        return self._ask(lambda engine: engine.render(view, size, samples, max_bounces, progress, film))

    def render_debug(self, view: NDArray[np.float32], size: tuple[int, int], shows: DebugView,
                     light_tints: NDArray[np.float32]) -> NDArray[np.float32]:
        """See `Engine.render_debug`."""
        return self._ask(lambda engine: engine.render_debug(view, size, shows, light_tints))

    def find_hits(self, rays: NDArray[np.float32]) -> Hits:
        """See `Engine.find_hits`."""
        return self._ask(lambda engine: engine.find_hits(rays))

    def cancel(self) -> None:
        """See `Engine.cancel`."""
        self._engine.cancel()

    def _ask(self, question: Callable[[Engine], _Answer]) -> _Answer:
        """Return the answer of the engine at work, or of the one that takes over."""
        engine = self._engine
        try:
            return question(engine)
        except EngineError as error:
            with self._replacing:  # threads that fail at the same time get the same other engine
                if engine is self._engine:
                    self._replace(error)
        return question(self._engine)

    def _replace(self, error: EngineError) -> None:
        """Put the other engine to work, with the scene."""
        if self._make_other is None:
            raise error
        other = self._make_other()
        other.prepare()
        if self._uploaded is not None:
            other.upload(*self._uploaded)
        self._engine, self._make_other = other, None
        self._tell(error.what)


def warn(failure: str) -> None:
    """Warn that the CPU goes on."""
    warnings.warn(GlimtWarning(f"{failure}; the CPU engine goes on"), stacklevel=2)

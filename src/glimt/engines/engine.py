"""What every engine can do, and how one is made."""

import contextlib
import threading
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from glimt.debug_view import DebugView
from glimt.engines.choice import choose_engine
from glimt.engines.options import DEFAULT_OPTIONS, EngineOptions
from glimt.errors import EngineError, GlimtError
from glimt.film import Film
from glimt.packed import PackedScene

Progress = Callable[[str, float], None]
"""Is told what is being done, and how far it is, 0 to 1."""
Samples = int | Literal["adaptive"]


class Hits(NamedTuple):
    """What n rays meet first.

    t : (n,) float32
        In lengths of the ray's direction; inf where it meets nothing.
    u, v : (n,) float32
        Barycentrics: the shares of a triangle's second and third corner; 0 on a sphere.
    prim : (n,) int32
        Triangle of the mesh; 0 on a sphere.
    inst : (n,) int32
        INSTANCE record; MISS (-1) where it meets nothing.
    """

    t: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    prim: NDArray[np.int32]
    inst: NDArray[np.int32]


class Engine(Protocol):
    """Renders packed scenes."""

    @property
    def threads(self) -> int:
        """How many threads the host may use for it."""

    @property
    def description(self) -> str:
        """What computes, in a few words."""

    def prepare(self, progress: Progress | None = None) -> None:
        """Make everything ready that does not depend on a scene, kernels above all."""

    def is_ready(self, samples: Samples, shows: DebugView | None = None) -> bool:
        """Return whether such a picture, or debug view, is rendered at once: what is rarely wanted is prepared late."""

    @property
    def uses_clearances(self) -> bool:
        """Whether pictures become faster when clearances are found (see `layout.FACE`)."""

    def keep_films(self) -> Any:
        """Leave films where they are computed from now on: they are to be shown there, and come back when asked for.

        Returns
        -------
        The device of a GPU, whose films are then a `DistantFilm` each; None where films are in memory anyway.
        """

    def upload(self, scene: PackedScene, light_count: int) -> None:
        """Take over a scene, or the changed arrays of one."""

    def render(self, view: NDArray[np.float32], size: tuple[int, int], samples: Samples, max_bounces: int,
               progress: Progress | None = None, film: Film | None = None) -> Film:
        """Render the scene.

        Parameters
        ----------
        view : VIEW words
        size : (width, height) in pixels
        samples : int or "adaptive"
            n for n×n samples a pixel; or 1 to 16, as many as it needs.
        max_bounces : int
        progress : Progress, optional
        film : Film, optional
            One whose memory may be written over, if it has the right size: a new one costs page faults each frame.

        Raises
        ------
        RenderCancelled
            When another thread calls `cancel` meanwhile.
        """

    def render_debug(self, view: NDArray[np.float32], size: tuple[int, int], shows: DebugView,
                     light_tints: NDArray[np.float32]) -> NDArray[np.float32]:
        """Render numbers a pixel instead of radiance.

        Parameters
        ----------
        view : VIEW words
        size : (width, height) in pixels
        shows : DebugView
        light_tints : (lights, 3) float32
            What "shadows" adds up.

        Returns
        -------
        (height, width, 4) float32: `DebugFilm.values`, of "instances" the numbers of INSTANCE records.

        Raises
        ------
        RenderCancelled
            When another thread calls `cancel` meanwhile.
        """

    def find_hits(self, rays: NDArray[np.float32]) -> Hits:
        """Return what (7, n) rays meet first in the scene: origins, directions of any length, how far each looks."""

    def cancel(self) -> None:
        """Stop what is being rendered, if anything is, within a few packets' time; from any thread."""


def get_engine(name: str = "auto", threads: int | None = None, options: EngineOptions = DEFAULT_OPTIONS,
               on_failure: Callable[[str], None] | None = None) -> Engine:
    """Return an engine by name.

    Parameters
    ----------
    name : str
        "cpu", "gpu", or "auto" for the best there is (see `choose_engine`).
    threads : int, optional
    options : EngineOptions
    on_failure : function, optional
        Is told what happened when the CPU takes over from a GPU that fails. None: with "auto" a `GlimtWarning` tells
        it, and with "gpu" the CPU does not take over: there is an error.

    Raises
    ------
    GlimtError
        See `choose_engine`; where "gpu" is found but cannot be opened; for options that an engine has not.
    """
    from glimt.engines.cpu.engine import CpuEngine
    from glimt.engines.fallback import FallbackEngine, warn

    if choose_engine(name).engine == "cpu":
        return CpuEngine(threads, options)
    from glimt.engines.gpu.engine import GpuEngine

    if name == "gpu" and on_failure is None:
        return GpuEngine(threads, group=options.group)
    tell = on_failure or warn
    try:
        return FallbackEngine(GpuEngine(threads, group=options.group), lambda: CpuEngine(threads, options), tell)
    except EngineError as error:
        if name == "gpu":
            raise
        tell(error.what)
        return CpuEngine(threads, options)


def begin_preparing(name: str = "auto") -> None:
    """Start in the background what `get_engine` and `Engine.prepare` will wait for: before a scene is loaded."""
    from glimt.engines.cpu import warm_up

    if name != "cpu":
        threading.Thread(target=_look_for_gpu, name="glimt-look", daemon=True).start()
    warm_up.begin()  # for the GPU as well: trees are built on the CPU


def _look_for_gpu() -> None:
    with contextlib.suppress(GlimtError):  # `get_engine` raises it where it matters
        choose_engine("gpu")

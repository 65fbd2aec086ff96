"""How an engine goes about its work: what measurements vary."""

from typing import NamedTuple

from glimt.layout import TILE


class EngineOptions(NamedTuple):
    """The ways an engine can make the same picture.

    Parameters
    ----------
    tile : int
        CPU: pixels along a tile, the piece of a picture that a thread takes at once; a multiple of 8, up to 1024.
    packets : int, optional
        CPU: how many packets of rays travel together, 1, 2, 4 or more, up to 64 rays; None: 64 rays.
    group : (width, height)
        GPU: the shape of a workgroup.
    brute_force : bool
        Every ray tests every triangle and sphere, as if there were no trees. The time of a frame then grows with
        what there is, and not with what is seen.
    time_stages : bool
        CPU: measure `Film.stages`; a GPU that has timestamps always does.
    """

    tile: int = TILE
    packets: int | None = None
    group: tuple[int, int] = (8, 8)
    brute_force: bool = False
    time_stages: bool = False


DEFAULT_OPTIONS = EngineOptions()

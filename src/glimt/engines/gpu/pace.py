"""How much goes to the GPU at once: a driver takes one that is busy for seconds for one that hangs, and resets it."""

from typing import NamedTuple

LONGEST_SECONDS = 0.5
"""A submission should take no longer. Windows resets a GPU after 2 s."""
_AIM_SECONDS = 0.1
"""What a submission is to take where there is more to do: so that parts of a picture may cost four times as much."""
_FIRST_RAYS = 1 << 16
"""Rays of the first submission for a scene that nothing is known of."""
_GROWTH = 4
_OVERHEAD_SECONDS = 0.002
"""What a submission takes however little it does."""


class Area(NamedTuple):
    """A part of a picture: its first pixel, and its size."""

    column: int
    row: int
    width: int
    height: int


class Pace:
    """Decides how many pixels, or rays, go to the GPU at once, by how long the last ones took.

    Begins with few, and grows by no more than a factor from one submission to the next. What never took long is not
    divided.

    Attributes
    ----------
    pixels : int
        The most that may be submitted next.
    """

    def __init__(self) -> None:
        self._rays_a_pixel = 1
        self.pixels = _FIRST_RAYS

    def restart(self) -> None:
        """Begin with few again: a scene came that nothing is known of."""
        self.pixels = min(self.pixels, _FIRST_RAYS // self._rays_a_pixel + 1)

    def expect(self, rays_a_pixel: int) -> None:
        """Be told how many rays a pixel may come to; more rays, fewer pixels, but not the other way round.

        Pixels cost less than that: many paths end early. So fewer rays need not be faster, and time will tell.
        """
        if rays_a_pixel > self._rays_a_pixel:
            self.pixels = max(1, self.pixels * self._rays_a_pixel // rays_a_pixel)
        self._rays_a_pixel = rays_a_pixel

    def learn(self, pixels: int, seconds: float) -> None:
        """Take note of how long a submission of so many pixels took."""
        fitting = int(pixels * _AIM_SECONDS / max(seconds - _OVERHEAD_SECONDS, 1e-6))
        self.pixels = max(1, min(fitting, max(self.pixels, _GROWTH * pixels)))


class Areas:
    """Hands out a picture in parts, from the top: bands of whole tiles, or pieces of the height of a tile.

    Parameters
    ----------
    size : (width, height) of the picture
    tile : (width, height)
        A smaller part is never handed out, but at the right and lower edge.
    """

    def __init__(self, size: tuple[int, int], tile: tuple[int, int]) -> None:
        self._left = [Area(0, 0, *size)]
        self._tile = tile
        self._pixels = size[0] * size[1]

    @property
    def done(self) -> float:
        """Which share of the picture was handed out, 0 to 1."""
        return 1 - sum(area.width * area.height for area in self._left) / self._pixels

    def take(self, most: int) -> Area | None:
        """Return the next part, of `most` pixels, whole tiles counted, if a tile has no more; None after the last."""
        if not self._left:
            return None
        column, row, width, height = self._left.pop()
        tile_width, tile_height = self._tile
        across, tiles = -(-width // tile_width), max(1, most // (tile_width * tile_height))
        rows = max(1, tiles // across) * tile_height
        if rows < height:
            self._left.append(Area(column, row + rows, width, height - rows))
            height = rows
        columns = max(1, tiles // -(-height // tile_height)) * tile_width
        if columns < width:
            self._left.append(Area(column + columns, row, width - columns, height))
            width = columns
        return Area(column, row, width, height)

    def put_back(self, area: Area) -> None:
        """Take back a part, to hand it out in smaller ones."""
        self._left.append(area)

"""Debug views: numbers a pixel that an engine gives instead of radiance, and the colours that show them."""

import functools
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from glimt.color import develop, srgb_to_linear
from glimt.errors import GlimtError

DebugView = Literal["normals", "depth", "barycentrics", "instances", "nodes", "shadows"]
DEBUG_VIEWS: tuple[DebugView, ...] = get_args(DebugView)

_SAMPLED = 1 << 16
"""About how many pixels a range is taken from."""
_FARTHEST = 0.1
"""Brightness of the far end of a depth view, above that of the background."""
_OBJECT_COLORS = 4096
_HEAT = ((0, 0, 0), (24, 18, 120), (104, 20, 168), (190, 40, 130), (235, 92, 50), (250, 175, 40), (255, 255, 255))
"""sRGB corners of the heat map: black, blue, violet, red, orange, yellow, white, each lighter than the one before."""


@dataclass
class DebugFilm:
    """A debug view: one ray through the centre of each pixel.

    Parameters
    ----------
    view : DebugView
    values : (h, w, 4) float32
        Row 0 on top. The fourth is 1 where the ray meets something; where it does not all are 0, but for "nodes".

        - "normals": x, y, z of the normal that the point is shaded with: in the world, with the normal map, on the
          viewer's side.
        - "depth": the distance from the camera in world units.
        - "barycentrics": the shares of the triangle's corners, ``1 - u - v``, u and v; a sphere is all first corner.
        - "instances": the place among the scene's objects, and the triangle of its mesh (0 for a sphere), as the bits
          of int32: ``values.view(np.int32)``.
        - "nodes": how many nodes of both trees, triangle blocks (leaves of up to four) and instances a closest-hit walk
          of this one ray visits, nearest children first. In a picture packets of rays share such visits.
        - "shadows": linear RGB, the sum of the tints of the lights that reach the point: that it faces, within whose
          cone it is, and that nothing stands before. All lights together are white.
    """

    view: DebugView
    values: NDArray[np.float32]

    def range(self) -> tuple[float, float]:
        """Return what the ends of the scale stand for: distances of "depth" (near, far), counts of "nodes".

        But for one pixel in a hundred of each end of depth, and the most expensive one in a thousand of nodes. (0, 1)
        for other views.
        """
        step = max(1, int((self.values.shape[0] * self.values.shape[1] / _SAMPLED) ** 0.5))
        values = self.values[::step, ::step].reshape(-1, 4)
        if self.view == "nodes":
            return 0.0, max(1.0, float(np.quantile(values[:, 0], 0.999, method="higher")))
        if self.view == "depth" and values[:, 3].any():
            near, far = np.quantile(values[values[:, 3] > 0, 0], (0.01, 0.99)).tolist()
            return near, far
        return 0.0, 1.0

    def image(self, scale: tuple[float, float] | None = None) -> NDArray[np.uint8]:
        """Return the view as colours, (h, w, 3) uint8 sRGB, black where the rays meet nothing.

        - "normals": ``n / 2 + 1 / 2``.
        - "depth": bright is near.
        - "barycentrics": red, green and blue for the three corners.
        - "instances": a colour for each object, the same in every picture.
        - "nodes": a heat map from black over blue, red and yellow to white, also where nothing is met.
        - "shadows": for one light white and black; else a hue for each light, which add up to white.

        Parameters
        ----------
        scale : (float, float), optional
            What to take for the ends of the scale instead of `range()`, so that pictures can be compared.
        """
        numbers, met = self.values[..., :3], self.values[..., 3:]
        if self.view == "shadows":
            return develop(self.values)
        if self.view == "instances":
            objects = self.values.view(np.int32)[..., 0] % np.int32(_OBJECT_COLORS)
            return np.take(_object_colors(), np.where(met[..., 0] > 0, objects, _OBJECT_COLORS), 0)
        if self.view == "nodes":
            return np.take(_heat_colors(), _bytes(_along(numbers[..., 0], scale or self.range())), 0)
        if self.view == "depth":
            nearness = 1 - _along(numbers[..., :1], scale or self.range())
            return np.repeat(_bytes((np.float32(_FARTHEST) + np.float32(1 - _FARTHEST) * nearness) * met), 3, 2)
        if self.view == "normals":
            return _bytes(numbers * np.float32(0.5) + np.float32(0.5) * met)
        return _bytes(numbers)


def light_tints(count: int, light: int | None = None) -> NDArray[np.float32]:
    """Return the linear colours of `count` lights in a "shadows" view, (count, 3) float32.

    Hues around the circle that add up to white, or white for one light and black for the others.
    """
    if light is not None:
        if not (isinstance(light, int | np.integer) and 0 <= light < count):
            raise GlimtError(f"there is no light {light!r}; the scene has {count}, counted from 0")
        tints = np.zeros((count, 3))
        tints[light] = 1
    else:
        tints = _hues(np.arange(count) / max(count, 1))
        tints /= np.maximum(tints.sum(0), 1e-6)
        if count == 1:
            tints[:] = 1
    return tints.astype(np.float32)


def _along(values: NDArray[np.float32], scale: tuple[float, float]) -> NDArray[np.float32]:
    """Return where values are on a scale, 0 to 1; 0 for all if it has no length."""
    lo, hi = scale
    share: NDArray[np.float32] = (values - np.float32(lo)) * np.float32(1 / (hi - lo) if hi > lo else 0)
    return np.clip(share, 0, 1)


def _hues(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (n, 3) saturated colours by their angle on the colour circle: red, green and blue at thirds of a turn."""
    away: NDArray[np.float64] = np.abs((turns[:, None] - np.array([0, 1, 2]) / 3 + 0.5) % 1 - 0.5) * 6
    return np.clip(2 - away, 0, 1)


@functools.cache
def _object_colors() -> NDArray[np.uint8]:
    """Return the colours of objects, which then repeat, and black, (n + 1, 3) uint8.

    Hues are a golden ratio of a turn apart, which keeps the first n of them apart for any n; at four lightnesses.
    """
    numbers = np.arange(_OBJECT_COLORS)
    hues, light = _hues(numbers * (5**0.5 - 1) / 2 % 1), np.array([1.0, 0.6, 0.8, 0.45])[numbers % 4, None]
    colors: NDArray[np.float64] = (0.25 + 0.75 * hues) * light
    return _bytes(np.concatenate([colors, np.zeros((1, 3))]))


@functools.cache
def _heat_colors() -> NDArray[np.uint8]:
    """Return the heat map, (256, 3) uint8: its lightness (CIE L*) grows evenly."""
    corners = np.array(_HEAT, np.float64) / 255
    luminance = srgb_to_linear(corners) @ (0.2126, 0.7152, 0.0722)
    lightness = np.where(luminance > 216 / 24389, 1.16 * np.cbrt(luminance) - 0.16, luminance * 24389 / 2700)
    shares = np.linspace(0, 1, 256)
    return _bytes(np.stack([np.interp(shares, lightness, corner) for corner in corners.T], 1))


def _bytes(colors: NDArray[np.floating]) -> NDArray[np.uint8]:
    """Return colours 0..1 as codes."""
    return (colors * np.asarray(255, colors.dtype) + np.asarray(0.5, colors.dtype)).astype(np.uint8)

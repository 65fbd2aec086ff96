"""Colour: sRGB transfer functions, tone curves, and developing linear radiance into an image."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.kernel import inline, kernel
from glimt.lanes import (
    LANES,
    f32,
    gather,
    gather_int,
    lane_numbers,
    minimum,
    pointer,
    scalar_int,
    select,
    stack_ints,
    store,
    to_int,
)

ToneCurve = Literal["clamp", "filmic"]


def srgb_to_linear(values: NDArray[Any]) -> NDArray[np.float32]:
    """Decode sRGB values 0..1 into linear ones (IEC 61966-2-1)."""
    values = np.clip(np.asarray(values, np.float32), 0, 1)
    low = values / np.float32(12.92)
    high = ((values + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(values <= np.float32(0.04045), low, high).astype(np.float32)


def linear_to_srgb(values: NDArray[Any]) -> NDArray[np.float32]:
    """Encode linear values 0..1 as sRGB (IEC 61966-2-1)."""
    values = np.clip(np.asarray(values, np.float32), 0, 1)
    low = values * np.float32(12.92)
    high = np.float32(1.055) * values ** np.float32(1 / 2.4) - np.float32(0.055)
    return np.where(values <= np.float32(0.0031308), low, high).astype(np.float32)


@inline
def filmic(x):  # type: ignore[no-untyped-def]
    """Roll radiance off towards 1 (Narkowicz, "ACES Filmic Tone Mapping Curve", 2016)."""
    top = x * (np.float32(2.51) * x + np.float32(0.03))
    return top / (x * (np.float32(2.43) * x + np.float32(0.59)) + np.float32(0.14))


def exposure_scale(exposure: float) -> float:
    """Return what radiance is multiplied by for an exposure in stops."""
    return float(2.0 ** min(max(exposure, -100.0), 25.0))


def develop(radiance: NDArray[np.float32], exposure: float = 0.0, tone_curve: ToneCurve = "clamp",
            image: NDArray[np.uint8] | None = None) -> NDArray[np.uint8]:
    """Turn linear radiance into a displayable image.

    Parameters
    ----------
    radiance : (h, w, 3) or (h, w, 4) float32
        Linear RGB, Rec. 709 primaries; a fourth number says how many samples were added up.
    exposure : float
        Stops; each doubles the radiance.
    tone_curve : "clamp" or "filmic"
        How radiance above 1 is shown: cut off, or rolled off.
    image : (h, w, 3) or (h, w, 4) uint8, optional
        Contiguous; is written to and returned. A fourth number, opacity, becomes 255.

    Returns
    -------
    (h, w, 3) uint8, sRGB, row 0 on top; or `image`.
    """
    if tone_curve not in ("clamp", "filmic"):
        raise GlimtError(f"tone curve is {tone_curve!r}, expected 'clamp' or 'filmic'")
    height, width, parts = radiance.shape
    words = image if image is not None and image.shape[2] == 4 else np.empty((height, width, 4), np.uint8)
    scale = np.float32(exposure_scale(exposure))
    _develop(np.ascontiguousarray(radiance, np.float32).reshape(-1), parts, scale, tone_curve == "filmic", _SRGB_CODES,
             words.reshape(-1).view(np.int32))
    if image is None:
        return np.ascontiguousarray(words[..., :3])
    if image is not words:
        image[...] = words[..., :3]
    return image


@inline
def _codes_of(radiance, at, active, factor, is_filmic, codes):  # type: ignore[no-untyped-def]
    """Return the sRGB codes of one number of each pixel; NaN is black."""
    value = gather(radiance, at, active) * factor
    value = select(value > 0.0, minimum(value, f32(np.float32(1e4))), 0.0)
    if is_filmic:
        value = filmic(value)
    last = np.float32(_STEPS - 1)
    return gather_int(codes, to_int(minimum(value, f32(np.float32(1.0))) * last + np.float32(0.5)), active)


@kernel
def _develop(radiance, parts, scale, is_filmic, codes, image):  # type: ignore[no-untyped-def]
    """Develop pixels of `parts` floats each through a table of sRGB codes into words of red, green, blue and 255."""
    radiance_words, code_words, line = pointer(radiance), pointer(codes), stack_ints(LANES)
    for first in range(0, len(image), LANES):
        pixel = lane_numbers() + np.int32(first)
        active = pixel < np.int32(len(image))
        at = pixel * np.int32(parts)
        factor = f32(scale)
        if parts > 3:
            samples = gather(radiance_words, at + 3, active)
            factor = select(samples > 0.0, factor / samples, 0.0)
        red = _codes_of(radiance_words, at, active, factor, is_filmic, code_words)
        green = _codes_of(radiance_words, at + 1, active, factor, is_filmic, code_words)
        blue = _codes_of(radiance_words, at + 2, active, factor, is_filmic, code_words)
        word = red | (green << 8) | (blue << 16) | np.int32(-1 << 24)
        if first + LANES <= len(image):
            store(image, first, word)
            continue
        store(line, 0, word)
        for lane in range(len(image) - first):
            image[first + lane] = scalar_int(line, lane)


_STEPS = 65536
# Codes for equal steps of linear light: at the dark end one code spans 20 steps, so the table is right to a step.
_SRGB_CODES = (linear_to_srgb(np.linspace(0, 1, _STEPS, dtype=np.float32)) * np.float32(255) + np.float32(0.5)).astype(
    np.int32)

"""Colour: sRGB transfer functions, tone curves, and developing linear radiance into an image."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError
from glimt.kernel import inline, kernel

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


def develop(radiance: NDArray[np.float32], exposure: float = 0.0, tone_curve: ToneCurve = "clamp") -> NDArray[np.uint8]:
    """Turn linear radiance into a displayable image.

    Parameters
    ----------
    radiance : (h, w, 3) or (h, w, 4) float32
        Linear RGB, Rec. 709 primaries; a fourth number says how many samples were added up.
    exposure : float
        Stops; each doubles the radiance.
    tone_curve : "clamp" or "filmic"
        How radiance above 1 is shown: cut off, or rolled off.

    Returns
    -------
    (h, w, 3) uint8, sRGB, row 0 on top.
    """
    if tone_curve not in ("clamp", "filmic"):
        raise GlimtError(f"tone curve is {tone_curve!r}, expected 'clamp' or 'filmic'")
    image = np.empty((*radiance.shape[:2], 3), np.uint8)
    scale = np.float32(exposure_scale(exposure))
    _develop(np.ascontiguousarray(radiance, np.float32).ravel(), radiance.shape[2], scale, tone_curve == "filmic",
             _SRGB_CODES, image.ravel())
    return image


@kernel
def _develop(radiance, parts, scale, is_filmic, codes, image):  # type: ignore[no-untyped-def]
    """Develop pixels of `parts` floats each through a table of sRGB codes."""
    one, zero, last = np.float32(1), np.float32(0), np.float32(len(codes) - 1)
    for pixel in range(len(image) // 3):
        samples = radiance[parts * pixel + 3] if parts > 3 else one
        factor = scale / samples if samples > zero else zero
        for k in range(3):
            value = radiance[parts * pixel + k] * factor
            value = min(value, np.float32(1e4)) if value > zero else zero  # NaN is black
            if is_filmic:
                value = filmic(value)
            image[3 * pixel + k] = codes[np.uint32(min(value, one) * last + np.float32(0.5))]


# Codes for 65,536 steps of linear light: at the dark end one code spans 20 steps, so the table is right to a step.
_SRGB_CODES = (linear_to_srgb(np.linspace(0, 1, 65536, dtype=np.float32)) * np.float32(255) + np.float32(0.5)).astype(
    np.uint8)

"""Colour: sRGB transfer functions, tone curves, and developing linear radiance into an image."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from glimt.errors import GlimtError

ToneCurve = Literal["clamp", "filmic"]


def srgb_to_linear(values: NDArray[Any]) -> NDArray[np.float32]:
    """Decode sRGB values 0..1 into linear ones (IEC 61966-2-1)."""
    values = np.clip(np.asarray(values, np.float32), 0, 1)
    low = values / np.float32(12.92)
    high = ((values + np.float32(0.055)) / np.float32(1.055)) ** np.float32(2.4)
    return np.where(values <= np.float32(0.04045), low, high)


def linear_to_srgb(values: NDArray[Any]) -> NDArray[np.float32]:
    """Encode linear values 0..1 as sRGB (IEC 61966-2-1)."""
    values = np.clip(np.asarray(values, np.float32), 0, 1)
    low = values * np.float32(12.92)
    high = np.float32(1.055) * values ** np.float32(1 / 2.4) - np.float32(0.055)
    return np.where(values <= np.float32(0.0031308), low, high)


def filmic(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    """Roll radiance off towards 1 (Narkowicz, "ACES Filmic Tone Mapping Curve", 2016)."""
    x = np.clip(radiance, 0, np.float32(1e4))
    f = np.float32
    return x * (f(2.51) * x + f(0.03)) / (x * (f(2.43) * x + f(0.59)) + f(0.14))


def develop(radiance: NDArray[np.float32], exposure: float = 0.0, tone_curve: ToneCurve = "clamp") -> NDArray[np.uint8]:
    """Turn linear radiance into a displayable image.

    Parameters
    ----------
    radiance : (h, w, 3) float32
        Linear RGB, Rec. 709 primaries.
    exposure : float
        Stops; each doubles the radiance.
    tone_curve : "clamp" or "filmic"

    Returns
    -------
    (h, w, 3) uint8, sRGB, row 0 on top.
    """
    if tone_curve not in ("clamp", "filmic"):
        raise GlimtError(f"tone curve is {tone_curve!r}, expected 'clamp' or 'filmic'")
    exposed = np.clip(radiance, 0, np.float32(1e30)) * np.float32(2.0**min(max(exposure, -100.0), 25.0))
    toned = filmic(exposed) if tone_curve == "filmic" else np.minimum(exposed, np.float32(1))
    return _SRGB_CODES[(toned * np.float32(len(_SRGB_CODES) - 1) + np.float32(0.5)).astype(np.int32)]


# Codes for 65,536 steps of linear light: at the dark end one code spans 20 steps, so the table is exact to a step.
_SRGB_CODES = (linear_to_srgb(np.linspace(0, 1, 65536, dtype=np.float32)) * np.float32(255) + np.float32(0.5)).astype(
    np.uint8)

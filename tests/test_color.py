"""Transfer functions and developing, against a float64 reference."""

import numpy as np
import pytest

from glimt import GlimtError
from glimt.color import develop, linear_to_srgb, srgb_to_linear

RNG = np.random.default_rng(9)


def _encoded(linear):
    """Return sRGB codes 0..255 as float64 (IEC 61966-2-1)."""
    linear = np.clip(np.asarray(linear, np.float64), 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9)**(1 / 2.4) - 0.055)


def _filmic(x):
    x = np.asarray(x, np.float64)
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


def test_srgb_codes_go_round():
    codes = np.arange(256) / np.float32(255)
    np.testing.assert_allclose(linear_to_srgb(srgb_to_linear(codes)), codes, atol=2e-6)
    linear = np.linspace(0, 1, 10001, dtype=np.float32)
    np.testing.assert_allclose(srgb_to_linear(linear_to_srgb(linear)), linear, atol=2e-6)


def test_srgb_is_the_standard():
    assert srgb_to_linear(np.array([0, 0.04045, 0.5, 1])) == pytest.approx([0, 0.0031308, 0.21404114, 1], rel=1e-5)
    assert linear_to_srgb(np.array([0, 0.0031308, 0.18, 1])) == pytest.approx([0, 0.04045, 0.46135613, 1], rel=1e-5)
    assert (np.diff(linear_to_srgb(np.linspace(0, 1, 4096))) > 0).all()
    np.testing.assert_array_equal(srgb_to_linear(np.array([-1, 2.0])), [0, 1])
    np.testing.assert_allclose(linear_to_srgb(np.array([-1, 2.0])), [0, 1], atol=1e-7)


@pytest.mark.parametrize("exposure", [0, 1, -2.5, 10])
@pytest.mark.parametrize("curve", ["clamp", "filmic"])
@pytest.mark.parametrize("samples", [None, 1, 9])
def test_develop_is_the_reference_to_a_code(exposure, curve, samples):
    radiance = (10**RNG.uniform(-5, 2, (40, 50, 3))).astype(np.float32)
    given = radiance if samples is None else np.concatenate(
        [radiance * np.float32(samples), np.full((40, 50, 1), samples, np.float32)], -1)
    linear = radiance.astype(np.float64) * 2.0**exposure
    expected = _encoded(_filmic(linear) if curve == "filmic" else linear)
    got = develop(given, exposure, curve)
    assert got.dtype == np.uint8
    assert got.shape == (40, 50, 3)
    assert np.abs(got - expected).max() <= 0.56  # half a code, and a step of the table
    assert (got == np.floor(expected + 0.5)).mean() > 0.99


def test_every_stop_doubles():
    radiance = np.full((1, 1, 3), 0.1, np.float32)
    np.testing.assert_array_equal(develop(radiance, 1), develop(2 * radiance))
    np.testing.assert_array_equal(develop(radiance, -3), develop(radiance / 8))
    assert (develop(radiance, 100) == 255).all()
    assert (develop(radiance, -100) == 0).all()


@pytest.mark.parametrize("curve", ["clamp", "filmic"])
def test_develop_is_monotone(curve):
    ramp = np.linspace(0, 4, 20000, dtype=np.float32)
    codes = develop(np.repeat(ramp[None, :, None], 3, 2), 0, curve)[0, :, 0].astype(int)
    assert (np.diff(codes) >= 0).all()
    assert codes[0] == 0
    assert codes[-1] >= 245


@pytest.mark.parametrize("curve", ["clamp", "filmic"])
def test_develop_shows_something_for_anything(curve):
    odd = np.float32([np.nan, np.inf, -np.inf, -1, 3.4e38, 1e-45, -0.0])
    codes = develop(np.repeat(odd[None, :, None], 3, 2), 25, curve)[0, :, 0]
    assert codes[1] == codes[4] >= 254
    assert codes[[2, 3, 6]].tolist() == [0, 0, 0]
    assert codes[0] == 0


def test_pixels_without_samples_are_black():
    sums = np.ones((2, 2, 4), np.float32)
    sums[0, 0, 3] = 0
    assert develop(sums)[0, 0].tolist() == [0, 0, 0]
    assert develop(sums)[1, 1].tolist() == [255, 255, 255]


def test_unknown_tone_curves_are_refused():
    with pytest.raises(GlimtError, match="tone curve is 'loud', expected 'clamp' or 'filmic'"):
        develop(np.zeros((1, 1, 3), np.float32), 0, "loud")

"""Images in and out."""

import contextlib
import os
import stat

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from glimt.errors import GlimtError
from glimt.io import image as module
from glimt.io.image import TextureCache, read_texture, save_image

PIXELS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [10, 20, 30]], [[0, 0, 0], [255, 255, 255]]], np.uint8)


def pixels(path):
    return read_texture(path, encoding="srgb").pixels


@pytest.mark.parametrize("ending", ["png", "bmp", "tga"])
def test_lossless_formats(tmp_path, ending):
    save_image(tmp_path / f"a.{ending}", PIXELS)
    assert np.array_equal(pixels(tmp_path / f"a.{ending}"), PIXELS)


@pytest.mark.parametrize("ending", ["jpg", "jpeg", "JPG"])
def test_jpeg(tmp_path, ending):
    grey = np.full((16, 16, 3), 120, np.uint8)
    save_image(tmp_path / f"a.{ending}", grey)
    assert np.abs(pixels(tmp_path / f"a.{ending}").astype(int) - 120).max() <= 1


def test_webp_is_written_but_not_read(tmp_path):
    save_image(tmp_path / "a.webp", PIXELS)
    with Image.open(tmp_path / "a.webp") as image:
        assert image.size == (2, 3)
    with pytest.raises(GlimtError, match=r"a\.webp: is no image; expected PNG, JPEG, BMP, GIF, TGA"):
        pixels(tmp_path / "a.webp")


def test_content_decides_and_not_the_ending(tmp_path):
    Image.fromarray(PIXELS).save(tmp_path / "a.jpg", "PNG")
    assert np.array_equal(pixels(tmp_path / "a.jpg"), PIXELS)


@pytest.mark.parametrize(("mode", "color", "expected"), [
    ("1", 1, (255, 255, 255)), ("L", 77, (77, 77, 77)), ("LA", (77, 0), (77, 77, 77)),
    ("RGBA", (10, 20, 30, 0), (10, 20, 30)), ("RGBA", (10, 20, 30, 128), (10, 20, 30)),
    ("I;16", 65535, (255, 255, 255)), ("I;16", 0x8080, (128, 128, 128)), ("I;16", 0, (0, 0, 0))])
def test_modes_of_png(tmp_path, mode, color, expected):
    Image.new(mode, (2, 2), color).save(tmp_path / "a.png")
    assert pixels(tmp_path / "a.png")[0, 0].tolist() == list(expected)


def test_a_palette_with_transparent_entries(tmp_path):
    image = Image.new("P", (2, 1))
    image.putpalette([1, 2, 3, 40, 50, 60])
    image.putdata([0, 1])
    for name in ("a.png", "a.gif"):
        image.save(tmp_path / name, transparency=1)
        assert pixels(tmp_path / name)[0, 0].tolist() == [1, 2, 3]
    image.save(tmp_path / "b.png", transparency=b"\x80\x00")
    assert pixels(tmp_path / "b.png").tolist() == [[[1, 2, 3], [40, 50, 60]]]


def test_the_first_frame_of_a_gif(tmp_path):
    frames = [Image.new("RGB", (4, 4), color) for color in ((255, 0, 0), (0, 255, 0))]
    frames[0].save(tmp_path / "a.gif", save_all=True, append_images=frames[1:])
    assert pixels(tmp_path / "a.gif")[0, 0].tolist() == [255, 0, 0]


def test_cmyk(tmp_path):
    Image.new("CMYK", (8, 8), (0, 255, 255, 0)).save(tmp_path / "a.jpg")
    red, green, blue = pixels(tmp_path / "a.jpg")[4, 4].tolist()
    assert red > 240
    assert max(green, blue) < 15


def test_exif_orientation_is_ignored(tmp_path):
    image = Image.new("RGB", (8, 4))
    exif = image.getexif()
    exif[0x0112] = 6
    image.save(tmp_path / "a.jpg", exif=exif)
    assert pixels(tmp_path / "a.jpg").shape == (4, 8, 3)


def test_texture_arguments(tmp_path):
    save_image(tmp_path / "a.png", PIXELS)
    texture = read_texture(tmp_path / "a.png", encoding="linear", wrap="clamp", scale=(2, 3), offset=(4, 5))
    assert (texture.encoding, texture.wrap, texture.scale, texture.offset) == ("linear", "clamp", (2, 3), (4, 5))
    assert texture.name == "a.png"


def test_the_cache_decodes_once(tmp_path):
    save_image(tmp_path / "a.png", PIXELS)
    cache = TextureCache()
    first = cache.texture(tmp_path / "a.png", encoding="srgb")
    second = cache.texture(tmp_path / "." / "a.png", encoding="linear")
    assert first.pixels is second.pixels
    with pytest.raises(GlimtError, match="no such file"):
        cache.pixels(tmp_path / "b.png")
    save_image(tmp_path / "b.png", PIXELS)
    with pytest.raises(GlimtError, match="no such file"):
        cache.pixels(tmp_path / "b.png")


# Limits

@pytest.mark.parametrize("size", [(16385, 1), (1, 16385), (9000, 8000), (30000, 30000), (65535, 65535)])
def test_huge_images_are_refused_unseen(tmp_path, size):
    header = Image.new("L", (1, 1))
    header.save(tmp_path / "a.bmp")
    content = bytearray((tmp_path / "a.bmp").read_bytes())
    content[18:26] = np.array(size, "<i4").tobytes()
    (tmp_path / "a.bmp").write_bytes(content)
    with pytest.raises(GlimtError, match=r"a\.bmp: .*more than 16384 pixels a side and 64 megapixels; scale it down"):
        pixels(tmp_path / "a.bmp")


def test_images_of_one_load_have_a_limit_together(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "LARGEST_TOTAL", 10)
    cache = TextureCache()
    for name in "ab":
        save_image(tmp_path / f"{name}.png", PIXELS)
    cache.pixels(tmp_path / "a.png")
    with pytest.raises(GlimtError, match="all images together"):
        cache.pixels(tmp_path / "b.png")


@pytest.mark.parametrize("ending", ["png", "jpg", "bmp", "tga", "gif"])
def test_truncated_images(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    Image.fromarray(np.random.default_rng(1).integers(0, 255, (20, 20, 3)).astype(np.uint8)).save(path)
    content = path.read_bytes()
    for length in range(0, len(content) * 3 // 4, max(1, len(content) // 40)):
        path.write_bytes(content[:length])
        with pytest.raises(GlimtError, match=rf"a\.{ending}: "):
            pixels(path)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.sampled_from(["PNG", "JPEG", "BMP", "TGA", "GIF"]),
       st.lists(st.tuples(st.floats(0, 0.999), st.binary(max_size=3)), min_size=1, max_size=6))
def test_damaged_images(tmp_path, image_format, mutations):
    path = tmp_path / "a.img"
    Image.fromarray(PIXELS).save(path, image_format)
    content = bytearray(path.read_bytes())
    for place, replacement in mutations:
        start = int(place * len(content))
        content[start:start + 1] = replacement
    path.write_bytes(content)
    with contextlib.suppress(GlimtError):
        assert pixels(path).dtype == np.uint8


# Writing

@pytest.mark.parametrize("name", ["a", "a.gif", "a.tiff", "a.png.txt"])
def test_unknown_endings(tmp_path, name):
    with pytest.raises(GlimtError, match=r"cannot tell the format from '.*', use one of \.png, \.jpg"):
        save_image(tmp_path / name, PIXELS)


@pytest.mark.parametrize("image", [
    PIXELS.astype(np.float32), PIXELS[..., 0], PIXELS[..., :2], PIXELS[:0], np.zeros((2, 2, 4), np.uint8),
    PIXELS.astype(int)])
def test_what_is_no_image(tmp_path, image):
    with pytest.raises(GlimtError, match=r"expected uint8 \(h, w, 3\)"):
        save_image(tmp_path / "a.png", image)


def test_where_an_image_cannot_go(tmp_path):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(GlimtError, match="is a folder"):
        save_image(tmp_path / "folder.png", PIXELS)
    with pytest.raises(GlimtError, match="there is no folder"):
        save_image(tmp_path / "nowhere" / "a.png", PIXELS)
    for name in ("a" * 300, "a\0"):
        with pytest.raises(GlimtError, match=r"\.png: cannot be written"):
            save_image(tmp_path / f"{name}.png", PIXELS)


@pytest.mark.parametrize("name", ["nothing", "a" * 300, "a\0", "."])
def test_where_no_image_is(tmp_path, name):
    with pytest.raises(GlimtError, match="; name an image"):
        pixels(tmp_path / name)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    save_image(tmp_path / "a.png", PIXELS)
    before = (tmp_path / "a.png").read_bytes()

    def fail(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module.Image.Image, "save", fail)
    with pytest.raises(GlimtError, match="cannot be written: No space left"):
        save_image(tmp_path / "a.png", PIXELS[:1])
    assert (tmp_path / "a.png").read_bytes() == before
    assert os.listdir(tmp_path) == ["a.png"]


@pytest.mark.skipif(os.name == "nt", reason="no such permissions")
def test_permissions_are_those_of_a_new_file(tmp_path):
    (tmp_path / "other").write_text("")
    save_image(tmp_path / "a.png", PIXELS)
    assert stat.S_IMODE((tmp_path / "a.png").stat().st_mode) == stat.S_IMODE((tmp_path / "other").stat().st_mode)

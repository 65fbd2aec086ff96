"""Image files to textures, and images to files."""

import contextlib
import io
import os
import secrets
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from glimt.errors import GlimtError
from glimt.io.files_read import note_read
from glimt.scene.texture import Encoding, Texture, Wrap

READABLE = ("PNG", "JPEG", "BMP", "GIF", "TGA")  # TGA has no signature and comes last
WRITABLE = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".bmp": "BMP", ".tga": "TGA", ".webp": "WEBP"}
_OPTIONS = {"JPEG": {"quality": 95}, "WEBP": {"quality": 95}, "PNG": {"compress_level": 2}}
"""How images are written; PNG's usual level 6 takes three times as long as 2, and makes files a tenth smaller."""
LARGEST_SIDE = 16384
LARGEST_AREA = 64 * 2**20
LARGEST_TOTAL = 192 * 2**20
"""Pixels of all images of one load: a small file can hold a huge image."""


class TextureCache:
    """Decodes each image file once; the textures made of it share one pixel array."""

    def __init__(self) -> None:
        self._decoded: dict[str, NDArray[np.uint8] | GlimtError] = {}
        self._total = 0

    def pixels(self, path: str | os.PathLike[str]) -> NDArray[np.uint8]:
        """Return the (h, w, 3) pixels of an image file, or raise the same `GlimtError` each time."""
        key = os.path.abspath(path)
        if key not in self._decoded:
            try:
                pixels = _decode(Path(path), LARGEST_TOTAL - self._total)
                pixels.flags.writeable = False
                self._total += pixels.shape[0] * pixels.shape[1]
                self._decoded[key] = pixels
            except GlimtError as error:
                self._decoded[key] = error
        result = self._decoded[key]
        if isinstance(result, GlimtError):
            raise GlimtError(str(result))
        return result

    def texture(self, path: str | os.PathLike[str], *, encoding: Encoding, wrap: Wrap = "repeat",
                scale: tuple[float, float] = (1.0, 1.0), offset: tuple[float, float] = (0.0, 0.0),
                where: str = "") -> Texture:
        """Return an image file as a `Texture`; see `read_texture`."""
        try:
            return Texture(self.pixels(path), encoding, wrap, scale, offset, Path(path).name)
        except GlimtError as error:
            raise GlimtError(f"{where}: {error}" if where else str(error)) from None


def read_texture(path: str | os.PathLike[str], *, encoding: Encoding, wrap: Wrap = "repeat",
                 scale: tuple[float, float] = (1.0, 1.0), offset: tuple[float, float] = (0.0, 0.0),
                 where: str = "") -> Texture:
    """Read a PNG, JPEG, BMP, TGA or GIF file, told apart by content; 8 bits a channel, the first frame, no alpha.

    Parameters
    ----------
    path : str or path
        Its ending does not matter.
    encoding, wrap, scale, offset : Encoding, Wrap, pair of float, pair of float
        As in `Texture`.
    where : str
        Who names the file ("room.mtl:12"), for the message of an error.

    Raises
    ------
    GlimtError
        The file cannot be read, is no such image, is damaged, or is larger than `LARGEST_SIDE` or `LARGEST_AREA`.
    """
    return TextureCache().texture(path, encoding=encoding, wrap=wrap, scale=scale, offset=offset, where=where)


def save_image(path: str | os.PathLike[str], image: NDArray[np.uint8]) -> None:
    """Write an (h, w, 3) uint8 image, row 0 on top, in the format its name ends with; an old file stays until then.

    Raises
    ------
    GlimtError
        The image or the ending is wrong, or the file cannot be written.
    """
    path = Path(path)
    image_format = WRITABLE.get(path.suffix.lower())
    if image_format is None:
        raise GlimtError(f"{path}: cannot tell the format from {path.suffix!r}, use one of {', '.join(WRITABLE)}")
    image = np.asarray(image)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or 0 in image.shape:
        raise GlimtError(f"{path}: the image is {image.dtype} of shape {image.shape}, expected uint8 (h, w, 3)")
    if os.path.isdir(path):
        raise GlimtError(f"{path}: is a folder; name a file in it")
    if not os.path.isdir(path.parent):
        raise GlimtError(f"{path}: there is no folder {path.parent}; create it")
    temporary = path.with_name(f".{secrets.token_hex(8)}.tmp")
    try:
        with open(temporary, "xb") as file:
            options = _OPTIONS.get(image_format, {})
            Image.fromarray(np.ascontiguousarray(image)).save(file, image_format, **options)
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        raise GlimtError(f"{path}: cannot be written: {getattr(error, 'strerror', None) or error}") from None
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def encode_png(image: NDArray[np.uint8]) -> bytes:
    """Return an (h, w, 3) uint8 image, row 0 on top, as the bytes of a PNG file."""
    file = io.BytesIO()
    Image.fromarray(image).save(file, "PNG", **_OPTIONS["PNG"])
    return file.getvalue()


def _decode(path: Path, allowance: int) -> NDArray[np.uint8]:
    """Return the (h, w, 3) pixels of a file whose image has at most `allowance` of them."""
    note_read(path)
    if not os.path.isfile(path):
        reason = ("is a folder" if os.path.isdir(path) else "is not a regular file" if os.path.exists(path)
                  else "no such file")
        raise GlimtError(f"{path}: {reason}; name an image")
    limits = f"{LARGEST_SIDE} pixels a side and {LARGEST_AREA // 2**20} megapixels"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path, formats=READABLE) as image:
                width, height = image.size
                if max(width, height) > LARGEST_SIDE or width * height > LARGEST_AREA:
                    raise GlimtError(f"{path}: {width} x {height} is more than {limits}; scale it down")
                if width * height > allowance:
                    raise GlimtError(f"{path}: all images together have more than {LARGEST_TOTAL // 2**20} megapixels; "
                                     "scale them down")
                return _rgb(image)
    except (GlimtError, MemoryError):
        raise
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise GlimtError(f"{path}: the image is more than {limits}; scale it down") from None
    except PermissionError as error:
        raise GlimtError(f"{path}: cannot be read: {error.strerror}") from None
    except UnidentifiedImageError:
        raise GlimtError(f"{path}: is no image; expected {', '.join(READABLE)}") from None
    except Exception as error:  # a damaged file makes Pillow's decoders raise nearly anything
        raise GlimtError(f"{path}: the image is damaged: {error}") from None


def _rgb(image: Image.Image) -> NDArray[np.uint8]:
    """Return an opened image as (h, w, 3): grey is repeated, alpha is dropped, 16 bits become 8."""
    if image.mode.startswith("I"):
        grey = np.asarray(image).astype(np.int64).clip(0, 65535)
        return np.repeat(((grey + 128) // 257).astype(np.uint8)[..., None], 3, -1)
    if image.mode in ("P", "PA"):
        image = image.convert("RGBA")  # not at once to RGB, which would warn of transparent entries
    return np.array(image.convert("RGB"))

"""Frames that are read and decoded only when they are asked for."""

import io
from collections.abc import Callable, Iterator, Sequence
from typing import Any, overload

import cv2
import numpy as np
from PIL import Image
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile

from recordings.refusal import Refusal

READERS = {b"\x89PNG": PngImageFile, b"\xff\xd8\xff": JpegImageFile}
# A camera has fewer; an image that claims more is damaged, or made to fill the memory.
MOST_PIXELS = 1 << 26


class LazyFrames(Sequence):
    """Frames of one shape and type, each read when it is indexed; `np.asarray` reads them all.

    shape: (F, ...); dtype: type of every frame; read: frame number to array.
    A slice is again lazy. Equal to another sequence where every frame has the same values (NaN equals NaN).
    """

    def __init__(self, shape: tuple[int, ...], dtype: Any, read: Callable[[int], np.ndarray]) -> None:
        self.shape = tuple(shape)
        self.dtype = np.dtype(dtype)
        self._read = read

    @property
    def ndim(self) -> int:
        """Number of axes, frames included."""
        return len(self.shape)

    @property
    def nbytes(self) -> int:
        """Bytes of all frames once decoded."""
        return int(np.prod(self.shape, dtype=object)) * self.dtype.itemsize

    def __len__(self) -> int:
        return self.shape[0]

    @overload
    def __getitem__(self, index: int) -> np.ndarray: ...
    @overload
    def __getitem__(self, index: slice) -> "LazyFrames": ...
    def __getitem__(self, index):
        if isinstance(index, slice):
            return self._chosen(range(len(self))[index])
        try:
            return self._read(range(len(self))[index])
        except IndexError:
            raise IndexError(f"frame {index} of {len(self)}") from None

    def _chosen(self, numbers: range) -> "LazyFrames":
        return LazyFrames((len(numbers), *self.shape[1:]), self.dtype, lambda i: self._read(numbers[i]))

    def __iter__(self) -> Iterator[np.ndarray]:
        return (self._read(i) for i in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        if copy is False:
            raise ValueError("frames that are read on demand have no array to share")
        whole = np.empty(self.shape, self.dtype)
        for i, frame in enumerate(self):
            whole[i] = frame
        return whole if dtype is None else whole.astype(dtype, copy=False)

    def __eq__(self, other: object) -> bool:
        if not hasattr(other, "shape") or tuple(other.shape) != self.shape or other.dtype != self.dtype:
            return False
        nan = self.dtype.kind == "f"
        return all(np.array_equal(a, b, equal_nan=nan) for a, b in zip(self, other, strict=True))

    __hash__ = None


class EncodedFrames(LazyFrames):
    """Colour frames kept as the PNG or JPEG bytes they came as: (F, H, W, 3) uint8 once decoded.

    encoded: frame number to bytes; size: (H, W) every frame has.
    """

    def __init__(self, encoded: Callable[[int], bytes], count: int, size: tuple[int, int]) -> None:
        super().__init__((count, *size, 3), np.uint8, lambda i: decoded(encoded(i), size, f"rgb[{i}]"))
        self._encoded = encoded
        self._size = size

    @classmethod
    def of(cls, blobs: Sequence[bytes]) -> "EncodedFrames":
        """Frames whose bytes are in memory; the first says the size of all."""
        if not len(blobs):
            raise Refusal("rgb has no frame, expected at least one")
        return cls(lambda i: blobs[i], len(blobs), encoded_size(blobs[0], "rgb[0]"))

    def encoded(self, index: int) -> bytes:
        """The PNG or JPEG bytes of one frame."""
        return self._encoded(range(len(self))[index])

    def grey(self, index: int) -> np.ndarray:
        """(H, W) uint8 brightness of one frame; of a JPEG its colours are not even decoded."""
        number = range(len(self))[index]
        return decoded(self._encoded(number), self._size, f"rgb[{number}]", "L")

    def _chosen(self, numbers: range) -> "EncodedFrames":
        return EncodedFrames(lambda i: self._encoded(numbers[i]), len(numbers), self.shape[1:3])


def encode(image: np.ndarray) -> bytes:
    """Lossless PNG of an (H, W, 3) uint8 image."""
    ok, blob = cv2.imencode(".png", cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2BGR))
    if not ok:
        raise Refusal(f"an image of shape {image.shape} cannot be written as PNG")
    return blob.tobytes()


def encoded_size(blob: bytes, name: str) -> tuple[int, int]:
    """Height and width from the head of PNG or JPEG bytes; refuses other bytes, calling them `name`."""
    with opened(blob, name) as image:
        return image.height, image.width


def decoded(blob: bytes, size: tuple[int, int], name: str, mode: str = "RGB") -> np.ndarray:
    """(H, W, 3) uint8 pixels of PNG or JPEG bytes; refuses damaged bytes and another size than (H, W).

    mode: "RGB", or "L" for (H, W) brightness.
    """
    with opened(blob, name) as image:
        if (image.height, image.width) != tuple(size):
            there = f"{image.width} x {image.height}"
            raise Refusal(f"{name} is {there} pixels, expected {size[1]} x {size[0]} (width x height)")
        try:
            if mode == "L":
                image.draft("L", image.size)
            return np.array(image.convert(mode))
        except (OSError, ValueError, SyntaxError) as wrong:
            raise Refusal(f"{name} is a damaged {image.format} image ({wrong})") from None


def opened(blob: bytes, name: str) -> Image.Image:
    """The image in PNG or JPEG bytes, its pixels not yet decoded."""
    reader = next((found for magic, found in READERS.items() if blob.startswith(magic)), None)
    try:
        image = reader(io.BytesIO(blob))
    except (OSError, ValueError, SyntaxError, TypeError):
        raise Refusal(f"{name} is not an image, expected PNG or JPEG bytes") from None
    if image.width * image.height > MOST_PIXELS:
        raise Refusal(f"{name} claims {image.width} x {image.height} pixels, expected {MOST_PIXELS} at most")
    return image

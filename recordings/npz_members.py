"""The arrays inside an .npz, read without trusting what the file says of itself."""

import math
import shutil
import warnings
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO

import numpy as np

from recordings.refusal import Refusal

# Deflate never packs more than this many bytes into one.
MOST_PACKED = 1032
SUFFIX = ".npy"
# Members larger than this get the long form of a zip entry; others the short one that every program reads.
LARGE = 1 << 30
PIECE = 1 << 22
# The record at the end of an archive, with the longest comment, and a number of members that is told elsewhere.
END, LONGEST_END, UNTOLD = b"PK\x05\x06", 22 + (1 << 16), 0xFFFF


@dataclass(frozen=True)
class Member:
    """An array in the archive, known by its header only: name, type, shape, offset of its first value."""

    name: str
    info: zipfile.ZipInfo
    dtype: np.dtype
    shape: tuple[int, ...]
    fortran: bool
    start: int

    @property
    def nbytes(self) -> int:
        """Bytes of all values."""
        return math.prod(self.shape) * self.dtype.itemsize

    def whole(self, archive: zipfile.ZipFile) -> np.ndarray:
        """The array."""
        with archive.open(self.info) as packed:
            packed.read(self.start)
            flat = np.frombuffer(exactly(packed, self.nbytes, self.name), self.dtype)
            self._expect_end(packed)
        return flat.reshape(self.shape, order="F" if self.fortran else "C")

    def rows(self, archive: zipfile.ZipFile) -> Iterator[np.ndarray]:
        """The array along its first axis, one after another."""
        if self.fortran:
            yield from self.whole(archive)
            return
        shape = self.shape[1:]
        size = math.prod(shape) * self.dtype.itemsize
        with archive.open(self.info) as packed:
            packed.read(self.start)
            for i in range(self.shape[0]):
                row = np.frombuffer(exactly(packed, size, self.name), self.dtype).reshape(shape)
                if i == self.shape[0] - 1:
                    self._expect_end(packed)
                yield row

    def _expect_end(self, packed: IO[bytes]) -> None:
        # The archive's own checksum is compared when its end is read.
        if packed.read(1):
            raise Refusal(f"{self.name} goes on after its {self.nbytes} bytes")


def exactly(packed: IO[bytes], size: int, name: str) -> bytearray:
    """`size` bytes, in memory that grows with what is there."""
    data = bytearray()
    while len(data) < size:
        more = packed.read(min(size - len(data), 1 << 24))
        if not more:
            raise Refusal(f"{name} ends after {len(data)} bytes, expected {size} as its header says")
        data += more
    return data


def entries(archive: zipfile.ZipFile) -> int:
    """How many members the end of the archive says there are: a damaged list may hide some of them."""
    file = archive.fp
    file.seek(0, 2)
    file.seek(max(0, file.tell() - LONGEST_END))
    end = file.read()
    return int.from_bytes(end[end.rindex(END) + 10 :][:2], "little")


def members(archive: zipfile.ZipFile) -> dict[str, Member]:
    """The arrays of an archive by name; refuses anything else in it, and headers that claim too much."""
    found: dict[str, Member] = {}
    counted = entries(archive)
    if counted not in (len(archive.infolist()), UNTOLD):
        raise Refusal(f"lists {len(archive.infolist())} arrays, expected {counted} as its end says")
    for info in archive.infolist():
        name = info.filename.removesuffix(SUFFIX)
        if name == info.filename:
            raise Refusal(f"holds {info.filename!r}, expected nothing but arrays ({SUFFIX})")
        if name in found:
            raise Refusal(f"holds {name} twice, expected it once")
        found[name] = member(archive, name, info)
    return found


def member(archive: zipfile.ZipFile, name: str, info: zipfile.ZipInfo) -> Member:
    """One array by its header."""
    with archive.open(info) as packed:
        version = np.lib.format.read_magic(packed)
        read = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if read is None:
            raise Refusal(f"{name} is of array format {version}, expected 1.0 or 2.0")
        with warnings.catch_warnings():
            # Files of Python 2 are read as well as others.
            warnings.simplefilter("ignore", UserWarning)
            shape, fortran, dtype = read(packed)
        start = packed.tell()
    if dtype.hasobject:
        raise Refusal(f"{name} holds Python objects (a pickle), expected numbers or text")
    if dtype.kind not in "biufcU" or dtype.names:
        raise Refusal(f"{name} holds {dtype}, expected numbers or text")
    here = Member(name, info, dtype, shape, fortran, start)
    holds = info.file_size - start
    if here.nbytes != holds or info.file_size > MOST_PACKED * (info.compress_size + 1):
        raise Refusal(f"{name} claims {here.nbytes} bytes, but its place in the file holds {holds}")
    return here


def text(value: np.ndarray, name: str) -> str:
    """A text from an array of one."""
    if value.dtype.kind != "U" or value.shape != ():
        raise Refusal(f"{name} holds {value.dtype.name} of shape {value.shape}, expected one text")
    return str(value)


def save_array(
    archive: zipfile.ZipFile, name: str, dtype: np.dtype, shape: tuple[int, ...], values: np.ndarray | IO[bytes]
) -> None:
    """Add an array; its values come from an array, or from a file of their bytes in row-major order."""
    size = math.prod(shape) * dtype.itemsize
    with archive.open(zipfile.ZipInfo(name + SUFFIX), "w", force_zip64=size >= LARGE) as packed:
        described = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(packed, described)
        if isinstance(values, np.ndarray):
            packed.write(np.ascontiguousarray(values).tobytes())
        else:
            shutil.copyfileobj(values, packed, PIECE)

"""Memory for large arrays, in large pages: handed out 4 KiB at a time it costs more than what is written into it."""

import math
import mmap
from contextlib import suppress

import numpy as np

LARGE_PAGE = 1 << 21


def zeros(shape: tuple[int, ...], dtype: type = float) -> np.ndarray:
    """As `numpy.zeros`, in large pages where the system has them and the array fills one.

    numpy asks for them, too, but its memory comes from the heap, which hands back what is freed and fetches it again
    in small pages.
    """
    bytes_needed = math.prod(shape) * np.dtype(dtype).itemsize
    if bytes_needed < LARGE_PAGE or not hasattr(mmap, "MADV_HUGEPAGE"):
        return np.zeros(shape, dtype)
    pages = mmap.mmap(-1, -(-bytes_needed // LARGE_PAGE) * LARGE_PAGE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    with suppress(OSError):  # A kernel without them: small pages do.
        pages.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(pages, dtype, math.prod(shape)).reshape(shape)

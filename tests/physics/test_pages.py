"""Memory in large pages is like any other."""

import numpy as np
import pytest

from physics.pages import zeros


@pytest.mark.parametrize("shape", [(0, 3), (2, 3), (3, 300, 1000)])
@pytest.mark.parametrize("dtype", [float, np.float32])
def test_it_is_what_numpy_gives(shape, dtype):
    made, expected = zeros(shape, dtype), np.zeros(shape, dtype)
    np.testing.assert_array_equal(made, expected)
    assert made.dtype == expected.dtype
    assert made.flags.writeable
    assert made.flags.c_contiguous


def test_arrays_do_not_share_memory_and_outlive_one_another():
    first, second = zeros((1 << 19,)), zeros((1 << 19,))
    first[:] = 1
    half = first[1 << 18 :]
    del first
    assert not second.any()
    assert half.all()

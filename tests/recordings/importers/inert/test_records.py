"""Plain data come out of pickles as they went in; arrays whose headers lie do not come out."""

import pickle
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from recordings.refusal import Refusal

KEPT = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
ARRAY = pickle.dumps(np.arange(6, dtype=np.int32).reshape(2, 3), 3)


def text(value):
    return b"X" + struct.pack("<I", len(value)) + value


def replaced(old, new):
    assert old in ARRAY
    return ARRAY.replace(old, new)


@pytest.mark.parametrize(
    "content",
    [
        replaced(b"K\x02K\x03\x86", b"K\x02K\x04\x86"),
        replaced(b"K\x02K\x03\x86", b"K\x02J\xff\xff\xff\x7f\x86"),
        replaced(b"K\x02K\x03\x86", b"J\xfe\xff\xff\xffJ\xfd\xff\xff\xff\x86"),
        replaced(b"K\x02K\x03\x86", b"K\x02N\x86"),
        replaced(b"i4", b"O8"),
        replaced(b"i4", b"V4"),
        replaced(b"i4", b"zz"),
        replaced(b"i4", b"i8"),
        pickle.dumps(np.array([{}, []], dtype=object), 4),
        pickle.dumps(np.zeros(3, dtype=[("a", "i4")]), 4),
        pickle.dumps(np.zeros(3, dtype="datetime64[s]"), 4),
        b"cnumpy\ndtype\n(tR.",
        b"cnumpy.core.multiarray\n_reconstruct\n(tR.",
        b"cnumpy.core.multiarray\nscalar\n(NNtR.",
        b"cbuiltins\ncomplex\n(" + text(b"one") + b"tR.",
        b"cnumpy\nmatrix\n(tR.",
    ],
)
def test_an_array_that_is_not_what_its_header_says_is_refused(tmp_path, content, read):
    with pytest.raises(Refusal, match="record 0 at byte 0"):
        read(tmp_path, content)


NUMBERS = st.sampled_from(["?", "i1", "<u2", ">i4", "u8", "f4", ">f8", "c16", "U3", "S2"])
PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False)
    | st.text(max_size=300)
    | st.complex_numbers(allow_nan=False),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4) | st.tuples(inner)
    ),
    max_leaves=20,
)


@KEPT
@given(value=PLAIN, protocol=st.integers(0, 5))
def test_plain_containers_come_out_as_they_went_in(tmp_path_factory, value, protocol, read):
    assert read(tmp_path_factory.mktemp("plain"), pickle.dumps(value, protocol)) == [value]


@KEPT
@given(
    dtype=NUMBERS,
    shape=st.lists(st.integers(0, 5), max_size=4),
    order=st.sampled_from("CF"),
    protocol=st.integers(0, 5),
    seed=st.integers(0, 99),
)
def test_arrays_come_out_as_they_went_in(tmp_path_factory, dtype, shape, order, protocol, seed, read):
    array = np.random.default_rng(seed).integers(0, 2, shape).astype(dtype, order=order)
    (back,) = read(tmp_path_factory.mktemp("array"), pickle.dumps(array, protocol))
    assert back.dtype == array.dtype
    np.testing.assert_array_equal(back, array)


def test_scalars_and_sets_come_out_as_they_went_in(tmp_path, read):
    value = [
        np.float32(1.5),
        np.int64(-3),
        np.bool_(True),
        np.str_("ab"),
        {1, 2},
        frozenset({3}),
        bytearray(b"xy"),
    ]
    for protocol in range(6):
        (back,) = read(tmp_path, pickle.dumps(value, protocol))
        assert back == value

"""Work that is shared out comes back in order, once, and with its first error."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.workers import in_parallel

pytestmark = pytest.mark.usefixtures("every_core")


@given(count=st.integers(0, 50), singly=st.booleans())
def test_results_are_in_order(count, singly):
    assert in_parallel(lambda i: i * i, range(count), singly=singly) == [i * i for i in range(count)]


@pytest.mark.parametrize("singly", [False, True])
def test_work_within_work_goes_one_by_one_in_its_thread(singly):
    def outer(_):
        return {threading.get_ident(), *in_parallel(lambda _: threading.get_ident(), range(9), singly=singly)}

    assert all(len(threads) == 1 for threads in in_parallel(outer, range(6), singly=singly))


@pytest.mark.parametrize("singly", [False, True])
def test_the_first_error_is_raised(singly):
    def work(i):
        if i >= 3:
            raise ValueError(i)

    with pytest.raises(ValueError, match="3"):
        in_parallel(work, range(20), singly=singly)

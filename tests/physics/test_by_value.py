"""What is given again, and what is worked out anew."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

from physics.by_value import kept_by_value
from physics.clock import Clock
from physics.pulse import ImpulseResponse


def counting(recent=3):
    """A function that gives the sum of what it is asked of; and of what it was asked."""
    asked = []

    @kept_by_value(recent)
    def total(*arguments):
        asked.append(arguments)
        return float(sum(np.sum(one) for one in arguments if not isinstance(one, Clock)))

    return total, asked


def clock(sigma=1.0, bins=16, zero_s=0.0):
    time_s = 1e-10 * np.arange(5)
    return Clock(1e-10, bins, np.array([zero_s]), ImpulseResponse(time_s, np.exp(-((np.arange(5) - 2) ** 2) / sigma)))


def test_equal_arguments_are_asked_once_and_others_anew():
    total, asked = counting(10)
    array = np.arange(6.0)
    for one in (array, array.copy(), array[::-1][::-1]):
        assert total(one, 2.0) == 17
    assert len(asked) == 1
    for other in ((array, 3.0), (array.reshape(2, 3), 2.0), (array.astype(np.float32), 2.0), (array + 1e-15, 2.0)):
        total(*other)
    # One and the next number that there is are not the same, nor are shapes and kinds.
    assert len(asked) == 5


def test_what_was_changed_in_place_is_asked_anew():
    total, asked = counting()
    array = np.arange(6.0)
    assert total(array) == 15
    array[0] = 5
    assert total(array) == 20
    assert len(asked) == 2


def test_clocks_are_the_same_whose_pulses_and_bins_are():
    total, asked = counting(10)
    for one in (clock(), clock(), clock(zero_s=1e-9)):
        total(one)
    assert len(asked) == 1
    for other in (clock(sigma=2.0), clock(bins=17)):
        total(other)
    assert len(asked) == 3


def test_only_the_latest_are_kept():
    total, asked = counting(3)
    for one in (1.0, 2.0, 3.0, 1.0, 4.0, 1.0, 2.0):
        total(one)
    # The second was the one that nobody had asked for of late.
    assert [one for (one,) in asked] == [1.0, 2.0, 3.0, 4.0, 2.0]


def test_errors_are_not_kept():
    @kept_by_value(2)
    def refusing(one):
        raise ValueError(one)

    for _ in range(2):
        with pytest.raises(ValueError, match="7"):
            refusing(7.0)


def test_many_at_once():
    total, _ = counting(2)
    found = []

    def ask(i):
        found.extend(total(np.full(3, float(j % 5))) == 3.0 * (j % 5) for j in range(i, i + 50))

    threads = [threading.Thread(target=ask, args=(i,)) for i in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert len(found) == 200
    assert all(found)


def test_what_is_kept_cannot_be_written_to():
    @kept_by_value(2)
    def doubled(one):
        return SimpleNamespace(twice=2 * one, name="twice")

    found = doubled(np.arange(3.0))
    with pytest.raises(ValueError, match="read-only"):
        found.twice[0] = 7
    assert doubled(np.arange(3.0)) is found

"""What was asked of a simulation is counted once, whoever asks."""

import numpy as np

from mismatch.work import MOST_RENDERINGS, Work


def test_a_recording_and_its_parts_are_counted_together_from_whatever_thread(drawn):
    simulation = drawn(1)
    part = simulation.of(np.array([0, 2, 3]))
    part.each(lambda gain: part.expected(gain), np.linspace(50.0, 90.0, 40))
    simulation.expected(70.0)
    # What is kept counts as well: which thread keeps what is chance.
    simulation.expected(70.0)
    assert simulation.work.renderings == part.work.renderings == 42


def test_enough_is_more_than_stated():
    assert not Work(MOST_RENDERINGS).enough
    assert Work(MOST_RENDERINGS + 1).enough

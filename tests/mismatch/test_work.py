"""Work is counted by size, and maps that are read zone by zone in each frame cost what that takes."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch.work import CARRYING, KNOT, LEAST, LOOKING, MOST_RENDERINGS, PIXEL, READING, WHOLE, Work, size_of
from physics.effects import find_effect


@pytest.mark.parametrize(("numbers", "part"), [(1, LEAST), (WHOLE // 2, 0.5), (WHOLE, 1.0), (5 * WHOLE, 1.0)])
def test_a_rendering_counts_by_its_size(numbers, part):
    work = Work()
    for _ in range(10):
        work.add(numbers)
    assert work.renderings == pytest.approx(10 * part)
    assert not work.enough
    work.add(numbers, read=MOST_RENDERINGS * WHOLE // READING)
    assert work.enough
    assert not work.far_beyond
    work.add(numbers, read=MOST_RENDERINGS * WHOLE // READING)
    assert work.far_beyond


def test_maps_that_are_drawn_anew_cost_all_their_pixels_once(drawn):
    simulation = replace(drawn(3), work=Work())
    blur = find_effect("footprint_blur")
    for variance, once in ((0.0, 0), (20.0, 1), (20.0, 0), (30.0, 1), (20.0, 0)):
        before = simulation.work.renderings
        simulation.expected(100.0, (blur.at(variance=variance),))
        drawn_anew = once * simulation.footprints.field.table.size / WHOLE
        assert simulation.work.renderings - before == pytest.approx(LEAST + drawn_anew)


def test_light_that_is_carried_costs_ten_renderings_once(drawn):
    simulation, lag = replace(drawn(3), work=Work()), find_effect("time_lag")
    for values, carried in (({}, 0), ({"carried": 1.0}, CARRYING), ({"carried": 1.0}, 0), ({"carried": 0.0}, 0)):
        before = simulation.work.renderings
        simulation.expected(100.0, (lag.at(lag=0.01, **values),))
        assert simulation.work.renderings - before == pytest.approx(LEAST * (1 + carried))
    assert not lag.carries(lag.at(lag=0.0, carried=1.0).values)


def test_maps_that_zones_and_frames_move_cost_what_is_read(drawn):
    simulation = drawn(3)

    def cost(*effects):
        asked = replace(simulation, work=Work())
        asked.expected(100.0, effects)
        return asked.work.renderings

    shift, parallax = find_effect("footprint_shift"), find_effect("parallax").at(x=0.01)
    apart = shift.at(x=np.array([1.0, 2.0, 0.0, 3.0]))
    read = READING * simulation.light.range_m.size * 4 / WHOLE
    assert cost() == cost(apart) == cost(parallax) == cost(shift.at(x=3.0, slip_x=2.0)) == LEAST
    assert cost(apart, parallax) == pytest.approx(LEAST + read)
    assert cost(shift.at(x=np.array([1.0, 2.0, 0.0, 3.0]), slip_x=2.0)) == pytest.approx(LEAST + read)


def test_to_look_for_pulses_costs_by_their_length(drawn):
    """In every cell, for each bin that one spans; steady ones, and none at all, cost no more than other light."""
    simulation, other = drawn(3), find_effect("interference")
    bins = np.ptp(simulation.clock.pulse.time_s) / simulation.clock.bin_width_s
    for values, looked in (({"roaming": 50.0}, 1), ({"counts": 50.0}, 0), ({}, 0)):
        asked = replace(simulation, work=Work())
        asked.expected(100.0, (other.at(**values),))
        due = LEAST + looked * LOOKING * simulation.counts.size * bins / WHOLE
        assert asked.work.renderings == pytest.approx(due)


def test_what_moves_light_costs_by_the_finer_knots(drawn):
    """Pixels, and knots of each zone's lattice in each frame: of those that light is moved on, where it is."""
    simulation, sizes = drawn(3), []

    class Asked(Work):
        def add(self, size, read=0, looked=0.0):
            sizes.append(size)

    asked, rows = replace(simulation, work=Asked()), simulation.counts.shape[0] * simulation.counts.shape[1]
    for effects, clock in (((), asked.clock), ((find_effect("range_walk").at(walk=1e-11),), asked.clock.finer())):
        asked.expected(100.0, effects)
        assert sizes[-1] == size_of(asked.light.range_m.size, rows * clock.lattice.size)
    assert size_of(1, 1) == PIXEL + KNOT

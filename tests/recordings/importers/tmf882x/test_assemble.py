"""Lines put together: every mode, counters that wrap, and what may not be put together."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.importers.tmf882x.assemble import Assembler
from recordings.refusal import Refusal

MODES = {"3x3": ((3, 3), 1), "4x4": ((4, 4), 2), "3x6": ((6, 3), 2), "8x8": ((8, 8), 8)}


def taken(assembler, lines, host_s=0.0):
    """Measurements out of lines."""
    return [got for line in lines if (got := assembler.push(line, host_s)) is not None]


def random(mode, seed=0, high=2**20):
    rng = np.random.default_rng(seed)
    (rows, columns), bursts = MODES[mode]
    return rng.integers(0, high, (rows * columns, 128)), rng.integers(0, high, (bursts, 128))


@pytest.mark.parametrize("mode", MODES)
@settings(max_examples=8)
@given(seed=st.integers(0, 2**16), number=st.integers(0, 63), high=st.sampled_from([2, 300, 70_000, 2**24]))
def test_every_mode_is_read_back(firmware, mode, seed, number, high):
    counts, reference = random(mode, seed, high)
    (got,) = taken(Assembler(mode), firmware.measurement(mode, counts, reference, number), 5.0)
    assert np.array_equal(got.counts, counts)
    assert np.array_equal(got.reference, reference)
    assert got.counts.dtype == np.uint32
    assert (got.number, got.host_s, got.missed) == (number, 5.0, 0)


@pytest.mark.parametrize("mode", MODES)
def test_two_objects_of_each_zone(firmware, mode):
    """Records count zones 1 to 9, 10 to 18, then their second objects; each sub-capture of 8x8 has its own."""
    assembler, lines, expected = Assembler(mode), [], {}
    for sub in range(4 if mode == "8x8" else 1):
        pairs = [(100 * sub + record, record) for record in range(36)]
        for slot in range(1 if mode == "3x3" else 2):
            lines += firmware.histogram_lines(np.zeros((10, 128), int))
            for channel in range(1, 9 if mode in ("4x4", "8x8") else 10):
                first = pairs[9 * slot + channel - 1], pairs[18 + 9 * slot + channel - 1]
                expected[firmware.place(mode, sub, slot, channel)] = first
        lines.append(firmware.result_line(sub, distances=pairs))
    (got,) = taken(assembler, lines)
    for zone, objects in expected.items():
        assert list(zip(got.distance_mm[zone], got.confidence[zone], strict=True)) == list(objects)
    assert len(expected) == len(got.counts)


@pytest.mark.parametrize(("mode", "wrap"), [("3x3", 256), ("8x8", 64)])
def test_the_number_counts_on(firmware, mode, wrap):
    assembler = Assembler(mode)
    zero = np.zeros((64, 128), int)
    numbers = [wrap - 2, wrap - 1, wrap, wrap + 1, wrap + 5, wrap + 6]
    got = [taken(assembler, firmware.measurement(mode, zero, zero, number)) for number in numbers]
    # After a gap the first is not trusted: a result line may have been lost with what came before it.
    assert [len(one) for one in got] == [1, 1, 1, 1, 0, 1]
    assert [one[0].number for one in got if one] == [*numbers[:4], wrap + 6]
    assert [one[0].missed for one in got if one] == [0, 0, 0, 0, 4]
    assert (assembler.tally.frames, assembler.tally.dropped, assembler.tally.missed) == (5, 1, 4)


def test_the_clock_counts_on(firmware):
    assembler, zero = Assembler(), np.zeros((10, 128), int)
    step = 150_000_000  # 30 s
    got = []
    for number in range(90):
        lines = [*firmware.histogram_lines(zero), firmware.result_line(number, tick=(number * step + 2**31 - 7) | 1)]
        got += taken(assembler, lines, 30.0 * number)
    times = np.array([one.tick_s for one in got])
    assert np.diff(times) == pytest.approx(30.0, abs=1e-6)


def test_a_pause_longer_than_the_clock_is_known_by_the_host(firmware):
    assembler, zero = Assembler(), np.zeros((10, 128), int)
    times = [
        taken(assembler, [*firmware.histogram_lines(zero), firmware.result_line(n, tick=int(5e6 * s) | 1)], s)[0].tick_s
        for n, s in enumerate([100.0, 2500.0])
    ]
    assert times[1] - times[0] == pytest.approx(2400, abs=1e-3)


def test_a_tick_that_says_it_is_not_valid_is_unknown(firmware):
    (got,) = taken(Assembler(), [*firmware.histogram_lines(np.zeros((10, 128), int)), firmware.result_line(0, tick=8)])
    assert np.isnan(got.tick_s)


def test_a_result_of_a_later_measurement_is_not_bound(firmware):
    """From a result line to the end of the next measurement's histograms everything is lost: 31 lines."""
    one, two = (firmware.histogram_lines(np.full((10, 128), n)) for n in (1, 2))
    assembler = Assembler()
    lines = [*one, firmware.result_line(7), *one, *two, firmware.result_line(9), *two, firmware.result_line(10)]
    del lines[61:91]
    got = taken(assembler, lines)
    assert [frame.number for frame in got] == [7, 10]
    assert assembler.tally.reasons["its number does not follow"] == 1


def test_the_halves_of_two_measurements_make_none(firmware):
    one, two = (firmware.histogram_lines(np.full((10, 128), n)) for n in (1, 2))
    lines = [*one, firmware.result_line(7), *one[:12], *two[12:], firmware.result_line(9)]
    assert [frame.number for frame in taken(Assembler(), lines)] == [7]


def test_electrical_calibration_is_not_mixed_in(firmware):
    raw, cal = (firmware.histogram_lines(np.full((10, 128), n), kind) for n, kind in ((1, "Raw"), (2, "Cal")))
    mixed = [line for pair in zip(raw, cal, strict=True) for line in pair]
    assembler = Assembler()
    (got,) = taken(assembler, [*mixed, firmware.result_line(0)])
    assert (got.counts == 1).all()
    assert assembler.tally.calibration == 1


def test_a_bare_result_line_ends_a_measurement_that_says_nothing(firmware):
    one = firmware.histogram_lines(np.ones((10, 128), int))
    got = taken(Assembler(), [b"Active range: 6E", *one, b"#Obj", *one, b"#Obj"])
    assert [frame.number for frame in got] == [0, 1]
    assert got[0].distance_mm is None
    assert np.isnan([got[0].temperature_c, got[0].tick_s]).all()


def test_a_result_line_cut_to_its_name_is_none_where_others_say_more(firmware):
    one = firmware.histogram_lines(np.ones((10, 128), int))
    assembler = Assembler()
    got = taken(assembler, [*one, firmware.result_line(1), *one, b"#Obj", *one, firmware.result_line(3)])
    assert [frame.number for frame in got] == [1, 3]
    assert assembler.tally.damaged == 1


def test_a_first_result_cut_to_its_name_says_nothing_of_its_zones(firmware):
    zero = np.zeros((64, 128), int)
    lines = firmware.measurement("8x8", zero, zero, 0)
    lines[60] = b"#Obj"
    (got,) = taken(Assembler("8x8"), lines)
    assert got.distance_mm is None


def test_partial_histograms_are_no_whole_ones(firmware):
    partial = [f"#Prt,65,{index},126,1,1".encode() for index in range(30)]
    assembler = Assembler()
    assert taken(assembler, [*partial, firmware.result_line(0)]) == []
    assert assembler.tally.reasons == {"partial histograms": 1}


def test_starting_anew_forgets_what_was_begun(firmware):
    one = firmware.histogram_lines(np.ones((10, 128), int))
    lines = [*one[:9], b"TMF882x state=stopped", b"TMF882x state=measure", *one, firmware.result_line(0)]
    assembler = Assembler()
    assert len(taken(assembler, [*lines, *lines, *lines])) == 3
    assert assembler.tally.dropped == 0
    assembler.reset()
    (got,) = taken(assembler, lines)
    assert (got.number, got.missed) == (768, 0)


def test_lines_of_two_sensors_make_no_measurement(firmware):
    one, two = (firmware.histogram_lines(np.ones((10, 128), int), address=a) for a in (65, 66))
    assembler = Assembler()
    assert taken(assembler, [*one[:5], *two[5:], firmware.result_line(0), *two, firmware.result_line(1)]) == []
    assert assembler.tally.reasons == {"lines of two sensors": 2}


def test_no_count_is_above_the_number_of_shots(firmware):
    counts = np.ones((10, 128), int)
    counts[4, 9] = 10 * 1024 + 1
    lines = [*firmware.histogram_lines(counts), firmware.result_line(0)]
    assembler = Assembler(kilo_iterations=10)
    assert taken(assembler, lines) == []
    assert assembler.tally.reasons == {"a count above the number of laser shots": 1}
    assert len(taken(Assembler(kilo_iterations=11), lines)) == 1


def test_an_unknown_mode_is_refused():
    with pytest.raises(Refusal, match="5x5"):
        Assembler("5x5")

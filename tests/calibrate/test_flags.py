import numpy as np

from calibrate.flags import Flag, clipped, describe, flag_samples
from calibrate.responses import responses
from calibrate.window import Window

WINDOW = Window(4, 11)


def scan(frames=40, zones=2, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(16)
    pulse = 20_000 * np.exp(-0.5 * ((t - 7.3) / 1.2) ** 2)
    return (
        rng.poisson(pulse + 50, (frames, zones, 16)).astype(np.uint32),
        rng.poisson(50.0, (frames, zones, 16)).astype(np.uint32),
    )


def flags_of(counts, background, cycles=None, outliers=None):
    frames = np.arange(len(counts))[:, None]
    found = responses(counts, background, WINDOW)
    outliers = np.zeros(found.value.shape, bool) if outliers is None else outliers
    return flag_samples(counts, background, cycles, frames, WINDOW, found, outliers)


def test_a_clean_scan_has_no_flags():
    assert not flags_of(*scan(), cycles=np.array(550_000 * 100)).any()


def test_each_fault_gets_its_flag_and_no_other():
    counts, background = scan()
    np.minimum(counts[3:6, 0], 9_000, out=counts[3:6, 0])
    counts[10, 1] = background[10, 1] // 2 + 20
    counts[12, 0] = np.roll(counts[12, 0], 4)
    background[14, 1, 5] += 60_000
    expected = np.zeros((2, 40), int)
    expected[1, 10] = Flag.NO_SIGNAL
    expected[0, 12] = Flag.WINDOW_EDGE
    expected[1, 14] = Flag.BACKGROUND_BRIGHTER
    np.testing.assert_array_equal(flags_of(counts, background), expected)


def test_a_clipped_counter():
    counts, background = scan()
    limit = np.uint32(15_000)
    np.minimum(counts, limit, out=counts)
    hit = clipped(counts, WINDOW)
    np.testing.assert_array_equal(hit, (counts == limit).any(axis=2))
    assert hit.all()
    assert (flags_of(counts, background) & Flag.SATURATED).all()


def test_pile_up_needs_the_number_of_shots():
    counts, background = scan()
    events = counts.sum(axis=2).astype(float)
    shots = events.max(axis=1) / 0.06
    shots[:20] *= 2
    piled = (flags_of(counts, background, shots) & Flag.PILE_UP) > 0
    np.testing.assert_array_equal(piled, (events > 0.05 * shots[:, None]).T)
    assert piled.any(axis=0)[20:].all()
    assert not piled[:, :20].any()


def test_outliers_pass_through_and_all_are_counted():
    outliers = np.zeros((2, 40), bool)
    outliers[1, 7] = True
    flags = flags_of(*scan(), outliers=outliers)
    assert flags[1, 7] == Flag.OUTLIER
    assert describe(flags) == {"outlier": 1}

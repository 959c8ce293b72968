import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.responses import responses
from calibrate.window import Window


def loop(counts, background, first, last):
    """Eq. 2, one number at a time in Python integers."""
    frames, zones, _ = counts.shape
    found = np.zeros((zones, frames))
    for k in range(frames):
        for p in range(zones):
            found[p, k] = max(max(int(counts[k, p, t]) - int(background[k, p, t]), 0) for t in range(first, last + 1))
    return found


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([np.uint8, np.uint16, np.uint32, np.uint64]),
    st.integers(0, 7),
    st.integers(0, 7),
)
def test_equation_2(seed, kind, a, b):
    rng = np.random.default_rng(seed)
    counts, background = (rng.integers(0, min(np.iinfo(kind).max, 2**52), (4, 3, 8), dtype=kind) for _ in range(2))
    first, last = min(a, b), max(a, b)
    found = responses(counts, background, Window(first, last))
    np.testing.assert_array_equal(found.value, loop(counts, background, first, last))
    assert ((found.peak_bin >= first) & (found.peak_bin <= last)).all()
    assert (found.sigma > 0).all()


def test_without_background_nothing_is_subtracted():
    counts = np.random.default_rng(0).integers(0, 99, (5, 2, 6), dtype=np.uint32)
    np.testing.assert_array_equal(responses(counts, None, Window(1, 4)).value, counts[:, :, 1:5].max(axis=2).T)


def test_published_files_agree_with_each_other(published_maps):
    """The unsubtracted maps bound the subtracted ones: max(a − b) ≤ max(a) for b ≥ 0."""
    with_, without = (np.load(published_maps / f"spad_calib_3x3_longrange_bins15_35{s}.npz") for s in ("", "_nobgsub"))
    assert (with_["responses"] <= without["responses"]).all()


@pytest.mark.parametrize("repeats", [1, 4])
def test_errors_are_those_of_repeated_scans(repeats):
    """Scatter of 400 simulated scans with gain noise, against the errors each states."""
    rng = np.random.default_rng(1)
    level, gain_noise, scans = 20_000.0, 0.0 if repeats == 1 else 0.02, 400
    frames = np.arange(30 * repeats).reshape(30, repeats)
    shape = np.array([0.1, 1.0, 0.3])
    values, sigmas = [], []
    for _ in range(scans):
        gain = 1 + gain_noise * rng.standard_normal((30 * repeats, 1, 1))
        counts = rng.poisson(level * gain * shape + 500).astype(np.uint32)
        found = responses(counts, rng.poisson(500.0, counts.shape).astype(np.uint32), Window(0, 2), frames)
        values.append(found.value[0])
        sigmas.append(found.sigma[0])
    assert np.mean(values) == pytest.approx(level, rel=2e-3)
    assert np.mean(sigmas) == pytest.approx(np.std(values), rel=0.05)


def test_noise_stays_below_its_limit():
    rng = np.random.default_rng(2)
    counts, background = (rng.poisson(300.0, (2000, 2, 21)).astype(np.uint32) for _ in range(2))
    found = responses(counts, background, Window(0, 20))
    above = (found.value > found.noise_limit).mean()
    assert above < 2e-3
    bright = responses(counts + np.uint32(400), background, Window(0, 20))
    assert (bright.value > bright.noise_limit).all()


def test_a_zone_without_counts_has_an_error_all_the_same():
    counts = np.zeros((3, 1, 4), np.uint32)
    found = responses(counts, counts, Window(0, 3))
    assert (found.value == 0).all()
    assert (found.sigma >= 1).all()

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.window import Window, choose_window
from recordings.refusal import Refusal


def scan(rng, centre, spread=0.0, frames=300, zones=3, bins=64, seen=0.2, light=5000.0, background=True, extra=None):
    """Counts with a pulse of three bins about `centre` in a share of the captures, over a wall and a pedestal."""
    t = np.arange(bins)
    wall = 50 + 3000 * np.exp(-0.5 * ((t - 45) / 1.5) ** 2)
    at = centre + spread * rng.standard_normal((frames, 1, 1))
    lit = (rng.random((frames, zones, 1)) < seen) * light * rng.random((frames, zones, 1))
    patch = lit * np.exp(-0.5 * ((t - at) / 1.2) ** 2)
    other = 0 if extra is None else extra(frames, zones, t, rng)
    counts = rng.poisson(wall + patch + other).astype(np.uint32)
    dark = rng.poisson(np.broadcast_to(wall, counts.shape)).astype(np.uint32)
    return counts, dark if background else None


@pytest.mark.parametrize("background", [True, False])
@given(st.integers(0, 2**32 - 1), st.integers(4, 35))
def test_holds_the_pulse(background, seed, centre):
    window = choose_window(*scan(np.random.default_rng(seed), centre, 0.3, background=background))
    assert window.first <= centre <= window.last
    assert len(window) <= 16
    assert window.share > 0.99
    assert window.chosen == "data"


def test_follows_a_patch_whose_range_varies():
    window = choose_window(*scan(np.random.default_rng(0), 20, 3.0))
    assert window.first <= 14
    assert window.last >= 26


def test_weaker_light_elsewhere_is_reported_not_chosen():
    def arm(frames, zones, t, rng):
        return 400 * np.exp(-0.5 * ((t - 8) / 1.0) ** 2) * (rng.random((frames, zones, 1)) < 0.5)

    window = choose_window(*scan(np.random.default_rng(0), 28, 0.3, extra=arm))
    assert window.first > 12
    assert any(first <= 8 <= last for first, last, _ in window.others)


def test_no_light_of_a_patch_is_refused():
    counts, dark = scan(np.random.default_rng(0), 20, seen=0)
    with pytest.raises(Refusal, match="no capture shows more light"):
        choose_window(counts, dark)


@given(st.integers(-5, 70), st.integers(-5, 70))
def test_a_window_outside_the_bins_is_refused(first, last):
    if 0 <= first <= last < 64:
        assert len(Window.checked(first, last, 64)) == last - first + 1
    else:
        with pytest.raises(Refusal, match="window"):
            Window.checked(first, last, 64)

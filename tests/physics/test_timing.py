"""Timing against distances and ratios that other measurements of the sensor give."""

import numpy as np
import pytest

from physics.pulse import arrival
from physics.timing import tmf882x_timing
from recordings.refusal import Refusal

LONG, SHORT = tmf882x_timing("long", 9), tmf882x_timing("short", 9)


@pytest.mark.parametrize(("timing", "bins_per_metre"), [(LONG, (16.7, 18)), (SHORT, (71, 73.5))])
def test_bins_per_metre(timing, bins_per_metre):
    low, high = bins_per_metre
    moved = (arrival(1.0, 0.0) - arrival(0.0, 0.0)) / timing.bin_width_s
    assert low < moved < high


def test_a_target_at_two_metres_peaks_near_bin_50():
    """Figure 23 of the datasheet: crosstalk in bin 15, target at 2 m around bin 50."""
    assert np.allclose(LONG.time_zero_s / LONG.bin_width_s, 15.3, atol=0.2)
    pulse = LONG.pulse.in_bins(arrival(2.0, LONG.time_zero_s), LONG.bins, LONG.bin_width_s)
    assert set(pulse.argmax(axis=1)) <= {50, 51}


def test_delays_between_channels_are_some_50_ps_in_both_modes():
    for timing in (LONG, SHORT):
        assert 20e-12 < np.ptp(timing.time_zero_s) < 120e-12


def test_crosstalk():
    assert (LONG.crosstalk / SHORT.crosstalk).mean() == pytest.approx(3.57, abs=0.05)
    assert LONG.energy / SHORT.energy == pytest.approx(3.57)
    assert ((LONG.crosstalk > 2e-4) & (LONG.crosstalk < 3e-3)).all()


def test_short_pulse_is_as_wide_as_histograms_of_a_plane_show():
    """TMF8820 histograms of a plane: about 2.5 bins at half the peak, 1 to 2 % of it ten bins later."""
    bins = SHORT.pulse.in_bins(np.array(20.5 * SHORT.bin_width_s), 128, SHORT.bin_width_s)
    assert (bins > 0.5 * bins.max()).sum() in (2, 3)
    assert 0.005 < bins[bins.argmax() + 10] / bins.max() < 0.03


def test_more_zones_use_the_channels_again():
    timing = tmf882x_timing("long", 16)
    assert timing.time_zero_s.shape == timing.crosstalk.shape == (16,)
    assert (timing.time_zero_s[9:] == timing.time_zero_s[:7]).all()


def test_unknown_mode_is_refused():
    with pytest.raises(Refusal, match="range mode is 'medium', expected long or short"):
        tmf882x_timing("medium", 9)

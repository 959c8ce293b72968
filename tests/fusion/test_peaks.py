import numpy as np
import pytest

from fusion.peaks import peak_ranges
from recordings.refusal import Refusal

C = 299_792_458.0


def histogram(sensor, places):
    """Four zones, pedestal 3, and 1000 counts in each bin of `places`."""
    counts = np.full((4, sensor.bins), 3.0)
    counts[:, places] += 1000
    return counts


def expected_range(sensor, bins):
    """Of a centroid at `bins`, written out."""
    delay = sum(t * p for t, p in zip(sensor.pulse.time_s, sensor.pulse.probability, strict=True))
    return (bins * sensor.bin_width_s - sensor.time_zero_s - delay) * C / 2


@pytest.mark.parametrize(("places", "bins"), [([20], 20.5), ([20, 21], 21.0), ([47], 47.5), ([20, 30], 20.5)])
def test_a_peak_is_the_centroid_about_the_strongest_bin(rig, places, bins):
    counts = histogram(rig.sensor, places)
    np.testing.assert_allclose(peak_ranges(counts, rig.sensor), expected_range(rig.sensor, bins), rtol=1e-9)


def test_it_finds_a_wall_to_a_part_of_a_bin(rig):
    light = np.zeros((1, 4, len(rig.response.range_m)))
    light[..., 30] = 1000
    found = peak_ranges(rig.response.linear(light, np.full((1, 4), 3.0)), rig.sensor)
    np.testing.assert_allclose(found, rig.response.range_m[30], atol=0.01)


def test_where_no_bin_stands_out_there_is_none(rig):
    counts = np.random.default_rng(0).poisson(3, (50, 4, 48))
    assert np.isnan(peak_ranges(counts, rig.sensor)).mean() > 0.95


def test_other_counts_are_refused(rig):
    with pytest.raises(Refusal, match=r"expected \(..., 4, 48\)"):
        peak_ranges(np.zeros((4, 40)), rig.sensor)

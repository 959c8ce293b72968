"""Distance of the published plane: what the sensor says itself, and what its histograms say."""

import numpy as np
import pytest

from calibrate.impulse import fit_impulse
from calibrate.impulse.sweep import Sweep
from calibrate.ranging import plane_templates, ranges
from calibrate.ranging.centroid import centroid_bins
from calibrate.ranging.straighten import CURVES, LINES, SHARED, straighten
from recordings.files import load, maps_of

# 4000 k shots, the sensor's longest setting.
SHOTS = 4.096e6
# Frames of 30 to 400 mm.
FIRST, LAST = 10, 159


@pytest.fixture(scope="module")
def recording(shared_data):
    path = shared_data / "tmf8820_plane_sweep" / "distance_data.json"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    return load(path), maps_of(path)


def errors_mm(readings, truth, even, freedom):
    """Root mean square of odd frames' errors."""
    wrong = straighten(readings, truth, even, freedom).metres[~even] - truth[~even, None]
    return 1e3 * np.sqrt(np.square(wrong).mean())


def test_the_sensors_own_distances_and_a_centroid_are_as_published_figures_have_it(recording):
    found = recording[0]
    truth = np.asarray(found.depth_m)[FIRST:LAST, 0, 0].astype(float)
    even = np.arange(FIRST, LAST) % 2 == 0
    chip = np.array(found.meta["on_chip"]["depths_1"][FIRST:LAST]) / 1e3
    assert errors_mm(chip, truth, even, LINES) == pytest.approx(1.31, abs=0.01)
    centroid = centroid_bins(np.asarray(found.counts)[FIRST:LAST])
    assert errors_mm(centroid, truth, even, LINES) == pytest.approx(1.59, abs=0.01)


@pytest.mark.slow
def test_histograms_tell_the_distance_several_times_better(recording):
    found, maps = recording
    sweep = Sweep.of(found, maps, SHOTS).part(np.arange(FIRST, LAST))
    truth = np.asarray(found.depth_m)[FIRST:LAST, 0, 0].astype(float)
    even = np.arange(FIRST, LAST) % 2 == 0
    estimate = fit_impulse(sweep.part(np.flatnonzero(even)), per_zone=True)
    told = ranges(sweep.counts, plane_templates(sweep, estimate, np.arange(0.015, 0.44, 0.0015)), SHOTS)
    assert np.isfinite(told.range_m).all()
    assert errors_mm(told.range_m, truth, even, LINES) < 1.05
    assert errors_mm(told.range_m, truth, even, SHARED) < 0.25
    assert errors_mm(told.range_m, truth, even, CURVES) < 0.18

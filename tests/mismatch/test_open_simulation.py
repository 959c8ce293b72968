"""A recording becomes a simulation, or is refused in one sentence."""

import numpy as np
import pytest

from mismatch.blocks import halves
from mismatch.open_simulation import open_simulation, simulation_of
from physics.geometry import incidence_cosine, incidence_cosine_across_edges
from physics.sensor import SensorModel
from recordings.files import save
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps
from recordings.refusal import Refusal

from .conftest import BACKGROUND, BINS, COLUMNS, CYCLES, FRAMES, INTRINSICS, ROWS, ZONES, depths


@pytest.fixture(scope="module")
def counts(rig):
    return np.random.default_rng(1).poisson(rig.expected())


def refused(recording, maps, *words):
    """The sentence, which holds these words."""
    with pytest.raises(Refusal) as caught:
        simulation_of(recording, maps, name="case.npz")
    sentence = str(caught.value)
    assert "\n" not in sentence
    assert "expected" in sentence
    for word in words:
        assert word in sentence
    return sentence


def test_it_is_the_model_of_the_recording(rig, counts):
    simulation, sensor, notes = simulation_of(rig.recording(counts), rig.maps)
    np.testing.assert_allclose(simulation.expected(rig.gain), rig.expected(), rtol=1e-6)
    np.testing.assert_array_equal(simulation.counts, counts)
    assert sensor.bins == BINS
    assert notes == ()
    assert (simulation.light.laser_cycles == CYCLES).all()


def test_it_is_the_same_from_files(rig, counts, tmp_path):
    save(rig.recording(counts), tmp_path / "seen.npz")
    save_maps(rig.maps, tmp_path / "maps.npz")
    simulation, _, _ = open_simulation(tmp_path / "seen.npz", tmp_path / "maps.npz")
    np.testing.assert_allclose(simulation.expected(rig.gain), rig.expected(), rtol=1e-5)
    with pytest.raises(Refusal, match="carries no response maps, expected them by --calibration"):
        open_simulation(tmp_path / "seen.npz")


def test_part_of_it_is_the_model_of_those_frames(rig, counts):
    simulation, _, _ = simulation_of(rig.recording(counts), rig.maps)
    chosen = np.array([3, 4, 11, 20])
    np.testing.assert_allclose(simulation.of(chosen).expected(rig.gain), rig.expected()[chosen], rtol=1e-6)


def test_a_still_scene_may_have_one_depth_image(rig, counts):
    simulation, _, _ = simulation_of(
        rig.recording(counts, depth_m=np.full((ROWS, COLUMNS), 0.8), reflectance=None), rig.maps
    )
    assert simulation.light.range_m.shape == (FRAMES, ROWS, COLUMNS)


def test_a_zone_that_counts_nothing_is_left_out_with_a_note(rig, counts):
    silent = counts.copy()
    silent[:, 2] = 0
    simulation, _, notes = simulation_of(rig.recording(silent), rig.maps)
    assert any("zone 2" in note for note in notes)
    assert simulation.dead.tolist() == [False, False, True, False]
    assert (simulation.expected(rig.gain)[:, 2] == 0).all()


@pytest.mark.parametrize("name", ["depth_m", "intrinsics"])
def test_geometry_that_is_missing_is_refused(rig, counts, name):
    refused(rig.recording(counts, **{name: None}), rig.maps, "case.npz", name, "missing")


def test_one_frame_is_refused(rig, counts):
    one = {n: getattr(rig.recording(counts), n)[:1] for n in ("timestamp_s", "depth_m", "reflectance")}
    refused(rig.recording(counts[:1], **one), rig.maps, "case.npz", "1 frame", "2 or more")


def test_counts_of_nothing_are_refused(rig, counts):
    refused(rig.recording(np.zeros_like(counts)), rig.maps, "case.npz", "counts are 0")


def test_maps_of_other_zones_are_refused(rig, counts):
    maps = rig.maps
    other = ResponseMaps(maps.responses[:, :1], maps.xs, maps.ys, maps.cap_ids)
    refused(rig.recording(counts), other, "case.npz", "2 x 2", "2 x 1")


def test_depth_that_is_nowhere_known_is_refused(rig, counts):
    refused(rig.recording(counts, depth_m=np.full((FRAMES, ROWS, COLUMNS), np.nan)), rig.maps, "depth_m", "NaN")


def test_an_impulse_response_that_is_missing_is_estimated_from_frames_that_choose(rig, counts):
    recording = rig.recording(counts, irf=None, irf_time_s=None)
    simulation, sensor, notes = simulation_of(recording, rig.maps)
    assert any("estimated from 12 frames" in note for note in notes)
    assert "estimated" in sensor.sources["pulse"]
    # Gain and pedestal of every frame were free there; here one gain must do, so the fit is only roughly that good.
    mean = simulation.expected(1.0) - simulation.background[:, None]
    gain = (counts - simulation.background[:, None]).sum() / mean.sum()
    assert np.corrcoef((gain * mean).ravel(), counts.ravel())[0, 1] > 0.97


@pytest.mark.parametrize("level", [0.0, 0.4])
def test_a_pedestal_that_nobody_recorded_is_what_dark_bins_hold(rig, level):
    """By the mean of bins to which no pulse comes, which the estimate does not single out."""
    mean = rig.expected() - BACKGROUND[:, None]
    counts = np.random.default_rng(6).poisson(mean + level)
    recording = rig.recording(counts, irf=None, irf_time_s=None, background_counts=None)
    simulation, sensor, _ = simulation_of(recording, rig.maps)
    chosen, _ = halves(FRAMES)
    for zone in range(ZONES):
        dark = (mean[chosen, zone] < 1e-9).ravel()
        assert dark.sum() > 100
        held = counts[chosen, zone].ravel()[dark]
        error = np.sqrt(max(held.sum(), 1)) / dark.sum()
        assert simulation.background[zone] == pytest.approx(held.mean(), abs=3 * error)
    np.testing.assert_array_equal(sensor.background_counts, simulation.background)


@pytest.mark.parametrize("level", [0.0, 0.3])
def test_a_pedestal_is_no_more_than_bins_hold_to_which_no_light_has_come_yet(rig, level):
    """Light that comes late, as by a tail whose end nobody estimated, is in the last bins alone."""
    mean = rig.expected() - BACKGROUND[:, None] + level
    late = np.arange(mean.shape[-1]) >= 42
    counts = np.random.default_rng(6).poisson(mean + 1.5 * late)
    recording = rig.recording(counts, irf=None, irf_time_s=None, background_counts=None)
    simulation = simulation_of(recording, rig.maps)[0]
    early = 10 * len(halves(FRAMES)[0])
    np.testing.assert_allclose(simulation.background, level, atol=4 * np.sqrt((level + 0.1) / early))


def test_a_background_that_is_recorded_stays_as_recorded_where_the_response_is_estimated(rig, counts):
    """Lamps that were lit between the two are a mismatch, and no part of the estimate."""
    lit = np.random.default_rng(7).poisson(counts + 0.8)
    recording = rig.recording(lit, irf=None, irf_time_s=None)
    simulation, sensor, notes = simulation_of(recording, rig.maps)
    np.testing.assert_array_equal(simulation.background, BACKGROUND)
    assert "background_counts" not in sensor.sources
    assert not any("pedestal" in note for note in notes)


@pytest.mark.parametrize("across", [False, True])
def test_incidence_that_is_not_recorded_is_told_from_depth_in_the_likelier_way(rig, across):
    """Counts are drawn with slopes of either kind; the rig's own come from depth within surfaces."""
    told = incidence_cosine_across_edges if across else incidence_cosine
    cosine = told(depths().astype(np.float32), INTRINSICS)
    full, _, _ = simulation_of(rig.recording(rig.expected(), incidence_cosine=cosine), rig.maps)
    counts = np.random.default_rng(5).poisson(full.expected(rig.gain))
    simulation, _, notes = simulation_of(rig.recording(counts), rig.maps)
    np.testing.assert_allclose(simulation.light.cosine, full.light.cosine, atol=1e-6)
    assert any("across edges" in note for note in notes) == across


def test_a_sensor_of_other_bins_is_refused(rig, counts):
    recording = rig.recording(counts)
    sensor = SensorModel.of(rig.recording(counts[:, :, :40]))
    with pytest.raises(Refusal, match=f"{ZONES} zones and {BINS} bins but the sensor 4 zones and 40 bins"):
        simulation_of(recording, rig.maps, sensor)

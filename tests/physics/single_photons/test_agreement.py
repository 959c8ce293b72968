"""The two engines agree, effect by effect: photons one by one, and expected counts in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from physics.effects import find_effect
from physics.single_photons.acts import all_acts
from physics.single_photons.engine import draw_frames

GAIN = 1e4
# Strengths at which an effect shows within 3 frames; where nothing is said it is taken where it starts.
STRENGTHS = {
    "afterpulsing": [
        {"probability": 0.2, "tau": 2e-9},
        {"probability": 0.5, "tau": 1e-9},
        {"probability": 0.4, "tau": 2e-9, "dead": 9e-10},
        {"probability": 0.3, "tau": 8e-10, "dead": 5e-10, "slower": 0.2, "times": 4},
        {"probability": 0.4, "tau": 2e-9, "ambient": 0.3},
        {"probability": [0.4, 0.1, 0, 0.3], "tau": 2e-9, "dead": -1.3e-10},
        {"probability": 0.4, "tau": 1e-9, "dead": 5e-10, "heavy": 2},
        {"probability": 0.3, "tau": 8e-10, "dead": 5e-10, "slower": 0.2, "times": 4, "earlier": 1},
    ],
    "ambient_pedestal": [
        {"level": [900, 0, 3000, 50]},
        {"level": 500, "growth": 2e4},
        {"level": 60, "growth": -600},
        {"more": 1.5},
        {"lit": 900},
        {"level": [900, 0, 3000, 50], "swing_sin": 300, "swing_cos": -150, "frequency": 3.3},
        {"level": [900, 0, 300, 50], "level_1": 0.9, "level_2": -0.5, "between_2": 0.4, "level_5": 0.6, "every": 0.05},
        {"level": 500, "jump": -1.2, "jump_at": 0.05},
    ],
    "bin_nonlinearity": [
        {"alternation": 0.25, "slope": 0},
        {"alternation": -0.1, "slope": 0.12},
        {"wave_sin": 0.3, "wave_cos": -0.2, "period": 9.3},
        {"edge": 0.4 * np.sin(np.arange(48) ** 2)},
        {"wave_sin": 0.5, "wave_cos": -0.4, "period": 14, "moved": 0},
        {"alternation": 0.2, "slope": -0.1, "moved": 0.4},
        {"tap_1": 0.3, "tap_3": -0.4, "tap_6": 0.2, "tap_7": 0.4, "width": 0.5 * np.cos(np.arange(48) ** 2)},
        {"zone_edge": 0.4 * np.sin(np.arange(192) ** 2)},
        {"zone_width": 0.5 * np.sin(np.arange(192) ** 2)},
    ],
    "bin_phase": [
        {"depth": 0.5},
        {"depth": 1, "phase": 0.8},
        {"along": [0.6, -0.3, 0, 0.2], "across": [0.1, 0.4, -0.9, 0]},
        {"whole": 0.2, "along": 0.2, "across": -0.3, "phase": 0.1},
        {"whole": 0.4},
        {"ringed": 2.0, "taken_at": 0.7},
        {"peaked": 1.5},
        {"depth": 0.3, "whole": 1, "phase": 0.6},
        {"depth": 0.4, "phase": 0.2, "cos_2": 0.5, "sin_3": -0.6},
        {"whole": 0.4, "phase": 0.7, "sin_2": 0.7, "cos_3": 0.4},
        {"depth": [0.6, 0, 0.3, 1], "whole": [0.3, 0.5, 0, 0.2]},
    ],
    "bin_width_error": [
        {"error": 0.03},
        {"error": -0.08},
        {"error": -0.02, "zero_in_seconds": 1},
        {"error": 0, "warmup": 0.01, "tau": 0.1},
        {"error": -0.02, "apart": [0, 0.01, -0.01, 0.005]},
        {"error": -0.03, "warmup": -0.01, "tau": 0.05, "zero_in_seconds": 0.4},
    ],
    "counter_saturation": [{"ceiling": 60}, {"ceiling": 40, "lost": 0.6}, {"ceiling": [40, 60, 500, 50]}],
    "cover_glass_crosstalk": [
        {"share": [0.3, 0.1, 0, 0.02], "delay": 1e-10},
        {"counts": [3e4, 1e4, 0, 2e3], "delay": -1e-10},
        {"counts": [3e4, 1e4, 0, 2e3], "longer": 2e-10, "together": 0.7},
        {"share": 0.1, "growth": 8},
        {"share": 0.1, "trail": 6e-10},
    ],
    "footprint_blur": [
        {"variance": 1600},
        {"variance": -400},
        {"variance": -900, "amount": 0.6, "kept": 0.3},
        {"variance": 900, "taller": -0.8},
        {"variance": 900, "flat": 0.7},
        {"variance": 900, "coarse": 0.8},
        {"haze": 0.2, "wide": 6400},
        {"steeper": 0.3},
        {"variance": 400, "haze": 0.3, "wide": 2500, "steeper": -0.2},
    ],
    "footprint_shift": [
        {"x": 20, "y": -15},
        {"x": -70, "y": 40},
        {"x": 9, "slip_x": -80, "slip_y": 60},
        {"x": [40, 0, -20, 9], "y": [0, 30, -9, 50], "slip_x": 50},
        {"turn": 0.1},
        {"x": 12, "y": -8, "turn": -0.08, "zoom": 0.1},
        {"x": [40, 0, -20, 9], "y": 5, "turn": 0.05, "zoom": -0.1, "slip_y": 50},
    ],
    "gain_drift": [
        {"rate": 2},
        {"rate": -3, "background": 1},
        {"warmup": 0.6, "tau": 0.1},
        {"rate": 4, "curve": -10, "background": 0.5},
        {"level_1": 0.4, "level_2": -0.3, "between_2": 0.2, "level_6": 0.5, "every": 0.05, "background": 1},
        {"jump": -0.6, "jump_at": 0.05},
        {"rate": [2, -3, 0, 4], "zero_at": 0.04, "background": 1},
        {"warmup": [0.6, 0, -0.4, 0.2], "tau": 0.1, "background": 0.5},
    ],
    "impulse_tail": [
        {"share": 0.5, "tau": 6e-10},
        {"share": 0.2, "tau": 2e-9},
        {"lingering": 0.3, "duration": 2e-9},
        {"share": 0.5, "tau": 6e-10, "since": 0.15},
        {"share": 0.4, "tau": 5e-10, "heavy": 0.6},
        {"share": [0.4, 0, 0.2, 0.3], "tau": 9e-10, "heavy": -0.5},
        {"share": [0.5, 0, 0.1, 0.3], "tau": 4e-10},
        {"share": [0.5, 0, 0.1, 0.3], "tau": 4e-10, "added": 1},
        {"share": 0.4, "tau": 5e-10, "heavy": 0.6, "added": 0.4},
    ],
    "impulse_width": [
        {"broader": 0.5},
        {"broader": -0.4, "centred": 0.2},
        {"jitter": 2e-10},
        {"broader": 0.3, "jitter": 1e-10},
        {"jitter": [3e-10, 0, 1e-10, 2e-10]},
    ],
    "interference": [
        {"counts": [3e4, 1e4, 0, 2e4], "arrival": 5e-9, "drift": 1e-8},
        {"counts": [3e4, 1e4, 0, 2e4], "arrival": 5e-9, "drift": 1e-8, "longer": 8e-10},
        {"counts": [3e4, 1e4, 0, 2e4], "arrival": 5e-9, "drift": 3e-8, "period": 7e-9},
    ],
    "mirrored_zones": [
        {"rows": 0.6, "columns": 0.3, "transposed": 0.2},
        {"rows": 0, "columns": 1, "transposed": 1},
        {"zones_exchanged": 0.7, "first": 1, "second": 2},
        {"rows_exchanged": 1, "columns_exchanged": 0.4, "transposed": 1},
        {"reordered": 0.8, "place": [2, 0, 3, 1], "rows": 1},
        {"columns": 1, "transposed": 1, "clocks": 1},
        {"rows": 1, "levels": 1},
    ],
    "multipath": [
        {"between": 1, "sensor": 0, "outside": 0},
        {"between": 1, "aimed": 0.7},
        {"between": 1, "aimed": 0.3, "rough": 0.6},
        {"between": 0, "sensor": 0.1, "outside": 0},
        {"retro": 0.05},
        {"mirrored": 0.1},
        {"mirrored": 0.05, "spreading": 1.5},
        {"mirrored": 0.1, "face": 0.11},
        {"retro": 0.05, "face": -0.07},
        {"around": 0.5, "around_distance": 0.4},
        {"between": 0, "sensor": 0, "outside": 0.5, "outside_distance": 0.4, "outside_azimuth": 200},
        {"between": 0, "sensor": 0, "outside": 0.5, "outside_distance": 0.5, "outside_azimuth": 70, "outside_tilt": 30},
        {"outside": 0.05, "outside_distance": 0.3, "outside_azimuth": -80, "outside_stands": 0, "outside_dimmed": 1},
        {"patch": 0.2, "patch_x": 0.5, "patch_y": -0.2, "patch_z": 0.15},
        {"patch": 0.05, "patch_x": -0.4, "patch_y": 0.3, "patch_z": 0.1, "patch_dimmed": 1},
    ],
    "non_lambertian": [
        {"lobe": 2, "exponent": 5},
        {"lobe": 0.5, "exponent": 0},
        {"lobe": 1, "exponent": 4, "pigment": 0.2},
        {"lobe": -0.9, "exponent": 3},
        {"power": 1.5},
        {"power": -0.8},
        {"gloss": 2, "gloss_exponent": 3, "surface": 1},
        {"gloss": 2, "gloss_exponent": 3, "surface": 1, "told_by": 1},
        {"gloss": 2, "gloss_exponent": 9, "matt": 0.4, "surface": 1},
        {"lobe": 2, "exponent": 5, "tail": 0.05},
        {"gloss_1": 1, "gloss_2": 2, "gloss_exponent": 3, "tail": 4},
    ],
    "parallax": [
        {"x": 0.03, "y": -0.02},
        {"x": -0.08, "y": 0.05},
        {"x": -0.06, "y": 0.04, "ranges": 1.0},
        {"x": -0.06, "y": 0.04, "whole": 1.0},
    ],
    "pile_up": [
        {},
        {"share": [1, 0.5, 0.3, 0]},
        {"per_count": [3e-5, 1e-5, 0, 2e-5]},
        {"partner": 1.0},
        {"share": [1, 0.5, 0.3, 0.8], "partner": 0.5, "converter": [0, 3, 3, 3]},
        {"share": 1.0, "dead": 1.3e-9},
    ],
    "range_aliasing": [
        {"counts": [3e4, 1e4, 0, 2e4]},
        {"counts": 2e4, "apparent_range": 0.4, "jitter": 0},
        {"counts": 3e4, "apparent_range": 0.4, "speed": 4},
        {"counts": 3e4, "apparent_range": 0.5, "spread": 4e-10},
        {"counts": 3e4, "apparent_range": 0.5, "still": 1.5},
        {"counts": 3e4, "apparent_range": 0.5, "every": 0.05, "level_1": 0.1, "level_3": -0.2, "level_4": 0.3},
        {"counts": 0, "folded": 0.8, "period": 3e-9, "smear": 2e-10},
        {"counts": 0, "through": 500, "depth": 1.1, "period": 3e-9, "tilt_x": 0.3, "tilt_y": -0.2, "azimuth": 0.2},
        {"counts": 0, "through": 500, "depth": 1.1, "period": 3e-9, "elevation": -0.2, "still": 1.0},
        {"counts": 0, "distant": 1, "depth": 1.1, "period": 3e-9, "azimuth": 0.2, "elevation": -0.1, "tilt_x": 0.4},
        {"counts": 0, "distant": 1, "depth": 1.1, "period": 3e-9, "azimuth": -0.1, "high": 0.1, "still": 1.0},
    ],
    "range_falloff": [
        {"overlap_range": 0.4},
        {"overlap_range": [0.1, 0.9, 0, 0.5]},
        {"overlap_range": 0.7, "steepness": 5},
        {"overlap_range": 0.9, "focus": 1.5},
        {"overlap_range": 0.6, "steepness": 2, "sudden": 0.7},
        {"overlap_range": 0.9, "steepness": 1, "sudden": 1.6},
        {"exponent": [1.2, -0.7, 0.3, 0]},
    ],
    "range_walk": [
        {"walk": 6e-10, "level": 5e4},
        {"walk": [0, 3e-10, 1e-9, 1e-10], "level": 2e5},
        {"logarithmic": [3e-10, 0, 5e-10, 1e-10], "level": 3e4},
        {"logarithmic": 3e-10, "level": 3e4, "reference": 2e5},
        {"logarithmic": 3e-10, "level": 3e3, "fullest": 1},
    ],
    "reflectance_map": [
        {"contrast": 1.5, "step": -0.8, "spot": 1, "level": 0.5},
        {"contrast": -1, "step": 0.7, "spot": -2, "spot_x": -0.3},
        {"near": 0.8, "near_range": 0.7},
        {"slope_x": 0.8, "slope_y": -1.5, "bow_x": -1, "bow_y": 0.6, "bow_xy": 2},
        {"one": 0.5, "surface": 1, "surface_2": -0.9},
        {"one": 0.5, "surface": 1, "surface_2": -0.9, "told_by": 2},
        {"slope_x": 0.8, "bow_xy": -1, "bend_xxy": 2, "bend_yyyy": -3},
        {"slope_x": 0.3, "space_x": 0.8, "space_zz": -1.5, "space_xy": 4},
        {"mark": -1.5, "mark_x": 0.1, "mark_y": 0.05, "mark_z": 0.6, "mark_size": 0.25},
        {"wave_sin": 0.6, "wave_cos": -0.3, "wave_x": 9, "wave_y": -14, "wave_z": 5},
        {"patch": 0.5 * np.sin(np.arange(128) ** 2)},
    ],
    "scattering_medium": [
        {"extinction": 0.5},
        {"extinction": 3, "albedo": 0.6, "overlap": 0.3},
        {"extinction": 0.8, "overlap": 0.1, "blind": 0.15},
        {"extinction": [2, 0.5, 0, 1], "begin": 0.3, "thickness": 0.25},
        {"extinction": 0.8, "growth": 9},
        {"extinction": 2, "begin": 0.3, "thickness": 0.15, "soft": 0.08},
        {"haze_1": 0.2, "haze_2": 1.5, "haze_3": 0.9, "haze_4": 0.1, "halfway_1": 0.3, "every": 0.04},
    ],
    "second_surface": [
        {"passed": 0.5, "spacing": 0.2},
        {"passed": 1, "spacing": 0.05},
        {"passed": 0.2, "spacing": -0.15},
        {"passed": 0.05, "spacing": -0.6},
        {"passed": [0.5, 0, 0.2, 0.8], "spacing": 0.3, "reflectance": 0.4, "falloff": 0},
        {"passed": [0.3, 0.1, 0, 0.2], "spacing": 0.1, "reflectance": 3, "falloff": 1},
        {"covered": 0.4, "spacing": 0.25, "nearest": 0.5, "farthest": 0.9},
        {"covered": 0.4, "spacing": -0.15, "nearest": 0.6, "reflectance": 0.5, "falloff": 0},
        {"one": 0.6, "spacing": 0.3, "reflectance": 0.7},
        {"one": 0.4, "spacing": -0.2},
        {"pane": 0.5, "spacing": 0.3, "pane_x": 0.05, "pane_y": -0.03, "pane_z": 0.8, "pane_size": 0.3},
    ],
    "stray_light": [
        {"share": 0.1},
        {"share": [0.3, 0, 0.05, 0.1]},
        {"share": 0.2, "clocks": 0.7},
        {"share": 0, "glare": 0.1, "glare_y": 0.2},
    ],
    "time_lag": [
        {"lag": 0.03},
        {"lag": -0.13},
        {"lag": 0.02, "skew": -0.4},
        {"burst": 0.05},
        {"lag": 0.03, "burst": -0.07, "late": [1, 0, 0, 1]},
    ],
    "time_zero_drift": [
        {"rate": 3e-9},
        {"rate": -2e-9},
        {"warmup": 4e-10, "tau": 0.1},
        {"rate": 3e-9, "curve": -1e-8},
        {"rate": 3e-9, "zero_at": 0.13},
        {"rate": [3e-9, 0, -2e-9, 1e-9], "curve": 2e-9},
        {"rate": 0, "level_1": 3e-10, "between_3": -2e-10, "level_4": 2e-10, "every": 0.05, "zero_at": 0.06},
        {"rate": 0, "jump": 3e-10, "jump_at": 0.15},
    ],
    "time_zero_offset": [{"delay": [3e-10, -2e-10, 0, 1e-10]}],
    "window_clipping": [
        {"early": 14.3, "late": 20.6},
        {"early": 18.3, "late": 24.6, "softness": 6.2, "lost": 0.7},
        {"early": 19.7, "softness": 3, "background": 0},
        {"late": 26.1, "lost": 0.5, "background": 0.4},
        {"early": [14.3, 0, 18.1, 16], "late": [0, 20.6, 12, 26], "lost": 0.8},
        {"early": [14.3, 0, 18.1, 16], "softness": 2, "background": 0},
        {"early": [16.3, 0, 18.1, 16], "late": 22.0, "softness": 4, "rounded": 0.8},
        {"aside": 0.6, "before": 1.3, "after": 2.6},
        {"aside": 0.4, "before": 0.8, "after": 3.0, "background": 0.3, "early": 12.5},
    ],
    "zone_gain": [
        {"factor": [0.7, 1.3, 1, 0]},
        {"one": -0.4, "zone": 2},
        {"one": 0.3, "zone": 1},
        {"across": 0.3, "down": -0.2},
        {"across": 0.1, "down": -0.1, "bow": -0.4},
        {"alternate": -0.25},
        {"factor": [0.7, 1.3, 1, 0], "ambient": 1},
        {"across": 0.3, "ambient": 0.6},
    ],
}
# A ceiling concerns frames of few counts; a second bounce is weak, and so is a sharpened map.
DRAWN = {
    "counter_saturation": SimpleNamespace(gain=300, times=40),
    "footprint_blur": SimpleNamespace(gain=3e4, times=1),
    "multipath": SimpleNamespace(gain=4e4, times=1),
}
MANY = SimpleNamespace(gain=GAIN, times=1)
TOGETHER = [
    ("cover_glass_crosstalk", "zone_gain", "ambient_pedestal", "pile_up", "afterpulsing"),
    ("range_falloff", "stray_light", "time_zero_offset", "gain_drift", "ambient_pedestal"),
    ("second_surface", "scattering_medium", "stray_light", "impulse_tail"),
    ("impulse_width", "impulse_tail", "cover_glass_crosstalk", "bin_nonlinearity"),
    ("interference", "impulse_width", "pile_up", "window_clipping"),
    ("range_aliasing", "gain_drift", "afterpulsing"),
]
# One strength of each always, the others among the slow tests.
EVERY = [
    pytest.param(name, i, marks=[pytest.mark.slow] if i else [])
    for name in sorted(all_acts())
    for i in range(len(STRENGTHS.get(name, [{}])))
]


# What stays where it is while the camera moves.
STANDS = ("still", "mark", "pane", "wave_sin", "space_x", "patch")
# Nearer, turned, and aside.
POSES = np.tile(np.eye(4), (3, 1, 1))
POSES[1, :3, :3] = Rotation.from_euler("zyx", [4, -6, 3], degrees=True).as_matrix()
POSES[1:, :3, 3] = (0.02, 0.0, 0.08), (0.05, -0.04, 0.12)


def compared(both, effects, drawn=MANY, **scene):
    """Photons against the fast engine, cell by cell, and how large the effects are by the photons' reckoning.

    p: of χ² over cells against the model with the effects. without: the same against the model without them.
    size: of the effects, 1 where it is as the model says: weighted least squares of the change. sigma: its error.
    """
    made, rng = both(gain=drawn.gain, effects=effects, **scene), np.random.default_rng(5)
    counts = sum(np.stack(list(draw_frames(made.session, rng))) for _ in range(drawn.times)).astype(float)
    expected, nominal = (drawn.times * made.model.expected(drawn.gain, which) for which in (effects, ()))
    # What both say is empty is empty, and cells of few counts are not normal.
    assert counts[expected < 1e-6].sum() <= 1
    cells, change = expected > 5, expected - nominal
    weight = np.where(cells, change / np.maximum(expected, 1), 0)
    information = float((weight * change).sum())
    return SimpleNamespace(
        p=_p_of_chi2(counts[cells], expected[cells]),
        without=_p_of_chi2(counts[nominal > 5], nominal[nominal > 5]),
        size=1 + float((weight * (counts - expected)).sum()) / information if information else 1.0,
        sigma=information**-0.5 if information else np.inf,
    )


def _p_of_chi2(counts, expected):
    return chi2.sf(((counts - expected) ** 2 / expected).sum(), counts.size)


@pytest.mark.parametrize(("name", "i"), EVERY)
def test_an_effect_does_to_photons_what_the_model_says(name, i, both):
    setting = find_effect(name).at(**STRENGTHS.get(name, [{}])[i])
    moves = {"poses": POSES} if any(np.any(setting.values.get(one)) for one in STANDS) else {}
    found = compared(both, [setting], DRAWN.get(name, MANY), seed=2 + i, **moves)
    assert found.p > 1e-4
    assert abs(found.size - 1) < max(4 * found.sigma, 0.01)
    # And it would show if it were not so: an error of some hundredths of the effect, or the effect forgotten.
    assert found.sigma < 0.025
    assert found.without < 1e-10


@pytest.mark.parametrize("names", TOGETHER, ids=" ".join)
def test_effects_compose_alike(names, both):
    settings = [find_effect(name).at(**STRENGTHS[name][0]) for name in names]
    found = compared(both, settings)
    assert found.p > 1e-4
    assert abs(found.size - 1) < 4 * found.sigma


def test_a_plane_outside_the_view_stands_still_while_the_camera_moves(both):
    """The camera comes nearer to it, turns, and at last is behind it."""
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[1, :3, :3] = Rotation.from_euler("zyx", [10, -15, 5], degrees=True).as_matrix()
    poses[1:, 0, 3] = 0.25, 0.45
    # Where the world's origin is does not matter.
    poses = np.linalg.inv([[0, -1, 0, 2], [1, 0, 0, 3], [0, 0, 1, -1], [0, 0, 0, 1]]) @ poses
    values = {"outside": 0.5, "outside_distance": 0.4, "outside_azimuth": 10, "outside_tilt": -20}
    setting = find_effect("multipath").at(**values)
    found = compared(both, [setting], DRAWN["multipath"], poses=poses)
    assert found.p > 1e-4
    assert abs(found.size - 1) < 4 * found.sigma
    still = both(gain=1, effects=[setting]).model.expected(1.0, [setting])
    moved = both(gain=1, effects=[setting], poses=poses).model.expected(1.0, [setting])
    np.testing.assert_allclose(moved[0], still[0])
    assert np.abs(moved[1] - still[1]).max() > 0.01 * still[1].max()


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_the_middle_of_the_highest_pulse_is_the_same_to_a_fiftieth_of_a_bin(both, seed):
    """As far as a lattice of sixteen knots to a bin tells what is in it: that makes some hundredths of the effect."""
    found = compared(both, [find_effect("bin_phase").at(whole=0.6, highest=1, phase=0.3)], seed=seed)
    assert abs(found.size - 1) < 0.05
    assert found.sigma < 0.01
    assert found.without < 1e-10


def test_every_act_is_that_of_an_effect():
    assert all(find_effect(name).id == name for name in all_acts())


@pytest.mark.parametrize("seed", [2, 3])
def test_without_effects_it_is_the_nominal_model(both, seed):
    assert compared(both, [], seed=seed).p > 1e-4

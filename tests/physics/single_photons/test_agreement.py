"""The two engines agree, effect by effect: photons one by one, and expected counts in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from physics.effects import find_effect
from physics.single_photons.acts import all_acts
from physics.single_photons.engine import draw_frames

from .strengths import STRENGTHS

GAIN = 1e4
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


@pytest.mark.parametrize("within", [1.0, 0.3])
@pytest.mark.parametrize("seed", [2, 3, 4])
def test_the_middle_of_the_highest_pulse_is_the_same_to_a_twentieth_of_a_bin(both, seed, within):
    """As far as sixteen knots to a bin tell where a flat top is highest: some hundredths of the effect."""
    found = compared(both, [find_effect("bin_phase").at(whole=0.6, highest=1, within=within, phase=0.3)], seed=seed)
    assert abs(found.size - 1) < 0.08
    assert found.sigma < 0.01
    assert found.without < 1e-10


def test_every_act_is_that_of_an_effect():
    assert all(find_effect(name).id == name for name in all_acts())


@pytest.mark.parametrize("seed", [2, 3])
def test_without_effects_it_is_the_nominal_model(both, seed):
    assert compared(both, [], seed=seed).p > 1e-4

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from calibrate.patch_repair import expect
from calibrate.plan import ScanPlan

PLAN = ScanPlan(12, 9, repeats=2)
MODEL = PLAN.cells * 30.0 + 50


def places(rng, scatter=0.2):
    """A robot that drifts smoothly away from the model, by up to 8 px over the grid."""
    column, row = PLAN.cells.T
    drift = np.column_stack([4 * np.sin(column / 6), -0.06 * row**2])
    return (MODEL + drift)[:, None] + scatter * rng.standard_normal((len(MODEL), 2, 2))


def apart(rng, many, most=3):
    """So many cells of the plan, of which no cell has more than some within two of it."""
    near = np.abs(PLAN.cells[:, None] - PLAN.cells[None]).max(axis=-1) <= 2
    chosen = []
    for cell in rng.permutation(len(PLAN.cells)):
        if len(chosen) < many and near[:, [*chosen, cell]].sum(axis=1).max() <= most:
            chosen.append(int(cell))
    return np.array(chosen)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(6, 200), st.floats(0, 6.28))
def test_only_what_departs_from_its_neighbours_is_doubted(seed, away, heading):
    rng = np.random.default_rng(seed)
    at = places(rng)
    # Neighbours may be wrong together, but not so many that with those unseen they outvote the rest (about one of 300
    # draws of eight places anywhere). From 6 px on: the limit is 3, and neighbours are off by some themselves.
    wrong = apart(rng, 8)
    at[wrong, 0] += away * np.array([np.cos(heading), np.sin(heading)])
    at[rng.choice(len(at), 20), 1] = np.nan
    departs = expect(PLAN, MODEL, at).departs(at)
    assert set(np.flatnonzero(departs[:, 0])) == set(wrong)
    assert not departs[:, 1].any() or set(np.flatnonzero(departs[:, 1])) <= set(wrong)


def test_neighbours_predict_what_was_not_seen():
    at = places(np.random.default_rng(0))
    truth = at[40].mean(axis=0)
    at[40] = np.nan
    expected = expect(PLAN, MODEL, at)
    assert np.abs(expected.at_px[40] - truth).max() < 1.0
    assert np.linalg.norm(MODEL[40] - truth) > 2


def test_a_rough_robot_is_allowed_more():
    assert expect(PLAN, MODEL, places(np.random.default_rng(0), scatter=0.05)).limit_px == 3.0
    rough = expect(PLAN, MODEL, places(np.random.default_rng(0), scatter=4.0))
    assert rough.limit_px > 20


def test_where_little_was_seen_the_model_speaks_and_nothing_is_doubted():
    at = np.full((len(MODEL), 2, 2), np.nan)
    at[5] = MODEL[5] + 10
    expected = expect(PLAN, MODEL, at)
    np.testing.assert_array_equal(expected.at_px, MODEL)
    assert not expected.departs(at).any()

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from calibrate.patch_grid import Sightings, fit_grid

SIZE = 848, 480


def camera(cells, shape, turn_deg, tilt_deg, mirror, distortion=0.0):
    """Pixels of a planar grid 0.9 × 0.5 m at 0.7 m, turned, tilted and mirrored, through pinhole and lens."""
    span = np.maximum(np.array(shape) - 1, 1)
    plane = (cells / span - 0.5 * (np.array(shape) > 1)) * (0.9, 0.5) * (-1 if mirror else 1, 1)
    turn = Rotation.from_euler("zxy", [turn_deg, *tilt_deg], degrees=True)
    points = np.array([0, 0, 0.7]) + turn.apply(np.column_stack([plane, np.zeros(len(plane))]))
    tangents = points[:, :2] / points[:, 2:]
    bent = tangents * (1 + distortion * np.square(tangents).sum(axis=1, keepdims=True))
    return 600 * bent + (424, 240)


def all_cells(columns, rows):
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)


def sightings(cells, at_px, radius=17.0, confidence=1.0):
    return Sightings(cells, at_px, np.full(len(cells), radius), np.full(len(cells), confidence))


def together(*parts):
    names = ("cell", "at_px", "radius_px", "confidence")
    return Sightings(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@settings(max_examples=25, deadline=None)
@given(
    turn=st.sampled_from([0.0, 3.0, 90.0, 180.0, 270.0, 40.0]),
    tilt=st.tuples(st.floats(-15, 15), st.floats(-15, 15)),
    mirror=st.booleans(),
    distortion=st.floats(-0.1, 0.1),
    seed=st.integers(0, 2**32 - 1),
)
def test_any_orientation_seen_through_any_mild_lens(turn, tilt, mirror, distortion, seed):
    rng = np.random.default_rng(seed)
    shape, every = (20, 11), all_cells(20, 11)
    truth = camera(every, shape, turn, tilt, mirror, distortion)
    some = rng.permutation(len(every))[:40]
    wrong = rng.permutation(len(every))[:15]
    scattered = sightings(every[wrong], rng.uniform((0, 0), SIZE, (15, 2)))
    seen = together(sightings(every[some], truth[some] + 0.3 * rng.standard_normal((40, 2))), scattered)
    grid, belongs = fit_grid(seen, 45, shape, SIZE, rng)
    assert belongs[:40].all()
    # 17 px of 848 x 480 hold a scattered sighting by chance once in 450 times.
    assert belongs[40:].sum() <= 1
    assert np.abs(grid.predict(every) - truth).max() < 2.5
    assert np.median(np.abs(grid.predict(every) - truth)) < 0.5
    assert 0.1 < grid.scatter_px < 0.6


def test_corners_that_failed_are_extrapolated():
    shape, every = (20, 11), all_cells(20, 11)
    truth = camera(every, shape, 0.0, (8, -10), False)
    inner = every[:, 0].clip(3, 16) == every[:, 0]
    grid, _ = fit_grid(sightings(every[inner], truth[inner]), 220, shape, SIZE, np.random.default_rng(0))
    assert np.abs(grid.predict(every) - truth).max() < 0.5


def test_a_disc_that_stands_still_is_no_grid():
    rng = np.random.default_rng(0)
    shape, every = (8, 6), all_cells(8, 6)
    truth = camera(every, shape, 0.0, (0, 0), False)
    still = sightings(every, (500, 200) + 0.1 * rng.standard_normal((48, 2)))
    assert fit_grid(still, 48, shape, SIZE, rng) is None
    grid, belongs = fit_grid(together(still, sightings(every[12:], truth[12:])), 48, shape, SIZE, rng)
    assert belongs[48:].all()
    assert np.abs(grid.predict(every) - truth).max() < 0.5


def test_a_disc_of_another_size_that_moves_along_loses():
    shape, every = (8, 6), all_cells(8, 6)
    truth = camera(every, shape, 0.0, (0, 0), False)
    cap = sightings(every, truth - (120, 50), radius=50.0, confidence=0.8)
    grid, belongs = fit_grid(together(cap, sightings(every, truth)), 48, shape, SIZE, np.random.default_rng(0))
    assert belongs.tolist() == [False] * 48 + [True] * 48
    assert np.abs(grid.predict(every) - truth).max() < 0.1


@pytest.mark.parametrize("shape", [(30, 1), (1, 12), (2, 2), (3, 1)])
def test_small_grids(shape):
    every = all_cells(*shape)
    truth = camera(every, shape, 5.0, (1, -2), True)
    grid, belongs = fit_grid(sightings(every, truth), len(every), shape, SIZE, np.random.default_rng(0))
    assert belongs.all()
    assert np.abs(grid.predict(every) - truth).max() < 1.5


def test_what_follows_no_grid_fits_none():
    rng = np.random.default_rng(0)
    every = all_cells(8, 6)
    assert fit_grid(sightings(every, rng.uniform((0, 0), SIZE, (48, 2))), 48, (8, 6), SIZE, rng) is None
    nothing = sightings(np.empty((0, 2)), np.empty((0, 2)))
    assert fit_grid(nothing, 48, (8, 6), SIZE, rng) is None
    # The right places in another order: a scan of 6 x 8 read as 8 x 6.
    shuffled = camera(all_cells(6, 8), (6, 8), 0.0, (0, 0), False)
    assert fit_grid(sightings(every, shuffled), 48, (8, 6), SIZE, rng) is None

import numpy as np
import pytest

from calibrate.patch_track import PatchTrack
from calibrate.plan import ScanPlan
from calibrate.positions import scan_positions
from recordings.refusal import Refusal


def track(x, found=None, sigma=0.1):
    x = np.asarray(x, float)
    found = np.ones(len(x), bool) if found is None else np.asarray(found)
    gone = np.where(found, 0, np.nan)
    return PatchTrack(
        x_px=x + gone,
        y_px=2 * x + gone,
        sigma_px=np.broadcast_to(sigma, x.shape) + gone,
        radius_px=np.full(len(x), 17.75) + gone,
        confidence=found.astype(float),
        method=np.where(found, "found", "none"),
    )


def test_every_frame_is_a_position_without_a_plan():
    found = scan_positions(track([1, 2, 3, 4], [True, False, True, True]), None)
    np.testing.assert_array_equal(found.frames, [[0], [2], [3]])
    np.testing.assert_allclose(found.x_px, [1, 3, 4])
    assert found.left_out == ["0001"]
    assert found.methods == {"found": 3, "none": 1}


def test_repeats_are_averaged_by_their_errors():
    sigma = np.array([9.0, 1, 2, 1, 1, 1, 1])
    found = scan_positions(track([0, 10, 20, 5, 7, 1, 1], sigma=sigma), ScanPlan(3, 1, repeats=2, first=1))
    # Weights 1 and 1/4, then equal ones.
    np.testing.assert_allclose(found.x_px, [12, 6, 1])
    np.testing.assert_allclose(found.sigma_px, [1 / np.sqrt(1.25), 1 / np.sqrt(2), 1 / np.sqrt(2)])


def test_a_position_not_seen_in_every_repeat_is_left_out():
    seen = [True] * 4 + [False] + [True] * 3
    found = scan_positions(track(np.arange(8), seen), ScanPlan(4, 1, repeats=2))
    assert found.frames.tolist() == [[0, 1], [2, 3], [6, 7]]
    assert found.left_out == ["0004", "0005"]


def test_too_few_positions_are_refused():
    with pytest.raises(Refusal, match="2 of 4 positions"):
        scan_positions(track(np.arange(4), [True, True, False, False]), None)

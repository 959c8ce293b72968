"""Whole scans that are awkward: decoys, borders, gaps, odd orders, and those that cannot be used."""

import cv2
import numpy as np
import pytest

from calibrate.patch_track import find_patches
from calibrate.plan import ScanPlan
from recordings.refusal import Refusal

SHAPE = (180, 300)
RADIUS = 9.0
PLAN = ScanPlan(8, 5)


def lay(image, x, y, radius, level):
    """A disc over part of an image; coverage of a pixel from its distance to the rim."""
    top, left = max(int(y - radius) - 2, 0), max(int(x - radius) - 2, 0)
    part = image[top : int(y + radius) + 3, left : int(x + radius) + 3]
    rows, columns = np.ogrid[top : top + part.shape[0], left : left + part.shape[1]]
    share = np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0, 1)
    part[:] = part * (1 - share) + level * share


class Scan:
    """Frames drawn when indexed: discs that stand still, then flange and patch at a centre; None is a covered lens."""

    def __init__(self, centres, still=(), without=(), light=1.0, along=()):
        self.centres, self.still, self.without, self.light, self.along = centres, still, set(without), light, along
        self.reads = np.zeros(len(centres), int)

    def __len__(self):
        return len(self.centres)

    def __getitem__(self, index):
        self.reads[index] += 1
        image = np.full(SHAPE, 25.0)
        for spot in self.still:
            lay(image, *spot)
        if self.centres[index] is not None:
            x, y = self.centres[index]
            for dx, dy, radius, level in self.along:
                lay(image, x + dx, y + dy, radius, level)
            lay(image, x, y, 2.4 * RADIUS, 210)
            lay(image, x, y, 1.9 * RADIUS, 60)
            if index not in self.without:
                lay(image, x, y, RADIUS, 185)
        noise = np.random.default_rng(index).normal(0, 3, SHAPE)
        grey = np.clip(self.light * (cv2.GaussianBlur(image, (0, 0), 0.7) + noise), 0, 255).astype(np.uint8)
        return np.repeat(grey[..., None], 3, axis=2)


def centres(plan=PLAN, corners=(14.0, 164.0, 285.0, 15.0), transposed=False, repeats=False):
    """Places of the plan's frames, rows bending and narrowing upwards, jittered by the robot."""
    u, v = (plan.cells / np.maximum((plan.columns - 1, plan.rows - 1), 1)).T
    if transposed:
        u, v = v, u
    x0, y0, x1, y1 = corners
    x = x0 + (x1 - x0) * (0.5 + (u - 0.5) * (1 - 0.03 * v))
    y = y0 + (y1 - y0) * (v + 0.02 * (u - 0.5))
    jitter = np.random.default_rng(4).normal(0, 0.2, (len(u), 2))
    return np.repeat(np.column_stack([x, y]) + jitter, plan.repeats, axis=0)


def errors(track, truth):
    return np.hypot(track.x_px - truth[:, 0], track.y_px - truth[:, 1])


@pytest.mark.parametrize(
    ("corners", "transposed"),
    [
        ((14.0, 164.0, 285.0, 15.0), False),
        ((285.0, 15.0, 14.0, 164.0), False),
        ((285.0, 164.0, 14.0, 15.0), True),
    ],
)
def test_any_orientation(corners, transposed):
    truth = centres(corners=corners, transposed=transposed)
    track = find_patches(Scan(truth), PLAN)
    assert track.found.all()
    assert errors(track, truth).max() < 0.15
    pulls = np.concatenate([track.x_px - truth[:, 0], track.y_px - truth[:, 1]]) / np.tile(track.sigma_px, 2)
    assert 0.5 < np.std(pulls) < 1.4


def test_down_to_the_border():
    truth = centres(corners=(1.8, 177.0, 297.5, 2.5))
    track = find_patches(Scan(truth), PLAN)
    assert track.found.all()
    assert np.median(errors(track, truth)) < 0.05
    assert errors(track, truth).max() < 0.4


def test_discs_that_stand_still_are_not_the_patch():
    truth = centres()
    still = [(150.0, 90.0, RADIUS, 190), (60.0, 40.0, 14.0, 230), (250.0, 130.0, RADIUS, 185)]
    without = [7, 20, 33, 34]
    for plan in (PLAN, None):
        track = find_patches(Scan(truth, still, without), plan)
        assert not track.found[without].any()
        assert track.found.sum() >= len(truth) - len(without) - (0 if plan else 4)
        assert errors(track, truth)[track.found].max() < 0.5


def test_a_disc_that_moves_along_is_not_the_patch_where_its_size_is_given():
    truth = centres()
    scan = Scan(truth, along=[(-40.0, -12.0, 14.0, 230)])
    track = find_patches(scan, PLAN, radius_px=RADIUS + 0.5)
    assert track.found.all()
    assert errors(track, truth).max() < 0.15


@pytest.mark.parametrize("plan", [PLAN, None])
def test_frames_without_a_patch_stay_without(plan):
    truth = centres()
    covered, fallen = [0, 11, 12, 39], [5, 30, 31]
    places = [None if index in covered else place for index, place in enumerate(truth)]
    track = find_patches(Scan(places, without=fallen), plan)
    assert np.flatnonzero(~track.found).tolist() == sorted(covered + fallen)
    for values in (track.x_px, track.y_px, track.sigma_px, track.radius_px):
        assert np.isfinite(values[track.found]).all()
        assert np.isnan(values[~track.found]).all()
    assert set(track.method[~track.found]) == {"none"}
    assert errors(track, truth)[track.found].max() < 0.15


def test_a_patch_seen_in_a_third_of_the_frames():
    truth = centres()
    without = [index for index in range(len(truth)) if index % 3]
    track = find_patches(Scan(truth, without=without), PLAN)
    assert np.flatnonzero(track.found).tolist() == list(range(0, len(truth), 3))


def test_a_place_that_departs_is_looked_at_again_and_left_out():
    truth = centres()
    truth[25] += (0, 6.5)
    track = find_patches(Scan(truth), PLAN, radius_px=RADIUS)
    assert np.flatnonzero(~track.found).tolist() == [25]


def test_repeats_agree_and_frames_outside_the_grid_are_searched():
    plan = ScanPlan(8, 5, repeats=2, first=3)
    inside = centres(plan)
    truth = np.concatenate([[(200.0, 60.0), (200.0, 60.0), (30.0, 120.0)], inside, [(100.0, 100.0)]])
    track = find_patches(Scan(truth), plan)
    assert track.found.all()
    assert errors(track, truth).max() < 0.15


def test_frames_that_the_recording_lost():
    whole = ScanPlan(8, 5, repeats=2, first=1)
    truth = np.concatenate([[(200.0, 60.0)], centres(whole)])
    lost = 0, 4, 5, 30, 80
    plan = ScanPlan(8, 5, repeats=2, first=1, lost=lost)
    kept = np.delete(truth, lost, axis=0)
    track = find_patches(Scan(kept), plan, radius_px=RADIUS)
    assert track.found.all()
    assert errors(track, kept).max() < 0.15


def test_dim_light_and_given_radius_give_the_same_centres():
    truth = centres()
    bright = find_patches(Scan(truth), PLAN)
    for scan, radius in ((Scan(truth, light=0.3), None), (Scan(truth), RADIUS)):
        other = find_patches(scan, PLAN, radius_px=radius)
        assert np.abs(other.x_px - bright.x_px).max() < 0.1
        assert np.abs(other.y_px - bright.y_px).max() < 0.1


@pytest.mark.usefixtures("every_core")
def test_a_scan_gives_the_same_centres_twice_and_frames_are_read_sparingly():
    scan = Scan(centres())
    first = find_patches(scan, PLAN)
    # The sample is seen twice, everything else once.
    assert scan.reads.max() <= 3
    assert scan.reads.sum() <= len(scan) + 36 + 1
    second = find_patches(scan, PLAN)
    np.testing.assert_array_equal(first.x_px, second.x_px)
    np.testing.assert_array_equal(first.sigma_px, second.sigma_px)


@pytest.mark.parametrize("plan", [ScanPlan(1, 1), ScanPlan(2, 1), ScanPlan(12, 1), ScanPlan(1, 7), ScanPlan(2, 2)])
def test_small_scans(plan):
    truth = centres(plan, corners=(40.0, 140.0, 260.0, 40.0))
    track = find_patches(Scan(truth), plan, radius_px=RADIUS)
    assert track.found.all()
    assert errors(track, truth).max() < 0.15


def test_progress_sees_every_frame():
    seen = {}

    def progress(items, total, label):
        items = list(items)
        assert total == len(items)
        seen[label] = items
        return items

    find_patches(Scan(centres()), PLAN, radius_px=RADIUS, progress=progress)
    assert sorted(seen["finding the patch"]) == list(range(PLAN.count))


@pytest.mark.parametrize(
    ("scan", "plan", "radius", "sentence"),
    [
        (Scan(centres()), ScanPlan(5, 8), RADIUS, "do not follow a grid of 5 x 8 cells in snake order"),
        (Scan(centres()), ScanPlan(9, 5), None, "rgb has 40 frames, expected 45"),
        (Scan(centres(), without=range(40)), PLAN, None, r"0 of \d+ frames looked at show a round patch"),
        (Scan([None] * 40), None, None, r"none of \d+ frames looked at shows a round patch"),
        (Scan([(150.0, 90.0)] * 40), PLAN, RADIUS, "do not follow a grid"),
        (Scan(centres()), PLAN, 1.0, "radius_px is 1.0, expected 2 pixels or more"),
        (Scan(centres()), PLAN, float("nan"), "radius_px is nan"),
    ],
)
def test_scans_that_cannot_be_used_are_refused(scan, plan, radius, sentence):
    with pytest.raises(Refusal, match=sentence):
        find_patches(scan, plan, radius_px=radius)


def test_a_patch_at_rest_is_found_where_there_is_no_plan():
    truth = np.array([(150.0, 90.0)] * 12)
    track = find_patches(Scan(truth))
    assert errors(track, truth).max() < 0.1

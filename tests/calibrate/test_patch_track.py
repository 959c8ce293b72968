"""Patch centres against discs drawn here by exact coverage, the simulated scan, and the published frame."""

import cv2
import numpy as np
import pytest

from calibrate.patch_track import PatchTrack, find_patches
from calibrate.plan import ScanPlan
from calibrate.simulated.frames import Mishaps
from calibrate.simulated_scan import simulate_scan
from recordings.refusal import Refusal

SIZE = 320, 240
RADIUS = 12.3
PLAN = ScanPlan(8, 6)


def disc(x, y, radius=RADIUS, size=SIZE, fine=8):
    """(H, W) share of each pixel that a disc covers, by counting points of a fine grid."""
    column = (np.arange(size[0] * fine) + 0.5) / fine - 0.5
    row = (np.arange(size[1] * fine) + 0.5) / fine - 0.5
    inside = (column[None] - x) ** 2 + (row[:, None] - y) ** 2 <= radius**2
    return inside.reshape(size[1], fine, size[0], fine).mean(axis=(1, 3))


def frame(x, y, rng, decoys=True, noise=2.0, bright=190.0):
    """A bright disc within a dark ring on a lighter plate, with a cap and screws beside it, blurred and noisy."""
    picture = np.full((SIZE[1], SIZE[0]), 30.0)
    layers = [
        (x - 48, y - 30, 30, 160.0),
        (x, y, 2.2 * RADIUS, 200.0),
        (x, y, 1.7 * RADIUS, 45.0),
        (x, y, RADIUS, bright),
    ]
    screws = [(x - 48 + 14 * np.cos(a), y - 30 + 14 * np.sin(a), 2.5, 60.0) for a in (0.3, 2.4, 4.5)]
    for cx, cy, radius, level in (layers[:1] + screws + layers[1:]) if decoys else layers[1:]:
        cover = disc(cx, cy, radius)
        picture = picture * (1 - cover) + level * cover
    picture = cv2.GaussianBlur(picture, (0, 0), 0.9) + noise * rng.standard_normal(picture.shape)
    return np.clip(np.repeat(picture[..., None], 3, axis=2), 0, 255).astype(np.uint8)


def grid_centres(plan=PLAN, rng=None):
    cells = plan.cells / (plan.columns - 1, plan.rows - 1)
    jitter = 0 if rng is None else 0.3 * rng.standard_normal(cells.shape)
    return np.array([40.0, 30.0]) + cells * (240, 180) + jitter


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(0)
    centres = grid_centres(rng=rng)
    return centres, [frame(*centre, rng) for centre in centres]


def error(track, centres):
    return np.hypot(track.x_px - centres[:, 0], track.y_px - centres[:, 1])


def test_drawn_discs(drawn):
    centres, frames = drawn
    track = find_patches(frames, PLAN)
    assert track.found.all()
    assert error(track, centres).max() < 0.15
    assert np.median(track.radius_px) == pytest.approx(RADIUS, abs=0.15)
    assert (track.confidence > 0.5).all()
    assert ((track.sigma_px > 0) & (track.sigma_px < 0.5)).all()


@pytest.mark.parametrize("flip", [(slice(None), slice(None, None, -1)), (slice(None, None, -1), slice(None))])
def test_a_mirrored_scan_has_mirrored_centres(drawn, flip):
    """Neither the direction of the rows nor that of the columns is assumed."""
    centres, frames = drawn
    across = flip[1].step == -1
    mirrored = centres.copy()
    mirrored[:, 0 if across else 1] = (SIZE[0] if across else SIZE[1]) - 1 - mirrored[:, 0 if across else 1]
    track = find_patches([np.ascontiguousarray(f[flip]) for f in frames], PLAN)
    assert track.found.all()
    assert error(track, mirrored).max() < 0.15


def test_without_a_plan_the_patch_is_followed(drawn):
    centres, frames = drawn
    track = find_patches(frames)
    assert track.found.mean() > 0.95
    assert np.nanmax(error(track, centres)) < 0.2


def test_missing_patches_are_never_invented(drawn):
    centres, frames = drawn
    rng = np.random.default_rng(1)
    gone = {7: frame(*centres[7], rng, bright=45.0), 20: np.zeros_like(frames[0]), 33: np.full_like(frames[0], 255)}
    track = find_patches([gone.get(i, f) for i, f in enumerate(frames)], PLAN)
    assert np.flatnonzero(~track.found).tolist() == sorted(gone)
    assert np.isnan(track.x_px[~track.found]).all()
    assert (track.confidence[~track.found] == 0).all()
    assert error(track, centres)[track.found].max() < 0.15


def test_repeats_and_frames_before_the_grid(drawn):
    centres, frames = drawn
    plan = ScanPlan(PLAN.columns, PLAN.rows, repeats=2, first=1)
    twice = [frames[0]] + [f for f in frames for _ in range(2)]
    track = find_patches(twice, plan)
    assert error(track, np.concatenate([centres[:1], np.repeat(centres, 2, axis=0)])).max() < 0.15


def test_the_simulated_scan():
    """What the scan must reach: median error 0.3 px, 99 % within 1.5 px, no patch where there is none."""
    plan, missing = ScanPlan(30, 17), (3, 100, 101, 400)
    scan = simulate_scan(plan, rng=np.random.default_rng(8), mishaps=Mishaps(missing=missing))
    track = find_patches(scan.patch.collect().rgb, plan)
    off = error(track, scan.truth.centres_px)[track.found]
    assert np.median(off) <= 0.3
    assert np.quantile(off, 0.99) <= 1.5
    assert not track.found[list(missing)].any()
    assert track.found.sum() >= plan.count - len(missing) - 5
    pull = off / track.sigma_px[track.found] / np.sqrt(2)
    assert 0.4 < np.sqrt(np.mean(pull**2)) < 2.5


def test_the_published_frame(shared_data):
    """Against the centroid of the bright disc above half its height, which uses no edge and no circle."""
    picture = cv2.imread(str(shared_data / "tmf8828_response_maps" / "sample_rgb.png"))[..., ::-1].copy()
    track = find_patches([picture] * 3)
    grey = picture.mean(axis=2)[216:261, 406:451]
    _, labels = cv2.connectedComponents((grey > 0.5 * (grey.max() + np.quantile(grey, 0.3))).astype(np.uint8))
    row, column = np.nonzero(labels == labels[22, 22])
    assert track.found.all()
    np.testing.assert_allclose([track.x_px[0], track.y_px[0]], [column.mean() + 406, row.mean() + 216], atol=0.4)
    assert track.radius_px[0] == pytest.approx(17.4, abs=0.6)


def test_known_centres_are_taken_as_they_are():
    track = PatchTrack.given(np.array([[3.0, 4.0], [np.nan, np.nan]]), 17.0)
    assert track.found.tolist() == [True, False]
    assert (track.x_px[0], track.y_px[0], track.sigma_px[0], track.radius_px[0]) == (3, 4, 0, 17)


def test_what_shows_no_patch_is_refused(drawn):
    blank = [np.zeros_like(drawn[1][0])] * PLAN.count
    with pytest.raises(Refusal, match="frames"):
        find_patches(blank, PLAN)
    with pytest.raises(Refusal, match="radius"):
        find_patches(drawn[1], PLAN, radius_px=-1)
    with pytest.raises(Refusal, match="uint8"):
        find_patches([f.astype(float) for f in drawn[1]], PLAN)

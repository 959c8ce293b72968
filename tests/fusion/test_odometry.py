"""Motion between two views of a painted, wavy wall, which is known."""

import cv2
import numpy as np
import pytest

from fusion.cloud import cloud
from fusion.fused import FusedFrame
from fusion.odometry import Odometry
from recordings.refusal import Refusal

SHAPE = (240, 320)
INTRINSICS = np.array([[280.0, 0, 159.5], [0, 280, 119.5], [0, 0, 1]])
PAINT = cv2.GaussianBlur(np.random.default_rng(3).integers(0, 256, (300, 400), np.uint8), (0, 0), 3)
PAINT = np.clip((PAINT.astype(float) - PAINT.mean()) * 6 + 128, 0, 255).astype(np.uint8)


def view(x_m, y_m, rgb=True, depth=True):
    """The wall z = 1.5 + 0.2 sin 4x · cos 3y, painted, seen from x, y along z: rays meet it where geometry says."""
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    ray = np.stack([(u - 159.5) / 280, (v - 119.5) / 280], axis=-1)
    z = np.full(SHAPE, 1.5)
    for _ in range(60):
        place = np.array([x_m, y_m]) + ray * z[..., None]
        z = 0.5 * z + 0.5 * (1.5 + 0.2 * np.sin(4 * place[..., 0]) * np.cos(3 * place[..., 1]))
    grey = cv2.remap(PAINT, *(100 * (place + 1.5).astype(np.float32)).transpose(2, 0, 1), cv2.INTER_LINEAR)
    image = np.repeat(grey[..., None], 3, axis=2) if rgb else None
    seen = z.astype(np.float32) if depth else np.full(SHAPE, np.nan, np.float32)
    sigma, trust = np.full(SHAPE, 0.02, np.float32), np.ones(SHAPE, np.float32)
    return FusedFrame(0.0, seen, sigma, trust, np.zeros(SHAPE, np.uint8), image, INTRINSICS, None, "splat")


def test_a_walk_is_followed_and_a_blind_frame_gets_no_pose():
    odometry = Odometry()
    np.testing.assert_array_equal(odometry.push(view(0, 0)), np.eye(4))
    places = [(0.02, 0.0), (0.04, -0.02), None, (0.06, -0.04)]
    for place in places:
        pose = odometry.push(view(0, 0, depth=False) if place is None else view(*place))
        if place is None:
            assert pose is None
        else:
            # A small turn and a small step are hardly told apart; where points come to lie is.
            points = cloud(view(*place)).points_m.astype(float)
            off = points @ pose[:3, :3].T + pose[:3, 3] - points - [*place, 0]
            assert np.median(np.linalg.norm(off, axis=1)) < 0.006
    assert odometry.lost == 1


def test_colour_is_needed():
    with pytest.raises(Refusal, match="no rgb"):
        Odometry().push(view(0, 0, rgb=False))

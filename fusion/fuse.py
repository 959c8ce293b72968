"""Fusion of histograms with the camera's image: one frame, and a recording frame by frame."""

from collections.abc import Iterator

import numpy as np

from fusion.depths import zone_depths
from fusion.fused import NO_ZONE, FusedFrame
from fusion.motion import Earlier, Motion
from fusion.range_response import RangeResponse
from fusion.rig import given
from fusion.sight import Sight
from fusion.splat import Images, splat
from fusion.unmix import unmix
from fusion.zone_view import ZoneDepths
from recordings.encoded import decoded
from recordings.refusal import Refusal
from recordings.stream import Stream

METHODS = ("splat", "unmix")


def fuse_frame(
    counts: np.ndarray,
    rgb: np.ndarray | bytes | None,
    sight: Sight,
    response: RangeResponse,
    method: str = METHODS[-1],
    *,
    timestamp_s: float = 0.0,
    pose: np.ndarray | None = None,
    depths: ZoneDepths | None = None,
    motion: Motion | None = None,
) -> FusedFrame:
    """Depth for every pixel of the camera from one frame of histograms.

    counts: (P, T) photon counts. rgb: (H, W, 3) uint8, or PNG or JPEG bytes, None where the camera gave nothing.
    method: one of METHODS. pose: (4, 4) world from camera. depths: what `zone_depths` found in these counts, where that
    is known. motion: an earlier image and how the camera moved since, of which unmixing makes use. A zone that is dead,
    saturated or sees nothing says nothing; pixels that only such zones see have no depth. Raises `Refusal` where shapes
    do not fit.
    """
    expect_method(method)
    image = _image(rgb, sight.shape)
    seen = zone_depths(counts, response) if depths is None else depths
    at = None if pose is None else np.asarray(pose, float)
    if method == "splat":
        depth, sigma, confidence, zones = splat(sight, seen)
    else:
        depth, sigma, confidence, zones = _unmixed(sight, seen, image, motion)
    return FusedFrame(float(timestamp_s), depth, sigma, confidence, zones, image, sight.intrinsics, at, method)


def fuse(
    passing: Stream, sight: Sight, response: RangeResponse, method: str = METHODS[-1], *, alone: bool = False
) -> Iterator[tuple[FusedFrame, ZoneDepths]]:
    """The frames of a recording, fused one after another as they pass, and what the zones saw in each.

    passing: with frames that were checked, as `fusion.rig.open_rig` gives them. alone: whether each frame is
    taken by itself, as if it had no pose.
    """
    expect_method(method)
    earlier = Earlier(sight)
    for frame in passing.frames:
        seen = zone_depths(frame["counts"], response)
        pose = frame.get("camera_pose")
        fused = fuse_frame(
            frame["counts"],
            given(frame, passing.static, "rgb"),
            sight,
            response,
            method,
            timestamp_s=float(frame["timestamp_s"]),
            pose=pose,
            depths=seen,
            motion=None if alone else earlier.motion(pose, seen.typical_m),
        )
        earlier.add(fused.rgb, fused.pose, seen.typical_m)
        yield fused, seen


def _unmixed(sight: Sight, seen: ZoneDepths, image: np.ndarray | None, motion: Motion | None) -> Images:
    """Depth by unmixing, with footprints where the zones' mean ranges put them."""
    depth, sigma, confidence = unmix(sight.moved(seen.mean_m), seen, image, motion=motion)
    zones = splat(sight, seen)[3]
    zones[~np.isfinite(depth)] = NO_ZONE
    return depth, sigma, confidence, zones


def expect_method(method: str) -> None:
    """Refuse a method that there is not."""
    if method not in METHODS:
        raise Refusal(f"method {method!r} is unknown, expected {' or '.join(METHODS)}")


def _image(rgb: np.ndarray | bytes | None, shape: tuple[int, int]) -> np.ndarray | None:
    """(H, W, 3) uint8, refused where it does not lie on the grid."""
    if rgb is None:
        return None
    image = decoded(rgb, shape, "rgb") if isinstance(rgb, bytes) else np.asarray(rgb)
    if image.shape != (*shape, 3) or image.dtype != np.uint8:
        raise Refusal(f"rgb holds {image.dtype.name} of shape {image.shape}, expected uint8 of shape {(*shape, 3)}")
    return image

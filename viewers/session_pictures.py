"""Images and clouds as a session keeps them: compressed, and no finer than a person looks."""

from dataclasses import replace

import cv2
import numpy as np
import rerun as rr

from fusion.cloud import Cloud, cloud
from fusion.fused import FusedFrame
from recordings.encoded import encoded_size

JPEG_QUALITY = 85
PER_METRE = 1000.0  # 16 bits of depth: millimetres up to 65 m
MOST_MM = 65535
TOUCHING = 0.7  # radius of a point over the distance to the next
JPEG, PNG = "image/jpeg", "image/png"
# Depth is known no finer, and to pack all of 848 x 480 pixels takes ten times as long.
DEPTH_PIXELS, SIGMA_PIXELS = 1 << 16, 1 << 15


def picture(rgb: np.ndarray | bytes) -> tuple[rr.EncodedImage, tuple[int, int]]:
    """A colour image, (H, W, 3) uint8 as JPEG, bytes of a PNG or JPEG as they are; and its height and width."""
    if isinstance(rgb, bytes):
        size = encoded_size(rgb, "rgb")
        return rr.EncodedImage(contents=rgb, media_type=PNG if rgb.startswith(b"\x89PNG") else JPEG), size
    blue_first = cv2.cvtColor(np.ascontiguousarray(rgb, np.uint8), cv2.COLOR_RGB2BGR)
    packed = cv2.imencode(".jpg", blue_first, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    return rr.EncodedImage(contents=packed, media_type=JPEG), rgb.shape[:2]


def every(shape: tuple[int, int], most: int) -> int:
    """The step at which an image of `shape` has `most` pixels or fewer."""
    return max(1, int(np.ceil(np.sqrt(shape[0] * shape[1] / most))))


def metres(values_m: np.ndarray, most: int, colormap: str, range_m: tuple[float, float]) -> rr.EncodedDepthImage:
    """(H, W) metres as millimetres in a PNG of 16 bits, 0 where they are not finite, of at most so many pixels."""
    step = every(values_m.shape, most)
    thin = values_m[step // 2 :: step, step // 2 :: step]
    scaled = np.nan_to_num(thin * np.float32(PER_METRE), nan=0.0, posinf=0.0, neginf=0.0)
    whole = np.rint(np.clip(scaled, 0, MOST_MM)).astype(np.uint16)
    packed = cv2.imencode(".png", whole, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
    return rr.EncodedDepthImage(
        blob=packed, media_type=PNG, meter=PER_METRE, colormap=colormap, depth_range=np.multiply(range_m, PER_METRE)
    )


def grey(values: np.ndarray, most: int) -> rr.EncodedImage:
    """(H, W) values 0 to 1 as a PNG of 8 bits of at most so many pixels; black where they are no numbers."""
    step = every(values.shape, most)
    thin = values[step // 2 :: step, step // 2 :: step]
    whole = (255 * np.clip(np.nan_to_num(thin), 0, 1)).astype(np.uint8)
    packed = cv2.imencode(".png", whole, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
    return rr.EncodedImage(contents=packed, media_type=PNG)


def thin_cloud(fused: FusedFrame, most: int) -> Cloud:
    """At most about so many points of a frame: of every n-th pixel of every n-th row."""
    step = every((np.count_nonzero(fused.known), 1), most)
    first = step // 2
    parts = {
        name: None if image is None else image[first::step, first::step]
        for name in ("depth_m", "sigma_m", "confidence", "zones", "rgb")
        for image in [getattr(fused, name)]
    }
    # x = first + step · x_thin
    to_thin = np.array([[1 / step, 0, -first / step], [0, 1 / step, -first / step], [0, 0, 1]])
    return cloud(replace(fused, **parts, intrinsics=to_thin @ fused.intrinsics))


def points(shown: Cloud, most: int, pose: np.ndarray | None, by_zone: np.ndarray) -> rr.Points3D:
    """At most so many points of a cloud in the camera's frame, taken to the world by `pose` (4, 4), and about as large
    as they lie apart; of the colours `by_zone` (256, 3) where there was no image.
    """
    step = max(1, -(-len(shown) // most))
    at = shown.points_m[::step]
    colours = by_zone[shown.zones[::step]] if shown.colours is None else shown.colours[::step]
    radius = TOUCHING * spacing(at)
    if pose is not None:
        at = at @ pose[:3, :3].T.astype(np.float32) + pose[:3, 3].astype(np.float32)
    return rr.Points3D(at, colors=colours, radii=radius)


def spacing(points_m: np.ndarray) -> float:
    """How far apart (N, 3) points of a camera's view lie, metres, were they spread evenly at their median depth."""
    depth = points_m[:, 2]
    seen = points_m[depth > 0]
    if not len(seen):
        return 0.0
    x, y = seen[:, 0] / seen[:, 2], seen[:, 1] / seen[:, 2]
    area = float(np.ptp(x) * np.ptp(y))
    return float(np.median(seen[:, 2])) * float(np.sqrt(area / len(seen)))

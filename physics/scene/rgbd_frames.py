"""Colour and depth images side by side in two folders, however the folders are called."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from physics.scene.material import reflectance_of_colour
from physics.scene.view import View
from recordings.refusal import Refusal

# Frames come without times; such cameras take thirty a second.
FRAME_S = 1 / 30


def paired(colour: Path, depth: Path) -> list[tuple[Path, Path]]:
    """Files of the two folders with one stem, in the order of their numbers or names."""
    by_stem = {path.stem: path for path in colour.iterdir() if path.suffix.lower() in (".png", ".jpg", ".jpeg")}
    depths = [path for path in depth.iterdir() if path.suffix.lower() in (".png", ".pgm")]
    pairs = [(by_stem[path.stem], path) for path in depths if path.stem in by_stem]
    lonely = {path.stem for path in depths} ^ by_stem.keys()
    if lonely or not pairs:
        some = f"{sorted(lonely)[0]!r} has not both" if lonely else "there is none"
        raise Refusal(f"{depth.parent}: expected a colour and a depth image of every name, {some}")
    return sorted(pairs, key=lambda pair: (int(pair[1].stem) if pair[1].stem.isdecimal() else 0, pair[1].stem))


def views(pairs: list[tuple[Path, Path]], per_metre: float, poses: np.ndarray) -> Iterator[View]:
    """A view of every pair; depth in units of 1/`per_metre`, 0 where unknown; reflectance is guessed from colour."""
    if len(poses) != len(pairs):
        raise Refusal(f"{pairs[0][1].parent.parent}: has {len(poses)} poses, expected {len(pairs)}, one for each frame")
    for i, ((colour, depth), pose) in enumerate(zip(pairs, poses, strict=True)):
        raw = _read(depth, cv2.IMREAD_UNCHANGED)
        if raw.dtype != np.uint16 or raw.ndim != 2:
            raise Refusal(f"{depth}: holds {raw.dtype.name} in {raw.ndim} axes, expected a grey image of 16 bits")
        bgr = _read(colour, cv2.IMREAD_COLOR)
        if bgr.shape[:2] != raw.shape:
            raise Refusal(f"{colour}: has {bgr.shape[1]} x {bgr.shape[0]} pixels, expected those of {depth.name}")
        rgb = np.ascontiguousarray(bgr[..., ::-1])
        metres = np.where(raw > 0, raw / np.float32(per_metre), np.float32(np.nan)).astype(np.float32)
        yield View(i * FRAME_S, metres, reflectance_of_colour(rgb), rgb=colour.read_bytes(), camera_pose=pose)


def _read(path: Path, how: int) -> np.ndarray:
    """An image; refuses what is none."""
    data = np.frombuffer(path.read_bytes(), np.uint8)
    image = cv2.imdecode(data, how) if data.size else None
    if image is None:
        raise Refusal(f"{path}: is no image that can be read")
    return image

"""Depth images and their errors, side by side."""

from pathlib import Path

import cv2
import numpy as np

from fusion.quality.trial import Trial

SHOWN = ("guided filter", "splat", "unmix")
FRAMES, WIDTH_PX = 3, 160
# Colours end at this depth, and at this error.
FAR_M, OFF_M = 6.5, 1.5


def draw(path: Path, trial: Trial, images: dict[str, list[np.ndarray]]) -> None:
    """A PNG with a column for each of the first frames: by method depth, then error, red too far and blue too near."""
    rows = []
    judged = trial.seen & np.isfinite(trial.depth_m)
    for name in SHOWN:
        frames = list(zip(images[name], trial.depth_m, judged, strict=True))[:FRAMES]
        depth = [_shown(_rainbow(image), trial.seen) for image, _, _ in frames]
        off = [_shown(_diverging(image - truth), where) for image, truth, where in frames]
        rows += [_labelled(np.hstack(depth), name), _labelled(np.hstack(off), f"{name}, error")]
    if not cv2.imwrite(str(path), np.vstack(rows), [cv2.IMWRITE_PNG_COMPRESSION, 9]):
        raise OSError(f"{path} could not be written")


def _rainbow(depth: np.ndarray) -> np.ndarray:
    """(H, W, 3) from blue at 0 m to red at FAR_M."""
    return cv2.applyColorMap(np.uint8(np.clip(np.nan_to_num(depth) / FAR_M, 0, 1) * 255), cv2.COLORMAP_TURBO)


def _diverging(error: np.ndarray) -> np.ndarray:
    """(H, W, 3) in OpenCV's order of colours: white at 0, red at OFF_M, blue at -OFF_M."""
    part = np.clip(np.nan_to_num(error) / OFF_M, -1, 1)
    far, near = np.maximum(part, 0), np.maximum(-part, 0)
    return np.uint8(255 * np.stack([1 - far, 1 - far - near, 1 - near], axis=-1))


def _shown(image: np.ndarray, where: np.ndarray) -> np.ndarray:
    """(h, w, 3) thumbnail, black elsewhere."""
    height = round(WIDTH_PX * image.shape[0] / image.shape[1])
    return cv2.resize(image * where[..., None].astype(np.uint8), (WIDTH_PX, height), interpolation=cv2.INTER_AREA)


def _labelled(row: np.ndarray, label: str) -> np.ndarray:
    return cv2.putText(row, label, (4, 12), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (255, 255, 255), 1, cv2.LINE_AA)

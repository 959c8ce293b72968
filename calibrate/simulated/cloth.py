"""The black cloth behind the arm, and the camera's noise in the dark."""

import cv2
import numpy as np

# Frames take turns with these, so that noise that belongs to a place (weak light, shading correction) is not
# frozen.
PLATES = 12
# Standard deviations of red, green, blue in grey levels after tone mapping, everywhere and in the cloth's
# middle.
NOISE = np.array([2.0, 1.6, 2.1])
CLOTH_NOISE = np.array([3.2, 2.3, 3.3])
FOLDS = 7


def cloth_plates(height: int, width: int, rng: np.random.Generator, noise: float) -> list[np.ndarray]:
    """Pictures (H, W, 3) uint8 RGB of one cloth, each with its own noise, stronger towards the corners."""
    cloth = _cloth(height, width, rng)
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    amplitude = (noise * (0.9 + 0.6 * (x**2 + y**2)))[..., None] * CLOTH_NOISE
    plates = (cloth + amplitude * _grain(height, width, rng) for _ in range(PLATES if noise else 1))
    return [np.clip(plate, 0, 255).round().astype(np.uint8) for plate in plates]


def noise_tile(height: int, width: int, rng: np.random.Generator, noise: float) -> np.ndarray:
    """(height, width, 3) uint8 noise around 128."""
    return (128 + noise * NOISE * _grain(height, width, rng)).round().astype(np.uint8)


def _grain(height: int, width: int, rng: np.random.Generator) -> np.ndarray:
    """Noise (height, width, 3) of unit variance, smeared over neighbours as demosaicing leaves it."""
    white = rng.standard_normal((height, width, 3), np.float32)
    grain = cv2.GaussianBlur(white, (0, 0), 0.8)
    return grain / grain.std()


def _cloth(height: int, width: int, rng: np.random.Generator) -> np.ndarray:
    """Warm black, lighter to the lower right, with soft folds and a faint weave; (H, W, 3) floats."""
    y, x = np.mgrid[0 : 1 : height * 1j, 0 : 1 : width * 1j].astype(np.float32)
    level = 25 + 10 * y + 26 * y * x**4 - 3 * (1 - y) * x
    for _ in range(FOLDS):
        heading, place, width_px = rng.uniform(-0.5, 0.5), rng.uniform(0.1, 0.9), rng.uniform(0.004, 0.012)
        level += rng.uniform(-2.5, 2.5) * np.exp(-0.5 * ((x - place - heading * (y - 0.5)) / width_px) ** 2)
    for size, depth in ((24, 1.5), (3, 0.8)):
        weave = cv2.GaussianBlur(rng.standard_normal((height, width), np.float32), (0, 0), size)
        level += depth * weave / weave.std()
    return level[..., None] * np.array([1.22, 1.0, 0.86], np.float32)

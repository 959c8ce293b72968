"""The light the TMF882x floods its field with (datasheet DS000693 v8, field of illumination)."""

from dataclasses import dataclass

import numpy as np

# Full widths in degrees, x and y, at which the intensity has fallen to a level.
LEVELS = np.array([0.5, np.exp(-2), 0.05])
WIDTHS_DEG = np.array([[30.0, 32.0], [41.0, 47.0], [47.0, 57.0]])

# The dark seam at x = 0 between the two halves of the micro-lens array: 15 to 20 % deep, Figure 42.
SEAM_DEPTH = 0.17
SEAM_SIGMA_DEG = 0.8

# Fine texture of the micro-lens array: +-10 % (two standard deviations) in grains of a degree or two.
TEXTURE_SIGMA = 0.05
TEXTURE_WAVES = 24
TEXTURE_PERIOD_DEG = (2.5, 7.0)


@dataclass(frozen=True, eq=False)
class Flood:
    """Radiant intensity of the flood relative to its plateau.

    half_width_deg, power: (2,) of the super-Gaussian exp(-|angle / half_width|^power) along x and y.
    wave_per_deg: (M, 2) radians per degree, phase: (M,) radians of the waves that make the texture; M may be
    0.
    """

    half_width_deg: np.ndarray
    power: np.ndarray
    wave_per_deg: np.ndarray
    phase: np.ndarray

    def intensity(self, tan_x: np.ndarray, tan_y: np.ndarray) -> np.ndarray:
        """Intensity towards directions of these tangents; broadcasts."""
        x, y = np.degrees(np.arctan(tan_x)), np.degrees(np.arctan(tan_y))
        fall = np.exp(
            -(np.abs(x / self.half_width_deg[0]) ** self.power[0]) - np.abs(y / self.half_width_deg[1]) ** self.power[1]
        )
        seam = 1 - SEAM_DEPTH * np.exp(-0.5 * (x / SEAM_SIGMA_DEG) ** 2)
        texture = np.ones(np.broadcast_shapes(x.shape, y.shape))
        for (along_x, along_y), phase in zip(self.wave_per_deg, self.phase, strict=True):
            texture += TEXTURE_SIGMA * np.sqrt(2 / TEXTURE_WAVES) * np.cos(along_x * x + along_y * y + phase)
        return fall * seam * texture


def tmf882x_flood(rng: np.random.Generator | None = None) -> Flood:
    """The flood of one device: its texture drawn from `rng`, none where that is None.

    The two parameters of each super-Gaussian are the straight line through ln(-ln level) over ln(half width).
    """
    lines = [np.polyfit(np.log(w / 2), np.log(-np.log(LEVELS)), 1) for w in WIDTHS_DEG.T]
    power = np.array([slope for slope, _ in lines])
    half_width = np.array([np.exp(-offset / slope) for slope, offset in lines])
    if rng is None:
        return Flood(half_width, power, np.empty((0, 2)), np.empty(0))
    heading, phase = rng.uniform(0, 2 * np.pi, (2, TEXTURE_WAVES))
    wave = 2 * np.pi / rng.uniform(*TEXTURE_PERIOD_DEG, TEXTURE_WAVES)
    return Flood(half_width, power, wave[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1), phase)

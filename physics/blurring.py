"""Maps that are blurred, or sharpened, along with what they were: by a discrete Gaussian, a disc, a haze, a power."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dctn, idctn
from scipy.special import j1

from physics.workers import in_parallel


@dataclass(frozen=True)
class Blur:
    """Maps (P, Y, X) of zones, blurred by a variance in pixels squared; sharpened where it is negative.

    Then hazy, and steeper. All as the parameters of `footprint_blur`; steps_px: of what is coarse, down the image and
    along it.
    """

    variance_px2: float
    taller: float = 0.0
    flat: float = 0.0
    amount: float = 1.0
    kept: float = 1.0
    haze: float = 0.0
    wide_px2: float = 2500.0
    steeper: float = 0.0
    coarse: float = 0.0
    steps_px: tuple[float, float] = (1.0, 1.0)

    def __call__(self, table: np.ndarray) -> np.ndarray:
        """(P, Y, X) double: what little a slight blur takes away is not lost in rounding."""
        return np.stack(in_parallel(self._zone, table))

    def _zone(self, zone: np.ndarray) -> np.ndarray:
        """(Y, X) of one zone."""
        zone = zone.astype(float)
        zone = self._blurred(zone) if self.variance_px2 else zone
        if self.haze:
            zone = zone + self.haze * (blurred(zone, self.wide_px2) - zone)
        most = zone.max()
        if not self.steeper or not most > 0:
            return zone
        steep = np.maximum(zone / most, 0) ** (1 + self.steeper)
        return steep * (zone.sum() / steep.sum())

    def _blurred(self, zone: np.ndarray) -> np.ndarray:
        """(Y, X) of one zone, blurred or sharpened."""
        spread = blurred(zone, abs(self.variance_px2), self.taller, self.flat, self.coarse, self.steps_px)
        if self.variance_px2 > 0:
            return spread
        sharp = np.maximum(zone + self.amount * (zone - spread), 0)
        total = sharp.sum()
        return sharp * (zone.sum() / total) ** self.kept if total > 0 else zone


def blurred(
    image: np.ndarray,
    variance_px2: float,
    taller: float = 0.0,
    flat: float = 0.0,
    coarse: float = 0.0,
    steps_px: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """(Y, X) after diffusion for a time of that variance, no flux through the edges; faster down where `taller`.

    The cosine of frequency ω decays with 1 − cos ω: eigenvalue of half the second difference. Where `coarse`, so much
    of the kernel steps by d pixels, steps_px down and along, and that decays with (1 − cos ωd)/d². Where `flat`, so
    much of it is under a disc instead, whose variance along each axis is a fourth of its radius squared, and whose
    transform is 2 J₁(ωR) / (ωR) (Bracewell, The Fourier Transform and Its Applications, chapter 12).
    """
    each = variance_px2 * np.exp(taller), variance_px2 * np.exp(-taller)
    waves = tuple(np.pi * np.arange(n) / n for n in image.shape)

    def diffused(steps: tuple[float, float]) -> np.ndarray:
        down, along = (one * (1 - np.cos(wave * d)) / d**2 for one, wave, d in zip(each, waves, steps, strict=True))
        return np.exp(-down)[:, None] * np.exp(-along)

    decay = diffused((1.0, 1.0))
    if coarse:
        decay += coarse * (diffused(steps_px) - decay)
    if flat:
        radii = (2 * np.sqrt(one) * wave for one, wave in zip(each, waves, strict=True))
        across = np.maximum(np.hypot.outer(*radii), 1e-9)
        decay = (1 - flat) * decay + flat * 2 * j1(across) / across
    return np.maximum(idctn(dctn(image) * decay), 0)

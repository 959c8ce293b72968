"""Maps that are blurred, or sharpened, along with what they were: by a discrete Gaussian, a disc, a haze, a power."""

import threading
import weakref
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.fft import dctn, idctn
from scipy.special import j1

from physics.workers import in_parallel

# What goes beyond the image is followed for so many standard deviations, in steps of so many pixels.
FAR, RIM_PX = 4.0, 64


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
    lost: float = 0.0
    steps_px: tuple[float, float] = (1.0, 1.0)

    def __call__(self, table: np.ndarray) -> np.ndarray:
        """(P, Y, X) double: what little a slight blur takes away is not lost in rounding."""
        said = abs(self.variance_px2), self.taller, self.flat, self.coarse, self.steps_px
        ways = []
        reach = _reach(table.shape[1:], abs(self.variance_px2), self.taller)
        for part, rim in ((1 - self.lost, (0, 0)), (self.lost, reach)):
            if part and self.variance_px2:
                spectra = _spectra(table, rim)
                ways.append((part, rim, spectra, transform(spectra.shape[1:], *said)))
        return np.stack(in_parallel(partial(self._zone, table, ways), range(len(table))))

    def _zone(self, table: np.ndarray, ways: list[tuple], number: int) -> np.ndarray:
        """(Y, X) of one zone. ways: part that is blurred so, the rim beside it, cosines of all zones, what passes."""
        zone = table[number].astype(float)
        if ways:
            spread = 0.0
            for part, (down, along), spectra, passed in ways:
                made = idctn(spectra[number] * passed, overwrite_x=True)
                spread = spread + part * made[down : down + zone.shape[0], along : along + zone.shape[1]]
            zone = self._blurred(zone, np.maximum(spread, 0))
        if self.haze:
            hazy = blurred(zone, self.wide_px2)
            if self.lost:
                hazy += self.lost * (_within(zone, self.wide_px2, _reach(zone.shape, self.wide_px2)) - hazy)
            zone = zone + self.haze * (hazy - zone)
        most = zone.max()
        if not self.steeper or not most > 0:
            return zone
        steep = np.maximum(zone / most, 0) ** (1 + self.steeper)
        return steep * (zone.sum() / steep.sum())

    def _blurred(self, zone: np.ndarray, spread: np.ndarray) -> np.ndarray:
        """(Y, X) of one zone, blurred, as it is `spread`, or sharpened."""
        if self.variance_px2 > 0:
            return spread
        sharp = np.maximum(zone + self.amount * (zone - spread), 0)
        total = sharp.sum()
        return sharp * (zone.sum() / total) ** self.kept if total > 0 else zone


def blurred(image: np.ndarray, variance_px2: float) -> np.ndarray:
    """(Y, X) after diffusion for a time of that variance, no flux through the edges."""
    return np.maximum(idctn(dctn(image) * transform(image.shape, variance_px2)), 0)


def _reach(shape: tuple[int, int], variance_px2: float, taller: float = 0.0) -> tuple[int, int]:
    """Pixels above and below, and to either side, beyond which next to nothing is blurred."""
    sides = (np.sqrt(variance_px2 * np.exp(way * taller)) for way in (1, -1))
    return tuple(min(RIM_PX * int(np.ceil(FAR * one / RIM_PX)), n) for one, n in zip(sides, shape, strict=True))


def _within(image: np.ndarray, variance_px2: float, rim: tuple[int, int]) -> np.ndarray:
    """(Y, X) the same with nothing beyond the edges, which what is blurred passes; followed so far down and along."""
    down, along = rim
    spread = blurred(np.pad(image, ((down, down), (along, along))), variance_px2)
    return spread[down : down + image.shape[0], along : along + image.shape[1]]


def transform(
    shape: tuple[int, int],
    variance_px2: float,
    taller: float = 0.0,
    flat: float = 0.0,
    coarse: float = 0.0,
    steps_px: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """(Y, X) by which cosines of an image fall in diffusion of that variance; faster down where `taller`.

    The cosine of frequency ω decays with 1 − cos ω: eigenvalue of half the second difference. Where `coarse`, so much
    of the kernel steps by d pixels, steps_px down and along, and that decays with (1 − cos ωd)/d². Where `flat`, so
    much of it is under a disc instead, whose variance along each axis is a fourth of its radius squared, and whose
    transform is 2 J₁(ωR) / (ωR) (Bracewell, The Fourier Transform and Its Applications, chapter 12).
    """
    each = variance_px2 * np.exp(taller), variance_px2 * np.exp(-taller)
    waves = tuple(np.pi * np.arange(n) / n for n in shape)

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
    return decay


class _Spectra:
    """(P, Y, X) cosine transforms of the table that was asked for last, which fits ask for again and again."""

    def __init__(self) -> None:
        self._lock, self._of, self._made = threading.Lock(), None, {}

    def __call__(self, table: np.ndarray, rim: tuple[int, int]) -> np.ndarray:
        """To read only; with so many pixels of nothing above and below, and to either side."""
        with self._lock:
            if self._of is None or self._of() is not table:
                self._of, self._made = weakref.ref(table), {}
            if rim not in self._made:
                down, along = ((n, n) for n in rim)
                self._made = {(0, 0): self._made[0, 0]} if (0, 0) in self._made else {}
                self._made[rim] = dctn(np.pad(table.astype(float), ((0, 0), down, along)), axes=(1, 2))
            return self._made[rim]


_spectra = _Spectra()

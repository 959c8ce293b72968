"""Where in an image there may be a bright disc, and which of these places hold one."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import scipy.fft

from calibrate.patch_circle import Expected
from calibrate.patch_edge import Disc, fit_disc

# The search runs on an image reduced until the smallest disc looked for has this radius.
SMALLEST_PX = 4.0
KNOWN_WIDTH_PX = 848  # Where only one radius is looked for, there is time for a larger image.
RADIUS_STEP = 1.09
# Radii looked for where none is given, as shares of the image's width; a patch of 17.75 px in 848 is 1/48.
RADII = 1 / 100, 1 / 14
LEAST_RADIUS_PX = 3.0
NOISES = 4.0  # Gradients below this many times the median are noise.
LEAST_SHARE = 0.15
SEARCH_PX = 4.0
LEAST_SCORE = 0.2
LEAST_CONFIDENCE = 0.35
LEAST_CONTRAST = 6.0
WORST_SIGMA = 0.03


@dataclass(frozen=True)
class Candidate:
    """A circle towards whose centre brightness rises along the rim; score up to 1."""

    x_px: float
    y_px: float
    radius_px: float
    score: float


def find_discs(grey: np.ndarray, radius_px: float | None = None, limit: int = 5) -> list[Disc]:
    """Discs anywhere in an image (H, W) uint8, brighter than their surround, the most certain first.

    radius_px: of the disc, to 10 %; any between 1/100 and 1/14 of the image's width where None.
    """
    width = grey.shape[1]
    smallest = radius_px or max(RADII[0] * width, LEAST_RADIUS_PX)
    largest = radius_px or max(RADII[1] * width, smallest)
    radii = smallest * RADIUS_STEP ** np.arange(1 + round(np.log(largest / smallest) / np.log(RADIUS_STEP)))
    scale = min(1.0, max(SMALLEST_PX / smallest, KNOWN_WIDTH_PX / width if radius_px else 0))
    small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    zoom = np.array(grey.shape[::-1]) / small.shape[::-1]
    spots = candidates(small, radii / zoom[0], (0, 0), small.shape[::-1], limit)
    discs: list[Disc] = []
    for spot in spots[: 4 * limit]:
        x, y = (np.array([spot.x_px, spot.y_px]) + 0.5) * zoom - 0.5
        radius = spot.radius_px * zoom[0]
        disc = fit_disc(grey, float(x), float(y), Expected(radius), max(SEARCH_PX, 0.1 * radius))
        if disc and plausible(disc) and not any(_same(disc, other) for other in discs):
            discs.append(disc)
    return sorted(discs, key=lambda disc: -disc.confidence)[:limit]


def plausible(disc: Disc) -> bool:
    """Whether the image itself says that there is a disc."""
    certain = disc.confidence >= LEAST_CONFIDENCE and disc.sigma_px <= WORST_SIGMA * disc.radius_px
    return certain and disc.contrast >= LEAST_CONTRAST


def _same(one: Disc, other: Disc) -> bool:
    apart = np.hypot(one.x_px - other.x_px, one.y_px - other.y_px)
    return apart < 2 and abs(one.radius_px - other.radius_px) < 2


def candidates(
    grey: np.ndarray, radii_px: Sequence[float], corner: tuple[int, int], size: tuple[int, int], limit: int
) -> list[Candidate]:
    """Local maxima of `rim_scores` among centres in a box, at most `limit` a radius, best first."""
    found = []
    for radius, score in zip(radii_px, rim_scores(grey, radii_px, corner, size), strict=True):
        # A disc has one centre: what scores beside it belongs to it.
        side = 2 * int(max(radius / 2, 1)) + 1
        y, x = np.nonzero((score >= cv2.dilate(score, np.ones((side, side), np.uint8))) & (score > LEAST_SCORE))
        best = np.argsort(-score[y, x], kind="stable")[:limit]
        found += [Candidate(x[i] + corner[0], y[i] + corner[1], radius, float(score[y[i], x[i]])) for i in best]
    # Noise scores inversely to the square root of the rim's length.
    return sorted(found, key=lambda candidate: -candidate.score * candidate.radius_px**0.5)


def rim_scores(
    grey: np.ndarray, radii_px: Sequence[float], corner: tuple[int, int], size: tuple[int, int]
) -> Iterator[np.ndarray]:
    """For each radius, how well a rim fits around each centre of a box: (height, width) of `size`, -1 to 1.

    corner, size: x, y and width, height of the box, which may reach beyond the image. The gradient, shortened to at
    most 1 so that a bright edge elsewhere counts no more than the rim, is projected on the direction to the centre
    and averaged over the rim: a correlation with a ring of unit vectors (radial symmetry; Loy & Zelinsky 2003).
    Where only a share v of the rim is in the image, the mean over that share is multiplied by the square root of v.
    """
    margin = int(np.ceil(max(radii_px) + 2 * _width(max(radii_px)))) + 1
    box = (corner[0] - margin, corner[1] - margin, size[0] + 2 * margin, size[1] + 2 * margin)
    piece, inside = _cut(grey, *box), _cut(np.ones_like(grey), *box, cv2.BORDER_CONSTANT)
    gx = cv2.Sobel(piece, cv2.CV_32F, 1, 0, scale=0.125)
    gy = cv2.Sobel(piece, cv2.CV_32F, 0, 1, scale=0.125)
    length = cv2.magnitude(gx, gy)
    shorten = inside / np.sqrt(np.square(length) + (NOISES * float(np.median(length)) + 1) ** 2)
    shape = tuple(scipy.fft.next_fast_len(side, real=True) for side in piece.shape)
    fx, fy = (scipy.fft.rfft2(gradient * shorten, shape) for gradient in (gx, gy))
    middle = np.s_[margin : margin + size[1], margin : margin + size[0]]
    for radius in radii_px:
        rounded = round(radius * 4) / 4
        ring_x, ring_y, _ = _ring(shape, rounded)
        score = -scipy.fft.irfft2(fx * ring_x + fy * ring_y, shape)[middle]
        yield score if inside.all() else score / np.sqrt(_share(grey.shape, box, shape, rounded)[middle])


def _width(radius_px: float) -> float:
    """Standard deviation of the ring's thickness: blur, and half a step between radii."""
    return 0.8 + 0.03 * radius_px


def _cut(
    grey: np.ndarray, left: int, top: int, width: int, height: int, beyond: int = cv2.BORDER_REPLICATE
) -> np.ndarray:
    """A box of the image as floats, continued beyond its border."""
    x0, y0 = max(left, 0), max(top, 0)
    x1, y1 = max(min(left + width, grey.shape[1]), x0), max(min(top + height, grey.shape[0]), y0)
    piece = grey[y0:y1, x0:x1].astype(np.float32)
    if not piece.size:
        return np.zeros((height, width), np.float32)
    return cv2.copyMakeBorder(piece, y0 - top, top + height - y1, x0 - left, left + width - x1, beyond)


@lru_cache(maxsize=64)
def _share(
    image: tuple[int, int], box: tuple[int, int, int, int], shape: tuple[int, int], radius_px: float
) -> np.ndarray:
    """How much of a rim around each place of a box lies in an image of this shape, not below `LEAST_SHARE`."""
    inside = _cut(np.ones(image, np.uint8), *box, cv2.BORDER_CONSTANT)
    share = scipy.fft.irfft2(scipy.fft.rfft2(inside, shape) * _ring(shape, radius_px)[2], shape)
    return np.maximum(share, LEAST_SHARE)


@lru_cache(maxsize=64)
def _ring(shape: tuple[int, int], radius_px: float) -> tuple[np.ndarray, ...]:
    """Conjugate spectra of a ring of unit vectors, x and y, and of its weights, which sum to 1."""
    y, x = (scipy.fft.fftfreq(side, 1 / side) for side in shape)
    x, y = np.meshgrid(x, y)
    distance = np.hypot(x, y)
    weight = np.exp(-0.5 * np.square((distance - radius_px) / _width(radius_px)))
    weight /= weight.sum()
    per_distance = weight / np.maximum(distance, 1e-9)
    return tuple(
        scipy.fft.rfft2(part.astype(np.float32)).conj() for part in (per_distance * x, per_distance * y, weight)
    )

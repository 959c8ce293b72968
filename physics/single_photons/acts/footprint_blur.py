"""`footprint_blur`: photons stray a little before a zone's map decides on them."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.ndimage import correlate1d, shift
from scipy.signal import fftconvolve
from scipy.special import ive

from physics.effect import Values
from physics.single_photons.looking import looking, looking_so, table
from physics.single_photons.world import World
from recordings.maps import ResponseMaps

# Of a walk's ends, those of less probability than this on either side are left out.
REST = 1e-9
# Points each way in a pixel by which it is told how much of it lies within a disc.
FINE = 8
# What numpy calls the edges that scipy calls so.
PADDED = {"reflect": "symmetric", "constant": "constant"}


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """A pixel's photons are seen with the map's mean over the ends of their walks."""
    if not any(values[n] for n in ("variance", "haze", "steeper")):
        return world
    how = looking(world)
    said = ("variance", "amount", "kept", "taller", "flat", "haze", "wide", "steeper", "coarse", "lost")
    wide, high = how.taken.image_size
    rows, columns = world.depth_m.shape
    steps = high / rows, wide / columns
    return looking_so(world, replace(how, redrawn=redrawn(how.taken, *(values[n] for n in said), steps)))


@lru_cache(maxsize=2)
def redrawn(
    maps: ResponseMaps,
    variance_px2: float,
    amount: float = 1.0,
    kept: float = 1.0,
    taller: float = 0.0,
    flat: float = 0.0,
    haze: float = 0.0,
    wide_px2: float = 2500.0,
    steeper: float = 0.0,
    coarse: float = 0.0,
    lost: float = 0.0,
    steps_px: tuple[float, float] = (1.0, 1.0),
) -> np.ndarray:
    """(P, Y, X) table of maps after walks of this variance; sharpened where it is negative.

    Of so many photons more, the `haze`, walks are `wide`. Then maps are `steeper`: logarithms that much longer.
    """
    _, _, counts = table(maps)
    edges = ("reflect", 1 - lost), ("constant", lost)
    if variance_px2:
        said = abs(variance_px2), taller, flat, coarse, steps_px
        spread = sum(part * walked(counts, *said, edge) for edge, part in edges if part)
        counts = spread if variance_px2 > 0 else sharpened(counts, spread, amount, kept)
    if haze:
        far = (part * strayed(counts, wide_px2, edge=edge) for edge, part in edges if part)
        counts = (1 - haze) * counts + haze * sum(far)
    if not steeper:
        return counts
    with np.errstate(divide="ignore"):
        grey = np.log(np.clip(counts, 0, None) / counts.max(axis=(1, 2), keepdims=True))
    steep = np.exp((1 + steeper) * grey)
    return steep * (counts.sum(axis=(1, 2), dtype=float) / steep.sum(axis=(1, 2), dtype=float))[:, None, None]


def walked(
    counts: np.ndarray,
    variance_px2: float,
    taller: float,
    flat: float,
    coarse: float,
    steps_px: tuple[float, float],
    edge: str,
) -> np.ndarray:
    """(P, Y, X) counts after walks of this variance; beyond the table it is as `edge` says, mirrored or nothing."""
    spread = strayed(counts, variance_px2, taller, edge=edge)
    if coarse:
        spread = (1 - coarse) * spread + coarse * strayed(counts, variance_px2, taller, steps_px, edge)
    if flat:
        spread = (1 - flat) * spread + flat * under_a_disc(counts, variance_px2, taller, edge)
    return spread


def sharpened(counts: np.ndarray, spread: np.ndarray, amount: float = 1.0, kept: float = 1.0) -> np.ndarray:
    """(P, Y, X) counts less `amount` times their change to those of walks, `spread`; none below 0.

    Sums are as they were where `kept` is 1, and less of the way back to that where it is less.
    """
    sharp = np.clip(counts - amount * (spread - counts), 0, None)
    back = counts.sum(axis=(1, 2), dtype=float) / np.maximum(sharp.sum(axis=(1, 2)), np.finfo(float).tiny)
    return sharp * back[:, None, None] ** kept


def strayed(
    counts: np.ndarray,
    variance_px2: float,
    taller: float = 0.0,
    steps_px: tuple[float, float] = (1.0, 1.0),
    edge: str = "reflect",
) -> np.ndarray:
    """(P, Y, X) means of counts at the ends of walks, which have exp(± taller) times this variance down and along.

    A photon steps to its right or left at random times, each direction as often: it ends where the difference of two
    Poisson numbers says, which has the variance of their sum (Skellam, J. R. Stat. Soc. 109, 1946, 296). At the edge of
    the table it turns back, as if there was a mirror, or it ends where nothing is (`edge` "constant"). steps_px: how
    far a step goes, down and along.
    """
    for axis, way, step in ((1, 1, steps_px[0]), (2, -1, steps_px[1])):
        walk = variance_px2 * np.exp(way * taller) / 2 / step**2
        # Bernstein's inequality for steps of one: what lies beyond is less than exp(-k²/2 / (2 walk + k/3)).
        rare = -np.log(REST)
        reach = int(np.ceil(rare / 3 + np.sqrt(rare**2 / 9 + 4 * rare * walk)))
        number = np.arange(-reach, reach + 1)
        ends = ive(np.abs(number), 2 * walk)
        ends /= ends.sum()
        counts = counts.astype(float)
        if step == 1:  # From pixel to pixel: nothing has to be read between them.
            counts = correlate1d(counts, ends, axis=axis, mode=edge)
        else:
            far = [(np.arange(3) == axis) * step * k for k in number]
            each = zip(ends, far, strict=True)
            counts = sum(part * shift(counts, away, order=1, mode=edge) for part, away in each if part > REST)
    return counts


def under_a_disc(counts: np.ndarray, variance_px2: float, taller: float = 0.0, edge: str = "reflect") -> np.ndarray:
    """(P, Y, X) means of counts over a disc, or an ellipse that has exp(± taller) times this variance down and along.

    Even over an ellipse of half-axis a, places along it have the variance a²/4. Of a pixel at its rim, the part counts
    that lies within, by points evenly in it.
    """
    down, along = (2 * np.sqrt(variance_px2 * np.exp(way * taller)) for way in (1, -1))
    rows, columns = (int(np.ceil(half)) + 1 for half in (down, along))
    within = (np.arange(FINE) + 0.5) / FINE - 0.5
    y, x = (np.add.outer(np.arange(-n, n + 1), within).ravel() for n in (rows, columns))
    inside = ((y / down) ** 2)[:, None] + (x / along) ** 2 <= 1
    kernel = inside.reshape(2 * rows + 1, FINE, 2 * columns + 1, FINE).mean(axis=(1, 3))
    padded = np.pad(counts.astype(float), ((0, 0), (rows, rows), (columns, columns)), mode=PADDED[edge])
    return np.maximum(fftconvolve(padded, kernel[None] / kernel.sum(), mode="valid", axes=(1, 2)), 0)

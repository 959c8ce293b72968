"""How each departure acts on the counts of a calibration, and from where its shapes are sought."""

import numpy as np

from mismatch.calibrations.departure import Shapes
from mismatch.calibrations.pair import Pair

# What a factor may be at most, as a logarithm: beyond, a fit has lost its way.
MOST_LOG = 3.0
FOCAL_OF_WIDTH = 0.72  # a camera of 70 degrees; only bins / focal² is identified well, so that its value matters little
BINS = (4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 24.0)


def times(light: np.ndarray, logarithm: np.ndarray) -> np.ndarray:
    """Light times a factor."""
    return light * np.exp(np.clip(logarithm, -MOST_LOG, MOST_LOG))


def relative(pair: Pair) -> np.ndarray:
    """(K, 2) position from the image's centre, in half widths."""
    return (pair.xy - np.array(pair.size) / 2) / (pair.size[0] / 2)


def path(pair: Pair, shapes: dict) -> np.ndarray:
    """(K,) range of a flat scan, in bins: the foot of the perpendicular at (foot_x, foot_y), its length `bins`."""
    rho2 = (pair.xy[:, 0] - shapes["foot_x"]) ** 2 + (pair.xy[:, 1] - shapes["foot_y"]) ** 2
    return shapes["bins"] * np.sqrt(1 + rho2 / (FOCAL_OF_WIDTH * pair.size[0]) ** 2)


def phase(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A first harmonic of the range in bins."""
    turns = 2 * np.pi * path(pair, shapes)
    return times(light, by["cos"] * np.cos(turns) + by["sin"] * np.sin(turns))


def feet(pair: Pair) -> Shapes:
    """Feet of the perpendicular near the middle, at all distances."""
    width, height = pair.size
    xs, ys = width * np.array([0.4, 0.5, 0.6]), height * np.array([0.4, 0.5, 0.6])
    return tuple((float(x), float(y), bins) for x in xs for y in ys for bins in BINS)


def centres(pair: Pair) -> Shapes:
    """Near the middle."""
    width, height = pair.size
    return tuple((width * u, height * v) for u in (0.4, 0.5, 0.6) for v in (0.4, 0.5, 0.6))


def shift(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Displaced in the image."""
    return pair.moved(light, np.array([by["x"], by["y"]]))


def turn(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Displaced, turned and magnified about the centre of the image."""
    out = relative(pair)
    swirl = np.stack([-out[:, 1], out[:, 0]], axis=1)
    return pair.moved(light, np.array([by["x"], by["y"]]) + by["scale"] * out + by["turn"] * swirl)


def lag(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Displaced along the path of the scan."""
    return pair.moved(light, by["captures"] * pair.along)


def blur(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Blurred by `variance`, px²."""
    # To first order in the variance a blur adds half of it times the second derivative, here over a patch's width.
    h = 12.0
    at = [pair.kernel.response(*(pair.xy + step).T) for step in ((h, 0), (-h, 0), (0, h), (0, -h))]
    laplacian = (sum(at) - 4 * pair.kernel.response(*pair.xy.T)) / h**2
    return np.maximum(light + by["variance"] / 2 * laplacian, 0)


def stray(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A share of the sum over zones."""
    return np.maximum(light + by["share"] * light.sum(axis=0), 0)


def ghost(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A share of each zone's own map, mirrored through a point."""
    mirrored = 2 * np.array([shapes["centre_x"], shapes["centre_y"]]) - pair.xy
    return np.maximum(light + by["share"] * pair.kernel.response(*mirrored.T), 0)


def brightness(light: np.ndarray) -> np.ndarray:
    """(P, K) part of the largest response of any zone."""
    return light / max(light.max(), 1e-12)


def pile_up(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Less, in proportion to what the zone counts and to what all zones together count."""
    whole = light.sum(axis=0)
    return times(light, -by["own"] * brightness(light) - by["all"] * whole / max(whole.max(), 1e-12))


def crowding(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """Besides, bent, and by the part of the light that the zone takes, which says how many detectors share it."""
    part = light / np.maximum(light.sum(axis=0), 1e-12)
    lost = by["bent"] * brightness(light) ** 2 + by["part"] * part
    return times(pile_up(pair, light, by, shapes), -lost)


def gain(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A factor for each zone."""
    return times(light, by["log_gain"] + np.zeros_like(light))


def falloff(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A smooth factor over the field."""
    u, v = relative(pair).T
    return times(light, by["across"] * u + by["down"] * v + by["outward"] * (u**2 + v**2))


def drift(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """A smooth factor over the scan."""
    return times(light, by["linear"] * pair.when)


def pedestal(pair: Pair, light: np.ndarray, by: dict, shapes: dict) -> np.ndarray:
    """An offset for each zone."""
    return np.maximum(light + by["offset"] * pair.a.max(axis=1, keepdims=True), 0)

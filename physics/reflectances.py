"""The factor by which surfaces reflect otherwise than was assumed, pixel by pixel."""

import numpy as np
from scipy.special import expit

from physics.effect import Values
from physics.light import Light
from physics.marks import in_ball
from physics.patchwork import patchwork
from physics.space_waves import wave
from physics.texture import PRODUCTS, texture
from physics.told_apart import numbers

# The reflectance that contrast leaves as it is. One number for all scenes, so that frames do not depend on each other;
# which one does not matter where a gain is fitted.
MIDDLE = 0.5
# Width of the edge of what is "dark", in log reflectance: 10 % of the way to the other side at ±22 % of `level`.
EDGE = 0.1
# The same of what is "near", in log range.
NEAR_EDGE = 0.02

# Least part of all pixels on either side of a gap, and how far apart gaps are, in log range.
A_SIDE, APART = 0.01, 0.1
# Part of all pixels that is as good as none.
EMPTY = 1e-4

# Surfaces that have factors of their own at once, beside the largest; the first FEW of them are tried before all.
FEW = 3
LAST = 8
SURFACES = tuple(f"surface_{k}" for k in range(2, LAST + 1))


def by_surface(values: Values) -> bool:
    """Whether surfaces are told apart at all."""
    return any(values[name] != 0 for name in ("one", *SURFACES))


def log_factor(values: Values, light: Light) -> np.ndarray:
    """Logarithm of the factor, (F, H, W) or what broadcasts to it; 0 where nothing is reflected or known."""
    found = np.zeros(())
    if values["spot"] != 0:
        x, y = light.rays[..., 0] - values["spot_x"], light.rays[..., 1] - values["spot_y"]
        found = values["spot"] * np.exp(-(x**2 + y**2) / (2 * values["spot_size"] ** 2))
    if values["mark"] != 0:
        found = found + values["mark"] * in_ball(values, "mark", light)
    if values["wave_sin"] != 0 or values["wave_cos"] != 0:
        found = found + wave(values, light)
    if any(values[name] != 0 for name in PRODUCTS):
        found = found + texture(values, light)
    if np.any(values["patch"]):
        found = found + patchwork(values["patch"], light)
    if values["contrast"] != 0 or values["step"] != 0:
        log = np.log(np.where(light.reflectance > 0, light.reflectance, MIDDLE).astype(float))
        found = found + values["contrast"] * (log - np.log(MIDDLE))
        found = found + values["step"] * expit((np.log(values["level"]) - log) / EDGE)
    if values["near"] != 0:
        range_m = np.where(light.range_m > 0, light.range_m, np.inf)
        found = found + values["near"] * expit((np.log(values["near_range"]) - np.log(range_m)) / NEAR_EDGE)
    if by_surface(values):
        number = numbers(values, light)
        each = np.zeros(max(int(number.max(initial=0)), LAST, round(values["surface"])) + 1)
        each[2 : LAST + 1] = [values[name] for name in SURFACES]
        each[round(values["surface"])] += values["one"]
        found = found + each[number]
    return found


def gaps(light: Light, most: int) -> list[float]:
    """Ranges, at most so many, at which there is least between what is nearer and what is farther, the emptiest first.

    Of the logarithm of range, in steps of an edge's width; in the middle of what is empty. A side has a hundredth of
    all pixels or more.
    """
    log = np.log(light.range_m[(light.range_m > 0) & np.isfinite(light.range_m)])
    if not len(log) or np.ptp(log) < 4 * NEAR_EDGE:
        return []
    count, edges = np.histogram(log, bins=int(np.ptp(log) / NEAR_EDGE))
    nearer = np.cumsum(count) / len(log)
    away = np.abs(np.subtract.outer(np.arange(len(count)), np.flatnonzero(count > EMPTY * len(log)))).min(axis=1)
    # What is empty is the better the wider it is, what is not the better the less is in it.
    order = np.argsort(np.where(away > 0, -away, count / len(log)), kind="stable")
    found: list[float] = []
    for at in order[(nearer[order] > A_SIDE) & (nearer[order] < 1 - A_SIDE)]:
        middle = (edges[at] + edges[at + 1]) / 2
        if len(found) < most and all(abs(middle - other) > APART for other in found):
            found.append(float(middle))
    return [float(np.exp(middle)) for middle in found]

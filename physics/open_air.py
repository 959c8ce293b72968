"""The air before surfaces: how much of a layer of it lies around each range, and who looks through it."""

from dataclasses import replace

import numpy as np
from numba import njit
from scipy.constants import speed_of_light
from scipy.special import ndtr

from physics.arrivals import arrivals
from physics.clock import Clock
from physics.effect import Values
from physics.footprint import Footprints
from physics.kept import kept_with_scene
from physics.light import Light, Return
from physics.workers import in_slices


def ranges_of(clock: Clock) -> np.ndarray:
    """(F or 1, P or 1, J) range at each knot, negative before time zero."""
    lattice, zero = clock.lattice, np.asarray(clock.time_zero_s, float)
    knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
    return speed_of_light / 2 * (knots_s - np.atleast_2d(zero)[..., None])


def layers(values: Values, clock: Clock, ranges: np.ndarray) -> np.ndarray:
    """Integral of 1/(r² + overlap²) over the medium in the layer around each knot, in closed form.

    Of soft edges, which hardly change across such a layer, their part at the knot.
    """
    half = speed_of_light / 4 * clock.lattice.step_s
    soft = values["soft"] > 0
    end = np.inf if soft else values["begin"] + values["thickness"]
    begin = min(values["blind"] if soft else max(values["begin"], values["blind"]), end)
    inner, outer = (np.arctan(np.clip(ranges + side, begin, end) / values["overlap"]) for side in (-half, half))
    there = np.diff(ndtr(_edges(values, ranges)[::-1]), axis=0)[0] if soft else 1.0
    return there * (outer - inner) / values["overlap"]


def _edges(values: Values, ranges: np.ndarray) -> np.ndarray:
    """(2, ...) how far ranges are beyond the begin and the end of a soft layer, in standard deviations."""
    begin = values["begin"]
    return np.stack([ranges - begin, ranges - begin - values["thickness"]]) / values["soft"]


def way_in(values: Values, ranges: np.ndarray) -> np.ndarray:
    """Metres of the way to a range that lie in the medium; of soft edges the integral of the normal distribution's."""
    if not values["soft"]:
        return np.clip(ranges - values["begin"], 0, values["thickness"])

    def until(there: np.ndarray) -> np.ndarray:
        beyond = _edges(values, there)
        behind = beyond * ndtr(beyond) + np.exp(-(beyond**2) / 2) / np.sqrt(2 * np.pi)
        return values["soft"] * (behind[0] - behind[1])

    return until(np.maximum(ranges, 0)) - until(np.zeros(1))


@kept_with_scene
def open_air(light: Light, footprints: Footprints, clock: Clock) -> np.ndarray:
    """(F, P, J) sum of each zone's weights over pixels whose surface is farther than the knot; to read only."""
    known = np.isfinite(light.range_m) & (light.range_m > 0)
    # What lies beyond the window is open air all the same.
    nearer = np.minimum(np.where(known, light.range_m, 0), np.float32(ranges_of(clock)[..., -2].min()))
    once = replace(light, returns=(Return(nearer.astype(np.float32), known.astype(np.float32)),))
    ends = arrivals(once, footprints, clock).light
    return np.cumsum(ends[..., ::-1], axis=-1)[..., ::-1] - ends / 2


def through(light: np.ndarray, air: np.ndarray, alpha: np.ndarray, way: np.ndarray, back: np.ndarray) -> np.ndarray:
    """(F, P, J) what passes of light and of what air sends back, (F, P, J): e^(-2·alpha·way)·(light + alpha·back·air).

    alpha: (F, P or 1). way, metres, and back: (F or 1, P or 1, J).
    """
    light, out, every = np.ascontiguousarray(light), np.empty(light.shape), np.arange(len(light)) % len(way)
    alpha = np.array(np.broadcast_to(alpha, light.shape[:2]))
    way, back = (np.array(np.broadcast_to(of, (len(of), *light.shape[1:]))) for of in (way, back))
    in_slices(lambda some: _through(light[some], air[some], alpha[some], way, back, every[some], out[some]), len(light))
    return out


@njit(nogil=True, cache=True)
def _through(light, air, alpha, way, back, every, out):
    """Fill frames of the same; `every` (F,) which of the ways each has."""
    frames, zones, knots = light.shape
    for f in range(frames):
        for p in range(zones):
            for j in range(knots):
                if light[f, p, j] == 0 and air[f, p, j] == 0:  # Beyond all surfaces.
                    out[f, p, j] = 0.0
                    continue
                sent = light[f, p, j] + alpha[f, p] * back[every[f], p, j] * air[f, p, j]
                out[f, p, j] = np.exp(-2 * alpha[f, p] * way[every[f], p, j]) * sent

"""`scattering_medium`: photons are lost in the air, and some come back from it."""

from functools import reduce
from itertools import chain

import numpy as np
from scipy.constants import speed_of_light
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import make_interp_spline
from scipy.stats import norm

from physics.effect import Values
from physics.single_photons.draw import by_zone, delays, many, way_m
from physics.single_photons.world import NO_PIXEL, Photons, World


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Of those from surfaces, the ones that get through; and those that the air before the surfaces scatters."""
    free_m = rng.exponential(1.0, len(photons)) / np.maximum(_extinction(world, values)[photons.zone], 1e-12)
    through = (2 * _way_in(values, way_m(photons, world) / 2) < free_m) | (photons.pixel == NO_PIXEL)
    return reduce(Photons.and_also, _scattered(world, values, rng), photons.only(through))


def _extinction(world: World, values: Values) -> np.ndarray:
    """(P,) by now; swathes by a spline through all that is halfway, too."""
    at_first = by_zone(world, values["extinction"])
    now = at_first + np.maximum(world.time_s * values["growth"], -1) * at_first
    haze = [values[f"haze_{k}"] for k in range(1, 7)]
    if not any(haze):
        return now
    half = [(haze[k] + haze[k + 1]) / 2 + values[f"halfway_{k + 1}"] for k in range(5)]
    times = np.arange(11) * values["every"] / 2
    swathe = make_interp_spline(times, [*chain(*zip(haze, half, strict=False)), haze[-1]], bc_type="natural")
    return now + max(float(swathe(min(world.time_s, times[-1]))), 0.0)


def _way_in(values: Values, range_m: np.ndarray) -> np.ndarray:
    """Metres of the way to a range that lie in the medium; summed up where its edges are soft."""
    if values["soft"]:
        at = np.linspace(0, max(float(np.nanmax(range_m, initial=0)), 1e-3), 4000)
        return np.interp(range_m, at, cumulative_trapezoid(_medium(values, at), at, initial=0))
    return np.minimum(np.maximum(range_m, values["begin"]) - values["begin"], values["thickness"])


def _medium(values: Values, range_m: np.ndarray) -> np.ndarray:
    """How much of a medium there is at a range: of soft edges, the chance of being behind one and before the other."""
    begin, end = values["begin"], values["begin"] + values["thickness"]
    return norm.cdf(range_m, begin, values["soft"]) - norm.cdf(range_m, end, values["soft"])


def _scattered(world: World, values: Values, rng: np.random.Generator) -> list[Photons]:
    """Photons that are scattered once, shell by shell about the sensor: as many as could be, less those that are not.

    Of light scattered evenly into 4π a square metre at distance r catches 1/(4πr²); of a matt surface's ρ·cosθ/(πr²),
    which is what a unit of light stands for: hence the quarter.
    """
    overlap, wider = values["overlap"], 8 * values["soft"]
    end = values["begin"] + values["thickness"] + wider
    extinction = _extinction(world, values)
    ranges = np.nan_to_num(world.range_m)
    shells = []
    inner = max(values["begin"] - wider, values["blind"], 0.0)
    while inner < min(ranges.max(), end):
        outer = min(inner + max(inner, overlap), end)
        most = (outer - inner) * values["albedo"] / 4 / (inner**2 + overlap**2)
        mean = world.gain * most * extinction[:, None, None] * world.weights * (ranges > inner)
        zone, pixel = many(mean, rng)
        radius = inner + (outer - inner) * rng.random(len(zone))
        in_air = radius < ranges.ravel()[pixel]
        if wider:
            in_air &= rng.random(len(zone)) < _medium(values, radius)
        survives = rng.exponential(1.0, len(zone)) > 2 * extinction[zone] * _way_in(values, radius)
        caught = rng.random(len(zone)) * (radius**2 + overlap**2) < inner**2 + overlap**2
        time = world.time_zero_s[zone] + 2 * radius / speed_of_light + delays(world, len(zone), rng)
        shell = Photons(zone, time, pixel, np.zeros(len(zone), np.int32))
        shells.append(shell.only(in_air & survives & caught))
        inner = outer
    return shells

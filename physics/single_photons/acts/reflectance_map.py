"""`reflectance_map`: surfaces send back more photons, or fewer, than their assumed reflectance says."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import interpn

from physics.effect import Values
from physics.single_photons.surfaces import surface_numbers
from physics.single_photons.where_from import at_the_start, in_a_ball
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Factors: a power of the reflectance itself, for dark surfaces, for near ones, for a spot and a texture in view.

    And factors of single surfaces. The edge of "dark" is a logistic function of the logarithm over 0.1, which is a
    tenth power of the ratio itself.
    """
    shines = world.reflectance > 0
    told = np.where(shines, world.reflectance, 0.5)
    power = (2 * told) ** values["contrast"]
    dark = np.exp(values["step"] / (1 + (told / values["level"]) ** 10))
    away = np.where(world.range_m > 0, world.range_m, np.inf) / values["near_range"]
    near = np.exp(values["near"] / (1 + away**50))
    x, y, z = np.moveaxis(world.points, -1, 0)
    z = np.where(z > 0, z, np.nan)
    off = np.hypot(x / z - values["spot_x"], y / z - values["spot_y"]) / values["spot_size"]
    spot = np.exp(values["spot"] * np.exp(-0.5 * off**2))
    texture = np.exp(_of_view(values, x / z, y / z) + _of_space(values, world))
    factor = (
        power
        * dark
        * near
        * spot
        * texture
        * _of_a_mark(values, world)
        * _of_a_wave(values, world)
        * _of_patches(values, world)
        * _of_surfaces(world, values)
    )
    return replace(world, reflectance=np.where(shines, told * factor, world.reflectance))


def _of_space(values: Values, world: World) -> np.ndarray | float:
    """Sums of products of up to three coordinates, each spelled out in its parameter's name.

    Of where things are in the world that the first frame's camera was half a metre behind the origin of.
    """
    spelled = {name: name.removeprefix("space_") for name in values if name.startswith("space_") and values[name]}
    if not spelled:
        return 0.0
    from_middle = at_the_start(world, "reflectance_map in space") - [0, 0, 0.5]
    along = dict(zip("xyz", np.moveaxis(from_middle, -1, 0), strict=True))
    return sum(values[name] * np.prod([along[c] for c in text], axis=0) for name, text in spelled.items())


def _of_a_mark(values: Values, world: World) -> np.ndarray | float:
    """A ball in space on which the logarithm falls by half."""
    return np.exp(values["mark"] * in_a_ball(world, values, "mark")) if values["mark"] else 1.0


def _of_a_wave(values: Values, world: World) -> np.ndarray | float:
    """The real part of a complex wave through where the first frame's camera has things."""
    if not (values["wave_sin"] or values["wave_cos"]):
        return 1.0
    phase = at_the_start(world, "reflectance_map with a wave") @ [values[f"wave_{axis}"] for axis in "xyz"]
    return np.exp(np.real((values["wave_cos"] - 1j * values["wave_sin"]) * np.exp(1j * phase)))


def _of_patches(values: Values, world: World) -> np.ndarray | float:
    """Tents about the corners of 5 × 5 × 5 boxes of which all that was seen fills the whole, if it is not too thin.

    The corners under whose tents most is seen have numbers, 128 of them.
    """
    if not np.any(values["patch"]):
        return 1.0
    every = [world.at(time) for time in world.times_s]
    points = np.concatenate([at_the_start(one, "reflectance_map of patches")[one.depth_m > 0] for one in every])
    longest = np.ptp(points, axis=0).max()
    axes = [along.min() + np.linspace(0, max(np.ptp(along), longest / 4), 6) for along in points.T]
    tents = [
        np.maximum(1 - np.abs(along[:, None] - at) / (at[1] - at[0]), 0)
        for along, at in zip(points.T, axes, strict=True)
    ]
    seen = np.einsum("ni,nj,nk->ijk", *tents).ravel()
    logs = np.zeros(seen.size)
    logs[np.argsort(-seen, kind="stable")[:128]] = values["patch"]
    here = np.clip(at_the_start(world, "reflectance_map of patches"), *np.array(axes)[:, [0, -1]].T)
    return np.exp(interpn(axes, logs.reshape(6, 6, 6), here))


def _of_view(values: Values, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sums of products of up to four tangents, spelled out likewise."""
    spelled = {"slope_x": "x", "slope_y": "y", "bow_x": "xx", "bow_y": "yy", "bow_xy": "xy"}
    spelled |= {name: name.removeprefix("bend_") for name in values if name.startswith("bend_")}
    return sum(values[n] * np.prod([{"x": x, "y": y}[c] for c in text], axis=0) for n, text in spelled.items())


def _of_surfaces(world: World, values: Values) -> np.ndarray | float:
    """Factors of surfaces that are looked up by their numbers."""
    logs = {k: values[f"surface_{k}"] for k in range(2, 9)}
    logs[round(values["surface"])] = logs.get(round(values["surface"]), 0.0) + values["one"]
    if not any(logs.values()):
        return 1.0
    table = np.ones(max(logs) + 1)
    table[list(logs)] = np.exp(list(logs.values()))
    number = surface_numbers(world, values)
    return np.where(number < len(table), table[np.minimum(number, len(table) - 1)], 1)

"""`reflectance_map`: surfaces send back more photons, or fewer, than their assumed reflectance says."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.surfaces import surface_numbers
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
    slope = np.array([values["slope_x"], values["slope_y"]])
    bow = np.array([[values["bow_x"], values["bow_xy"] / 2], [values["bow_xy"] / 2, values["bow_y"]]])
    ray = np.stack([x / z, y / z], axis=-1)
    texture = np.exp(ray @ slope + ((ray @ bow) * ray).sum(axis=-1))
    factor = power * dark * near * spot * texture * _of_surfaces(world, values)
    return replace(world, reflectance=np.where(shines, told * factor, world.reflectance))


def _of_surfaces(world: World, values: Values) -> np.ndarray | float:
    """Factors of surfaces that are looked up by their numbers."""
    logs = {k: values[f"surface_{k}"] for k in range(2, 5)}
    logs[round(values["surface"])] = logs.get(round(values["surface"]), 0.0) + values["one"]
    if not any(logs.values()):
        return 1.0
    table = np.ones(max(logs) + 1)
    table[list(logs)] = np.exp(list(logs.values()))
    number = surface_numbers(world)
    return np.where(number < len(table), table[np.minimum(number, len(table) - 1)], 1)

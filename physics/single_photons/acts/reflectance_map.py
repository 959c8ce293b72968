"""`reflectance_map`: surfaces send back more photons, or fewer, than their assumed reflectance says."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """Factors: a power of the reflectance itself, for dark surfaces, for near ones, for a spot and a texture in view.

    The edge of "dark" is a logistic function of the logarithm over 0.1, which is a tenth power of the ratio itself.
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
    return replace(world, reflectance=np.where(shines, told * power * dark * near * spot * texture, world.reflectance))

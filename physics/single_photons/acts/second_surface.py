"""`second_surface`: photons that pass the first surface come back from the one behind it, or from a sheet before it."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.effect import Values
from physics.single_photons.draw import by_zone, returned, way_m
from physics.single_photons.surfaces import surface_numbers
from physics.single_photons.where_from import in_a_ball
from physics.single_photons.world import NO_PIXEL, Photons, World

# A sheet fades as it comes nearer than this, or than half the range of what is behind it; metres.
FADES_M = 0.1
# Surfaces met at less than this cosine are seen edge on.
EDGE_ON = 0.1
# Where surfaces begin and end to be covered, ranges of which one is this power greater are told apart.
SHARPNESS = 50


def photons(photons: Photons, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """Some of those from surfaces are lost; those that come back are thinned by the larger sphere, and late.

    What the second surface sends back beyond what the first lost is drawn by itself, and all of what a sheet before
    it does, or a third surface: straight, as such a surface has no part in other ways.
    """
    spacing, ratio = _along(values, world).ravel()[photons.pixel], values["reflectance"]
    ranges = way_m(photons, world) / 2
    lost = (rng.random(len(photons)) < _lost(values, world, photons.zone, ranges, photons.pixel)) & (
        photons.pixel != NO_PIXEL
    )
    first = photons.only(~lost)
    if values["again"]:
        third = {**values, "spacing": values["spacing"] + values["beyond"]}
        first = first.and_also(_straight(ratio * values["again"], world, third, rng))
    if values["spacing"] < 0:
        return first.and_also(_straight(ratio, world, values, rng))
    meets = (
        rng.random(len(photons)) * (ranges + spacing) ** values["falloff"] < min(ratio, 1) * ranges ** values["falloff"]
    )
    later = photons.only(lost & meets)
    second = replace(
        later,
        time_s=later.time_s + 2 * spacing[lost & meets] / speed_of_light,
        detour_m=2 * spacing[lost & meets] + (np.zeros(len(later)) if later.detour_m is None else later.detour_m),
    )
    both = first.and_also(second)
    return both.and_also(_straight(ratio - 1, world, values, rng)) if ratio > 1 else both


def _lost(values: Values, world: World, zone: np.ndarray, range_m: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    """Chance that the first surface, at this range and pixel, does not send back a photon of this zone."""
    with np.errstate(divide="ignore", over="ignore"):
        far_enough = 1 / (1 + (values["nearest"] / range_m) ** SHARPNESS)
        near_enough = 1 / (1 + (range_m / values["farthest"]) ** SHARPNESS)
    part = by_zone(world, values["passed"])[zone] + values["covered"] * far_enough * near_enough + values["parallel"]
    if values["one"]:
        part = part + values["one"] * (surface_numbers(world, values).ravel()[pixel] == round(values["surface"]))
    if values["pane"]:
        part = part + values["pane"] * in_a_ball(world, values, "pane").ravel()[pixel]
    return np.minimum(part, 1)


def _along(values: Values, world: World) -> np.ndarray:
    """(H, W) metres along rays to the second surface: its distance, or more where that is meant along normals."""
    facing = np.maximum(world.cosine, EDGE_ON) if values["parallel"] else np.ones_like(world.depth_m)
    return values["spacing"] / facing


def _straight(ratio: float, world: World, values: Values, rng: np.random.Generator) -> Photons:
    """What a surface of so many times the reflectance, for each photon that the first loses, sends back."""
    far = np.where(world.range_m > 0, world.range_m, np.nan)
    there = far + _along(values, world)
    fades, floor = np.ones_like(far), there
    if values["spacing"] < 0:
        # A sheet that fades is no brighter than where it begins to.
        fades = np.clip(there / np.minimum(FADES_M, far / 2), 0, 1)
        floor = np.maximum(there, np.minimum(FADES_M, far / 2))
    # Light goes by 1/r² of the range at which it is drawn.
    brightness = ratio * fades * (far / floor) ** values["falloff"] * (there / far) ** 2
    zones = np.arange(world.zones)[:, None, None]
    weights = world.weights * np.nan_to_num(
        _lost(values, world, zones, far[None], np.arange(far.size).reshape(far.shape))
    )
    seen = there > 0
    depth = world.depth_m * np.where(seen, there, np.nan) / far
    gloss = world.gloss * np.where(seen, brightness, 0)
    return returned(replace(world, depth_m=depth, gloss=gloss, weights=weights), rng)

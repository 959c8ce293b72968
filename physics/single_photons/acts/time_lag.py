"""`time_lag`: photons meet the scene of another time than that of the camera's image."""

from dataclasses import replace

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone, returned
from physics.single_photons.looking import Looking, looking_so
from physics.single_photons.world import NO_PIXEL, Photons, World
from recordings.refusal import Refusal

# A surface whose range changes by more than this, beyond what half of the image does, has not moved: another has come.
ANOTHER = 0.05


def world(world: World, values: Values, rng: np.random.Generator) -> World:
    """The scene between two frames: each pixel's depth, and what it sends back, on the way from one to the other.

    Where another surface has come, each photon is drawn to come from the one or the other.
    """
    if values["carried"] > 0.5:
        raise Refusal("time_lag: carried is 1, expected 0 where photons are drawn one by one: they go pixel by pixel")
    if values["burst"]:
        return world
    return _then(world, values)


def photons(photons: Photons, here: World, values: Values, rng: np.random.Generator) -> Photons:
    """Zones of two bursts receive what comes back by then, in place of what came with the image."""
    if not values["burst"]:
        return photons
    late = by_zone(here, values["late"])
    late = np.where(late < 0, 2 * np.arange(here.zones) >= here.zones, late == 1)
    found = photons.only(photons.pixel == NO_PIXEL)
    for of, lag in ((~late, values["lag"]), (late, values["lag"] + values["burst"])):
        then = returned(_then(here, {**values, "lag": lag}), rng)
        found = found.and_also(then.only(of[then.zone]))
    return found


def _then(world: World, values: Values) -> World:
    """The scene at another time."""
    times = world.times_s
    there = float(np.clip((1 + values["skew"]) * world.time_s + values["lag"], times[0], times[-1]))
    before, after = (world.at(t) for t in (times[times <= there].max(), times[times >= there].min()))
    part = (there - before.time_s) / (after.time_s - before.time_s) if after.time_s > before.time_s else 0.0

    def between(name: str, known=np.isfinite) -> np.ndarray:
        return _between(getattr(before, name), getattr(after, name), part, known)

    depth, reflectance = between("depth_m", lambda z: z > 0), between("reflectance")
    lagged = replace(world, depth_m=depth, reflectance=reflectance, cosine=np.ones_like(depth), gloss=1.0)
    # Where zones look may go by depth, of the time when they do.
    if isinstance(world.maps, Looking):
        lagged = looking_so(lagged, world.maps)
    both = (before.depth_m > 0) & (after.depth_m > 0)
    log = np.log(np.where(both, after.range_m, 1) / np.where(both, before.range_m, 1))
    jumps = both & (np.abs(log - np.median(log[both]) if both.any() else log) > np.log1p(ANOTHER))
    lagged = replace(lagged, depth_m=np.where(jumps, before.depth_m, depth))
    sent = (1 - part) * _sent_back(before) + part * _sent_back(after)
    matt = _sent_back(lagged)
    gloss = np.where(sent > 0, sent / np.where(matt > 0, matt, np.inf), 0)
    new = np.where(jumps & (sent > 0), part * _sent_back(after) / np.where(sent > 0, sent, 1), 0)
    return replace(lagged, gloss=gloss, behind=(new, np.where(jumps, after.range_m - before.range_m, 0)))


def _sent_back(world: World) -> np.ndarray:
    """(H, W) light that each pixel sends back to a square metre; 0 where something is not known."""
    power = world.reflectance * world.gloss * np.clip(world.cosine, 0, None)
    ranges = np.where(world.depth_m > 0, world.range_m, np.inf)
    return np.where(np.isfinite(power), power, 0) / ranges**2


def _between(before: np.ndarray, after: np.ndarray, part: float, known) -> np.ndarray:
    """(H, W) means of two frames; where one alone is known, that one."""
    both = known(before) & known(after)
    mean = (1 - part) * np.where(both, before, 0) + part * np.where(both, after, 0)
    one = np.where(known(before), before, after)
    return np.where(both, mean, before if part == 0 else one)

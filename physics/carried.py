"""What the camera sees between its frames where it is known how it moves, and how things before it do."""

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from physics.bodies import Body, bodies
from physics.kept import kept_of_session
from physics.light import Light, Return
from physics.light_between import JUMP, neighbours
from physics.seen_from import filled, from_there, gather, looking, put, sources
from physics.workers import in_parallel

# What is not known is taken to be so far away that it turns with the camera alone.
FAR_M = 1e3
# So many surfaces are told apart in a pixel; more are taken together with the last of them.
SLOTS = 8
# What there is less of is lost in rounding.
LEAST = 1e-9


def carriers(light: Light) -> tuple[Body, ...]:
    """What moves, as one or each thing by itself, by what tells frames of a session better from those around them."""
    things = _carriers(light)
    if light.part_of is None:
        return things
    return tuple(replace(thing, there=thing.there[light.part_of[1]]) for thing in things)


@kept_of_session
def _carriers(light: Light) -> tuple[Body, ...]:
    """By ranges, and by what is near more than by what is far, as light is."""
    each = bodies(light)
    if len(each) == 1:
        return each
    times = np.asarray(light.time_s, float)
    together = (replace(each[0], there=np.ones(light.range_m.shape, bool)),)

    def off(things: tuple[Body, ...]) -> float:
        return float(off_by(carried(light, things, *neighbours(times), times).range_m, light.range_m).sum())

    return min((together, each), key=off)


def off_by(guess: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """(F,) how far ranges (F, H, W) that were guessed are off those that were seen; what is near counts for more."""
    known = (seen > 0) & (guess > 0)
    ratio = np.abs(np.log(np.where(known, guess, 1) / np.where(known, seen, 1)))
    return (np.minimum(ratio, JUMP) / np.where(known, seen, 1) ** 2 * known).sum(axis=(1, 2), dtype=float)


def carried(
    light: Light, things: tuple[Body, ...], lower: np.ndarray, upper: np.ndarray, part: np.ndarray, time_s: np.ndarray
) -> Light:
    """Light at times (F,), seconds, of frames `lower` and `upper` (F,) as things are seen from the camera by then.

    things: what is seen, each with its motion. part: (F,) how much of the second frame there is, 0 to 1. A pixel sees
    the four pixels of either frame around the point that it looks at, each by its share of the way between their
    centres: of one surface their mean, otherwise a return each. Strength goes with 1/r²; by how much surfaces turn
    towards the sensor is left as it was. What is nearer hides what is behind it. What no frame saw is missing. Range,
    reflectance and cosine, by which other effects go, are those of the nearer frame's nearest pixel.
    """
    weights = np.clip(np.stack([1 - part, part]), 0, 1)
    moved = [np.linalg.inv(thing.motion.at(time_s)) for thing in things]
    frames, shape = np.stack([lower, upper]), light.range_m.shape
    there = [
        [way @ thing.motion.at(light.time_s[of]) for of in frames] for way, thing in zip(moved, things, strict=True)
    ]
    out = np.ones((SLOTS, 2, *shape), np.float32)
    out[:, 1] = 0
    ranges, albedo, cosine = (np.empty_like(of) for of in (light.range_m, light.reflectance, light.cosine))

    def one(i: int) -> None:
        each = [
            _seen(light, thing, frames[:, i], weights[:, i], [way[0][i], way[1][i]], k == 0)
            for k, (thing, way) in enumerate(zip(things, there, strict=True))
        ]
        seen = [mine for mine in each if mine is not None]
        clear = [np.ones(shape[1:], np.float32) for _ in seen]
        for mine, its in permutations(range(len(seen)), 2):
            box = seen[its].box
            hides = seen[its].range_m[box] < seen[mine].range_m[box]
            clear[mine][box] *= np.where(hides, 1 - seen[its].covers[box], 1)
        pixel, found, most = np.zeros(shape[1:], np.int64), np.full(shape[1:], np.inf), np.zeros(shape[1:])
        for mine, left in zip(seen, clear, strict=True):
            to = out[:, :, i, *mine.box]
            for way in mine.found.reshape(8 * len(mine.found), *mine.found.shape[3:]):
                put(way[0], way[1] * left[mine.box], to[:, 0], to[:, 1])
            shows = mine.covers * left
            more = shows > most
            pixel[more], found[more], most[more] = mine.pixel[more], mine.range_m[more], shows[more]
        near = frames[1 if weights[1, i] > weights[0, i] else 0, i]
        ranges[i] = np.where(np.isfinite(found), found, light.range_m[near].ravel()[pixel])
        albedo[i], cosine[i] = (of[near].ravel()[pixel] for of in (light.reflectance, light.cosine))

    in_parallel(one, range(shape[0]))
    missing = np.count_nonzero(~(ranges > 0) | np.isnan(albedo) | np.isnan(cosine), axis=(1, 2))
    returns = [Return(*(of.copy() for of in way)) for way in out if way[1].any()] or [Return(*out[0])]
    return replace(light, range_m=ranges, reflectance=albedo, cosine=cosine, returns=tuple(returns), missing=missing)


@dataclass(frozen=True, eq=False)
class _Seen:
    """A thing as it is seen by then. found: (N, 2, 4, 2, h, w) range and strength of each way of light, frame and
    neighbour in the pixels `box` that may see it. covers: (H, W) part of each pixel that it fills. range_m: (H, W) how
    far it is there, else infinity. pixel: (H, W) which of the nearer frame's is nearest to what is seen.
    """

    box: tuple[slice, slice]
    found: np.ndarray
    covers: np.ndarray
    range_m: np.ndarray
    pixel: np.ndarray


def _seen(
    light: Light, thing: Body, frames: np.ndarray, weights: np.ndarray, there: list[np.ndarray], rest: bool
) -> _Seen | None:
    """A thing as two frames (2,) show it, each by its weight, from a camera that is there (4, 4) from theirs.

    None where neither does. rest: whether it is what everything else is before: what one frame does not show of it the
    other does.
    """
    shape = light.range_m.shape[1:]
    sides, boxes = [], []
    for side in np.argsort(weights):
        at, way = frames[side], there[side]
        mask = thing.there[at]
        known = mask & (light.range_m[at] > 0)
        if weights[side] < LEAST or not known.any():
            continue
        guess = FAR_M if rest else float(np.median(light.range_m[at][known]))
        mine = np.where(known, light.range_m[at], np.float32(0))
        then, ahead = from_there(mine, light.rays, way)
        sides.append((side, mask, guess, mine, then, ahead))
        boxes.append((0, shape[0], 0, shape[1]) if rest else looking(mine, then, light.rays, light.intrinsics, way))
    if not any(box[1] for box in boxes):
        return None
    ends = np.array([each for each in boxes if each[1]])
    box = np.array([ends[:, 0].min(), ends[:, 1].max(), ends[:, 2].min(), ends[:, 3].max()])
    inside = np.s_[box[0] : box[1], box[2] : box[3]]
    found = np.ones((len(light.returns), 2, 4, 2, *(box[1::2] - box[::2])), np.float32)
    found[:, :, :, 1] = 0
    covers, far, pixel = np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.int64)
    for side, mask, guess, mine, then, ahead in sides:
        where, left = sources(ahead, light.rays, light.intrinsics, np.linalg.inv(there[side]), guess, box)
        pixel[inside] = where[..., 0]
        fills, reaches = filled(then, where, left)
        covers[inside] += np.float32(weights[side]) * fills
        far[inside] += np.float32(weights[side]) * reaches
        for k, sent in enumerate(light.returns):
            strength = np.where(mask, sent.strength[frames[side]], 0) * np.float32(weights[side])
            gather(mine, then, sent.range_m[frames[side]], strength, where, left, found[k, side])
    there_is = covers > 0
    ranges = np.where(there_is, far / np.where(there_is, covers, 1), np.inf)
    if rest:
        found[:, :, :, 1] /= np.where(there_is, covers, 1)[inside]
        covers = there_is.astype(np.float32)
    return _Seen(inside, found, covers, ranges, pixel)

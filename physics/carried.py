"""What the camera sees between its frames where it is known how it moves, and how things before it do."""

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from physics.bodies import Body, bodies
from physics.light import Light, Return
from physics.light_between import JUMP, neighbours
from physics.seen_from import filled, gather, sources
from physics.workers import in_parallel

# What is not known is taken to be so far away that it turns with the camera alone.
FAR_M = 1e3


def carriers(light: Light) -> tuple[Body, ...]:
    """What moves, as one or each thing by itself, by what better tells the frames of a session from those around them.

    What was worked out for a scene is kept with it.
    """
    if light.part_of is not None:
        every, frames = light.part_of
        return tuple(replace(body, there=body.there[frames]) for body in carriers(every))
    kept = light.kept.get(carriers.__qualname__)
    if kept is None or kept[0] is not light.range_m:
        kept = light.range_m, _carriers(light)
        light.kept[carriers.__qualname__] = kept
    return kept[1]


def _carriers(light: Light) -> tuple[Body, ...]:
    """See above."""
    each = bodies(light)
    if len(each) == 1:
        return each
    times = np.asarray(light.time_s, float)
    together = (replace(each[0], there=np.ones(light.range_m.shape, bool)),)

    def off(things: tuple[Body, ...]) -> float:
        guess = carried(light, things, *neighbours(times), times).range_m
        known = (light.range_m > 0) & (guess > 0)
        ratio = np.log(np.where(known, guess, 1) / np.where(known, light.range_m, 1))
        return float((light.returns[0].strength * np.minimum(np.abs(ratio), JUMP))[known].sum())

    return min((together, each), key=off)


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
    seen = [_Seen.of(light, thing, (lower, upper), weights, time_s, k == 0) for k, thing in enumerate(things)]
    left = [np.ones(light.range_m.shape, np.float32) for _ in things]
    for mine, its in permutations(range(len(things)), 2):
        left[mine] *= np.where(seen[its].range_m < seen[mine].range_m, 1 - seen[its].covers, 1)
    returns = [
        Return(way[0], way[1] * clear)
        for one, clear in zip(seen, left, strict=True)
        for way in one.found.reshape(-1, 2, *light.range_m.shape)
        if way[1].any()
    ]
    most = np.argmax([one.covers * clear for one, clear in zip(seen, left, strict=True)], axis=0)[None]
    pixel = np.take_along_axis(np.stack([one.pixel for one in seen]), most, axis=0)[0]
    frame = np.where(weights[1] > weights[0], upper, lower)

    def picked(values: np.ndarray) -> np.ndarray:
        return np.take_along_axis(values[frame].reshape(len(frame), -1), pixel.reshape(len(frame), -1), axis=1).reshape(
            values.shape
        )

    ranges = np.take_along_axis(np.stack([one.range_m for one in seen]), most, axis=0)[0]
    ranges = np.where(np.isfinite(ranges), ranges, picked(light.range_m))
    albedo, cosine = picked(light.reflectance), picked(light.cosine)
    missing = np.count_nonzero(~(ranges > 0) | np.isnan(albedo) | np.isnan(cosine), axis=(1, 2))
    shape = light.range_m.shape
    empty = Return(np.ones(shape, np.float32), np.zeros(shape, np.float32))
    return replace(
        light, range_m=ranges, reflectance=albedo, cosine=cosine, returns=tuple(returns) or (empty,), missing=missing
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """A thing as it is seen by then. found: (N, 2, 4, 2, F, H, W) range and strength of each way of light, frame and
    neighbour. covers: (F, H, W) part of each pixel that it fills. range_m: (F, H, W) how far it is there, else
    infinity. pixel: (F, H, W) which of the nearer frame's is nearest to what is seen.
    """

    found: np.ndarray
    covers: np.ndarray
    range_m: np.ndarray
    pixel: np.ndarray

    @classmethod
    def of(
        cls,
        light: Light,
        thing: Body,
        frames: tuple[np.ndarray, np.ndarray],
        weights: np.ndarray,
        time_s: np.ndarray,
        rest: bool,
    ) -> "_Seen":
        """rest: whether it is what everything else is before: what one frame does not show of it the other does."""
        moved = np.linalg.inv(thing.motion.at(time_s))
        there = [moved @ thing.motion.at(light.time_s[of]) for of in frames]
        back = [np.linalg.inv(one) for one in there]
        shape, ways = light.range_m.shape, len(light.returns)
        found = np.ones((ways, 2, 4, 2, *shape), np.float32)
        found[:, :, :, 1] = 0
        covers, ranges = np.zeros(shape, np.float32), np.full(shape, np.inf, np.float32)
        pixel = np.zeros(shape, np.int64)

        def one(i: int) -> None:
            far = np.zeros(shape[1:], np.float32)
            for side in np.argsort(weights[:, i]):
                if weights[side, i] == 0:
                    continue
                at, way = frames[side][i], (there[side][i], back[side][i])
                mask = thing.there[at]
                known = mask & (light.range_m[at] > 0)
                if not known.any():
                    continue
                guess = FAR_M if rest else float(np.median(light.range_m[at][known]))
                mine = np.where(known, light.range_m[at], np.float32(0))
                where, left = sources(mine, light.rays, light.intrinsics, *way, guess)
                pixel[i] = where[..., 0]
                fills, reaches = filled(mine, where, left, light.rays, there[side][i])
                covers[i] += weights[side, i] * fills
                far += weights[side, i] * reaches
                for k, sent in enumerate(light.returns):
                    strength = np.where(mask, sent.strength[at], 0) * np.float32(weights[side, i])
                    gather(
                        mine, sent.range_m[at], strength,
                        light.rays, there[side][i], where, left, found[k, side, :, :, i],
                    )  # fmt: skip
            seen = covers[i] > 0
            ranges[i][seen] = far[seen] / covers[i][seen]
            if rest:
                found[:, :, :, 1, i] /= np.where(seen, covers[i], 1)
                covers[i] = seen

        in_parallel(one, range(len(time_s)))
        return cls(found, covers, ranges, pixel)

"""How far what is taken to be seen between frames is off, as frames that were seen tell."""

from dataclasses import dataclass, replace

import numpy as np

from physics.arrivals import arrivals
from physics.carried import carried
from physics.light import Light, Return
from physics.light_between import JUMP, from_neighbours, neighbours
from physics.rendering import Rendering


@dataclass(frozen=True, eq=False)
class Told:
    """What frames tell that are guessed from those before and after them, in deviance.

    surfaces, edges: (F, P) by which guesses are off, where the range guessed is about that seen, and where an edge has
    passed. steps: (F - 1, P) by which the next frame differs. carried: whether frames are guessed by carrying surfaces
    along with the camera.
    """

    surfaces: np.ndarray
    edges: np.ndarray
    steps: np.ndarray
    carried: bool

    @classmethod
    def of(cls, rendering: Rendering, by_motion: bool) -> "Told":
        """Guessed by interpolation, or by the camera's motion."""
        light = rendering.light
        times = np.asarray(light.time_s, float)
        guess = carried(light, *neighbours(times), times) if by_motion else from_neighbours(light)
        counts, guessed, smooth = (
            rendering.gain * arrivals(seen, rendering.footprints, rendering.clock).binned()
            for seen in (light, guess, _but_for_edges(light, guess))
        )

        def off(other: np.ndarray) -> np.ndarray:
            out = ((other - counts) ** 2 / np.maximum(counts + rendering.background, 1)).sum(axis=2)
            if len(out) > 2:  # What nobody saw from both sides is off as its neighbour is.
                out[[0, -1]] = out[[1, -2]]
            return out

        surfaces = off(smooth)
        steps = (np.diff(counts, axis=0) ** 2 / np.maximum((counts[1:] + counts[:-1]) / 2, 1)).sum(axis=2)
        return cls(surfaces, np.maximum(off(guessed) - surfaces, 0), steps, by_motion)

    def between(self, zones: np.ndarray, lower: np.ndarray, upper: np.ndarray, part: np.ndarray) -> float:
        """Deviance by which zones (P,) are off at the part (F,) of the way from one frame (F,) to another.

        On a curve interpolation is off by x·(1 - x) of what it would be halfway between frames twice as far apart, with
        x the part of the way; its deviance goes with the square (the remainder of linear interpolation, Abramowitz and
        Stegun 25.2.1), before the first frame and after the last as well. Whether an edge has passed a pixel by then is
        as good as chance, 1 with probability x where x is taken: off by x·(1 - x) in the mean square, twice that of
        what twice as many are off by halfway. What is carried is off by as much as it is carried.
        """

        def around(of: np.ndarray) -> np.ndarray:
            return (of[lower] + of[upper])[:, zones].sum(axis=1) / 2

        way = part * (1 - part)
        curved = (4.0 if self.carried else 1.0) * way**2
        return float((curved * around(self.surfaces) + 2 * np.maximum(way, 0) * around(self.edges)).sum())

    def beyond(self, zones: np.ndarray, lower: np.ndarray, upper: np.ndarray, part: np.ndarray, stays: float) -> float:
        """Deviance by which zones are off where things moved on before the first frame or after the last.

        stays: the part of that by which they were not let.
        """
        further = stays * (part - np.clip(part, 0, 1))
        steps = self.steps[np.minimum(lower, len(self.steps) - 1)][:, zones] if len(self.steps) else np.zeros((1, 1))
        return float((further**2 * steps.sum(axis=1)).sum())


def _but_for_edges(light: Light, guess: Light) -> Light:
    """Guessed light, but that which was seen where the two differ by more than a surface moves."""
    ratio = guess.range_m / np.where(light.range_m > 0, light.range_m, np.nan)
    typical = np.nanmedian(ratio, axis=(1, 2), keepdims=True)
    edge = ~(np.abs(np.log(np.maximum(ratio / typical, 1e-9))) < np.log1p(JUMP / 2))
    returns = [Return(way.range_m, way.strength * edge) for way in light.returns]
    returns += [Return(way.range_m, way.strength * ~edge) for way in guess.returns]
    return replace(light, returns=tuple(returns))

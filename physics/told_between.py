"""How far what is taken to be seen between frames is off, as frames that were seen tell."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from physics.arrivals import arrivals
from physics.followed import followed
from physics.kept import kept_of_session
from physics.light import Light, Return
from physics.light_between import JUMP, from_neighbours, neighbours
from physics.rendering import Rendering

# What nobody saw is told bin by bin by what was seen of so many around it.
BINS = 3
# From so many frames on they tell whether surfaces are carried along with the camera.
FRAMES = 4
# What is carried must be off by less than this part of what interpolation is.
CLEARLY = 0.5
# Interpolation tells next to nothing of lags where it is off by more than this part of what frames differ by.
BLINDLY = 0.3
# Edges that pass sooner after a frame than this part of a step, or before the next, are as rare as those.
SOON = 0.01


@dataclass(frozen=True, eq=False)
class Told:
    """What frames tell that are guessed from those before and after them, in counts squared.

    surfaces, edges: (F, P, T) by which guesses are off, where the range guessed is about that seen, and where an edge
    has passed. steps: (F - 1, P, T) by which the next frame differs. together: how many cells are off alike. carried:
    whether frames are guessed by carrying surfaces along with the camera.
    """

    surfaces: np.ndarray
    edges: np.ndarray
    steps: np.ndarray
    together: float
    carried: bool

    @classmethod
    def of(cls, rendering: Rendering, by_motion: bool) -> "Told":
        """Guessed by interpolation, or by the camera's motion."""
        light = rendering.light
        times = np.asarray(light.time_s, float)
        way = neighbours(times)
        guess = followed(light, *way, times) if by_motion else from_neighbours(light)
        counts, guessed, smooth = (
            rendering.gain * arrivals(seen, rendering.footprints, rendering.clock).binned()
            for seen in (light, guess, _but_for_edges(light, guess))
        )

        def off(change: np.ndarray) -> np.ndarray:
            return np.maximum(uniform_filter1d(change**2, BINS, axis=2), 0)  # Running sums are off by a last digit.

        def inner(square: np.ndarray) -> np.ndarray:
            if len(square) > 2:  # What nobody saw from both sides is off as its neighbour is.
                square[[0, -1]] = square[[1, -2]]
            return square

        surfaces = off(smooth - counts)
        edges = np.maximum(off(guessed - counts) - surfaces, 0)
        return cls(inner(surfaces), inner(edges), off(np.diff(counts, axis=0)), together(guessed - counts), by_motion)

    def between(self, lower: np.ndarray, upper: np.ndarray, part: np.ndarray) -> np.ndarray:
        """(F, P, T) by which counts are off at the part (F,) of the way from one frame (F,) to another.

        On a curve interpolation is off by x·(1 - x) of what it would be halfway between frames twice as far apart, with
        x the part of the way; its square goes with the square (the remainder of linear interpolation, Abramowitz and
        Stegun 25.2.1), before the first frame and after the last as well. Whether an edge has passed a pixel by then is
        as good as chance, 1 with probability x where x is taken: off by x·(1 - x) in the mean square, twice that of
        what twice as many are off by halfway. What is carried is off by parts of pixels, alike: where in a pixel an
        edge is is as good as chance until it has passed that.
        """

        def around(of: np.ndarray) -> np.ndarray:
            return (of[lower] + of[upper]) / 2

        way = (part * (1 - part))[:, None, None]
        if self.carried:
            return 2 * np.maximum(way, 0) * around(self.surfaces + self.edges)
        return way**2 * around(self.surfaces) + 2 * np.maximum(way, 0) * around(self.edges)

    def by_chance(self, part: np.ndarray) -> np.ndarray:
        """(F,) how many times what `between` has edges may be off by, in the mean square, in a single frame.

        One has passed or not: off by its whole, with probability x, where it passes soon after a frame.
        """
        x = np.clip(part, 0, 1)
        return 1 / np.maximum(x * (1 - x), SOON)

    def beyond(self, lower: np.ndarray, upper: np.ndarray, part: np.ndarray, stays: float) -> np.ndarray:
        """(F, P, T) by which counts are off where things moved on before the first frame or after the last.

        stays: the part of that by which they were not let.
        """
        if not len(self.steps):
            return np.zeros_like(self.surfaces)
        further = stays * (part - np.clip(part, 0, 1))
        return further[:, None, None] ** 2 * self.steps[np.minimum(lower, len(self.steps) - 1)]


def carries(rendering: Rendering) -> bool:
    """Whether frames of a session are guessed better by carrying surfaces along with the camera, pixels and all."""
    return _carries(rendering.light, rendering)


@kept_of_session
def _carries(every: Light, rendering: Rendering) -> bool:
    """See above. every: light of all frames."""
    if every.frames < FRAMES:
        return False
    ways = (Told.of(replace(rendering, light=every), by_motion) for by_motion in (True, False))
    carried_on, by_pixel = (float((told.surfaces + told.edges).sum()) for told in ways)
    return carried_on < CLEARLY * by_pixel


def jumps(rendering: Rendering) -> bool:
    """Whether so much moves from frame to frame that interpolation does not tell what is in between."""
    told = Told.of(rendering, False)
    return float((told.surfaces + told.edges).sum()) > BLINDLY * float(told.steps.sum())


def together(change: np.ndarray) -> float:
    """How many cells of changes (F, P, T) change alike: bins next to one another, and zones."""
    square = max(float((change**2).sum()), 1e-300)
    bins = 1.0
    for away in range(1, change.shape[2]):
        alike = float((change[..., away:] * change[..., :-away]).sum()) / square
        if alike <= 0:
            break
        bins += 2 * alike
    zones = np.maximum(np.einsum("fpt,fqt->pq", change, change), 0).sum() / square
    return bins * max(float(zones), 1.0)


def _but_for_edges(light: Light, guess: Light) -> Light:
    """Guessed light, but that which was seen where the two differ by more than a surface moves."""
    ratio = guess.range_m / np.where(light.range_m > 0, light.range_m, np.nan)
    typical = np.nanmedian(ratio, axis=(1, 2), keepdims=True)
    edge = ~(np.abs(np.log(np.maximum(ratio / typical, 1e-9))) < np.log1p(JUMP / 2))
    returns = [Return(way.range_m, way.strength * edge) for way in light.returns]
    returns += [Return(way.range_m, way.strength * ~edge) for way in guess.returns]
    return replace(light, returns=tuple(returns))

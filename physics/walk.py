"""What changes in the course of a session in a way that no formula says: levels at even times, and jumps."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import expit

from physics.effect import Parameter, Values

# A walk has so many levels, or the first of them, and as many halfway to each.
LEVELS = tuple(f"level_{k}" for k in range(1, 7))
BETWEEN = tuple(f"between_{k}" for k in range(1, 7))
# A jump takes this long, seconds: nothing for any sensor.
JUMP_S = 1e-4
# Only the data say how long a session is: with levels no longer apart than this, where a fit begins that was not told,
# there is no walk. It would be a constant, which is an offset.
SHORTEST_S = 1e-3
TINY = 1e-12


def walk_parameters(unit: str, most: float, start: float, levels: int = len(LEVELS)) -> tuple[Parameter, ...]:
    """Parameters of a walk and of a jump, of so much in either direction at most."""
    heights = [(name, "Height at this level.") for name in LEVELS[:levels]]
    heights += [(name, "Height halfway to it, above the mean of those before and after.") for name in BETWEEN[:levels]]
    heights += [("jump", "By how much it is higher after a jump.")]
    return (
        *(Parameter(name, unit, -most, most, start, said, vanishes_at=0.0) for name, said in heights),
        Parameter(
            "every", "s", SHORTEST_S, 1e5, SHORTEST_S, "Time from one level to the next, as long as the session says."
        ),
        Parameter("jump_at", "s", 0.0, 1e5, 0.0, "When it jumps."),
    )


def walked(values: Values, time_s: np.ndarray) -> np.ndarray:
    """Height at times of any shape: a natural cubic spline through 0 at the start and the levels, and the jump.

    From the last level on it stays.
    """
    level = np.array([0.0, *(values[name] for name in LEVELS if name in values)])
    heights = np.zeros(2 * len(level) - 1)
    heights[::2] = level
    heights[1::2] = (level[1:] + level[:-1]) / 2 + [values[name] for name in BETWEEN if name in values]
    found = values["jump"] * expit((time_s - values["jump_at"]) / JUMP_S)
    if values["every"] <= SHORTEST_S or not heights.any():
        return found
    return found + curve(heights, values["every"] / 2, time_s)


def curve(heights: np.ndarray, every_s: float, time_s: np.ndarray) -> np.ndarray:
    """A natural cubic spline through heights (N,) or (N, M), one every so many seconds; from the last on it stays."""
    at = np.clip(np.asarray(time_s) / every_s, 0, len(heights) - 1)
    return CubicSpline(np.arange(len(heights)), heights, bc_type="natural")(at)


def walk_starts(parameters: dict[str, Parameter], time_s: np.ndarray, height: np.ndarray, weight: np.ndarray) -> list:
    """Levels that last as long as the session; and the jump that explains most of heights (F,), weighted (F,)."""
    found = []
    every = float(np.ptp(time_s)) / sum(name in parameters for name in LEVELS)
    if every >= parameters["every"].low:
        found.append({LEVELS[0]: parameters[LEVELS[0]].start, "every": every})
    if len(time_s) > 2:
        found.append({"jump": parameters["jump"].start, "jump_at": _split(time_s, height, weight)})
    return found


def _split(time_s: np.ndarray, height: np.ndarray, weight: np.ndarray) -> float:
    """The time between two frames before and after which weighted means differ most clearly, squared."""
    heaped, weighed = np.cumsum(weight * height), np.cumsum(weight)
    before, after = weighed[:-1], weighed[-1] - weighed[:-1]
    apart = heaped[:-1] / np.maximum(before, TINY) - (heaped[-1] - heaped[:-1]) / np.maximum(after, TINY)
    best = int(np.argmax(apart**2 * before * after / max(weighed[-1], TINY)))
    return float((time_s[best] + time_s[best + 1]) / 2)

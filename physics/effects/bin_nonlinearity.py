"""`bin_nonlinearity`: the converter's bins are not equally wide."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


class BinNonlinearity(Effect):
    """The edge before bin t of T is displaced by alternation · (-1)^t + slope · T/π · sin(π·t/T) bins.

    Odd and even bins differ where a converter counts both flanks of a clock of unequal halves; the slow part bends
    the whole scale. What lies between the displaced edges is read off the cumulative counts, monotone cubic between
    the true edges: every count is kept, for the outermost edges stay, and none turns negative.
    """

    id = "bin_nonlinearity"
    acts_on = "detector"
    sentence = "Some bins are wider and some narrower, so that they hold more and fewer counts, pulse or not."
    look_alikes = (
        LookAlike(
            "bin_width_error", "Look at a flat pedestal: unequal bins print their pattern on it, a clock does not."
        ),
        LookAlike("bin_phase", "Cover the emitter and look at the ambient pedestal: only unequal bins show there."),
    )
    parameters = (
        Parameter(
            "alternation",
            unit="bins",
            low=-0.4,
            high=0.4,
            start=0.05,
            vanishes_at=0.0,
            sentence="How much later every other edge between bins is, the rest earlier.",
        ),
        Parameter(
            "slope",
            unit="1",
            low=-0.15,
            high=0.15,
            start=1e-3,
            vanishes_at=0.0,
            sentence="By how much the first bin is wider and the last one narrower.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts between displaced edges."""
        counts, bins = rendering.expected, rendering.expected.shape[-1]
        edges = np.arange(bins + 1.0)
        slow = values["slope"] * bins / np.pi * np.sin(np.pi * edges / bins)
        moved = np.clip(edges + values["alternation"] * (-1) ** edges + slow, 0, bins)
        moved[[0, -1]] = edges[[0, -1]]
        until = np.concatenate([np.zeros_like(counts[..., :1]), np.cumsum(counts, axis=-1)], axis=-1)
        # Where there are no counts, rounding alone could bring a bin below 0.
        return np.maximum(np.diff(PchipInterpolator(edges, until, axis=-1)(moved), axis=-1), 0)


effect = BinNonlinearity()

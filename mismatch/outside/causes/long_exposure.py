"""Histograms gather light for so long that things move meanwhile."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class LongExposure(Effect):
    """Each histogram is the mean of what would be seen from `half` a frame's time before its image to as long after.

    Between frames counts go evenly from one to the next; before the first and after the last nothing changes. Unlike a
    lag, which moves pulses, it widens them where they move, either way.
    """

    id = "long_exposure"
    acts_on = "detector"
    order = 90  # Of finished histograms.
    sentence = "each histogram holds light from before and after its image"
    forms = (("half",),)
    parameters = (
        Parameter("half", unit="frames", low=0.0, high=20.0, start=0.5, vanishes_at=0.0, sentence="Half its exposure."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """All frames, as their times are not known here."""
        return (np.inf, np.inf) if values["half"] else (0.0, 0.0)

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Mean counts."""
        half = values["half"]
        if not half:
            return rendering.expected
        frames = np.arange(len(rendering.expected))
        apart = frames[:, None] - np.arange(-np.ceil(half) - 1, len(frames) + np.ceil(half) + 1)
        weights = (_heaped(apart + half) - _heaped(apart - half)) / (2 * half)
        # What lies beyond the ends is what is seen there.
        beyond = int(np.ceil(half)) + 1
        inside = weights[:, beyond:-beyond].copy()
        inside[:, 0] += weights[:, :beyond].sum(axis=1)
        inside[:, -1] += weights[:, -beyond:].sum(axis=1)
        return np.einsum("fg,gpt->fpt", inside, rendering.expected)


def _heaped(t: np.ndarray) -> np.ndarray:
    """Integral up to t of 1 - |t| between -1 and 1: of a frame's part in what is seen t frames from it."""
    t = np.clip(t, -1, 1)
    return 0.5 + t - np.sign(t) * t**2 / 2


effect = LongExposure()

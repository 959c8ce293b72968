"""`impulse_width`: the pulse is broader, or narrower, than was assumed."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import ndtr

from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.pulse import CORE_REACH, ImpulseResponse
from physics.rendering import Rendering

# Less of a step than this is nothing, and its square would be too small for a number.
NARROWEST = 1e-9


class ImpulseWidth(Effect):
    """The impulse response is stretched about its mean time by the factor 1 + broader, then blurred by `jitter`.

    Its cumulative, monotone cubic between the edges of the steps, is read at the steps' own spacing: all light is
    kept, and bins that held whole steps still do. Jitter of laser or clock delays each photon by a normal deviate of
    its own: variances add, and a pulse of two flanks loses its corners first.
    """

    id = "impulse_width"
    acts_on = "time"
    order = -1  # What widens the core comes before what hangs a tail on it.
    sentence = "The pulse is broader or narrower than assumed, on both flanks alike, at all ranges."
    look_alikes = (
        LookAlike("impulse_tail", "Look at the early flank: a wider pulse rises earlier, a tail leaves it as it is."),
        LookAlike(
            "footprint_blur",
            "Face a plane squarely: a wider pulse stays wide there, ranges that mix under a blur do not.",
        ),
        LookAlike("counter_saturation", "Step away from the target: a wide pulse stays wide, a flat top goes."),
    )
    forms = (("broader",), ("jitter",))
    parameters = (
        Parameter(
            "broader",
            unit="1",
            low=-0.9,
            high=9.0,
            start=0.2,
            vanishes_at=0.0,
            sentence="By what part of its width the pulse is broader, narrower where negative.",
        ),
        Parameter(
            "jitter",
            unit="s",
            low=0.0,
            high=2e-9,
            start=5e-11,
            vanishes_at=0.0,
            sentence="Standard deviation of a random delay of each photon, beyond that of the pulse.",
        ),
    )

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The same clock with the pulse stretched and blurred."""
        pulse = rendering.clock.pulse
        if values["broader"] != 0:
            pulse = _stretched(pulse, 1 + values["broader"])
        if values["jitter"] != 0:
            pulse = _blurred(pulse, values["jitter"])
        return rendering.clock if pulse is rendering.clock.pulse else replace(rendering.clock, pulse=pulse)


def _stretched(pulse: ImpulseResponse, factor: float) -> ImpulseResponse:
    """The pulse `factor` times as wide about its mean, on steps of the same width and places."""
    step, edges, total = pulse.step_s, pulse.edges, pulse.edge_cumulative[-1]
    mean = float(pulse.time_s @ pulse.probability) / total
    ends = mean + factor * (edges[[0, -1]] - mean)
    before, after = (max(0, int(np.ceil(n))) for n in ((edges[0] - ends[0]) / step, (ends[1] - edges[-1]) / step))
    new = edges[0] + step * np.arange(-before, len(edges) + after)
    source = np.clip(mean + (new - mean) / factor, edges[0], edges[-1])
    # Rounding alone could bring a step below 0.
    probability = np.maximum(np.diff(PchipInterpolator(edges, pulse.edge_cumulative)(source)), 0)
    return ImpulseResponse((new[1:] + new[:-1]) / 2, probability * (total / probability.sum()))


def _blurred(pulse: ImpulseResponse, sigma_s: float) -> ImpulseResponse:
    """The pulse convolved with a normal density; exact at the edges for a response even within its steps."""
    sigma = max(sigma_s / pulse.step_s, NARROWEST)
    reach = int(np.ceil(CORE_REACH * sigma)) + 1
    at = np.arange(-reach - 1, reach + 2.0)
    # Integral of the normal cumulative: its second difference is the share of a step that falls into each other step.
    heaped = at * ndtr(at / sigma) + sigma * np.exp(-0.5 * (at / sigma) ** 2) / np.sqrt(2 * np.pi)
    probability = np.convolve(pulse.probability, np.maximum(np.diff(heaped, 2), 0))
    times = pulse.time_s[0] + pulse.step_s * np.arange(-reach, len(pulse.time_s) + reach)
    return ImpulseResponse(times, probability * (pulse.probability.sum() / probability.sum()))


effect = ImpulseWidth()

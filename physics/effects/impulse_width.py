"""`impulse_width`: the pulse is broader, or narrower, than was assumed."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.signal import fftconvolve

from physics.arrivals import Arrivals
from physics.clock import Clock, Lattice
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.pulse import ImpulseResponse, blurring
from physics.rendering import Rendering

# Steps reach as far as a pulse that is so many parts of its width wider, that fits keep theirs. In each there is more
# than what is lost in rounding.
WHOLES = 4
NEXT_TO_NOTHING = 1e-13


class ImpulseWidth(Effect):
    """The impulse response is stretched by the factor 1 + broader, then blurred by `jitter`.

    About its mean time, or about the nominal arrival, which need not be its mean, or anything between.

    Its cumulative, monotone cubic between the edges of the steps, is read at the steps' own spacing: all light is
    kept, and bins that held whole steps still do. Jitter of laser or clock delays each photon by a normal deviate of
    its own, or by anything up to a longest alike (`even`), as where a trigger waits for the next tick: variances add,
    and a pulse of two flanks loses its corners first. Zones may have pulses stretched by different factors, on steps
    that reach as far as the widest; those whose clocks jitter by different amounts have their light blurred on the
    knots of the lattice.
    """

    id = "impulse_width"
    acts_on = "time"
    grows = True
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
    forms = (("broader",), ("broader", "centred"), ("jitter",), ("jitter", "even"))
    parameters = (
        Parameter(
            "broader",
            unit="1",
            low=-0.9,
            high=9.0,
            start=0.2,
            vanishes_at=0.0,
            axis="zone",
            sentence="By what part of its width the pulse is broader, narrower where negative.",
        ),
        Parameter(
            "centred",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            tries=(0.0,),
            sentence="1 where a broader pulse keeps its mean time, 0 where it keeps its nominal arrival.",
        ),
        Parameter(
            "jitter",
            unit="s",
            low=0.0,
            high=2e-9,
            start=5e-11,
            vanishes_at=0.0,
            axis="zone",
            power=2.0,
            sentence="Standard deviation of a random delay of each photon, beyond that of the pulse.",
        ),
        Parameter(
            "even", "1", 0.0, 1.0, 0.0, "Part of its variance that is a delay up to a longest alike.", tries=(1.0,)
        ),
    )

    def clock(self, values: Values, rendering: Rendering) -> Clock:
        """The same clock with the pulse stretched and blurred."""
        pulse = rendering.clock.pulse
        if np.ndim(values["broader"]):
            pulse = _longer(pulse, np.ceil(WHOLES * (1 + np.max(values["broader"]))) / WHOLES, values["centred"])
        elif values["broader"] != 0:
            pulse = _stretched(pulse, 1 + values["broader"], values["centred"])
        if np.ndim(values["jitter"]) == 0 and values["jitter"] != 0:
            pulse = pulse.blurred(values["jitter"], values["even"])
        return rendering.clock if pulse is rendering.clock.pulse else replace(rendering.clock, pulse=pulse)

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Pulses of zones that are stretched by factors of their own, light blurred where they differ in how much."""
        here = rendering.arrivals
        if np.ndim(values["broader"]) and np.any(values["broader"]):
            here = replace(here, pulses=_each_stretched(here.lattice, 1 + values["broader"], values["centred"]))
        if np.ndim(values["jitter"]) == 0 or not np.any(values["jitter"]):
            return here
        blurred = here.light.copy()
        for zone in np.flatnonzero(values["jitter"]):
            kernel = blurring(here.lattice.step_s, values["jitter"][zone], values["even"])
            # Rounding of a transform makes a little less than nothing of nothing.
            blurred[:, zone] = np.maximum(fftconvolve(here.light[:, zone], kernel[None], mode="same", axes=-1), 0)
        return replace(here, light=blurred)


def _longer(pulse: ImpulseResponse, factor: float, centred: float) -> ImpulseResponse:
    """The same pulse with next to nothing on steps that one `factor` times as wide would take."""
    if factor <= 1:
        return pulse
    wide = _stretched(pulse, factor, centred)
    before = round((pulse.time_s[0] - wide.time_s[0]) / pulse.step_s)
    probability = np.full(len(wide.probability), NEXT_TO_NOTHING)
    probability[before : before + len(pulse.probability)] = pulse.probability
    return ImpulseResponse(wide.time_s, probability)


def _each_stretched(lattice: Lattice, factors: np.ndarray, centred: float) -> np.ndarray:
    """(P, N + 1) cumulative, at the edges of a lattice's steps, of its pulse so many times (P,) as wide."""
    edges, cumulative = lattice.edges_s, lattice.cumulative
    pivot = centred * float((edges[1:] + edges[:-1]) / 2 @ np.diff(cumulative)) / cumulative[-1]
    with np.errstate(over="ignore"):
        within = PchipInterpolator(edges, cumulative)
    at = np.clip(pivot + (edges - pivot) / factors[:, None], edges[0], edges[-1])
    found = within(at)
    found[:, 0], found[:, -1] = cumulative[0], cumulative[-1]
    return found


def _stretched(pulse: ImpulseResponse, factor: float, centred: float) -> ImpulseResponse:
    """The pulse `factor` times as wide about so much of its mean, on steps of the same width and places."""
    step, edges, total = pulse.step_s, pulse.edges, pulse.edge_cumulative[-1]
    mean = centred * float(pulse.time_s @ pulse.probability) / total
    ends = mean + factor * (edges[[0, -1]] - mean)
    before, after = (max(0, int(np.ceil(n))) for n in ((edges[0] - ends[0]) / step, (ends[1] - edges[-1]) / step))
    new = edges[0] + step * np.arange(-before, len(edges) + after)
    source = np.clip(mean + (new - mean) / factor, edges[0], edges[-1])
    # Rounding alone could bring a step below 0.
    with np.errstate(over="ignore"):  # Its mean of slopes, where a step holds next to nothing.
        cumulative = PchipInterpolator(edges, pulse.edge_cumulative)
    probability = np.maximum(np.diff(cumulative(source)), 0)
    return ImpulseResponse((new[1:] + new[:-1]) / 2, probability * (total / probability.sum()))


effect = ImpulseWidth()

"""`afterpulsing`: an avalanche traps carriers, which release a later one."""

import numpy as np
from scipy.linalg import toeplitz

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.waits import waiting

# Traps hold carriers for nanoseconds and more; what comes sooner, without a hold-off, is rather the pulse's own tail.
SOONEST_S = 1.5e-9


class Afterpulsing(Effect):
    """Each event is followed by another with some probability, an exponentially distributed time later.

    Delays run from the end of the event's bin and a hold-off of `dead` after it, until when the detector is taken to
    count nothing: with dead 0, j bins later come (1 - q)·q^(j-1) of the afterpulses, q = exp(-bin width / τ); those
    beyond the last bin are lost. Traps of many depths release by a power law (Ziarkash et al. 2018, Scientific Reports
    8, 5076): with `heavy` h above 0 a carrier is still held after t with a chance of (1 + h·t/τ)^(-1/h), which is the
    generalised Pareto distribution (Pickands 1975, Annals of Statistics 3, 119), and the exponential at 0. Afterpulses
    of afterpulses are left out: they go with the probability squared.
    Background that was measured in the dark of the laser has its afterpulses in it already: with `ambient` 0 they are
    not added again. A detector that counts before the window, too, brings afterpulses of the background from then into
    it: with `earlier` 1 the background is followed as evenly as it falls. Traps so `deep` that they hold carriers for
    many cycles release them at any time in these: evenly, as many for each event.
    """

    id = "afterpulsing"
    acts_on = "detector"
    grows = True
    order = 2  # Only what was registered is followed by afterpulses, so pile-up comes before.
    sentence = "Part of the detected photons sets off a second count later, in an exponentially falling echo."
    look_alikes = (
        LookAlike(
            "impulse_tail", "Look many bins after the pulse: a tail is over in a nanosecond or so, the echo goes on."
        ),
        LookAlike("ambient_pedestal", "Cover the emitter: a pedestal stays, afterpulses of the laser's light go."),
        LookAlike("multipath", "Take the target out of the corner: the echo stays, a second bounce goes."),
    )
    forms = (
        ("probability", "tau"),
        ("probability", "tau", "dead"),
        ("probability", "tau", "dead", "ambient"),
        ("probability", "tau", "dead", "heavy"),
        ("probability", "tau", "dead", "slower", "times"),
        ("probability", "tau", "dead", "slower", "times", "ambient"),
        ("probability", "tau", "dead", "deep"),
        ("probability", "tau", "dead", "earlier"),
        ("probability", "tau", "dead", "slower", "times", "earlier"),
    )
    parameters = (
        Parameter(
            "probability",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.01,
            vanishes_at=0.0,
            axis="zone",
            sentence="Afterpulses for each event.",
        ),
        Parameter(
            "tau",
            unit="s",
            low=2e-10,
            high=1e-6,
            start=5e-9,
            tries=(1e-9, 4e-9, 2e-8),
            sentence="Mean delay of an afterpulse, after the hold-off.",
        ),
        Parameter(
            "dead",
            unit="s",
            low=-1e-9,
            high=2e-8,
            start=0.0,
            tries=(5e-10, 3e-9),
            sentence="How long after an event's bin none is released or counted; some are within it where negative.",
        ),
        Parameter(
            "ambient",
            "1",
            0.0,
            1.0,
            1.0,
            "Part of the background without its afterpulses in it.",
            tries=(0.0, 1.0),
        ),
        Parameter(
            "earlier",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.0,
            tries=(1.0,),
            sentence="Part of the afterpulses of background before the window that come in it.",
        ),
        Parameter(
            "slower", "1", 0.0, 1.0, 0.01, "Afterpulses for each event of a second kind of trap.", vanishes_at=0.0
        ),
        Parameter("deep", "1", 0.0, 1.0, 0.003, "Afterpulses for each event in later cycles.", vanishes_at=0.0),
        Parameter("heavy", "1", 0.0, 10.0, 0.0, "Falls with the power 1 + 1/heavy of time; 0 exponentially."),
        Parameter(
            "times", "1", 1.0, 1000.0, 10.0, "How many times as long those take, after the hold-off.", tries=(4.0, 20.0)
        ),
    )

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """An echo at once that is over in a nanosecond is a tail of the pulse."""
        quick = values["tau"] < SOONEST_S and values["dead"] < rendering.clock.bin_width_s
        return quick and bool(np.any(values["probability"]))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Of light alone, where there is background: that may have been recorded with its afterpulses in it."""
        if not np.any(rendering.background):
            return []
        probability, tau = self.parameter("probability"), self.parameter("tau")
        return [{"probability": probability.start, "tau": tau_s, "ambient": 0.0} for tau_s in tau.tries]

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts and their echoes, of one kind of trap or two."""
        found = events = rendering.expected
        if values["ambient"] != 1:
            events = np.maximum(events - (1 - values["ambient"]) * rendering.background, 0)
        for name, times in (("probability", 1.0), ("slower", values["times"])):
            probability = np.asarray(values[name], float)
            probability = probability[:, None] if probability.ndim else probability
            if probability.any():
                tau, width = times * values["tau"], rendering.clock.bin_width_s
                held = _held(events.shape[-1], width, tau, values["dead"], values["heavy"])
                earlier = values["earlier"] * rendering.background * held[1:] if values["earlier"] else 0.0
                found = found + probability * (events @ np.triu(toeplitz(-np.diff(held))) + earlier)
        return found + values["deep"] * events.mean(axis=-1, keepdims=True) if values["deep"] else found


def _held(bins: int, width: float, tau: float, dead: float, heavy: float) -> np.ndarray:
    """(T + 1,) part of the afterpulses that have not come until the end of the event's own bin, of the next, and so on.

    None comes before the event's own bin.
    """
    waited = np.maximum(np.arange(bins + 1) * width - width - max(dead, -width), 0) / tau
    return waiting(waited, 1.0, heavy)


effect = Afterpulsing()

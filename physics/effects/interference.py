"""`interference`: another emitter."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.tracks import straight_tracks


class Interference(Effect):
    """The pulses of an emitter of nearly the same period: within a frame one pulse, which wanders between frames."""

    id = "interference"
    acts_on = "scene"
    sentence = "Pulses of another emitter are counted as well, at a time that wanders from frame to frame."
    look_alikes = (
        LookAlike("ambient_pedestal", "Cover the emitter: both stay, but interference is a pulse and moves."),
        LookAlike("range_aliasing", "Cover the emitter: interference stays, a far target's pulse goes."),
        LookAlike("multipath", "Cover the emitter: interference stays, a second bounce goes."),
    )
    parameters = (
        Parameter(
            "counts",
            unit="counts",
            low=0.0,
            high=1e7,
            start=100.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Counts per frame of the other emitter's pulse.",
        ),
        Parameter(
            "arrival",
            unit="s",
            low=-1e-6,
            high=1e-6,
            start=5e-9,
            sentence="When it arrives at the start of the session, from the start of bin 0.",
        ),
        Parameter(
            "drift",
            unit="1",
            low=-1e-3,
            high=1e-3,
            start=1e-8,
            sentence="Seconds by which it arrives later for each second of the session.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """The pulse in the bins, frame by frame; outside the window it is not seen."""
        clock = rendering.clock
        arrival_s = values["arrival"] + values["drift"] * rendering.light.time_s
        shares = clock.pulse.in_bins(arrival_s, clock.bins, clock.bin_width_s)
        return rendering.expected + np.atleast_1d(values["counts"])[:, None] * shares[:, None]

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A pulse that stays where it is comes from the sensor's own laser: another emitter's clock is another."""
        wandered = abs(values["drift"]) * float(np.ptp(rendering.light.time_s))
        return wandered < rendering.clock.bin_width_s

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The straight lines through frames and bins along which most is in excess."""
        tracks = straight_tracks(excess, expected, rendering, fastest=1e-3)
        return [{"arrival": float(np.clip(t.arrival_s, -1e-6, 1e-6)), "drift": t.drift} for t in tracks]


effect = Interference()

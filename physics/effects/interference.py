"""`interference`: another emitter."""

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering


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

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The straight lines through frames and bins along which most is in excess."""
        clock, time_s = rendering.clock, rendering.light.time_s
        by_frame = excess.sum(axis=1) / np.sqrt(np.maximum(expected.sum(axis=1), 1))
        bins, lasted = by_frame.shape[1], max(float(np.ptp(time_s)), 1e-9)
        # Lines that cross the window once at most; neighbours differ by a bin at the end of the session.
        slopes = np.arange(-bins, bins + 1, 2)
        moved = np.rint(slopes[:, None] * (time_s - time_s[0]) / lasted).astype(int)
        found = []
        for i, shift in enumerate(moved):
            at = np.arange(-bins, 2 * bins)[:, None] + shift
            inside = (at >= 0) & (at < bins)
            along = np.where(inside, by_frame[np.arange(len(shift)), np.clip(at, 0, bins - 1)], 0.0).sum(axis=1)
            score = along / np.sqrt(np.maximum(inside.sum(axis=1), len(shift) / 4))
            best = int(np.argmax(score))
            first = best - bins - slopes[i] * time_s[0] / lasted
            found.append((score[best], (first + 0.5) * clock.bin_width_s, slopes[i] * clock.bin_width_s / lasted))
        mean = float(clock.pulse.time_s @ clock.pulse.probability)
        best = sorted(found, reverse=True)[:4]
        return [{"arrival": float(np.clip(a - mean, -1e-6, 1e-6)), "drift": float(d)} for _, a, d in best]


effect = Interference()

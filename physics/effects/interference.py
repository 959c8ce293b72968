"""`interference`: another emitter."""

from dataclasses import replace
from functools import partial

import numpy as np

from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.owning import Look
from physics.pulse import longer
from physics.rendering import Rendering
from physics.returning import returning_track, shares_of_all
from physics.roaming import Roaming, clear_evidence, pulses_in_bins, roaming
from physics.tracks import CROSSED, straight_tracks

# Strengths at which a search for pulses that roam begins, counts.
BEGINNINGS = (2.0, 6.0, 20.0, 70.0, 250.0, 1000.0)
# And shares of the frames that hold one.
PRESENT = (0.8, 0.3)
# What all crossings must add to the evidence of any one, plus a part of it, to be one pulse: noise adds nothing.
BESIDE, AGAIN = 24.0, 0.02
# Evidence from which it is worth a fit: one in four hundred by chance.
SURE = 12.0
# Pulses of rangers are over in this, as a standard deviation, seconds.
LONGEST_S = 3e-9
# Step, in bins, over which it is seen how evidence goes with the width of the pulse.
WIDER = 0.05


class Interference(Effect):
    """The pulses of an emitter with a clock of its own, the same in all zones.

    Where its period is nearly a multiple of the laser's they wander evenly from frame to frame, a `period` apart: one
    that has left the window returns. Where it is not there is one, somewhere else in each frame: it roams. Where, only
    the frame itself can tell; where nothing was recorded it is anywhere, its mean spread over the window.
    """

    id = "interference"
    acts_on = "scene"
    sentence = "Pulses of another emitter are counted as well, at a time that wanders from frame to frame."
    look_alikes = (
        LookAlike("ambient_pedestal", "Cover the emitter: both stay, but interference is a pulse and moves."),
        LookAlike("range_aliasing", "Cover the emitter: interference stays, a far target's pulse goes."),
        LookAlike("multipath", "Cover the emitter: interference stays, a second bounce goes."),
    )
    forms = (
        ("counts", "arrival", "drift"),
        ("counts", "arrival", "drift", "longer"),
        ("counts", "arrival", "drift", "period", "longer"),
        ("roaming", "present"),
        ("roaming", "present", "longer"),
    )
    parameters = (
        Parameter("counts", "counts", 0.0, 1e7, 100.0, "Counts per frame of the other emitter's pulse.", 0.0, "zone"),
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
        Parameter(
            "period",
            unit="s",
            low=5e-9,
            high=1e-3,
            start=1e-3,
            sentence="Time between the other emitter's pulses: one that has left the window returns after it.",
        ),
        Parameter(
            "roaming", "counts", 0.0, 1e7, 100.0, "Counts of a pulse that is somewhere else in each frame.", 0.0, "zone"
        ),
        Parameter("present", "1", 0.01, 1.0, 0.8, "Share of the frames that hold a pulse that roams."),
        # A choice: no longer pulse is looked for.
        Parameter("longer", "s", 0.0, 5e-9, 0.0, "Deviation by which its pulse is longer.", tries=(5e-10,), power=2.0),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """The pulse in the bins, frame by frame; outside the window it is not seen."""
        clock = _longer(rendering.clock, values["longer"])
        arrival_s = values["arrival"] + values["drift"] * rendering.light.time_s
        shares = shares_of_all(clock.pulse, arrival_s, values["period"], clock.bins, clock.bin_width_s)
        steady = rendering.expected + np.atleast_1d(values["counts"])[:, None] * shares[:, None]
        if not np.any(values["roaming"]):
            return steady
        if rendering.recorded is not None:
            return steady + self._placed(values, rendering).added
        anywhere = pulses_in_bins(clock.pulse, clock.bins, clock.bin_width_s).mean(axis=0)
        return steady + values["present"] * np.atleast_1d(values["roaming"])[:, None] * anywhere

    def looks(self, values: Values) -> bool:
        """Whether its pulse roams."""
        return bool(np.any(values["roaming"]))

    def look(self, values: Values, rendering: Rendering) -> Look:
        """What it costs not to have known where it was, over all frames."""
        placed = self._placed(values, rendering)
        return Look(float(placed.flattery.sum()), float(placed.blur.sum()), partial(self._slopes, values, rendering))

    def _slopes(self, values: Values, rendering: Rendering) -> dict[str, np.ndarray]:
        """How the evidence of each frame goes with what is looked for."""
        placed, step = self._placed(values, rendering), WIDER * rendering.clock.bin_width_s
        # A pulse that is no longer does not change with the square root of a variance.
        slopes = {"roaming": placed.by_counts, "present": placed.by_present, "longer": np.zeros(len(placed.evidence))}
        if values["longer"]:
            step = min(step, values["longer"])
            ends = (self._placed({**values, "longer": values["longer"] + s}, rendering) for s in (-step, step))
            shorter, longer = (end.evidence / 2 for end in ends)
            slopes["longer"] = (longer - shorter) / (2 * step)
        return slopes

    def at_random(self, values: Values, rendering: Rendering, rng: np.random.Generator) -> np.ndarray:
        """A pulse at one place in some of the frames, as often at each as all that were recorded say.

        One that keeps where the sensor's own light is bright shows less than one that may be anywhere.
        """
        clock = _longer(rendering.clock, values["longer"])
        shares, recorded = pulses_in_bins(clock.pulse, clock.bins, clock.bin_width_s), rendering.recorded
        often = np.ones(len(shares)) if recorded is None else self._placed(values, rendering).chances.sum(axis=0)
        # Where no frame says that there is one at all it is anywhere.
        places = rng.choice(len(shares), len(rendering.expected), p=often / often.sum() if often.any() else None)
        there = shares[places] * (rng.random(len(places)) < values["present"])[:, None]
        return rendering.expected + np.atleast_1d(values["roaming"])[:, None] * there[:, None]

    def _placed(self, values: Values, rendering: Rendering) -> Roaming:
        """Where it is in each frame."""
        counts = np.broadcast_to(np.asarray(values["roaming"], float), rendering.recorded.shape[1])
        clock = _longer(rendering.clock, values["longer"])
        return roaming(rendering.recorded, rendering.expected, rendering.background, clock, counts, values["present"])

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A pulse that stays, or hardly wanders, is no free-running clock's."""
        return _within(CROSSED * rendering.clock.bins * rendering.clock.bin_width_s, values, rendering)

    def contradiction(self, values: Values, rendering: Rendering) -> str | None:
        """What does not wander is no clock's but the sensor's. How fast it seems to is chance, frame by frame.

        And what lasts is no pulse.
        """
        if values["longer"] > LONGEST_S:
            return "no ranger's pulse lasts as long"
        why = "the pulse of another emitter would wander from frame to frame, and this does not"
        return why if _within(rendering.clock.bin_width_s, values, rendering) else None

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The straight lines through frames and bins along which most is in excess; and how strong one that roams."""
        tracks = straight_tracks(excess, expected, rendering, fastest=1e-3)
        lines = [{"arrival": t.arrival_s, "drift": t.drift} for t in tracks]
        again = returning_track(excess, expected, rendering)
        once = max((t.evidence for t in tracks), default=0.0)
        if again is not None and again.evidence > once + max(BESIDE, AGAIN * once):
            lines.insert(0, {"arrival": again.arrival_s, "drift": again.drift, "period": again.period_s})
        ends = {p.name: (p.low, p.high) for p in self.parameters}
        lines = [{name: float(np.clip(value, *ends[name])) for name, value in line.items()} for line in lines]
        return [*lines, *self._roaming(excess + expected, expected, rendering)]

    def _roaming(self, recorded: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict]:
        """How strong a pulse that roams may be, alike in all zones and in one alone, where it shows in clear places."""
        zones, seen = recorded.shape[1], (recorded, expected, rendering.background, rendering.clock)
        # (how strong, in how many frames, alike or alone in each zone)
        evidence = np.array([clear_evidence(*seen, counts, PRESENT) for counts in BEGINNINGS])
        found = []
        for alone, of in enumerate((evidence[..., :1], evidence[..., 1:])):
            strongest, often, zone = np.unravel_index(int(np.argmax(of)), of.shape)
            counts = BEGINNINGS[strongest]
            there = np.where(np.arange(zones) == zone, counts, 0.0) if alone else counts
            found.append((of.max(), {"roaming": there, "present": PRESENT[often]}))
        return [start for sure, start in found if sure > SURE]


def _within(width_s: float, values: Values, rendering: Rendering) -> bool:
    """Whether its pulse keeps within so much time all the session."""
    session_s = float(np.ptp(rendering.light.time_s))
    return bool(np.any(values["counts"])) and abs(values["drift"]) * session_s < width_s


def _longer(clock: Clock, longer_s: float) -> Clock:
    """The clock with the other emitter's pulse in the place of the sensor's own."""
    return replace(clock, pulse=longer(clock.pulse, float(longer_s)))


effect = Interference()

"""`range_aliasing`: a target beyond the laser period."""

from functools import partial

import numpy as np
from scipy.constants import speed_of_light

from physics.curved_track import curved_track
from physics.distant import likely_across, likely_boards, seen_board
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.far_pulse import ASIDE, TOWARD, far_pulse
from physics.far_wall import normal_of, planes, seen_through, walls
from physics.folded import folds, one_period_early, seen_beyond, two_periods
from physics.light import Return
from physics.odometry import camera_motion, moved_m
from physics.rendering import Rendering
from physics.tracks import CROSSED, straight_tracks
from physics.walk import BETWEEN, LEVELS, SHORTEST_S

# A wall stands still, or it goes along with the camera.
STILL = 0.5
# No laser's period varies so much by chance, and few targets are so deep (0.45 m); rising dark counts are as broad.
BROADEST_S = 3e-9
# What says where a thing of limited extent is.
BOARD = ("distant", "depth", "azimuth", "elevation", "wide", "high")


class RangeAliasing(Effect):
    """Light of one shot is registered after the next: a far target seems near.

    Depth images seldom hold it: then it is a pulse at `apparent_range`, alike in all zones, with a number for each, or
    `as_seen` by those that see more or less in all; a wall at `depth`, seen where depth is unknown (`through`) or all
    over (`across`); or a thing of some extent there (`physics.distant`). What they hold beyond the period comes back
    one period early, `folded` times as much as it should; so do wall and thing.

    Where the laser's period is jittered evenly by up to ± jitter, so is the time since the next shot; where it is by
    chance, with standard deviation `spread`, the pulse is the longer by that, as it is where the target is deep. A
    laser of two periods, the second longer by `stagger`, has half of its shots after either, or frames take turns
    (`in_turn`); then what is seen beyond comes back in two places. A target's pulse may
    draw nearer or farther evenly: it is at apparent_range + speed·t after t seconds; or come and go on a way of its
    own (`own_way`). One that stands still comes nearer by as much as the camera has moved towards it, ahead or aside;
    where nobody says, as what it sees says (`odometry`). It is followed until it leaves the window, not into the next
    period.
    """

    id = "range_aliasing"
    acts_on = "scene"
    sentence = "A target farther than the laser period allows is counted as a pulse at a range where nothing is."
    look_alikes = (
        LookAlike("interference", "Cover the emitter: an aliased pulse goes, interference stays."),
        LookAlike("multipath", "Turn on the laser's jitter: an aliased pulse is smeared, a second bounce is not."),
        LookAlike("cover_glass_crosstalk", "Change the laser period: an aliased pulse moves, crosstalk stays."),
    )
    forms = (
        ("counts", "apparent_range"),
        ("counts", "apparent_range", "spread"),
        ("counts", "apparent_range", "speed"),
        ("counts", "apparent_range", "speed", "jitter"),
        ("counts", "apparent_range", "speed", "spread"),
        ("counts", "apparent_range", *LEVELS),
        ("counts", "apparent_range", *LEVELS, *BETWEEN),
        ("counts", "apparent_range", *TOWARD),
        ("counts", "apparent_range", "speed", "as_seen"),
        ("folded", "period"),
        ("folded", "period", "smear"),
        ("folded", "period", "stagger"),
        BOARD,
        (*BOARD, "tilt_x", "tilt_y"),
        (*BOARD, "smear"),
        ("through", "depth", "smear"),
        ("through", "depth", "smear", "tilt_x", "tilt_y"),
        ("through", "depth", "smear", "speed", "tilt_x", "tilt_y"),
        ("across", "depth", "period"),
        ("across", "depth", "period", "smear"),
    )
    richer = ((*BOARD, "tilt_x", "tilt_y"), (*BOARD, "smear"), ("counts", "apparent_range", *TOWARD))
    varied = (*LEVELS, *BETWEEN, "jitter", "spread", "stagger")  # What goes straight is not on a curved way as well.
    parameters = (
        Parameter("counts", "counts", 0.0, 1e7, 100.0, "Counts per frame of the far target's pulse.", 0.0, axis="zone"),
        # Nearer than 10 cm it is crosstalk for all that anybody can tell.
        Parameter(
            "apparent_range", "m", 0.1, 100.0, 1.0, "At the start, less whole periods: 8.4 m at 17.77 MHz.", axis="zone"
        ),
        Parameter("speed", "m/s", -5.0, 5.0, 0.0, "By how much its range grows in a second."),
        *(Parameter(name, "m", -20.0, 20.0, 0.0, f"By how much it is farther at level {name[-1]}.") for name in LEVELS),
        *(Parameter(name, "m", -20.0, 20.0, 0.0, f"Beyond that way, halfway to level {name[-1]}.") for name in BETWEEN),
        Parameter("every", "s", SHORTEST_S, 1e5, SHORTEST_S, "Time from one level to the next."),
        Parameter("as_seen", "1", 0.0, 1.0, 0.0, "1 where its counts go by what zones see in all.", tries=(1.0,)),
        Parameter("jitter", "s", 0.0, 1e-8, 0.0, "Most by which the laser's period is longer.", tries=(1e-10, 1e-9)),
        Parameter("spread", "s", 0.0, 5e-9, 0.0, "Standard deviation of it, or of a deep target.", tries=(5e-10,)),
        Parameter("still", "1", -1.5, 1.5, 0.0, "Metres it comes nearer for each the camera moves; 1 where it rests."),
        *(Parameter(f"still_{way}", "1", -1.5, 1.5, 0.0, f"The same for each it moves {way}.") for way in ASIDE),
        Parameter("folded", "1", 0.0, 1e3, 1.0, "Part of the light of surfaces beyond the period.", vanishes_at=0.0),
        Parameter("through", "1", 0.0, 1e3, 0.5, "Reflectance of a wall where depth is unknown.", vanishes_at=0.0),
        Parameter("across", "1", 0.0, 1e3, 0.5, "Reflectance of a wall that is seen all over.", vanishes_at=0.0),
        Parameter("distant", "1", 0.0, 1e3, 0.5, "Reflectance of a thing of some extent.", vanishes_at=0.0),
        Parameter("hidden", "1", 0.0, 1.0, 0.0, "Part of that thing's light that surfaces of known depth keep back."),
        Parameter("wide", "1", 0.02, 2.0, 0.2, "Half its width over its distance."),
        Parameter("high", "1", 0.02, 2.0, 0.2, "Half its height over its distance."),
        Parameter("depth", "m", 1.0, 60.0, 10.0, "How far away that wall or thing is at the start."),
        Parameter("azimuth", "rad", -np.pi, np.pi, 0.0, "Where it is so far, to the right of the camera's axis."),
        Parameter("elevation", "rad", -np.pi / 2, np.pi / 2, 0.0, "The same, above that axis."),
        Parameter("tilt_x", "1", -2.0, 2.0, 0.0, "Part of its depth by which it is nearer a unit farther right."),
        Parameter("tilt_y", "1", -2.0, 2.0, 0.0, "The same, farther down."),
        Parameter("period", "s", 1e-9, 1e-6, 5.627e-8, "Period of the laser; of a TMF8828 56.27 ns, 17.77 MHz."),
        Parameter("stagger", "s", -1e-7, 1e-7, 0.0, "By how much a second period is longer."),
        Parameter("in_turn", "1", 0.0, 1.0, 0.0, "1 where frames have either in turn, 0 where each has both."),
        Parameter("smear", "s", 0.0, 5e-9, 0.0, "Standard deviation of that period.", tries=(5e-10, 2e-9)),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """With the far target's pulse, and with what is seen beyond the period."""
        found = rendering.expected
        if np.any(values["counts"]):
            found = found + far_pulse(values, rendering)
        seen = {"through": self._wall, "across": partial(self._wall, anywhere=True), "distant": self._thing}
        seen["folded"] = lambda values, now: seen_beyond(now.light, now.clock, values["period"])
        for period_s, part in two_periods(rendering.light, values["period"], values["stagger"], values["in_turn"]):
            for strength, light in seen.items():
                if values[strength]:
                    returns = light({**values, "period": period_s}, rendering)
                    early = one_period_early(rendering, returns, period_s, values["smear"])
                    found = found if early is None else found + values[strength] * part[:, None, None] * early
        return found

    def _wall(self, values: Values, rendering: Rendering, anywhere: bool = False) -> list[Return]:
        """What a wall across the view sends back where depth is unknown, or anywhere."""
        toward, tilt, away_m, motion = self._place(values, rendering)
        there = planes(normal_of(toward, tilt), away_m, motion, rendering.light.time_s)
        return seen_through(rendering.light, *there, anywhere)

    def _thing(self, values: Values, rendering: Rendering) -> list[Return]:
        """What a thing of limited extent sends back."""
        toward, tilt, away_m, motion = self._place(values, rendering)
        extent, light = (values["wide"], values["high"]), rendering.light
        ranges, strength = seen_board(light.rays, toward, away_m, extent, motion, light.time_s, tilt)
        strength = strength * (1 - values["hidden"] * (light.range_m > 0))
        return [Return(ranges.astype(np.float32), strength.astype(np.float32))]

    def _place(self, values: Values, rendering: Rendering) -> tuple:
        """Direction, tilt, (F,) metres and the camera's motion, None where it goes along, of a wall or a thing."""
        toward, tilt = (values["azimuth"], values["elevation"]), (values["tilt_x"], values["tilt_y"])
        motion = camera_motion(rendering.light) if values["still"] > STILL else None
        return toward, tilt, values["depth"] + values["speed"] * rendering.light.time_s, motion

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A pulse so broad is what dark counts look like; one that wanders far by itself is another emitter's.

        And a wall or a thing that seems to be at the sensor is its own glass or air.
        """
        if any(values[name] for name in ("through", "across", "distant")):
            return values["depth"] - speed_of_light / 2 * values["period"] < self.parameter("apparent_range").low
        window_m = rendering.clock.bins * speed_of_light / 2 * rendering.clock.bin_width_s
        wanders = abs(values["speed"]) * float(np.ptp(rendering.light.time_s)) > CROSSED * window_m
        return bool(np.any(values["counts"])) and (values["spread"] > BROADEST_S or wanders)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Straight lines through frames and bins along which most is in excess, no faster than targets are.

        Lines of a target that goes along with the camera, and of one that stands still where the camera moves; such
        walls where depth is unknown; and the periods at which surfaces that are seen beyond them come early.
        """
        beyond = folds(excess, expected, rendering)
        found, slowest, fastest = [], self.parameter("speed").low, self.parameter("speed").high
        way_m, clock = moved_m(rendering.light)[:, 2], rendering.clock
        way_s = -2 * way_m / speed_of_light
        for still in (0.0, 1.0) if np.ptp(way_s) > clock.bin_width_s / 2 else (0.0,):
            most = 2 * fastest / speed_of_light
            for track in straight_tracks(excess, expected, rendering, most, way_s=still * way_s):
                apparent = float(speed_of_light / 2 * (track.arrival_s - np.mean(clock.time_zero_s)))
                moves = {"speed": float(np.clip(speed_of_light / 2 * track.drift, slowest, fastest)), "still": still}
                if apparent >= self.parameter("apparent_range").low:
                    where = {"counts": self.parameter("counts").start, "apparent_range": apparent} | moves
                    broad = [{name: at} for name in ("jitter", "spread") for at in self.parameter(name).tries]
                    found += [where | more for more in ({}, *broad)]
        ways, every = curved_track(excess, expected, rendering)
        for arrival_s, levels in ways:
            apparent = speed_of_light / 2 * (arrival_s - np.mean(clock.time_zero_s))
            by_m = {name: speed_of_light / 2 * level for name, level in levels.items()}
            where = {"apparent_range": float(apparent), "every": every} | by_m
            if all(self.parameter(name).low <= value <= self.parameter(name).high for name, value in where.items()):
                found.append({"counts": self.parameter("counts").start} | where)
        period, reach, smear = (self.parameter(name) for name in ("period", "depth", "smear"))
        far = [("through", wall) for wall in walls(excess, expected, rendering, period.start, smear.tries)]
        far += [("across", wall) for wall in likely_across(excess, expected, rendering)]
        far += [("distant", board) for board in likely_boards(excess, expected, rendering, period.start)]
        for name, where in far:
            beyond.append({name: self.parameter(name).start} | where)
            beyond[-1]["depth"] = float(np.clip(where["depth"], reach.low, reach.high))
        return found + beyond


effect = RangeAliasing()

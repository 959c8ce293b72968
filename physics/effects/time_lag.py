"""`time_lag`: LiDAR and camera do not look at the same time."""

from dataclasses import replace
from typing import Any

import numpy as np

from physics.arrivals import Arrivals, arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.followed import followed
from physics.kept import kept_lately
from physics.lags_told import evenly, promised, ratio, two_groups
from physics.light import Light
from physics.light_between import around, light_at
from physics.owning import Unseen
from physics.rendering import Rendering
from physics.told_between import Told, carries, jumps

# Parts of a step between frames beyond the first or the last of them at which nobody knows what was there.
BLIND = 0.3
# Lags that explain less than this part of a misfit, or less deviance than this, are not what is amiss.
HARDLY, LEAST = 0.1, 20.0
# Slopes are those over half a step to either side; of what is carried, over this part of it: it moves on a curve.
NEARBY = 0.1
# At the image's times, pixel by pixel.
NOW = {"lag": 0.0, "skew": 0.0, "beyond": 0.0, "carried": 0.0}


class TimeLag(Effect):
    """The LiDAR sees the scene lag + skew·t seconds after the camera's image of its frame, before it where negative.

    t is the time since the session began: two clocks that do not agree run apart.

    What it sees then is taken pixel by pixel from the two frames around that time, range and strength linear in
    between; where an edge passes, part of the light of either (`light_at`). What it sees before the first frame and
    after the last nobody knows: nothing moves, or all moves on as it did, by the part `beyond`. Where it is known
    what moves how, the scene before a camera and things in it, all is `carried`: seen from where the camera is by then,
    things where they are (`carried.carried`), by the motions that frames show (`odometry`, `bodies`). Then edges are in
    place; but between frames that do not become each other so light is blended (`followed`). Whether frames are guessed
    better so, from those before and after, says whether a fit begins so.

    A sensor with more zones than converters measures them in two bursts: some zones look `burst` seconds later still,
    those of which `late` is 1. What either sees then is what surfaces send back directly; where zones look, and what
    other effects add by ways of their own, stays as it is in the image's frame.
    """

    id = "time_lag"
    acts_on = "time"
    order = 9  # It concerns all that light has met by then.
    sentence = "The LiDAR measures somewhat later or earlier than the camera takes the image of its frame."
    look_alikes = (
        LookAlike("time_zero_drift", "Hold sensor and scene still: drift goes on, a lag has nothing to show."),
        LookAlike("footprint_shift", "Hold sensor and scene still: a shift stays, a lag has nothing to show."),
        LookAlike("parallax", "Hold sensor and scene still: parallax stays, a lag has nothing to show."),
    )
    forms = (("lag",), ("skew",), ("lag", "skew"), ("burst",), ("lag", "burst"), ("lag", "beyond"))
    richer = forms[-1:]
    parameters = (
        Parameter(
            "lag", "s", -2.0, 2.0, 0.05, "How much later than the camera the LiDAR looks.", 0.0, tries=(-0.05, 0.05)
        ),
        Parameter("skew", "1", -0.5, 0.5, 0.01, "Seconds by which that grows in a second.", vanishes_at=0.0),
        Parameter("burst", "s", -2.0, 2.0, 0.02, "How much later zones of a second burst look.", vanishes_at=0.0),
        Parameter(
            "late",
            unit="1",
            low=-1.0,
            high=1.0,
            start=-1.0,
            axis="zone",
            sentence="1 for zones of the second burst, 0 for others; -1 where those of the second half are.",
        ),
        Parameter("beyond", "1", 0.0, 1.0, 0.0, "How far things move on before the first frame and after the last."),
        Parameter(
            "carried", "1", 0.0, 1.0, 0.0, "1, or more than half, where things are carried along; else pixel by pixel."
        ),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Seconds before and after a frame from which its light comes."""
        if values["skew"]:
            return np.inf, np.inf
        lag, burst = values["lag"], values["burst"]
        return max(-lag, -lag - burst, 0.0), max(lag, lag + burst, 0.0)

    def light(self, values: Values, rendering: Rendering) -> Light:
        """What the scene sends back at the LiDAR's times; the frames keep theirs."""
        return rendering.light if values["burst"] else _then(values, rendering.light)

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """What zones of either burst see by then, in place of what they would have seen with the image."""
        if not values["burst"]:
            return rendering.arrivals
        bursts = values, {**values, "lag": values["lag"] + values["burst"]}
        first, second = (arrivals(_then(of, rendering.light), rendering.footprints, rendering.clock) for of in bursts)
        late = late_zones(values, first.light.shape[1])
        return replace(first, light=np.where(late[:, None], second.light, first.light))

    def owns_up(self, values: Values) -> bool:
        """Whether anything is taken from between frames."""
        return bool(values["lag"] or values["skew"] or values["burst"])

    def carries(self, values: Values) -> bool:
        """Whether that is seen from where the camera is by then."""
        return values["carried"] > 0.5 and self.owns_up(values)

    def unseen(self, values: Values, rendering: Rendering) -> Unseen:
        """What interpolation is off, as that of frames which were seen tells; and what moved on beyond them."""
        times = np.asarray(rendering.light.time_s, float)
        late = late_zones(values, rendering.footprints.seen[0][1].shape[1]) & (values["burst"] != 0)
        moves_on = values["carried"] > 0.5
        told = Told.of(rendering, moves_on)
        found, blind, most = [], np.zeros(len(times), bool), np.ones(len(times))
        for lag, there in ((values["lag"], ~late), (values["lag"] + values["burst"], late)):
            near = around(times, times + lag + values["skew"] * times, 1.0)
            found.append(told.between(*near) + told.beyond(*near, 0.0 if moves_on else 1 - values["beyond"]))
            part = near[2]
            most = np.where(there.any(), np.maximum(most, told.by_chance(part)), most)
            blind |= there.any() & (np.abs(part - np.clip(part, 0, 1)) > BLIND) & (not moves_on)
        return Unseen(np.where(late[:, None], found[1], found[0]), told.together, blind, most)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Lags that explain most of an excess; and zones in two groups, by what they are in each by itself.

        Where frames say that things are carried along they are.
        """
        light, zones = rendering.light, expected.shape[1]
        step_s = float(np.median(np.diff(light.time_s))) / 2 if light.frames > 1 else 0.0
        if not step_s > 0:
            return []
        along: dict[str, Any] = {}
        told, found = _slopes(along, step_s, excess, expected, rendering)
        # What lags explain hardly anything of is not worth the time that carrying takes; unless nobody would know.
        misfit = float((excess**2 / np.maximum(expected, 1)).sum()) - excess.size
        least = max(HARDLY * misfit, LEAST)
        much = promised(told, found, light.time_s) > least
        if (much or jumps(rendering)) and carries(rendering):
            by_motion = _slopes({"carried": 1.0}, NEARBY * step_s, excess, expected, rendering)
            if much or promised(*by_motion, light.time_s) > least:
                along, (told, found) = {"carried": 1.0}, by_motion
        starts = [start | along for start in evenly(told.sum(axis=1), found.sum(axis=1), light.time_s)] if along else []
        if zones > 1:
            lags = found.sum(axis=0) / np.maximum(told.sum(axis=0), 1e-12)
            late = two_groups(lags, told.sum(axis=0))
            lag, burst = (ratio(found[:, of].sum(), told[:, of].sum()) for of in (~late, late))
            alone = {"burst": burst - lag, "late": late.astype(float)} | along
            starts += [{"lag": lag} | alone, alone]
        for start in starts:
            start |= {
                n: float(np.clip(v, self.parameter(n).low, self.parameter(n).high))
                for n, v in start.items()
                if n != "late"
            }
        # Where nothing moves nothing is told.
        return [start for start in starts if all(start.get(n, 1.0) for n in ("lag", "skew", "burst"))]


def _slopes(
    how: dict[str, Any], step_s: float, excess: np.ndarray, expected: np.ndarray, rendering: Rendering
) -> tuple[np.ndarray, np.ndarray]:
    """(F, P) each: information on the lag of each histogram, and score. how: `carried`, or nothing."""
    later, before = (
        arrivals(_then({**NOW, **how, "lag": side * step_s}, rendering.light), rendering.footprints, rendering.clock)
        for side in (1, -1)
    )
    slope = rendering.gain * (later.binned() - before.binned()) / (2 * step_s)
    weight = slope / np.maximum(expected, 1)
    told, found = ((weight * of).sum(axis=2) for of in (slope, excess))
    return told, found


def _then(values: Values, light: Light) -> Light:
    """Light at the LiDAR's times."""
    if values["lag"] == 0 and values["skew"] == 0:
        return light
    return _seen_later(light, *(float(values[name]) for name in ("lag", "skew", "beyond", "carried")))


@kept_lately
def _seen_later(light: Light, lag: float, skew: float, beyond: float, carried: float) -> Light:
    """See above. Zones that look later do so in all that else moves them, or changes what they count."""
    frames_s = np.asarray(light.time_s, float)
    time_s = frames_s + lag + skew * frames_s
    if carried > 0.5:
        return followed(light, *around(frames_s, time_s, 0.0), time_s)
    return light_at(light, time_s, beyond)


def late_zones(values: Values, zones: int) -> np.ndarray:
    """(P,) whether each zone is of the second burst."""
    late = np.broadcast_to(np.asarray(values["late"], float), (zones,))
    return np.where(late < 0, np.arange(zones) >= zones / 2, late > 0.5)


effect = TimeLag()

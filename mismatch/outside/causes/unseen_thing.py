"""A thing is in view that the depth camera does not show."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from mismatch.outside.spot import places, spot
from physics.arrivals import Arrivals
from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering
from physics.tracks import Track, matched_parts, straight_tracks

# Spread of a thing in the image that fits begin with, as a part of its width, and its times of stay as a part of the
# session.
WIDE, SHORTEST = 0.1, 0.1
SPOT = ("bright", "across", "down", "wide")


class UnseenThing(Effect):
    """Something thin, dark or shiny, which stereo does not match: a spot in the image, bell-shaped in space and time.

    At the range r it returns `bright` / r² from the pixels where it is, and `cover` of what lies behind it is gone. It
    moves evenly across the image, its range on a parabola, and is there about the time `when`.
    """

    id = "unseen_thing"
    acts_on = "scene"
    order = 1  # What it hides has been lit by then.
    sentence = "something is in view that the depth camera does not show"
    forms = (
        (*SPOT, "distance", "approach", "when", "lasting"),
        (*SPOT, "cover", "rightward", "downward", "distance", "approach", "bend", "when", "lasting"),
    )
    parameters = (
        Parameter("bright", "1", 0.0, 10.0, 0.02, "Reflectance times the part of a pixel it fills.", vanishes_at=0.0),
        Parameter("cover", "1", 0.0, 1.0, 0.0, "Part of what lies behind that it hides."),
        Parameter("across", "1", -0.5, 1.5, 0.5, "Where it is at `when`, as a part of the image's width."),
        Parameter("down", "1", -0.5, 1.5, 0.5, "Where it is at `when`, as a part of the image's height."),
        Parameter("wide", "1", 0.01, 1.0, WIDE, "Standard deviation of the spot, as a part of the image's width."),
        Parameter("rightward", "1/s", -2.0, 2.0, 0.0, "Widths of the image by which it moves in a second."),
        Parameter("downward", "1/s", -2.0, 2.0, 0.0, "Heights of the image by which it moves in a second."),
        Parameter("distance", "m", 0.01, 50.0, 0.5, "Its range at `when`."),
        Parameter("approach", "m/s", -10.0, 10.0, 0.0, "By how much its range grows in a second, at `when`."),
        Parameter("bend", "m/s²", -10.0, 10.0, 0.0, "Half by how much that grows."),
        Parameter("when", "s", -1e3, 1e5, 1.0, "When it is there most."),
        Parameter("lasting", "s", 1e-3, 1e6, 1.0, "Standard deviation in time of its stay."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The straight lines through frames and bins along which most is in excess, where zones show most of it."""
        tracks = straight_tracks(excess, expected, rendering)
        matched, times = matched_parts(excess, expected, rendering)
        found = [self._start(track, matched, times, rendering) for track in tracks]
        ends = {p.name: (p.low, p.high) for p in self.parameters}
        return [{name: float(np.clip(value, *ends[name])) for name, value in one.items()} for one in found if one]

    def _start(self, track: Track, matched: np.ndarray, times: np.ndarray, rendering: Rendering) -> dict[str, float]:
        """Where and when a line is brightest; nothing where it is nowhere bright."""
        clock = rendering.clock
        bins = ((track.arrival_s + track.drift * times) / clock.bin_width_s).astype(int)
        inside = (bins >= 0) & (bins < clock.bins)
        shown = np.where(inside[:, None], matched[np.arange(len(times)), :, np.clip(bins, 0, clock.bins - 1)], 0)
        shown = np.maximum(shown, 0) ** 2
        if not shown.any():
            return {}
        by_time, by_zone = shown.sum(axis=1), shown.sum(axis=0)
        when = float(times @ by_time / by_time.sum())
        lasting = np.sqrt((times - when) ** 2 @ by_time / by_time.sum())
        weights = rendering.footprints.weights
        weights = weights.mean(axis=0) if weights.ndim == 4 else weights
        right, below = places(weights.shape[1:])
        seen = by_zone / np.maximum(weights.sum(axis=(1, 2)), 1e-12) @ weights.reshape(len(weights), -1)
        metres = speed_of_light / 2
        zero = float(np.mean(clock.time_zero_s))
        return {
            "across": float(seen @ right.ravel() / seen.sum()),
            "down": float(seen @ below.ravel() / seen.sum()),
            "distance": (track.arrival_s + track.drift * when - zero) * metres,
            "approach": track.drift * metres,
            "when": when,
            "lasting": max(lasting, SHORTEST * float(np.ptp(times))),
        }

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light, less what is hidden, and that of the thing."""
        here = rendering.arrivals
        if not (values["bright"] or values["cover"]):
            return here
        since = np.asarray(rendering.light.time_s, float) - values["when"]
        there = np.exp(-0.5 * (since / values["lasting"]) ** 2)
        weights = rendering.footprints.weights
        filled = []
        for i, time in enumerate(since):
            across, down = (
                values[at] + values[by] * time for at, by in (("across", "rightward"), ("down", "downward"))
            )
            thing = there[i] * spot(weights.shape[-2:], across, down, values["wide"])
            filled.append((weights[i] if weights.ndim == 4 else weights).reshape(-1, thing.size) @ thing.ravel())
        seen = np.stack(filled)
        whole = np.maximum(weights.sum(axis=(-2, -1)), 1e-12)
        range_m = np.maximum(values["distance"] + values["approach"] * since + values["bend"] * since**2, 0.01)
        behind = here.light * (1 - values["cover"] * np.minimum(seen / whole, 1))[..., None]
        arrival_s = np.atleast_2d(rendering.clock.time_zero_s) + (2 * range_m / speed_of_light)[:, None]
        return replace(here, light=behind).added(values["bright"] * seen / range_m[:, None] ** 2, arrival_s)


effect = UnseenThing()

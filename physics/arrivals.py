"""The kernel: pixels to a histogram of arrivals, arrivals to bins."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.constants import speed_of_light

from physics.clock import Clock, Lattice
from physics.footprint import Footprints
from physics.knots import bin_knots, delay_knots, splat_knots, stretch_knots, until_knots
from physics.light import Light
from physics.pages import zeros
from physics.workers import in_slices
from recordings.refusal import Refusal

# A frame is worked through in blocks of so many pixels, whatever the number of cores: sums come out the same.
BLOCK_PX = 1 << 17


@dataclass(frozen=True, eq=False)
class Arrivals:
    """When light arrives at F frames' zones, before the pulse spreads it and bins hold it.

    light: (F, P, lattice.size) light by knot of the lattice, pixels · 1/m² as in the nominal model's sum. pulses: (P,
    N + 1) cumulative of each zone's pulse at the edges of the lattice's, None where all have that.
    """

    light: np.ndarray
    lattice: Lattice
    bins: int
    pulses: np.ndarray | None = None

    def binned(self) -> np.ndarray:
        """(F, P, T) light registered in each bin: the pulse integrated over it."""
        per_bin, first = self.lattice.per_bin, 1 - self.lattice.lead

        def bins_of(light: np.ndarray, cumulative: np.ndarray) -> np.ndarray:
            shares, out = _shares(cumulative, per_bin), np.empty((*light.shape[:2], self.bins))
            in_slices(lambda some: bin_knots(light[some], shares, per_bin, first, out[some]), len(light))
            return out

        return self._by_pulse(bins_of)

    def until(self, times: np.ndarray) -> np.ndarray:
        """(F, P, N) light registered until each of N times, or of (P, N) where each zone has its own; linear in a step.

        times: in bins from the start of bin 0.
        """
        lattice, zones = self.lattice, self.light.shape[1]
        # Light of knot 0 is over `lead` steps after the start of bin 0, and sets in the length of the pulse before.
        over = np.asarray(times, float) * lattice.per_bin + len(lattice.cumulative) - 1 - lattice.lead
        over = np.ascontiguousarray(np.broadcast_to(over, (zones, over.shape[-1])))

        def registered(light: np.ndarray, cumulative: np.ndarray, over: np.ndarray) -> np.ndarray:
            light, backward = np.ascontiguousarray(light), np.ascontiguousarray(cumulative[::-1])
            out = np.empty((*light.shape[:2], over.shape[1]))
            in_slices(lambda some: until_knots(light[some], backward, over, out[some]), len(light))
            return out

        return self._by_pulse(registered, over)

    def _by_pulse(self, of: Callable[..., np.ndarray], *by_zone: np.ndarray) -> np.ndarray:
        """What `of` makes of light (F, P, J) and the cumulative (N + 1,) of a pulse, of all zones or of each its own.

        by_zone: (P, ...) what else it takes.
        """
        if self.pulses is None:
            return of(self.light, self.lattice.cumulative, *by_zone)
        zones = (slice(i, i + 1) for i in range(len(self.pulses)))
        each = [of(np.ascontiguousarray(self.light[:, i]), self.pulses[i][0], *(x[i] for x in by_zone)) for i in zones]
        return np.concatenate(each, axis=1)

    def added(self, light: np.ndarray, arrival_s: np.ndarray) -> "Arrivals":
        """With `light` that arrives `arrival_s` after the start of bin 0; both (F, P), or anything that broadcasts."""
        shape = self.light.shape[:2]
        total = self.light.copy()
        at = np.broadcast_to((np.asarray(arrival_s, float) - self.lattice.first_s) / self.lattice.step_s, shape)
        light = np.broadcast_to(light, shape)
        inside = (at >= 0) & (at < self.lattice.size - 1)
        frame, zone = np.nonzero(inside)
        knot = at[inside].astype(int)
        part = at[inside] - knot
        total[frame, zone, knot] += light[inside] * (1 - part)
        total[frame, zone, knot + 1] += light[inside] * part
        return replace(self, light=total)

    def delayed(self, delay_s: np.ndarray) -> "Arrivals":
        """All arrivals later by `delay_s`, (F, P) or anything that broadcasts, earlier where negative.

        Light between two knots is given to both in proportion: exact in its mean time, wider by at most half a step.
        """
        steps = np.broadcast_to(np.asarray(delay_s, float) / self.lattice.step_s, self.light.shape[:2])
        return replace(self, light=delayed(self.light, steps))

    def stretched(self, factor: np.ndarray, about_s: np.ndarray) -> "Arrivals":
        """All arrivals `factor` times as far from `about_s`; (F, P) each, or anything that broadcasts.

        Light between two knots is given to both in proportion, as by `delayed`.
        """
        shape = self.light.shape[:2]
        about = np.broadcast_to((np.asarray(about_s, float) - self.lattice.first_s) / self.lattice.step_s, shape)
        times = np.ascontiguousarray(np.broadcast_to(np.asarray(factor, float), shape))
        light, moved = np.ascontiguousarray(self.light), np.zeros(self.light.shape)
        in_slices(lambda some: stretch_knots(light[some], times[some], about[some], moved[some]), len(light))
        return replace(self, light=moved)


def arrivals(light: Light, footprints: Footprints, clock: Clock) -> Arrivals:
    """Add up every pixel's returns by zone: w_p(u) · strength at time_zero_p + 2r/c, without rounding in time.

    Each return is given to the two knots of the lattice around it (`Lattice`). Light that would be registered before
    the first bin or after the last is left out.
    """
    lattice, pixels = clock.lattice, light.range_m.shape[1] * light.range_m.shape[2]
    seen = footprints.seen
    zones = seen[0][1].shape[1]
    if len(seen) not in (1, light.frames):
        raise Refusal(f"footprints move through {len(seen)} frames, expected {light.frames} as there is light")
    if footprints.x_px.shape[-2:] != light.range_m.shape[1:]:
        raise Refusal(f"footprints on a grid {footprints.x_px.shape[-2:]}, expected {light.range_m.shape[1:]} as depth")
    try:
        zero = np.broadcast_to(np.asarray(clock.time_zero_s, float), (light.frames, zones))
    except ValueError:
        found = np.shape(clock.time_zero_s)
        raise Refusal(f"time_zero_s has shape {found}, expected one time or one for each of {zones} zones") from None
    offset = (zero - lattice.first_s) / lattice.step_s
    per_metre = 2 / speed_of_light / lattice.step_s
    blocks = [slice(at, at + BLOCK_PX) for at in range(0, pixels, BLOCK_PX)]
    sums = zeros((len(blocks), light.frames, zones, lattice.size))

    ways = [tuple(of.reshape(light.frames, pixels) for of in (way.range_m, way.strength)) for way in light.returns]

    def add(some: slice) -> None:
        at = some.start
        while at < some.stop:
            block, frame = divmod(at, light.frames)
            # Frames whose footprints are the same are added up together.
            frames = slice(frame, min(frame + some.stop - at, light.frames) if len(seen) == 1 else frame + 1)
            where, weights = (of[blocks[block]] for of in seen[frame % len(seen)])
            for ranges, strength in ways:
                out = sums[block, frames]
                splat_knots(ranges[frames], strength[frames], where, weights, offset[frames], per_metre, out)
            at += frames.stop - frame

    in_slices(add, len(blocks) * light.frames)
    return Arrivals(sums[0] if len(blocks) == 1 else sums.sum(axis=0), lattice, clock.bins)


def delayed(light: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(F, P, J) light by knot, that of each zone later by its number of `steps` (F, P), of which parts are shared."""
    light, steps, moved = np.ascontiguousarray(light), np.array(steps, float), np.empty(light.shape)
    in_slices(lambda some: delay_knots(light[some], steps[some], moved[some]), len(light))
    return moved


def _shares(cumulative: np.ndarray, per_bin: int) -> np.ndarray:
    """(M,) share of a pulse in a bin, by knot, from the earliest that still reaches it to the latest."""
    steps = len(cumulative) - 1
    since = np.arange(steps - 1, -per_bin, -1)  # Steps of the pulse that have passed when the bin begins.
    return cumulative[np.clip(since + per_bin, 0, steps)] - cumulative[np.clip(since, 0, steps)]

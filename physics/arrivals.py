"""The kernel: pixels to a histogram of arrivals, arrivals to bins."""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.constants import speed_of_light

from physics.clock import Clock, Lattice
from physics.footprint import Footprints
from physics.light import Light
from physics.pages import zeros
from physics.workers import in_slices
from recordings.refusal import Refusal

# A frame is worked through in blocks of so many pixels, whatever the number of cores: sums come out the same.
BLOCK_PX = 1 << 17


@dataclass(frozen=True, eq=False)
class Arrivals:
    """When light arrives at F frames' zones, before the pulse spreads it and bins hold it.

    light: (F, P, lattice.size) light by knot of the lattice, pixels · 1/m² as in the nominal model's sum.
    """

    light: np.ndarray
    lattice: Lattice
    bins: int

    def binned(self) -> np.ndarray:
        """(F, P, T) light registered in each bin: the pulse integrated over it."""
        frames, zones, _ = self.light.shape
        shares, first = _shares(self.lattice), 1 - self.lattice.lead
        out = np.empty((frames, zones, self.bins))
        in_slices(lambda some: _bin(self.light[some], shares, self.lattice.per_bin, first, out[some]), frames)
        return out

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
                _splat(ranges[frames], strength[frames], where, weights, offset[frames], per_metre, out)
            at += frames.stop - frame

    in_slices(add, len(blocks) * light.frames)
    return Arrivals(sums[0] if len(blocks) == 1 else sums.sum(axis=0), lattice, clock.bins)


def delayed(light: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(F, P, J) light by knot, that of each zone later by its number of `steps` (F, P), of which parts are shared."""
    light, steps, moved = np.ascontiguousarray(light), np.array(steps, float), np.empty(light.shape)
    in_slices(lambda some: _delay(light[some], steps[some], moved[some]), len(light))
    return moved


def _shares(lattice: Lattice) -> np.ndarray:
    """(M,) share of a pulse in a bin, by knot, from the earliest that still reaches it to the latest."""
    n, steps = lattice.per_bin, len(lattice.cumulative) - 1
    since = np.arange(steps - 1, -n, -1)  # Steps of the pulse that have passed when the bin begins.
    return lattice.cumulative[np.clip(since + n, 0, steps)] - lattice.cumulative[np.clip(since, 0, steps)]


@njit(nogil=True, cache=True)
def _splat(ranges, strength, pixels, weights, offset, per_metre, out):
    """Add light of F frames' N pixels, with weights (N, P), to (F, P, J) knots."""
    zones, last = out.shape[1], out.shape[2] - 1
    for f in range(out.shape[0]):
        first_zone, last_zone = offset[f].min(), offset[f].max()
        for i in range(pixels.size):
            light = float(strength[f, pixels[i]])
            if not light > 0:
                continue
            travel = ranges[f, pixels[i]] * per_metre
            if travel + first_zone >= 0 and travel + last_zone < last:
                for p in range(zones):  # No zone has to be asked.
                    _share(travel + offset[f, p], light * weights[i, p], out[f, p])
                continue
            for p in range(zones):
                at = travel + offset[f, p]
                if 0 <= at < last:
                    _share(at, light * weights[i, p], out[f, p])


@njit(nogil=True, cache=True, inline="always")
def _share(at, given, row):
    """Give light to the two knots of a row about `at`."""
    whole = np.int64(at)
    knot = np.uint64(whole)  # An index without sign: no test whether it counts from the end.
    later = given * (at - whole)
    row[knot] += given - later
    row[knot + np.uint64(1)] += later


@njit(nogil=True, cache=True)
def _delay(light, steps, out):
    """Fill (F, P, J) knots with those of `light`, each row later by its own number of steps, earlier where negative."""
    frames, zones, size = light.shape
    for f in range(frames):
        for p in range(zones):
            # Beyond the lattice either way all is gone.
            by = min(max(steps[f, p], -size - 1.0), size + 1.0)
            whole = np.int64(np.floor(by))
            later = by - whole
            out[f, p] = 0.0
            for j in range(max(whole, 0), min(whole, 0) + size):
                out[f, p, j] += (1 - later) * light[f, p, j - whole]
            for j in range(max(whole + 1, 0), min(whole + 1, 0) + size):
                out[f, p, j] += later * light[f, p, j - whole - 1]


@njit(nogil=True, cache=True, fastmath={"reassoc", "contract"})
def _bin(light, shares, per_bin, first, out):
    """Fill (F, P, T) bins from (F, P, J) knots; `shares` of bin 0 are those of knots `first` and later."""
    frames, zones, knots = light.shape
    for f in range(frames):
        for p in range(zones):
            row = light[f, p]
            begin, end = 0, knots
            while begin < end and row[begin] == 0:
                begin += 1
            while begin < end and row[end - 1] == 0:
                end -= 1
            for t in range(out.shape[2]):
                at = first + t * per_bin
                low, high = max(begin, at), min(end, at + shares.size)
                total = 0.0
                for j in range(high - low):
                    # Indices without sign, as above: the compiler takes several at once.
                    total += row[np.uint64(low + j)] * shares[np.uint64(low - at + j)]
                out[f, p, t] = total

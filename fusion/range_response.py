"""What light from each range makes of a histogram, under whatever a sensor is known to do."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.constants import speed_of_light

from physics.footprint import Footprints
from physics.light import Light, Return
from physics.nominal import ForwardModel
from physics.sensor import SensorModel
from physics.setting import Setting
from recordings.refusal import Refusal

# A response that changes by more than this part of its largest value between faint and bright light is not linear.
LINEAR = 1e-3
FAINT, BRIGHT = 1.0, 1e5
# Of a response, what is less than this part of its sum is not followed.
NOTHING = 1e-6
# Steps of the finer table to one of `range_m`: linear between them errs by 1/16 of what half a bin does.
FINE = 4


@dataclass(frozen=True, eq=False)
class RangeResponse:
    """Histograms of faint light by range, for P zones of T bins.

    sensor: how it counts. range_m: (B,) ascending; half a bin apart unless others were asked for. counts: (P, B, T)
    counts in each bin for one unit of light from each range: where a sensor is nominal, the shares of one count. A unit
    is gain · Σ w·ρ·cosθ/r² = 1 of the nominal model. pedestal: (P, T) counts where nothing is there: background,
    crosstalk, other emitters. lossy: whether brightness or other zones change the response, so that `expected` is not
    the sum of `counts`.

    What a scene does to light (`light` of an effect) and where zones look (`footprints`) is no part of it, and effects
    that look at other frames are left out. Drifts are taken at the session's beginning.
    """

    sensor: SensorModel
    range_m: np.ndarray
    counts: np.ndarray
    pedestal: np.ndarray
    lossy: bool

    @cached_property
    def bands(self) -> np.ndarray:
        """(P, B, 2) first bin that light from a range reaches, and the one after the last."""
        there = self.counts > NOTHING * self.counts.sum(axis=2, keepdims=True)
        bins = there.shape[2]
        first, last = there.argmax(axis=2), bins - there[:, :, ::-1].argmax(axis=2)
        return np.where(there.any(axis=2)[..., None], np.stack([first, last], axis=-1), 0)

    @cached_property
    def fine_m(self) -> np.ndarray:
        """(R,) ranges of the finer table: `range_m`, and those between that divide each step evenly."""
        many = len(self.range_m)
        return np.interp(np.arange((many - 1) * FINE + 1) / FINE, np.arange(many), self.range_m)

    @cached_property
    def fine_counts(self) -> np.ndarray:
        """(P, R, T) `counts` at the ranges `fine_m`: half a bin is too far for a line between two pulses."""
        alone, dark = _dark(self.sensor, self.fine_m)
        made = np.empty((len(self.counts), len(self.fine_m), self.counts.shape[2]))
        # As many ranges at a time as in the coarse table: memory grows with their square.
        for at in range(0, len(self.fine_m), len(self.range_m)):
            part = slice(at, at + len(self.range_m))
            made[:, part] = _each(self.sensor, alone, self.fine_m[part], FAINT, dark).swapaxes(0, 1)
        return np.maximum(made, 0)

    @cached_property
    def width_m(self) -> float:
        """Standard deviation of the pulse and a bin together, as a range."""
        pulse = self.sensor.response
        mean = pulse.time_s @ pulse.probability
        variance = (pulse.time_s - mean) ** 2 @ pulse.probability + self.sensor.bin_width_s**2 / 12
        return float(np.sqrt(variance)) * speed_of_light / 2

    @cached_property
    def flat(self) -> np.ndarray:
        """(P,) counts per bin of the pedestal that are the same in all bins."""
        return self.pedestal.min(axis=1)

    def linear(self, light: np.ndarray, level: np.ndarray) -> np.ndarray:
        """(F, P, T) counts of light (F, P, B) and a flat level (F, P) of counts per bin, if nothing is lost."""
        made = np.einsum("fpb,pbt->fpt", light, self.counts, optimize=True)
        return made + (self.pedestal - self.flat[:, None]) + level[..., None]

    def expected(self, light: np.ndarray, level: np.ndarray) -> np.ndarray:
        """(F, P, T) counts of the same, with all the sensor's effects: bright light may hide what comes later."""
        own = self.sensor.background_counts
        return np.concatenate(
            [
                _counts(self.sensor, _taken(self.sensor.effects), self.range_m, one[None], np.maximum(rest, 0))
                for one, rest in zip(light, own + level - self.flat, strict=True)
            ]
        )


def range_response(sensor: SensorModel, range_m: np.ndarray | None = None) -> RangeResponse:
    """The response of a sensor, made by the forward model with the effects that are on.

    range_m: (B,) metres, ascending; where None, half a bin apart up to the end of the sensor's window, which is as fine
    as its pulse can tell. Raises `Refusal` where a sensor's window is empty or its effects cannot be computed.
    """
    ranges = window_ranges(sensor) if range_m is None else np.asarray(range_m, float)
    if ranges.ndim != 1 or not (ranges > 0).all() or not (np.diff(ranges) > 0).all():
        raise Refusal("range_m holds ranges that are not ascending metres above 0, expected such")
    taken = _taken(sensor.effects)
    pedestal = _counts(sensor, taken, ranges, np.zeros((1, sensor.zones, len(ranges))), sensor.background_counts)[0]
    alone, dark = _dark(sensor, ranges)
    faint, bright = (_each(sensor, alone, ranges, light, dark) for light in (FAINT, BRIGHT))
    lossy = len(alone) < len(taken) or bool(np.abs(bright - faint).max() > LINEAR * np.abs(faint).max())
    counts = np.ascontiguousarray(np.maximum(faint, 0).swapaxes(0, 1))
    if not counts.any():
        raise Refusal("sensor: light of no range is registered in any bin, expected a window that holds some")
    return RangeResponse(sensor, ranges, counts, pedestal, lossy)


def window_ranges(sensor: SensorModel) -> np.ndarray:
    """(B,) ranges half a bin apart, from half a bin to where light of the latest zone leaves the window."""
    step = sensor.bin_width_s / 2 * speed_of_light / 2
    end = (sensor.bins * sensor.bin_width_s - float(np.max(sensor.time_zero_s))) * speed_of_light / 2
    if end < 2 * step:
        raise Refusal(f"sensor: its window ends {end:.3g} m away, expected a bin or more after time zero")
    return step * np.arange(1, int(end / step) + 1)


def _taken(effects: Iterable[Setting]) -> tuple[Setting, ...]:
    """The effects that are the sensor's own, whatever the scene."""
    return tuple(s for s in effects if not s.effect.in_scene(s.values) and not s.effect.reaches(s.values))


def _dark(sensor: SensorModel, ranges: np.ndarray) -> tuple[tuple[Setting, ...], np.ndarray]:
    """Effects of a zone by itself, and the counts (1, P, T) they make without light.

    What light of one zone does to another is left to `expected`.
    """
    alone = tuple(setting for setting in _taken(sensor.effects) if setting.effect.acts_on != "optics")
    return alone, _counts(sensor, alone, ranges, np.zeros((1, sensor.zones, len(ranges))), sensor.background_counts)


def _each(
    sensor: SensorModel, alone: tuple[Setting, ...], ranges: np.ndarray, light: float, dark: np.ndarray
) -> np.ndarray:
    """(B, P, T) counts above those in the dark (1, P, T), per unit, that `light` units from each range (B,) make."""
    each = np.broadcast_to(np.eye(len(ranges))[:, None], (len(ranges), sensor.zones, len(ranges)))
    return (_counts(sensor, alone, ranges, light * each, sensor.background_counts) - dark) / light


def _counts(
    sensor: SensorModel, effects: tuple[Setting, ...], ranges: np.ndarray, light: np.ndarray, background: np.ndarray
) -> np.ndarray:
    """(F, P, T) expected counts of light (F, P, B).

    The scene is one row of B pixels, one at each range, and a zone sees each with the weight that makes its light:
    strength is 1/r² as anywhere, so weights are light · r².
    """
    frames, zones, _ = light.shape
    row = np.broadcast_to(ranges.astype(np.float32), (frames, 1, len(ranges)))
    ones = np.ones_like(row)
    strength = (1 / np.square(row)).astype(np.float32)
    cycles = None if sensor.laser_cycles is None else np.full(frames, float(sensor.laser_cycles))
    missing = np.zeros(frames, int)
    seen = Light(np.zeros(frames), cycles, np.eye(3), row, ones, ones, (Return(row, strength),), missing)
    place = np.zeros((1, len(ranges)))
    where = Footprints(None, place, place, 1.0, sensor.zone_grid)
    # These footprints were not read from maps.
    where.__dict__["weights"] = (light * ranges**2).reshape(frames, zones, 1, -1)
    return ForwardModel(seen, where, sensor.clock, background).expected(1.0, effects)

"""The SensorModel: how a diffuse LiDAR counts."""

from dataclasses import dataclass, field

import numpy as np

from physics.axes import sizes_along
from physics.clock import Clock
from physics.pulse import ImpulseResponse
from physics.pulse_shape import PulseShape
from physics.setting import Setting, in_order
from recordings.recording import Recording
from recordings.refusal import Refusal

# Far beyond any such sensor, and short of what a slip of the keyboard would cost in memory.
MOST_ZONES, MOST_BINS = 1 << 14, 1 << 16


@dataclass(frozen=True, eq=False)
class SensorModel:
    """How P zones of a sensor count: timing, impulse response, and the effects that are on.

    name, mode: which sensor, in which mode. zone_grid: rows, columns; their product is P. bins: T.
    bin_width_s: seconds. time_zero_s: (P,) seconds, arrival of a target at range 0 from the start of bin 0.
    pulse: impulse response, by its parameters or sampled. laser_cycles: shots in a frame, None where unknown.
    laser_hz: shots per second, None where unknown. background_counts: (P,) counts per bin with the emitter off.
    effects: departures from the nominal model, with their parameters.
    sources: field name -> where its number comes from.

    Raises `Refusal` with one sentence naming the field, the value at fault and what was expected.
    """

    name: str
    zone_grid: tuple[int, int]
    bins: int
    bin_width_s: float
    time_zero_s: np.ndarray
    pulse: PulseShape | ImpulseResponse
    mode: str = ""
    laser_cycles: int | None = None
    laser_hz: float | None = None
    background_counts: np.ndarray | None = None
    effects: tuple[Setting, ...] = ()
    sources: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows, columns = self.zone_grid
        if not (rows >= 1 and columns >= 1 and rows * columns <= MOST_ZONES):
            raise Refusal(
                f"zone_grid is {rows:g} x {columns:g}, expected 1 or more of each, {MOST_ZONES} in all at most"
            )
        if not 1 <= self.bins <= MOST_BINS:
            raise Refusal(f"bins is {self.bins:g}, expected 1 to {MOST_BINS}")
        _positive("bin_width_s", self.bin_width_s, "seconds")
        for name in ("laser_cycles", "laser_hz"):
            if getattr(self, name) is not None:
                _positive(name, getattr(self, name), "shots")
        background = 0.0 if self.background_counts is None else self.background_counts
        for name, values in (("time_zero_s", self.time_zero_s), ("background_counts", background)):
            object.__setattr__(self, name, self._by_zone(name, values))
        if (self.background_counts < 0).any():
            raise Refusal(f"background_counts holds {self.background_counts.min():g}, expected counts of 0 or more")
        for setting in in_order(self.effects):
            for parameter, value in setting.values.items():
                axis = setting.effect.parameter(parameter).axis
                many = sizes_along(self.zones, self.bins).get(axis)
                if np.ndim(value) and len(value) != many:
                    place = f"effect {setting.effect.id}: {parameter}"
                    raise Refusal(f"{place} has {len(value)} values, expected one or {many}, one for each {axis}")
        unknown = sorted(self.sources.keys() - self.__dataclass_fields__.keys())
        if unknown:
            raise Refusal(f"sources names {unknown[0]!r}, expected names of fields")

    @property
    def zones(self) -> int:
        """P."""
        return self.zone_grid[0] * self.zone_grid[1]

    def is_estimate(self, name: str) -> bool:
        """Whether this field was estimated from a recording."""
        return self.sources.get(name, "").startswith("estimated")

    @property
    def response(self) -> ImpulseResponse:
        """The impulse response, sampled."""
        return self.pulse.sampled(self.bin_width_s) if isinstance(self.pulse, PulseShape) else self.pulse

    @property
    def clock(self) -> Clock:
        """How it registers time."""
        return Clock(self.bin_width_s, self.bins, self.time_zero_s, self.response)

    @classmethod
    def of(cls, recording: Recording) -> "SensorModel":
        """The nominal sensor that a recording says it was made with; refused where it does not carry its pulse."""
        if recording.irf is None:
            raise Refusal("irf is missing in the recording, expected an impulse response or a sensor.json with one")
        meta, cycles = recording.meta, recording.laser_cycles
        return cls(
            name=str(meta.get("sensor", "")),
            mode=str(meta.get("mode", "")),
            zone_grid=tuple(int(n) for n in recording.zone_grid),
            bins=recording.counts.shape[2],
            bin_width_s=float(recording.bin_width_s),
            time_zero_s=np.asarray(recording.time_zero_s, float),
            pulse=ImpulseResponse(np.asarray(recording.irf_time_s, float), np.asarray(recording.irf, float)),
            laser_cycles=None if cycles is None else int(np.ravel(cycles)[0]),
            background_counts=recording.background_counts,
        )

    def _by_zone(self, name: str, values: np.ndarray | float) -> np.ndarray:
        """(P,) values from one, or one for each zone."""
        array = np.asarray(values, float)
        if array.shape not in ((), (self.zones,)):
            raise Refusal(f"{name} has shape {array.shape}, expected one value or one for each of {self.zones} zones")
        if not np.isfinite(array).all():
            raise Refusal(f"{name} holds {array[~np.isfinite(array)].ravel()[0]}, expected finite numbers")
        return np.broadcast_to(array, self.zones)


def _positive(name: str, value: float, unit: str) -> None:
    """Refuse a number that is not positive and finite."""
    if not (np.isfinite(value) and value > 0):
        raise Refusal(f"{name} is {value}, expected positive, finite {unit}")

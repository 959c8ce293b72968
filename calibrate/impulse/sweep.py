"""Frames of known geometry, and when their light arrives on a clock that is not quite known."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from calibrate.impulse.cells import Cells, cells_of
from calibrate.impulse.likelihood import exposure
from calibrate.impulse.shape import Shape
from physics.arrivals import Arrivals, arrivals
from physics.clock import Clock
from physics.footprint import Footprints, footprints
from physics.light import Light, direct_light
from physics.pulse import ImpulseResponse
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal


@dataclass(frozen=True, eq=False)
class Sweep:
    """F frames of a scene whose geometry is known, as P zones counted them in T bins.

    light: what the scene sends back. footprints: where zones look. counts: (F, P, T). bin_width_s: seconds.
    time_zero_s: (P,) or one, seconds from the start of bin 0. shots: (F,) laser shots of a frame times channels of a
    zone, each of which registers one photon a shot; None where no photon hides another.
    """

    light: Light
    footprints: Footprints
    counts: np.ndarray
    bin_width_s: float
    time_zero_s: np.ndarray | float
    shots: np.ndarray | None = None

    def __post_init__(self) -> None:
        counts = np.asarray(self.counts, float)
        if counts.ndim != 3 or len(counts) != self.light.frames:
            raise Refusal(f"counts have shape {counts.shape}, expected ({self.light.frames}, P, T) as there is light")
        zero = np.asarray(self.time_zero_s, float)
        if zero.shape not in ((), (counts.shape[1],)):
            raise Refusal(f"time_zero_s has shape {zero.shape}, expected one time or one for each zone")
        object.__setattr__(self, "counts", counts)
        object.__setattr__(self, "time_zero_s", np.broadcast_to(zero, counts.shape[1]))
        if self.shots is not None:
            shots = np.broadcast_to(np.asarray(self.shots, float), len(counts))
            if not (np.isfinite(shots) & (shots > 0)).all():
                raise Refusal(f"laser shots are {shots.min():g}, expected a finite number above 0")
            object.__setattr__(self, "shots", shots)

    @classmethod
    def of(
        cls,
        recording: Recording,
        maps: ResponseMaps,
        shots: float | None = None,
        nearest_m: float = 0.0,
        farthest_m: float = np.inf,
    ) -> "Sweep":
        """The frames of a recording that keep the depth of what was seen, as zones that look where `maps` say saw it.

        shots: as above, the recording's laser_cycles where None. nearest_m, farthest_m: frames whose median depth is
        outside are left out: light that returns from a few centimetres is seen through the edge of the optics.
        """
        for name in ("depth_m", "intrinsics"):
            if getattr(recording, name) is None:
                raise Refusal(f"{name} is missing in the recording, expected the geometry of what was seen")
        depth = np.asarray(recording.depth_m)
        counts = np.asarray(recording.counts)
        if depth.ndim == 2:
            depth = np.broadcast_to(depth, (len(counts), *depth.shape))
        middle = np.array([np.median(d[np.isfinite(d)]) if np.isfinite(d).any() else np.nan for d in depth])
        kept = np.flatnonzero((middle >= nearest_m) & (middle <= farthest_m))
        if not len(kept):
            raise Refusal(f"no frame has its median depth in {nearest_m:g} to {farthest_m:g} m, expected some")

        def images(name: str) -> np.ndarray | None:
            field = getattr(recording, name)
            return None if field is None else np.broadcast_to(np.asarray(field), depth.shape)[kept]

        light = direct_light(depth[kept], recording.intrinsics, images("reflectance"), images("incidence_cosine"))
        where = footprints(maps, depth.shape[1:], recording.meta.get("calibration_range_m"))
        if shots is None and recording.laser_cycles is not None:
            shots = np.broadcast_to(np.asarray(recording.laser_cycles, float), len(depth))[kept]
        zero = np.asarray(recording.time_zero_s, float)
        return cls(light, where, counts[kept], float(recording.bin_width_s), zero, shots)

    def with_channels(self, channels: int) -> "Sweep":
        """The same, the light of each zone shared evenly by so many timing channels."""
        return self if self.shots is None else replace(self, shots=self.shots * channels)

    def part(self, frames: slice | np.ndarray) -> "Sweep":
        """Some of the frames: a slice or indices."""
        old = self.light
        light = Light(
            old.time_s[frames],
            None,
            old.intrinsics,
            *(getattr(old, name)[frames] for name in ("range_m", "reflectance", "cosine")),
            tuple(type(r)(r.range_m[frames], r.strength[frames]) for r in old.returns),
            old.missing[frames],
        )
        shots = None if self.shots is None else self.shots[frames]
        return Sweep(light, self.footprints, self.counts[frames], self.bin_width_s, self.time_zero_s, shots)

    @cached_property
    def alive(self) -> np.ndarray:
        """(F, P, T) share of the shots that have registered nothing before each bin."""
        return exposure(self.counts, self.shots)

    @cached_property
    def lit(self) -> np.ndarray:
        """(F, P) whether any light of the scene reaches a zone within its window."""
        return self.arrivals(Shape(1, 0.5, 0.0, 0.5)).light.any(axis=2)

    def arrivals(self, shape: Shape, delay: np.ndarray | float = 0.0, stretch: float = 0.0) -> Arrivals:
        """When light arrives, for zones delayed by `delay` (P,) or (F, P) steps, bins wider by the share `stretch`."""
        width = self.bin_width_s * (1 + stretch)
        steps = len(shape.offsets)
        response = ImpulseResponse(shape.offsets * width / shape.per_bin, np.full(steps, 1 / steps))
        zero = (self.time_zero_s / self.bin_width_s + np.asarray(delay) / shape.per_bin) * width
        return arrivals(self.light, self.footprints, Clock(width, self.counts.shape[2], zero, response))

    def cells(self, shape: Shape, zones: list[int], delay: np.ndarray, stretch: float) -> list[Cells]:
        """The cells of each of `zones`, delayed by `delay` (F, len(zones)) steps."""
        late = np.zeros(self.counts.shape[:2])
        late[:, zones] = delay
        arriving = self.arrivals(shape, late, stretch)
        zero = (self.time_zero_s / self.bin_width_s + late / shape.per_bin) * self.bin_width_s * (1 + stretch)
        return [cells_of(arriving, self.counts, self.alive, self.shots, zero, zone) for zone in zones]

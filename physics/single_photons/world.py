"""What one frame of photons meets: a scene seen by one camera image, zones, a clock, and photons on their way."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from recordings.maps import ResponseMaps

NO_PIXEL = -1


@dataclass(frozen=True, eq=False)
class World:
    """One frame as photons meet it; acts change it with `dataclasses.replace`.

    time_s: since the first frame. depth_m, reflectance, cosine: (H, W) float64, NaN where unknown; cosine is that of
    incidence. intrinsics: (3, 3). maps: where zones look. weights: (P, H, W) how strongly zone p sees a pixel, largest
    of the undisturbed maps on the grid = 1. gain: counts per unit of light. laser_cycles: shots in this frame, None
    where unknown. zone_grid: rows, columns. bin_width_s; bins: T; time_zero_s: (P,). pulse_time_s, pulse: (N,) impulse
    response, probability of each step, spread evenly over it. background: (P,) counts per bin.
    at: another frame of the same scene by its time, seconds; between two frames the nearer.
    times_s: (F,) times of all frames. gloss: (H, W) or one number, how many times as bright as a matt surface.
    behind: (H, W) each: which part of a pixel's photons comes from another surface, and how many metres that is behind
    (before where negative) the one at its depth; None where all photons come from there.
    start_from_camera: (4, 4) rigid transform to the camera's frame of when the session began, None where unknown.
    boost: how many times as many photons come as without changes of sensitivity; gain and background have it in them,
    acts that add photons by number add boost times as many.
    """

    time_s: float
    depth_m: np.ndarray
    reflectance: np.ndarray
    cosine: np.ndarray
    intrinsics: np.ndarray
    maps: ResponseMaps
    weights: np.ndarray
    gain: float
    laser_cycles: int | None
    zone_grid: tuple[int, int]
    bin_width_s: float
    bins: int
    time_zero_s: np.ndarray
    pulse_time_s: np.ndarray
    pulse: np.ndarray
    background: np.ndarray
    at: Callable[[float], "World"]
    times_s: np.ndarray
    gloss: np.ndarray | float = 1.0
    behind: tuple[np.ndarray, np.ndarray] | None = None
    start_from_camera: np.ndarray | None = None
    boost: float = 1.0

    @property
    def zones(self) -> int:
        """P."""
        return self.zone_grid[0] * self.zone_grid[1]

    @property
    def points(self) -> np.ndarray:
        """(H, W, 3) metres in the camera frame, of each pixel's centre."""
        v, u = np.indices(self.depth_m.shape)
        pixels = np.stack([u, v, np.ones_like(u)], axis=-1).astype(float)
        return pixels @ np.linalg.inv(self.intrinsics).T * self.depth_m[..., None]

    @property
    def range_m(self) -> np.ndarray:
        """(H, W) distance of each pixel's point from the sensor."""
        return np.linalg.norm(self.points, axis=-1)


@dataclass(frozen=True, eq=False)
class Photons:
    """Photons, one entry each, before they are detected.

    zone: (N,) which zone each falls on. time_s: (N,) when it is registered, from the start of bin 0, by the clock of
    its zone, pulse included. pixel: (N,) flat index of the camera pixel it comes from, NO_PIXEL where from none.
    shot: (N,) laser shot of the frame, 0 to laser_cycles - 1; all 0 where the shots are unknown.
    detour_m: (N,) by how much its way there and back is longer than twice the range of its pixel; None where no
    photon's is.
    """

    zone: np.ndarray
    time_s: np.ndarray
    pixel: np.ndarray
    shot: np.ndarray
    detour_m: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.zone)

    def only(self, which: np.ndarray) -> "Photons":
        """Those of a mask or an index array (M,)."""
        detour = None if self.detour_m is None else self.detour_m[which]
        return Photons(self.zone[which], self.time_s[which], self.pixel[which], self.shot[which], detour)

    def and_also(self, more: "Photons") -> "Photons":
        """These and more."""
        pairs = [(getattr(self, name), getattr(more, name)) for name in ("zone", "time_s", "pixel", "shot")]
        if self.detour_m is not None or more.detour_m is not None:
            pairs.append(tuple(np.zeros(len(p)) if p.detour_m is None else p.detour_m for p in (self, more)))
        return Photons(*(np.concatenate(pair) for pair in pairs))

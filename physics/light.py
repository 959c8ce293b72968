"""What the scene sends back: for every camera pixel, how far away a surface is and how much light returns from it."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numba import njit

from physics.geometry import incidence_cosine, inverse_pinhole, pixel_rays
from physics.materials import materials, parts
from physics.motion import Motion
from physics.pages import zeros
from physics.segments import segments
from physics.workers import in_parallel
from recordings.refusal import Refusal

# What float32 may round a reflectance or a cosine of 1 to.
ABOVE_1 = 1 + 1e-6


@dataclass(frozen=True, eq=False)
class Return:
    """One way light takes from every pixel's direction back to the sensor.

    range_m: (F, H, W) float32 metres, half the way there and back. strength: (F, H, W) float32 1/m², what the nominal
    model calls ρ·cosθ/r²; 0 where nothing returns.
    """

    range_m: np.ndarray
    strength: np.ndarray


@dataclass(frozen=True, eq=False)
class Light:
    """F frames of a scene as the sensor's light meets it.

    time_s: (F,) seconds since the first frame of the session. laser_cycles: (F,) laser shots by frame, None where
    unknown. intrinsics: (3, 3) pinhole matrix of the grid. range_m, reflectance, cosine: (F, H, W) float32 of
    the surfaces that are lit directly. returns: the ways light takes; the first is the direct one.
    missing: (F,) pixels that contribute nothing because depth, reflectance or incidence is not known there.
    motion: of the camera, in these frames at least; None where it is not known.
    part_of: light of all frames of which these are some, and which, (F,); None where these are all.
    assumed: like reflectance, before an effect changed that; None where none has. kept: what was made of the scene, for
    all light that it sends back.
    """

    time_s: np.ndarray
    laser_cycles: np.ndarray | None
    intrinsics: np.ndarray
    range_m: np.ndarray
    reflectance: np.ndarray
    cosine: np.ndarray
    returns: tuple[Return, ...]
    missing: np.ndarray
    motion: Motion | None = None
    part_of: "tuple[Light, np.ndarray] | None" = None
    assumed: np.ndarray | None = None
    kept: dict[str, tuple] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return len(self.range_m)

    @cached_property
    def rays(self) -> np.ndarray:
        """(H, W, 3) ray through each pixel's centre, of length 1 along z."""
        return pixel_rays(self.intrinsics, self.range_m.shape[1:])

    @property
    def assumed_reflectance(self) -> np.ndarray:
        """(F, H, W) float32, whatever effects have made of it."""
        return self.reflectance if self.assumed is None else self.assumed

    @cached_property
    def surfaces(self) -> np.ndarray:
        """(F, H, W) int32 number of the surface at each pixel, followed through all frames as `segments` does."""
        if self.part_of is None:
            cameras = None if self.motion is None else self.motion.at(self.time_s)
            return segments(self.range_m, self.intrinsics, cameras)
        every, frames = self.part_of
        return every.surfaces[frames]

    @cached_property
    def materials(self) -> np.ndarray:
        """(F, H, W) int32 number of the material at each pixel, told by assumed reflectance as `materials` does."""
        if self.part_of is None:
            return materials(self.assumed_reflectance, self.surfaces)
        every, frames = self.part_of
        return every.materials[frames]

    @cached_property
    def pieces(self) -> np.ndarray:
        """(F, H, W) int32 number of the part of a surface that is of one material, the largest first; 0 at none."""
        if self.part_of is None:
            return parts(self.surfaces, self.materials)
        every, frames = self.part_of
        return every.pieces[frames]

    def of(self, chosen: np.ndarray) -> "Light":
        """Some of the frames, by index (N,)."""
        every, frames = (self, np.arange(self.frames)) if self.part_of is None else self.part_of
        return replace(
            self,
            time_s=self.time_s[chosen],
            laser_cycles=None if self.laser_cycles is None else self.laser_cycles[chosen],
            range_m=self.range_m[chosen],
            reflectance=self.reflectance[chosen],
            cosine=self.cosine[chosen],
            returns=tuple(Return(way.range_m[chosen], way.strength[chosen]) for way in self.returns),
            missing=self.missing[chosen],
            part_of=(every, frames[chosen]),
            assumed=None if self.assumed is None else self.assumed[chosen],
            kept={},
        )


def direct_light(
    depth_m: np.ndarray,
    intrinsics: np.ndarray,
    reflectance: np.ndarray | None = None,
    cosine: np.ndarray | None = None,
    *,
    time_s: np.ndarray | None = None,
    laser_cycles: np.ndarray | None = None,
    first_frame: int = 0,
    motion: Motion | None = None,
) -> Light:
    """The nominal model's light: strength ρ·cosθ/r² at range r = |X| of every pixel's point X.

    depth_m: (F, H, W) metres along z. intrinsics: (3, 3). reflectance: like depth_m, 1 where None. cosine: like
    depth_m, from depth where None; a surface that faces away (cosine below 0) returns nothing. time_s: (F,).
    laser_cycles: (F,) or one for all. first_frame: which of a recording's frames is the first of these. motion: of the
    camera. Raises `Refusal` naming frame and pixel where a value cannot be.
    """
    depth = np.require(depth_m, np.float32, ("C", "W"))
    if depth.ndim != 3:
        raise Refusal(f"depth_m has shape {depth.shape}, expected (F, H, W)")
    albedo = _like(depth, "reflectance", np.ones((), np.float32) if reflectance is None else reflectance)
    given = incidence_cosine(depth, intrinsics) if cosine is None else _like(depth, "incidence_cosine", cosine)
    inverse = inverse_pinhole(intrinsics)
    ranges, strength = zeros((2, *depth.shape), np.float32)
    missing = np.zeros(len(depth), np.int64)

    def one(i: int) -> None:
        wrong, missing[i] = _direct(depth[i], inverse, albedo[i], given[i], ranges[i], strength[i])
        if wrong:
            raise _complaint(first_frame + i, depth[i], albedo[i], given[i])

    in_parallel(one, range(len(depth)))
    times = np.arange(len(depth), dtype=float) if time_s is None else np.asarray(time_s, float)
    cycles = None if laser_cycles is None else np.broadcast_to(np.asarray(laser_cycles, float), len(depth))
    returns = (Return(ranges, strength),)
    return Light(times, cycles, np.asarray(intrinsics, float), ranges, albedo, given, returns, missing, motion)


def _like(depth: np.ndarray, name: str, values: np.ndarray) -> np.ndarray:
    """Values for every frame and pixel, float32, in memory of their own shape: the kernels are compiled for that."""
    values = np.asarray(values, np.float32)
    try:
        # A broadcast array may not be written to and would be copied even where it is of the shape already.
        full = values if values.shape == depth.shape else np.broadcast_to(values, depth.shape)
    except ValueError:
        raise Refusal(f"{name} has shape {values.shape}, expected {depth.shape} as depth_m") from None
    return np.require(full, requirements=("C", "W"))


def _complaint(frame: int, depth: np.ndarray, albedo: np.ndarray, cosine: np.ndarray) -> Refusal:
    """What is wrong with the first pixel of a frame that has a value which cannot be."""
    checks = (
        ("depth_m", depth, (depth < 0) | np.isinf(depth), "finite metres of 0 or more, NaN where unknown"),
        ("reflectance", albedo, (albedo < 0) | (albedo > ABOVE_1), "0 to 1, NaN where unknown"),
        ("incidence_cosine", cosine, np.abs(cosine) > ABOVE_1, "-1 to 1, NaN where unknown"),
    )
    v, u = np.argwhere(np.any([wrong for _, _, wrong, _ in checks], axis=0))[0]
    name, values, _, expected = next(check for check in checks if check[2][v, u])
    return Refusal(f"{name}[{frame}, {v}, {u}] is {values[v, u]}, expected {expected}")


@njit(nogil=True, cache=True, error_model="numpy")
def _direct(depth, inverse, albedo, cosine, ranges, strength):
    """Fill range and strength of one frame; how many pixels cannot be, how many contribute nothing.

    Without branches, so that several pixels are worked on at once; what is wrong is looked up when something is.
    """
    wrong = missing = 0
    for v in range(depth.shape[0]):
        y = inverse[1, 1] * v + inverse[1, 2]
        across, beside = inverse[0, 1] * v + inverse[0, 2], y * y + 1
        for u in range(depth.shape[1]):
            z, rho, cos = float(depth[v, u]), float(albedo[v, u]), float(cosine[v, u])
            x = inverse[0, 0] * u + across
            r = z * np.sqrt(x * x + beside)
            known = (r > 0) & (rho == rho) & (cos == cos)
            wrong += (z < 0) | (z == np.inf) | (rho < 0) | (rho > ABOVE_1) | (abs(cos) > ABOVE_1)
            missing += not known
            ranges[v, u] = r
            strength[v, u] = rho * (cos if cos > 0 else 0.0) / (r * r) if known else 0.0
    return wrong, missing

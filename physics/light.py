"""What the scene sends back: for every camera pixel, how far away a surface is and how much light returns from it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from physics.geometry import incidence_cosine, inverse_pinhole, pixel_rays
from physics.workers import in_parallel
from recordings.refusal import Refusal

GOOD, BAD_DEPTH, BAD_REFLECTANCE, BAD_COSINE = range(4)
COMPLAINTS = {
    BAD_DEPTH: ("depth_m", "finite metres of 0 or more, NaN where unknown"),
    BAD_REFLECTANCE: ("reflectance", "0 to 1, NaN where unknown"),
    BAD_COSINE: ("incidence_cosine", "-1 to 1, NaN where unknown"),
}


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
    """

    time_s: np.ndarray
    laser_cycles: np.ndarray | None
    intrinsics: np.ndarray
    range_m: np.ndarray
    reflectance: np.ndarray
    cosine: np.ndarray
    returns: tuple[Return, ...]
    missing: np.ndarray

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return len(self.range_m)

    @cached_property
    def rays(self) -> np.ndarray:
        """(H, W, 3) ray through each pixel's centre, of length 1 along z."""
        return pixel_rays(self.intrinsics, self.range_m.shape[1:])


def direct_light(
    depth_m: np.ndarray,
    intrinsics: np.ndarray,
    reflectance: np.ndarray | None = None,
    cosine: np.ndarray | None = None,
    *,
    time_s: np.ndarray | None = None,
    laser_cycles: np.ndarray | None = None,
    first_frame: int = 0,
) -> Light:
    """The nominal model's light: strength ρ·cosθ/r² at range r = |X| of every pixel's point X.

    depth_m: (F, H, W) metres along z. intrinsics: (3, 3). reflectance: like depth_m, 1 where None. cosine: like
    depth_m, from depth where None; a surface that faces away (cosine below 0) returns nothing. time_s: (F,).
    laser_cycles: (F,) or one for all. first_frame: which of a recording's frames is the first of these. Raises
    `Refusal` naming frame and pixel where a value cannot be.
    """
    depth = np.require(depth_m, np.float32, ("C", "W"))
    if depth.ndim != 3:
        raise Refusal(f"depth_m has shape {depth.shape}, expected (F, H, W)")
    albedo = _like(depth, "reflectance", np.ones((), np.float32) if reflectance is None else reflectance)
    given = incidence_cosine(depth, intrinsics) if cosine is None else _like(depth, "incidence_cosine", cosine)
    inverse = inverse_pinhole(intrinsics)
    ranges, strength = np.empty_like(depth), np.empty_like(depth)
    missing = np.zeros(len(depth), np.int64)

    def one(i: int) -> None:
        fault, v, u, missing[i] = _direct(depth[i], inverse, albedo[i], given[i], ranges[i], strength[i])
        if fault != GOOD:
            name, expected = COMPLAINTS[fault]
            value = {BAD_DEPTH: depth, BAD_REFLECTANCE: albedo, BAD_COSINE: given}[fault][i, v, u]
            raise Refusal(f"{name}[{first_frame + i}, {v}, {u}] is {value}, expected {expected}")

    in_parallel(one, range(len(depth)))
    times = np.arange(len(depth), dtype=float) if time_s is None else np.asarray(time_s, float)
    cycles = None if laser_cycles is None else np.broadcast_to(np.asarray(laser_cycles, float), len(depth))
    return Light(
        times, cycles, np.asarray(intrinsics, float), ranges, albedo, given, (Return(ranges, strength),), missing
    )


def _like(depth: np.ndarray, name: str, values: np.ndarray) -> np.ndarray:
    """Values for every frame and pixel, float32, in memory of their own shape: the kernels are compiled for that."""
    values = np.asarray(values, np.float32)
    try:
        return np.require(np.broadcast_to(values, depth.shape), requirements=("C", "W"))
    except ValueError:
        raise Refusal(f"{name} has shape {values.shape}, expected {depth.shape} as depth_m") from None


@njit(nogil=True, cache=True)
def _direct(depth, inverse, albedo, cosine, ranges, strength):
    """Fill range and strength of one frame; (fault, row, column of it, pixels that contribute nothing)."""
    missing = 0
    for v in range(depth.shape[0]):
        y = inverse[1, 1] * v + inverse[1, 2]
        for u in range(depth.shape[1]):
            z, rho, cos = depth[v, u], albedo[v, u], cosine[v, u]
            if z < 0 or z == np.inf:
                return BAD_DEPTH, v, u, missing
            if rho < 0 or rho > 1 + 1e-6:
                return BAD_REFLECTANCE, v, u, missing
            if cos < -1 - 1e-6 or cos > 1 + 1e-6:
                return BAD_COSINE, v, u, missing
            x = inverse[0, 0] * u + inverse[0, 1] * v + inverse[0, 2]
            r = z * np.sqrt(x * x + y * y + 1)
            ranges[v, u] = r
            if r > 0 and rho == rho and cos == cos:
                strength[v, u] = rho * max(cos, np.float32(0)) / (r * r)
            else:
                strength[v, u] = 0
                missing += 1
    return GOOD, 0, 0, missing

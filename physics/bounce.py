"""Light that bounces twice between surfaces that a frame shows.

In the nominal model a pixel's strength, ρ·cosθ/r², is the light its surface sends out by area (its radiosity) over the
radiant intensity I of the source. Whatever else lights the surface adds to it: the rendering equation of Kajiya 1986,
expanded to the second bounce. A pixel of solid angle ΔΩ catches I·ΔΩ, however its surface is tilted, and a matt one
sends on ρ of it. Of that, surface j at distance d from surface i, under angles φ_i and φ_j to the normals, gets by area

    E_j / I = ρ_i · ΔΩ_i · cosφ_i · cosφ_j / (π d² + A_i)

so that j's strength by way of i is ρ_j · E_j / I, and it arrives (r_i + d + r_j) / c after time zero (as in Velten et
al. 2012), in the zones that see j. A_i keeps surfaces that touch from exchanging more than there is: the form factor of
a disc (Wallace, Elmquist and Haines 1989).

Rough surfaces have facets that face every way; between these cosφ_i · cosφ_j is taken to be ¼, a half for each, the
mean over the hemisphere that a facet may face.

The sums run over patches instead of pixels: the image in at most `CELLS` cells, each cell in two at its mean range, so
that the two sides of an edge do not mix. What effects make of reflectance, and how they move or blur footprints, is of
second order here and left out. The source lights all of the image alike and nothing beyond it, or as the zones look:
most where all of them together see most. What stands between two patches is not looked for: all that face each other
exchange light. What a patch exchanges with itself, as it may where it is rough, is left out: it comes with the direct
light.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import delayed
from physics.clock import Clock
from physics.exchange import exchange
from physics.footprint import Footprints
from physics.kept import kept_by_frame, kept_with_scene
from physics.light import Light
from physics.normals import solid_angles, vector_areas
from physics.pulse import ImpulseResponse
from physics.workers import in_parallel

CELLS = 400
# Bounces are added up for so many bins at a time: a longer pulse seldom needs more.
WHOLE = 32
OUTSIDE = -1


@dataclass(frozen=True, eq=False)
class Patches:
    """N pieces of a frame's surfaces, in the camera's frame.

    label: (H, W) which patch a pixel is of, `OUTSIDE` where of none. point_m, normal: (N, 3). area_m2: (N,).
    sent_sr: (N,) ρ·ΔΩ summed over pixels, what the patch sends on of a source of intensity 1.
    """

    label: np.ndarray
    point_m: np.ndarray
    normal: np.ndarray
    area_m2: np.ndarray
    sent_sr: np.ndarray


def bounces(light: Light, footprints: Footprints, clock: Clock, aimed: float, rough: float) -> np.ndarray:
    """(F, P, J) light by knot of the clock's lattice, pixels · 1/m², that bounced between two visible surfaces.

    aimed: part of the source that lights where the zones look, by their summed response over its largest. rough: part
    of the surfaces' light that goes whichever way they face.
    """
    lattice = clock.lattice
    # Bounces are added up for zeros at 0 and a pulse of one step, so that other zeros and pulses find them made.
    bins = WHOLE * (lattice.size // (lattice.per_bin * WHOLE) + 1)
    at_once = ImpulseResponse(lattice.step_s * np.arange(2), np.array([1.0, 0.0]))
    bare = Clock(lattice.step_s * lattice.per_bin, bins, np.zeros(1), at_once)
    total = np.zeros(())
    for is_aimed, is_rough in product((False, True), repeat=2):
        part = (aimed if is_aimed else 1 - aimed) * (rough if is_rough else 1 - rough)
        if part:
            total = total + part * second_bounce(light, footprints.before_moving, bare, is_aimed, is_rough)
    later = (
        np.broadcast_to(clock.time_zero_s, total.shape[:2]) + bare.lattice.first_s - lattice.first_s
    ) / lattice.step_s
    # As far as zeros are parts of a step apart a pulse is wider by at most half a step.
    return delayed(total, later)[..., : lattice.size]


# A fit asks for the same geometry again and again, with other strengths.
@kept_with_scene
def second_bounce(light: Light, footprints: Footprints, clock: Clock, aimed: bool, rough: bool) -> np.ndarray:
    """(F, P, J) the same by a clock with one zero for all zones; either all of it or nothing aimed and rough.

    Not to be written to: whoever asks for the same again may get the same array.
    """
    out = np.empty((light.frames, footprints.seen[0][1].shape[1], clock.lattice.size))

    def one(i: int) -> None:
        out[i] = _of_frame(light, i, footprints, clock, aimed, rough)

    in_parallel(one, range(light.frames))
    return out


@kept_by_frame
def _of_frame(light: Light, i: int, footprints: Footprints, clock: Clock, aimed: bool, rough: bool) -> np.ndarray:
    """(P, J) the same of one frame."""
    lattice, seen = clock.lattice, footprints.seen
    offset = (float(clock.time_zero_s[0]) - lattice.first_s) / lattice.step_s
    pixels, weights = seen[i % len(seen)]
    made = patches(light, i, _aim(light, pixels, weights) if aimed else None)
    label = made.label.ravel()[pixels]
    inside = label != OUTSIDE
    received = weights[inside] * light.assumed_reflectance[i].ravel()[pixels[inside], None]
    response = np.stack([np.bincount(label[inside], zone, len(made.area_m2)) for zone in received.T], axis=1)
    out = np.zeros((response.shape[1], lattice.size))
    geometry = made.point_m, made.normal, made.area_m2, made.sent_sr
    exchange(*geometry, response, rough, 1 / speed_of_light / lattice.step_s, offset, out)
    return out


def _aim(light: Light, pixels: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(H, W) how much of the source's light goes there: 1 where zones, by weights (N, P) at pixels, see most."""
    aim = np.zeros(light.range_m[0].size)
    aim[pixels] = weights.sum(axis=1)
    return (aim / max(float(aim.max()), 1e-300)).reshape(light.range_m.shape[1:])


def patches(light: Light, frame: int, aim: np.ndarray | None = None) -> Patches:
    """The patches of one frame: of pixels that return light directly and whose slope is known.

    aim: (H, W) how much of the source's light goes to each pixel; alike to all where None.
    """
    height, width = light.range_m.shape[1:]
    scale = min(1.0, np.sqrt(CELLS / (height * width)))
    rows, columns = max(1, int(height * scale)), max(1, int(width * scale))
    cell = np.arange(height)[:, None] * rows // height * columns + np.arange(width) * columns // width
    vector, solid = vector_areas(light, frame), solid_angles(light)
    lit = np.isfinite(vector[..., 0]) & (light.returns[0].strength[frame] > 0)
    cell, vector, solid = cell[lit], vector[lit], solid[lit]
    ranges, reflectance, rays = (
        light.range_m[frame][lit].astype(float),
        light.assumed_reflectance[frame][lit],
        light.rays[lit],
    )

    def mean(values: np.ndarray, group: np.ndarray, count: int) -> np.ndarray:
        return np.bincount(group, values * solid, count) / np.maximum(np.bincount(group, solid, count), 1e-300)

    middle = mean(ranges, cell, rows * columns)
    # Groups that hold a pixel, numbered in order.
    held, group = np.unique(2 * cell + (ranges > middle[cell]), return_inverse=True)
    count = len(held)
    points = (ranges / np.linalg.norm(rays, axis=-1))[:, None] * rays
    area = np.stack([np.bincount(group, axis, count) for axis in vector.T], axis=1)
    size = np.linalg.norm(area, axis=-1)
    label = np.full((height, width), OUTSIDE)
    label[lit] = group
    return Patches(
        label,
        np.stack([mean(axis, group, count) for axis in points.T], axis=1),
        area / np.maximum(size, 1e-300)[:, None],
        size,
        np.bincount(group, reflectance * solid if aim is None else reflectance * solid * aim[lit], count),
    )

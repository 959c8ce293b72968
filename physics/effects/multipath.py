"""`multipath`: light takes a second bounce."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.constants import speed_of_light
from scipy.signal import fftconvolve

from physics.arrivals import Arrivals, arrivals
from physics.bounce import second_bounce
from physics.clock import Clock
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.light import Light, Return
from physics.normals import solid_angles, vector_areas
from physics.rendering import Rendering
from physics.workers import in_parallel

# Surfaces nearer to the outside plane than this part of its distance get less light of it in proportion, none behind.
EDGE = 0.1


class Multipath(Effect):
    """Three ways of a second bounce, each alone or with the others; surfaces are matt, of the assumed reflectance.

    Between two visible surfaces: `physics.bounce`.

    Between target and sensor: light of strength S_i from pixels of solid angle ΔΩ_i, under α_i to the optical axis,
    falls on the sensor's face, which sends `sensor` (its reflectance times its area) of it back, matt as well:

        S'_j = S_j · cosα_j · sensor/π² · Σ_i S_i · ΔΩ_i · cosα_i,   at 2 (r_i + r_j) / c

    one cosine and 1/π for the light the face catches, one for what it sends. It falls as the square of the signal.

    By way of a surface outside the view: a plane parallel to the optical axis lights the target as an image of the
    sensor would that stands behind it. It is as far from the target as the target's own image X' is from the sensor.
    With θ' the incidence of its light on the target,

        S' = outside · ρ · cosθ' / |X'|²,   at (r + |X'|) / c

    in the zones that see the target. Light that goes the same way the other way round comes in from outside the view,
    where no zone looks. A matt plane would spread the replica in time; here it stands for a mean of that.
    """

    id = "multipath"
    acts_on = "scene"
    sentence = "Light takes a second bounce, so that a weak pulse comes late by a delay that moves with the geometry."
    forms = (("between",), ("sensor",), ("outside", "outside_distance", "outside_azimuth"))
    look_alikes = (
        LookAlike("second_surface", "Step the target in range: a bounce's delay changes, a second surface's stays."),
        LookAlike("impulse_tail", "Show one flat wall from afar: a tail stays, the bounce goes."),
        LookAlike("afterpulsing", "Step the target in range: a bounce's delay changes, an afterpulse's stays."),
        LookAlike("range_aliasing", "Turn on the laser's jitter: an aliased pulse is smeared, a second bounce is not."),
        LookAlike("stray_light", "Show one zone alone a bright target: a second bounce is late, stray light is not."),
        LookAlike("interference", "Cover the emitter: a second bounce goes, interference stays."),
    )
    parameters = (
        Parameter(
            "between",
            unit="1",
            low=0.0,
            high=10.0,
            start=1.0,
            vanishes_at=0.0,
            sentence="Light between two visible surfaces, over what matt ones of the assumed reflectance exchange.",
        ),
        Parameter(
            "sensor",
            unit="m²",
            low=0.0,
            high=0.1,
            start=3e-4,
            vanishes_at=0.0,
            sentence="Reflectance times area of the sensor's face; 10 cm² that reflect 30 %.",
        ),
        Parameter(
            "outside",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.1,
            vanishes_at=0.0,
            sentence="What the plane outside the view sends on, over what a mirror in even light would.",
        ),
        Parameter(
            "outside_distance",
            unit="m",
            low=0.01,
            high=10.0,
            start=0.5,
            tries=(0.3, 1.0),
            sentence="Distance of the plane from the optical axis.",
        ),
        Parameter(
            "outside_azimuth",
            unit="deg",
            low=-360.0,
            high=360.0,
            start=90.0,
            tries=(0.0, 90.0, 180.0, -90.0),
            sentence="Direction of the plane in the image: 0 to the right, 90 down.",
        ),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """One more return of every pixel, by way of the plane outside the view."""
        light = rendering.light
        if values["outside"] == 0:
            return light
        half_path, strength = _by_way_of_plane(
            light, float(values["outside_azimuth"]), float(values["outside_distance"])
        )
        bounced = Return(half_path, (values["outside"] * strength).astype(strength.dtype))
        return replace(light, returns=(*light.returns, bounced))

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """What bounces between visible surfaces, and what the sensor's face sends back."""
        total = rendering.arrivals.light
        if values["between"]:
            bounced = second_bounce(rendering.light, rendering.footprints, rendering.clock)
            total = total + values["between"] * bounced
        if values["sensor"]:
            back = _from_face(rendering.light, rendering.footprints, rendering.clock)
            total = total + values["sensor"] / np.pi**2 * back
        return replace(rendering.arrivals, light=total)


# Fits try strengths and change the plane in turn.
@lru_cache(maxsize=2)
def _by_way_of_plane(light: Light, azimuth_deg: float, distance_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Half the path (F, H, W) by way of a plane outside the view, and its strength for a perfect one; to read only."""
    azimuth = np.radians(azimuth_deg)
    axis = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    image = 2 * distance_m * axis  # of the sensor
    half_path, strength = np.zeros_like(light.range_m), np.zeros_like(light.range_m)

    def one(i: int) -> None:
        area, ranges = vector_areas(light, i), light.range_m[i].astype(float)
        point = light.rays * (ranges / np.linalg.norm(light.rays, axis=-1))[..., None]
        to_image = image - point
        far, size = np.linalg.norm(to_image, axis=-1), np.linalg.norm(area, axis=-1)
        before = 1 - point @ axis / distance_m
        lit = (light.returns[0].strength[i] > 0) & (size > 0) & (before > 0)
        cosine = np.maximum((area * to_image).sum(axis=-1)[lit], 0) / (size * far)[lit]
        edge = np.minimum(before[lit] / EDGE, 1)
        strength[i][lit] = light.reflectance[i][lit] * cosine / far[lit] ** 2 * edge
        half_path[i][lit] = (ranges + far)[lit] / 2

    in_parallel(one, range(light.frames))
    return half_path, strength


@lru_cache(maxsize=1)
def _from_face(light: Light, footprints: Footprints, clock: Clock) -> np.ndarray:
    """(F, P, J) light that falls on the sensor's face and back on the target, for a face of π² m²; to read only."""
    lattice = clock.lattice
    direct = light.returns[0]
    forward = (1 / np.linalg.norm(light.rays, axis=-1)).astype(np.float32)
    seen = replace(light, returns=(Return(direct.range_m, direct.strength * forward),))
    target = arrivals(seen, footprints, clock).light
    onto_face = solid_angles(light) * forward
    again = np.empty_like(target)

    def one(i: int) -> None:
        lit = direct.strength[i] > 0
        at = direct.range_m[i][lit] * (2 / speed_of_light / lattice.step_s)
        fallen = (direct.strength[i] * onto_face)[lit]
        inside = at < lattice.size - 1
        knot, fallen = at[inside].astype(int), fallen[inside]
        later = fallen * (at[inside] - knot)
        delays = np.bincount(knot, fallen - later, lattice.size) + np.bincount(knot + 1, later, lattice.size)
        # Rounding of the transform must not make light negative.
        again[i] = np.maximum(fftconvolve(target[i], delays[None], axes=1)[:, : lattice.size], 0)

    in_parallel(one, range(light.frames))
    return again


effect = Multipath()

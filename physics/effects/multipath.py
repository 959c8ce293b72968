"""`multipath`: light takes a second bounce."""

from dataclasses import replace
from itertools import product

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals
from physics.bounce import bounces
from physics.cavity import gone_round
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.hidden_bounces import hidden
from physics.light import Light, Return
from physics.outside_patch import likely_patches, patch_returns
from physics.outside_plane import by_way_of_plane
from physics.owning import Unseen
from physics.rendering import Rendering
from physics.sensor_face import from_face
from physics.walls_around import by_walls_around, likely_distances

# Directions of a plane outside the view that fits begin with; parts of its distance, told roughly, where it goes along.
SIDES_DEG, NEARER = (0.0, 90.0, 180.0, -90.0), (1.0, 0.7)
# By such a part of its time of flight light is late that has gone once across a cavity as wide as the target is far.
LATE = 0.75
# Of light that goes round and round as much is left after each way: its times are exponential, a breadth of 1. Beyond
# this they have a tail of another kind.
BROAD = 1.3


class Multipath(Effect):
    """Eight ways of a second bounce, each alone or with the others; surfaces are matt, of the assumed reflectance.

    Between two visible surfaces, matt or rough: `physics.bounce`.

    Between target and sensor: light of strength S_i from pixels of solid angle ΔΩ_i, under α_i to the optical axis,
    falls on the sensor's face, which sends `sensor` (its reflectance times its area) of it back, matt as well:

        S'_j = S_j · cosα_j · sensor/π² · Σ_i S_i · ΔΩ_i · cosα_i,   at 2 (r_i + r_j) / c

    one cosine and 1/π for the light the face catches, one for what it sends. It falls as the square of the signal.

    Between target and sensor the same way again: what falls on the lens is sent back by what lies in its focus to where
    it came from, as by a cat's eye, and returns once more:

        S'_i = retro · S_i²,   at 4 r_i / c

    A target that sends light straight back, and a face that mirrors it, lose as much at any range, or more at larger
    ones, as light spreads: S'_i = mirrored · S_i · (1 m / r_i)^spreading, at 4 r_i / c. What sends it back may lie so
    much behind (or before) what ranges are measured from: then it comes at (4 r_i + 2 face) / c.

    By way of a surface outside the view: a plane lights the target as an image of the sensor would that stands behind
    it. It is as far from the target as the target's own image X' is from the sensor. With θ' the incidence of its light
    on the target,

        S' = outside · ρ · cosθ' / |X'|²,   at (r + |X'|) / c

    in the zones that see the target. Light that goes the same way the other way round comes in from outside the view,
    where no zone looks. A matt plane would spread that in time; this is its mean. It stands still, and is nearer or
    farther in every frame where it is known how the camera moved; or it is a part of the robot and goes along. Where
    light comes back that way as well as it goes, it goes with the direct light: S' = outside · S.

    By way of one patch outside the view, a part of the robot or of a wall, small or wide: `physics.outside_patch`.

    By way of walls on all sides, as of a corridor: the mean of such planes, |X'| = √(r² + 4 distance²) and θ' = θ.

    Round and round in a cavity about the target, the larger the farther it is: a part of the direct light, broad, and
    late by a part of its own time of flight: `physics.cavity`.
    """

    id = "multipath"
    acts_on = "scene"
    sentence = "Light takes a second bounce, so that a weak pulse comes late by a delay that moves with the geometry."
    forms = (
        ("between",),
        ("between", "aimed"),
        ("between", "aimed", "rough"),
        ("sensor",),
        ("retro",),
        ("mirrored",),
        ("mirrored", "spreading"),
        ("retro", "face"),
        ("mirrored", "spreading", "face"),
        ("around", "around_distance"),
        ("outside", "outside_distance", "outside_azimuth", "outside_tilt"),
        ("patch", "patch_x", "patch_y", "patch_z", "patch_wide"),
        ("cavity", "cavity_late", "cavity_breadth"),
    )
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
            "between", "1", 0.0, 1e3, 1.0, "Light between two visible surfaces, over what matt ones exchange.", 0.0
        ),
        Parameter(
            "aimed", "1", 0.0, 1.0, 0.0, "Part of the light that goes where zones look, not all over.", tries=(1.0,)
        ),
        Parameter("rough", "1", 0.0, 1.0, 0.0, "Part of it that goes whichever way surfaces face.", tries=(1.0,)),
        # It begins at 10 cm² that reflect 30 %, and ends at a white wall that the sensor is mounted on.
        Parameter("sensor", "m²", 0.0, 10.0, 3e-4, "Reflectance times area of the sensor's face.", 0.0),
        Parameter("retro", "m²", 0.0, 10.0, 1e-2, "What the lens sends back, over what falls on a square metre.", 0.0),
        Parameter("mirrored", "1", 0.0, 1.0, 0.01, "Part that returns once more of what comes from 1 m.", 0.0),
        Parameter("spreading", "1", -1.0, 6.0, 0.0, "Power of range with which that part falls.", tries=(2.0,)),
        Parameter("face", "m", -0.3, 0.3, 0.0, "How far behind the sensor what sends it back lies.", tries=(0.02,)),
        Parameter("around", "1", 0.0, 10.0, 0.1, "What walls on all sides send on, over what mirrors would.", 0.0),
        Parameter("around_distance", "m", 0.01, 10.0, 0.5, "Distance of these walls, wherever the sensor goes."),
        Parameter("outside", "1", 0.0, 10.0, 0.1, "What the plane outside the view sends on, over a mirror's.", 0.0),
        # Of the plane at the beginning of the session.
        Parameter("outside_distance", "m", 0.01, 10.0, 0.5, "Distance of the plane from the sensor."),
        Parameter("outside_azimuth", "deg", -360.0, 360.0, 90.0, "Where it is in the image: 0 to the right, 90 down."),
        Parameter("outside_tilt", "deg", -80.0, 80.0, 0.0, "How it leans: 0 along the optical axis, above 0 ahead."),
        Parameter("outside_stands", "1", 0.0, 1.0, 1.0, "1 where it stays where it was, 0 where it goes along."),
        Parameter("outside_dimmed", "1", 0.0, 1.0, 0.0, "1 where it goes with what surfaces send back directly."),
        Parameter("patch", "1", 0.0, 10.0, 0.01, "What the patch sends on.", vanishes_at=0.0),
        Parameter("patch_x", "m", -5.0, 5.0, 0.3, "How far to the right of the sensor it is."),
        Parameter("patch_y", "m", -5.0, 5.0, 0.0, "How far below it."),
        Parameter("patch_z", "m", -5.0, 5.0, 0.1, "How far ahead of it."),
        Parameter("patch_wide", "m", 0.0, 2.0, 0.0, "How far its parts are about it, one sigma.", tries=(0.05,)),
        Parameter("patch_stands", "1", 0.0, 1.0, 0.0, "1 where it stays where it was, 0 where it goes along."),
        Parameter("patch_dimmed", "1", 0.0, 1.0, 0.0, "1 where it goes with what surfaces send back directly."),
        Parameter("cavity", "1", 0.0, 10.0, 0.05, "What goes round in a cavity, over what comes directly.", 0.0),
        Parameter("cavity_late", "1", 0.02, 2.0, 0.4, "How late it is, over its time of flight.", tries=(0.2, 0.5)),
        Parameter("cavity_breadth", "1", 0.1, 2.0, 0.6, "How broad it is, one sigma, over how late."),
    )

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Whether light goes round for nearly as long as it flew, or some much longer: it is rather held by traps."""
        return bool(values["cavity"] and (values["cavity_late"] > LATE or values["cavity_breadth"] > BROAD))

    def owns_up(self, values: Values) -> bool:
        """Whether light goes between surfaces, of which the image shows one side."""
        return bool(values["between"])

    def unseen(self, values: Values, rendering: Rendering) -> Unseen:
        """What goes by way of what is hidden."""
        return hidden(rendering, values["between"], values["aimed"], values["rough"])

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Walls and planes on all sides by way of which light is about as late as what is in excess."""
        found = []
        # What goes along may send on its own light, as a floor under the camera does, where it is known how that moves.
        along = [(0.0, dimmed) for dimmed in ((1.0,) if rendering.light.motion is None else (1.0, 0.0))]
        for away in likely_distances(excess, expected, rendering):
            ways = [(1.0, 0.0, away)]
            ways += [(*how, part * away) for how, part in product(along, NEARER) if not found]
            for side, (stands, dimmed, distance) in product(SIDES_DEG, ways):
                plane = {"outside_distance": distance, "outside_azimuth": side}
                found.append(plane | {"outside_stands": stands, "outside_dimmed": dimmed})
            found.append({"around_distance": away})
        return found + likely_patches(excess, expected, rendering)

    def light(self, values: Values, rendering: Rendering) -> Light:
        """More returns of every pixel: by way of the lens, of walls all around, and of the plane outside the view."""
        light, more = rendering.light, []
        direct = light.returns[0]
        if values["retro"]:
            again = values["retro"] * direct.strength.astype(float) ** 2
            more.append(Return(2 * direct.range_m + np.float32(values["face"]), again.astype(np.float32)))
        if values["mirrored"]:
            spread = np.where(direct.range_m > 0, direct.range_m, 1).astype(float) ** -values["spreading"]
            again = values["mirrored"] * direct.strength * spread
            more.append(Return(2 * direct.range_m + np.float32(values["face"]), again.astype(np.float32)))
        if values["around"]:
            by_wall = by_walls_around(direct, values["around_distance"])
            more.append(replace(by_wall, strength=(values["around"] * by_wall.strength).astype(np.float32)))
        if values["outside"]:
            plane = (float(values[f"outside_{name}"]) for name in ("distance", "azimuth", "tilt"))
            how = (values[f"outside_{name}"] > 0.5 for name in ("stands", "dimmed"))
            half_path, strength = by_way_of_plane(light, *plane, *how)
            more.append(Return(half_path, (values["outside"] * strength).astype(strength.dtype)))
        if values["patch"]:
            place = (float(values[f"patch_{name}"]) for name in ("x", "y", "z", "wide"))
            how = (values[f"patch_{name}"] > 0.5 for name in ("stands", "dimmed"))
            bin_m = rendering.clock.bin_width_s * speed_of_light / 2
            more += patch_returns(light, *place, *how, values["patch"], bin_m)
        return replace(light, returns=(*light.returns, *more)) if more else light

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """What bounces between visible surfaces, and what the sensor's face sends back."""
        total = rendering.arrivals.light
        if values["between"]:
            scene = rendering.light, rendering.footprints, rendering.clock
            total = total + values["between"] * bounces(*scene, values["aimed"], values["rough"])
        if values["sensor"]:
            back = from_face(rendering.light, rendering.footprints, rendering.clock)
            total = total + values["sensor"] / np.pi**2 * back
        if values["cavity"]:
            late = float(values["cavity_late"]), float(values["cavity_breadth"])
            total = total + values["cavity"] * gone_round(rendering.arrivals.light, rendering.clock, *late)
        return replace(rendering.arrivals, light=total)


effect = Multipath()

"""`reflectance_map`: surfaces reflect the near infrared otherwise than was assumed."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light
from physics.marks import likely_marks, place_parameters
from physics.reflectances import FEW, SURFACES, by_surface, gaps, log_factor
from physics.rendering import Rendering
from physics.space_waves import NAMES, WAVE, likely_waves
from physics.surfaces_amiss import surfaces_amiss
from physics.texture import COARSE, PRODUCTS, SPACE, VIEW, passing
from physics.told_apart import BOTH, REFLECTANCE, WHICH, surfaces_alone

# Surfaces that a fit tries alone, the largest and others that counts suggest; gaps in range that it tries as ends of
# what is near.
ALONE, SUGGESTED, GAPS = 8, 4, 4
# Logarithm of a factor beyond which no fit has any business; larger ones are no numbers soon.
LARGEST = 20.0
# Where ranges vary by more than this the sensor moves, or what it sees.
PASSING = 0.03


class ReflectanceMap(Effect):
    """Reflectance ρ becomes ρ · (ρ/½)^contrast · exp(step·s(ln(level/ρ)/0.1) + near·s(ln(near_range/r)/0.02)
    + spot·exp(-d²/2·size²) + mark·(in it) + wave + texture + patches + one at surface number `surface` + surface_k at
    number k).

    s(x) = 1/(1 + e^-x); d is the distance of a pixel's ray from the spot's, both as tangents x/z, y/z. The texture is
    a polynomial of these tangents, slope_x·x + slope_y·y + bow_x·x² + bow_y·y² + bow_xy·x·y + bend_xxx·x³ + ..., and
    another of metres to the right, down and ahead in the camera's frame when the session began, space_x·x + space_y·y +
    space_z·z + space_xx·x² + ...: what varies slowly over the view, as the finish of one large wall does that is seen
    from one place, or in space, as that of walls one moves along.
    Contrast stands for a guess from colour that is too flat or too steep, the step for dyes that are dark in colour and
    bright in the near infrared (or the reverse), the near step for an object before a wall, the spot for what the field
    of view itself carries, the mark for ink or tape on a surface, which stays there (`marks`), the wave for a finish
    that goes to and fro, as wallpaper and wood do (`space_waves`), patches for what differs from place to place with
    no order to it (`patchwork`). Nothing is cut at 1:
    reflectance is known up to the gain, and a surface that sends light back to where it came from outshines a white
    matt one. Surfaces are told apart and followed through the frames by their geometry (`segments`), or told by the
    reflectance assumed of them (`materials`), and numbered by their pixels in all frames, the largest first: an object
    of another material, or each of several.
    Where no reflectance is assumed it is 1 everywhere: then contrast is a gain, the step nothing unless `level` is near
    1, and the rest the same as ever.
    """

    id = "reflectance_map"
    acts_on = "scene"
    order = -3  # All that surfaces send back, by whatever way and shape of lobe, goes with their reflectance.
    sentence = "Surfaces reflect more or less near infrared than was assumed, whatever their range."
    look_alikes = (
        LookAlike("zone_gain", "Turn the sensor about its axis: reflectance stays with the surface, a gain does not."),
        LookAlike("non_lambertian", "Tilt one surface: only a lobe changes with the angle."),
        LookAlike("gain_drift", "Look at one surface again at the end: reflectance is what it was, a drift is not."),
        LookAlike("range_falloff", "Step one target in range: its reflectance is the same at all ranges."),
    )
    forms = (
        ("contrast",),
        ("step", "level"),
        ("near",),
        ("near", "near_range"),
        ("spot", "spot_x", "spot_y", "spot_size"),
        ("mark", "mark_x", "mark_y", "mark_z", "mark_size"),
        ("wave_sin", "wave_cos", *NAMES),
        tuple(COARSE),
        tuple(VIEW),
        tuple(SPACE)[:3],
        tuple(SPACE),
        ("one",),
        SURFACES[:FEW],
        SURFACES,
        ("patch",),
    )
    richer = forms[-1:]
    parameters = (
        Parameter(
            "contrast", "1", -1.0, 5.0, 0.3, "Exponent by which contrasts are stronger; -1 makes all alike.", 0.0
        ),
        Parameter("step", "1", -5.0, 5.0, 0.5, "Logarithm of the factor on surfaces darker than `level`.", 0.0),
        Parameter("level", "1", 0.01, 1.0, 0.4, "Assumed reflectance at which the step lies.", tries=(0.2, 0.5)),
        Parameter("near", "1", -5.0, 5.0, 0.5, "Logarithm of the factor on surfaces nearer than `near_range`.", 0.0),
        Parameter(
            "near_range", "m", 0.05, 10.0, 0.6, "Range that tells near surfaces from far ones.", tries=(0.45, 0.9)
        ),
        Parameter("spot", "1", -5.0, 5.0, 0.5, "Logarithm of the factor amid a spot fixed in the field of view.", 0.0),
        # Tries are the quarters of such a sensor's field of view.
        Parameter("spot_x", "1", -3.0, 3.0, 0.1, "Tangent x/z of the spot's middle.", tries=(-0.2, 0.2)),
        Parameter("spot_y", "1", -3.0, 3.0, 0.1, "Tangent y/z of the spot's middle.", tries=(-0.15, 0.15)),
        Parameter("spot_size", "1", 0.01, 3.0, 0.2, "Standard deviation of the spot, as a tangent.", tries=(0.15,)),
        Parameter("mark", "1", -5.0, 5.0, -0.3, "Logarithm of the factor on a mark that stays on its surface.", 0.0),
        *place_parameters("mark"),
        *WAVE,
        *(
            Parameter(name, unit, -most, most, most / 200, f"Log-factor per {product} of the texture.", vanishes_at=0.0)
            for name, product in PRODUCTS.items()
            # What is some tenths wide varies as much by a higher power where its factor is the larger.
            for most, unit in ((20.0 * 4 ** (len(product) - 1), f"1/m^{len(product)}" if name in SPACE else "1"),)
        ),
        # A factor of 4 beside what surfaces are on the whole.
        Parameter("patch", "1", -1.4, 1.4, 0.1, "Logarithm of the factor about each knot.", 0.0, axis="patch"),
        Parameter("one", "1", -5.0, 5.0, 0.3, "Logarithm of the factor on surface `surface`.", vanishes_at=0.0),
        *WHICH,
        *(
            Parameter(name, "1", -2.0, 2.0, 0.3, f"Logarithm of the factor on surface {k}.", vanishes_at=0.0)
            for k, name in enumerate(SURFACES, start=2)
        ),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Surfaces are followed, and numbered by their pixels, through all frames; so are patches."""
        return (np.inf, np.inf) if by_surface(values) or np.any(values["patch"]) else (0.0, 0.0)

    def mixes(self, values: Values) -> bool:
        """Which surface is which a part of the frames knows."""
        return False

    def light(self, values: Values, rendering: Rendering) -> Light:
        """Reflectance and the strength of what surfaces send back directly, times one factor by pixel."""
        light = rendering.light
        factor = np.exp(np.minimum(log_factor(values, light), LARGEST))
        direct, *others = light.returns
        lit = replace(direct, strength=(direct.strength * factor).astype(np.float32))
        reflectance = (light.reflectance * factor).astype(np.float32)
        return replace(light, reflectance=reflectance, returns=(lit, *others), assumed=light.assumed_reflectance)

    def contradiction(self, values: Values, rendering: Rendering) -> str | None:
        """Emitter, window and optics are in the view, whatever passes there; surfaces pass."""
        fixed = values["spot"] or any(values[name] for name in VIEW)
        if not fixed or passing(rendering.light.range_m) <= PASSING:
            return None
        return "it stays where it is in the view while surfaces pass there"

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Large surfaces alone, and small ones that are amiss; what is nearer than gaps in range; several materials."""
        smaller = surfaces_amiss(excess, expected, rendering, ALONE, SUGGESTED)
        which = [*surfaces_alone(rendering.light, ALONE), *smaller]
        alone = [{"one": self.parameter("one").start} | one for one in which]
        if any(one["told_by"] == REFLECTANCE for one in alone):
            first = {name: self.parameter(name).start for name in SURFACES[:FEW]}
            alone += [first | {"told_by": by} for by in (REFLECTANCE, BOTH)]
        ends = self.parameter("near_range").low, self.parameter("near_range").high
        near = self.parameter("near").start
        gap = [at for at in gaps(rendering.light, GAPS) if ends[0] < at < ends[1]]
        marks = [{"mark": self.parameter("mark").start} | at for at in likely_marks(excess, expected, rendering)]
        strengths = {name: self.parameter(name).start for name in ("wave_sin", "wave_cos")}
        waves = [strengths | at for at in likely_waves(excess, expected, rendering)]
        return [*alone, *({"near": near, "near_range": at} for at in gap), *marks, *waves]


effect = ReflectanceMap()

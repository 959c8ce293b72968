"""`non_lambertian`: surfaces send more light, or less, back along the ray it came by than matt ones would."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light
from physics.rendering import Rendering
from physics.surfaces_amiss import surfaces_amiss
from physics.told_apart import WHICH, numbers, surfaces_alone

# Surfaces that a fit tries alone, the largest, and smaller ones that are amiss.
ALONE, SUGGESTED = 4, 2
# Exponent of the widest lobe of one surface.
WIDEST = 2.0
# Parts of surfaces that have lobes of their own at once, the largest.
GLOSSES = tuple(f"gloss_{k}" for k in range(1, 9))
# Reflectance below which a varnish shows no more.
DARKEST = 0.02


class NonLambertian(Effect):
    """A surface of reflectance ρ at range r returns ρ/r² · (cosθ^(1 + power) + lobe · cosθ^exponent) where cosθ > 0.

    The lobe is that of Blinn (SIGGRAPH 1977, "Models of light reflection for computer synthesized pictures"),
    k_s · (N·H)^c with H halfway between the directions to source and eye. Here both are the sensor, so that H is the
    ray itself and N·H = cosθ. As in his sum of terms the lobe is not multiplied by the cosine of the light that falls
    in: `lobe` is how many times as bright as the matt part it is at normal incidence, and exponent 0 is a
    retroreflector as bright at every incidence. A lobe below 0 is light that a surface sends elsewhere from where a
    matt one would send it back; nothing sends back less than none. Another power of the cosine is a surface that is
    matt, but rough or porous: Minnaert's (1941, Astrophys. J. 93, 403) (cosθ_in · cosθ_out)^k / cosθ_out, both angles
    equal, is cosθ^(2k - 1), so that k is 1 + power/2; power -1, k = ½, is the moon, as bright at its rim as amid.
    A varnish reflects at its surface, whatever the pigment below: with `pigment` 0 all surfaces have the lobe of one of
    reflectance ½, with 1 it goes with theirs, in between lobe · (2ρ)^(pigment - 1). What is black sends nothing.
    A lobe may have another shape, (1 + tail·tan²θ)^(-exponent/(2·tail)): facets whose slopes have a Student's
    t-distribution (Ribardière et al. 2017, "STD", Computer Graphics Forum 36), which is the power of the cosine with
    tail 1 and, towards 0, the Gaussian of Beckmann and Spizzichino (1963).
    Energy is not kept: what goes elsewhere is never seen from here. One surface may have a lobe of its own beside that,
    gloss · cosθ^gloss_exponent, and less matt light for it: surfaces are told apart and followed through the frames by
    their geometry, the largest first (`segments`). As one surface may meet the light at much the same angle in all
    frames, a lobe of its own that hardly varies with the angle, or darkens, is no lobe but its reflectance.
    """

    id = "non_lambertian"
    acts_on = "scene"
    order = -2  # The lobe goes with reflectance, and is there before light takes further ways.
    sentence = "Surfaces that are glossy, retroreflective or rough change with incidence otherwise than matt ones."
    look_alikes = (
        LookAlike("reflectance_map", "Tilt one surface: a lobe changes with the angle, reflectance does not."),
        LookAlike("range_falloff", "Tilt one surface at a fixed range: only a lobe changes."),
        LookAlike("multipath", "Take away everything but the one surface: its lobe stays, a second bounce goes."),
    )
    forms = (
        ("lobe", "exponent"),
        ("lobe", "exponent", "pigment"),
        ("power",),
        ("gloss", "gloss_exponent"),
        ("lobe", "exponent", "pigment", "tail"),
        ("gloss", "gloss_exponent", "tail"),
        ("lobe", "exponent", "tail", *GLOSSES, "gloss_exponent"),
        ("gloss", "gloss_exponent", "tail", *GLOSSES),
        ("gloss", "gloss_exponent", "matt"),
    )
    richer = forms[-5:]
    parameters = (
        Parameter(
            "lobe",
            unit="1",
            low=-1.0,
            high=100.0,
            start=0.5,
            vanishes_at=0.0,
            sentence="Light of the lobe over matt light, at normal incidence; less than matt where negative.",
        ),
        Parameter(
            "exponent",
            unit="1",
            low=0.0,
            high=500.0,
            start=20.0,
            tries=(4.0, 60.0),
            sentence="How narrow the lobe is: half of it is left at 15 degrees for 20, at 7 degrees for 100.",
        ),
        Parameter(
            "pigment",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            tries=(0.0,),
            sentence="1 where the lobe goes with reflectance, 0 where it is as bright on dark surfaces as on bright.",
        ),
        Parameter(
            "power",
            unit="1",
            low=-1.0,
            high=5.0,
            start=0.3,
            vanishes_at=0.0,
            sentence="By how much the power of the cosine is above that of a matt surface, which is 1.",
        ),
        Parameter("gloss", "1", 0.0, 100.0, 0.5, "Light of the lobe of one surface over matt light.", vanishes_at=0.0),
        Parameter(
            "gloss_exponent",
            unit="1",
            low=WIDEST,
            high=500.0,
            start=20.0,
            tries=(4.0, 60.0),
            sentence="How narrow the lobe of that surface is, as `exponent`.",
        ),
        Parameter("matt", "1", 0.0, 1.0, 1.0, "Matt light of that surface over what was thought, as its lobe takes."),
        *WHICH,
        *(
            Parameter(name, "1", 0.0, 100.0, 0.5, f"The same of part {k}, on top.", vanishes_at=0.0)
            for k, name in enumerate(GLOSSES, start=1)
        ),
        Parameter(
            "tail",
            unit="1",
            low=0.01,
            high=30.0,
            start=1.0,
            sentence="1 for powers of the cosine, towards 0 for slopes by a Gaussian, above 1 with longer tails.",
        ),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Surfaces are followed, and numbered by their pixels, through all frames."""
        return (np.inf, np.inf) if _by_surface(values) else (0.0, 0.0)

    def mixes(self, values: Values) -> bool:
        """Which surface is which a part of the frames knows."""
        return False

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The lobe, added to what surfaces send back directly."""
        light = rendering.light
        if all(values[name] == 0 for name in ("lobe", "power", "gloss", *GLOSSES)):
            return light
        direct, *others = light.returns
        # What sends nothing back, is turned away or is unknown has no lobe either.
        lit = (direct.strength > 0) & (light.cosine > 0)
        cosine = np.where(lit, light.cosine, 1).astype(float)
        # Strength over the cosine is ρ/r²; by way of the logarithm, so that no power overflows where cosθ is tiny.
        log, tail = np.log(cosine), values["tail"]
        shape = log if tail == 1 else -np.log1p(tail * (cosine**-2 - 1)) / (2 * tail)
        lobe = values["lobe"] * np.exp(values["exponent"] * shape - log)
        if values["pigment"] != 1:
            lobe *= np.maximum(2 * light.reflectance, 2 * DARKEST) ** (values["pigment"] - 1)
        more = np.exp(values["power"] * log) + lobe
        if _by_surface(values):
            there = numbers(values, light) == round(values["surface"])
            glosses = values["gloss"] * there
            if values["gloss"]:
                more = np.where(there, values["matt"], 1) * more
            if any(values[name] != 0 for name in GLOSSES):
                each = np.array([0.0, *(values[name] for name in GLOSSES), 0.0])
                glosses = glosses + each[np.minimum(light.pieces, len(each) - 1)]
            more = more + glosses * np.exp(values["gloss_exponent"] * shape - log)
        strength = np.where(lit, direct.strength * np.maximum(more, 0), direct.strength).astype(np.float32)
        return replace(light, returns=(replace(direct, strength=strength), *others))

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A lobe of one surface or of varnish as wide as may be is rather reflectance; so is varnish that dims."""
        broad = values["gloss"] > 0 and values["gloss_exponent"] < WIDEST + 0.5
        varnished = values["lobe"] != 0 and values["pigment"] < 1
        return broad or (varnished and (values["lobe"] < 0 or values["exponent"] < WIDEST))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Each of the largest surfaces alone, and smaller ones that are amiss."""
        exponents = self.parameter("gloss_exponent").tries
        smaller = surfaces_amiss(excess, expected, rendering, ALONE, SUGGESTED)
        which = [*surfaces_alone(rendering.light, ALONE), *smaller]
        return [{"gloss_exponent": n} | one for one in which for n in exponents]


def _by_surface(values: Values) -> bool:
    """Whether surfaces are told apart at all."""
    return any(values[name] != 0 for name in ("gloss", *GLOSSES))


effect = NonLambertian()

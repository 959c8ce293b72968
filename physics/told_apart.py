"""Which surface an effect of one surface acts on: its number, and by what surfaces are told apart."""

import numpy as np

from physics.effect import Parameter, Values
from physics.light import Light

# What tells surfaces apart: their geometry, the reflectance that is assumed of them, or both.
GEOMETRY, REFLECTANCE, BOTH = 0.0, 1.0, 2.0
# A material that is, but for this part of its pixels, a surface told by geometry is looked at once.
ELSEWHERE = 0.05

WHICH = (
    Parameter("surface", "1", 1.0, 30.0, 1.0, "Number of that surface, from the largest on."),
    Parameter(
        "told_by", "1", GEOMETRY, BOTH, GEOMETRY, "What tells surfaces apart: 0 geometry, 1 reflectance, 2 both."
    ),
)


def numbers(values: Values, light: Light) -> np.ndarray:
    """(F, H, W) int32 number of the surface at each pixel, told apart as the values say; 0 where there is none."""
    return (light.surfaces, light.materials, light.pieces)[round(values["told_by"])]


def surfaces_alone(light: Light, most: int) -> list[dict[str, float]]:
    """The largest surfaces, and materials that are none of these: values that choose one each."""
    geometry, material = light.surfaces, light.materials
    found = [{"surface": float(k), "told_by": GEOMETRY} for k in range(1, 1 + min(most, int(geometry.max(initial=0))))]
    many = int(material.max(initial=0))
    for k in range(1, 1 + min(most, many)) if many > 1 else ():
        there = material == k
        if not there.any():  # It is seen in other frames alone.
            continue
        alike = np.bincount(geometry[there])
        other = int(np.argmax(alike))
        shared, either = alike[other], there.sum() + (geometry == other).sum() - alike[other]
        if other == 0 or other > most or shared < (1 - ELSEWHERE) * either:
            found.append({"surface": float(k), "told_by": REFLECTANCE})
    return found

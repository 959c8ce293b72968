"""The laser is polarised, and what analyses it sees surfaces that are met at an angle brighter one way than another."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.normals import facing
from physics.rendering import Rendering


class Polarised(Effect):
    """Light times 1 + sin²θ · (along · cos2φ + across · sin2φ), θ the incidence, φ the azimuth of its plane.

    Surfaces, and what covers the sensor, let through or send back more of the light that is polarised in the plane of
    incidence than of that across it, the more the more oblique that is: as the square of the angle at first (Fresnel;
    Born & Wolf 1999, §1.5.3). φ is counted from the camera's x axis towards its y axis, so that it turns with a camera
    that rolls. Where what analyses the light stands behind the lens, φ is the azimuth of the surface's normal
    (`telecentric`). No light is less than none.
    """

    id = "polarised"
    acts_on = "scene"
    sentence = "surfaces met at an angle send back more or less light by the azimuth of the plane they are met in"
    forms = (("along", "across"),)
    parameters = (
        Parameter("along", unit="1", low=-5.0, high=5.0, start=0.2, vanishes_at=0.0, sentence="Along the x axis."),
        Parameter("across", unit="1", low=-5.0, high=5.0, start=0.2, vanishes_at=0.0, sentence="Along its diagonal."),
        Parameter("telecentric", "1", 0.0, 1.0, 0.0, "1 where what analyses light stands behind the lens."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Begun with an analyser behind the lens as well."""
        return [{name: self.parameter(name).start for name in ("along", "across")} | {"telecentric": 1.0}]

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene as it is seen."""
        light = rendering.light
        areas = facing(light)
        ray = light.rays / np.linalg.norm(light.rays, axis=-1, keepdims=True)
        normal = areas / np.maximum(np.linalg.norm(areas, axis=-1, keepdims=True), 1e-300)
        cosine = (normal * ray).sum(axis=-1, keepdims=True)
        way = normal if values["telecentric"] > 0.5 else normal - cosine * ray
        azimuth = 2 * np.arctan2(way[..., 1], way[..., 0])
        more = (1 - cosine[..., 0] ** 2) * (values["along"] * np.cos(azimuth) + values["across"] * np.sin(azimuth))
        bright = np.maximum(1 + np.nan_to_num(more), 0).astype(np.float32)
        return replace(light, returns=tuple(Return(way.range_m, way.strength * bright) for way in light.returns))


effect = Polarised()

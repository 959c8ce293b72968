"""`scattering_medium`: fog, smoke, dust."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light

from physics.arrivals import Arrivals, arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering


class ScatteringMedium(Effect):
    """An even medium of extinction α: light from range R is less by exp(-2αR), and air before it sends light back.

    Scattering once, to all directions alike, a layer dr returns what a matt surface of ρ·cosθ = ω·α·dr/4 would; near
    the sensor emitter and receiver overlap in part, so that 1/r² becomes 1/(r² + overlap²). Each zone's medium
    reaches as far as its surfaces; pixels whose range is unknown have none.
    """

    id = "scattering_medium"
    acts_on = "scene"
    order = 1  # All that comes from surfaces, by whatever way, is dimmed.
    sentence = "Fog, smoke or dust dims far surfaces and sends light back from the air before them."
    look_alikes = (
        LookAlike("ambient_pedestal", "Cover the emitter: backscatter goes, a pedestal stays."),
        LookAlike("cover_glass_crosstalk", "Clear the air: crosstalk stays, backscatter goes."),
        LookAlike("range_falloff", "Clear the air: falloff stays, extinction goes."),
    )
    parameters = (
        Parameter(
            "extinction",
            unit="1/m",
            low=0.0,
            high=10.0,
            start=0.03,
            vanishes_at=0.0,
            sentence="Part of the light lost by metre; one sees 3 / extinction far, 100 m at 0.03.",
        ),
        Parameter(
            "albedo",
            unit="1",
            low=0.0,
            high=30.0,
            start=1.0,
            sentence="Backscatter over that of a medium that scatters to all sides alike and absorbs nothing.",
        ),
        Parameter(
            "overlap",
            unit="m",
            low=1e-3,
            high=1.0,
            start=0.05,
            tries=(0.05, 0.3),
            sentence="Range at which emitter and receiver overlap by half.",
        ),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Extinction of what is there, and the backscatter of each zone's open air."""
        surfaces, lattice = rendering.arrivals, rendering.arrivals.lattice
        alpha, overlap = values["extinction"], values["overlap"]
        zero = np.broadcast_to(rendering.clock.time_zero_s, surfaces.light.shape[:2])[..., None]
        half = speed_of_light / 4 * lattice.step_s
        ranges = speed_of_light / 2 * (lattice.first_s + lattice.step_s * np.arange(lattice.size) - zero)
        # The share of 1/(r² + overlap²) in the layer around each knot, in closed form.
        inner, outer = (np.arctan(np.maximum(ranges + side, 0) / overlap) for side in (-half, half))
        passed = np.exp(-2 * alpha * np.maximum(ranges, 0))
        layers = values["albedo"] * alpha / 4 * (outer - inner) / overlap
        return replace(surfaces, light=passed * (surfaces.light + layers * _open_air(rendering, ranges)))


def _open_air(rendering: Rendering, ranges: np.ndarray) -> np.ndarray:
    """(F, P, J) sum of each zone's weights over pixels whose surface is farther than the knot."""
    light = rendering.light
    known = np.isfinite(light.range_m) & (light.range_m > 0)
    # What lies beyond the window is open air all the same.
    nearer = np.minimum(np.where(known, light.range_m, 0), np.float32(ranges[..., -2].min()))
    once: Light = replace(light, returns=(Return(nearer.astype(np.float32), known.astype(np.float32)),))
    ends = arrivals(once, rendering.footprints, rendering.clock).light
    return np.cumsum(ends[..., ::-1], axis=-1)[..., ::-1] - ends / 2


effect = ScatteringMedium()

"""How much light comes back: from a matt surface, and from a small retroreflective patch.

Both are one lidar equation. A surface element dA at range r is lit with intensity / r², and sends
`coefficient` times that, per steradian and area, back to an aperture that fills 1 / r² steradians per area:

    photons = gain · W(direction) · coefficient · dA / r⁴

Matt: coefficient = (ρ/π) cos²θ, once for the light it catches and once for how large it is seen. With the
solid angle dΩ = cosθ dA / r² this is gain · W · (ρ/π) · cosθ · dΩ / r², the nominal model's form.
Retroreflector: coefficient = R_A = I / (E dA) in cd / (lx m²) = 1/sr (ASTM E808), so that a patch smaller
than what a zone sees falls off as r⁻⁴. Emitter and receiver 2.5 mm apart see it at 0.6 m under an observation
angle of 0.24 degrees, about the 0.2 degrees sheeting is specified at. The drop of R_A with the entrance angle
is left out.
"""

import numpy as np

# White sheeting of types III and IV: 250 and 360 per steradian at the least (ASTM D4956).
SHEETING_PER_SR = 300.0


def matt(reflectance: float, cosine: np.ndarray) -> np.ndarray:
    """Coefficient of a Lambertian surface, 1/sr, at incidence of this cosine."""
    return reflectance / np.pi * np.square(cosine)


def returned(response: np.ndarray, coefficient: np.ndarray, area_m2: np.ndarray, range_m: np.ndarray) -> np.ndarray:
    """Photons per unit of gain from elements of `area_m2` at `range_m`; all broadcast."""
    return response * coefficient * area_m2 / range_m**4

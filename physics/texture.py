"""What varies slowly over the view or over what is in it: a polynomial of two coordinates."""

import numpy as np

from physics.effect import Values
from physics.light import Light

# Powers of the two coordinates; those of third and fourth order by the letters of their product.
COARSE = {"slope_x": (1, 0), "slope_y": (0, 1), "bow_x": (2, 0), "bow_y": (0, 2), "bow_xy": (1, 1)}
FINE = {f"bend_{'x' * (n - k)}{'y' * k}": (n - k, k) for n in (3, 4) for k in range(n + 1)}
POWERS = COARSE | FINE
PRODUCTS = {name: "x" * i + "y" * j for name, (i, j) in POWERS.items()}


def texture(values: Values, light: Light) -> np.ndarray:
    """Value of the polynomial, (F, H, W) or what broadcasts to it; 0 where no range is known and it is asked for."""
    x, y = _on_surface(light) if values["on_surface"] else np.moveaxis(light.rays[..., :2], -1, 0)
    # By multiplication, which is quicker than powers are.
    across, down = ([1.0, one, one * one, one * one * one, (one * one) ** 2] for one in (x, y))
    return sum((values[name] * across[i] * down[j] for name, (i, j) in POWERS.items() if values[name]), np.zeros(()))


def _on_surface(light: Light) -> tuple[np.ndarray, np.ndarray]:
    """(F, H, W) each: metres to the right and down of what pixels see, in the camera's frame when the session began."""
    range_m = np.where(np.isfinite(light.range_m), light.range_m, 0).astype(float)
    depth = range_m / np.linalg.norm(light.rays, axis=-1)
    if light.motion is None:
        return light.rays[..., 0] * depth, light.rays[..., 1] * depth
    moved = light.motion.start_from_camera[light.motion.nearest(light.time_s)]
    rays = np.ascontiguousarray(np.moveaxis(light.rays, -1, 0))
    # Row by row of the transform, so that no array of points is made.
    right, down = (np.tensordot(moved[:, row, :3], rays, 1) * depth + moved[:, row, 3][:, None, None] for row in (0, 1))
    return right, down

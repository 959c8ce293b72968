"""What walks and jumps in the course of a session, for photons: written out anew, by another spline."""

from scipy.interpolate import make_interp_spline

from physics.effect import Values


def height_by_now(values: Values, time_s: float) -> float:
    """Height of a curve through the levels that is straight at both ends, and of a jump that is over or to come."""
    height = {0.0: 0.0}
    levels = sum(name.startswith("level_") for name in values)
    for k in range(1, levels + 1):
        height[float(k)] = values[f"level_{k}"]
        height[k - 0.5] = values[f"between_{k}"] + (height[k - 1.0] + height[float(k)]) / 2
    places = sorted(height)
    curve = make_interp_spline(places, [height[at] for at in places], k=3, bc_type="natural")
    return float(curve(min(time_s / values["every"], float(levels)))) + values["jump"] * (time_s > values["jump_at"])

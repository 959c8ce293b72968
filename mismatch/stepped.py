"""Whether counts are those of surfaces that pass smoothly between steps of the depth camera."""

from dataclasses import replace

import numpy as np
from scipy.stats import norm

from mismatch.checks import Check
from mismatch.fit import Fit, expected_at
from mismatch.projection import Projection
from mismatch.simulation import Simulation
from physics.depth_steps import between_steps


def stepped(simulation: Simulation, fitted: Fit) -> Check:
    """By a score test of the change that smooth surfaces make beside a fit; nothing where depth has no steps."""
    found = between_steps(simulation.light)
    if found is None:
        return Check(1.0, "")
    smooth, step = found
    other = replace(simulation, light=smooth)
    if simulation.whole is not None:
        other = replace(other, whole=replace(simulation.whole, light=between_steps(simulation.whole.light)[0]))
    projection = Projection(simulation, fitted)
    change = projection.whitened((expected_at(other, fitted.forms, fitted.x) - fitted.expected).ravel())
    size = float(np.sqrt(change @ change))
    z = float(change @ projection.residual) / size if size > 0 else 0.0
    said = f"depth comes in steps of {step}, and counts are of surfaces between them, by {z:.1f} standard deviations"
    return Check(float(norm.sf(z)), said, foreign=True)

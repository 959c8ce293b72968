"""Sweeps on which physics and a black box are compared, and the comparison itself."""

import numpy as np
import pytest

from mismatch.prove.extrapolation import FARTHEST_M, NEAREST_M, compare_on_far, sweep
from physics.effects import find_effect


def test_a_sweep_recedes():
    tail = find_effect("impulse_tail").at(share=0.1, tau=5e-10)
    simulation, distance = sweep(np.random.default_rng(1), tail, 6)
    assert simulation.counts.shape == (6, 9, 128)
    assert distance[[0, -1]] == pytest.approx([NEAREST_M, FARTHEST_M])
    seen = np.median(simulation.light.range_m, axis=(1, 2))
    assert (np.diff(seen) > 0).all()
    assert simulation.given == ()


@pytest.mark.slow
def test_physics_holds_beyond_where_it_was_fitted_and_a_black_box_does_not():
    tail = find_effect("impulse_tail").at(share=0.1, tau=5e-10)
    simulation, distance = sweep(np.random.default_rng(2), tail, 48)
    found = compare_on_far(simulation, np.flatnonzero(distance < 0.8), "impulse_tail")
    assert found.named == ("impulse_tail",)
    near, far = ({kind: getattr(found, kind)[i] for kind in ("nominal", "physics", "black_box")} for i in (0, 1))
    # Both take most of the misfit away where they were fitted.
    assert max(near["physics"], near["black_box"]) < 1 + 0.1 * (near["nominal"] - 1)
    assert far["physics"] == pytest.approx(found.noise[1], abs=0.04)
    assert far["black_box"] > far["physics"] + 0.05

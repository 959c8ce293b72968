from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from devices.arm.kinematics import MODELS, forward, inverse, inverted, links, pose_of, transform
from recordings.refusal import Refusal

# Corners of a published scan, taught on a UR10, degrees: lower left, upper right, upper left.
TAUGHT = [
    [90, -110.82, 151.63, -82.93, -180, 225.22],
    [90, -45.64, 31.43, -64.68, -180, 225.22],
    [90, -129.53, 123.36, -87.48, -180, 225.22],
]
angles = st.lists(st.floats(-np.pi, np.pi), min_size=6, max_size=6).map(np.array)
models = st.sampled_from(sorted(MODELS))


def elementary(axis, angle=0.0, shift=0.0):
    """A turn about an axis and a shift along it."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
    out[:3, 3] = shift * np.eye(3)["xyz".index(axis)]
    return out


def chained(model, joints, longer_m=0.0):
    """The flange by a chain of elementary turns and shifts, the definition of Denavit and Hartenberg."""
    arm = replace(MODELS[model], a3=MODELS[model].a3 - longer_m)
    out = np.eye(4)
    table = ((arm.d1, 0, 90), (0, arm.a2, 0), (0, arm.a3, 0), (arm.d4, 0, 90), (arm.d5, 0, -90), (arm.d6, 0, 0))
    for q, (d, a, twist) in zip(joints, table, strict=True):
        out = out @ elementary("z", q, d) @ elementary("x", np.radians(twist), a)
    return out


@given(models, angles)
def test_forward_is_the_chain_of_joints(model, joints):
    np.testing.assert_allclose(forward(MODELS[model], joints), chained(model, joints), atol=1e-12)


@given(models, angles)
def test_every_solution_brings_the_flange_there_and_the_joints_are_one_of_them(model, joints):
    flange = chained(model, joints)
    found = inverse(MODELS[model], flange[None], joints[5]).joints[0]
    real = found[np.isfinite(found).all(axis=1)]
    for solution in real:
        np.testing.assert_allclose(chained(model, solution), flange, atol=1e-5)
    # Close to a singularity joints are as uncertain as the root of the rounding.
    well_away = min(abs(np.sin(joints[4])), abs(np.sin(joints[2]))) > 1e-2
    wrist = flange[:3, 3] - MODELS[model].d6 * flange[:3, 2]
    if well_away and np.hypot(*wrist[:2]) > 1.001 * MODELS[model].d4:
        turned = np.remainder(real - joints + np.pi, 2 * np.pi) - np.pi
        assert abs(turned).max(axis=1).min() < 1e-6


@settings(max_examples=6, deadline=None)
@given(models, angles)
def test_what_a_numerical_solver_finds_is_among_the_solutions(model, joints):
    flange = chained(model, joints)
    solved = least_squares(lambda q: (chained(model, q) - flange)[:3].ravel(), joints + 0.2, xtol=1e-15, ftol=1e-15)
    if solved.cost < 1e-20 and min(abs(np.sin(solved.x[4])), abs(np.sin(solved.x[2]))) > 0.05:
        found = inverse(MODELS[model], flange[None]).joints[0]
        turned = np.remainder(found - solved.x + np.pi, 2 * np.pi) - np.pi
        assert np.nanmin(abs(turned).max(axis=1)) < 1e-4


def test_taught_corners_of_a_published_scan_span_an_upright_plane():
    corners = forward(links("UR10"), np.radians(TAUGHT))
    lower_left, upper_right, upper_left = corners[:, :3, 3]
    # The published script keeps x at the first corner and runs through y and z.
    assert np.ptp(corners[:, 0, 3]) < 1e-6
    np.testing.assert_allclose(corners[:, :3, 2], np.tile([-1.0, 0, 0], (3, 1)), atol=1e-3)
    assert abs(upper_left[1] - lower_left[1]) < 0.005
    assert abs(upper_right[2] - upper_left[2]) < 0.02
    assert 0.7 < abs(upper_right[1] - upper_left[1]) < 0.9


def test_where_no_wrist_gets_there_is_no_solution_and_how_far_it_misses():
    # Where a straight arm with a longer forearm gets, the real one is too short by just that.
    flange = chained("UR5e", [0.3, -1.0, 0.0, 0.4, 1.0, 0.2], longer_m=0.05)
    found = inverse(MODELS["UR5e"], flange[None])
    missed = abs(found.missing_m[0] - 0.05) < 1e-9
    assert missed.any()
    assert np.isnan(found.joints[0, missed]).all()


def test_too_close_to_the_base_there_is_no_solution():
    arm = MODELS["UR10"]
    flange = np.eye(4)
    flange[:3, 3] = [arm.d4 - 0.03, 0.0, 0.7 + arm.d6]
    found = inverse(arm, flange[None])
    assert np.isnan(found.joints).all()
    np.testing.assert_allclose(found.missing_m, -0.03)


def test_poses_and_transforms_go_there_and_back():
    rng = np.random.default_rng(3)
    poses = rng.uniform(-1, 1, (50, 6))
    np.testing.assert_allclose(pose_of(transform(poses)), poses, atol=1e-12)
    np.testing.assert_allclose(
        transform(poses) @ inverted(transform(poses)), np.tile(np.eye(4), (50, 1, 1)), atol=1e-12
    )


def test_an_arm_nobody_has_measured_is_refused():
    with pytest.raises(Refusal, match=r"arm\.model is 'UR99', expected one of UR3"):
        links("UR99")

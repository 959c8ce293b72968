"""Where the flange of a UR arm is for given joints, and which joints bring it to a given pose.

Poses are (..., 4, 4) rigid transforms in the arm's base frame or, where they are called `pose`, (..., 6) metres and
rotation vectors as the controller reports them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from recordings.refusal import Refusal


@dataclass(frozen=True)
class Links:
    """Denavit-Hartenberg lengths, metres; the twists are 90, 0, 0, 90, -90 and 0 degrees for all of these arms."""

    d1: float
    a2: float
    a3: float
    d4: float
    d5: float
    d6: float


# Universal Robots, "DH Parameters for calculations of kinematics and dynamics" (support article 17257).
MODELS = {
    "UR3": Links(0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "UR5": Links(0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "UR10": Links(0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "UR3e": Links(0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "UR5e": Links(0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "UR10e": Links(0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "UR16e": Links(0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
}
# Shoulder, wrist and elbow each have two ways: (8, 3) signs, the order of the second axis of `inverse`.
BRANCHES = np.array([(s, w, e) for s in (1, -1) for w in (1, -1) for e in (1, -1)], float)

SINGULAR = 1e-6


def links(model: str) -> Links:
    """The lengths of a model by its name."""
    if model not in MODELS:
        raise Refusal(f"arm.model is {model!r}, expected one of {', '.join(MODELS)}")
    return MODELS[model]


def transform(pose: np.ndarray) -> np.ndarray:
    """(..., 4, 4) of (..., 6) metres and rotation vector."""
    pose = np.asarray(pose, float)
    out = np.zeros((*pose.shape[:-1], 4, 4))
    out[..., :3, :3] = Rotation.from_rotvec(pose[..., 3:]).as_matrix()
    out[..., :3, 3] = pose[..., :3]
    out[..., 3, 3] = 1
    return out


def pose_of(matrix: np.ndarray) -> np.ndarray:
    """(..., 6) metres and rotation vector of (..., 4, 4)."""
    turn = Rotation.from_matrix(matrix[..., :3, :3]).as_rotvec()
    return np.concatenate([matrix[..., :3, 3], turn], axis=-1)


def inverted(matrix: np.ndarray) -> np.ndarray:
    """The inverse of rigid transforms (..., 4, 4)."""
    out = np.zeros_like(matrix)
    turned = np.swapaxes(matrix[..., :3, :3], -1, -2)
    out[..., :3, :3] = turned
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", turned, matrix[..., :3, 3])
    out[..., 3, 3] = 1
    return out


def forward(arm: Links, joints: np.ndarray) -> np.ndarray:
    """(..., 4, 4) pose of the flange for joints (..., 6), radians; written out, as Hawkins (2013), eq. 1 to 12."""
    q = np.moveaxis(np.asarray(joints, float), -1, 0)
    (s1, s5, s6), (c1, c5, c6) = np.sin(q[[0, 4, 5]]), np.cos(q[[0, 4, 5]])
    q23, q234 = q[1] + q[2], q[1] + q[2] + q[3]
    s, c = np.sin(q234), np.cos(q234)
    along = arm.a2 * np.cos(q[1]) + arm.a3 * np.cos(q23) + arm.d5 * s - arm.d6 * s5 * c
    up = arm.d1 + arm.a2 * np.sin(q[1]) + arm.a3 * np.sin(q23) - arm.d5 * c - arm.d6 * s5 * s
    across = arm.d4 + arm.d6 * c5
    out = np.zeros((*q.shape[1:], 4, 4))
    for column, (in_plane, height, aside) in enumerate(
        (
            (c * c5 * c6 - s * s6, s * c5 * c6 + c * s6, s5 * c6),
            (-c * c5 * s6 - s * c6, -s * c5 * s6 + c * c6, -s5 * s6),
            (-c * s5, -s * s5, c5),
            (along, up, across),
        )
    ):
        out[..., 0, column] = c1 * in_plane + s1 * aside
        out[..., 1, column] = s1 * in_plane - c1 * aside
        out[..., 2, column] = height
    out[..., 3, 3] = 1
    return out


@dataclass(frozen=True, eq=False)
class Solutions:
    """Joints (N, 8, 6), radians within ±π, of N poses on each of the eight `BRANCHES`; NaN where there are none.

    shoulder, elbow: (N, 8) the cosines that have to be within ±1 for a solution; wrist: (N, 8) sine of joint 5.
    missing_m: (N, 8) by how much the wrist is too far out (more than 0) or too far in (less than 0).
    """

    joints: np.ndarray
    shoulder: np.ndarray
    elbow: np.ndarray
    wrist: np.ndarray
    missing_m: np.ndarray


def inverse(arm: Links, flange: np.ndarray, joint6: float = 0.0) -> Solutions:
    """All joints that bring the flange to (N, 4, 4).

    K. P. Hawkins, "Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms" (Georgia Tech, 2013).
    Where joint 5 is 0 or 180 degrees only a sum of joints counts: joint 6 is taken as `joint6` there.
    """
    shoulder_way, wrist_way, elbow_way = BRANCHES.T
    turn, at = flange[:, None, :3, :3], flange[:, None, :3, 3]
    wrist = at - arm.d6 * turn[..., 2]
    from_axis = np.hypot(wrist[..., 0], wrist[..., 1])
    shoulder = arm.d4 / np.maximum(from_axis, 1e-12)
    q1 = np.arctan2(wrist[..., 1], wrist[..., 0]) + np.pi / 2 + shoulder_way * np.arccos(np.minimum(shoulder, 1))
    s1, c1 = np.sin(q1), np.cos(q1)
    # Axes of the flange across the plane of the arm, whose normal is (s1, -c1, 0).
    x, y, z = (turn[..., 0, i] * s1 - turn[..., 1, i] * c1 for i in range(3))
    s5 = wrist_way * np.hypot(x, y)
    q5 = np.arctan2(s5, z)
    q6 = np.where(abs(s5) > SINGULAR, np.arctan2(-y * wrist_way, x * wrist_way), joint6)
    # Within the plane: "along" and "up" of the wrist's centre beyond joint 4, and the direction of joints 2 + 3 + 4.
    s6, c6 = np.sin(q6), np.cos(q6)
    y4 = turn[..., 0] * s6[..., None] + turn[..., 1] * c6[..., None]
    sin234, cos234 = -(y4[..., 0] * c1 + y4[..., 1] * s1), y4[..., 2]
    along = wrist[..., 0] * c1 + wrist[..., 1] * s1 - arm.d5 * sin234
    up = wrist[..., 2] - arm.d1 + arm.d5 * cos234
    far = np.hypot(along, up)
    elbow = (far**2 - arm.a2**2 - arm.a3**2) / (2 * arm.a2 * arm.a3)
    q3 = elbow_way * np.arccos(np.clip(elbow, -1, 1))
    s3, c3 = arm.a3 * np.sin(q3), arm.a2 + arm.a3 * np.cos(q3)
    q2 = np.arctan2(c3 * up - s3 * along, c3 * along + s3 * up)
    q4 = np.arctan2(sin234, cos234) - q2 - q3
    joints = np.stack(np.broadcast_arrays(q1, q2, q3, q4, q5, q6), axis=-1)
    joints = np.remainder(joints + np.pi, 2 * np.pi) - np.pi
    joints[(shoulder > 1) | (abs(elbow) > 1)] = np.nan
    too_far, too_near = far - abs(arm.a2 + arm.a3), far - abs(arm.a2 - arm.a3)
    missing = np.where(too_far > 0, too_far, np.minimum(too_near, 0))
    missing = np.where(shoulder > 1, from_axis - arm.d4, missing)
    shoulder = np.broadcast_to(shoulder, elbow.shape)
    return Solutions(joints, shoulder, elbow, s5, missing)

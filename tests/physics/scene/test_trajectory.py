import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from physics.scene.trajectory import Trajectory, looking_at, pose_of, read_trajectory
from recordings.refusal import Refusal


def test_poses_between_poses_turn_evenly():
    turn = pose_of(np.array([1.0, 2, 3]), Rotation.from_euler("y", 90, degrees=True).as_quat(), "there")
    found = Trajectory(np.array([0.0, 2]), np.stack([np.eye(4), turn])).resampled(5)
    np.testing.assert_allclose(found.time_s, [0, 0.5, 1, 1.5, 2])
    np.testing.assert_allclose(found.poses[1, :3, 3], [0.25, 0.5, 0.75])
    np.testing.assert_allclose(Rotation.from_matrix(found.poses[3, :3, :3]).as_rotvec(), [0, 0.75 * np.pi / 2, 0])
    still = Trajectory(np.zeros(1), turn[None]).resampled(3)
    assert len(np.unique(still.time_s)) == 3
    np.testing.assert_array_equal(still.poses[2], turn)


def test_looking_at_something_level():
    pose = looking_at(np.array([1.0, 0, 0]), np.array([4.0, 0, 0]), "here")
    np.testing.assert_allclose(pose[:3, :3] @ [0, 0, 1], [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(pose[:3, :3] @ [0, 1, 0], [0, 1, 0], atol=1e-12)
    assert np.linalg.det(pose) == pytest.approx(1)
    with pytest.raises(Refusal, match="straight up or down"):
        looking_at(np.zeros(3), np.array([0.0, 3, 0]), "here")


def test_a_file_of_poses(tmp_path):
    file = tmp_path / "poses.txt"
    file.write_text("# a comment\n0 1 2 3 0 0 0 1\n\n0.5 1 2 4 0 0 1 0\n")
    found = read_trajectory(file)
    assert found.time_s.tolist() == [0, 0.5]
    np.testing.assert_allclose(found.poses[1], [[-1, 0, 0, 1], [0, -1, 0, 2], [0, 0, 1, 4], [0, 0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("0 1 2 3 0 0 1\n", "line 1 has 7 numbers, expected 8"),
        ("0 1 2 3 0 0 0 2\n", "line 1: the quaternion has length 2, expected 1"),
        ("0 1 2 nan 0 0 0 1\n", "line 1 holds a number that is not finite"),
        ("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "strictly increasing"),
        ("0 a b c 0 0 0 1\n", "damaged list of poses"),
        ("# nothing\n", "holds no pose"),
    ],
)
def test_what_is_no_list_of_poses(text, sentence, tmp_path):
    (tmp_path / "poses.txt").write_text(text)
    with pytest.raises(Refusal, match=sentence):
        read_trajectory(tmp_path / "poses.txt")


def test_a_pose_that_is_not_rigid():
    with pytest.raises(Refusal, match="pose 0 has rows that are not orthonormal"):
        Trajectory(np.zeros(1), np.diag([1.0, 1, 1.1, 1])[None])

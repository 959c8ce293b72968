"""A stream of frames, most of them bad: it neither raises, nor grows, nor stops."""

import threading

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from fusion.fuser import CLOCK_FRAMES, MOST_COMPLAINTS, Fuser
from fusion.volume import Volume
from recordings.refusal import Refusal

SHAPE = (24, 32)
RGB = np.random.default_rng(0).integers(0, 256, (*SHAPE, 3), np.uint8)


@pytest.fixture(scope="module")
def counts(rig):
    """A wall at 1.1 m, 4000 counts a zone."""
    at = np.abs(rig.response.range_m - 1.1).argmin()
    return np.random.default_rng(1).poisson(4000 * rig.response.counts[:, at] + 3)


def fuser(rig, **more):
    return Fuser(rig.sight, rig.response, "splat", **more)


def test_a_good_frame(rig, counts):
    robot, pose = fuser(rig, volume=Volume(voxel_m=0.1, most_blocks=500)), np.eye(4)
    pose[:3, 3] = 1, 2, 3
    made = robot.push(counts, RGB, pose, 4.0)
    bare = fuser(rig).push(counts, RGB, timestamp_s=4.0)
    np.testing.assert_allclose(made.points_m, bare.points_m + np.float32([1, 2, 3]), atol=1e-5)
    assert np.median(np.linalg.norm(bare.points_m, axis=1)) == pytest.approx(1.1, abs=0.03)
    assert made.timestamp_s == 4.0
    assert made.colours.shape == made.points_m.shape
    assert robot.complaints == {}
    assert robot.latest is made
    assert robot.volume.frames == 1
    assert len(robot.volume.cloud().point.positions) > 10


def test_without_a_camera_frame_zones_are_points(rig, counts):
    robot = fuser(rig)
    made = robot.push(counts)
    assert made.zones.tolist() == [0, 1, 2, 3]
    assert made.colours is None
    assert list(robot.complaints) == ["rgb is missing: the cloud is by direction of zones"]
    assert robot.skipped == 0


BAD = {
    "shape": (lambda c: {"counts": c[:2]}, "counts are no numbers of shape"),
    "text": (lambda c: {"counts": "abc"}, "counts are no numbers"),
    "ragged": (lambda c: {"counts": [[1], [1, 2]]}, "counts are no numbers"),
    "nan": (lambda c: {"counts": np.where(c > 50, np.nan, c)}, "NaN, infinity or values below 0"),
    "negative": (lambda c: {"counts": c.astype(int) - 10}, "NaN, infinity or values below 0"),
    "dark": (lambda c: {"counts": c * 0}, "all zones are dead"),
    "time": (lambda c: {"timestamp_s": np.nan}, "timestamp_s is no finite number"),
    "early": (lambda c: {"timestamp_s": -5.0}, "timestamp_s is not after"),
}
ODD = {
    "dead zone": (lambda c: {"counts": c * (np.arange(4)[:, None] != 2)}, "zone 2 is dead"),
    "image of another size": (lambda c: {"rgb": RGB[:5]}, "rgb holds uint8 of shape"),
    "broken image": (lambda c: {"rgb": b"\x89PNG nothing"}, "direction of zones"),
    "no image": (lambda c: {"rgb": None}, "rgb is missing"),
    "pose": (lambda c: {"pose": np.full((4, 4), np.nan)}, "pose is no rigid"),
    "pose of another shape": (lambda c: {"pose": [1, 2, 3]}, "pose is no rigid"),
    "mirror": (lambda c: {"pose": np.diag([-1.0, 1, 1, 1])}, "pose is no rigid"),
}


@pytest.mark.parametrize("fault", BAD)
def test_a_bad_frame_is_skipped_and_the_next_is_not(rig, counts, fault):
    robot = fuser(rig)
    robot.push(counts, RGB, timestamp_s=0.0)
    change, said = BAD[fault]
    assert len(robot.push(**({"counts": counts, "rgb": RGB, "timestamp_s": 1.0} | change(counts)))) == 0
    assert robot.skipped == 1
    (sentence,) = [sentence for sentence in robot.complaints if said in sentence]
    assert "\n" not in sentence
    assert len(robot.push(counts, RGB, timestamp_s=2.0)) > 100


@pytest.mark.parametrize("fault", ODD)
def test_an_odd_frame_gives_what_it_can(rig, counts, fault):
    robot = fuser(rig, volume=Volume(voxel_m=0.1, most_blocks=500))
    change, said = ODD[fault]
    made = robot.push(**({"counts": counts, "rgb": RGB, "timestamp_s": 1.0} | change(counts)))
    assert len(made) >= 3
    assert [sentence for sentence in robot.complaints if said in sentence]
    assert robot.skipped == 0


def test_a_clock_that_is_set_back_is_followed(rig, counts):
    robot = fuser(rig)
    robot.push(counts, RGB, timestamp_s=1e12)
    made = [len(robot.push(counts, RGB, timestamp_s=float(i))) for i in range(CLOCK_FRAMES + 2)]
    assert made[: CLOCK_FRAMES - 1] == [0] * (CLOCK_FRAMES - 1)
    assert min(made[CLOCK_FRAMES - 1 :]) > 100


@settings(max_examples=12, deadline=None)
@given(st.lists(st.sampled_from([None, *BAD, *ODD]), min_size=5, max_size=40), st.booleans())
def test_a_stream_of_faults_neither_raises_nor_grows_nor_stops(rig, counts, faults, odometry):
    volume = Volume(voxel_m=0.1, most_blocks=40)
    robot = fuser(rig, volume=volume, odometry=odometry)
    robot.push(counts, RGB, np.eye(4), -1.0)
    faults = [fault for fault in faults if fault != "early"] + ["early"] * min(faults.count("early"), CLOCK_FRAMES - 1)
    np.random.default_rng(len(faults)).shuffle(faults)
    for i, fault in enumerate(faults):
        pose = np.eye(4)
        pose[0, 3] = i
        frame = {"counts": counts, "rgb": RGB, "timestamp_s": float(i), "pose": pose}
        change = (lambda c: {}) if fault is None else (BAD | ODD)[fault][0]
        made = robot.push(**(frame | change(counts)))
        assert (len(made) == 0) == (fault in BAD)
        assert volume.grid.hashmap().size() <= 40
    assert robot.frames == len(faults) + 1
    assert len(robot.complaints) < 30
    assert robot.skipped == sum(fault in BAD for fault in faults)
    assert len(robot.push(counts, RGB, timestamp_s=1e6)) > 100


def test_complaints_are_bounded(rig, counts):
    robot = fuser(rig)
    for i in range(MOST_COMPLAINTS + 50):
        robot._complain(f"of kind {i}")
    assert len(robot.complaints) == MOST_COMPLAINTS + 1
    assert sum(robot.complaints.values()) == MOST_COMPLAINTS + 50


def test_several_threads_push_and_none_is_lost(rig, counts):
    robot = fuser(rig, volume=Volume(voxel_m=0.1, most_blocks=500))
    sizes = []

    def work():
        sizes.extend(len(robot.push(counts, RGB, np.eye(4))) for _ in range(10))

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(sizes) == robot.frames == robot.volume.frames == 40
    assert len(set(sizes)) == 1


def test_other_zones_or_methods_are_refused(rig):
    with pytest.raises(Refusal, match="method 'magic' is unknown"):
        Fuser(rig.sight, rig.response, "magic")

"""A scan through the real drivers before emulated devices, from the rig file to the maps, with trouble on the way."""

import json

import numpy as np
import pytest

from calibrate.calibration import calibrate
from calibrate.consistency import cosines
from calibrate.rig import load_rig
from devices.captures import DeviceLost
from devices.emulated.tmf882x.faults import Faults
from devices.rehearsal.control import Control, order
from devices.rehearsal.rehearsal import KILO, Rehearsal, Trouble
from devices.scan.conduct import begun, conduct
from devices.scan.motion_plan import load_plan
from devices.tmf882x.driver import open_tmf882x
from recordings.files import load
from recordings.refusal import Refusal


def nobody(sentence):
    raise AssertionError(f"a person was asked: {sentence}")


def test_a_scan_with_trouble_ends_and_its_maps_are_those_of_the_bench(tmp_path):
    trouble = Trouble(Faults(lose=0.005, unplug_at=(8,)), stops=((12, "protective"),))
    rng = np.random.default_rng(3)
    more = {"monitor_every": 10, "settle_s": 0.0}
    rehearsal = Rehearsal(tmp_path / "rig", 6, 4, rng=rng, speed=200, host="127.0.7.1", trouble=trouble, **more)
    said = []
    with rehearsal:
        plan, rig = load_plan(tmp_path / "rig" / "plan.json"), load_rig(tmp_path / "rig" / "rig.json")
        assert plan == rehearsal.plan
        written, tally = conduct(plan, rig, tmp_path / "scan.rrd", ask=nobody, tell=said.append)
        with pytest.raises(Refusal, match="is there already, expected a new name"):
            conduct(plan, rig, tmp_path / "scan.rrd", ask=nobody, tell=said.append)
    assert sorted(written) == ["background", "monitor", "patch"]
    assert tally["stops"] == {"protective": 1}
    assert tally["lost"]["LiDAR"] >= 1
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "rig",
        "scan-background.rrd",
        "scan-monitor.rrd",
        "scan.rrd",
    ]
    lit, dark = load(written["patch"]), load(written["background"])
    assert len(lit.counts) == len(dark.counts) == 24
    result = calibrate(lit, dark)
    poses = np.array(lit.meta["arm_pose"])[result.positions.frames[:, 0]]
    # The arm was really where the plan has it, and the maps are those of the bench.
    cells = plan.poses(lit_cells(lit))
    np.testing.assert_allclose(poses[:, :3], cells[:, :3], atol=3e-4)
    assert cosines(result.maps.by_zone.astype(float), rehearsal.scene.truth(poses, KILO)).min() > 0.995
    assert lit.laser_cycles == 1024 * KILO
    np.testing.assert_allclose(lit.intrinsics, rehearsal.scene.bench.intrinsics)
    np.testing.assert_allclose(lit.lidar_from_camera, rehearsal.scene.bench.lidar_from_camera, atol=1e-12)


def lit_cells(recording):
    plan = recording.meta["plan"]
    row, column = np.divmod(np.arange(plan["columns"] * plan["rows"]), plan["columns"])
    return row * plan["columns"] + np.where(row % 2 == 1, plan["columns"] - 1 - column, column)


def files(tmp_path):
    """Plan and rig of a rehearsal that is not served."""
    rehearsal = Rehearsal(tmp_path / "rig", 5, 4, rng=np.random.default_rng(0))
    return rehearsal.plan, rehearsal.scene.rig(rehearsal._lidar)


def test_a_scan_that_was_left_is_neither_begun_anew_nor_gone_on_with_by_another_plan(tmp_path):
    plan, rig = files(tmp_path)
    out = tmp_path / "scan.rrd"
    with pytest.raises(Refusal, match="so there is no scan to go on with"):
        begun(plan, rig, out, resume=True)
    assert list(tmp_path.iterdir()) == []
    begun(plan, rig, out, resume=False).close()
    with pytest.raises(Refusal, match="a scan was left here; go on with --resume"):
        begun(plan, rig, out, resume=False)
    other = type(plan)(**json.loads(plan.text()) | {"columns": 6, "lower_left": plan.lower_left})
    with pytest.raises(Refusal, match="plan: columns is not what the scan was begun with"):
        begun(other, rig, out, resume=True)
    begun(plan, rig, out, resume=True).close()


def test_addresses_of_devices_may_change_between_two_sittings(tmp_path):
    plan, rig = files(tmp_path)
    begun(plan, rig, tmp_path / "scan.rrd", resume=False).close()
    moved = type(rig)(**{**vars(rig), "arm": type(rig.arm)("10.0.0.7", rig.arm.model), "control": "elsewhere"})
    begun(plan, moved, tmp_path / "scan.rrd", resume=True).close()
    wider = type(rig)(**{**vars(rig), "patch_radius_m": 0.02})
    with pytest.raises(Refusal, match="rig: patch_radius_m is not what"):
        begun(plan, wider, tmp_path / "scan.rrd", resume=True)


def test_orders_are_obeyed_one_by_one_and_bad_ones_are_answered(tmp_path):
    heard = []

    def twice(number):
        heard.append(int(number))

    control = Control(tmp_path / "c", {"add": twice, "sum": lambda: str(sum(heard))})
    assert order(tmp_path / "c", "add 3") == "done"
    assert order(tmp_path / "c", "add 4") == "done"
    assert order(tmp_path / "c", "sum") == "7"
    assert "unknown order 'fly', expected one of add, sum" in order(tmp_path / "c", "fly away")
    assert order(tmp_path / "c", "add x").startswith("add: ")
    assert order(tmp_path / "c", "add").startswith("add: ")
    control.close()
    with pytest.raises(DeviceLost, match="no rehearsal listens at"):
        order(tmp_path / "c", "sum")


def test_a_speed_that_is_none_is_refused(tmp_path):
    with pytest.raises(Refusal, match="speed is 0, expected a number above 0"):
        Rehearsal(tmp_path, rng=np.random.default_rng(0), speed=0)


def test_a_mistake_in_the_scene_is_not_taken_for_a_pulled_cable(tmp_path):
    class Wrong(Exception):
        pass

    def broken(pose, kilo):
        raise Wrong("of the scene")

    with Rehearsal(tmp_path, 5, 4, rng=np.random.default_rng(0), speed=200, host="127.0.7.3") as rehearsal:
        assert rehearsal.failure is None
        rehearsal.scene.counts = broken
        lidar = open_tmf882x(rehearsal.rig.lidar)
        with pytest.raises(DeviceLost):
            lidar.measure()
        lidar.close()
        assert isinstance(rehearsal.failure, Wrong)

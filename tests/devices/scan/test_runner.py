"""Scans of a simulated bench from start to end, and from wherever they were cut off."""

import json

import numpy as np
import pytest

from calibrate.calibration import calibrate
from calibrate.consistency import cosines
from calibrate.rig import LidarSetup
from devices.scan.export import export
from devices.scan.journal import Journal
from devices.scan.runner import Scan
from recordings.files import load
from recordings.refusal import Refusal
from tests.devices.scan.fakes import KILO, FakeHolder, World, known_survey, lens, station

GRID = (8, 5)


class Cut(Exception):
    """The process ends here."""


def begin(path, world, *, said=None, holder=None, watch=lambda seen: None, surveyed=True, **more):
    """A scan with its journal; `said` collects what it tells. surveyed: the patch was looked for already."""
    journal = Journal(path)
    plan = world.scene.plan(*GRID, **more)
    journal.say("plan", json.loads(plan.text()))
    journal.say("rig", json.loads(world.scene.rig(LidarSetup()).text()))
    journal.say("camera", {"intrinsics": lens(world)})
    if surveyed:
        journal.say("survey", known_survey(*GRID))
    journal.say("lidar", {"kilo_iterations": KILO})
    tell = (said if said is not None else []).append
    place = station(world, tell)
    return journal, Scan(plan, place, holder or FakeHolder(world), journal, zone_grid=(3, 3), watch=watch, tell=tell)


def visits(journal, name):
    return journal.cells(name)


def test_a_scan_visits_every_cell_in_both_passes_and_calibrates(tmp_path):
    world = World()
    journal, scan = begin(tmp_path / "s.scanning", world, surveyed=False, monitor_every=7)
    scan.run()
    snake = [r * 8 + (c if r % 2 == 0 else 7 - c) for r in range(5) for c in range(8)]
    assert visits(journal, "patch") == visits(journal, "background") == snake
    assert visits(journal, "monitor") == [20] * 5
    written = export(journal, tmp_path / "s.rrd")
    assert sorted(written) == ["background", "monitor", "patch"]
    lit, dark = load(written["patch"]), load(written["background"])
    poses = np.array(lit.meta["arm_pose"])
    result = calibrate(lit, dark)
    truth = world.scene.truth(poses, KILO)
    assert cosines(result.maps.by_zone.astype(float), truth).min() > 0.99
    expected = np.stack([world.scene.bench.project(world.scene.position_m(pose)) for pose in poses])
    off = np.hypot(*(np.stack([result.maps.xs, result.maps.ys], axis=1) - expected).T)
    assert np.median(off) < 0.1
    assert lit.laser_cycles == 1024 * KILO
    assert abs(lit.meta["drift"]["signal"]) < 0.02


@pytest.mark.parametrize("interleaved", [False, True])
def test_what_was_cut_off_goes_on_and_does_nothing_twice(tmp_path, interleaved):
    world, path = World(), tmp_path / "s.scanning"
    more = {"passes": "interleaved", "block": 9} if interleaved else {}
    for cut_at in (3, 20, 30, 60):

        def watch(seen, cut_at=cut_at):
            if seen.done == cut_at:
                raise Cut

        journal, scan = begin(path, world, watch=watch, **more)
        with pytest.raises(Cut):
            scan.run()
        assert journal.count() >= cut_at
        journal.close()
    journal, scan = begin(path, world, **more)
    scan.run()
    assert sorted(visits(journal, "patch")) == sorted(visits(journal, "background")) == list(range(40))
    # At each of five starts and each change of the pass a look; each position once, but for those that were cut off.
    assert len(world.moved_to) <= 80 + 2 * 5 + 2 * (40 // 9 + 5) + 4 + 5


def test_devices_that_go_away_and_arms_that_stop_are_waited_for(tmp_path):
    world, said = World(goes_wrong={"arm": {5, 25}, "lidar": {5, 33}, "camera": {30}}), []
    journal, scan = begin(tmp_path / "s.scanning", world, said=said, passes="patch only")
    scan.run()
    assert sorted(visits(journal, "patch")) == list(range(40))
    assert world.resumed == 2
    assert world.opened.count("lidar") == 3
    assert world.opened.count("camera") == 2
    assert sum("cable" in sentence for sentence in said) == 2
    assert sum("ran into" in sentence for sentence in said) == 2


def test_what_was_lost_while_it_was_read_is_seen_again_at_its_own_position(tmp_path):
    world = World(goes_wrong={"reading": {4, 17}, "line": {2, 9, 10, 41}})
    journal, scan = begin(tmp_path / "s.scanning", world, passes="patch only", monitor_every=0)
    scan.run()
    cells = journal.cells("patch")
    assert sorted(cells) == list(range(40))
    plan = world.scene.plan(*GRID)
    for sample in journal.samples("patch"):
        np.testing.assert_allclose(sample.said["pose"], plan.poses(np.array([sample.cell]))[0], atol=1e-6)
        # Counts were taken where the arm was: those of a fresh look there are alike.
        again = world.scene.counts(np.array(sample.said["pose"]), KILO)[1:].astype(float)
        assert abs(again.sum() / sample.frames[0].counts.sum() - 1) < 0.1
    assert world.opened.count("lidar") == 3


def test_a_patch_that_fell_off_stops_the_scan_and_its_empty_samples_are_forgotten(tmp_path):
    world = World()

    def watch(seen):
        world.scene.patch = seen.done < 15

    journal, scan = begin(tmp_path / "s.scanning", world, watch=watch, passes="patch only")
    with pytest.raises(Refusal, match="was not seen at 5 positions in a row"):
        scan.run()
    assert len(visits(journal, "patch")) == 15


def test_a_patch_that_is_not_taken_off_is_noticed(tmp_path):
    world = World()
    _, scan = begin(tmp_path / "s.scanning", world, holder=FakeHolder(world, obeys=False))
    with pytest.raises(Refusal, match="still seen at cell 0, expected it gone"):
        scan.run()


def test_a_patch_that_is_not_there_at_the_start_is_noticed_before_anything_is_scanned(tmp_path):
    world = World()
    world.scene.patch = False
    journal, scan = begin(tmp_path / "s.scanning", world, holder=FakeHolder(world, obeys=False), surveyed=False)
    with pytest.raises(Refusal, match=r"before the scan, .*patch"):
        scan.run()
    assert journal.count() == 0

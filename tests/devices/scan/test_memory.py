"""Twenty thousand samples take no more memory than two thousand."""

import json

import numpy as np
import psutil
import pytest

from calibrate.rig import LidarSetup
from devices.scan.export import export
from devices.scan.journal import Journal
from devices.scan.runner import Scan
from tests.devices.scan.fakes import FakeHolder, World, known_survey, lens, station

GRID = (200, 100)
LEARNT, MOST_MB = 2000, 25


@pytest.mark.slow
def test_memory_stays_flat_over_20000_samples(tmp_path):
    world, seen = World(), {}
    plan = world.scene.plan(*GRID, passes="patch only", monitor_every=1000)
    picture = world.scene.picture(plan.poses(np.array([plan.middle]))[0])
    counts = world.scene.counts(plan.poses(np.array([plan.middle]))[0], 400)
    world.scene.picture = lambda pose: picture
    world.scene.counts = lambda pose, kilo: counts
    journal = Journal(tmp_path / "s.scanning")
    journal.say("survey", known_survey(*GRID))
    for name, value in {"plan": plan, "rig": world.scene.rig(LidarSetup())}.items():
        journal.say(name, json.loads(value.text()))
    journal.say("camera", {"intrinsics": lens(world)})
    process = psutil.Process()

    def watch(at):
        if at.done % LEARNT == 0:
            seen[at.done] = process.memory_info().rss / 2**20

    scan = Scan(plan, station(world), FakeHolder(world), journal, zone_grid=(3, 3), watch=watch)
    # One picture for all: the patch is where it is expected only in the middle.
    scan._expect_seen = lambda cell, patch: None
    scan._expect_patch = lambda there, cell, found: None
    scan.run()
    assert len(seen) == 10
    assert seen[20000] - seen[LEARNT] < MOST_MB, seen
    before = process.memory_info().rss / 2**20
    export(journal, tmp_path / "s.rrd")
    print(
        f"\nresident MB by samples: {seen}; export of 20000 frames: {process.memory_info().rss / 2**20 - before:.0f} MB"
    )

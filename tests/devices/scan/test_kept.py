"""Devices that go away and come back."""

import pytest

from devices.captures import DeviceLost
from devices.scan.kept import Kept
from recordings.refusal import Refusal


class Flaky:
    """Lost at the calls in `at`; counts in `of`, which outlives it."""

    def __init__(self, of, at):
        self.of, self.at = of, at

    def work(self):
        self.of["calls"] += 1
        if self.of["calls"] in self.at:
            raise DeviceLost("gone")
        return self.of["calls"]

    def close(self):
        self.of["closed"] += 1


def kept(at=(), away=0, patience_s=60.0):
    """What opens it refuses `away` times after the first opening."""
    of, said = {"calls": 0, "closed": 0, "opened": 0, "away": 0}, []

    def opener():
        of["opened"] += 1
        if of["opened"] > 1 and of["away"] < away:
            of["away"] += 1
            raise Refusal("no such port")
        return Flaky(of, at)

    return Kept("LiDAR", opener, said.append, patience_s=patience_s, again_s=0), of, said


def test_it_is_opened_once_and_when_it_is_needed():
    device, of, _ = kept()
    assert of["opened"] == 0
    assert [device.use(Flaky.work) for _ in range(3)] == [1, 2, 3]
    assert of["opened"] == 1


def test_lost_in_the_midst_of_work_it_is_opened_again_and_the_work_done_again():
    device, of, said = kept(at={2, 3}, away=2)
    assert device.use(Flaky.work) == 1
    assert device.use(Flaky.work) == 4
    assert (device.lost, of["closed"], of["away"]) == (2, 2, 2)
    assert said == [
        "LiDAR: gone; waiting for it to come back",
        "LiDAR: is back",
        "LiDAR: gone; waiting for it to come back",
        "LiDAR: is back",
    ]


def test_patience_ends():
    device, _, _ = kept(at={1}, away=10**6, patience_s=0)
    with pytest.raises(Refusal, match="LiDAR: did not come back within 0 s: no such port"):
        device.use(Flaky.work)


def test_what_cannot_be_opened_at_first_is_refused_at_once():
    def nothing_there():
        raise Refusal("no sensor")

    with pytest.raises(Refusal, match="no sensor"):
        Kept("LiDAR", nothing_there, again_s=0).use(Flaky.work)


def test_lost_while_it_is_opened_it_is_tried_again_a_few_times():
    fails = iter([True, True, False])
    of = {"calls": 0, "closed": 0}

    def opener():
        if next(fails, True):
            raise DeviceLost("an answer was lost")
        return Flaky(of, ())

    assert Kept("LiDAR", opener, again_s=0).use(Flaky.work) == 1
    with pytest.raises(Refusal, match="LiDAR: an answer was lost; tried 4 times"):
        Kept("LiDAR", opener, again_s=0).use(Flaky.work)

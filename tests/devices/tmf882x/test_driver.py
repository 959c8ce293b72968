"""The driver against the emulated firmware at a pseudo-terminal: what it measures is what the sensor saw."""

import time

import numpy as np
import pytest

from devices.captures import DeviceLost
from devices.emulated.tmf882x.chip import Chip
from devices.emulated.tmf882x.faults import Faults
from devices.emulated.tmf882x.firmware import Firmware
from devices.emulated.tmf882x.free_running import USUAL, FreeRunning
from devices.tmf882x import connection, dialogue, reader
from devices.tmf882x.calibration_page import load_pages, save_pages
from devices.tmf882x.driver import open_tmf882x
from recordings.refusal import Refusal

SHAPES = {"3x3": (9, 1), "4x4": (16, 2), "8x8": (64, 8)}
# Zones of channels 1 to 8 in both bursts of the first sub-capture of 8 x 8, as ams' table has them.
FIRST_CAPTURE = [[56, 60, 40, 44, 24, 28, 8, 12], [57, 61, 41, 45, 25, 29, 9, 13]]
BACK_S = 60.0


class Scene:
    """Counts that tell when they were seen, by a pulse whose height grows with `epoch`; `asked_s` is when, seconds."""

    def __init__(self):
        self.epoch, self.asked_s = 0, []

    def __call__(self, setting):
        self.asked_s.append(time.time())
        shape = np.exp(-0.5 * ((np.arange(128) - 40) / 2.0) ** 2)
        heights = 100 * (1 + np.arange(setting.sets * 10)).reshape(setting.sets, 10, 1) + self.epoch
        self.last = np.rint(heights * shape).astype(np.uint32)
        return self.last


@pytest.mark.parametrize("mode", ["3x3", "4x4", "8x8"])
@pytest.mark.parametrize("ranging", ["long", "short"])
def test_what_is_measured_is_what_was_seen(port, mode, ranging):
    scene = Scene()
    port.plug(source=scene)
    with open_tmf882x(port.setup(mode=mode, ranging=ranging)) as lidar:
        one = lidar.measure()
        seen = scene.last
    zones, bursts = SHAPES[mode]
    assert one.counts.shape == (zones, 128)
    np.testing.assert_array_equal(one.reference, seen[:, 0])
    assert one.reference.shape == (bursts, 128)
    if mode == "3x3":
        np.testing.assert_array_equal(one.counts, seen[0, 1:])
    elif mode == "4x4":
        np.testing.assert_array_equal(one.counts, seen[:, 1:9].reshape(16, 128))
    else:
        np.testing.assert_array_equal(one.counts[FIRST_CAPTURE], seen[:2, 1:9])
    assert one.distance_mm.shape == one.confidence.shape == (zones, 2)
    assert lidar.said["mode"] == mode
    assert lidar.said["ranging"] == ranging
    assert lidar.said["spad_map_id"] == {"3x3": 6, "4x4": 7, "8x8": 15}[mode]


def test_every_measurement_was_taken_after_it_was_asked_for(port):
    scene = Scene()
    port.plug(source=scene)
    with open_tmf882x(port.setup()) as lidar:
        for epoch in range(1, 20):
            scene.epoch = epoch
            assert lidar.measure().counts[0, 40] == 200 + epoch


def test_free_running_firmware_is_waited_for(port):
    """The measurement must have begun after the call: asked for at its end, it took its burst before."""
    scene = Scene()
    port.plug(FreeRunning(scene, np.random.default_rng(0)), speed=2)
    with open_tmf882x(port.setup(baud=1_000_000, ranging="short")) as lidar:
        for epoch in range(1, 4):
            scene.epoch, called_s, before = epoch, time.time(), len(scene.asked_s)
            one = lidar.measure()
            assert one.counts[0, 40] == 200 + epoch
            ended = [asked for asked in scene.asked_s[before:] if asked < one.host_s]
            assert max(ended) - USUAL.burst_s / 2 >= called_s
        numbers = [one.number for one, _ in zip(lidar.frames(), range(4), strict=False)]
        assert numbers == list(range(numbers[0], numbers[0] + 4))
        assert lidar.said["firmware"].startswith("free-running")


def test_the_second_setting_of_the_larger_sensor(port):
    port.plug()
    with open_tmf882x(port.setup(mode="8x8", kilo_iterations=2500)) as lidar:
        assert (lidar.said["kilo_iterations"], lidar.said["period_ms"]) == (2500, 264)


def test_a_sensor_that_measures_already_is_taken_over(port):
    terminal = port.plug()
    with open_tmf882x(port.setup()) as lidar:
        stream = lidar.frames()
        next(stream)
        # Let go without a stop, as a process that was killed.
        lidar._attached.close()
    with open_tmf882x(port.setup(mode="4x4")) as lidar:
        assert lidar.measure().counts.shape == (16, 128)
    assert terminal.failure is None


def test_a_stream_goes_on_and_can_be_left(port):
    port.plug()
    with open_tmf882x(port.setup()) as lidar:
        numbers = [one.number for one, _ in zip(lidar.frames(), range(5), strict=False)]
        assert numbers == [0, 1, 2, 3, 4]
        later = lidar.measure()
        assert later.number > 4
        assert later.temperature_c == 31


def test_a_stream_that_still_runs_spoils_no_measurement(port):
    scene = Scene()
    port.plug(source=scene)
    with open_tmf882x(port.setup()) as lidar:
        stream = lidar.frames()
        for epoch in range(1, 5):
            next(stream)
            scene.epoch = epoch
            assert lidar.measure().counts[0, 40] == 200 + epoch
            assert next(stream).counts[0, 40] == 200 + epoch


def test_nothing_is_lost_while_nobody_listens(port):
    """The consumer stalls for many measurements; each that waited is whole and in order."""
    scene = Scene()
    port.plug(source=scene)
    with open_tmf882x(port.setup()) as lidar:
        stream = lidar.frames()
        first = next(stream)
        until = len(scene.asked_s) + 40
        deadline = time.monotonic() + 60
        while len(scene.asked_s) < until:
            assert time.monotonic() < deadline
        numbers = [next(stream).number for _ in range(40)]
        assert numbers == list(range(first.number + 1, first.number + 41))
        assert lidar.said["lost"]["dropped"] == 0


def test_lost_and_garbled_lines_cost_measurements_but_spoil_none(port):
    scene = Scene()
    port.plug(source=scene, faults=Faults(lose=0.006, garble=0.006))
    with open_tmf882x(port.setup(), reconnect_s=BACK_S) as lidar:
        numbers = []
        for epoch in range(1, 30):
            scene.epoch = epoch
            one = lidar.measure()
            np.testing.assert_array_equal(one.counts[:, 40], 100 * np.arange(2, 11) + epoch)
            numbers.append(one.number)
        lost = lidar.said["lost"]
        assert lost["dropped"] > 0
        assert numbers == sorted(set(numbers))
        assert 29 < numbers[-1] + 1 <= len(scene.asked_s)


def test_a_pulled_cable_is_a_lost_device(port):
    terminal = port.plug()
    with open_tmf882x(port.setup()) as lidar:
        lidar.measure()
        terminal.unplug()
        with pytest.raises(DeviceLost, match="went away"):
            list(lidar.frames())
        with pytest.raises(DeviceLost, match="did not come back within 0 s"):
            lidar.reopen(0.0)
        terminal.plug_in()
        lidar.reopen(BACK_S)
        assert lidar.measure().counts.shape == (9, 128)
        assert lidar.said["lost"]["reconnects"] == 1


def test_a_cable_that_is_pulled_again_and_again_only_takes_time(port):
    port.plug(faults=Faults(unplug_at=(2, 5, 6), back_after_s=50.0, stall_at=(4,), stall_s=20.0))
    told = []
    with open_tmf882x(port.setup(mode="4x4", ranging="short"), reconnect_s=BACK_S, progress=told.append) as lidar:
        numbers = [lidar.measure().number for _ in range(10)]
        assert numbers == sorted(set(numbers))
        assert lidar.said["lost"]["reconnects"] == 3
        assert (lidar.said["mode"], lidar.said["ranging"]) == ("4x4", "short")
    assert sum("waiting for it to come back" in sentence for sentence in told) == 3


def test_a_stream_survives_a_pulled_cable(port):
    port.plug(faults=Faults(unplug_at=(3,), back_after_s=50.0))
    with open_tmf882x(port.setup(), reconnect_s=BACK_S) as lidar:
        assert len([one for one, _ in zip(lidar.frames(), range(8), strict=False)]) == 8
        assert lidar.said["lost"]["reconnects"] == 1


def test_another_sensor_is_not_taken_for_the_one_that_was_there(port):
    terminal = port.plug()
    with open_tmf882x(port.setup()) as lidar:
        terminal.close()
        port.plug(Firmware(None, np.random.default_rng(0), Chip(serial=0x1234)))
        with pytest.raises(Refusal, match="serial was 0x8A4C21, is 0x1234"):
            lidar.reopen(BACK_S)


def test_factory_calibration_is_run_saved_and_given(port, tmp_path):
    port.plug()
    path = tmp_path / "page.c"
    with open_tmf882x(port.setup()) as lidar:
        assert lidar.said["factory_calibration"]["zone_zero_bins"] is None
        next(stream := lidar.frames())
        pages = lidar.calibrate_factory(path)
        said = lidar.said["factory_calibration"]
        np.testing.assert_allclose(said["zone_zero_bins"], pages[0].zero_bins[0, 1:])
        next(stream)
        assert [page.content for page in load_pages(path)] == [page.content for page in pages]
        assert pages[0].calibrated
        lidar.measure()
        stored = lidar.load_factory_calibration()
        assert stored[0].content != pages[0].content
    with open_tmf882x(port.setup(factory_calibration=str(path))) as lidar:
        said = lidar.said["factory_calibration"]
        # What the firmware was compiled with is another one: it cannot be sent.
        assert said["on_chip"] is False
        np.testing.assert_allclose(said["zone_zero_bins"], pages[0].zero_bins[0, 1:])
    with pytest.raises(Refusal, match="page 0 is of long range"):
        open_tmf882x(port.setup(factory_calibration=str(path), ranging="short"))


def test_a_calibration_that_the_firmware_holds_is_on_the_chip(port, tmp_path):
    port.plug()
    path = tmp_path / "page.c"
    with open_tmf882x(port.setup()) as lidar:
        save_pages(lidar.load_factory_calibration(), path)
    with open_tmf882x(port.setup(factory_calibration=str(path))) as lidar:
        assert lidar.said["factory_calibration"]["on_chip"] is True


class Hiccup(Firmware):
    """Once, in the middle of a measurement, the sensor has no data, and the firmware stops."""

    done = False

    def take(self, now):
        out = super().take(now)
        at = next((at for at, line in enumerate(out) if line.startswith(b"#Raw,65,12,")), None)
        if not self.done and at is not None:
            self.done = True
            del out[at + 1 :]
            self.measuring.stop()
            self.out.clear(now)
            self.state = "stopped"
            self.say(["#Err,inter,4,but no data"])
        return out


def test_a_measurement_that_the_firmware_gives_up_is_begun_again(port):
    port.plug(Hiccup(None, np.random.default_rng(0)), speed=20)
    told = []
    with open_tmf882x(port.setup(), progress=told.append) as lidar:
        assert lidar.measure().counts.shape == (9, 128)
        assert lidar.said["lost"]["errors"] == 1
    assert told == ["the LiDAR reports #Err,inter,4,but no data"]


def test_a_sensor_that_falls_silent_is_lost(port, monkeypatch):
    monkeypatch.setattr(connection, "SPARE_S", 0.1)
    monkeypatch.setattr(dialogue, "PATIENCE_S", 0.2)
    port.plug(faults=Faults(stall_at=(1,), stall_s=float("inf")))
    with open_tmf882x(port.setup()) as lidar, pytest.raises(DeviceLost, match="nothing came from the LiDAR for 2"):
        for _ in lidar.frames():
            pass


def test_what_waits_is_bounded_and_what_does_not_fit_is_counted(port, monkeypatch):
    monkeypatch.setattr(reader, "MOST_FRAMES", 5)
    scene = Scene()
    port.plug(source=scene)
    with open_tmf882x(port.setup()) as lidar:
        stream = lidar.frames()
        next(stream)
        deadline = time.monotonic() + 60
        while lidar.said["lost"]["overrun"] < 10:
            assert time.monotonic() < deadline
        numbers = [next(stream).number for _ in range(4)]
        assert numbers[0] > 10
        assert numbers[-1] - numbers[0] >= 3


class Terse(Firmware):
    """A firmware whose sensor shows neither its range mode nor a page of calibration."""

    def say(self, lines, after=0.0):
        super().say([line.replace("0x6F", "0x0") for line in lines if "calib_" not in line], after)


def test_what_is_not_said_is_not_needed_to_measure(port):
    port.plug(Terse(None, np.random.default_rng(0)))
    with open_tmf882x(port.setup()) as lidar:
        assert lidar.measure().counts.shape == (9, 128)
        assert lidar.said["ranging_is"] == "assumed"
        assert lidar.said["factory_calibration"]["pages"] == []


def test_a_sensor_that_stays_in_the_other_range_is_refused(port):
    class Stuck(Firmware):
        def say(self, lines, after=0.0):
            super().say([line.replace("0x6F", "0x6E") for line in lines], after)

    port.plug(Stuck(None, np.random.default_rng(0)))
    with pytest.raises(Refusal, match=r"lidar.ranging is 'long', but this sensor stays in short range"):
        open_tmf882x(port.setup())


def test_a_mistake_of_ours_is_not_taken_for_a_lost_sensor(port, monkeypatch):
    class Wrong(Exception):
        pass

    def broken(self, line, host_s):
        raise Wrong("in the assembler")

    port.plug()
    lidar = open_tmf882x(port.setup())
    monkeypatch.setattr("recordings.importers.tmf882x.assemble.Assembler.push", broken)
    with pytest.raises(Wrong):
        lidar.measure()
    with pytest.raises(Wrong):
        lidar.close()
    monkeypatch.undo()
    # The port was let go of all the same.
    with open_tmf882x(port.setup()) as lidar:
        assert lidar.measure().counts.shape == (9, 128)

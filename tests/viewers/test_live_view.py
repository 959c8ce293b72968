import numpy as np
import pytest
import rerun as rr
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.refusal import Refusal
from viewers.live_view import MOST_WAITING, LiveView
from viewers.session_frame import SessionFrame, SessionRig
from viewers.session_panels import upright

from .fusion_frames import BINS, ZONES, frame, rig


class Counting:
    """Stands in for a recording: keeps how often each entity was logged."""

    def __init__(self):
        self.logged, self.sent = {}, {}

    def log(self, entity, what, *, static=False, strict=False):
        assert strict
        if not static:
            self.logged[entity] = self.logged.get(entity, 0) + 1

    def send_columns(self, entity, indexes, columns, strict=False):
        assert strict
        rows = len(indexes[0].as_arrow_array())
        self.sent[entity] = self.sent.get(entity, 0) + rows

    def set_time(self, *_, **__):
        pass

    def set_log_time_enabled(self, on):
        assert not on

    def set_log_tick_enabled(self, on):
        assert not on

    def flush(self):
        pass


def shown(frames, **options):
    recording = Counting()
    view = LiveView(rig(), recording, **options)
    for one in frames:
        view.push(one)
    view.close()
    return recording


def test_pictures_come_ten_times_a_second_at_most_and_histograms_always():
    recording = shown(frame(i, rate_hz=60.0) for i in range(61))
    assert recording.sent["lidar/zone/0_0"] == 61
    assert recording.logged["fused/depth"] == 11
    assert recording.logged["world/rig/camera/rgb"] == 11
    assert shown(frame(i, rate_hz=2.0) for i in range(5)).logged["world/cloud"] == 5


def test_a_clock_set_back_does_not_stop_the_pictures():
    early = [frame(i, rate_hz=10.0) for i in range(3)]
    late = [frame(i + 1000, rate_hz=10.0) for i in range(3)]
    assert shown([*late, *early]).logged["fused/depth"] == 6


@pytest.mark.parametrize("missing", ["counts", "surface_m", "surface_share", "fused", "cloud", "expected"])
def test_what_a_frame_lacks_is_left_out(missing):
    recording = shown([frame(0), frame(1, **{missing: None}), frame(2)])
    assert recording.logged["recorded_depth"] == 3
    if missing == "counts":
        assert recording.sent["lidar/zone/0_0"] == 2


def test_a_robot_without_camera_and_maps_sees_its_histograms():
    recording = Counting()
    bare = SessionRig((2, 3), rig().range_m, None)
    view = LiveView(bare, recording)
    view.push(SessionFrame(0.0, np.zeros((ZONES, BINS), np.uint32)))
    view.close()
    assert recording.sent == {f"lidar/zone/{r}_{c}": 1 for r in range(2) for c in range(3)}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"timestamp_s": np.nan}, "timestamp_s is nan"),
        ({"counts": np.zeros((ZONES, BINS + 1))}, r"counts has shape \(6, 41\), expected \(6, 40\)"),
        ({"expected": np.zeros(3)}, r"expected has shape \(3,\)"),
        ({"surface_m": np.zeros((2, 1))}, "surface_m has shape .*each of 6 zones"),
    ],
)
def test_a_frame_that_does_not_fit_is_refused_and_the_next_is_shown(changes, sentence):
    recording = Counting()
    view = LiveView(rig(), recording)
    with pytest.raises(Refusal, match=sentence):
        view.push(SessionFrame(**{"timestamp_s": 0.0, **changes}))
    view.push(frame(0))
    view.close()
    assert recording.sent["lidar/zone/0_0"] == 1


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=80), st.booleans())
def test_no_more_waits_than_a_few_frames_whatever_the_clock_says(times, prompt):
    recording = Counting()
    view = LiveView(rig(), recording, prompt=prompt)
    for i, time_s in enumerate(times):
        view.push(SessionFrame(time_s, np.zeros((ZONES, BINS), np.uint32)))
        assert i + 1 - recording.sent.get("lidar/zone/0_0", 0) < MOST_WAITING
    view.close()
    assert recording.sent["lidar/zone/0_0"] == len(times)


def test_a_rig_of_other_zones_is_refused():
    with pytest.raises(Refusal, match="range_m has shape"):
        rig(range_m=np.zeros((5, BINS)))
    with pytest.raises(Refusal, match="footprints has shape"):
        rig(footprints=np.zeros((6, 4)))


@pytest.mark.parametrize(
    ("up", "name"), [((0, -1, 0), "Y_DOWN"), ((0, 1, 0.2), "Y_UP"), ((0.1, 0, 1), "Z_UP"), ((-1, 0, 0), "X_DOWN")]
)
def test_the_world_stands_as_the_camera_sees_it(up, name):
    pose = np.eye(4)
    # The image's y axis points down.
    pose[:3, 1] = -np.array(up)
    wanted = getattr(rr.ViewCoordinates, f"RIGHT_HAND_{name}")
    found, expected = (
        coordinates.as_component_batches()[0].as_arrow_array().to_pylist() for coordinates in (upright(pose), wanted)
    )
    assert found == expected


def test_arrays_may_be_used_again_after_a_push():
    recording = rr.RecordingStream("test")
    memory = recording.memory_recording()
    view = LiveView(rig(), recording, prompt=False)
    counts = np.ones((ZONES, BINS), np.uint32)
    view.push(SessionFrame(0.0, counts))
    counts[:] = 7
    assert (view._waiting[0].counts == 1).all()
    view.close()
    assert memory.num_msgs() > 0

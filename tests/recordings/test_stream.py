import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.encoded import EncodedFrames, encode
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.stream import Stream


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_a_recording_comes_back_from_its_frames(recordings_of_any_kind, same, data):
    recording = Recording(**data.draw(recordings_of_any_kind))
    passing = Stream.of(recording)
    assert passing.count == len(recording.counts)
    same(recording, passing.collect())


def test_frames_carry_what_varies_and_the_rest_is_static(make):
    passing = Stream.of(make(still=("rgb", "laser_cycles")))
    frame = next(passing.frames)
    assert {"counts", "timestamp_s", "depth_m", "camera_pose", "patch_px"} <= frame.keys()
    assert {"rgb", "laser_cycles", "intrinsics", "meta_json"} <= passing.static.keys()
    assert frame["counts"].shape == (6, 8)
    assert frame["timestamp_s"].shape == ()


def test_encoded_frames_stay_bytes(make, jpeg):
    blobs = [jpeg(image) for image in make().rgb]
    recording = make()
    object.__setattr__(recording, "rgb", EncodedFrames.of(blobs))
    collected = Stream.of(recording).collect()
    assert [collected.rgb.encoded(i) for i in range(5)] == blobs


def test_arrays_among_encoded_frames_are_encoded_without_loss(make):
    recording = make()
    passing = Stream.of(recording)
    mixed = ({**f, "rgb": encode(f["rgb"]) if i % 2 else f["rgb"]} for i, f in enumerate(passing.frames))
    assert Stream(passing.static, mixed).collect().rgb == recording.rgb


def test_a_static_image_may_be_encoded(make, jpeg):
    recording = make(still=("rgb",))
    passing = Stream.of(recording)
    collected = Stream({**passing.static, "rgb": encode(recording.rgb)}, passing.frames).collect()
    assert np.array_equal(collected.rgb, recording.rgb)


def spoilt(make, change, static=None):
    passing = Stream.of(make())
    frames = [{**frame, **(change if i == 2 else {})} for i, frame in enumerate(passing.frames)]
    frames = [{name: value for name, value in frame.items() if value is not None} for frame in frames]
    return Stream({**passing.static, **(static or {})}, iter(frames), 5)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"timestamp_s": 0.0}, "timestamp_s[2] is 0.0 after"),
        ({"timestamp_s": np.nan}, "timestamp_s[2] is nan"),
        ({"counts": np.zeros((6, 9), "u4")}, "counts has shape (6, 9), expected (P, T)"),
        ({"counts": np.zeros((6, 8), "u2")}, "counts[2] holds uint16, expected uint32 as in the frames before"),
        ({"counts": np.full((6, 8), -1)}, "counts[2, 0, 0] is -1"),
        ({"depth_m": np.full((4, 6), -1.0)}, "depth_m[2, 0, 0] is -1.0"),
        ({"camera_pose": 2 * np.eye(4)}, "camera_pose[2]"),
        ({"rgb": b"no image"}, "rgb[2] is not an image"),
        ({"rgb": None}, "frame 2 lacks rgb"),
        ({"irf": np.ones(3)}, "frame 2 has irf"),
        ({"colour": 3}, "colour is no field of a recording"),
    ],
)
def test_a_frame_that_breaks_the_format_is_refused_by_its_number(make, change, sentence):
    with pytest.raises(Refusal) as refused:
        list(spoilt(make, change).checked())
    assert sentence in str(refused.value)


@pytest.mark.parametrize(
    ("static", "sentence"),
    [
        ({"bin_width_s": None}, "bin_width_s is missing"),
        ({"bin_width_s": -1.0}, "bin_width_s is -1.0"),
        ({"timestamp_s": 1.0}, "timestamp_s is given once, expected one for every frame"),
        ({"depth_m": np.zeros((4, 6))}, "depth_m must be in the static part"),
        ({"image_size": [8, 8]}, "expected (H, W)"),
        ({"zone_grid": [2, 2]}, "zone_grid is 2 x 2, expected a product of 6"),
        ({"meta_json": "no"}, "meta_json is not JSON"),
        ({"colour": 3}, "colour is no field"),
    ],
)
def test_a_static_part_that_breaks_the_format_is_refused(make, static, sentence):
    with pytest.raises(Refusal) as refused:
        list(spoilt(make, {}, static).checked())
    assert sentence in str(refused.value)


def test_a_stream_without_frames_is_refused(make):
    with pytest.raises(Refusal, match="no frame"):
        Stream(Stream.of(make()).static, iter([])).collect()


def test_frames_must_have_counts(make):
    passing = Stream.of(make())
    with pytest.raises(Refusal, match="counts must be in the frames"):
        list(Stream(passing.static, ({"timestamp_s": 1.0} for _ in range(2))).checked())

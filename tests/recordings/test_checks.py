import json

import numpy as np
import pytest

from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal


def changed(value, index, to):
    value = np.array(value)
    value[index] = to
    return value


def turned(pose):
    return pose @ np.diag([1.0, 1.0, -1.0, 1.0])


BROKEN = {
    "float counts": ("counts", lambda v: v.astype(float), "counts holds float64, expected integers"),
    "bool counts": ("counts", lambda v: v > 2, "counts holds bool, expected integers"),
    "text counts": ("counts", lambda v: v.astype(str), "counts holds str"),
    "object counts": ("counts", lambda v: v.astype(object), "counts holds object"),
    "ragged counts": ("counts", lambda v: [[[1]], [[1, 2]]], "counts is not an array of equal rows"),
    "negative count": (
        "counts",
        lambda v: changed((v % 9).astype(int), (3, 1, 2), -7),
        "counts[3, 1, 2] is -7, expected a count of 0 or more",
    ),
    "flat counts": ("counts", lambda v: v[0], "counts has shape (6, 8), expected (F, P, T)"),
    "no frame": ("counts", lambda v: v[:0], "counts has shape (0, 6, 8)"),
    "no counts": ("counts", lambda v: None, "counts is missing"),
    "zones": ("zone_grid", lambda v: v + 1, "zone_grid is 3 x 4, expected a product of 6, the number of zones"),
    "no zone": ("zone_grid", lambda v: v * 0, "zone_grid[0] is 0"),
    "zones as floats": ("zone_grid", lambda v: v.astype(float), "zone_grid holds float64, expected integers"),
    "no width": ("bin_width_s", lambda v: 0.0, "bin_width_s is 0.0, expected positive"),
    "negative width": ("bin_width_s", lambda v: -v, "bin_width_s is -"),
    "infinite width": ("bin_width_s", lambda v: np.inf, "bin_width_s is inf"),
    "two widths": ("bin_width_s", lambda v: [v, v], "bin_width_s has shape (2,), expected ()"),
    "zero of other zones": ("time_zero_s", lambda v: np.zeros(5), "has shape (5,), expected () or (P,), P=6"),
    "time zero": ("time_zero_s", lambda v: np.nan, "time_zero_s is nan"),
    "time back": (
        "timestamp_s",
        lambda v: changed(v, 3, v[1]),
        "timestamp_s[3] is {0[1]} after {0[2]}, expected strictly increasing",
    ),
    "time stands": ("timestamp_s", lambda v: changed(v, 2, v[1]), "timestamp_s[2] is"),
    "time nan": ("timestamp_s", lambda v: changed(v, 4, np.nan), "timestamp_s[4] is nan"),
    "unsigned time back": ("timestamp_s", lambda v: np.array([9, 8, 10, 11, 12], "u1"), "timestamp_s[1] is 8 after 9"),
    "times short": ("timestamp_s", lambda v: v[:-1], "timestamp_s has shape (4,), expected (F,), F=5"),
    "no shots": ("laser_cycles", lambda v: changed(v, 1, 0), "laser_cycles[1] is 0, expected a positive"),
    "half a response": ("irf", lambda v: None, "irf_time_s is there but irf is missing"),
    "other half": ("irf_time_s", lambda v: None, "irf is there but irf_time_s is missing"),
    "sum": ("irf", lambda v: v * 1.01, "irf sums to 1.01, expected 1"),
    "negative probability": ("irf", lambda v: changed(v, 2, -0.1), "irf[2] is -0.1"),
    "coarse response": ("irf_time_s", lambda v: v * 1e3, "expected finer than a bin"),
    "uneven response": ("irf_time_s", lambda v: v + np.where(np.arange(7) > 4, 1e-11, 0), "at index 4, expected even"),
    "response back": ("irf_time_s", lambda v: v[::-1], "irf_time_s[1] is"),
    "background": ("background_counts", lambda v: changed(v, 5, -1), "background_counts[5] is -1.0"),
    "depth in millimetres": ("depth_m", lambda v: (np.nan_to_num(v) * 1000).astype("u2"), "depth_m holds uint16"),
    "depth behind": ("depth_m", lambda v: changed(v, (2, 1, 3), -0.5), "depth_m[2, 1, 3] is -0.5"),
    "depth without end": ("depth_m", lambda v: changed(v, (0, 0, 0), np.inf), "depth_m[0, 0, 0] is inf"),
    "depth of other frames": ("depth_m", lambda v: v[:3], "depth_m has shape (3, 4, 6)"),
    "bright": ("reflectance", lambda v: changed(v, (1, 1, 1), 1.5), "reflectance[1, 1, 1] is 1.5, expected 0 to 1"),
    "steep": ("incidence_cosine", lambda v: changed(v, (1, 1, 1), -1.5), "incidence_cosine[1, 1, 1] is -1.5"),
    "grid": ("reflectance", lambda v: v[:, :, :5], "reflectance has shape (5, 4, 5), expected (F, H, W)"),
    "rgb type": ("rgb", lambda v: v.astype(float) / 255, "rgb holds float64, expected uint8"),
    "rgb alpha": ("rgb", lambda v: np.zeros((5, 4, 6, 4), "u1"), "rgb has shape (5, 4, 6, 4)"),
    "rgb other size": ("rgb", lambda v: v[:, :3], "rgb has shape (5, 3, 6, 3)"),
    "intrinsics shape": ("intrinsics", lambda v: v[:2], "intrinsics has shape (2, 3)"),
    "focal length": ("intrinsics", lambda v: changed(v, (1, 1), 0), "intrinsics[1, 1] is 0.0, expected a positive"),
    "no pinhole": ("intrinsics", lambda v: v.T, "intrinsics is not a pinhole matrix"),
    "size swapped": ("image_size", lambda v: v[::-1], "image_size is 4 x 6, expected 6 x 4"),
    "scaled": ("lidar_from_camera", lambda v: v * 1.01, "lidar_from_camera has rows that are not orthonormal"),
    "mirror": ("lidar_from_camera", turned, "lidar_from_camera mirrors"),
    "bottom row": ("lidar_from_camera", lambda v: changed(v, 3, 0), "has the last row (0.0, 0.0, 0.0, 0.0)"),
    "huge rotation": ("lidar_from_camera", lambda v: v * 1e300, "orthonormal"),
    "pose": ("camera_pose", lambda v: changed(v, 3, turned(v[3])), "camera_pose[3] mirrors"),
    "pose nan": ("camera_pose", lambda v: changed(v, (2, 0, 3), np.nan), "camera_pose[2, 0, 3] is nan"),
    "patch": ("patch_px", lambda v: changed(v, (4, 1), np.inf), "patch_px[4, 1] is inf"),
    "meta": ("meta_json", lambda v: "[1, 2]", "meta_json holds a JSON list, expected a JSON object"),
    "no json": ("meta_json", lambda v: "{", "meta_json is not JSON text"),
    "deep json": ("meta_json", lambda v: "[" * 10**5, "meta_json is not JSON text"),
    "half a character": ("meta_json", lambda v: '{"a": "\ud800"}', "meta_json is not JSON text"),
    "meta of another type": ("meta_json", lambda v: {"a": 1}, "meta_json is dict, expected JSON text"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_rule_is_refused_with_its_place(fields, case):
    name, breaks, sentence = BROKEN[case]
    good = fields()
    with pytest.raises(Refusal) as refused:
        Recording(**{**good, name: breaks(good[name])})
    assert sentence.format(good[name]) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("patch_px", np.full((5, 2), np.nan)),
        ("depth_m", np.full((4, 6), np.nan, "f4")),
        ("reflectance", np.ones((5, 4, 6), "f4")),
        ("timestamp_s", np.arange(5)),
        ("laser_cycles", 537_000),
        ("counts", [[[0] * 8] * 6] * 5),
        ("irf", np.full(7, 1 / 7, "f4")),
        ("camera_pose", np.round(np.tile(np.eye(4), (5, 1, 1)), 4).astype("f4")),
        ("background_counts", np.zeros(6, int)),
        ("time_zero_s", -1e-9),
        ("intrinsics", None),
    ],
)
def test_what_the_format_allows_is_accepted(fields, name, value):
    Recording(**{**fields(), name: value})


@pytest.mark.parametrize("kind", ["u1", "u2", "u4", "u8"])
def test_counts_keep_their_type(make, kind):
    assert make(counts_type=kind).counts.dtype == kind


def test_signed_counts_become_unsigned_of_the_same_width_and_values(fields):
    counts = np.arange(240, dtype=np.int16).reshape(5, 6, 8)
    kept = Recording(**{**fields(), "counts": counts}).counts
    assert kept.dtype == np.uint16
    assert np.array_equal(kept, counts)


def test_byte_order_is_the_machine_s(fields):
    depth = fields()["depth_m"]
    kept = Recording(**{**fields(), "depth_m": depth.astype(">f8")}).depth_m
    assert kept.dtype.isnative
    assert np.array_equal(kept, depth, equal_nan=True)


MAPS = {
    "responses": np.arange(24, dtype="f4").reshape(2, 3, 4),
    "xs": np.arange(4.0),
    "ys": np.arange(4.0),
    "cap_ids": np.array(["0001", "0002", "0003", "0004"]),
    "meta_json": json.dumps({"image_size": [640, 480]}),
    "sigma": np.ones((2, 3, 4)),
    "flags": np.zeros((2, 3, 4), "u1"),
    "position_sigma_px": np.ones(4),
    "position_confidence": np.ones(4),
}


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("responses", changed(MAPS["responses"], (1, 2, 3), np.nan), "responses[1, 2, 3] is nan"),
        ("responses", -MAPS["responses"], "responses[0, 0, 1] is -1.0"),
        ("responses", MAPS["responses"][0], "responses has shape (3, 4), expected (R, C, K)"),
        ("xs", np.arange(5.0), "xs has shape (5,), expected (K,), K=4"),
        ("ys", None, "ys is missing"),
        ("cap_ids", np.arange(4), "cap_ids holds int64"),
        ("cap_ids", np.array(["a"]), "expected text of shape (4,)"),
        ("sigma", np.ones((2, 3)), "sigma has shape (2, 3)"),
        ("flags", np.zeros((2, 3, 4)), "flags holds float64, expected uint8"),
        ("position_sigma_px", -np.ones(4), "position_sigma_px[0] is -1.0"),
        ("meta_json", "3", "meta_json holds a JSON int"),
        ("meta_json", '{"image_size": [0, 480]}', "image_size [0, 480]"),
        ("meta_json", '{"image_size": "848"}', "image_size 848"),
    ],
)
def test_broken_maps_are_refused(name, value, sentence):
    ResponseMaps(**MAPS)
    with pytest.raises(Refusal) as refused:
        ResponseMaps(**{**MAPS, name: value})
    assert sentence in str(refused.value)


def test_published_data_keep_every_rule(shared_data):
    for path in shared_data.glob("tmf8828_response_maps/*.npz"):
        with np.load(path) as arrays:
            maps = ResponseMaps(**{n: arrays[n] if n != "meta_json" else str(arrays[n]) for n in arrays})
        assert maps.zone_grid == (3, 3)

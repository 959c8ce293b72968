import contextlib
import json
import pickle
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.files import holds_maps, save
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps, save_maps
from recordings.refusal import Refusal


def some_maps(**more):
    rng = np.random.default_rng(4)
    published = {
        "responses": rng.random((2, 3, 5), np.float32),
        "xs": rng.random(5, np.float32) * 848,
        "ys": rng.random(5, np.float32) * 480,
        "cap_ids": np.array([f"{i:04d}" for i in range(5)]),
        "meta_json": json.dumps({"calibration_range_m": 0.4}),
    }
    return ResponseMaps(**{**published, **more})


OWN = {
    "sigma": np.random.default_rng(1).random((2, 3, 5)),
    "flags": np.arange(30, dtype=np.uint8).reshape(2, 3, 5),
    "position_sigma_px": np.random.default_rng(2).random(5, np.float32),
    "position_confidence": np.random.default_rng(3).random(5, np.float32),
}


@pytest.mark.parametrize("more", [{}, OWN, {"sigma": OWN["sigma"]}])
def test_numpy_reads_what_is_written_and_it_comes_back(tmp_path, more):
    maps = some_maps(**more)
    save_maps(maps, tmp_path / "a.npz")
    kept = load_maps(tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as arrays:
        assert set(arrays) == {"responses", "xs", "ys", "cap_ids", "meta_json", *more}
        for name in arrays:
            value = np.asarray(getattr(maps, name))
            assert (arrays[name].dtype, arrays[name].tobytes()) == (value.dtype, value.tobytes())
            assert np.array_equal(getattr(kept, name), value)
    assert holds_maps(tmp_path / "a.npz")


def test_numbers_are_written_as_published(tmp_path):
    save_maps(some_maps(responses=np.ones((2, 3, 5)), xs=np.arange(5.0)), tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz") as arrays:
        assert [arrays[name].dtype for name in ("responses", "xs", "ys")] == [np.float32] * 3


def test_published_files_are_read_as_they_are(shared_data, tmp_path):
    for path in sorted(shared_data.glob("tmf8828_response_maps/*.npz")):
        maps = load_maps(path)
        save_maps(maps, tmp_path / path.name)
        with np.load(path) as first, np.load(tmp_path / path.name) as again:
            assert set(first) == set(again)
            for name in first:
                assert (first[name].dtype, first[name].tobytes()) == (again[name].dtype, again[name].tobytes())
        assert maps.meta["mode"] == "3x3"


def test_a_recording_is_no_maps(tmp_path, make):
    save(make(), tmp_path / "a.npz")
    with pytest.raises(Refusal, match=r"responses is missing.*this is a recording"):
        load_maps(tmp_path / "a.npz")


def test_a_pickle_inside_is_refused(tmp_path):
    save_maps(some_maps(), tmp_path / "a.npz")
    with zipfile.ZipFile(tmp_path / "a.npz", "a") as archive:
        archive.writestr("sigma.npy", pickle.dumps([1]))
    with pytest.raises(Refusal, match=r"damaged \.npz of response maps"):
        load_maps(tmp_path / "a.npz")


def test_no_archive_is_refused(tmp_path):
    (tmp_path / "a.npz").write_bytes(b"no archive")
    with pytest.raises(Refusal, match="damaged"):
        load_maps(tmp_path / "a.npz")


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_damage_is_refused_or_changes_nothing(tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp()
    maps = some_maps(**OWN)
    save_maps(maps, folder / "m.npz")
    raw = bytearray((folder / "m.npz").read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(raw) - 1), min_size=1, max_size=3)):
        raw[place] = data.draw(st.integers(0, 255))
    (folder / "bad.npz").write_bytes(raw[: data.draw(st.just(len(raw)) | st.integers(0, len(raw)))])
    with contextlib.suppress(Refusal):
        kept = load_maps(folder / "bad.npz")
        for name in ("responses", "xs", "ys", "cap_ids"):
            assert np.array_equal(getattr(kept, name), getattr(maps, name))

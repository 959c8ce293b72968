import contextlib
import io
import pickle
import struct
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.encoded import EncodedFrames
from recordings.files import load, save, stream
from recordings.npz import load_npz, stream_npz
from recordings.npz_members import members
from recordings.recording import Recording
from recordings.refusal import Refusal
from recordings.stream import Stream


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("npz")


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_what_numpy_writes_is_read(folder, recordings_of_any_kind, same, data):
    fields = data.draw(recordings_of_any_kind)
    write = data.draw(st.sampled_from([np.savez, np.savez_compressed]))
    write(folder / "a.npz", **fields)
    same(Recording(**fields), load_npz(folder / "a.npz"))
    same(Recording(**fields), stream_npz(folder / "a.npz").collect())


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_what_is_written_numpy_reads(folder, recordings_of_any_kind, data):
    fields = data.draw(recordings_of_any_kind)
    save(Recording(**fields), folder / "b.npz")
    with np.load(folder / "b.npz", allow_pickle=False) as arrays:
        assert set(arrays) == set(fields)
        assert str(arrays["meta_json"]) == fields.pop("meta_json")
        for name, value in fields.items():
            assert (arrays[name].dtype, arrays[name].shape) == (value.dtype, value.shape)
            assert arrays[name].tobytes() == value.tobytes()


def test_encoded_frames_are_written_as_pixels(folder, make, jpeg):
    blobs = [jpeg(image) for image in make().rgb]
    passing = Stream.of(make())
    frames = ({**frame, "rgb": blob} for frame, blob in zip(passing.frames, blobs, strict=True))
    save(Stream(passing.static, frames), folder / "c.npz")
    with np.load(folder / "c.npz") as arrays:
        assert EncodedFrames.of(blobs) == arrays["rgb"]


def test_column_major_arrays_are_read(folder, fields, same):
    good = fields()
    np.savez(folder / "f.npz", **{**good, "depth_m": np.asfortranarray(good["depth_m"])})
    same(Recording(**good), load_npz(folder / "f.npz"))
    same(Recording(**good), stream_npz(folder / "f.npz").collect())


def test_other_plain_arrays_are_left_alone(folder, fields, same):
    np.savez(folder / "g.npz", **fields(), own_notes=np.arange(3))
    same(Recording(**fields()), load_npz(folder / "g.npz"))


class Bomb:
    def __reduce__(self):
        return (pytest.fail, ("a pickle was run",))


def with_member(path, fields, name, content):
    np.savez(path, **{n: v for n, v in fields.items() if f"{n}.npy" != name})
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(name, content)
    return path


def npy(header, values=b"", version=b"\x01\x00"):
    text = (header + " " * 10 + "\n").encode("latin1")
    return b"\x93NUMPY" + version + struct.pack("<H", len(text)) + text + values


def described(descr, shape):
    return repr({"descr": descr, "fortran_order": False, "shape": shape})


LIES = {
    "an object array": ("counts.npy", lambda: objects(), "counts holds Python objects (a pickle)"),
    "an object array elsewhere": ("own.npy", lambda: objects(), "own holds Python objects (a pickle)"),
    "a pickle beside": ("data.pkl", lambda: pickle.dumps(Bomb()), "holds 'data.pkl', expected nothing but arrays"),
    "a pickle as an array": ("counts.npy", lambda: pickle.dumps(Bomb()), "damaged .npz"),
    "a terabyte": ("counts.npy", lambda: npy(described("<u4", (10**9, 9, 128))), "claims 4608000000000 bytes"),
    "an overflow": ("counts.npy", lambda: npy(described("<u4", (2**62, 2**62, 1))), "counts claims"),
    "a negative shape": ("counts.npy", lambda: npy(described("<u4", (-1, 9, 128))), "counts"),
    "values left over": ("counts.npy", lambda: npy(described("<u4", (1, 1, 1)), b"\0" * 8), "claims 4 bytes"),
    "a structure": ("counts.npy", lambda: npy(described([("a", "<u4")], (1,)), b"\0" * 4), "expected numbers or text"),
    "another version": ("counts.npy", lambda: npy("{}", version=b"\x09\x00"), "array format (9, 0)"),
    "no header": ("counts.npy", lambda: b"\x93NUMPY", "damaged .npz"),
    "code for a header": ("counts.npy", lambda: npy("__import__('os').abort()"), "damaged .npz"),
    "numbers for text": ("meta_json.npy", lambda: saved(np.arange(3)), "meta_json holds int64"),
    "many texts": ("meta_json.npy", lambda: saved(np.array(["{}", "{}"])), "expected one text"),
    "bytes for text": ("meta_json.npy", lambda: saved(np.array(b"{}")), "expected numbers or text"),
}


def saved(array):
    written = io.BytesIO()
    np.save(written, array)
    return written.getvalue()


def objects():
    written = io.BytesIO()
    np.save(written, np.array([Bomb()], object), allow_pickle=True)
    return written.getvalue()


@pytest.mark.parametrize("read", [load_npz, lambda path: stream_npz(path).collect()], ids=["load", "stream"])
@pytest.mark.parametrize("case", LIES)
def test_a_lie_is_refused(tmp_path, fields, case, read):
    name, content, sentence = LIES[case]
    path = with_member(tmp_path / "lie.npz", fields(), name, content())
    with pytest.raises(Refusal) as refused:
        read(path)
    assert sentence in str(refused.value)
    assert str(refused.value).startswith(str(path))


def test_a_directory_that_claims_more_than_is_packed_is_refused(tmp_path, fields):
    path = tmp_path / "bomb.npz"
    header = npy(described("<u4", (1 << 20, 9, 128)))
    size = len(header) + (1 << 20) * 9 * 128 * 4
    with_member(path, fields(), "counts.npy", header)
    raw = bytearray(path.read_bytes())
    entry = raw.rindex(b"PK\x01\x02")
    raw[entry + 24 : entry + 28] = struct.pack("<I", size & 0xFFFFFFFF)
    path.write_bytes(raw)
    with pytest.raises(Refusal):
        load_npz(path)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_an_array_that_is_there_twice_is_refused(tmp_path, fields):
    np.savez(tmp_path / "a.npz", **fields())
    with zipfile.ZipFile(tmp_path / "a.npz", "a") as archive:
        archive.writestr("counts.npy", saved(fields()["counts"]))
    with pytest.raises(Refusal, match="holds counts twice"):
        load_npz(tmp_path / "a.npz")


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("timestamp_s", np.arange(4.0), "timestamp_s has shape (4,), expected (F,), F=5"),
        ("depth_m", np.zeros((3, 4, 6)), "depth_m has shape (3, 4, 6)"),
        ("counts", np.zeros((5, 6, 8)), "counts holds float64"),
        ("bin_width_s", np.array(["1"]), "bin_width_s has shape (1,)"),
    ],
)
def test_wrong_arrays_are_refused(tmp_path, fields, name, value, sentence):
    np.savez(tmp_path / "a.npz", **{**fields(), name: value})
    for read in (load_npz, lambda path: stream_npz(path).collect()):
        with pytest.raises(Refusal) as refused:
            read(tmp_path / "a.npz")
        assert sentence in str(refused.value)


def test_a_missing_array_is_named(tmp_path, fields):
    np.savez(tmp_path / "a.npz", **{n: v for n, v in fields().items() if n != "bin_width_s"})
    with pytest.raises(Refusal, match="bin_width_s is missing"):
        load_npz(tmp_path / "a.npz")


def test_an_encrypted_archive_is_refused(tmp_path, fields):
    np.savez(tmp_path / "a.npz", **fields())
    raw = bytearray((tmp_path / "a.npz").read_bytes())
    for mark, flags in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        raw[raw.index(mark) + flags] |= 1
    (tmp_path / "a.npz").write_bytes(raw)
    with pytest.raises(Refusal):
        load_npz(tmp_path / "a.npz")


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_damage_is_refused_or_changes_nothing(folder, make, same, data):
    recording = make(frames=2, grid=(1, 2), bins=3, size=(2, 2))
    whole = folder / "whole.npz"
    if not whole.exists():
        save(recording, whole)
    raw = bytearray(whole.read_bytes())
    for place in data.draw(st.lists(st.integers(0, len(raw) - 1), max_size=3)):
        raw[place] = data.draw(st.integers(0, 255))
    cut = data.draw(st.just(len(raw)) | st.integers(0, len(raw)))
    (folder / "d.npz").write_bytes(raw[:cut])
    for read in (load, lambda path: stream(path).collect()):
        with contextlib.suppress(Refusal):
            same(recording, read(folder / "d.npz"))


def test_a_list_of_members_that_hides_one_is_refused(tmp_path):
    """The entry of one array, swallowed as the comment of the one before."""
    path = tmp_path / "hiding.npz"
    np.savez(path, first=np.arange(3), second=np.arange(3))
    data = bytearray(path.read_bytes())
    one, other = (data.rindex(b"PK\x01\x02", 0, at) for at in (data.rindex(b"PK\x01\x02"), len(data)))
    end = data.rindex(b"PK\x05\x06")
    data[one + 32 : one + 34] = (end - other).to_bytes(2, "little")
    path.write_bytes(data)
    with zipfile.ZipFile(path) as archive, pytest.raises(Refusal, match="lists 1 arrays, expected 2 as its end says"):
        members(archive)

"""Hostile pickles: none is run, none gets memory for the asking, each is refused by name."""

import os
import pickle
import struct
import subprocess
import tracemalloc

import pytest

from recordings.refusal import Refusal

STAND_IN = b"ccc_hardware.drivers\nThing\n"


class Reduces:
    """Pickles as a call of `function` on `args`."""

    def __init__(self, function, *args):
        self.call = function, args

    def __reduce__(self):
        return self.call


def text(value):
    return b"X" + struct.pack("<I", len(value)) + value


# What each asks for, and a pickle that asks for it; {canary} is a file that must not appear.
ATTACKS = {
    "posix.system": lambda canary: pickle.dumps(Reduces(os.system, f"touch {canary}"), 4),
    "__builtin__.eval": lambda canary: pickle.dumps(Reduces(eval, f"open({str(canary)!r}, 'w')"), 2),
    "builtins.exec": lambda canary: pickle.dumps({"iter": [Reduces(exec, f"open({str(canary)!r}, 'w')")]}, 5),
    "subprocess.Popen": lambda canary: pickle.dumps(Reduces(subprocess.Popen, ["touch", str(canary)]), 4),
    "os.mkdir": lambda canary: b"(cos\nmkdir\n" + text(str(canary).encode()) + b"o.",
    "os.makedirs": lambda canary: b"(" + text(str(canary).encode()) + b"ios\nmakedirs\n.",
    "nt.system": lambda canary: b"\x80\x04" + text(b"nt") + text(b"system") + b"\x93" + text(b"dir") + b"\x85R.",
    "builtins.getattr": lambda canary: b"c__builtin__\ngetattr\n(c__builtin__\nset\n" + text(b"pop") + b"tR.",
    "functools.partial": lambda canary: b"cfunctools\npartial\n.",
    "copyreg.__newobj__": lambda canary: b"ccopyreg\n__newobj__\n.",
    "copyreg.add_extension": lambda canary: b"ccopyreg\nadd_extension\n.",
    "numpy.load": lambda canary: b"cnumpy\nload\n(" + text(str(canary).encode()) + b"tR.",
    "numpy.testing._private.utils.runstring": lambda canary: b"cnumpy.testing._private.utils\nrunstring\n.",
    "numpy.f2py.compile": lambda canary: b"cnumpy.f2py\ncompile\n.",
    "numpy.core.multiarray.fromfile": lambda canary: b"cnumpy.core.multiarray\nfromfile\n.",
    "collections.defaultdict": lambda canary: b"ccollections\ndefaultdict\n.",
    "recordings.refusal.Refusal": lambda canary: b"crecordings.refusal\nRefusal\n.",
    "sys.modules": lambda canary: b"csys\nmodules\n.",
    "outside the file": lambda canary: b"Pfile:///etc/passwd\n.",
    "outside the file ": lambda canary: text(b"id") + b"Q.",
    "extension code 7": lambda canary: b"\x82\x07.",
    "extension code 300": lambda canary: b"\x83\x2c\x01.",
    "extension code 70000": lambda canary: b"\x84\x70\x11\x01\x00.",
    # The publisher's own names are noted, so calling what they return, or changing them, must lead nowhere.
    "calls what cc_hardware.drivers.Thing returns": lambda canary: STAND_IN + b"(tR(tR.",
    "changes Thing": lambda canary: STAND_IN + b"(N}" + text(b"args") + b"K\x01stb.",
    "unknown encoding": lambda canary: b"c_codecs\nencode\n(" + text(b"x") + text(b"rot13") + b"tR.",
}


@pytest.mark.parametrize("wanted", ATTACKS)
def test_what_asks_for_more_than_data_is_refused_and_not_run(tmp_path, wanted, read):
    canary = tmp_path / "canary"
    content = ATTACKS[wanted](canary)
    with pytest.raises(Refusal) as refusal:
        read(tmp_path, content)
    assert not canary.exists()
    assert "record 0 at byte 0" in str(refusal.value)
    if wanted not in ("unknown encoding", "changes Thing"):
        assert wanted.strip() in str(refusal.value)


def test_the_record_at_fault_is_named(tmp_path, read):
    good = pickle.dumps({"iter": 0}, 4)
    with pytest.raises(Refusal, match=f"record 2 at byte {2 * len(good)} asks for os.system"):
        read(tmp_path, 2 * good + b"cos\nsystem\n.")


def test_stand_ins_of_one_record_do_not_leak_into_the_next(tmp_path, read):
    first, second = read(tmp_path, STAND_IN + b"(K\x05tR}" + text(b"x") + b"K\x07sb." + STAND_IN + b"(tR.")
    assert str(first) == "cc_hardware.drivers.Thing(5)"
    assert (first.state, second.args, second.state) == ({"x": 7}, (), None)


LIES = {
    "binbytes8": b"\x8e" + struct.pack("<Q", 1 << 40) + b"abc.",
    "binbytes": b"B" + struct.pack("<I", (1 << 32) - 1) + b"abc.",
    "bytearray8": b"\x96" + struct.pack("<Q", 1 << 62) + b"abc.",
    "binunicode8": b"\x8d" + struct.pack("<Q", 1 << 40) + b"abc.",
    "binunicode": b"X" + struct.pack("<I", (1 << 32) - 1) + b"abc.",
    "binstring": b"T" + struct.pack("<i", (1 << 31) - 1) + b"abc.",
    "frame": b"\x80\x04\x95" + struct.pack("<Q", 1 << 60) + b"N.",
    "long4": b"\x8b" + struct.pack("<i", (1 << 31) - 1) + b"abc.",
    "memo": b"Nr" + struct.pack("<I", (1 << 32) - 1) + b".",
    "bytearray of a number": b"cbuiltins\nbytearray\n(J" + struct.pack("<i", (1 << 31) - 1) + b"tR.",
    "integer of many digits": b"I" + b"9" * 100_000 + b"\n.",
    "dictionaries": b"(" + b"}" * (4 << 20) + b"t.",
}


@pytest.mark.parametrize("name", LIES)
def test_a_claim_of_memory_is_not_believed(tmp_path, name, read):
    tracemalloc.start()
    try:
        read(tmp_path, LIES[name])
    except (Refusal, EOFError):
        pass
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 64e6


def test_shared_parts_may_not_unfold_without_end(tmp_path, read):
    nested = []
    for _ in range(60):
        nested = [nested, nested]
    with pytest.raises(Refusal, match="unfolds"):
        read(tmp_path, pickle.dumps({"iter": nested}, 4))
    itself = []
    itself.append(itself)
    with pytest.raises(Refusal, match="contains itself"):
        read(tmp_path, pickle.dumps(itself, 4))
    deep = []
    for _ in range(5000):
        deep = [deep]
    with pytest.raises(Refusal):
        read(tmp_path, b"]" * 5000 + b"a" * 4999 + b".")

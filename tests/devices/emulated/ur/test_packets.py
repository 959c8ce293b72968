import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from devices.emulated.ur import packets


def test_a_packet_as_the_guide_spells_it():
    # Size with the header, then the kind: request of protocol version 2.
    assert packets.packet(b"V", b"\x00\x02") == bytes([0, 5, 86, 0, 2])


def test_data_as_the_guide_packs_it():
    recipe = packets.recipe(3, b"timestamp,actual_q,robot_mode,safety_status_bits,")
    assert recipe.types == ("DOUBLE", "VECTOR6D", "INT32", "UINT32")
    sent = recipe.pack({"timestamp": (1.5,), "actual_q": [1, 2, 3, 4, 5, 6], "robot_mode": (7,)})
    assert sent[:4] == bytes([0, 4 + 8 + 48 + 4 + 4, 85, 3])
    assert sent[4:] == struct.pack(">d6diI", 1.5, 1, 2, 3, 4, 5, 6, 7, 0)


def test_a_command_is_unpacked_by_name():
    recipe = packets.recipe(1, b"input_int_register_0,input_double_register_0,input_int_register_1")
    values = recipe.unpack(struct.pack(">idi", 3, -0.25, 1))
    assert values == {"input_int_register_0": 3, "input_double_register_0": -0.25, "input_int_register_1": 1}
    with pytest.raises(ValueError, match="3 bytes for recipe 1, expected 16"):
        recipe.unpack(b"abc")


@pytest.mark.parametrize(
    "name", ["nonsense", "output_int_register_48", "output_int_register_x", "input_double_register_"]
)
def test_what_a_controller_has_not_is_not_found(name):
    recipe = packets.recipe(1, f"timestamp,{name}".encode())
    assert recipe.types == ("DOUBLE", "NOT_FOUND")
    assert not recipe.known


@given(st.lists(st.tuples(st.sampled_from([b"U", b"I", b"S"]), st.binary(max_size=20)), max_size=6), st.data())
def test_packets_come_whole_however_the_line_cuts_them(sent, data):
    stream = b"".join(packets.packet(kind, payload) for kind, payload in sent)
    buffer, got = bytearray(), []
    while stream:
        size = data.draw(st.integers(1, len(stream)))
        buffer += stream[:size]
        stream = stream[size:]
        got.extend(packets.whole(buffer))
    assert got == sent
    assert not buffer


@pytest.mark.parametrize("size", [0, 2, 60000])
def test_no_packet_begins_so(size):
    with pytest.raises(ValueError, match=f"a packet of {size} bytes"):
        list(packets.whole(bytearray(struct.pack(">Hc", size, b"U") + b"x")))

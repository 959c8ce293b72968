"""Packets of RTDE, the controller's real-time data exchange, protocol version 2; big endian.

Universal Robots, "Real-Time Data Exchange (RTDE) Guide".
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

REQUEST_VERSION, CONTROLLER_VERSION = b"V", b"v"
SET_OUTPUTS, SET_INPUTS, START, PAUSE, DATA = b"O", b"I", b"S", b"P", b"U"
HEADER = struct.Struct(">Hc")
VERSION = struct.Struct(">4I")
HERTZ = struct.Struct(">d")
MOST_BYTES = 4096  # a client asks for no more; whoever claims more is no client

_CODES = {
    "DOUBLE": "d",
    "INT32": "i",
    "UINT32": "I",
    "UINT64": "Q",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}
_TYPES = {
    "joint_mode": "VECTOR6INT32",
    "actual_tool_accelerometer": "VECTOR3D",
    "payload_cog": "VECTOR3D",
    "payload_inertia": "VECTOR6D",
    "ft_raw_wrench": "VECTOR6D",
    **dict.fromkeys(("actual_digital_input_bits", "actual_digital_output_bits"), "UINT64"),
    **dict.fromkeys(("robot_mode", "safety_mode"), "INT32"),
    **dict.fromkeys(("runtime_state", "robot_status_bits", "safety_status_bits"), "UINT32"),
    **dict.fromkeys(
        (
            "target_q",
            "target_qd",
            "target_qdd",
            "target_current",
            "target_moment",
            "actual_q",
            "actual_qd",
            "actual_current",
            "joint_control_output",
            "actual_TCP_pose",
            "actual_TCP_speed",
            "actual_TCP_force",
            "target_TCP_pose",
            "target_TCP_speed",
            "joint_temperatures",
            "actual_joint_voltage",
        ),
        "VECTOR6D",
    ),
    **dict.fromkeys(
        (
            "timestamp",
            "actual_execution_time",
            "target_speed_fraction",
            "speed_scaling",
            "speed_scaling_combined",
            "actual_momentum",
            "actual_main_voltage",
            "actual_robot_voltage",
            "actual_robot_current",
            "standard_analog_input0",
            "standard_analog_input1",
            "standard_analog_output0",
            "standard_analog_output1",
            "payload",
        ),
        "DOUBLE",
    ),
}
REGISTERS = 48


def type_of(name: str) -> str:
    """The type of a variable; "NOT_FOUND" for those this controller has not."""
    for kind, code in (("int_register_", "INT32"), ("double_register_", "DOUBLE")):
        for way in ("input_", "output_"):
            number = name.removeprefix(way + kind)
            if number != name:
                return code if number.isdigit() and int(number) < REGISTERS else "NOT_FOUND"
    return _TYPES.get(name, "NOT_FOUND")


def packet(kind: bytes, payload: bytes = b"") -> bytes:
    """A packet with its header."""
    return HEADER.pack(HEADER.size + len(payload), kind) + payload


def whole(buffer: bytearray) -> Iterator[tuple[bytes, bytes]]:
    """Take the whole packets out of a buffer: kind and payload; raises ValueError where no packet can begin."""
    while len(buffer) >= HEADER.size:
        size, kind = HEADER.unpack_from(buffer)
        if not HEADER.size <= size <= MOST_BYTES:
            raise ValueError(f"a packet of {size} bytes")
        if len(buffer) < size:
            return
        payload = bytes(buffer[HEADER.size : size])
        del buffer[:size]
        yield kind, payload


@dataclass(frozen=True)
class Recipe:
    """Variables that travel together under one number."""

    number: int
    names: tuple[str, ...]

    @cached_property
    def types(self) -> tuple[str, ...]:
        """The type of each variable."""
        return tuple(type_of(name) for name in self.names)

    @property
    def known(self) -> bool:
        """Whether this controller has all of the variables."""
        return "NOT_FOUND" not in self.types

    @cached_property
    def layout(self) -> struct.Struct:
        """How the values are packed after the number."""
        return struct.Struct(">" + "".join(_CODES[kind] for kind in self.types))

    @cached_property
    def _zeros(self) -> tuple[list[int], ...]:
        return tuple([0] * int(_CODES[kind][:-1] or 1) for kind in self.types)

    def pack(self, values: Mapping[str, Sequence[float]]) -> bytes:
        """A data packet; each value is a sequence, variables that have none are zero."""
        row = chain.from_iterable(map(values.get, self.names, self._zeros))
        return packet(DATA, bytes([self.number]) + self.layout.pack(*row))

    def unpack(self, payload: bytes) -> dict[str, float]:
        """Single values by name out of a data packet's payload after the number; raises ValueError where it is none."""
        if len(payload) != self.layout.size:
            raise ValueError(f"{len(payload)} bytes for recipe {self.number}, expected {self.layout.size}")
        return dict(zip(self.names, self.layout.unpack(payload), strict=True))


def recipe(number: int, names: bytes) -> Recipe:
    """The recipe a client asks for; its names are joined by commas and may end in one."""
    return Recipe(number, tuple(filter(None, names.decode("ascii", "replace").split(","))))

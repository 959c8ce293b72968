"""The interpreter of a pickle's opcodes, except that a call a pickle asks for is noted, not made."""

import pickle
import struct
from typing import Any, ClassVar, NoReturn

from recordings.importers.inert.reader import BoundedReader
from recordings.refusal import Refusal

# From here on bytes are left in the file until somebody asks for them.
SPAN_FROM_BYTES = 256

NUMPY_CORES = ("numpy.core", "numpy._core")
BUILTINS = ("builtins", "__builtin__")
NOTED = {
    ("numpy", "ndarray"),
    ("numpy", "dtype"),
    *((f"{core}.multiarray", name) for core in NUMPY_CORES for name in ("_reconstruct", "scalar")),
    *((f"{core}.numeric", "_frombuffer") for core in NUMPY_CORES),
    *((module, name) for module in BUILTINS for name in ("complex", "bytes", "bytearray", "getattr")),
    ("_codecs", "encode"),
}
CONTAINERS = {
    ("collections", "OrderedDict"): dict,
    **{(module, kind.__name__): kind for module in BUILTINS for kind in (set, frozenset)},
}
# The capture scripts' own enums and settings; they are noted by name and never imported.
PUBLISHERS = ("cc_hardware",)


class Global(type):
    """A class that stands for a global a pickle names; nothing can be set on it."""

    def __setattr__(cls, name: str, value: Any) -> NoReturn:
        raise Refusal(f"changes {cls.name}")


class Noted(metaclass=Global):
    """A call a pickle asks for, written down: `name` of what is called, its `args`, its later `state`."""

    __slots__ = ("args", "state")
    name = ""

    def __new__(cls, *args: Any) -> "Noted":  # noqa: D102 - what becomes of a call is said by the class
        noted = super().__new__(cls)
        noted.args, noted.state = args, None
        return noted

    def __setstate__(self, state: Any) -> None:
        self.state = state

    def __call__(self, *args: Any) -> NoReturn:  # noqa: D102 - the refusal says it
        raise Refusal(f"calls what {self.name} returns")


# The interpreter written in Python: the one in C allocates what a length field claims before it reads.
class InertUnpickler(pickle._Unpickler):
    """Plain containers, numbers and text come out as they are, the rest as `Noted`, long bytes as `Span`."""

    dispatch: ClassVar[dict[int, Any]] = dict(pickle._Unpickler.dispatch)

    def __init__(self, reader: BoundedReader) -> None:
        super().__init__(reader)
        self.reader = reader

    def find_class(self, module: str, name: str) -> Any:
        """The stand-in for a global; refuses every global that is not known to be data."""
        if (module, name) in CONTAINERS:
            return CONTAINERS[module, name]
        if (module, name) not in NOTED and module.split(".")[0] not in PUBLISHERS:
            wanted = ascii(f"{module}.{name}")[1:-1]
            raise Refusal(f"asks for {wanted:.100}, expected numpy arrays and plain containers only")
        return Global(name, (Noted,), {"__slots__": (), "name": f"{module}.{name}"})

    def persistent_load(self, pid: Any) -> NoReturn:
        """Refuse a reference to something outside the file."""
        raise Refusal("refers to an object outside the file, expected numpy arrays and plain containers only")

    def get_extension(self, code: int) -> NoReturn:
        """Refuse a global given by its number in this process's registry."""
        raise Refusal(f"asks for extension code {code}, expected numpy arrays and plain containers only")

    def load_frame(self) -> None:
        """Frames only say how far to read ahead."""
        self.read(8)

    def load_counted(self, width: str) -> None:
        """Bytes after a length of struct type `width`."""
        length: int = struct.unpack(width, self.read(struct.calcsize(width)))[0]
        self.append(self.read(length) if length < SPAN_FROM_BYTES else self.reader.skip(length))

    dispatch[pickle.FRAME[0]] = load_frame
    dispatch[pickle.BINBYTES[0]] = lambda self: self.load_counted("<I")
    dispatch[pickle.BINBYTES8[0]] = lambda self: self.load_counted("<Q")
    dispatch[pickle.BYTEARRAY8[0]] = lambda self: self.load_counted("<Q")

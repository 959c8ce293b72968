"""Which entity and component of an .rrd file holds which field, and what a recording says of itself.

Counts, images and text stand, once, where the viewer shows them: a bar chart for each zone on `lidar/zone/R_C`,
images on `camera/...`, `meta_json` on `recording/meta`. Every other field stands as a plain column of its own type
on `recording`, because the viewer's own transforms and times are rounded to 32 bits or nanoseconds. Rows are told
apart by the timeline `frame`; `time` is for the viewer. `recording` also has the description of all fields, and a
CRC-32 of each field of each frame, so that damage anywhere is found.
"""

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.fields import FIELDS
from recordings.refusal import Refusal

FORMAT, VERSION = "difflidar recording", 1
APPLICATION = "difflidar"
OWN = "recording"
LAYOUT, CHECKSUMS = "Recording:layout", "Recording:crc32"
COUNTS = "BarChart:values"
META = "TextDocument:text"
SHOWN = {
    "meta_json": ("recording/meta", META),
    "rgb": ("camera/rgb", "EncodedImage:blob"),
    "depth_m": ("camera/depth", "DepthImage:buffer"),
    "reflectance": ("camera/reflectance", "Image:buffer"),
    "incidence_cosine": ("camera/incidence_cosine", "Image:buffer"),
}


def place(name: str) -> tuple[str, str]:
    """Entity and component of a field other than `counts`."""
    return SHOWN.get(name, (OWN, f"Recording:{name}"))


def checksum(value: Any) -> int:
    """CRC-32 of the bytes of an array, or of the bytes or text themselves."""
    if isinstance(value, str):
        return zlib.crc32(value.encode())
    return zlib.crc32(value if isinstance(value, bytes) else np.ascontiguousarray(value).view(np.uint8).data)


@dataclass(frozen=True)
class Kept:
    """Type and shape of a field as kept: of the whole where static, else of one frame; CRC-32 where static."""

    dtype: np.dtype
    shape: tuple[int, ...]
    crc32: int = 0


@dataclass(frozen=True)
class Layout:
    """The fields of a recording, static ones and those of each frame, in order; how many columns of zones."""

    static: Mapping[str, Kept]
    frames: Mapping[str, Kept]
    zone_columns: int

    @classmethod
    def of(cls, static: Mapping[str, Any], frame: Mapping[str, Any], image_shape: tuple[int, ...]) -> "Layout":
        """Of checked fields; `image_shape` is (H, W, 3), which encoded images do not carry openly."""

        def kept(value: Any, crc32: int) -> Kept:
            if isinstance(value, bytes | str):
                return Kept(np.dtype(np.uint8), image_shape if isinstance(value, bytes) else (), crc32)
            return Kept(value.dtype, value.shape, crc32)

        still = {name: kept(value, checksum(value)) for name, value in static.items()}
        moving = {name: kept(value, 0) for name, value in frame.items()}
        return cls(still, moving, int(static["zone_grid"][1]))

    def zone_entity(self, zone: int) -> str:
        """Entity of a zone by its number; zones are numbered row by row."""
        return f"lidar/zone/{zone // self.zone_columns}_{zone % self.zone_columns}"

    def text(self) -> str:
        """As JSON text, which opens with its own checksum."""
        groups = {"static": self.static, "frames": self.frames}
        listed = {
            group: {name: [kept.dtype.str, list(kept.shape), kept.crc32] for name, kept in fields.items()}
            for group, fields in groups.items()
        }
        said = {"format": FORMAT, "version": VERSION, "zone_columns": self.zone_columns, **listed}
        body = json.dumps(said)
        return f"{checksum(body):08x} {body}"

    @classmethod
    def read(cls, text: str) -> "Layout":
        """From that text; refuses text that is damaged or of a later version, and fields that do not exist."""
        body = text[9:]
        if text[:9] != f"{checksum(body):08x} ":
            raise Refusal("the description of the recording does not match its checksum")
        said = json.loads(body)
        if said["version"] > VERSION:
            raise Refusal(f"is of version {said['version']}, expected {VERSION} at most: a newer difflidar wrote it")
        static, frames = ({n: entry(n, *k) for n, k in said[group].items()} for group in ("static", "frames"))
        missing = {"zone_grid", "meta_json"} - static.keys() | {"counts", "timestamp_s"} - frames.keys()
        if missing:
            raise Refusal(f"{min(missing)} is missing from the description of the recording")
        return cls(static, frames, int(said["zone_columns"]))


def entry(name: str, dtype: str, shape: list[int], crc32: int) -> Kept:
    """One entry of the description, checked as far as it can be alone."""
    if name not in FIELDS and name != "meta_json":
        raise Refusal(f"{name} is no field of a recording")
    return Kept(np.dtype(dtype), tuple(int(n) for n in shape), int(crc32))

"""Check a recording frame by frame, as it is streamed."""

from typing import Any

import numpy as np

from recordings.checks import check_json, unsigned
from recordings.encoded import decoded, encoded_size
from recordings.fields import FIELDS
from recordings.one_field import check_shape, checked
from recordings.refusal import Refusal
from recordings.relations import check_relations, check_rigid


class FrameChecks:
    """Checks the static fields when made, then one frame after another against them and the frames before.

    static: the static fields as plain arrays (text and bytes as they came).
    count: how many frames have passed.
    """

    def __init__(self, static: dict[str, Any]) -> None:
        self._sizes: dict[str, int] = {}
        self._types: dict[str, np.dtype | None] = {}
        self._last_time = None
        self.count = 0
        self.static = {"meta_json": "{}", **{n: v for n, v in static.items() if v is not None}}
        check_json("meta_json", self.static["meta_json"])
        for name in FIELDS:
            if name in self.static:
                self.static[name] = self._static(name)
            elif FIELDS[name].required and FIELDS[name].of_all_frames().shapes:
                raise Refusal(f"{name} is missing, expected {FIELDS[name].expected}")
        self._known(self.static, ("meta_json",))
        rows, columns = (int(n) for n in self.static["zone_grid"])
        self._sizes.setdefault("P", rows * columns)
        if "image_size" in self.static:
            width, height = (int(n) for n in self.static["image_size"])
            self._sizes = {"W": width, "H": height, **self._sizes}
        check_relations(self.static, self._sizes)

    @property
    def image_shape(self) -> tuple[int, ...]:
        """(H, W, 3) of the camera grid, once an image has passed."""
        return self._sizes.get("H", 0), self._sizes.get("W", 0), 3

    def frame(self, frame: dict[str, Any]) -> dict[str, Any]:
        """The frame as plain arrays (encoded images as bytes); raises `Refusal` naming the index."""
        self._known(frame, ())
        if not self._types:
            self._types = dict.fromkeys(frame)
            twice = [name for name in frame if name in self.static]
            missing = [name for name in ("counts", "timestamp_s") if name not in frame]
            if twice or missing:
                raise Refusal(f"{(twice + missing)[0]} must be in the {'frames' if missing else 'static part'}")
        if frame.keys() != self._types.keys():
            odd = sorted(frame.keys() ^ self._types.keys())[0]
            raise Refusal(f"frame {self.count} {'has' if odd in frame else 'lacks'} {odd}, unlike those before")
        plain = {name: self._moving(name, value) for name, value in frame.items()}
        time = plain["timestamp_s"]
        if self._last_time is not None and not time > self._last_time:
            came = f"timestamp_s[{self.count}] is {time} after {self._last_time}"
            raise Refusal(f"{came}, expected strictly increasing seconds")
        if "camera_pose" in plain:
            check_rigid(f"camera_pose[{self.count}]", plain["camera_pose"])
        self._last_time = time
        self.count += 1
        return plain

    def _known(self, values: dict[str, Any], more: tuple[str, ...]) -> None:
        for name in values:
            if name not in FIELDS and name not in more:
                raise Refusal(f"{name} is no field of a recording, expected one of {', '.join(FIELDS)}")

    def _static(self, name: str) -> Any:
        value, field = self.static[name], FIELDS[name].of_all_frames()
        if not field.shapes:
            raise Refusal(f"{name} is given once, expected one for every frame")
        if name == "rgb" and isinstance(value, bytes):
            check_shape(name, (*encoded_size(value, name), 3), field.shapes, self._sizes)
            decoded(value, (self._sizes["H"], self._sizes["W"]), name)
            return value
        return checked(name, value, field, self._sizes)

    def _moving(self, name: str, value: Any) -> Any:
        field = FIELDS[name].of_a_frame()
        place = f"{name}[{self.count}]"
        if not field.shapes:
            raise Refusal(f"{place} is given for a frame, expected one {name} for all frames")
        if name == "rgb" and isinstance(value, bytes):
            check_shape(place, (*encoded_size(value, place), 3), field.shapes, self._sizes)
            decoded(value, (self._sizes["H"], self._sizes["W"]), place)
            return value
        array = checked(name, value, field, self._sizes, self.count)
        array = unsigned(array) if name == "counts" else array
        known = self._types[name] or array.dtype
        if array.dtype != known:
            raise Refusal(f"{place} holds {array.dtype.name}, expected {known.name} as in the frames before")
        self._types[name] = known
        return array

"""A recording that is handed on frame by frame, so that it need not fit in memory."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.encoded import EncodedFrames, LazyFrames, decoded, encode, encoded_size
from recordings.fields import varies
from recordings.frame_checks import FrameChecks
from recordings.recording import Recording
from recordings.refusal import Refusal


@dataclass(frozen=True)
class Stream:
    """A recording in passing: what holds for all frames, and the frames one after another, once.

    static: fields of the `Recording` that do not vary by frame, `meta_json` among them.
    frames: for each frame the fields that do, without their first axis; every frame has the same ones.
        `rgb` may be an (H, W, 3) uint8 array or the bytes of a PNG or JPEG, which are kept as they are.
    count: how many frames will come; None where nobody knows.
    """

    static: dict[str, Any]
    frames: Iterator[dict[str, Any]]
    count: int | None = None

    @classmethod
    def of(cls, recording: Recording) -> "Stream":
        """The frames of a recording."""
        present = dict(recording.present())
        moving = {n: v for n, v in present.items() if n != "meta_json" and varies(n, v.ndim)}
        static = {n: v for n, v in present.items() if n not in moving}
        count = len(recording.counts)
        return cls(static, ({n: at(v, i) for n, v in moving.items()} for i in range(count)), count)

    def checked(self) -> Iterator[dict[str, Any]]:
        """The frames, each checked as it passes; raises `Refusal` at the first that breaks the format."""
        checks = FrameChecks(self.static)
        for frame in self.frames:
            yield checks.frame(frame)

    def collect(self) -> Recording:
        """All frames as one recording in memory; colour frames that came as bytes stay bytes."""
        frames = list(self.checked())
        if not frames:
            raise Refusal("the recording has no frame, expected at least one")
        moving = {name: joined(name, [frame[name] for frame in frames]) for name in frames[0]}
        static = dict(self.static)
        if isinstance(static.get("rgb"), bytes):
            static["rgb"] = decoded(static["rgb"], encoded_size(static["rgb"], "rgb"), "rgb")
        return Recording(**static, **moving)


def at(values: np.ndarray | LazyFrames, i: int) -> Any:
    """Frame `i`: bytes where they are kept, else an array."""
    return values.encoded(i) if isinstance(values, EncodedFrames) else values[i]


def joined(name: str, values: list[Any]) -> np.ndarray | EncodedFrames:
    """One array of all frames, or one sequence where any of them are encoded images."""
    if name == "rgb" and any(isinstance(value, bytes) for value in values):
        return EncodedFrames.of([v if isinstance(v, bytes) else encode(v) for v in values])
    return np.stack(values)

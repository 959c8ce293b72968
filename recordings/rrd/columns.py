"""Checked frames as the columns of an .rrd file."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr

from recordings.encoded import encode
from recordings.rrd.arrays import Batch, rows_of_bytes, rows_of_numbers, tensors
from recordings.rrd.index import FRAME
from recordings.rrd.layout import CHECKSUMS, LAYOUT, META, OWN, SHOWN, Layout, checksum, place
from recordings.rrd.scene import image_kind, send_poses, send_scene

TIME = "time"
# Images are cut into chunks of about this, so that one of them is read without many others.
CHUNK_BYTES = 4 << 20
# The viewer's clock counts nanoseconds in 64 bits.
MOST_SECONDS = 9e9
TENSOR = rr.components.TensorDataBatch._ARROW_DATATYPE
BLOB = rr.components.BlobBatch._ARROW_DATATYPE


def send_static(recording: rr.RecordingStream, static: dict[str, Any], layout: Layout) -> None:
    """Log the fields that hold for all frames, and the description of the whole."""
    plain = [text_column(LAYOUT, layout.text())]
    for name, value in static.items():
        entity, component = place(name)
        if name == "meta_json":
            recording.send_columns(entity, [], [text_column(META, value)], strict=True)
        elif name in SHOWN:
            send_images(recording, name, [], [value])
        else:
            plain.append(number_column(component, np.asarray(value).reshape(1, -1)))
    recording.send_columns(OWN, [], plain, strict=True)
    send_scene(recording, static, layout)


def send_frames(recording: rr.RecordingStream, first: int, frames: list[dict[str, Any]], layout: Layout) -> None:
    """Log frames whose numbers start at `first`."""
    moving = {name: [frame[name] for frame in frames] for name in layout.frames}
    numbers = np.arange(first, first + len(frames))
    seconds = np.array(moving["timestamp_s"], float).clip(-MOST_SECONDS, MOST_SECONDS)
    times = [rr.TimeColumn(FRAME, sequence=numbers), rr.TimeColumn(TIME, duration=seconds)]
    plain = []
    sums = np.empty((len(frames), len(moving)), np.uint32)
    for i, (name, values) in enumerate(moving.items()):
        if name == "rgb":
            values = encoded_all(values)
        sums[:, i] = [checksum(value) for value in values]
        if name == "counts":
            send_counts(recording, times, np.stack(values), layout)
        elif name in SHOWN:
            send_images(recording, name, times, values)
        else:
            plain.append(number_column(place(name)[1], np.stack(values).reshape(len(frames), -1)))
    send_poses(recording, times, moving)
    # Last, so that frames that have a checksum are there as a whole where writing was cut off.
    recording.send_columns(OWN, times, [*plain, number_column(CHECKSUMS, sums)], strict=True)


def send_counts(recording: rr.RecordingStream, times: list, counts: np.ndarray, layout: Layout) -> None:
    """Log (n, P, T) counts, a bar chart for each zone."""
    for p in range(counts.shape[1]):
        chart = rr.BarChart.columns(values=tensors(counts[:, p], TENSOR))
        recording.send_columns(layout.zone_entity(p), times, chart, strict=True)


def send_images(recording: rr.RecordingStream, name: str, times: list, values: list[Any]) -> None:
    """Log images of field `name`, in chunks of a bearable size; `times` is empty for a static one."""
    entity, kind = place(name)[0], image_kind(name)
    blobs = values if name == "rgb" else [np.ascontiguousarray(value).tobytes() for value in values]
    for part in runs(blobs):
        field = "blob" if name == "rgb" else "buffer"
        columns = kind.columns(**{field: rows_of_bytes(blobs[part], BLOB)})
        recording.send_columns(entity, [Cut(time, part) for time in times], columns, strict=True)


class Cut:
    """Some rows of a column of times."""

    def __init__(self, times: rr.TimeColumn, rows: slice) -> None:
        self._name, self._times = times.timeline_name(), times.as_arrow_array()[rows]

    def timeline_name(self) -> str:
        """Name of the timeline."""
        return self._name

    def as_arrow_array(self) -> pa.Array:
        """The times."""
        return self._times


def encoded_all(images: list[Any]) -> list[bytes]:
    """Each image as PNG where it is an array, as it is where it is encoded already."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(lambda image: image if isinstance(image, bytes) else encode(image), images))


def runs(blobs: list[bytes]) -> Iterator[slice]:
    """Cuts of a list into stretches of about `CHUNK_BYTES`, each of at least one item."""
    start, size = 0, 0
    for i, blob in enumerate(blobs):
        size += len(blob)
        if size >= CHUNK_BYTES or i == len(blobs) - 1:
            yield slice(start, i + 1)
            start, size = i + 1, 0


def text_column(component: str, text: str) -> rr.ComponentColumn:
    """A column of one row of text."""
    return rr.ComponentColumn(component, Batch(pa.array([text])))


def number_column(component: str, rows: np.ndarray) -> rr.ComponentColumn:
    """A column of rows of numbers (n, k), of their own type."""
    starts = np.arange(len(rows) + 1, dtype=np.int32) * np.int32(rows.shape[1])
    return rr.ComponentColumn(component, Batch(rows_of_numbers(rows).values), offsets=starts)

"""Small recordings with any choice of fields, and what it means that two are the same."""

import io
import json
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import strategies as st
from PIL import Image

from recordings.recording import Recording

OPTIONAL = (
    "laser_cycles",
    "irf",
    "background_counts",
    "depth_m",
    "reflectance",
    "incidence_cosine",
    "rgb",
    "intrinsics",
    "image_size",
    "lidar_from_camera",
    "camera_pose",
    "patch_px",
)
MAY_BE_STILL = ("laser_cycles", "depth_m", "reflectance", "incidence_cosine", "rgb")


def fields_of(
    seed: int = 0,
    frames: int = 5,
    grid: tuple[int, int] = (2, 3),
    bins: int = 8,
    size: tuple[int, int] = (4, 6),
    there: tuple[str, ...] = OPTIONAL,
    still: tuple[str, ...] = (),
    counts_type: str = "u4",
    float_type: str = "f8",
) -> dict:
    """Fields of a recording that keeps every rule; `still` ones do not vary by frame."""
    rng = np.random.default_rng(seed)
    zones, (height, width) = grid[0] * grid[1], size
    real = np.dtype(float_type).type
    most = min(np.iinfo(counts_type).max, 2**63 - 1)

    def image(name: str, *channels: int) -> tuple[int, ...]:
        return (*(() if name in still else (frames,)), height, width, *channels)

    def pose() -> np.ndarray:
        matrix = np.eye(4)
        matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        matrix[:3, :3] *= np.sign(np.linalg.det(matrix[:3, :3]))
        matrix[:3, 3] = rng.normal(size=3)
        return matrix

    irf = rng.random(7)
    depth = rng.random(image("depth_m")).astype(real)
    depth[..., 0, 0] = np.nan
    every = {
        "counts": rng.integers(0, most, (frames, zones, bins), endpoint=True).astype(counts_type),
        "zone_grid": np.array(grid),
        "bin_width_s": np.array(rng.random() * 1e-10 + 1e-10),
        "time_zero_s": rng.random(zones) * 1e-9 if seed % 2 else np.array(rng.random() * 1e-9),
        "timestamp_s": np.cumsum(rng.random(frames) + 1e-3) + 1e9,
        "laser_cycles": np.array(537_000) if "laser_cycles" in still else rng.integers(1, 10**6, frames),
        "irf_time_s": np.linspace(-1e-10, 1e-10, 7),
        "irf": irf / irf.sum(),
        "background_counts": rng.random(zones) * 20,
        "depth_m": depth,
        "reflectance": rng.random(image("reflectance")).astype(real),
        "incidence_cosine": rng.random(image("incidence_cosine")).astype(real),
        "rgb": rng.integers(0, 256, image("rgb", 3), dtype=np.uint8),
        "intrinsics": np.array([[70.5, 0, 52.25], [0, 71.5, 29.125], [0, 0, 1]]),
        "image_size": np.array([width, height]),
        "lidar_from_camera": pose(),
        "camera_pose": np.stack([pose() for _ in range(frames)]),
        "patch_px": rng.random((frames, 2)) * 100,
        "meta_json": json.dumps({"sensor": "TMF8828", "note": "µ 光", "seed": seed}, ensure_ascii=False),
    }
    absent = set(OPTIONAL) - set(there)
    return {n: v for n, v in every.items() if n not in absent and not (n == "irf_time_s" and "irf" in absent)}


def check_same(first: Recording, second: Recording, frames: int | None = None) -> None:
    """The same fields with the same types, shapes and bits; of `first` the first `frames` frames only."""
    one, two = dict(first.present()), dict(second.present())
    assert one.keys() == two.keys()
    assert one.pop("meta_json") == two.pop("meta_json")
    moving = {name for name, value in one.items() if len(value.shape) and name in MOVING}
    for name, value in one.items():
        a, b = np.asarray(value), np.asarray(two[name])
        varies = name in moving and len(a.shape) == MOVING[name]
        a = a[:frames] if varies else a
        assert (name, a.dtype, a.shape) == (name, b.dtype, b.shape)
        assert a.tobytes() == b.tobytes(), name


# Axes of a field that has one value for each frame.
MOVING = {
    "counts": 3,
    "timestamp_s": 1,
    "laser_cycles": 1,
    "depth_m": 3,
    "reflectance": 3,
    "incidence_cosine": 3,
    "rgb": 4,
    "camera_pose": 3,
    "patch_px": 2,
}


@st.composite
def any_fields(draw: st.DrawFn) -> dict:
    """Fields of any recording that keeps the rules."""
    subset = st.lists(st.sampled_from(OPTIONAL), unique=True)
    still = st.lists(st.sampled_from(MAY_BE_STILL), unique=True)
    small = st.integers(1, 4)
    return fields_of(
        seed=draw(st.integers(0, 2**32)),
        frames=draw(st.integers(1, 6)),
        grid=(draw(small), draw(small)),
        bins=draw(st.integers(1, 9)),
        size=(draw(small), draw(small)),
        there=tuple(draw(subset)),
        still=tuple(draw(still)),
        counts_type=draw(st.sampled_from(["u1", "u2", "u4", "u8"])),
        float_type=draw(st.sampled_from(["f2", "f4", "f8"])),
    )


def jpeg_of(image: np.ndarray) -> bytes:
    """JPEG bytes of an (H, W, 3) image."""
    written = io.BytesIO()
    Image.fromarray(image).save(written, "JPEG")
    return written.getvalue()


@pytest.fixture(scope="session")
def fields() -> Callable[..., dict]:
    """Makes the fields of a small recording."""
    return fields_of


@pytest.fixture(scope="session")
def make() -> Callable[..., Recording]:
    """Makes a small recording."""
    return lambda *args, **options: Recording(**fields_of(*args, **options))


@pytest.fixture(scope="session")
def same() -> Callable[..., None]:
    """Asserts that two recordings are the same to the bit."""
    return check_same


@pytest.fixture(scope="session")
def recordings_of_any_kind() -> st.SearchStrategy[dict]:
    """Draws the fields of a recording; use with `st.data()`."""
    return any_fields()


@pytest.fixture(scope="session")
def jpeg() -> Callable[[np.ndarray], bytes]:
    """Encodes a frame as a camera does."""
    return jpeg_of

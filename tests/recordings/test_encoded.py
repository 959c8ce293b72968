import contextlib
import io

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from recordings.encoded import EncodedFrames, LazyFrames, decoded, encode, encoded_size
from recordings.refusal import Refusal

PIXELS = np.random.default_rng(5).integers(0, 256, (7, 4, 6, 3), dtype=np.uint8)


def lazy():
    return LazyFrames(PIXELS.shape, np.uint8, lambda i: PIXELS[i])


def png():
    return EncodedFrames.of([encode(image) for image in PIXELS])


@pytest.mark.parametrize("frames", [lazy(), png()])
class TestFramesBehaveAsTheirArray:
    def test_shape_type_and_size(self, frames):
        assert (frames.shape, frames.dtype, frames.ndim, frames.nbytes) == (PIXELS.shape, np.uint8, 4, PIXELS.nbytes)
        assert len(frames) == 7

    @pytest.mark.parametrize("index", [0, 3, -1, np.int64(6)])
    def test_a_frame(self, frames, index):
        assert np.array_equal(frames[index], PIXELS[index])

    @pytest.mark.parametrize("index", [7, -8])
    def test_no_such_frame(self, frames, index):
        with pytest.raises(IndexError):
            frames[index]

    @pytest.mark.parametrize("cut", [slice(2, 5), slice(None, None, -2), slice(5, 5)])
    def test_a_slice(self, frames, cut):
        assert np.array_equal(np.asarray(frames[cut]), PIXELS[cut])

    def test_all_in_turn_and_at_once(self, frames):
        assert all(np.array_equal(a, b) for a, b in zip(frames, PIXELS, strict=True))
        assert np.array_equal(np.asarray(frames), PIXELS)
        assert np.asarray(frames, float).dtype == float

    def test_equality_is_by_pixels(self, frames):
        changed = PIXELS.copy()
        changed[6, 3, 5, 2] ^= 1
        assert frames == PIXELS
        assert frames == lazy()
        assert frames != changed
        assert frames != PIXELS[:6]
        assert frames != "text"


def test_nothing_is_read_before_it_is_asked_for():
    asked = []
    frames = LazyFrames((5, 2), np.uint8, lambda i: asked.append(i) or np.zeros(2, np.uint8))
    frames[1:4][1]
    assert asked == [2]


def test_encoded_bytes_are_kept(jpeg):
    blobs = [jpeg(image) for image in PIXELS]
    frames = EncodedFrames.of(blobs)
    assert [frames.encoded(i) for i in range(7)] == blobs
    assert frames[::-1].encoded(0) == blobs[6]
    assert np.array_equal(frames[2], np.asarray(Image.open(io.BytesIO(blobs[2]))))


def test_png_is_lossless_for_another_decoder():
    seen = cv2.imdecode(np.frombuffer(encode(PIXELS[0]), np.uint8), cv2.IMREAD_COLOR_RGB)
    assert np.array_equal(seen, PIXELS[0])


def test_a_frame_of_another_size_is_refused(jpeg):
    frames = EncodedFrames.of([encode(PIXELS[0]), jpeg(PIXELS[1][:3])])
    with pytest.raises(Refusal, match=r"rgb\[1\] is 6 x 3 pixels, expected 6 x 4"):
        frames[1]


def test_no_frames_are_refused():
    with pytest.raises(Refusal, match="no frame"):
        EncodedFrames.of([])


def test_a_header_that_claims_a_huge_image_is_refused():
    blob = bytearray(encode(PIXELS[0]))
    blob[16:24] = (1 << 20).to_bytes(4, "big") * 2
    with pytest.raises(Refusal, match="image"):
        encoded_size(bytes(blob), "rgb[0]")


@given(st.data())
def test_damaged_images_are_refused_or_read(jpeg, data):
    blob = bytearray(data.draw(st.sampled_from([encode(PIXELS[0]), jpeg(PIXELS[0])])))
    for place in data.draw(st.lists(st.integers(0, len(blob) - 1), max_size=4)):
        blob[place] = data.draw(st.integers(0, 255))
    cut = bytes(blob[: data.draw(st.integers(0, len(blob)))])
    with contextlib.suppress(Refusal):
        assert decoded(cut, (4, 6), "rgb[0]").shape == (4, 6, 3)


@pytest.mark.parametrize(("ending", "off"), [(".png", 1), (".jpg", 4)])
def test_grey_is_the_brightness_of_the_colours(ending, off):
    """Within the rounding of the conversion, and of JPEG's own brightness."""
    smooth = cv2.GaussianBlur(np.random.default_rng(0).integers(0, 256, (40, 60, 3), np.uint8), (0, 0), 3)
    blob = cv2.imencode(ending, smooth, [cv2.IMWRITE_JPEG_QUALITY, 95] if ending == ".jpg" else [])[1].tobytes()
    frames = EncodedFrames.of([blob, blob])
    expected = frames[1].astype(float) @ (0.299, 0.587, 0.114)
    assert frames.grey(1).shape == (40, 60)
    assert np.abs(frames.grey(-1) - expected).max() <= off


def test_damaged_bytes_have_no_grey():
    with pytest.raises(Refusal, match="rgb"):
        EncodedFrames(lambda i: b"\xff\xd8\xffnothing", 1, (4, 4)).grey(0)

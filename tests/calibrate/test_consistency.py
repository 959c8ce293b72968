import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibrate.consistency import compare, iou_curve
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps
from recordings.refusal import Refusal


def maps_of(responses, xs=None, ys=None, ids=None, **meta):
    k = responses.shape[-1]
    xs = np.arange(k, dtype=float) if xs is None else xs
    ids = np.array([f"{i:04d}" for i in range(k)]) if ids is None else ids
    return ResponseMaps(responses, xs, xs * 0 if ys is None else ys, ids, json.dumps(meta))


def test_published_figures(published_maps):
    found = compare(
        load_maps(published_maps / "spad_calib_3x3_longrange_bins15_35.npz"),
        load_maps(published_maps / "spad_calib_3x3_shortrange_bins45_75.npz"),
    ).summary()
    published = {"iou": (0.915, 0.029), "displacement_px": (2.94, 0.67), "cosine": (0.984, 0.008)}
    for figure, (mean, spread) in published.items():
        digits = 3 if figure != "displacement_px" else 2
        assert round(found[figure][0], digits) == mean
        assert round(found[figure][1], digits) == spread


def test_by_hand():
    a = maps_of(np.array([[[1.0, 2.0, 0.0, 0.1]]]))
    b = maps_of(np.array([[[0.0, 4.0, 2.0, 0.0]]]))
    found = compare(a, b, 0.1)
    # Supports {0, 1} and {1, 2}; centroids (2 + 0.3) / 3.1 and (4 + 4) / 6; dot 1, norms² 1.2525 and 1.25.
    assert found.iou == pytest.approx([1 / 3])
    assert found.displacement_px == pytest.approx([8 / 6 - 2.3 / 3.1])
    assert found.cosine == pytest.approx([1 / np.sqrt(1.2525 * 1.25)])


@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 1e6))
def test_a_calibration_agrees_with_its_own_multiple(seed, factor):
    rng = np.random.default_rng(seed)
    values = rng.random((2, 2, 20)) + 0.01
    found = compare(maps_of(values), maps_of(values * factor), 0.3)
    np.testing.assert_allclose(found.cosine, 1)
    np.testing.assert_allclose(found.displacement_px, 0, atol=1e-9)
    np.testing.assert_array_equal(found.iou, 1)


@given(st.integers(0, 2**32 - 1))
def test_symmetric_and_bounded(seed):
    rng = np.random.default_rng(seed)
    a, b = (maps_of(rng.gamma(0.3, size=(1, 3, 30)) + 1e-6) for _ in range(2))
    forward, backward = compare(a, b), compare(b, a)
    for name in ("iou", "displacement_px", "cosine"):
        np.testing.assert_allclose(getattr(forward, name), getattr(backward, name))
    assert ((forward.iou >= 0) & (forward.iou <= 1)).all()
    assert ((forward.cosine >= 0) & (forward.cosine <= 1 + 1e-12)).all()


def test_captures_that_one_left_out_do_not_count():
    rng = np.random.default_rng(0)
    values = rng.random((1, 1, 10)) + 0.1
    ids = np.array([f"{i:04d}" for i in range(10)])
    part = [0, 1, 2, 4, 5, 9]
    short = maps_of(values[:, :, part], np.arange(10.0)[part], ids=ids[part])
    assert compare(maps_of(values, ids=ids), short).positions == 6
    np.testing.assert_allclose(compare(short, maps_of(values, ids=ids)).cosine, 1)


def test_curve_holds_every_threshold():
    rng = np.random.default_rng(0)
    a, b = maps_of(rng.random((1, 2, 50))), maps_of(rng.random((1, 2, 50)))
    thresholds = np.array([0.1, 0.5, 0.9])
    curve = iou_curve(a, b, thresholds)
    assert curve.shape == (3, 2)
    np.testing.assert_array_equal(curve[1], compare(a, b, 0.5).iou)


@pytest.mark.parametrize(
    ("a", "b", "threshold", "says"),
    [
        (maps_of(np.ones((1, 1, 5))), maps_of(np.ones((1, 2, 5))), 0.1, "zones"),
        (maps_of(np.ones((1, 1, 5))), maps_of(np.ones((1, 1, 5)), image_size=[640, 480]), 0.1, "image size"),
        (
            maps_of(np.ones((1, 1, 5))),
            maps_of(np.ones((1, 1, 5)), ids=np.array(list("abcde"))),
            0.1,
            "cap_ids",
        ),
        (maps_of(np.ones((1, 1, 5))), maps_of(np.ones((1, 1, 5)), np.arange(5.0) + 9), 0.1, "9.0 px apart"),
        (maps_of(np.ones((1, 1, 5))), maps_of(np.zeros((1, 1, 5))), 0.1, "zones \\[0\\] of the second"),
        (maps_of(np.ones((1, 1, 5))), maps_of(np.ones((1, 1, 5))), 1.0, "threshold"),
    ],
)
def test_what_cannot_be_compared_is_refused(a, b, threshold, says):
    with pytest.raises(Refusal, match=says):
        compare(a, b, threshold)

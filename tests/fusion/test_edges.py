"""The field of smoothness against dense matrices."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fusion.edges import Field, guided_field


def dense(field):
    """A from each edge's own quadratic form w·(x_i − x_j)²."""
    height, width = field.shape
    number = np.arange(height * width).reshape(height, width)
    a = field.ridge * np.eye(number.size)
    pairs = [(number[r, c], number[r, c + 1], field.across[r, c]) for r in range(height) for c in range(width - 1)]
    pairs += [(number[r, c], number[r + 1, c], field.down[r, c]) for r in range(height - 1) for c in range(width)]
    for i, j, w in pairs:
        form = np.zeros(number.size)
        form[i], form[j] = 1, -1
        a += w * np.outer(form, form)
    return a


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 99))
def test_solves_as_the_dense_matrix_does(height, width, seed):
    rng = np.random.default_rng(seed)
    field = Field(rng.uniform(0.01, 1, (height, width - 1)), rng.uniform(0.01, 1, (height - 1, width)), 0.01)
    images = rng.normal(size=(3, height, width))
    expected = np.linalg.solve(dense(field), images.reshape(3, -1).T).T.reshape(images.shape)
    np.testing.assert_allclose(field.solve(images), expected, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(field.solve(images[0]), expected[0], rtol=1e-8, atol=1e-9)


def test_edges_are_where_colour_changes():
    rgb = np.zeros((16, 32, 3), np.uint8)
    rgb[:, 16:] = 255
    field = guided_field(rgb, (4, 8), 0.05, 0.01, 1e-3)
    np.testing.assert_allclose(field.across[:, 3], 0.01, atol=1e-6)
    np.testing.assert_allclose(np.delete(field.across, 3, axis=1), 1.01, atol=1e-6)
    np.testing.assert_allclose(field.down, 1.01, atol=1e-6)


def test_without_an_image_there_are_no_edges():
    field = guided_field(None, (3, 5), 0.05, 0.01, 1e-3)
    assert field.shape == (3, 5)
    assert (field.across == 1).all()
    assert (field.down == 1).all()

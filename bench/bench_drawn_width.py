"""The likeliest width of numbers that are drawn: by three diagonals, beside numpy's eigenvectors."""

import time

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from threadpoolctl import threadpool_limits

from mismatch.drawn_width import LEAST, MOST, likeliest_width


def by_eigenvectors(information, score):
    """The square of the width, of numbers turned until each is told by itself."""
    each, ways = np.linalg.eigh(information)
    promised = ways.T @ score

    def loss(log_width):
        wider = 1 + np.exp(2 * log_width) * each
        return (np.log(wider) - np.exp(2 * log_width) * promised**2 / wider).sum()

    seen = -0.5 * np.log(each.max())
    bounds = (seen + np.log(LEAST), seen + np.log(MOST))
    return np.exp(2 * minimize_scalar(loss, bounds=bounds, method="bounded").x)


@pytest.mark.parametrize("many", [9 * 64, 9 * 128])
def test_drawn_width(many):
    """As many numbers as a converter of each zone has edges."""
    rng = np.random.default_rng(1)
    mixed = 20 * rng.normal(size=(many, many + 50))
    information = mixed @ mixed.T
    score = information @ rng.normal(scale=0.05, size=many)
    ways = {"three diagonals": lambda: likeliest_width(information, score)[1]}
    ways["eigenvectors"] = lambda: by_eigenvectors(information, score)
    taken, found = {name: [] for name in ways}, {}
    with threadpool_limits(1, user_api="blas"):
        for _ in range(5):
            for name, way in ways.items():
                begin = time.perf_counter()
                found[name] = way()
                taken[name].append(time.perf_counter() - begin)
    median = {name: np.median(times[1:]) for name, times in taken.items()}
    print("\n" + ", ".join(f"{name} {1e3 * one:.0f} ms" for name, one in median.items()), f"of {many} numbers")
    assert found["three diagonals"] == pytest.approx(found["eigenvectors"], rel=1e-6)
    assert median["three diagonals"] < median["eigenvectors"]

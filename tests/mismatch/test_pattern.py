"""Numbers that are drawn: shrunk as the dense normal model says, by an oracle that integrates them out."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mismatch.form import forms_of
from mismatch.pattern import drawn, shrunk
from physics.effects import all_effects

BINS = 40


@pytest.fixture(scope="module")
def form():
    forms = forms_of(all_effects()["bin_nonlinearity"], {"zone": 9, "bin": BINS})
    return next(form for form in forms if form.free == ("width",))


def measured(form, width, seed):
    """Best numbers, gain first, and their information, where the truth is drawn with this width."""
    rng = np.random.default_rng(seed)
    count = 1 + len(form.coordinates)
    mixed = rng.normal(size=(count, 3 * count))
    information = mixed @ mixed.T * 50
    truth = np.r_[0.3, rng.normal(scale=width, size=count - 1)]
    return truth, rng.multivariate_normal(truth, np.linalg.inv(information)), information


def test_numbers_of_bins_are_drawn_and_others_are_not(form):
    gain = next(forms_of(all_effects()["zone_gain"], {"zone": 9, "bin": BINS}))
    assert list(drawn((form,))) == list(range(1, 1 + len(form.coordinates)))
    assert not drawn((gain,)).size


@pytest.mark.parametrize("width", [0.003, 0.02, 0.2])
def test_the_width_is_where_the_numbers_integrated_out_are_likeliest(form, width):
    _, best, information = measured(form, width, 1)
    _, pattern = shrunk((form,), best, information)
    spread = np.linalg.inv(information)[1:, 1:]
    nothing = np.zeros(len(spread))

    def unlikely(square):
        return -multivariate_normal(nothing, spread + square * np.eye(len(spread))).logpdf(best[1:])

    found = pattern.width**2
    assert unlikely(found) <= min(unlikely(found * 1.05), unlikely(found / 1.05)) + 1e-6


def test_shrunk_numbers_are_the_best_of_likelihood_and_distribution(form):
    _, best, information = measured(form, 0.02, 2)
    x, pattern = shrunk((form,), best, information)
    uphill = information @ (x - best) + pattern.prior(len(x)) @ x
    assert np.allclose(uphill, 0, atol=1e-6 * np.abs(information).max())


def test_shrunk_numbers_are_nearer_to_the_truth(form):
    for seed in range(5):
        truth, best, information = measured(form, 0.005, seed)
        x, _ = shrunk((form,), best, information)
        assert (x - truth) @ information @ (x - truth) < (best - truth) @ information @ (best - truth)


def test_a_pattern_that_is_not_there_costs_and_is_worth_next_to_nothing(form):
    worth = []
    for seed in range(10):
        _, best, information = measured(form, 0.0, seed)
        worth.append(shrunk((form,), best, information)[1].effective)
    assert np.median(worth) < BINS / 10


@pytest.fixture(scope="module", params=["edge", "zone_edge"])
def edges(request):
    forms = forms_of(all_effects()["bin_nonlinearity"], {"zone": 3, "bin": BINS})
    return next(form for form in forms if form.free == (request.param,))


@pytest.mark.parametrize("walk", [False, True])
def test_data_tell_whether_edges_are_drawn_or_their_distances(edges, walk):
    rng, right = np.random.default_rng(4), 0
    for _ in range(10):
        count = 1 + len(edges.coordinates)
        information = np.diag(rng.uniform(50, 400, count))
        widths = rng.normal(scale=0.2, size=(count // BINS, BINS))
        truth = np.r_[0.0, (np.cumsum(widths, axis=1) if walk else widths).ravel()]
        best = rng.multivariate_normal(truth, np.linalg.inv(information))
        x, pattern = shrunk((edges,), best, information)
        off = np.abs(pattern.precision - np.diag(np.diag(pattern.precision))).max()
        right += (off > 0) == walk
        # As likely as can be: uphill of likelihood is downhill of the distribution.
        uphill = information @ (x - best) + pattern.prior(count) @ x
        assert np.allclose(uphill, 0, atol=1e-6 * np.abs(information).max())
        spread, shape = np.linalg.inv(information)[1:, 1:], np.linalg.inv(pattern.precision)
        oracle = shape @ np.linalg.solve(shape + spread, best[1:])
        assert np.allclose(x[1:], oracle, atol=1e-6)
    assert right >= 9


def test_a_strong_pattern_is_left_as_it_is_and_costs_as_many_numbers(form):
    _, best, information = measured(form, 0.4, 3)
    x, pattern = shrunk((form,), best, information)
    assert np.allclose(x, best, atol=0.02)
    assert pattern.effective == pytest.approx(len(form.coordinates), rel=0.05)
    # Occam's factor: deviance it costs is that of the density with the numbers integrated out, less that at the best.
    spread = np.linalg.inv(information)[1:, 1:]
    whole = -2 * multivariate_normal(np.zeros(len(spread)), spread + np.eye(len(spread)) * pattern.width**2).logpdf(
        best[1:]
    )
    at_best = -2 * multivariate_normal(best[1:], spread).logpdf(best[1:])
    lost = (x - best) @ information @ (x - best)
    assert pattern.cost + lost == pytest.approx(whole - at_best, rel=1e-4)

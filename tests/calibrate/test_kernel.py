import numpy as np
import pytest

from calibrate.kernel import fit_kernel
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

RADIUS = 17.75


def truth(x, y, zone=0):
    """A lattice of bright spots under a bell, as SPADs under a flood: counts per patch area."""
    u, v = np.asarray(x) - 300 - 60 * zone, np.asarray(y) - 200
    bell = np.exp(-((u / 90) ** 4) - (v / 70) ** 4)
    return 1e5 * bell * (1.2 + 0.5 * np.cos(u / 9) + 0.5 * np.cos(v / 12)) + 500


def over_patch(x, y, zone=0):
    """The mean of the truth over the patch by a fine sum over pixels."""
    a, b = (g.ravel() for g in np.meshgrid(*[np.arange(-18, 18.5, 0.5)] * 2))
    inside = np.hypot(a, b) <= RADIUS
    return truth(x[:, None] + a[inside], y[:, None] + b[inside], zone).mean(axis=1)


def scan(rng, step=10.5, zones=2, noise=0.01, jitter=1.0):
    x, y = (g.ravel() for g in np.meshgrid(np.arange(150.0, 510, step), np.arange(80.0, 330, step)))
    x, y = x + jitter * rng.standard_normal(x.shape), y + jitter * rng.standard_normal(y.shape)
    clean = np.stack([over_patch(x, y, p) for p in range(zones)])
    values = np.maximum(
        clean * (1 + noise * rng.standard_normal(clean.shape)) + 30 * rng.standard_normal(clean.shape), 0
    )
    ids = np.array([f"{i:04d}" for i in range(len(x))])
    return ResponseMaps(values[None], x, y, ids)


def grid(n=400, seed=9):
    rng = np.random.default_rng(seed)
    return rng.uniform(190, 460, n), rng.uniform(110, 300, n)


def test_predicts_the_response_between_the_samples():
    kernel = fit_kernel(scan(np.random.default_rng(0)), RADIUS)
    x, y = grid()
    for zone in range(2):
        error = kernel.response(x, y)[zone] - over_patch(x, y, zone)
        assert np.sqrt(np.mean(error**2)) < 0.01 * 1.3e5


def test_frees_the_map_of_the_patch():
    """The deconvolved kernel must lie nearer the truth than the samples' own blur leaves it."""
    kernel = fit_kernel(scan(np.random.default_rng(0)), RADIUS)
    x, y = grid()
    sharp = np.sqrt(np.mean((kernel.density(x, y)[0] - truth(x, y)) ** 2))
    blurred = np.sqrt(np.mean((over_patch(x, y) - truth(x, y)) ** 2))
    assert sharp < 0.5 * blurred


def test_errors_cover():
    """68 % and 95 % intervals of the response, over six scans."""
    x, y = grid(200)
    pulls = []
    for seed in range(6):
        kernel = fit_kernel(scan(np.random.default_rng(seed), zones=1, noise=0.03), RADIUS)
        pulls.append((kernel.response(x, y)[0] - over_patch(x, y)) / kernel.response_sigma(x, y)[0])
    pulls = np.abs(np.concatenate(pulls))
    assert 0.58 < (pulls < 1).mean() < 0.85
    assert (pulls < 1.96).mean() > 0.88


def test_error_grows_where_nothing_was_sampled():
    maps = scan(np.random.default_rng(0))
    hole = np.flatnonzero(np.hypot(maps.xs - 300, maps.ys - 200) > 45)
    kernel = fit_kernel(maps, RADIUS, hole)
    inside, outside = (kernel.response_sigma(np.array([x]), np.array([200.0]))[0, 0] for x in (300.0, 360.0))
    assert inside > 3 * outside


def test_a_damaged_sample_is_told_and_takes_no_part():
    maps = scan(np.random.default_rng(0))
    k = int(np.hypot(maps.xs - 310, maps.ys - 205).argmin())
    damaged = maps.responses.copy()
    damaged[0, 0, k] += 65_536 * 5
    spoiled = fit_kernel(ResponseMaps(damaged, maps.xs, maps.ys, maps.cap_ids), RADIUS)
    assert spoiled.outliers[0, k]
    assert spoiled.outliers.mean() < 0.01
    clean = fit_kernel(maps, RADIUS)
    x, y = grid()
    difference = spoiled.response(x, y)[0] - clean.response(x, y)[0]
    assert np.abs(difference).max() < 0.06 * 1.3e5


def test_a_dead_zone_is_zero_and_does_not_disturb_the_others():
    maps = scan(np.random.default_rng(0))
    dead = maps.responses.copy()
    dead[0, 1] = 0
    kernel = fit_kernel(ResponseMaps(dead, maps.xs, maps.ys, maps.cap_ids), RADIUS)
    x, y = grid()
    assert (kernel.response(x, y)[1] == 0).all()
    assert (kernel.response_sigma(x, y)[1] < 1e-6).all()
    assert kernel.response(x, y)[0].max() > 1e5


def test_too_few_or_no_samples_are_refused():
    maps = scan(np.random.default_rng(0))
    with pytest.raises(Refusal, match="at least 10"):
        fit_kernel(maps, RADIUS, np.arange(9))
    with pytest.raises(Refusal, match="all are 0"):
        fit_kernel(ResponseMaps(maps.responses * 0, maps.xs, maps.ys, maps.cap_ids), RADIUS)

"""Exchanged zones against maps whose zones are exchanged."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import poisson

from physics.effects.mirrored_zones import effect, gain_in_place
from physics.footprint import footprints
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.zone_order import exchange, exchanged, reordered
from recordings.maps import ResponseMaps

SHARE = st.floats(0, 1)


def other_maps(maps, rows, columns, transposed):
    """The maps in another order, by numpy's own."""
    responses = maps.responses
    responses = np.flipud(responses) if rows else responses
    responses = np.fliplr(responses) if columns else responses
    return replace(maps, responses=np.swapaxes(responses, 0, 1) if transposed else responses)


@pytest.mark.parametrize("rows", [0, 1])
@pytest.mark.parametrize("columns", [0, 1])
@pytest.mark.parametrize("transposed", [0, 1])
def test_whole_exchanges_are_other_maps(small, maps, rows, columns, transposed):
    model = ForwardModel(small.light, small.footprints, small.clock, np.array([1.0, 2, 3, 4]))
    found = model.expected(1e3, [effect.at(rows=rows, columns=columns, transposed=transposed)])
    there = footprints(other_maps(maps, rows, columns, transposed), (6, 10))
    # Time zero and background stay with the zone.
    wanted = ForwardModel(small.light, there, small.clock, np.array([1.0, 2, 3, 4])).expected(1e3)
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


LINES = {
    "zones_exchanged": lambda z: z.reshape(-1, 1),
    "rows_exchanged": lambda z: z,
    "columns_exchanged": lambda z: z.T,
}


@pytest.mark.parametrize("name", LINES)
def test_two_lines_are_exchanged_and_found_to_be(name):
    """Against a permutation written down by indexing; the data say which two, whatever the brightness."""
    zones = np.arange(12).reshape(3, 4)
    lines, order = LINES[name](zones), zones.ravel().copy()
    first, second = 0, len(lines) - 1
    order[lines[first]], order[lines[second]] = lines[second], lines[first]
    values = effect.at(**{name: 1.0, "first": first, "second": second}).values
    mixed = exchanged((3, 4), values)
    np.testing.assert_array_equal(mixed @ np.arange(12), order)
    half = exchanged((3, 4), effect.at(**{name: 0.5, "first": first, "second": second}).values)
    np.testing.assert_allclose(half, (mixed + np.eye(12)) / 2)
    expected = 100 + 50 * np.random.default_rng(2).random((5, 12, 30))
    seen = SimpleNamespace(footprints=SimpleNamespace(zone_grid=(3, 4)), background=0.0)
    starts = effect.starts(3 * expected[:, order] - expected, expected, seen)
    (found,) = [start for start in starts if name in start]
    assert {found["first"], found["second"]} == {first, second}


@given(st.permutations(range(6)))
def test_any_order_is_found_and_made(order):
    """Against a permutation written down by indexing."""
    expected = 100 + 50 * np.random.default_rng(3).random((4, 6, 20))
    seen = SimpleNamespace(footprints=SimpleNamespace(zone_grid=(2, 3)), background=0.0)
    found = effect.starts(3 * expected[:, order] - expected, expected, seen)[-1]
    np.testing.assert_array_equal(found["place"], order)
    values = effect.at(reordered=0.25, place=found["place"]).values
    np.testing.assert_allclose(reordered((2, 3), values) @ np.eye(6), 0.75 * np.eye(6) + 0.25 * np.eye(6)[list(order)])


def test_what_is_no_order_leaves_zones_where_they_were():
    values = effect.at(reordered=1.0, place=[0, 0, 1, 2, 3, 4]).values
    np.testing.assert_array_equal(reordered((2, 3), values), np.eye(6))


def test_what_a_zone_gains_in_the_place_of_another():
    """Against scipy's Poisson likelihood: signal exchanged, level its own, as many counts in all as were recorded."""
    rng = np.random.default_rng(4)
    signal, level = rng.uniform(5, 50, (3, 2, 8)), np.broadcast_to([[4.0], [30.0]], (3, 2, 8))
    counts = rng.poisson(0.7 * signal[:, ::-1] + level).astype(float)

    def likelihood(zone, other):
        bright = (counts[:, zone] - level[:, zone]).sum() / signal[:, other].sum()
        return poisson.logpmf(counts[:, zone], bright * signal[:, other] + level[:, zone]).sum()

    wanted = [[likelihood(z, o) - likelihood(z, z) for o in range(2)] for z in range(2)]
    np.testing.assert_allclose(gain_in_place(counts, signal, level), wanted, atol=1e-6)


@pytest.mark.parametrize("level", [0.0, 40.0])
def test_it_suggests_zones_whose_light_is_exchanged_however_unlike_their_backgrounds(small, level):
    """Backgrounds stay with their zones, and tell nothing of where these look."""
    signal = 100 + 50 * np.random.default_rng(5).random((5, 4, 30))
    background = level * np.arange(4.0)[:, None]
    rendering = Rendering(small.light, small.footprints, small.clock, gain=1.0, background=background)
    starts = effect.starts(signal[:, [0, 3, 2, 1]] - signal, signal + background, rendering)
    (zones,) = [start for start in starts if "zones_exchanged" in start]
    assert (zones["first"], zones["second"]) == (1, 3)


@pytest.mark.parametrize("grid", [(3, 3), (4, 4), (3, 6), (1, 4)])
@pytest.mark.parametrize("which", ["rows", "columns", "transposed"])
def test_a_mirrored_mirror_is_none(grid, which):
    if which == "transposed" and grid[0] != grid[1]:
        return  # Counted down the columns twice is another order.
    whole = exchange(grid, **({"rows": 0, "columns": 0, "transposed": 0} | {which: 1}))
    np.testing.assert_array_equal(whole @ whole, np.eye(grid[0] * grid[1]))


@given(rows=SHARE, columns=SHARE, transposed=SHARE)
def test_light_is_only_exchanged(rows, columns, transposed):
    """Each zone is given whole shares and gives whole shares."""
    mixed = exchange((3, 3), rows, columns, transposed)
    assert (mixed >= 0).all()
    np.testing.assert_allclose(mixed.sum(axis=0), 1)
    np.testing.assert_allclose(mixed.sum(axis=1), 1)
    straight = np.arange(9.0).reshape(3, 3)
    for share, other in ((rows, np.flipud), (columns, np.fliplr), (transposed, np.transpose)):
        straight = (1 - share) * straight + share * other(straight)
    np.testing.assert_allclose(mixed @ np.arange(9.0), straight.ravel(), atol=1e-12)


def test_footprints_that_move_are_exchanged_in_every_frame(small):
    still = replace(small.footprints)
    moving = still.moved(np.zeros((3, 6, 10)), np.array([0.0, 20, 40])[:, None, None])
    values = effect.at(rows=1.0).values
    found = effect.footprints(values, Rendering(small.light, moving, small.clock, 1.0)).weights
    np.testing.assert_allclose(found, moving.weights[:, [2, 3, 0, 1]], rtol=1e-12)


def test_a_grid_that_is_not_square_is_counted_down_its_columns(small):
    responses = np.random.default_rng(1).uniform(1, 2, (2, 3, 20))
    x, y = np.random.default_rng(2).uniform((0, 0), (848, 480), (20, 2)).T
    where = footprints(ResponseMaps(responses, x, y, np.full(20, "a")), (6, 10))
    clock = replace(small.clock, time_zero_s=2e-9)
    model = ForwardModel(small.light, where, clock)
    found = model.expected(1.0, [effect.at(rows=1, columns=1, transposed=0)])
    np.testing.assert_allclose(found, model.expected()[:, ::-1], rtol=1e-9)
    down = model.expected(1.0, [effect.at(rows=0, transposed=1.0)])
    # The second zone is that of the first column's second row, which the maps count as the fourth.
    np.testing.assert_allclose(down, model.expected()[:, [0, 3, 1, 4, 2, 5]], rtol=1e-9)


def test_histograms_that_are_exchanged_may_bring_their_backgrounds_along(small):
    level = np.array([0.5, 3.0, 1.0, 7.0])
    model = ForwardModel(small.light, small.footprints, small.clock, level)
    plain = model.expected(1.0, [effect.at(rows=1, clocks=1)]) - level[:, None]
    found = model.expected(1.0, [effect.at(rows=1, clocks=1, levels=1)])
    np.testing.assert_allclose(found, plain + level[[2, 3, 0, 1]][:, None], rtol=1e-9)
    half = model.expected(1.0, [effect.at(rows=1, clocks=1, levels=0.5)])
    np.testing.assert_allclose(half, plain + (level + level[[2, 3, 0, 1]])[:, None] / 2, rtol=1e-9)


@pytest.mark.parametrize(
    "values", [{"rows": 1}, {"columns": 1, "transposed": 1}, {"reordered": 1, "place": [2, 0, 3, 1]}]
)
def test_histograms_that_are_exchanged_bring_their_clocks_along(small, values):
    clock = replace(small.clock, time_zero_s=np.array([1.0, 1.7, 2.1, 3.2]) * 1e-9)
    model = ForwardModel(small.light, small.footprints, clock)
    maps_alone = ForwardModel(small.light, small.footprints, replace(clock, time_zero_s=np.zeros(1)))
    which = maps_alone.expected(1.0, [effect.at(**values)]), maps_alone.expected()
    order = [int(np.argmin([np.abs(which[0][:, p] - which[1][:, q]).max() for q in range(4)])) for p in range(4)]
    assert order != [0, 1, 2, 3]
    np.testing.assert_allclose(
        model.expected(1.0, [effect.at(clocks=1, **values)]), model.expected()[:, order], rtol=1e-9, atol=1e-12
    )
    # Where the maps are, zones keep their own.
    assert not np.allclose(model.expected(1.0, [effect.at(**values)]), model.expected()[:, order], rtol=1e-3)

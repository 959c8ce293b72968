import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibrate.adaptive import COARSE, LIT, AdaptivePlan
from calibrate.consistency import cosines
from calibrate.kernel import fit_kernel
from calibrate.sparse import spread_order
from recordings.maps_file import load_maps
from recordings.refusal import Refusal

# Tests are no package: the helper beside this file is loaded by its place.
_spec = importlib.util.spec_from_file_location("adaptive_sensor", Path(__file__).with_name("adaptive_sensor.py"))
adaptive_sensor = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(adaptive_sensor)
RADIUS_PX = adaptive_sensor.RADIUS_PX

GRID = np.stack(np.meshgrid(np.arange(10.0, 840, 20), np.arange(10.0, 470, 20)), axis=-1).reshape(-1, 2)


def scanned(maps, **options):
    """The plan run to its end, and the cosine of each zone to the full map at every batch after the coarse pass."""
    plan = AdaptivePlan(np.stack([maps.xs, maps.ys], axis=1), RADIUS_PX, **options)
    full, visited, cosine = maps.by_zone.astype(float), [], {}
    while len(cells := plan.next()):
        visited += cells.tolist()
        plan.learn(cells, full[:, cells], np.sqrt(full[:, cells]))
        if len(visited) >= COARSE + LIT:
            cosine[len(visited)] = cosines(full, plan.expected())
    return plan, visited, cosine


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"accuracy": 1.0}, "accuracy"),
        ({"zone_grid": (8, 8)}, "8 x 8 zones"),
        ({"batch": 0}, "batches"),
        ({"patch_radius_px": 0.0}, "patch radius"),
        ({"centres_px": GRID[:20]}, "20 cells"),
        ({"centres_px": np.full((100, 2), np.nan)}, "finite"),
    ],
)
def test_what_makes_no_scan_is_refused(options, said):
    given = {"centres_px": GRID, "patch_radius_px": RADIUS_PX} | options
    with pytest.raises(Refusal, match=said):
        AdaptivePlan(given.pop("centres_px"), given.pop("patch_radius_px"), **given)


def test_the_coarse_pass_covers_the_image_and_then_the_light():
    plan = AdaptivePlan(GRID, RADIUS_PX)
    first = plan.next()
    assert sorted(first) == sorted(spread_order(GRID, COARSE))
    light = np.exp(-np.square((GRID - [420, 240]) / 90).sum(axis=1))
    plan.learn(first, np.tile(light[first], (9, 1)))
    second = plan.next()
    assert len(second) == LIT
    assert not set(first) & set(second)
    assert np.linalg.norm(GRID[second] - [420, 240], axis=1).max() < 350
    assert plan.reached == 0
    with pytest.raises(Refusal, match="coarse pass"):
        plan.expected()


def test_no_more_than_the_most_and_what_is_lost_is_not_visited_again():
    plan = AdaptivePlan(GRID, RADIUS_PX, most=30)
    first = plan.next()
    lost = np.full((9, len(first)), np.nan)
    plan.learn(first, lost)
    second = plan.next()
    assert len(second) == 30 - COARSE
    assert not set(first) & set(second)
    plan.learn(second, np.zeros((9, len(second))))
    assert len(plan.next()) == 0


def test_a_zone_that_saw_nothing_is_looked_for():
    plan, visited = AdaptivePlan(GRID, RADIUS_PX, most=120), set()
    while len(cells := plan.next()):
        assert not visited & set(cells)
        visited |= set(cells)
        light = np.exp(-np.square((GRID[cells] - [420, 240]) / 90).sum(axis=1))
        plan.learn(cells, np.arange(9)[:, None] * light)
    assert len(visited) == 120
    assert plan.reached == 0


@pytest.mark.parametrize("wrong", [{"responses": np.ones((9, 3))}, {"centres_px": np.ones((3, 2))}])
def test_samples_of_another_shape_are_refused(wrong):
    plan = AdaptivePlan(GRID, RADIUS_PX)
    with pytest.raises(Refusal, match="expected"):
        plan.learn(**({"cells": np.arange(2), "responses": np.ones((9, 2))} | wrong))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 12, 13])
def test_the_plan_ends_when_the_maps_are_as_good_as_it_says(seed):
    maps = adaptive_sensor.sensor(seed)
    plan, visited, cosine = scanned(maps, accuracy=0.99)
    assert len(set(visited)) == len(visited) < 250
    reached = cosine[len(visited)].min()
    assert plan.reached >= 0.99
    assert 1 - reached < 1.5 * (1 - plan.reached)
    x, y = maps.xs.astype(float), maps.ys.astype(float)
    order = np.sort(spread_order(np.stack([x, y], axis=1), 2 * len(visited)))
    even = cosines(maps.by_zone.astype(float), fit_kernel(maps, RADIUS_PX, order).response(x, y))
    assert even.min() < reached


@pytest.mark.slow
def test_published_maps_at_a_third_of_the_points(shared_data):
    maps = load_maps(shared_data / "tmf8828_response_maps" / "spad_calib_3x3_longrange_bins15_35.npz")
    plan, visited, cosine = scanned(maps, accuracy=0.9999, most=270)
    # Evenly spread positions need about 550 for the first and 830 for the second.
    assert cosine[126].min() > 0.97
    assert max(c.min() for n, c in cosine.items() if n <= 270) > 0.99
    assert 1 - cosine[len(visited)].min() < 1.5 * (1 - plan.reached)


@pytest.mark.slow
def test_maps_of_another_mode_make_the_coarse_pass_unnecessary():
    maps = adaptive_sensor.sensor(14, 40, 23)
    field = np.stack([maps.xs, maps.ys], axis=1)
    other = replace(maps, responses=(maps.responses * 0.2 + 50).astype(np.float32))
    plan = AdaptivePlan(field, RADIUS_PX, prior=other)
    first = plan.next()
    assert len(first) == LIT
    assert (maps.normalised[:, first] > 0.01).any(axis=0).mean() > 0.9
    plan.learn(first, maps.by_zone[:, first])
    assert cosines(maps.by_zone.astype(float), plan.expected()).min() > 0.95


def test_a_prior_of_other_zones_is_refused():
    maps = adaptive_sensor.sensor(14, 12, 8)
    other = replace(maps, responses=maps.responses.reshape(9, 1, -1))
    with pytest.raises(Refusal, match="prior"):
        AdaptivePlan(GRID, RADIUS_PX, prior=other)

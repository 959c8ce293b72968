"""Counting right answers, on answers written by hand."""

import pytest
from scipy.stats import beta

from mismatch.prove.scores import Answered, Rate, score_answers


def effect(name, look_alikes=(), **parameters):
    return {
        "id": name,
        "parameters": [{"name": n.replace("_at_", "[") + "]" * ("_at_" in n), "value": v, "sigma": s, "unit": "1"}
                       for n, (v, s) in parameters.items()],
        "look_alikes": [{"id": i, "probability": p, "separated_by": ""} for i, p in look_alikes],
    }  # fmt: skip


def case(truth, verdict, named=(), *, kind=None, stranger=None, gap=0.9, moved=500.0):
    effects = [{"id": name, "parameters": parameters} for name, parameters in truth.items()]
    said = {"verdict": verdict, "effects": list(named), "fit": {"gap_closed": gap}, "seconds": 2.0}
    return Answered({"kind": kind, "effects": effects, "stranger": stranger, "deviance_moved": moved}, said)


ANSWERS = [
    # Right, one parameter 0.5 sigma off, the other 1.5.
    case({"impulse_tail": {"share": 0.1, "tau": 3e-10}}, "explained",
         [effect("impulse_tail", share=(0.105, 0.01), tau=(4.5e-10, 1e-10))], gap=0.8, moved=900.0),
    # Wrong, but the likeliest look-alike.
    case({"pile_up": {"share": 1.0}}, "explained", [effect("range_walk", [("gain_drift", 0.1), ("pile_up", 0.3)])]),
    # Wrong, and only the second look-alike.
    case({"pile_up": {"share": 1.0}}, "explained", [effect("range_walk", [("gain_drift", 0.3), ("pile_up", 0.1)])]),
    # Not found.
    case({"zone_gain": {"factor": 1.1}}, "agrees", gap=None),
    # Right, a value for each zone, 3 sigma and 0 off.
    case({"time_zero_offset": {"delay": [1.1, 0.9]}}, "explained",
         [effect("time_zero_offset", delay_at_0=(1.13, 0.01), delay_at_1=(0.9, 0.01))], gap=1.0),
    case({}, "agrees"), case({}, "agrees"), case({}, "explained", [effect("pile_up")]), case({}, "unknown"),
    case({}, "unknown", stranger="flicker"), case({}, "explained", [effect("time_lag")], kind="unknown"),
    case({"a_cause_of_tomorrow": {}}, "unknown"),
    case({"pile_up": {}, "stray_light": {}}, "explained", [effect("stray_light"), effect("pile_up")], gap=0.7),
    case({"pile_up": {}, "stray_light": {}}, "explained", [effect("stray_light")]),
]  # fmt: skip


@pytest.fixture(scope="module")
def scores():
    return score_answers(ANSWERS)


def test_kinds_are_told_by_the_truth():
    kinds = [answered.kind for answered in ANSWERS]
    assert kinds == ["single"] * 5 + ["nothing"] * 4 + ["unknown"] * 3 + ["pair"] * 2


def test_rates(scores):
    assert scores.named == Rate(2, 5)
    assert scores.among_two == Rate(3, 5)
    assert scores.false_alarms == Rate(2, 4)
    assert scores.unknown == Rate(2, 3)
    assert scores.pairs == Rate(1, 2)
    assert scores.gap_closed == pytest.approx(0.8)
    assert scores.seconds == 2.0


def test_pulls_of_what_was_named(scores):
    # 0.5, 1.5, 3 and 0 sigma.
    assert scores.within_68 == Rate(2, 4)
    assert scores.within_95 == Rate(3, 4)


def test_a_factor_that_all_zones_share_is_the_gain():
    found = [effect("zone_gain", factor_at_0=(1.21, 0.01), factor_at_1=(0.99, 0.01))]
    scores = score_answers([case({"zone_gain": {"factor": [1.1, 0.9]}}, "explained", found)])
    assert scores.within_68 == Rate(2, 2)


def test_confusion_and_faintness(scores):
    assert scores.confusion == {
        ("impulse_tail", "impulse_tail"): 1, ("pile_up", "range_walk"): 2, ("zone_gain", "agrees"): 1,
        ("time_zero_offset", "time_zero_offset"): 1, ("nothing", "agrees"): 2, ("nothing", "pile_up"): 1,
        ("nothing", "unknown"): 1,
        ("unknown", "unknown"): 2, ("unknown", "time_lag"): 1, ("pile_up+stray_light", "pile_up+stray_light"): 1,
        ("pile_up+stray_light", "stray_light"): 1,
    }  # fmt: skip
    assert scores.faint[0] == (900.0, True)
    assert [named for _, named in scores.faint] == [True, False, False, False, True]


@pytest.mark.parametrize(("hits", "cases"), [(0, 40), (3, 40), (40, 40), (7, 9)])
def test_the_interval_is_that_of_clopper_and_pearson(hits, cases):
    low = beta.ppf(0.025, hits, cases - hits + 1) if hits else 0.0
    high = beta.ppf(0.975, hits + 1, cases - hits) if hits < cases else 1.0
    assert Rate(hits, cases).interval == pytest.approx((low, high))


def test_a_rate_of_nothing_says_nothing():
    assert Rate(0, 0).interval == (0.0, 1.0)
    assert Rate(0, 0).value != Rate(0, 0).value
    assert str(Rate(1, 4)).startswith("1 of 4 (25.0 %")

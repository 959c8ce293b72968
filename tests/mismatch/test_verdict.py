"""The verdict file: the fields of the format and no others, and no number that JSON does not know."""

import json

import numpy as np

from mismatch.places import Place
from mismatch.verdict import Alternative, Deviance, Estimate, Named, NotVisible, Verdict

# The format, and `notes`, which it leaves open.
FIELDS = {
    "format", "verdict", "located", "effects", "fit", "unexplained", "not_visible", "next_measurement", "seconds",
    "notes",
}  # fmt: skip
PLACE = {"zones", "bins", "frames", "follows", "share_of_misfit", "p_value", "sentence"}


def verdict(**changed):
    place = Place((0, np.int64(3)), (12, 15), (0, 95), "range", 0.41, 1e-9, 30.0, "zones 0, 3")
    alike = Alternative("range_walk", 0.03, "Swap the target.")
    effect = Named("pile_up", "One.", (Estimate("share", 0.5, np.float64(0.1), "1"),), 10.0, 1e-5, 11.0, (alike,))
    values = {
        "verdict": "explained", "located": (place,), "effects": (effect,), "train": Deviance(2.0, 1.0, 1.0),
        "heldout": Deviance(2.1, 1.1, 1.0), "gap_closed": 0.9, "unexplained": (place,),
        "not_visible": (NotVisible("multipath", float("inf"), "1"),), "next_measurement": None, "seconds": 0.1,
    }  # fmt: skip
    return Verdict(**(values | changed))


def fail_on_constant(name):
    raise AssertionError(f"{name} in the file")


def test_its_fields_are_those_of_the_format():
    held = json.loads(verdict().text(), parse_constant=fail_on_constant)
    assert held["format"] == "difflidar-verdict/1"
    assert held.keys() == FIELDS
    assert held["located"][0].keys() == PLACE
    assert held["unexplained"][0].keys() == PLACE
    assert held["fit"].keys() == {"train", "heldout", "gap_closed"}
    for half in ("train", "heldout"):
        assert held["fit"][half].keys() == {"nominal", "explained", "floor"}
    effect = held["effects"][0]
    expected = {"id", "sentence", "parameters", "heldout_gain", "p_value", "expected_gain", "look_alikes"}
    assert effect.keys() == expected
    assert effect["parameters"][0].keys() == {"name", "value", "sigma", "unit"}
    assert effect["look_alikes"][0].keys() == {"id", "probability", "separated_by"}
    assert held["not_visible"][0].keys() == {"id", "smallest_visible", "unit"}


def test_numbers_come_back_and_what_is_none_is_null():
    held = json.loads(verdict(gap_closed=float("nan"), seconds=np.float32(2.0)).text(), parse_constant=fail_on_constant)
    assert held["located"][0]["zones"] == [0, 3]
    assert held["located"][0]["share_of_misfit"] == 0.41
    assert held["not_visible"][0]["smallest_visible"] is None
    assert held["fit"]["gap_closed"] is None
    assert held["next_measurement"] is None
    assert held["seconds"] == 2.0

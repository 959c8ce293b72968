"""What is said of effects against the effects themselves."""

import json

import pytest

from difflidar.cli import main
from physics.effects import all_effects, find_effect
from physics.setting import OF_EVERY


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main(list(arguments))
    return ended.value.code


def squeezed(text):
    """Without the frames of tables and where lines are broken."""
    return "".join(c for c in text if c.isalnum())


def test_all_are_listed_in_the_order_in_which_they_act(capsys):
    assert run("effects") == 0
    said = capsys.readouterr().out
    places = [said.index(name) for name in ("multipath", "parallax", "range_walk", "pile_up", "bin_phase")]
    assert places == sorted(places)
    assert all(name in said for name in all_effects())


@pytest.mark.parametrize("name", sorted(all_effects()))
def test_of_one_its_parameters_and_look_alikes_are_told(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "400")
    assert run("effects", name) == 0
    said, effect = squeezed(capsys.readouterr().out), find_effect(name)
    assert squeezed(effect.sentence) in said
    for parameter in (*effect.parameters, *OF_EVERY):
        assert squeezed(parameter.name) in said
        assert squeezed(parameter.sentence) in said
    for other in effect.look_alikes:
        assert squeezed(other.separated_by) in said


def test_as_json(capsys):
    assert run("effects", "range_walk", "--json") == 0
    said = json.loads(capsys.readouterr().out)
    effect = find_effect("range_walk")
    assert (said["id"], said["acts_on"], said["sentence"]) == ("range_walk", "time", effect.sentence)
    assert [tuple(form) for form in said["forms"]] == list(effect.forms)
    assert {one["name"]: one["vanishes_at"] for one in said["parameters"]}["walk"] == 0
    assert run("effects", "--json") == 0
    assert {one["id"] for one in json.loads(capsys.readouterr().out)} == set(all_effects())


def test_one_that_is_not_known_is_refused(capsys):
    assert run("effects", "magic") == 2
    assert "effect 'magic' is unknown, expected one of afterpulsing" in capsys.readouterr().err

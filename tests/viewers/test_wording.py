import pytest
from hypothesis import given
from hypothesis import strategies as st

from mismatch.verdict import Estimate
from viewers.wording import chance, found_in_words, grouped, number, quantity


@pytest.mark.parametrize(
    ("value", "sigma", "unit", "text"),
    [
        (-1.718e-11, 3.03e-12, "s", "−17.2 ± 3.0 ps"),
        (0.1234, 0.0123, "1", "0.123 ± 0.012"),
        (3.2e-7, 1e-8, "1", "3.2·10⁻⁷ ± 1·10⁻⁸"),
        (120.2, 13.0, "counts", "120 ± 13 counts"),
        (0.02, 0.001, "m", "20.0 ± 1.0 mm"),
        (0.0, 0.0, "s", "0 s"),
        (5.0, float("nan"), "px", "5 px"),
        (float("inf"), None, "s", "– s"),
        (float("nan"), 1.0, "1", "–"),
    ],
)
def test_quantities(value, sigma, unit, text):
    assert quantity(value, sigma, unit) == text


@given(st.floats(), st.none() | st.floats(min_value=0), st.sampled_from(["1", "s", "m", "px²"]))
def test_every_quantity_can_be_said(value, sigma, unit):
    said = quantity(value, sigma, unit)
    assert said.endswith("" if unit == "1" else unit)
    assert not any(word in said for word in ("nan", "inf", "e+", "e-"))


@given(st.floats(0, 1))
def test_every_chance_can_be_said(p_value):
    assert "e-" not in chance(p_value)


def test_numbers_and_chances():
    assert [number(v) for v in (1.2345, -0.5, 2e9, float("nan"))] == ["1.23", "−0.5", "2·10⁹", "–"]
    assert [chance(p) for p in (0.0, 1.2e-97, 0.031)] == ["below 10⁻³⁰⁰", "10⁻⁹⁷", "0.031"]


def test_parameters_go_together_by_name():
    parameters = [Estimate(name, 1.0, 0.1, "1") for name in ("share", "delay[0]", "delay[10]")]
    assert [(name, [i for i, _ in values]) for name, values in grouped(parameters)] == [
        ("share", [""]),
        ("delay", ["0", "10"]),
    ]


def test_a_verdict_in_words(explanations):
    said = {kind: found_in_words(explanation.verdict) for kind, explanation in explanations.items()}
    assert said["agrees"].startswith("Nothing in the recording differs")
    assert said["explained"].startswith("The recording differs from its simulation because of impulse tail.")
    assert "97 % of the gap" in said["explained"]
    assert "Part of it goes with impulse tail" in said["unknown"]
    assert "no effect in the library explains any of it" in said["nothing fits"]
    for kind in ("unknown", "nothing fits"):
        assert "Most of what is left sits in zones 1, 2" in said[kind]

"""What every effect must be, whatever it does: written once, run over all that are known."""

import numpy as np
import pytest

from mismatch.form import DRAWN
from physics.effect import Effect, Parameter
from physics.effects import all_effects, fault_of, find_effect
from physics.nominal import ForwardModel
from physics.sensitivity import difference
from physics.setting import OF_EVERY, STAGES, in_order
from recordings.refusal import Refusal

GAIN = 2e3
EVERY = sorted(all_effects())


@pytest.fixture
def model(small):
    return ForwardModel(small.light, small.footprints, small.clock, np.array([1.0, 2, 0.5, 3]))


@pytest.mark.parametrize("name", EVERY)
class TestEveryEffect:
    def test_is_described(self, name):
        effect = find_effect(name)
        assert fault_of(effect, name) is None
        assert effect.sentence.endswith(".")
        assert effect.look_alikes
        assert all(look.separated_by.endswith(".") and look.id != name for look in effect.look_alikes)
        for parameter in effect.parameters:
            assert parameter.low <= parameter.start <= parameter.high
            assert parameter.sentence.endswith(".")

    def test_vanishes(self, name, model):
        gone = model.expected(GAIN, [find_effect(name).vanished()])
        np.testing.assert_allclose(gone, model.expected(GAIN), rtol=1e-12)

    def test_shows_at_its_start(self, name, model):
        found = model.expected(GAIN, [find_effect(name).at()])
        assert np.isfinite(found).all()
        assert (found >= 0).all()
        assert np.abs(found - model.expected(GAIN)).max() > 1

    def test_fades_as_it_weakens(self, name, model):
        effect, nominal = find_effect(name), model.expected(GAIN)
        before = np.inf
        for strength in (1, 1e-2, 1e-4):
            values = {
                p.name: p.vanishes_at + strength * (p.start - p.vanishes_at)
                for p in effect.parameters
                if p.vanishes_at is not None
            }
            departure = np.abs(model.expected(GAIN, [effect.at(**values)]) - nominal).max()
            assert departure < before
            before = departure
        assert before < 1e-2 * nominal.max()

    def test_derivatives_add_up_to_the_change(self, name, model):
        """The fundamental theorem of calculus, through the kinks that counts have: knots of time, triangles of maps."""
        for parameter in find_effect(name).parameters:
            form = next((f for f in find_effect(name).forms if parameter.name in f), ())
            start = find_effect(name).at(**{n: find_effect(name).parameter(n).start for n in form})

            def at(there, parameter=parameter, start=start):
                return model.expected(GAIN, [start.with_value(parameter.name, there)])

            size = 0.3 * parameter.size
            inward = -size if parameter.start + size > parameter.high else size
            # Counts go smoothly with how maps are drawn, which takes longer than all else.
            drawn = start.effect.redraws_maps(start.values)
            nodes, shares = np.polynomial.legendre.leggauss(10 if drawn else 40)
            slopes = [difference(at, parameter.start + inward * (1 + node) / 2, parameter) for node in nodes]
            change = at(parameter.start + inward) - at(parameter.start)
            summed = inward / 2 * np.tensordot(shares, slopes, axes=1)
            np.testing.assert_allclose(summed, change, atol=0.03 * np.abs(change).max() + 1e-6)

    def test_each_zone_may_have_its_own_where_it_says_so(self, name, model):
        effect = find_effect(name)
        for parameter in effect.parameters:
            if parameter.axis in DRAWN:
                continue
            if parameter.axis != "zone":
                with pytest.raises(Refusal, match="expected one number"):
                    effect.at(**{parameter.name: [parameter.start] * 4})
                continue
            gone = parameter.vanishes_at if parameter.vanishes_at is not None else parameter.start
            found = model.expected(GAIN, [effect.at(**{parameter.name: [gone, gone, parameter.start, gone]})])
            alone = model.expected(GAIN, [effect.at(**{parameter.name: parameter.start})])
            np.testing.assert_allclose(found[:, 2], alone[:, 2], rtol=1e-6)
            if parameter.vanishes_at is not None:
                np.testing.assert_allclose(found[:, [0, 1, 3]], model.expected(GAIN)[:, [0, 1, 3]])


def test_values_out_of_bounds_and_of_other_names_are_refused():
    with pytest.raises(Refusal, match=r"effect pile_up: share is 1\.5, expected 0 to 1$"):
        find_effect("pile_up").at(share=1.5)
    with pytest.raises(Refusal, match="'strength' is no parameter of it, expected one of share"):
        find_effect("pile_up").at(strength=1)
    with pytest.raises(Refusal, match="tau is nan"):
        find_effect("impulse_tail").at(tau=np.nan)
    with pytest.raises(Refusal, match="expected a number"):
        find_effect("impulse_tail").at(tau="long")
    with pytest.raises(Refusal, match="effect 'fog' is unknown, expected one of"):
        find_effect("fog")


def test_an_effect_is_on_once():
    setting = find_effect("pile_up").at()
    with pytest.raises(Refusal, match="pile_up is named twice"):
        in_order((setting, setting))


class Brighter(Effect):
    """An effect from outside."""

    id = "brighter"
    acts_on = "scene"
    sentence = "Everything is brighter."
    parameters = (Parameter("more", "1", 0.0, 9.0, 1.0, "By how much.", vanishes_at=0.0),)

    def expected(self, values, rendering):
        return rendering.expected * (1 + values["more"])


def test_effects_come_from_other_packages(monkeypatch):
    import physics.effects as effects

    class Entry:
        name, value = "brighter", "elsewhere:effect"

        @staticmethod
        def load():
            return Brighter()

    monkeypatch.setattr(effects, "entry_points", lambda group: [Entry] if group == "difflidar.effects" else [])
    effects.all_effects.cache_clear()
    try:
        of_every = {parameter.name: 0.0 for parameter in OF_EVERY}
        assert effects.find_effect("brighter").at(more=2).values == {"more": 2.0} | of_every
        monkeypatch.setattr(Entry, "name", "pile_up")
        effects.all_effects.cache_clear()
        with pytest.raises(Refusal, match="pile_up of elsewhere:effect has the id 'brighter'"):
            effects.all_effects()
    finally:
        monkeypatch.undo()
        effects.all_effects.cache_clear()


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"id": "other"}, "has the id 'other'"),
        ({"acts_on": "sky"}, "acts on 'sky', expected one of " + ", ".join(STAGES)),
        ({"parameters": ()}, "never vanishes"),
    ],
)
def test_what_is_no_effect_is_told_why(change, fault):
    assert fault_of(Brighter(), "brighter") is None
    assert fault in fault_of(type("Wrong", (Brighter,), change)(), "brighter")
    assert "is int" in fault_of(3, "brighter")

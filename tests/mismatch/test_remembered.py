"""Changes that are remembered: what stands out is found as without them, and in fewer renderings. And parts."""

from dataclasses import replace

import numpy as np

from mismatch.fit import fit, fit_nominal
from mismatch.form import all_forms, forms_of
from mismatch.ranking import KNOWN, ranked
from mismatch.remembered import MOST_NUMBERS, PARTS, Remembered
from mismatch.work import Work
from physics.effects import find_effect

SIZES = {"zone": 4, "bin": 48}


def test_what_stands_out_beside_a_later_fit_is_what_a_fresh_look_finds(drawn):
    simulation = replace(drawn(3, "impulse_tail", share=0.1, tau=0.6e-9), work=Work())
    # Every third effect: what is asked of each does not depend on the others.
    forms = all_forms(SIZES)
    some = sorted({form.effect.id for form in forms})[1::3]
    forms = [form for form in forms if form.effect.id in some]
    nominal = fit_nominal(simulation)
    (pedestal, *_) = forms_of(find_effect("ambient_pedestal"), SIZES)
    later = fit(simulation, (pedestal,), np.concatenate([nominal.x, pedestal.at_start()]))
    others = [form for form in forms if form.effect.id != "ambient_pedestal"]

    def renderings(sim):
        began = sim.work.renderings
        found, tried = ranked(sim, later, others)
        return {(s.form.name, s.form.begins_alike): s for s in found}, tried, sim.work.renderings - began

    ranked(simulation, nominal, forms)
    quick, tried, few = renderings(simulation)
    exact, all_tried, many = renderings(replace(simulation, work=Work()))
    assert few < 0.8 * many
    telling = {key for key, s in exact.items() if s.log_p < 4 * KNOWN}
    assert telling
    assert abs(tried - all_tried) <= 0.02 * all_tried
    for key in telling:
        assert quick[key].gain == exact[key].gain
    assert all(s.log_p < 2 * KNOWN for key, s in exact.items() if key in quick and quick[key].log_p < 4 * KNOWN)


def test_beside_what_differs_by_much_nothing_is_remembered():
    memory, counts = Remembered(), np.full((2, 3, 4), 10.0)
    assert not memory.beginning(counts, frozenset())
    memory.keep("a", lambda: counts / 10)
    assert memory.beginning(1.1 * counts, frozenset())
    assert set(memory.changes) == {"a"}
    assert not memory.beginning(1.5 * counts, frozenset())
    assert not memory.changes


def test_beside_what_another_effect_makes_nothing_is_remembered():
    memory, counts, one, two = Remembered(), np.full((2, 3, 4), 10.0), frozenset({"one"}), frozenset({"two"})
    memory.beginning(counts, one)
    memory.keep("a", lambda: counts / 10)
    for names in (one | two, frozenset(), one):
        assert memory.beginning(counts, names)
    assert not memory.beginning(counts, two)
    assert not memory.changes


def test_what_there_is_no_room_for_is_made_and_not_kept():
    memory = Remembered()
    large = np.broadcast_to(np.ones(1), (MOST_NUMBERS + 1,))
    assert memory.keep("large", lambda: large) is large
    assert not memory.changes


def test_the_same_frames_are_the_same_part_as_long_as_few_others_are_asked_for(drawn):
    simulation, some = drawn(3), np.array([1, 5, 7])
    memory = simulation.remembered
    part = memory.part(simulation, some)
    np.testing.assert_array_equal(part.counts, simulation.counts[some])
    assert memory.part(simulation, some.copy()) is part
    for i in range(PARTS):
        memory.part(simulation, np.array([i]))
    assert memory.part(simulation, some) is not part
    assert len(memory.parts) == PARTS


def test_what_is_made_anew_takes_no_more_room():
    memory, quarter = Remembered(), np.zeros(MOST_NUMBERS // 4, np.float32)
    for _ in range(8):
        memory.keep("one", lambda: quarter)
    for name in ("two", "three", "four", "five"):
        memory.keep(name, lambda: quarter)
    assert set(memory.changes) == {"one", "two", "three", "four"}

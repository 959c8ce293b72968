"""A glance at every second frame: what it leaves out all frames would not have chosen, and it costs less."""

from dataclasses import replace

import numpy as np
import pytest

from mismatch import glance, ranking
from mismatch.fit import fit_nominal
from mismatch.form import all_forms, forms_of
from mismatch.gained import SIGNIFICANT, to_be_gained
from mismatch.glance import FAINT, NOTHING, glanced, promised
from mismatch.projection import Projection
from mismatch.ranking import ranked
from physics.effects import find_effect

from .conftest import BINS, ZONES

SIZES = {"zone": ZONES, "bin": BINS}
CONCEALED = {None: {}, "impulse_tail": {"share": 0.1, "tau": 0.6e-9}, "gain_drift": {"rate": 0.1}}


@pytest.mark.parametrize("concealed", CONCEALED)
def test_what_is_told_by_half_of_the_frames_would_not_have_been_chosen(drawn, monkeypatch, concealed):
    simulation = drawn(6, concealed, **CONCEALED[concealed])
    forms, nominal = all_forms(SIZES)[::3], fit_nominal(simulation)

    def ranking_by(enough):
        seen = []

        def counted(*args):
            seen.append(len(args[0].frames))
            return promised(*args)

        monkeypatch.setattr(ranking, "ENOUGH", enough)
        for room in (ranking, glance):
            monkeypatch.setattr(room, "promised", counted)
        scores, tried = ranked(replace(simulation), nominal, forms)
        return {(s.form.name, s.form.begins_alike): s for s in scores}, tried, sum(seen)

    quick, tried, few = ranking_by(0)
    exact, all_tried, many = ranking_by(1000)
    assert abs(tried - all_tried) <= 0.02 * all_tried
    assert few < 0.85 * many
    most = max(s.gain for s in exact.values())
    # What stands out, and promises enough to be fitted, is what all frames say of it.
    chosen = {
        key for key, s in exact.items()
        if s.log_p < np.log(SIGNIFICANT / tried) and s.gain > 2 * FAINT * min(most, to_be_gained(nominal))
    }  # fmt: skip
    assert bool(chosen) == (concealed is not None)
    for key in chosen:
        assert quick[key].gain == exact[key].gain
    # And the rest is not made out to be more.
    assert max(s.gain for s in quick.values()) <= 1.2 * most


def test_what_a_glance_tells_is_what_all_frames_would_within_noise(drawn):
    simulation = drawn(7, "impulse_tail", share=0.1, tau=0.6e-9)
    nominal = fit_nominal(simulation)
    names = ("impulse_tail", "zone_gain")
    forms = {form.begins_alike: form for name in names for form in forms_of(find_effect(name), SIZES)}
    projection = Projection(simulation, nominal)
    exact = {key: promised(simulation, nominal, False, projection, form) for key, form in forms.items()}
    most = max(s.gain for s in exact.values() if s is not None)
    found = glanced(simulation, nominal, np.inf, [forms])
    assert found
    for key, about in found.items():
        # Half of the frames: what they tell of the gain scatters as its root, and by what noise is worth.
        assert abs(about.gain - exact[key].gain) < 4 * np.sqrt(2 * exact[key].gain + 2 * about.dof)
        assert about.information == pytest.approx(exact[key].information, rel=0.35)
        assert about.log_p > NOTHING or about.gain < 1.5 * FAINT * most

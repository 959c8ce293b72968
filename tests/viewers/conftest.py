"""A small explanation, made without a search: the fits are real, the verdict is written by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mismatch.blocks import halves
from mismatch.explain import Explanation
from mismatch.fit import fit, fit_nominal
from mismatch.form import Form
from mismatch.places import Place
from mismatch.simulation import Simulation
from mismatch.verdict import Alternative, Deviance, Estimate, Named, NotVisible, Verdict
from physics.clock import Clock
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.pulse import tailed_pulse
from recordings.maps import ResponseMaps

FRAMES, ZONES, BINS = 8, 4, 40
PLACE = Place((1, 2), (10, 19), (2, 5), "range", 0.8, 1e-12, 90.0, "zones 1, 2, bins 10 to 19, going with <range>")


@pytest.fixture(scope="session")
def simulation():
    """8 frames of 6 × 10 pixels, 4 zones of 40 bins; the recording has a late tail that the simulation lacks."""
    rng = np.random.default_rng(5)
    x, y = (g.ravel() + rng.uniform(-3, 3, 80) for g in np.meshgrid(np.linspace(40, 800, 10), np.linspace(30, 450, 8)))
    centres = [(250, 150), (600, 160), (260, 330), (580, 340)]
    responses = np.stack([1e5 * np.exp(-(((x - a) / 120) ** 2) - ((y - b) / 90) ** 2) for a, b in centres])
    maps = ResponseMaps(responses.reshape(2, 2, -1), x, y, np.arange(80).astype(str))
    shape = (FRAMES, 6, 10)
    intrinsics = np.array([[7.5, 0, 4.5], [0, 7.5, 2.5], [0, 0, 1]])
    light = direct_light(rng.uniform(0.3, 1, shape), intrinsics, rng.uniform(0.2, 1, shape), time_s=np.arange(8) / 10)
    width = 0.26e-9
    clock = Clock(width, BINS, np.full(ZONES, 2e-9), tailed_pulse(0.2e-9, 0.3e-9, 0.3e-9, 0.1, step_s=width / 8))
    where, background = footprints(maps, shape[1:]), np.full(ZONES, 5.0)
    bare = Simulation(np.zeros((FRAMES, ZONES, BINS)), light, where, clock, background, np.arange(FRAMES))
    gain = 2e3 / (bare.expected(1.0) - 5).max()
    tail = find_effect("impulse_tail").at(share=0.2, tau=0.6e-9)
    return replace(bare, counts=rng.poisson(bare.expected(gain, (tail,))).astype(float))


@pytest.fixture(scope="session")
def explanations(simulation):
    """By verdict."""
    effect = find_effect("impulse_tail")
    form = Form(effect, ("share", "tau"), (), {p.name: p.start for p in effect.parameters})
    chosen, held = halves(FRAMES)
    nominal = fit_nominal(simulation)
    explained = fit(simulation, (form,), np.concatenate([nominal.x, form.at_start()]))
    candidate = SimpleNamespace(form=form, observed=140.0, expected_gain=150.0, z=12.0)
    rounds = (
        SimpleNamespace(before=nominal, tried=7, candidates=(candidate,), chosen=candidate),
        SimpleNamespace(before=explained, tried=5, candidates=(), chosen=None),
    )
    parameters = (
        Estimate("share", 0.2, 0.01, "1"),
        Estimate("duration[0]", 1.2e-11, 3e-12, "s"),
        Estimate("duration[1]", -3.4e-11, 3e-12, "s"),
    )
    other = Alternative("afterpulsing", 0.25, "Record <b>less</b> light.")
    named = Named("impulse_tail", effect.sentence, parameters, 140.0, 1e-30, 150.0, (other,))
    hidden = (NotVisible("pile_up", 0.02, "1"), NotVisible("parallax", float("inf"), "m"))
    fits = Deviance(3.0, 1.02, 1.01), Deviance(3.1, 1.03, 1.01)
    flat = Deviance(1.01, 1.01, 1.01)
    verdicts = {
        "agrees": Verdict("agrees", (), (), flat, flat, None, (), hidden, None, 1.0),
        "explained": Verdict("explained", (PLACE,), (named,), *fits, 0.97, (), hidden, "Record & see.", 1.0, ("<i>",)),
        "unknown": Verdict("unknown", (PLACE,), (named,), *fits, 0.4, (PLACE,), hidden, None, 1.0),
        "nothing fits": Verdict("unknown", (PLACE,), (), flat, flat, None, (PLACE,), hidden, None, 1.0),
    }
    bare = (SimpleNamespace(before=nominal, tried=5, candidates=(), chosen=None),)
    return {
        kind: Explanation(
            verdict,
            simulation,
            chosen,
            held,
            nominal,
            explained if verdict.effects else nominal,
            explained if verdict.effects else nominal,
            rounds if verdict.effects else bare,
        )
        for kind, verdict in verdicts.items()
    }

"""A sealed recording: drawn photon by photon, with a cause concealed, or two, or none, or one that nobody knows."""

import json
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mismatch.form import DRAWN
from mismatch.prove.rig import Rig, draw_rig
from mismatch.prove.shown import MOVED, moved, strength_for
from mismatch.prove.strangers import STRANGERS
from physics.axes import sizes_along
from physics.effect import Effect
from physics.effects import all_effects
from physics.footprint import footprints
from physics.nominal import ForwardModel
from physics.rendering import Rendering
from physics.setting import Setting
from physics.simulate import light_of
from physics.single_photons.acts import all_acts
from physics.single_photons.engine import record
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal

KINDS = ("single", "nothing", "pair", "unknown")
SHARES = (0.45, 0.27, 0.13, 0.15)
FRAMES = (48, 96)
TRIES = 12
# How often an effect is concealed in the first of its forms. How many times as strong as at its start one strength of
# several is, or that of one zone.
FIRST, UNLIKE = 0.5, (0.2, 1.8)


@dataclass(frozen=True, eq=False)
class Case:
    """A recording to explain, and the truth that is not shown. truth: as the ledger holds it."""

    recording: Recording
    maps: ResponseMaps
    truth: dict[str, Any]


def draw_case(rng: np.random.Generator) -> Case:
    """One case; rigs in which the cause cannot show are drawn anew."""
    kind = str(rng.choice(KINDS, p=SHARES))
    for _ in range(TRIES):
        rig = draw_rig(rng, int(rng.choice(FRAMES)))
        views = list(rig.views.views)
        light = light_of(views, rig.views.intrinsics, rig.sensor, views[0].timestamp_s)
        where = footprints(rig.maps, light.range_m.shape[1:], 0.6)
        model = ForwardModel(light, where, rig.sensor.clock, rig.sensor.background_counts)
        fullest = model.expected().max() - rig.sensor.background_counts.max()
        if not fullest > 0:
            continue
        gain = rig.peak / fullest
        rendering = Rendering(light, where, rig.sensor.clock, gain, background=model.expected(0.0)[:1, :, :1])
        concealed = _concealed(rng, kind, model, rendering)
        if concealed is not None:
            return _recorded(rng, rig, views, gain, kind, *concealed)
    raise Refusal(f"no scene in {TRIES} showed a cause of kind {kind}, expected one")


def _concealed(rng, kind: str, model: ForwardModel, rendering: Rendering):
    """Settings, a stranger's change of counts or None, and its name; None where the cause does not show.

    Nor what nobody would call by its name: that of surfaces where it stays in the view and they do not.
    """
    gain = rendering.gain
    nominal, dark = model.expected(gain), model.expected(0.0)
    if kind == "nothing":
        return (), None, None, 0.0
    target = float(np.exp(rng.uniform(*np.log(MOVED))))
    if kind == "unknown":
        name = str(rng.choice(sorted(STRANGERS)))
        seed = int(rng.integers(1 << 31))

        def changed(strength: float) -> np.ndarray:
            return STRANGERS[name](nominal, strength, np.random.default_rng(seed))

        strength = strength_for(lambda s: moved(changed(s), nominal, dark), target)
        return None if strength is None else ((), changed(strength), name, moved(changed(strength), nominal, dark))
    names = rng.choice(sorted(set(all_effects()) & set(all_acts())), 1 if kind == "single" else 2, replace=False)
    settings = []
    for name in names:
        setting = draw_setting(rng, all_effects()[str(name)], model, gain, nominal, target)
        setting = None if setting is None else _whole(setting, rendering)
        if setting is None or setting.effect.strained(setting.values, rendering):
            return None
        settings.append(setting)
    try:
        return tuple(settings), None, None, moved(model.expected(gain, settings), nominal, dark)
    except Refusal:
        return None


def _whole(setting: Setting, rendering: Rendering) -> Setting | None:
    """The same, whole where a part of it has no meaning (zones exchanged by a share); None where nor that has."""
    effect = setting.effect
    if effect.contradiction(setting.values, rendering) is None:
        return setting
    values = dict(setting.values)
    for p in effect.parameters:
        if p.vanishes_at is not None and np.any(values[p.name] != p.vanishes_at):
            values[p.name] = p.high
    whole = effect.at(**values)
    return whole if effect.contradiction(whole.values, rendering) is None else None


def draw_setting(
    rng: np.random.Generator, effect: Effect, model: ForwardModel, gain: float, nominal: np.ndarray, target: float
) -> Setting | None:
    """An effect of drawn shape, as strong as moves the deviance by about `target`; None where it moves less than any.

    nominal: (F, P, T) expected counts of `model` at `gain` without effects.
    """
    forms = effect.forms or (tuple(p.name for p in effect.parameters),)
    # Half of the time as anybody would write it first.
    names = forms[0] if rng.random() < FIRST else forms[int(rng.integers(len(forms)))]
    values, strengths = {}, []
    for name in names:
        p = effect.parameter(name)
        if p.vanishes_at is None:
            low, high = max(p.low, p.start / 2.5) if p.start > 0 else p.low, min(p.high, p.start * 2.5)
            values[name] = float(rng.uniform(low, high)) if high > low else p.start
            continue
        strengths.append(p)
        sign = rng.choice([-1.0, 1.0]) if p.low < p.vanishes_at < p.high else 1.0
        # What takes away as much as something else of the same effect adds would not show.
        size = np.full(nominal.shape[1], 1.0 if len(strengths) == 1 else rng.uniform(*UNLIKE))
        if p.axis == "zone" and rng.random() < 0.5:
            size = rng.uniform(*UNLIKE, nominal.shape[1]) * (
                rng.choice([-1, 1], nominal.shape[1]) if p.low < p.vanishes_at else 1
            )
        if p.axis in DRAWN:
            size = rng.normal(size=sizes_along(*nominal.shape[1:])[p.axis])
        values[name] = p.vanishes_at + sign * (p.start - p.vanishes_at) * (size if p.axis and np.ptp(size) else size[0])

    def at(strength: float) -> Setting:
        now = dict(values)
        for p in strengths:
            there = p.vanishes_at + strength * (np.asarray(values[p.name]) - p.vanishes_at)
            now[p.name] = np.clip(there, p.low, p.high)
            now[p.name] = now[p.name] if np.ndim(there) else float(now[p.name])
        gone = {p.name: p.vanishes_at for p in effect.parameters if p.vanishes_at is not None}
        return effect.at(**(gone | now))

    dark = model.expected(0.0)
    try:
        strength = strength_for(lambda s: moved(model.expected(gain, [at(s)]), nominal, dark), target)
    except Refusal:
        return None
    return None if strength is None else at(strength)


def _recorded(rng, rig: Rig, views, gain: float, kind: str, settings, changed, stranger, moved: float) -> Case:
    """Draw the photons, and write down what is true."""
    sensor = replace(rig.sensor, effects=settings)
    drawn = record(replace(rig.views, views=iter(views)), rig.maps, sensor, rng, gain)
    counts = np.asarray(drawn.counts)
    if changed is not None:
        # What a stranger takes is thinned out photon by photon; what it adds is drawn.
        plain = ForwardModel(
            light_of(views, rig.views.intrinsics, rig.sensor, views[0].timestamp_s),
            footprints(rig.maps, views[0].depth_m.shape, 0.6), rig.sensor.clock, rig.sensor.background_counts,
        ).expected(gain)  # fmt: skip
        ratio = changed / np.maximum(plain, 1e-9)
        counts = rng.binomial(counts, np.clip(ratio, 0, 1)) + rng.poisson(np.maximum(changed - plain, 0))
    meta = {"calibration_range_m": 0.6, "made_by": "difflidar prove"}
    hidden = replace(drawn, counts=counts.astype(np.uint32), meta_json=json.dumps(meta))
    truth = {
        "kind": kind,
        "effects": [
            {"id": s.effect.id, "parameters": {k: np.asarray(v).tolist() for k, v in s.values.items()}}
            for s in settings
        ],
        "stranger": stranger,
        "deviance_moved": moved,
        "frames": len(views),
    }
    return Case(hidden, rig.maps, truth)

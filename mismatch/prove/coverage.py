"""Whether stated errors are right: how often true parameters lie within the intervals of a fit of the named form."""

from dataclasses import dataclass, replace

import numpy as np

from mismatch.economy import economical
from mismatch.fit import fit, fit_nominal
from mismatch.form import Form, forms_of
from mismatch.naming import estimates
from mismatch.prove.case import draw_setting
from mismatch.prove.pulls import pulls
from mismatch.prove.rig import draw_rig
from mismatch.prove.shown import MOVED
from mismatch.ranking import ranked
from mismatch.score import start_of
from mismatch.simulation import Simulation
from mismatch.verdict import Estimate
from physics.effect import Effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.setting import Setting
from recordings.refusal import Refusal

FRAMES = 24
# Of the geometry's pixels one in so many rows and columns is read: intervals are a matter of counts, not of pixels.
STRIDE = 4
TRIES = 30


# A fit that is worse than one begun at the truth by more deviance than this has ended somewhere else.
ASTRAY = 10.0


@dataclass(frozen=True, eq=False)
class Coverage:
    """Pulls of an effect's parameters, (N,) by name, over recordings of it. astray: fits that ended in another minimum,
    whose pulls are left out: there it is the answer that is wrong, and not its error.
    """

    effect: Effect
    pulls: dict[str, np.ndarray]
    astray: int
    recordings: int

    def within(self, sigmas: float) -> float:
        """Share of true values that lie within so many stated standard deviations."""
        return float((np.abs(np.concatenate(list(self.pulls.values()))) < sigmas).mean())


def coverage(effect: Effect, recordings: int, seed: int, moved: tuple[float, float] = MOVED) -> Coverage:
    """Pulls of an effect over recordings of it, each of its own scene, sensor, form and strength, Poisson counts.

    moved: between which total deviances, log-uniform, its strength is drawn. The named form is fitted as `explain`
    does: from the start that promises most, by maximum likelihood of all frames.
    """
    found: dict[str, list[np.ndarray]] = {}
    astray = 0
    for i in range(recordings):
        simulation, setting = _drawn(effect, np.random.default_rng([seed, i]), moved)
        estimated = fitted_estimates(simulation, setting)
        if estimated is None:
            astray += 1
            continue
        for name, values in pulls(effect, setting.values, estimated).items():
            found.setdefault(name, []).append(values)
    return Coverage(effect, {name: np.concatenate(several) for name, several in found.items()}, astray, recordings)


def fitted_estimates(simulation: Simulation, setting: Setting) -> tuple[Estimate, ...] | None:
    """Parameters of the form of a setting, fitted to a simulation's counts, with their errors.

    None where the fit went astray; nothing where the form is one with the gain, as that of all zones is.
    """
    nominal = fit_nominal(simulation)
    scores, _ = ranked(simulation, nominal, forms_like(setting, simulation.counts.shape))
    if not scores:
        return ()
    best = max(scores, key=lambda s: s.gain)
    begun = (start_of(best.form, best.amplitude), best.form.coordinates_of(setting))
    ours, ideal = (fit(simulation, (best.form,), np.concatenate([nominal.x, x])) for x in begun)
    return estimates(ours, best.form) if ours.deviance < ideal.deviance + ASTRAY else None


def forms_like(setting: Setting, shape: tuple[int, int, int]) -> list[Form]:
    """The plainest forms that hold a setting, at all their starts."""
    forms = list(forms_of(setting.effect, {"zone": shape[1], "bin": shape[2]}))
    hold = [form for form in forms if _holds(form, setting)]
    fewest = min((len(form.coordinates) for form in hold), default=0)
    return [form for form in hold if len(form.coordinates) == fewest]


def _holds(form: Form, setting: Setting) -> bool:
    """Whether a form can be at a setting."""
    for parameter in setting.effect.parameters:
        value = np.asarray(setting.values[parameter.name])
        if parameter.name not in form.free and (value != form.start[parameter.name]).any():
            return False
        if value.ndim and parameter.name not in form.own:
            return False
    return True


def _mean(simulation: Simulation, gain: float, setting: Setting, rng: np.random.Generator) -> np.ndarray:
    """(F, P, T) expected counts; with things somewhere by chance where only a recording could say where they are."""
    if not setting.effect.looks(setting.values):
        return simulation.expected(gain, (setting,))
    bare = replace(simulation.without(gain, (setting,), setting), recorded=None)
    return setting.effect.at_random(setting.values, bare, rng)


def _drawn(effect: Effect, rng: np.random.Generator, moved: tuple[float, float]) -> tuple[Simulation, Setting]:
    """A recording of an effect beside its simulation; rigs in which the effect does not show are drawn anew."""
    for _ in range(TRIES):
        rig = draw_rig(rng, FRAMES)
        views = list(rig.views.views)
        images = [
            np.stack([getattr(view, name)[STRIDE // 2 :: STRIDE, STRIDE // 2 :: STRIDE] for view in views])
            for name in ("depth_m", "reflectance", "incidence_cosine")
        ]
        intrinsics = np.array(rig.views.intrinsics, float)
        intrinsics[:2] /= STRIDE
        intrinsics[:2, 2] -= 0.5 / STRIDE
        times = np.array([view.timestamp_s for view in views])
        cycles = rig.sensor.laser_cycles
        light = direct_light(images[0], intrinsics, *images[1:], time_s=times, laser_cycles=cycles)
        where = footprints(rig.maps, images[0].shape[1:], 0.6)
        background = np.asarray(rig.sensor.background_counts, float)
        empty = np.zeros((FRAMES, len(background), rig.sensor.bins))
        simulation = Simulation(empty, light, where, rig.sensor.clock, background, np.arange(FRAMES))
        fullest = simulation.expected(1.0).max() - background.max()
        if not fullest > 0:
            continue
        gain = rig.peak / fullest
        target = float(np.exp(rng.uniform(*np.log(moved))))
        setting = draw_setting(rng, effect, simulation.model, gain, simulation.expected(gain), target)
        if setting is not None and forms_like(setting, empty.shape):
            counts = rng.poisson(_mean(simulation, gain, setting, rng)).astype(float)
            whole = Simulation(counts, light, where, rig.sensor.clock, background, np.arange(FRAMES))
            return economical(whole), setting
    raise Refusal(f"no scene in {TRIES} showed {effect.id}, expected one")

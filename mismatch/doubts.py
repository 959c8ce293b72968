"""Names that stand in for something else: they gain far less on held-out frames than they should, or contradict it."""

from mismatch.fit import Fit
from mismatch.gained import SHORT_ROUGHLY, SIGNIFICANT, chance, falls_short
from mismatch.places import Place, wherever
from mismatch.simulation import Simulation
from mismatch.verdict import Named

# What noise would gain in more than one search of a hundred is no name, though it gains what it should.
BY_CHANCE = 0.01
ELSE = "stands in for something else"


def doubts(simulation: Simulation, explained: Fit, effects: tuple[Named, ...]) -> tuple[Place, ...]:
    """What speaks against the names of a fit of all frames, a misfit that has no place each."""
    looking = {s.effect.id for s in explained.settings if s.effect.looks(s.values) or s.effect.owns_up(s.values)}
    found = []
    for one in effects:
        told = one.heldout_gain, one.expected_gain, one.scatter
        # What counts that are trusted less leave of a name may be no more than noise gains.
        noise = one.p_value > SIGNIFICANT and one.heldout_gain < SHORT_ROUGHLY * one.expected_gain
        noise |= one.p_value > BY_CHANCE
        # A response that was estimated is off in part as the name is, and leaves less to be gained.
        roughly = one.id in looking or simulation.loose is not None
        if noise or falls_short(*told, roughly, len(effects)):
            gained = f"it gains {one.heldout_gain:.0f} on frames held out where {one.expected_gain:.0f} are due"
            what = f"may be noise: {gained}, and noise may gain as much" if noise else f"{ELSE}: {gained}"
            p_value = min(1.0, chance(*told) * len(effects))
            sentence = f"{one.id} {what}"
            found.append(wherever(simulation, p_value, sentence))
    rendering = simulation.rendering(explained.gain) if explained.settings else None
    for setting in explained.settings:
        why = setting.effect.contradiction(setting.values, rendering)
        if why is not None:
            sentence = f"{setting.effect.id} {ELSE}: {why}"
            found.append(wherever(simulation, next(e.p_value for e in effects if e.id == setting.effect.id), sentence))
    return tuple(found)

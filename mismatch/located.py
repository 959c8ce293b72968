"""Where effects that were found change what is expected, and what the change goes with."""

from dataclasses import replace

import numpy as np

from mismatch.fit import Fit
from mismatch.places import FOLLOWS, Place, extent, told
from mismatch.poisson import LEAST
from mismatch.selection import without
from mismatch.simulation import Simulation
from mismatch.tables import divisions
from mismatch.verdict import Named

# From the plainest on: the first that holds nearly as much of a change as any is what it goes with.
PLAINEST = ("nothing", "position", "time", "signal", "range", "bin_phase", "neighbours", "reflectance", "incidence")
NEARLY = 0.85
# Where a change is, and what it goes with, is seen before the others have settled to the last without it.
ENOUGH_STEPS = 5


def locate_effects(simulation: Simulation, explained: Fit, effects: tuple[Named, ...]) -> tuple[Place, ...]:
    """A place for each effect of a fit, the one that changes most first."""
    p_values = {effect.id: effect.p_value for effect in effects}
    found = []
    for form in explained.forms:
        less = without(simulation, explained, form, ENOUGH_STEPS)
        change = explained.expected - less.expected
        zones, bins, frames = extent(change, less.expected)
        gain = float((change**2 / np.maximum(less.expected, LEAST)).sum())
        p_value = p_values.get(form.effect.id, 1.0)
        found.append(Place(zones, bins, frames, followed(simulation, less, change), 1.0, p_value, gain, ""))
    total = max(sum(place.gain for place in found), 1e-12)
    shared = [told(replace(place, share=place.gain / total)) for place in found]
    return tuple(sorted(shared, key=lambda place: -place.gain))


def followed(simulation: Simulation, less: Fit, change: np.ndarray) -> str:
    """What a change (F, P, T) goes with: the plainest division of the cells that holds nearly all that any holds."""
    mean = np.maximum(less.expected, LEAST)
    held = dict.fromkeys(PLAINEST, 0.0)
    for division in divisions(simulation, less.expected):
        if len(division.axes) > 2:
            continue
        group = division.group.ravel()
        sums, noise = np.bincount(group, change.ravel()), np.bincount(group, mean.ravel())
        name = next((FOLLOWS[axis] for axis in division.axes if axis in FOLLOWS), "nothing")
        if division.axes in (("zone",), ("zone", "aligned")):
            name = "position"
        held[name] = max(held[name], float((sums**2 / np.maximum(noise, LEAST)).sum()))
    best = max(held.values())
    return next(name for name in PLAINEST if held[name] >= NEARLY * best)

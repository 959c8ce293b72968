"""Effects that are superfluous once another is let be richer: a walk with an offset of its own needs no late clock."""

from itertools import permutations

import numpy as np

from mismatch.fit import Fit, fit
from mismatch.form import Form
from mismatch.refined import enriched
from mismatch.rivals import evidence
from mismatch.selection import coordinates
from mismatch.simulation import Simulation


def absorbed(train: Simulation, test: Simulation, forms: list[Form], found: Fit) -> Fit:
    """The fit less one effect, with another as it is or richer, where that is likelier; as it was where none is."""
    best, most = found, evidence(train, test, found)
    for gone, kept in permutations(found.forms, 2):
        if train.work.enough:
            break
        others = tuple(form for form in found.forms if form is not gone and form is not kept)
        x = np.concatenate([found.x[:1], *(coordinates(found, form) for form in (*others, kept))])
        less = fit(train, (*others, kept), x, found.frame_gain_sigma)
        for other in (less, enriched(train, less, forms)):
            likely = evidence(train, test, other)
            if likely > most:
                best, most = other, likely
    return best

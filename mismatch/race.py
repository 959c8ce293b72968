"""Fits side by side, of which those that cannot come near the best are not finished."""

from collections.abc import Sequence

import numpy as np

from mismatch.descent import MOST_STEPS, Descent

# Steps after which it is looked who is still in the race: the first tell little.
HEATS = (2, 2, 3, 4, 6, MOST_STEPS)
# A fit is left when it can hope to come no nearer to the best than this deviance, and than this part of what the best
# has gained.
BEYOND, BEYOND_PART = 120.0, 0.1


def race(descents: Sequence[Descent], prices: Sequence[float], least: float = np.inf) -> list[int]:
    """Run descents of one simulation to their ends, but for those that cannot come near the best. Which were left.

    Far beyond enough work only the one that leads is.

    prices: deviance that each must gain beside the others for its parameters. least: what another came to with its.
    """
    running = list(range(len(descents)))
    left: list[int] = []
    began = max((descent.deviance for descent in descents), default=0.0)
    for steps in HEATS:
        if not running:
            break
        descents[0].simulation.each(lambda i, steps=steps: descents[i].run(steps), running)
        came_to = [descent.deviance + price for descent, price in zip(descents, prices, strict=True)]
        best = min(*came_to, least)
        near = best + max(BEYOND, BEYOND_PART * (began - best))
        leads = came_to.index(min(came_to)) if descents[0].simulation.work.far_beyond else None
        running = [i for i in running if not descents[i].over]
        left += [i for i in running if descents[i].hoped + prices[i] > near or leads not in (None, i)]
        running = [i for i in running if i not in left]
    return left

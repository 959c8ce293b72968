"""How strong an effect that was not found would have had to be."""

import numpy as np

from mismatch.score import Score
from mismatch.verdict import NotVisible

# Deviance at which an effect is found about half the time.
FOUND = 30.0


def not_visible(scores: tuple[Score, ...], share: float) -> tuple[NotVisible, ...]:
    """For each effect that was tried and not found, the smallest strength that would have shown, by its best form.

    share: of all frames, those that were scored.
    """
    best: dict[str, tuple[float, NotVisible]] = {}
    for score in scores:
        form = score.form
        name = form.strengths[0]
        parameter = form.effect.parameter(name)
        times = np.sqrt(FOUND / (score.information / share)) if score.information > 0 else np.inf
        smallest = times * np.max(np.abs(form.start[name] - parameter.vanishes_at))
        reach = max(abs(end - parameter.vanishes_at) for end in (parameter.low, parameter.high))
        shown = NotVisible(form.effect.id, float(smallest) if smallest <= reach else float("inf"), parameter.unit)
        if form.effect.id not in best or times < best[form.effect.id][0]:
            best[form.effect.id] = times, shown
    return tuple(shown for _, (_, shown) in sorted(best.items()))

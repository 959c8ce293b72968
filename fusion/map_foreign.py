"""Why maps cannot be of the rig that recorded, whatever is put right."""

from fusion.map_departure import Departure
from fusion.map_null import LEAST_GAIN, Null
from fusion.map_trials import Scores

# Zones that wander by errors of the model gain less by it than this part of what their order does.
FAR = 0.1
# A mistake that is put right must win this part of what making it would cost.
SHARE = 0.5


def twisted(seen: Scores, null: Null, found: Departure | None) -> str | None:
    """Why maps are of a rig with other optics or turned, in words; None where what was found explains as much."""
    gain, chance = seen.twist_gain, max(null.over(lambda one: one.twist_gain), LEAST_GAIN)
    if gain <= max(chance, float(seen.shift_gain.max()), found.gain if found else 0.0):
        return None
    how = max(seen.twist, key=seen.twist.get)
    return (
        f"with all footprints {how} the log-likelihood rises by {gain:.0f}; by noise and errors of the model it would "
        f"by {max(chance, 0):.0f} at most"
    )


def foreign(seen: Scores, null: Null) -> str | None:
    """Why maps as they are cannot be of this rig, in words; None where they can."""
    wander, chance = seen.disorder, max(null.over(lambda one: one.disorder, 3.0), FAR)
    if wander > chance and seen.wander_gain > LEAST_GAIN:
        return (
            f"zones by themselves fit best in different places: that gains {wander:.2f} of what their order does, "
            f"where it stays below {chance:.2f} for right maps"
        )
    fits, knows = float(seen.base.sum()), seen.knowledge
    worst = null.least_plausible(lambda one: float(one.base.sum()), 3.0)
    if fits < worst and knows < null.least_plausible(lambda one: one.knowledge, 2.0):
        return (
            f"histograms agree with the maps little better ({knows:.0f}) than with the same maps in any order, where "
            f"right ones gain {null.mean(lambda one: one.knowledge):.0f}"
        )
    return None


def implausible(found: Departure, null: Null) -> str | None:
    """Why a departure that was put right was none, in words: the mistake would have cost right maps far more."""
    if found.redone is None:
        return None
    cost = -null.mean(found.redone)
    if found.gain > min(SHARE * cost, -null.over(found.redone)):
        return None
    return (
        f"if {found.sentence}, putting that right would raise the log-likelihood by about {cost:.0f}, "
        f"but it does by {found.gain:.0f}"
    )

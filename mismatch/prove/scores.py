"""How often the answers were right."""

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from mismatch.prove.pulls import pulls
from mismatch.verdict import Estimate
from physics.effects import all_effects, find_effect

NOTHING, UNKNOWN = "nothing", "unknown"


@dataclass(frozen=True, eq=False)
class Answered:
    """A case and its answer. truth: of the ledger. verdict: as verdict.json holds it, or None where it was refused."""

    truth: dict[str, Any]
    verdict: dict[str, Any]

    @property
    def kind(self) -> str:
        """single, pair, nothing or unknown."""
        ids = self.true_ids
        if self.truth.get("kind") == UNKNOWN or self.truth.get("stranger") or any(i not in all_effects() for i in ids):
            return UNKNOWN
        return {0: NOTHING, 1: "single"}.get(len(ids), "pair")

    @property
    def true_ids(self) -> list[str]:
        """Effects that are there."""
        return [effect["id"] for effect in self.truth.get("effects", [])]

    @property
    def named_ids(self) -> list[str]:
        """Effects that were named."""
        return [effect["id"] for effect in self.verdict["effects"]]

    @property
    def named(self) -> bool:
        """Whether the one cause was named, alone."""
        return self.named_ids == self.true_ids

    @property
    def among_two(self) -> bool:
        """Whether it was named, or is the likeliest look-alike of what was named."""
        if len(self.verdict["effects"]) != 1:
            return False
        effect = self.verdict["effects"][0]
        alike = sorted(effect["look_alikes"], key=lambda a: -a["probability"])[:1]
        return self.true_ids[0] in [effect["id"], *(a["id"] for a in alike)]

    @property
    def right(self) -> bool:
        """Whether the answer is what its kind asks for."""
        if self.kind == NOTHING:
            return self.verdict["verdict"] == "agrees"
        if self.kind == UNKNOWN:
            return self.verdict["verdict"] == "unknown"
        if self.kind == "pair":
            return set(self.true_ids) == set(self.named_ids)
        return self.named


@dataclass(frozen=True)
class Rate:
    """So many of so many, and the 95 % interval of the rate (Clopper and Pearson 1934)."""

    hits: int
    cases: int

    @property
    def value(self) -> float:
        """The rate."""
        return self.hits / self.cases if self.cases else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 %."""
        if not self.cases:
            return 0.0, 1.0
        found = binomtest(self.hits, self.cases).proportion_ci(0.95)
        return float(found.low), float(found.high)

    def __str__(self) -> str:
        if not self.cases:
            return "no such case"
        low, high = self.interval
        return (
            f"{self.hits} of {self.cases} ({100 * self.value:.1f} %, 95 % interval {100 * low:.1f} to {100 * high:.1f})"
        )


@dataclass(frozen=True, eq=False)
class Scores:
    """named, among_two: of single causes. false_alarms: of recordings with nothing. unknown, pairs: of their kinds.

    gap_closed: median, of explained single causes and pairs. within_68, within_95: of parameters, how many true values
    lie in the interval. confusion: (truth, answer) -> how many. faint: (deviance moved, named) of single causes.
    """

    named: Rate
    among_two: Rate
    false_alarms: Rate
    unknown: Rate
    pairs: Rate
    gap_closed: float
    within_68: Rate
    within_95: Rate
    confusion: dict[tuple[str, str], int]
    faint: list[tuple[float, bool]]
    seconds: float


def score_answers(answered: list[Answered]) -> Scores:
    """Count."""
    of = {kind: [a for a in answered if a.kind == kind] for kind in ("single", "pair", NOTHING, UNKNOWN)}
    gaps = [a.verdict["fit"]["gap_closed"] for a in of["single"] + of["pair"] if a.right]
    gaps = [gap for gap in gaps if gap is not None]
    pulls = np.array([pull for a in of["single"] if a.named for pull in _pulls(a)])
    confusion = Counter()
    for a in answered:
        truth = "+".join(sorted(a.true_ids)) if a.kind in ("single", "pair") else a.kind
        answer = "+".join(sorted(a.named_ids)) if a.verdict["verdict"] == "explained" else a.verdict["verdict"]
        confusion[truth, answer] += 1
    return Scores(
        named=_rate(a.named for a in of["single"]),
        among_two=_rate(a.among_two for a in of["single"]),
        false_alarms=_rate(not a.right for a in of[NOTHING]),
        unknown=_rate(a.right for a in of[UNKNOWN]),
        pairs=_rate(a.right for a in of["pair"]),
        gap_closed=float(np.median(gaps)) if gaps else float("nan"),
        within_68=_rate(np.abs(pulls) < 1.0),
        within_95=_rate(np.abs(pulls) < 1.96),
        confusion=dict(confusion),
        faint=[(float(a.truth.get("deviance_moved", np.nan)), a.named) for a in of["single"]],
        seconds=float(np.median([a.verdict["seconds"] for a in answered])),
    )


def _rate(hits) -> Rate:
    """Of a sequence of truths."""
    hits = [bool(hit) for hit in hits]
    return Rate(sum(hits), len(hits))


def _pulls(answered: Answered) -> list[float]:
    """(estimate - truth) / sigma of parameters that both sides name."""
    true = answered.truth["effects"][0].get("parameters", {})
    estimates = [Estimate(**found) for found in answered.verdict["effects"][0]["parameters"]]
    each = pulls(find_effect(answered.true_ids[0]), true, estimates)
    return [float(pull) for values in each.values() for pull in values]

"""The tables of docs/quality.md."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from fusion.prior import Prior
from fusion.quality.judge import ALTERNATIVES, best_of, judge, rms_of
from fusion.quality.oracle import oracle_rms
from fusion.quality.trial import Trial

# Priors that the cross-wise choice is made from.
TRIED = tuple(
    Prior(colour=colour, left=left, reach_px=reach)
    for colour, left, reach in product((0.02, 0.03, 0.05, 0.08), (0.01, 0.02, 0.05), (10.0, 14.0, 22.0))
)
REGIONS = (20, 60, 200)

Scores = dict[str, list[dict[str, float]]]


def methods_table(scores: Scores) -> str:
    """One row a method: means over frames, and the largest rms of any frame."""
    rows = ["| method | rms | median | δ < 1.05 | rms at edges | worst frame's rms | 90 % interval covers |"]
    rows += ["|---" * 7 + "|"]
    for name, frames in scores.items():
        mean = {key: float(np.mean([frame[key] for frame in frames])) for key in frames[0]}
        cover = f"{mean['coverage']:.0%}" if "coverage" in mean else "-"
        worst = max(frame["rms"] for frame in frames)
        metres = [f"{value:.3f} m" for value in (mean["rms"], mean["median"], mean["edges"], worst)]
        rows.append(
            f"| {name} | {metres[0]} | {metres[1]} | {mean['close']:.0%} | {metres[2]} | {metres[3]} | {cover} |"
        )
    return "\n".join(rows)


def verdict(draws: Sequence[Scores]) -> str:
    """How far unmixing is below the best alternative, in each draw and all, and on how many frames above any."""
    joined = together(draws)
    frames = list(zip(*(joined[name] for name in (*ALTERNATIVES, "unmix")), strict=True))
    worse = sum(any(frame[-1]["rms"] > other["rms"] for other in frame[:-1]) for frame in frames)
    best, mean, below = _below(joined)
    each = ", ".join(f"{_below(scores)[2]:.0%}" for scores in draws)
    return (
        f"Unmixing: rms {below:.0%} below the best alternative ({best}, {mean:.3f} m), by draw {each}; "
        f"above an alternative on {worse} of {len(frames)} frames."
    )


def together(draws: Sequence[Scores]) -> Scores:
    """The frames of all draws."""
    return {name: [frame for scores in draws for frame in scores[name]] for name in draws[0]}


def _below(scores: Scores) -> tuple[str, float, float]:
    """The best alternative, its mean rms, and by what part unmixing is below it."""
    means = {name: float(np.mean([frame["rms"] for frame in scores[name]])) for name in (*ALTERNATIVES, "unmix")}
    best = min(ALTERNATIVES, key=means.__getitem__)
    return best, means[best], 1 - means["unmix"] / means[best]


def with_mean_ranges(trial: Trial) -> Trial:
    """The trial whose alternatives are given the mean range of each zone's surfaces in place of its strongest peak."""
    return replace(trial, range_m=np.stack([depths.mean_m for depths in trial.depths]))


def crosswise_table(trials: Sequence[Trial]) -> str:
    """Rms on each set with the prior that is best on the other, on itself, and with the default."""
    rows = ["| judged on | prior chosen on the other set | on the same set | default |", "|---" * 4 + "|"]
    chosen = [best_of(trial, TRIED) for trial in trials]
    for trial, own, other in zip(trials, chosen, chosen[::-1], strict=True):
        cells = []
        for prior in (other, own, Prior()):
            values = f"colour {prior.colour}, left {prior.left}, reach {prior.reach_px:.0f}"
            cells.append(f"{np.mean(rms_of(trial, prior)):.3f} m ({values})")
        rows.append(f"| {trial.name} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def oracle_table(trials: Sequence[Trial]) -> str:
    """Rms of regions of like colour at their true mean depth."""
    rows = ["| set | " + " | ".join(f"{n} regions" for n in REGIONS) + " |", "|---" * (len(REGIONS) + 1) + "|"]
    for trial in trials:
        cells = [f"{np.mean(oracle_rms(trial, n)):.3f} m" for n in REGIONS]
        rows.append(f"| {trial.name} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def document(draws: Sequence[Sequence[Trial]], judged: Sequence[Sequence[Scores]]) -> str:
    """All measured tables; draws: of each set, the trials that differ by what is random alone."""
    parts = []
    for trials, scores in zip(draws, judged, strict=True):
        stronger = [judge(with_mean_ranges(trial))[0] for trial in trials]
        parts += [f"### {trials[0].name}, {len(trials)} draws", methods_table(together(scores)), verdict(scores)]
        parts += ["Alternatives given the mean range of each zone's surfaces in place of its strongest peak:"]
        rest = together(stronger)
        parts += [methods_table({name: rest[name] for name in ALTERNATIVES}), verdict(stronger)]
    first = [trials[0] for trials in draws]
    parts += ["### Priors chosen on one set, judged on the other (first draw)", crosswise_table(first)]
    parts += ["### Regions of like colour, each at its true mean depth", oracle_table(first)]
    return "\n\n".join(parts) + "\n"

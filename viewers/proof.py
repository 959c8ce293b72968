"""Pictures of a proof: what was concealed and answered, how faint a cause may be, and a black box beside it."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from mismatch.prove.extrapolation import SideBySide
from mismatch.prove.scores import Scores
from recordings.atomic import written_aside

# Room, in inches, for each letter of a name, and for the picture of strengths.
INCH_OF_A_LETTER, STRENGTHS_INCH = 0.06, 4.0
# What is answered where nothing is concealed.
AGREED = {"agrees": "nothing"}


def save_proof(scores: Scores, path: str | Path) -> None:
    """Confusion of truth and answer, and the share named by the deviance that a cause moves, as a .png.

    Right answers are framed: they lie along the diagonal, other answers beside it.
    """
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    confusion = {(truth, AGREED.get(answer, answer)): many for (truth, answer), many in scores.confusion.items()}
    truths, answers = _in_one_order(confusion)
    matrix = np.array([[confusion.get((truth, answer), 0) for answer in answers] for truth in truths])
    names = INCH_OF_A_LETTER * max(len(name) for name in (*truths, *answers))
    wide, high = 0.28 * len(answers) + names, 0.24 * len(truths) + names
    figure = Figure(figsize=(1 + wide + STRENGTHS_INCH, max(high + 0.6, 3.5)), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[wide, STRENGTHS_INCH])
    left.imshow(matrix / matrix.sum(axis=1, keepdims=True), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (row, column), count in np.ndenumerate(matrix):
        if count:
            shade = "white" if 2 * count > matrix[row].sum() else "black"
            left.text(column, row, str(count), ha="center", va="center", fontsize=7, color=shade)
    for row, truth in enumerate(truths):
        if truth in answers:
            left.add_patch(Rectangle((answers.index(truth) - 0.5, row - 0.5), 1, 1, fill=False, lw=1))
    left.set_xticks(range(len(answers)), answers, rotation=90, fontsize=7)
    left.set_yticks(range(len(truths)), truths, fontsize=7)
    left.set_xlabel("answered")
    left.set_ylabel("concealed")
    _strengths(right, scores.faint)
    with written_aside(Path(path)) as aside:
        figure.savefig(aside, format="png", dpi=120)


def _in_one_order(confusion: dict[tuple[str, str], int]) -> tuple[list[str], list[str]]:
    """Truths, and answers: the right ones in the order of the truths, then those that are right for none."""
    given = {answer for _, answer in confusion}
    truths = sorted({truth for truth, _ in confusion}, key=lambda truth: (truth not in given, "+" in truth, truth))
    return truths, [truth for truth in truths if truth in given] + sorted(given - set(truths))


def _strengths(axes, faint: list[tuple[float, bool]]) -> None:
    """Share of single causes named, in steps of the deviance they move, with 68 % intervals (Agresti and Coull)."""
    moved = np.array([pair for pair in faint if np.isfinite(pair[0]) and pair[0] > 0], float).reshape(-1, 2)
    axes.set_xlabel("deviance that the cause moves")
    axes.set_ylabel("share named")
    axes.set_ylim(-0.02, 1.02)
    if not len(moved):
        axes.set_xticks([])
        axes.text(0.5, 0.5, "not stated of any single cause", ha="center", va="center", transform=axes.transAxes)
        return
    steps = np.geomspace(moved[:, 0].min() * 0.999, moved[:, 0].max() * 1.001, 7)
    for low, high in pairwise(steps):
        inside = moved[(moved[:, 0] >= low) & (moved[:, 0] < high), 1]
        if len(inside):
            share = (inside.sum() + 0.5) / (len(inside) + 1)
            spread = np.sqrt(share * (1 - share) / (len(inside) + 1))
            axes.errorbar(np.sqrt(low * high), share, spread, fmt="o", color="tab:blue")
    axes.set_xscale("log")


def save_extrapolations(found: Sequence[SideBySide], path: str | Path) -> None:
    """Misfit of named physics and of a black box, near frames held out and far ones, as a .png.

    Deviance per cell less what noise alone gives, on a scale that is linear about 0.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4), layout="constrained")
    at = np.arange(len(found))
    for i, (axes, frames) in enumerate(zip(figure.subplots(1, 2, sharey=True), ("near, held out", "far"), strict=True)):
        for shift, kind in ((-0.25, "nominal"), (0, "physics"), (0.25, "black_box")):
            beyond = [getattr(one, kind)[i] - one.noise[i] for one in found]
            axes.bar(at + shift, beyond, 0.23, label=kind.replace("_", " "))
        axes.set_xticks(at, [one.cause.replace("_", "\n") for one in found], fontsize=8)
        axes.set_title(f"frames that are {frames}" if i else f"frames that are {frames}, at fitted ranges")
        axes.set_yscale("symlog", linthresh=0.05)
        axes.axhline(0, color="black", lw=0.8)
        axes.grid(axis="y", alpha=0.3)
        if not i:
            axes.set_ylabel("deviance per cell beyond noise")
            axes.legend(fontsize="small")
    with written_aside(Path(path)) as aside:
        figure.savefig(aside, format="png", dpi=120)

"""`difflidar prove`: whether `explain` can be trusted, on recordings in which the cause is concealed."""

import json
from dataclasses import asdict
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from difflidar.progress import bar


@click.command()
@click.option("--cases", default=20, show_default=True, type=click.IntRange(1), help="How many recordings to seal.")
@click.option("--seed", default=0, show_default=True, help="Of everything that is drawn.")
@click.option("--recordings", type=click.Path(path_type=Path), help="Instead: a folder of recordings made elsewhere.")
@click.option("--truth", type=click.Path(path_type=Path), help="Their truth, opened when all are answered.")
@click.option("--calibration", "maps", type=click.Path(path_type=Path), help="Response maps, where none lie beside.")
@click.option("--black-box", is_flag=True, help="Instead: named physics beside a smooth correction, near and far.")
@click.option("--out", default=Path("out/proof"), show_default=True, type=click.Path(path_type=Path), help="Folder.")
def command(cases, seed, recordings, truth, maps, black_box, out):
    """Seal recordings, explain each, open the truth, and count how often the answer was right.

    OUT receives the sealed recordings with the hash of their truth, an answer for each, and proof.png.

    With --black-box the frames of a sweep that are near are explained, and corrected by splines that know no physics;
    both are tested on the frames that are far. OUT receives black_box.json and black_box.png.
    """
    from mismatch.prove.run import answer, compare, make_cases, recordings_in
    from mismatch.prove.scores import score_answers
    from recordings.refusal import Refusal
    from viewers.proof import save_proof

    if (recordings is None) != (truth is None):
        raise Refusal("--recordings and --truth go together, expected both or neither")
    if black_box:
        if recordings is not None:
            raise Refusal("--black-box draws its own recordings, expected no --recordings beside it")
        beside_black_box(seed, out)
        return
    if truth is not None and not truth.is_file():
        raise Refusal(f"{truth}: does not exist, expected the truth of the recordings")
    digest = None
    if recordings is None:
        recordings, truth = out / "sealed", out / "sealed" / "truth.json"
        digest = make_cases(recordings, cases, seed, bar)
        click.echo(f"sealed {cases} recordings; SHA-256 of their truth: {digest}")
    answer(recordings, out / "answers", recordings_in(recordings, maps), bar)
    scores = score_answers(compare(out / "answers", truth, digest))
    show(scores)
    save_proof(scores, out / "proof.png")
    click.echo(f"wrote {out / 'answers'}, {out / 'proof.png'}")


def beside_black_box(seed: int, out: Path) -> None:
    """Compare physics and black box on sweeps with a cause concealed, print and write the figures."""
    from mismatch.prove.extrapolation import CAUSES, compare_on_far, sweeps
    from recordings.atomic import expect_place_for, written_aside
    from viewers.proof import save_extrapolations

    out.mkdir(parents=True, exist_ok=True)
    for name in ("black_box.json", "black_box.png"):
        expect_place_for(out / name)
    found = [
        compare_on_far(simulation, near, cause)
        for cause, simulation, near in bar(sweeps(seed), len(CAUSES), "near and far")
    ]
    table = Table("concealed", "named", "frames", "nominal", "named physics", "black box", "noise")
    for one in found:
        for i, frames in enumerate(("near, held out", "far")):
            figures = (one.nominal[i], one.physics[i], one.black_box[i], one.noise[i])
            head = ("", "") if i else (one.cause, ", ".join(one.named) or "nothing")
            table.add_row(*head, frames, *(f"{figure:.3f}" for figure in figures))
    console = Console()
    console.print("Poisson deviance per cell")
    console.print(table)
    with written_aside(out / "black_box.json") as aside:
        aside.write_text(json.dumps([asdict(one) for one in found], indent=1) + "\n")
    save_extrapolations(found, out / "black_box.png")
    click.echo(f"wrote {out / 'black_box.json'}, {out / 'black_box.png'}")


def show(scores) -> None:
    """Print the figures."""
    table = Table("figure", "value")
    for name, value in (
        ("single causes named", scores.named),
        ("named, or the likeliest look-alike", scores.among_two),
        ("false alarms where nothing is concealed", scores.false_alarms),
        ("unknown causes called unknown", scores.unknown),
        ("both of a pair named", scores.pairs),
        ("gap closed on held-out frames, median", f"{scores.gap_closed:.3f}"),
        ("true parameters within 68 % intervals", scores.within_68),
        ("true parameters within 95 % intervals", scores.within_95),
        ("seconds for a recording, median", f"{scores.seconds:.1f}"),
    ):
        table.add_row(name, str(value))
    console = Console()
    console.print(table)
    for (truth, answer), count in sorted(scores.confusion.items()):
        if truth != answer and (truth, answer) != ("nothing", "agrees"):
            console.print(f"{count} × {truth} answered as {answer}", soft_wrap=True)

"""`difflidar explain A.npz B.npz`: what makes two calibrations of one sensor disagree."""

from contextlib import ExitStack, suppress
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

FILES = ("a.npz", "b.npz", "verdict.json")


def explain_pair(a: Path, b: Path, out: Path | None, as_json: bool) -> None:
    """Print, or write into the folder `out`, the verdict on two calibrations; their common maps go beside it."""
    from mismatch.calibrations.explain import explain_calibrations
    from recordings.atomic import expect_place_for
    from recordings.maps_file import load_maps

    for name in FILES if out is not None and out.is_dir() else ():
        expect_place_for(out / name)
    found = explain_calibrations(load_maps(a), load_maps(b))
    if out is not None:
        write(found, out)
    if as_json:
        click.echo(found.text(), nl=False)
        return
    show(found, a, b)
    if out is not None:
        click.echo(f"wrote {out / 'verdict.json'}, and both maps on common ground, {out / 'a.npz'}, {out / 'b.npz'}")


def write(found, out: Path) -> None:
    """Write all files into the folder, made if need be, or none."""
    from recordings.atomic import written_aside
    from recordings.maps_file import save_maps

    made = [path for path in (out, *out.parents) if not path.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        # They take their places when all are written.
        with ExitStack() as stack:
            one, other, verdict = (stack.enter_context(written_aside(out / name)) for name in FILES)
            save_maps(found.a, one)
            save_maps(found.b, other)
            verdict.write_text(found.text(), encoding="utf-8")
    except BaseException:
        for path in made:
            with suppress(OSError):
                path.rmdir()
        raise


def show(found, a: Path, b: Path) -> None:
    """Say on a screen what was found."""
    console = Console(markup=False, highlight=False)
    console.print(f"{a} and {b}: {found.verdict}", style="bold", soft_wrap=True)
    for effect, multiple in zip(found.effects, found.multiples, strict=True):
        told = ", ".join(f"{p.name} {p.value:.4g} ± {p.sigma:.2g} {p.unit}" for p in effect.parameters[:4])
        console.print(f"{effect.id}: {told}; {multiple:.2f} of it is found on positions held out", soft_wrap=True)
    table = Table(f"on {found.positions[1]} positions held out", "before", "after", "noise alone")
    three = (found.before, found.after, found.floor)
    table.add_row("displacement, px", *(f"{figures.displacement_px:.2f}" for figures in three))
    table.add_row("1 - cosine", *(f"{figures.one_minus_cosine:.4f}" for figures in three))
    for i, threshold in enumerate(found.before.thresholds):
        table.add_row(f"IoU at {threshold:g} of the peak", *(f"{figures.iou[i]:.3f}" for figures in three))
    console.print(table)
    for place in found.unexplained:
        console.print(f"left: {place.sentence}", soft_wrap=True)
    for note in found.notes:
        console.print(note, soft_wrap=True)

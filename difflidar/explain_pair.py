"""`difflidar explain A.npz B.npz`: what makes two calibrations of one sensor disagree."""

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table


def explain_pair(a: Path, b: Path, out: Path | None, as_json: bool) -> None:
    """Print, or write into the folder `out`, the verdict on two calibrations; their common maps go beside it."""
    from mismatch.calibrations.explain import explain_calibrations
    from recordings.atomic import written_aside
    from recordings.maps_file import load_maps, save_maps

    found = explain_calibrations(load_maps(a), load_maps(b))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        for name, maps in (("a.npz", found.a), ("b.npz", found.b)):
            save_maps(maps, out / name)
        with written_aside(out / "verdict.json") as aside:
            aside.write_text(found.text(), encoding="utf-8")
    if as_json:
        click.echo(found.text(), nl=False)
        return
    show(found, a, b)
    if out is not None:
        click.echo(f"wrote {out / 'verdict.json'}, and both maps on common ground, {out / 'a.npz'}, {out / 'b.npz'}")


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

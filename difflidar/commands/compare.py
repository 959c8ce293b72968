"""`difflidar compare`: how well two calibrations of one sensor agree."""

import json
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table


@click.command()
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
@click.option("--threshold", default=0.1, show_default=True, help="Fraction of the peak that bounds a support.")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON and nothing else.")
@click.option("--picture", type=click.Path(path_type=Path), help="IoU over all thresholds, .png.")
def command(a, b, threshold, as_json, picture):
    """Compare the response maps A and B: overlap of supports, displacement of centroids, cosine."""
    import numpy as np

    from calibrate.consistency import compare, iou_curve
    from recordings.maps_file import load_maps

    first, second = load_maps(a), load_maps(b)
    found = compare(first, second, threshold)
    thresholds = np.round(np.arange(0.05, 1.0, 0.05), 2)
    curve = iou_curve(first, second, thresholds)
    if picture is not None:
        from viewers.curves import save_iou_curve

        save_iou_curve(picture, thresholds, curve, threshold)
    if as_json:
        click.echo(json.dumps(_as_dict(found, thresholds, curve)))
        return
    console = Console()
    table = Table("zone", f"IoU at {threshold:g}", "displacement px", "cosine", title=f"{found.positions} positions")
    columns = first.zone_grid[1]
    for p, figures in enumerate(zip(found.iou, found.displacement_px, found.cosine, strict=True)):
        table.add_row(f"{p // columns},{p % columns}", *(f"{v:.{d}f}" for v, d in zip(figures, (3, 2, 4), strict=True)))
    table.add_section()
    digits = {"iou": 3, "displacement_px": 2, "cosine": 3}
    table.add_row("mean ± sd", *(f"{m:.{digits[n]}f} ± {s:.{digits[n]}f}" for n, (m, s) in found.summary().items()))
    console.print(table)
    over_all = Table("threshold", "IoU mean ± sd", "lowest zone", title="Overlap at every threshold")
    for t, row in zip(thresholds, curve, strict=True):
        over_all.add_row(f"{t:.2f}", f"{row.mean():.3f} ± {row.std():.3f}", f"{row.min():.3f}")
    console.print(over_all)


def _as_dict(found, thresholds, curve) -> dict:
    return {
        "threshold": found.threshold,
        "positions": found.positions,
        "mean": {name: mean for name, (mean, _) in found.summary().items()},
        "standard_deviation": {name: spread for name, (_, spread) in found.summary().items()},
        "per_zone": {
            "iou": found.iou.tolist(),
            "displacement_px": found.displacement_px.tolist(),
            "cosine": found.cosine.tolist(),
        },
        "iou_over_thresholds": {"threshold": thresholds.tolist(), "iou": curve.tolist()},
    }

"""`difflidar sparse`: what a shorter scan would have cost."""

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from difflidar.progress import bar


@click.command()
@click.argument("maps", type=click.Path(path_type=Path))
@click.option("--points", multiple=True, type=int, help="Scan points to keep; repeatable. Default: ½, ¼, ⅛, 1/16.")
@click.option("--patch-radius", type=float, metavar="PX", help="Radius of the patch; default: as calibrated, or 17.75.")
@click.option("--threshold", default=0.1, show_default=True, help="Fraction of the peak that bounds a support.")
@click.option("--picture", type=click.Path(path_type=Path), help="The same as a graph, .png.")
def command(maps, points, patch_radius, threshold, picture):
    """Predict MAPS from ever fewer of its scan points and compare with the full map."""
    from calibrate.kernel import patch_radius_of
    from calibrate.sparse import sparse_scans
    from recordings.maps_file import load_maps

    full = load_maps(maps)
    total = len(full.xs)
    radius = patch_radius_of(full) if patch_radius is None else patch_radius
    wanted = points or tuple(total // part for part in (2, 4, 8, 16))
    found = sparse_scans(full, radius, tuple(wanted), threshold, bar)
    table = Table(
        "points", "of the scan", "cosine", "IoU", "cosine at points left out", title=f"{maps}: {total} points"
    )
    for scan in found:
        figures = (scan.cosine, scan.iou, scan.left_out_cosine)
        table.add_row(
            str(scan.points),
            f"{scan.points / total:.0%}",
            *(f"{v.mean():.3f} ± {v.std():.3f}" for v in figures),
        )
    Console().print(table)
    if picture is not None:
        from viewers.curves import save_sparse_curve

        save_sparse_curve(picture, found)

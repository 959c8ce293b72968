"""`difflidar move`: the maps at another range."""

from pathlib import Path

import click


@click.command()
@click.argument("maps", type=click.Path(path_type=Path))
@click.argument("distance", type=float)
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Maps to write, .npz.")
def command(maps, distance, out):
    """Carry MAPS, calibrated in space, to a plane DISTANCE metres away along the camera's optical axis."""
    import numpy as np

    from calibrate.space import at_depth
    from recordings.maps_file import load_maps, save_maps

    here = load_maps(maps)
    there = at_depth(here, distance)
    save_maps(there, out)
    shift = np.hypot(there.xs - here.xs, there.ys - here.ys)
    click.echo(f"{out}: maps at {distance:g} m; footprints moved by {np.median(shift):.1f} px (median)")

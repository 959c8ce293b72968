"""`difflidar rays`: maps calibrated in space as weighted rays from the LiDAR."""

from pathlib import Path

import click


@click.command()
@click.argument("maps", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Rays to write, .npz.")
def command(maps, out):
    """Write MAPS as directions in the LiDAR's own frame and weights of every zone, whatever the range."""
    import numpy as np

    from calibrate.space import rays
    from recordings.atomic import expect_place_for, written_aside
    from recordings.maps_file import load_maps

    expect_place_for(out)
    found = load_maps(maps)
    bundle = rays(found)
    shape = found.responses.shape
    sigma = {} if bundle.sigma is None else {"sigma": bundle.sigma.reshape(shape)}
    with written_aside(out) as aside, aside.open("wb") as file:
        np.savez_compressed(
            file,
            directions=bundle.directions,
            weights=bundle.weights.reshape(shape),
            cap_ids=found.cap_ids,
            meta_json=found.meta_json,
            **sigma,
        )
    click.echo(f"{out}: {shape[2]} rays, weights of {shape[0]} x {shape[1]} zones: counts the patch would give at 1 m")

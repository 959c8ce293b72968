"""`difflidar simulate`: what a diffuse LiDAR would record of a scene."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--calibration", "maps_path", required=True, type=click.Path(path_type=Path), help="Response maps, .npz.")
@click.option("--sensor", "sensor_name", help="A sensor.json, or a preset such as tmf8828-3x3-wide-long.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Recording to write, .rrd or .npz.")
@click.option("--poses", type=click.Path(path_type=Path), help="Where a mesh is seen from: time x y z qx qy qz qw.")
@click.option("--gain", type=float, help="Counts per unit of light of the nominal model.")
@click.option("--peak", default=1000.0, show_default=True, help="Without a gain: counts in the first frame's peak.")
@click.option("--seed", default=0, show_default=True, help="Of the photons.")
def command(scene, maps_path, sensor_name, out, poses, gain, peak, seed):
    """Simulate the recording of SCENE.

    SCENE is a folder of RGB-D frames, a mesh, a scene.json, or a recording with depth. Without --sensor it is the
    sensor of that recording, or the TMF8828 in the mode of the maps.
    """
    import numpy as np

    from physics.scene.open_scene import open_scene
    from physics.sensor_choice import choose_sensor
    from physics.simulate import simulate
    from recordings.atomic import expect_place_for
    from recordings.files import save
    from recordings.maps_file import load_maps

    expect_place_for(out)
    maps = load_maps(maps_path)
    sensor = choose_sensor(sensor_name, scene, maps)
    stream, tally = simulate(
        open_scene(scene, maps, poses), maps, sensor, np.random.default_rng(seed), gain=gain, peak=peak
    )
    save(stream, out, progress=bar)
    click.echo(f"wrote {out}: {sensor.name or 'sensor of the recording'} {sensor.mode}".rstrip())
    if tally.missing:
        share = f"{tally.missing / tally.pixels:.1%}"
        click.echo(f"{share} of the pixels contributed nothing: depth, reflectance or incidence is unknown there")

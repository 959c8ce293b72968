"""`difflidar check`: do response maps say where the zones looked? By a recording with depth."""

import json
from contextlib import nullcontext
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--calibration", "maps_path", required=True, type=click.Path(path_type=Path), help="Response maps, .npz.")
@click.option("--sensor", "sensor_name", help="A sensor.json or a preset; default: as recorded.")
@click.option("--seed", default=0, show_default=True, help="Of the made-up recordings.")
@click.option("--json", "as_json", is_flag=True, help="Print the verdict as JSON and nothing else.")
def command(recording, maps_path, sensor_name, seed, as_json):
    """Check response maps by RECORDING, which has depth from the camera or is simulated.

    The verdict: the maps are fine, shifted, mirrored, with zones exchanged, of another rig, or the recording cannot
    tell. The exit status is 0 whatever the verdict.
    """
    import numpy as np

    from fusion.check import check
    from physics.sensor_choice import choose_sensor
    from recordings.files import load
    from recordings.maps_file import load_maps

    maps, seen = load_maps(maps_path), load(recording)
    sensor = choose_sensor(sensor_name, recording, maps)
    waits = Console(stderr=True)
    with waits.status("comparing histograms") if waits.is_terminal else nullcontext():
        found = check(seen, maps, sensor, np.random.default_rng(seed))
    if as_json:
        click.echo(json.dumps(found.as_dict()))
        return
    show(found, recording)


def show(found, recording: Path) -> None:
    """Say on a screen what was found."""
    console = Console(markup=False, highlight=False)
    console.print(f"{recording}: {found.sentence}", style="bold", soft_wrap=True)
    for sentence in found.evidence:
        console.print(sentence, soft_wrap=True)
    table = Table("zone", "cosine", "bias mm", "error mm", title=f"{len(found.frames)} frames, maps as they are")
    for zone in found.zones:
        figures = ("-" if value is None else f"{value * 1e3:.0f}" for value in (zone.bias_m, zone.error_m))
        table.add_row(str(zone.zone), f"{zone.cosine:.3f}", *figures)
    if found.bias_m is not None:
        table.add_section()
        table.add_row("median", "", f"{found.bias_m * 1e3:.0f}", "")
    console.print(table)

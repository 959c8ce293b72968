"""`difflidar impulse`: the impulse response of a sensor from frames whose geometry is known."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--zones", type=click.Path(path_type=Path), help="Table of the zones, zone_spec.json, in place of maps.")
@click.option("--calibration", "maps_path", type=click.Path(path_type=Path), help="Response maps, .npz.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="sensor.json to write; by zone, one each.")
@click.option("--plot", type=click.Path(path_type=Path), help="Picture of the response to write, .png.")
@click.option("--per-zone", is_flag=True, help="A response for each zone, rather than one and delays.")
@click.option("--bin-width", "fit_bin_width", is_flag=True, help="Estimate the width of the bins, too.")
@click.option("--laser-cycles", type=float, help="Shots in a frame; default: as recorded, else no pile-up.")
@click.option("--channels", default=1, show_default=True, help="Timing channels that share a zone's light evenly.")
@click.option("--nearest", default=0.0, show_default=True, help="Leave out frames nearer than this, metres.")
@click.option("--every", default=1, show_default=True, help="Use every so manieth frame.")
@click.option("--steps", default=8, show_default=True, help="Steps of the response to a bin.")
def command(
    recording,
    zones,
    maps_path,
    out,
    plot,
    per_zone,
    fit_bin_width,
    laser_cycles,
    channels,
    nearest,
    every,
    steps,
):
    """Estimate the impulse response from RECORDING, frames of a scene whose depth it keeps.

    A plane that moves in steps smaller than a bin tells the response finer than the bins. Where the number of laser
    shots is known, photons hidden by earlier ones are accounted for. Without --zones or --calibration, zones look where
    the published data say that the recording is part of.
    """
    from calibrate.impulse import fit_impulse
    from calibrate.impulse.sweep import Sweep
    from physics.sensor_file import save_sensor
    from recordings.atomic import expect_place_for
    from recordings.files import load
    from recordings.refusal import Refusal

    for path in (out, plot):
        if path is not None:
            expect_place_for(path)
    for name, value in (("every", every), ("channels", channels)):
        if value < 1:
            raise Refusal(f"--{name}: {value} found, expected 1 or more")
    found = load(recording)
    sweep = Sweep.of(found, _where(recording, zones, maps_path), laser_cycles, nearest)
    sweep = sweep.with_channels(channels).part(slice(None, None, every))
    estimate = fit_impulse(sweep, per_zone=per_zone, fit_bin_width=fit_bin_width, steps_per_bin=steps, progress=bar)
    for place, sensor in _sensors(found, sweep, estimate, out, recording.name, channels):
        save_sensor(sensor, place)
        click.echo(f"wrote {place}")
    for sentence in _sentences(sweep, estimate):
        click.echo(sentence)
    if plot is not None:
        from viewers.impulse_plot import save_impulse_plot

        save_impulse_plot(plot, estimate)
        click.echo(f"wrote {plot}")


def _where(recording, zones, maps_path):
    """The response maps that are named, or those beside the recording."""
    from recordings.files import maps_of
    from recordings.importers import tmf8820_json
    from recordings.importers.tmf8820.zones import NAME
    from recordings.maps_file import load_maps
    from recordings.refusal import Refusal

    if zones is not None and maps_path is not None:
        raise Refusal("--zones and --calibration are both given, expected one of them")
    if zones is not None:
        if zones.name != NAME:
            raise Refusal(f"{zones}: expected a table named {NAME}")
        return tmf8820_json.maps(zones)
    maps = maps_of(recording) if maps_path is None else load_maps(maps_path)
    if maps is None:
        raise Refusal(f"{recording}: no table of zones beside it, expected --calibration or --zones")
    return maps


def _sensors(recording, sweep, estimate, out, source, channels):
    """Where to write, and the sensor: one, or one for each zone that has a response of its own."""
    import numpy as np

    from physics.effects import find_effect
    from physics.sensor import SensorModel

    meta, single = recording.meta, estimate.probability.ndim == 1
    said = f"estimated from {sweep.light.frames} frames of {source}"
    width = estimate.bin_width_s
    given = "as recorded" if estimate.bin_width_sigma_s == 0 else said
    # Time zero is kept in bins: it is a place in the histogram.
    zero = sweep.time_zero_s / sweep.bin_width_s * width + estimate.delay_s
    cycles = None if sweep.shots is None else round(float(sweep.shots[0]) / channels)
    piling = () if cycles is None else (find_effect("pile_up").at(share=1 / channels),)
    for zone in (None,) if single else range(sweep.counts.shape[1]):
        column = "" if zone is None else f"-zone{zone}"
        yield (
            out.with_name(f"{out.stem}{column}{out.suffix}"),
            SensorModel(
                name=str(meta.get("sensor", "")),
                mode=str(meta.get("mode", "")),
                zone_grid=tuple(int(n) for n in recording.zone_grid),
                bins=sweep.counts.shape[2],
                bin_width_s=width,
                time_zero_s=zero,
                pulse=estimate.response(zone),
                laser_cycles=cycles,
                background_counts=np.median(estimate.pedestal, axis=0),
                effects=piling,
                sources={
                    "pulse": said + ("" if zone is None else f", zone {zone}"),
                    "bin_width_s": given,
                    "time_zero_s": "as recorded" + (", and delays of zones " + said if single else ""),
                    "background_counts": said,
                },
            ),
        )


def _sentences(sweep, estimate):
    """What was estimated, and how well."""
    import numpy as np

    width = estimate.bin_width_s
    step = estimate.time_s[1] - estimate.time_s[0]
    several = np.atleast_2d(estimate.probability)
    yield f"{sweep.light.frames} frames, {len(several[0])} steps of {step * 1e12:.2f} ps"
    rows = zip(several, *(np.atleast_1d(a) for a in (estimate.degrees, estimate.scatter, estimate.noise)), strict=True)
    for zone, (row, degrees, scatter, noise) in enumerate(rows):
        name = "response" if len(several) == 1 else f"zone {zone}"
        mean = row @ estimate.time_s
        high = estimate.time_s[row >= row.max() / 2]
        shape = f"mean {mean * 1e12:.0f} ps, {(high[-1] - high[0] + step) * 1e12:.0f} ps wide at half its height"
        yield f"{name}: {shape}; counts determine {degrees:.0f} numbers of it"
        yield f"  counts scatter {scatter:.3g} times as photons do" + (f"; model off by {noise:.1%}" if noise else "")
    if len(several) == 1:
        delays = zip(estimate.delay_s, estimate.delay_sigma_s, strict=True)
        said = ", ".join(f"{d * 1e12:+.1f} ± {s * 1e12:.1f}" for d, s in delays)
        yield f"delays of the zones about their mean, ps: {said}"
    if estimate.bin_width_sigma_s:
        said = f"{width * 1e12:.3f} ± {estimate.bin_width_sigma_s * 1e12:.3f} ps"
        yield f"bin width {said}, given as {sweep.bin_width_s * 1e12:.3f} ps"
    if estimate.gap_bins > 0.5:
        yield f"no light arrives in {estimate.gap_bins:.2f} of a bin: the response is known no finer than that"
    if not estimate.settled:
        yield "the search was stopped before it had settled; errors are not to be trusted"

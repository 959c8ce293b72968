"""`difflidar explain`: where a recording and its simulation differ, and what physics was left out."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

FILES = ("verdict.json", "report.html", "residuals.rrd", "sensor.json")
MOST_VALUES = 4  # of one parameter that are printed


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.argument("other", required=False, type=click.Path(path_type=Path))
@click.option("--calibration", "maps", type=click.Path(path_type=Path), help="Response maps, .npz; default: its own.")
@click.option("--sensor", type=click.Path(path_type=Path), help="A sensor.json; default: as recorded.")
@click.option("--mesh", type=click.Path(path_type=Path), help="Shape of the target, where no depth was recorded.")
@click.option("--zones", type=click.Path(path_type=Path), help="Where zones look, where no maps were measured.")
@click.option("--out", type=click.Path(path_type=Path), help=f"Folder that receives {', '.join(FILES)}.")
@click.option("--json", "as_json", is_flag=True, help="Print verdict.json and nothing else.")
def command(recording, other, maps, sensor, mesh, zones, out, as_json):
    """Compare RECORDING with its simulation and name the physics that the simulation lacks.

    Given two calibrations of one sensor, A.npz and B.npz, it names what makes them disagree.

    The verdict is one of three: they agree; they differ and named effects explain it; they differ and no known effect
    explains it. The exit status is 0 whatever the verdict.
    """
    from mismatch.explain import explain
    from mismatch.open_simulation import open_simulation

    if out is not None:
        expect_folder(out)
    if other is not None:
        from difflidar.explain_pair import explain_pair

        explain_pair(recording, other, out, as_json)
        return
    with waiting():
        simulation, assumed, notes = open_simulation(recording, maps, sensor, mesh=mesh, zones=zones)
        found = explain(simulation, notes)
        if out is not None:
            write(found, assumed, out, recording.name)
    if as_json:
        click.echo(found.verdict.text(), nl=False)
        return
    show(found.verdict, recording)
    if out is not None:
        click.echo(f"wrote {', '.join(str(out / name) for name in FILES)}")


def waiting():
    """A sign that work goes on, where standard error is a terminal."""
    console = Console(stderr=True)
    return console.status("comparing recording and simulation") if console.is_terminal else nullcontext()


def expect_folder(out: Path) -> None:
    """Refuse, before any work, a folder that cannot be made or written to."""
    from recordings.atomic import expect_place_for
    from recordings.refusal import Refusal

    there = next(path for path in (out, *out.absolute().parents) if path.exists())
    if not there.is_dir():
        raise Refusal(f"{out}: {there} is a file, expected a folder, or a name for one")
    if not os.access(there, os.W_OK):
        raise Refusal(f"{out}: no permission to write into {there}")
    if out.is_dir():
        for name in FILES:
            expect_place_for(out / name)


def write(found, assumed, out: Path, name: str) -> None:
    """Write all files into the folder, or none."""
    from mismatch.improved import improved_sensor
    from physics.sensor_file import save_sensor
    from viewers.explain_report import write_report
    from viewers.residual_session import write_residuals

    with all_or_none(out) as (verdict, report, residuals, sensor):
        verdict.write_text(found.verdict.text(), encoding="utf-8")
        write_report(found, report, name)
        write_residuals(found, residuals)
        save_sensor(improved_sensor(assumed, found), sensor)


@contextmanager
def all_or_none(out: Path) -> Iterator[list[Path]]:
    """Yield a path for each of FILES; they take their places in `out`, made if need be, when the block ends well."""
    from recordings.atomic import written_aside

    made = [path for path in (out, *out.parents) if not path.exists()]
    try:
        out.mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:
            yield [stack.enter_context(written_aside(out / name)) for name in FILES]
    except BaseException:
        for path in made:
            with suppress(OSError):
                path.rmdir()
        raise


def show(verdict, recording: Path) -> None:
    """Say on a screen what was found."""
    from viewers.wording import found_in_words, grouped, headline, number, plain_name, quantity

    console = Console(markup=False, highlight=False)
    console.print(f"{recording}: {headline(verdict).lower()}", style="bold", soft_wrap=True)
    console.print(found_in_words(verdict), soft_wrap=True)
    if verdict.effects:
        table = Table("effect", "parameter", "value", "gain, held out", "expected", "or")
        table.columns[2].no_wrap = True
        for effect in verdict.effects:
            others = "\n".join(f"{plain_name(o.id)} ({number(o.probability, 2)})" for o in effect.look_alikes)
            head = (plain_name(effect.id), number(effect.heldout_gain), number(effect.expected_gain), others)
            for name, values in grouped(effect.parameters):
                told = [
                    f"{i}: " * bool(i) + quantity(one.value, one.sigma, one.unit) for i, one in values[:MOST_VALUES]
                ]
                told += [f"and {len(values) - MOST_VALUES} more"] * (len(values) > MOST_VALUES)
                table.add_row(head[0], plain_name(name), "\n".join(told), *head[1:])
                head = ("",) * 4
        console.print(table)
    for place in verdict.unexplained:
        console.print(f"left: {place.sentence}", soft_wrap=True)
    for sentence in (*verdict.notes, verdict.next_measurement):
        if sentence:
            console.print(sentence, soft_wrap=True)

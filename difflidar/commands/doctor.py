"""`difflidar doctor`: is the rig ready, and what to do where it is not."""

from pathlib import Path

import click
from rich.console import Console


@click.command()
@click.argument("rig", default="rig.json", type=click.Path(path_type=Path))
@click.option("--plan", "plan_path", type=click.Path(path_type=Path), help="Check the arm's reach of this plan, too.")
@click.option("--out", default=".", type=click.Path(path_type=Path, file_okay=False), help="Where scans are written.")
def command(rig, plan_path, out):
    """Check sensor, camera, arm, clocks and disk of RIG (rig.json); say what to do about failures; nothing moves."""
    from calibrate.rig import load_rig
    from devices.doctor import examine
    from devices.scan.motion_plan import load_plan
    from recordings.refusal import Refusal

    if not rig.exists():
        raise Refusal(
            f"{rig}: no such file; expected a rig file, docs/lab.md says what is in it, `rehearse` writes one"
        )
    setup = load_rig(rig)
    plan = None if plan_path is None else load_plan(plan_path)
    if not out.is_dir():
        raise Refusal(f"{out}: no such folder")
    console = Console()
    marks = {True: "[green]good[/green]", False: "[red]wrong[/red]", None: "[yellow]unsure[/yellow]"}
    wrong = total = 0
    for finding in examine(setup, plan, out):
        console.print(f"{marks[finding.good]:>6} ", end="")
        console.print(f"{finding.what}: {finding.said}", markup=False, highlight=False, soft_wrap=True)
        if finding.remedy:
            console.print(f"       {finding.remedy}", markup=False, highlight=False, soft_wrap=True)
        wrong += finding.good is False
        total += 1
    if wrong:
        raise Refusal(f"{rig}: {wrong} of {total} checks failed, see above for what to do about each")
    console.print("The rig is ready.")

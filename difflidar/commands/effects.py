"""`difflidar effects`: the causes that are known, what their parameters mean, and what each is mistaken for."""

import json

import click
from rich.console import Console
from rich.table import Table


@click.command()
@click.argument("effect", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print the same as JSON and nothing else.")
def command(effect, as_json):
    """List the effects that `simulate` and `explain` know; or tell of one EFFECT its parameters and look-alikes."""
    from physics.effects import all_effects, find_effect
    from physics.setting import STAGES

    if effect is None:
        found = sorted(all_effects().values(), key=lambda one: (STAGES.index(one.acts_on), one.id))
    else:
        found = [find_effect(effect)]
    if as_json:
        said = [as_dict(one) for one in found]
        click.echo(json.dumps(said if effect is None else said[0]))
    elif effect is None:
        table = Table("effect", "acts on", "what happens")
        for one in found:
            table.add_row(one.id, one.acts_on, one.sentence)
        Console(markup=False).print(table)
    else:
        tell(found[0], Console(markup=False))


def tell(effect, console) -> None:
    """One effect on a screen."""
    from physics.setting import OF_EVERY

    console.print(f"{effect.id} ({effect.acts_on}): {effect.sentence}\n", highlight=False)
    table = Table("parameter", "unit", "from", "to", "may differ by", "what it is", title="Parameters")
    for one in (*effect.parameters, *OF_EVERY):
        table.add_row(one.name, one.unit, f"{one.low:g}", f"{one.high:g}", one.axis or "", one.sentence)
    console.print(table)
    if effect.forms:
        ways = Table("it may be there by", title="Fitted together")
        for form in effect.forms:
            ways.add_row(", ".join(form))
        console.print(ways)
    if effect.look_alikes:
        others = Table("mistaken for", "told apart so", title="Look-alikes")
        for other in effect.look_alikes:
            others.add_row(other.id, other.separated_by)
        console.print(others)


def as_dict(effect) -> dict:
    """The same of one effect, for JSON."""
    from physics.setting import OF_EVERY

    return {
        "id": effect.id,
        "acts_on": effect.acts_on,
        "sentence": effect.sentence,
        "parameters": [
            {
                "name": one.name,
                "unit": one.unit,
                "low": one.low,
                "high": one.high,
                "start": one.start,
                "vanishes_at": one.vanishes_at,
                "may_differ_by": one.axis,
                "sentence": one.sentence,
            }
            for one in (*effect.parameters, *OF_EVERY)
        ],
        "forms": [list(form) for form in effect.forms],
        "look_alikes": [{"id": other.id, "separated_by": other.separated_by} for other in effect.look_alikes],
    }

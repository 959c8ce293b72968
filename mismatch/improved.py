"""The improved sensor: the one assumed, with the effects that were found."""

from dataclasses import replace

from mismatch.explain import Explanation
from mismatch.likelier_response import likelier_clock
from physics.sensor import SensorModel


def improved_sensor(sensor: SensorModel, explanation: Explanation) -> SensorModel:
    """The sensor with the effects that an explanation found, at their fitted values, and what was estimated beside."""
    found = explanation.explained.settings
    ids = {setting.effect.id for setting in found}
    kept = tuple(setting for setting in sensor.effects if setting.effect.id not in ids)
    sources = sensor.sources | {"effects": "found by difflidar explain"}
    simulation = explanation.simulation
    if simulation.guessed:
        clock = simulation.clock
        if simulation.loose is not None:
            clock = likelier_clock(simulation, explanation.explained.gain, found, every=True)
        sensor = replace(sensor, pulse=clock.pulse, time_zero_s=clock.time_zero_s)
    return replace(sensor, effects=(*kept, *found), sources=sources)

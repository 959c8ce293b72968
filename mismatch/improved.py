"""The improved sensor: the one assumed, with the effects that were found."""

from dataclasses import replace

from mismatch.explain import Explanation
from physics.sensor import SensorModel


def improved_sensor(sensor: SensorModel, explanation: Explanation) -> SensorModel:
    """The sensor with the effects that an explanation found, at their fitted values, and what was estimated beside."""
    found = explanation.explained.settings
    ids = {setting.effect.id for setting in found}
    kept = tuple(setting for setting in sensor.effects if setting.effect.id not in ids)
    sources = sensor.sources | {"effects": "found by difflidar explain"}
    simulation = explanation.simulation
    if simulation.guessed:
        sensor = replace(sensor, pulse=simulation.clock.pulse, time_zero_s=simulation.clock.time_zero_s)
    return replace(sensor, effects=(*kept, *found), sources=sources)

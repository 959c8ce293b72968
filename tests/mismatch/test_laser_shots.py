"""Laser shots that a recording does not tell are those of the sensor it is compared with."""

from dataclasses import replace

import numpy as np

from mismatch.open_simulation import simulation_of
from physics.effects import find_effect
from physics.sensor import SensorModel

from .conftest import CYCLES


def test_pile_up_of_a_sensor_goes_by_the_sensors_own_shots(rig):
    counts = np.random.default_rng(1).poisson(rig.expected())
    sensor = replace(SensorModel.of(rig.recording(counts)), effects=(find_effect("pile_up").at(),))
    untold = rig.recording(counts, laser_cycles=None)
    simulation, _, _ = simulation_of(untold, rig.maps, replace(sensor, laser_cycles=int(CYCLES)))
    assert (simulation.light.laser_cycles == CYCLES).all()
    # First photons, bin after bin, of what would have been counted.
    lossless, left = rig.expected() / CYCLES, 1.0
    first = np.empty_like(lossless)
    for t in range(lossless.shape[-1]):
        first[..., t] = CYCLES * left * (1 - np.exp(-lossless[..., t]))
        left = left * np.exp(-lossless[..., t])
    np.testing.assert_allclose(simulation.expected(rig.gain), first, rtol=1e-5)


def test_what_the_recording_tells_goes_first(rig):
    counts = np.random.default_rng(1).poisson(rig.expected())
    sensor = replace(SensorModel.of(rig.recording(counts)), laser_cycles=7)
    simulation, _, _ = simulation_of(rig.recording(counts), rig.maps, sensor)
    assert (simulation.light.laser_cycles == CYCLES).all()

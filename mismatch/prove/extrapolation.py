"""Named physics and a black box fitted on near frames, tested on far ones."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mismatch.black_box import fit_black_box
from mismatch.explain import explain
from mismatch.fit import fit_nominal, on_others
from mismatch.noise import Nuisances
from mismatch.open_simulation import simulation_of
from mismatch.poisson import expected_deviance
from mismatch.prove.rig import FRAME_S, HORIZONTAL_DEG, draw_maps
from mismatch.simulation import Simulation
from physics.effects import find_effect
from physics.geometry import pixel_rays
from physics.pulse_shape import PulseShape, Tail
from physics.scene.camera import pinhole
from physics.scene.cast import Thing, look
from physics.scene.material import Material
from physics.scene.surfaces import Plane
from physics.scene.view import Views
from physics.sensor import SensorModel
from physics.setting import Setting
from physics.simulate import simulate

SIZE = (53, 30)
NEAREST_M, FARTHEST_M = 0.35, 2.0
NEAR_M = 0.8
WIDTH_S = 0.2e-9
PEAK = 2e4  # counts in the fullest bin of the nearest frame, before the effect
# A cause of each kind, as strong as such sensors show it or somewhat stronger.
CAUSES: dict[str, dict[str, float]] = {
    "pile_up": {"share": 1.0},
    "range_walk": {"walk": 1e-10, "level": 2e4},
    "impulse_tail": {"share": 0.1, "tau": 5e-10},
    "range_falloff": {"overlap_range": 0.15},
    "counter_saturation": {"ceiling": 4095.0},
}


@dataclass(frozen=True)
class SideBySide:
    """Poisson deviance per cell on held-out frames: (of the near ones, of the far ones) each.

    cause: concealed. named: what the near frames were explained by. noise: what photon noise alone would give.
    smoothness: of the black box, as it chose.
    """

    cause: str
    named: tuple[str, ...]
    nominal: tuple[float, float]
    physics: tuple[float, float]
    black_box: tuple[float, float]
    noise: tuple[float, float]
    smoothness: float


def compare_on_far(simulation: Simulation, near: np.ndarray, cause: str = "") -> SideBySide:
    """Explain the near frames (indices), fit a black box to those of them that chose, and test both on all others."""
    far = np.setdiff1d(np.arange(len(simulation.counts)), near)
    found = explain(simulation.of(near))
    train, tests = simulation.of(near[found.chosen]), (simulation.of(near[found.held]), simulation.of(far))
    nominal = fit_nominal(train)
    box = fit_black_box(train, nominal.expected)
    rows = []
    for test in tests:
        before, _ = on_others(test, nominal)
        named, _ = on_others(test, found.judged)
        nuisances = Nuisances(test, 0.0)
        noise = float(expected_deviance(named)[0].sum())
        totals = (
            nuisances.deviance(before),
            nuisances.deviance(named),
            nuisances.deviance(box.expected(test, before)),
            noise,
        )
        rows.append([total / test.counts.size for total in totals])
    each = zip(*rows, strict=True)
    effects = tuple(form.effect.id for form in found.judged.forms)
    return SideBySide(cause, effects, *(tuple(pair) for pair in each), box.smoothness)


def sweeps(seed: int, frames: int = 64) -> Iterator[tuple[str, Simulation, np.ndarray]]:
    """A recording with each of CAUSES of a wall that recedes, and its near frames by index."""
    for number, (name, values) in enumerate(CAUSES.items()):
        rng = np.random.default_rng([seed, number])
        simulation, distance = sweep(rng, find_effect(name).at(**values), frames)
        yield name, simulation, np.flatnonzero(distance < NEAR_M)


def sweep(rng: np.random.Generator, effect: Setting, frames: int) -> tuple[Simulation, np.ndarray]:
    """A recording of a wall that recedes and sways, under an effect, beside its simulation without; (F,) distances."""
    distance = np.geomspace(NEAREST_M, FARTHEST_M, frames)
    sensor = SensorModel(
        name="drawn", mode="drawn", zone_grid=(3, 3), bins=128, bin_width_s=WIDTH_S, time_zero_s=12 * WIDTH_S,
        pulse=PulseShape(WIDTH_S, 1.3 * WIDTH_S, (Tail(2 * WIDTH_S, 0.1),)), laser_cycles=120_000,
        background_counts=rng.uniform(2, 10, 9),
    )  # fmt: skip
    maps, matrix = draw_maps(rng), pinhole(SIZE, HORIZONTAL_DEG)
    rays = pixel_rays(matrix, (SIZE[1], SIZE[0]))
    wall = Material(float(rng.uniform(0.3, 0.9)))

    def views():
        for i, metres in enumerate(distance):
            tilt = 0.15 * np.sin([0.9 * i, 0.7 * i + 1])
            things = [Thing(Plane(np.array([0, 0, metres]), np.array([*tilt, -1.0])), wall)]
            yield look(things, rays, np.eye(4), i * FRAME_S)

    seen = Views(matrix, views(), frames, meta={"calibration_range_m": 0.6})
    stream, _ = simulate(seen, maps, replace(sensor, effects=(effect,)), rng, peak=PEAK)
    simulation, _, _ = simulation_of(stream.collect(), maps, sensor)
    return simulation, distance

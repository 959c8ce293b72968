"""The demo's second half: a recording in which one cause is concealed, and what `explain` makes of it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

# What the demo may conceal, each as strong as sensors of this class show it.
CONCEALED = {
    "impulse_tail": {"share": 0.08, "tau": 6e-10},
    "stray_light": {"share": 0.01},
    "time_zero_offset": {"delay": [5e-11, -3e-11, 0.0, 2e-11, -5e-11, 4e-11, 0.0, -2e-11, 3e-11]},
    "afterpulsing": {"probability": 0.02, "tau": 8e-9},
    "gain_drift": {"rate": 0.02, "background": 0.0},
}
FRAMES = 48
PEAK = 3000.0


def conceal(maps_path: Path, recording_path: Path, rng: np.random.Generator) -> str:
    """Write a recording drawn photon by photon through these maps, one cause concealed; the cause's id."""
    from mismatch.prove.rig import draw_views
    from physics.effects import find_effect
    from physics.footprint import footprints
    from physics.nominal import ForwardModel
    from physics.presets import preset
    from physics.simulate import light_of
    from physics.single_photons.engine import record
    from recordings.files import save
    from recordings.maps_file import load_maps

    name = str(rng.choice(sorted(CONCEALED)))
    maps, sensor = load_maps(maps_path), preset("tmf8828-3x3-wide-long")
    scene = draw_views(rng, FRAMES, 3.0)
    views = list(scene.views)
    light = light_of(views, scene.intrinsics, sensor, views[0].timestamp_s)
    seen = ForwardModel(light, footprints(maps, views[0].depth_m.shape), sensor.clock).expected()
    true = replace(sensor, effects=(find_effect(name).at(**CONCEALED[name]),))
    drawn = record(replace(scene, views=iter(views)), maps, true, rng, PEAK / float(seen.max()))
    save(replace(drawn, meta_json='{"calibration_range_m": 0.6}'), recording_path)
    return name


def find(maps_path: Path, recording_path: Path, out: Path) -> tuple[str, ...]:
    """Explain the recording from its file, write what `difflidar explain` writes; the ids that it names."""
    from difflidar.commands.explain import write
    from mismatch.explain import explain
    from mismatch.open_simulation import open_simulation

    simulation, sensor, notes = open_simulation(recording_path, maps_path)
    found = explain(simulation, notes)
    write(found, sensor, out, recording_path.name)
    return tuple(effect.id for effect in found.verdict.effects)

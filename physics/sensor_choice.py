"""Which sensor is meant, by a file, a name, or what it is to look at."""

from pathlib import Path

from physics.presets import preset, preset_names
from physics.sensor import SensorModel
from physics.sensor_file import load_sensor
from recordings.files import WRITTEN, load
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# The layout that maps of a zone grid are most likely of.
USUAL = {(3, 3): "3x3-wide", (4, 4): "4x4-normal", (6, 3): "3x6", (8, 8): "8x8"}


def choose_sensor(name: str | None, scene: str | Path, maps: ResponseMaps) -> SensorModel:
    """The sensor in the file `name`, or the preset of that name.

    Where `name` is None, the one that the recording at `scene` was made with, or else the TMF8828 with the zones of the
    maps, in the range mode of the recording or the maps.
    """
    if name in preset_names():
        return preset(name)
    if name is not None:
        if not Path(name).suffix and not Path(name).exists():
            raise Refusal(f"{name}: neither a sensor.json nor a preset, expected one such as {preset_names()[8]}")
        return load_sensor(name)
    meta = maps.meta if maps is not None else {}
    if Path(scene).suffix in WRITTEN:
        recording = load(scene)
        # A real TMF882x does not say what its impulse response is; which device it is says that.
        if recording.irf is not None or not str(recording.meta.get("sensor", "")).startswith("TMF882"):
            return SensorModel.of(recording)
        meta = recording.meta
    if maps.zone_grid not in USUAL:
        rows, columns = maps.zone_grid
        raise Refusal(f"the response maps have {rows} x {columns} zones, of no preset; expected a sensor to be given")
    ranging = "short" if str(meta.get("ranging", "")).startswith("short") else "long"
    return preset(f"tmf8828-{USUAL[maps.zone_grid]}-{ranging}")

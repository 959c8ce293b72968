"""What the LiDAR says of itself, as plain values for a recording."""

from typing import Any

from calibrate.rig import LidarSetup
from devices.tmf882x.calibration_page import zone_zero_bins
from devices.tmf882x.connection import Connection
from devices.tmf882x.start import Started


def said(setup: LidarSetup, link: Connection, lost: dict[str, Any]) -> dict[str, Any]:
    """Of a sensor that is set up; `lost` counts what was lost on the way."""
    values = {
        "port": link.port,
        "baud": setup.baud,
        "firmware": link.firmware,
        "mode": setup.mode,
        "ranging": link.ranging or setup.ranging,
        "ranging_is": _how_known(link),
        "kilo_iterations": setup.kilo_iterations or None,
    }
    if link.started is not None:
        values |= _of_commanded(setup, link.started)
    return values | {"lost": lost}


def _how_known(link: Connection) -> str:
    """How the range mode is known."""
    if link.ranging is None:
        return "assumed"
    return "said by the firmware" if link.started is None else "read back"


def _of_commanded(setup: LidarSetup, started: Started) -> dict[str, Any]:
    zeros = zone_zero_bins(started.pages, setup.mode)
    return {
        "driver": started.device["driver"],
        "chip_firmware": started.device["firmware"],
        "chip": started.device["chip"],
        "serial": started.device["serial"],
        "kilo_iterations": started.setting.kilo_iterations,
        "period_ms": started.setting.period_ms,
        "spad_map_id": started.setting.spad_map,
        "persistence": started.setting.persistence,
        "histograms": "raw",
        "factory_calibration": {
            "file": setup.factory_calibration or None,
            # Histograms are the same without; distances that the chip finds are not.
            "on_chip": started.given,
            "pages": [page.said() for page in started.pages],
            "zone_zero_bins": None if zeros is None else zeros.tolist(),
        },
    }

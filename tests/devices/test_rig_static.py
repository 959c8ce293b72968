"""What a rig's recordings say of time zero: the sensor's own where it was read, or that it is another one's."""

import numpy as np
import pytest

from calibrate.rig import Rig
from devices.rig_static import rig_meta, rig_static
from physics.timing import tmf882x_timing


@pytest.mark.parametrize(
    "pages", [{}, {"factory_calibration": None}, {"factory_calibration": {"zone_zero_bins": None}}]
)
def test_a_time_zero_of_a_table_is_said_to_be_assumed(pages):
    rig = Rig()
    timing = tmf882x_timing(rig.lidar.ranging, 9)
    np.testing.assert_array_equal(rig_static(rig, pages, {})["time_zero_s"], timing.time_zero_s)
    (said,) = rig_meta(rig, pages, {}, "scan")["assumed"]
    assert said.startswith("time_zero_s")


def test_a_time_zero_of_the_sensor_itself_is_not():
    rig, own = Rig(), [15.0 + 0.1 * zone for zone in range(9)]
    pages = {"factory_calibration": {"zone_zero_bins": own}}
    timing = tmf882x_timing(rig.lidar.ranging, 9)
    np.testing.assert_allclose(rig_static(rig, pages, {})["time_zero_s"], np.array(own) * timing.bin_width_s)
    assert "assumed" not in rig_meta(rig, pages, {}, "scan")

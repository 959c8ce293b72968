"""What `#Conf` says, in the words of the protocol."""

import pytest

from calibrate.rig import LidarSetup
from devices.tmf882x.settings import CONF, measurement_s, setting_from


def setting(line, mode_8828=False):
    return setting_from(CONF.fullmatch(line), mode_8828=mode_8828)


@pytest.mark.parametrize(
    ("line", "mode_8828", "mode", "kilo"),
    [
        ("#Conf,Period=16ms,KIter=10000 SPAD=6 Pers=0", False, "3x3", 10000),
        ("#Conf,Period=8ms,KIter=2500 SPAD=7 Pers=0", False, "4x4", 2500),
        ("#Conf,Period=33ms,KIter=537 SPAD=1 Pers=3", False, "3x3", 537),
        ("#Conf,Period=33ms,KIter=537 SPAD=10 Pers=0", False, "3x6", 537),
        ("#Conf,Period=33ms,KIter=537 SPAD=13 Pers=0", False, "4x4", 537),
        ("#Conf,Period=132ms,KIter=10 SPAD=15 Pers=0", True, "8x8", 10),
        # Without the image of the larger sensor, map 15 is the user's.
        ("#Conf,Period=132ms,KIter=10 SPAD=15 Pers=0", False, None, 10),
    ],
)
def test_lines(line, mode_8828, mode, kilo):
    one = setting(line, mode_8828)
    assert (one.mode, one.kilo_iterations) == (mode, kilo)
    assert one.serves(LidarSetup(mode=mode or "3x3")) == (mode is not None)
    assert not one.serves(LidarSetup(mode=mode or "3x3", kilo_iterations=kilo + 1))


@pytest.mark.parametrize(
    "line",
    ["#Conf,Period=16ms,KIter=10000,SPAD=6,Pers=0", "#Conf,Period=16ms,KIter=1000", "#Err,Config", "#Conf,Perio"],
)
def test_other_lines_are_none(line):
    assert CONF.fullmatch(line) is None


def test_a_measurement_takes_its_bursts_and_more():
    """The datasheet has 230 ms for 4000 kilo-iterations of 3 x 3 zones, twice as much of 4 x 4."""
    assert 0.230 < measurement_s("3x3", 4000, 0) < 1
    assert 0.460 < measurement_s("4x4", 4000, 0) < 2
    assert measurement_s("3x3", 10, 5000) >= 5

"""The patch holder: its volume by hand, its fit to the flange, and the tool that it makes."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from calibrate.rig import ArmSetup, Rig
from devices.parts.holder import Holder
from devices.parts.solids import box, cylinder


@pytest.fixture(scope="module")
def holder():
    return Holder.of(Rig())


def disc(radius, length=1.0):
    return np.pi * radius**2 * length


def test_every_part_is_a_closed_body(holder, tmp_path):
    for part in (holder.column, holder.front, holder.cover):
        stl = trimesh.load_mesh(part.save(tmp_path))
        assert stl.is_watertight
        assert stl.body_count == 1
        assert stl.bounds[0][2] == pytest.approx(0, abs=1e-4)
        assert stl.extents == pytest.approx(part.size, abs=1e-4)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["column.stl", "cover.stl", "front.stl"]


def test_front_and_cover_by_hand(holder):
    radius = 31.5 + 35 * np.tan(np.radians(35))
    assert holder.front.size == pytest.approx([2 * radius, 2 * radius, 5], abs=0.02)
    sink = (6.7 - 3.4) / 2
    cone = np.pi * sink / 3 * (1.7**2 + 1.7 * 3.35 + 3.35**2)
    blank = disc(radius, 5) - 4 * (disc(1.7, 5 - sink) + cone)
    assert holder.cover.solid.volume() == pytest.approx(blank, rel=2e-3)
    recess = holder.cover.solid.volume() - holder.front.solid.volume()
    assert recess == pytest.approx(disc(17.6, 0.5), rel=2e-3)


def test_column_by_hand(holder):
    """The base is the flange's disc with four holes of 6.6 and a dowel's; the column lacks four channels."""
    base = holder.column.solid ^ box((-50, -50, 6.5), (50, 50, 7.5))
    assert base.volume() == pytest.approx(disc(31.5) - 4 * disc(3.3), rel=2e-3)
    below = holder.column.solid ^ box((-50, -50, 1), (50, 50, 2))
    assert base.volume() - below.volume() == pytest.approx(disc(3.05), rel=1e-2)
    above = holder.column.solid ^ box((-50, -50, 12), (50, 50, 13))
    # A channel: half a disc, and a strip as wide out to the rim of the column, by summing thin strips.
    across = np.linspace(-5.75, 5.75, 20001)
    strip = np.trapezoid(np.sqrt(31.5**2 - across**2) - 25, across)
    assert above.volume() == pytest.approx(disc(31.5) - 4 * (disc(5.75) / 2 + strip), rel=2e-3)


@pytest.mark.parametrize("turn", [45, 135, 225, 315])
def test_a_screw_reaches_the_flange_and_its_head_finds_room(holder, turn):
    bolt = cylinder((25, 0, -1), 9.5, 6.2) + cylinder((25, 0, 8.01), 30, 10.5)
    assert (holder.column.solid ^ bolt.rotate([0, 0, turn])).volume() < 1e-6


def test_front_and_column_share_their_screws(holder):
    lifted = holder.front.solid.translate([0, 0, 30])
    for turn in (0, 90, 180, 270):
        screw = cylinder((26, 0, 20.5), 15, 2.3).rotate([0, 0, turn])
        assert ((holder.column.solid + lifted) ^ screw).volume() < 1e-6
        assert not (holder.column.solid ^ cylinder((26, 0, 20.5), 15, 3.3).rotate([0, 0, turn])).is_empty()


def test_the_flange_is_hidden(holder):
    """From 35 deg off the axis, the line past the front's rim just touches the flange's rim."""
    line = holder.front_radius - holder.length * np.tan(np.radians(35))
    assert line == pytest.approx(31.5)


@pytest.mark.parametrize(("radius", "column"), [(0.01, 31.5), (0.0174, 31.5), (0.03, 38.8), (0.05, 58.8)])
def test_a_larger_patch_has_a_larger_column(radius, column):
    """Screws stand 2 mm and half a head, 3.35, outside the recess; 2 mm and half a pilot, 1.25, are around them."""
    holder = Holder.of(Rig(patch_radius_m=radius))
    assert holder.column_radius == pytest.approx(column)
    assert holder.circle - 3.35 - holder.recess >= 2 - 1e-9
    assert len(holder.front.solid.decompose()) == 1


def test_the_tool_is_held_against_the_rig():
    rig = Rig()
    said = Holder.of(rig).mismatch(rig)
    assert "(0, 0, 0) mm" in said
    assert '"tool": [0.0, 0.0, 0.035, 0.0, 0.0, 0.0]' in said
    right = replace(rig, arm=ArmSetup(tool=(0, 0, 0.0352, 0, 0, 0)))
    assert Holder.of(right).mismatch(right) is None
    longer = replace(right, mount={"standoff": 40.0})
    assert "(0, 0, 53) mm" in Holder.of(longer).mismatch(longer)
    aside = replace(rig, arm=ArmSetup(tool=(0.01, 0, 0.035, 0, 0, 0)))
    assert Holder.of(aside).mismatch(aside) is not None

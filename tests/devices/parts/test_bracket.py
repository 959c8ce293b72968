"""The bracket holds camera and LiDAR where the rig says: held against geometry written out anew, in plain numbers."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from calibrate.rig import Rig
from devices.parts.bracket import Bracket
from devices.parts.clear import expect_clear, expect_in_reach, expect_printable
from devices.parts.holder import Holder
from devices.parts.placed import Placed
from devices.parts.solids import box
from recordings.refusal import Refusal

RIGS = {
    "below": Rig(),
    "above, tilted": Rig(lidar_position_m=(0.0325, -0.034, 0.0), lidar_rotation_deg=(8.0, -5.0, 2.0)),
    "beside": Rig(lidar_position_m=(-0.035, 0.0, 0.0)),
    "a little turned": Rig(lidar_rotation_deg=(-0.3, -0.4, 0.5)),
}


def bracket_of(rig):
    return Bracket(Placed.of(rig))


@pytest.fixture(scope="module", params=RIGS)
def bracket(request):
    return bracket_of(RIGS[request.param])


@pytest.fixture(scope="module", params=["above, tilted", "beside"])
def unusual(request):
    return bracket_of(RIGS[request.param])


@pytest.fixture(scope="module")
def stl(bracket, tmp_path_factory):
    path = bracket.part.save(tmp_path_factory.mktemp("stl"))
    return trimesh.load_mesh(path)


def filled(part, spacing):
    """Voxels of a part, by even-odd crossing of its slices: knows nothing of how the part was made."""
    low, high = np.array(part.solid.bounding_box()).reshape(2, 3)
    x, y, z = (np.arange(a + spacing / 2, b, spacing) for a, b in zip(low, high, strict=True))
    solid = np.zeros((len(x), len(y), len(z)), bool)
    for k, height in enumerate(z):
        outlines = part.solid.slice(height).to_polygons()
        a, b = np.vstack(outlines), np.vstack([np.roll(outline, -1, axis=0) for outline in outlines])
        edge, row = np.nonzero((y >= np.minimum(a, b)[:, 1:]) & (y < np.maximum(a, b)[:, 1:]))
        share = (y[row] - a[edge, 1]) / (b[edge, 1] - a[edge, 1])
        crossings = np.zeros((len(x) + 1, len(y)), int)
        np.add.at(crossings, (np.searchsorted(x, a[edge, 0] + share * (b - a)[edge, 0]), row), 1)
        # A voxel is inside where an odd number of edges lies to its right.
        solid[:, :, k] = np.cumsum(crossings[::-1], axis=0)[::-1][1:] % 2
    return solid


def thin(solid, spacing, wall):
    """Largest volume, mm³, of what a ball of the wall's diameter cannot reach from inside."""
    padded = np.pad(solid, 3)
    radius = wall / 2 - spacing
    core = ndimage.distance_transform_edt(padded, spacing) > radius
    reached = ndimage.distance_transform_edt(~core, spacing) <= radius + 1.5 * spacing
    labels, count = ndimage.label(padded & ~reached)
    return max(np.bincount(labels.ravel())[1:], default=0) * spacing**3 if count else 0.0


def test_the_file_is_a_closed_body_in_millimetres_on_its_base(bracket, stl):
    assert stl.is_watertight
    assert stl.is_winding_consistent
    assert stl.body_count == 1
    assert stl.volume == pytest.approx(bracket.part.solid.volume(), rel=1e-4)
    assert stl.bounds[0][2] == pytest.approx(0, abs=1e-4)
    assert stl.bounds.mean(axis=0)[:2] == pytest.approx([0, 0], abs=1e-4)
    base = stl.triangles_center[:, 2] < 1e-3
    assert stl.area_faces[base].sum() > 0.8 * (np.prod(stl.extents[:2]) - 600)


def test_extents_by_hand():
    """Sums of measures for the usual rig: 45 from back to the end of the foot; 73.2 is two pitches, holes and ribs."""
    width, height, depth = bracket_of(Rig()).part.size
    assert depth == pytest.approx(5 + 40)
    assert width == pytest.approx(2 * (25 + 6.6 + 5))
    # Top: pads of 10 about the middle, and 1. Foot: 1 below what the LiDAR sees where the foot ends, 8 thick.
    face = (4.3 - 25.05) - (16 - 2.5 - 5)
    seen = 24 + 1 + (face + 40 + 20) * np.tan(np.radians(26))
    assert height == pytest.approx(5 + 1 + seen + 1 + 8, abs=1e-3)


def test_volume_by_hand():
    """The plate with its holes, cut out of the bracket between back and face: no post or pad reaches there."""
    bracket = bracket_of(Rig())
    left, right = bracket.sides
    low = np.array([left, -6.0, bracket.face - 5])
    inside = bracket.part.solid ^ box(low, (right, bracket.foot_top + 8, bracket.face - 3.5))
    area = (right - left) * (6 + bracket.foot_top + 8)
    area -= 2 * np.pi * 1.7**2 + (20.32 - 7 - 2) ** 2 + 2 * 5 * 2.5
    # The two posts with screws are drilled 8 deep from 23 behind the LiDAR's plane: not as far as this.
    assert inside.volume() == pytest.approx(1.5 * area, rel=2e-3)


def test_no_wall_is_thin(unusual):
    assert thin(filled(unusual.part, 0.5), 0.5, 2.0) < 1.5


def test_thin_walls_would_be_found():
    part = bracket_of(Rig()).part
    leaf = box((0, 0, 0), (30, 1.0, 30))
    assert thin(filled(replace(part, solid=leaf), 0.25), 0.25, 2.0) > 100


def test_the_sensor_ends_up_where_the_rig_says(bracket):
    """Posts end in the plane of the board's back: 1.6 board and 1.4 sensor behind the optical centre."""
    rig = next(
        rig
        for rig in RIGS.values()
        if np.allclose(Placed.of(rig).position, bracket.placed.position)
        and np.allclose(Placed.of(rig).rotation, bracket.placed.rotation)
    )
    a, b, c = np.radians(rig.lidar_rotation_deg)
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    about_z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    rotation = about_z @ about_y @ about_x
    position = np.array(rig.lidar_position_m) * 1e3
    solid = trimesh.Trimesh(*_triangles(bracket.part.solid))
    at_posts = (solid.vertices - position) @ rotation
    flat = np.abs(at_posts[:, 2] + 3.0) < 1e-3
    assert np.count_nonzero(flat) > 40
    for x in (-10.16, 10.16):
        for y in (-10.16, 10.16):
            around = np.hypot(at_posts[flat, 0] - x, at_posts[flat, 1] - y)
            rims = around[around < 4]
            assert rims.max() == pytest.approx(3.5, abs=0.02)
            # What remains inside: the rim of a pilot hole of 2.5, or of a pin of 3.
            assert rims.min() == pytest.approx(1.25, abs=0.02) or rims.min() == pytest.approx(1.5, abs=0.02)


def _triangles(solid):
    triangles = solid.to_mesh()
    return triangles.vert_properties[:, :3], triangles.tri_verts


def test_screws_of_the_camera_go_through_the_plate(bracket):
    for sign in (-1, 1):
        at = 32.5 + sign * 22.5
        drill = box((at - 1.1, -1.1, -80), (at + 1.1, 1.1, 0))
        assert (bracket.part.solid ^ drill).is_empty()


def test_fields_of_view_are_clear_by_rays(bracket):
    """Rays drawn one by one, not the pyramids that were checked; the camera's body as the box it fits in, rounded."""
    placed, rng = bracket.placed, np.random.default_rng(0)
    expect_clear(bracket, bracket.part)
    reaches = np.repeat([1, 5, 12, 20, 30, 50], 120)[:, None]
    tangents = rng.uniform(-1, 1, (len(reaches), 2)) * np.tan(np.radians([20.4, 25.9]))
    points = placed.position + reaches * np.c_[tangents, np.ones(len(reaches))] @ placed.rotation.T
    assert not inside(bracket.part.solid, points).any()
    y, z = np.abs(points[:, 1]), points[:, 2]
    in_body = (y < 12.5) & (z < 4.3) & (z > 4.3 - 25.05) & (np.abs(points[:, 0] - 32.5) < 45)
    corner = np.hypot(np.maximum(y - 8, 0), np.maximum(np.abs(z - (4.3 - 12.525)) - 8.025, 0))
    assert not (in_body & (corner < 4.49)).any()
    tangents = rng.uniform(-1, 1, (len(reaches), 2)) * np.tan(np.radians([34.5, 21]))
    points = reaches * np.c_[tangents, np.ones(len(reaches))]
    assert not inside(bracket.part.solid, points).any()
    assert not inside(placed.board, points).any()


def inside(solid, points):
    """Which points lie in a solid: by the sum of the solid angles of its triangles (van Oosterom & Strackee 1983)."""
    corners = np.asarray(_triangles(solid)[0], float)[_triangles(solid)[1]]
    low, high = corners.reshape(-1, 3).min(axis=0), corners.reshape(-1, 3).max(axis=0)
    found = np.zeros(len(points), bool)
    for i in np.flatnonzero(((points > low) & (points < high)).all(axis=1)):
        a, b, c = np.moveaxis(corners - points[i], 1, 0)
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c))
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        found[i] = abs(np.arctan2(volume, below).sum() * 2) > 2 * np.pi
    return found


def test_what_is_inside_would_be_found():
    points = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 0.99], [0.5, 0.5, 1.01], [2, 2, 2]])
    assert inside(box((0, 0, 0), (1, 1, 1)), points).tolist() == [True, True, False, False]


@settings(max_examples=12)
@given(
    st.tuples(st.floats(-0.06, 0.12), st.floats(-0.06, 0.06), st.floats(-0.03, 0.02)),
    st.tuples(*[st.floats(-12, 12)] * 3),
)
def test_whatever_the_rig_it_is_one_sound_body_or_one_sentence(position, rotation):
    bracket = bracket_of(Rig(lidar_position_m=position, lidar_rotation_deg=rotation))
    try:
        part = bracket.part
        expect_clear(bracket, part)
        expect_printable(part, 220)
    except Refusal:
        return
    surface = trimesh.Trimesh(*_triangles(part.solid))
    assert surface.is_watertight
    assert surface.body_count == 1
    assert (part.solid ^ bracket.placed.camera).volume() < 0.5


@pytest.mark.parametrize(
    ("rig", "says"),
    [
        (Rig(lidar_position_m=(0.03, 0.0, -0.005)), "puts the sensor into the camera"),
        (Rig(lidar_position_m=(0.03, 0.0, -0.04)), "the camera's body stands in the field of view of the LiDAR"),
        (Rig(lidar_position_m=(0.03, -0.03, 0.05)), "board stands in the field of view of the colour camera"),
        (Rig(lidar_position_m=(0.0325, 0.026, -0.03)), "mount.shelf_thickness 0"),
        (Rig(lidar_rotation_deg=(0.0, 60.0, 0.0)), "turns the LiDAR 60 deg"),
        (Rig(lidar_position_m=(0.1, 0.05, -0.15)), "M3 screws of at most 50 mm"),
        (Rig(lidar_position_m=(0.212, 0.05, -0.02)), "bracket is .* the printer's bed"),
        (Rig(lidar_position_m=(0.0, 1e6, 0.0)), "from the camera, expected at most 220 mm"),
        (Rig(mount={"pst": 7.0}), "did you mean 'post'"),
        (Rig(mount={"zebra": 7.0}), "difflidar mount --example"),
        (Rig(mount={"post": 0.0}), "rig.mount.post is 0, expected millimetres above 0"),
        (Rig(mount={"base_thickness": 7.0}), "base_thickness less dowel_depth leaves a wall of 1 mm"),
        (Rig(mount={"post": 6.0}), "post round m3_pilot leaves a wall of 1.75 mm"),
        (Rig(mount={"lidar_width_deg": 190.0}), "expected degrees"),
        (Rig(mount={"front_radius": 25.0}), "recess of 17.6 mm radius"),
        (Rig(patch_radius_m=0.1), "the printer's bed"),
    ],
)
def test_what_cannot_be_built_is_one_sentence(rig, says):
    with pytest.raises(Refusal, match=says) as wrong:
        build(rig)
    assert "\n" not in str(wrong.value)
    assert "expected" in str(wrong.value) or "did you mean" in str(wrong.value)


def build(rig):
    placed = Placed.of(rig)
    expect_in_reach(placed)
    bracket, holder = Bracket(placed), Holder.of(rig)
    expect_clear(bracket, bracket.part)
    for part in (bracket.part, holder.column, holder.front):
        expect_printable(part, placed.measures.bed)


def test_the_angle_that_is_blocked_is_named():
    """24.3 behind the front of a body without rounding, 11.5 below its edge: atan(11.5 / 24.3) is 25.3 deg."""
    rig = Rig(mount={"camera_edge": 0.0, "lidar_window_height": 0.01, "lidar_window_width": 0.01})
    with pytest.raises(Refusal, match="up to 25 deg from its axis"):
        build(rig)

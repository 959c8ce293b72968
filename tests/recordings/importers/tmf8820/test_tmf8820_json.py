"""The importer of the TMF8820 data sets on small files made here."""

import numpy as np
import pytest

from recordings import files
from recordings.importers import tmf8820_json
from recordings.refusal import Refusal

C = 299_792_458


def test_a_plane_is_seen_square(folder, frame, written, rays_through):
    recording = tmf8820_json.stream(written(folder, [frame(0), frame(1, dist_to_plane=0.5)])).collect()
    assert (recording.depth_m[0] == 0.25).all()
    assert (recording.depth_m[1] == 0.5).all()
    rays = rays_through(recording)
    np.testing.assert_allclose(recording.incidence_cosine[0], rays[..., 2] / np.linalg.norm(rays, axis=-1), rtol=1e-6)
    assert recording.camera_pose[:, 3].tolist() == [[0, 0, 0, 1]] * 2
    assert recording.timestamp_s.tolist() == [0.0, 2.0]
    assert recording.counts.dtype == np.uint32
    assert recording.bin_width_s == pytest.approx(2 / (C * 73.484))


def test_rays_that_miss_the_mesh_have_no_depth(folder, frame, written, stl, rays_through):
    # Edges that run through no pixel's centre.
    triangle = [(-5, -5.03, 2), (5, -5.03, 2), (0.0013, 0.0171, 2)]
    (folder / "scene.stl").write_bytes(stl(triangle))
    pose = np.eye(4).tolist()
    recording = tmf8820_json.stream(written(folder, [frame(pose=pose, dist_to_plane=...)], "scene.json")).collect()
    x, y, _ = np.moveaxis(2 * rays_through(recording), 2, 0)
    left, right = ((0.0013 - side) / (0.0171 + 5.03) * (y + 5.03) + side for side in (-5, 5))
    hit = (left < x) & (x < right) & (y < 0.0171)
    assert 0 < hit.mean() < 0.5
    np.testing.assert_array_equal(np.isfinite(recording.depth_m[0]), hit)
    np.testing.assert_array_equal(np.isfinite(recording.incidence_cosine[0]), hit)
    np.testing.assert_allclose(recording.depth_m[0][hit], 2, rtol=1e-6)


def test_maps_are_one_inside_a_zone_and_none_outside(folder, zone_table):
    """Oracle: points strewn over each pixel, counted inside the rectangle of angles."""
    maps = tmf8820_json.maps(folder / "sweep.json")
    width, height = maps.image_size
    assert maps.responses.shape == (3, 3, width * height)
    matrix = np.array(maps.meta["intrinsics"])
    strewn = (np.arange(10) + 0.5) / 10 - 0.5
    x = maps.xs[:, None, None] + strewn[None, :, None]
    y = maps.ys[:, None, None] + strewn[None, None, :]
    angle_x = np.arctan((x - matrix[0, 2]) / matrix[0, 0])
    angle_y = np.arctan((y - matrix[1, 2]) / matrix[1, 1])
    for zone, entry in zip(maps.by_zone, zone_table(), strict=True):
        inside = np.abs(angle_x - entry["center"][0]) < entry["width"] / 2
        inside = inside & (np.abs(angle_y - entry["center"][1]) < entry["height"] / 2)
        np.testing.assert_allclose(zone, inside.mean(axis=(1, 2)), atol=0.11)
    np.testing.assert_allclose(maps.by_zone.sum(axis=0).max(), 1)


def test_without_a_valid_counter_time_is_said_to_be_assumed(folder, frame, written):
    chip = {"tick": 1000}
    recording = tmf8820_json.stream(written(folder, [frame(0), frame(1, distances=[chip])])).collect()
    assert recording.timestamp_s.tolist() == [0.0, 1.0]
    assert any("timestamp_s" in line for line in recording.meta["assumed"])


def test_only_histograms_and_a_place_are_needed(folder, frame, written):
    bare = frame(distances=..., reference_hist=..., pose=...)
    recording = tmf8820_json.stream(written(folder, [bare])).collect()
    assert recording.camera_pose is None
    assert recording.meta["publisher_fields"] == {"dist_to_plane": [0.25]}


def test_a_byte_order_mark_is_no_obstacle(folder, frame, written):
    path = written(folder, [frame()])
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert tmf8820_json.reads(path)
    assert tmf8820_json.stream(path).collect().counts.shape == (1, 9, 16)


def test_the_mesh_is_the_one_that_belongs_to_the_file(folder, frame, written, stl):
    path = written(folder, [frame(dist_to_plane=...)], "cone.json")
    with pytest.raises(Refusal, match=r"expected its mesh cone\*.stl beside it \(there: none\)"):
        tmf8820_json.stream(path)
    near, far = (stl([(-9, -9, z), (9, -9, z), (0, 9, z)]) for z in (1, 2))
    (folder / "table.stl").write_bytes(far)
    assert "table.stl" in tmf8820_json.stream(path).collect().meta["assumed"][1]
    (folder / "other.stl").write_bytes(far)
    with pytest.raises(Refusal, match=r"there: other\.stl, table\.stl"):
        tmf8820_json.stream(path)
    (folder / "cone2.stl").write_bytes(near)
    assert np.nanmax(tmf8820_json.stream(path).collect().depth_m) == pytest.approx(1)
    (folder / "cone3.stl").write_bytes(far)
    with pytest.raises(Refusal, match=r"cone\*.stl"):
        tmf8820_json.stream(path)


def test_what_is_no_such_file_is_not_claimed(folder):
    (folder / "empty").touch()
    (folder / "other.json").write_text('{"hists": 1}')
    for name in ("zone_spec.json", "empty", "absent", ".", "other.json"):
        assert not tmf8820_json.reads(folder / name)


def test_the_importer_is_found_by_what_the_file_is(folder, capture_file, frame, written):
    path = written(folder, [frame(), frame(1)])
    assert files.load(path).counts.shape == (2, 9, 16)
    assert files.maps_of(path).zone_grid == (3, 3)
    scan = capture_file(iterations=range(2)).path
    assert files.load(scan).meta["sensor"] == "TMF8828"
    assert files.maps_of(scan) is None

"""The published TMF8820 files, against geometry worked out another way and against their own light."""

import json
import struct

import numpy as np
import pytest

from recordings.importers import tmf8820_json

OBJECTS = ("tmf8820_objects/tall_block.json", "tmf8820_objects/pyramid.json")


PUBLISHED = ("tmf8820_plane_sweep/distance_data.json", *OBJECTS)


C = 299_792_458


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_file_loses_nothing(shared_data, name):
    path = shared_data / name
    frames = json.loads(path.read_text())
    assert tmf8820_json.reads(path)
    recording = tmf8820_json.stream(path).collect()
    np.testing.assert_array_equal(recording.counts, [one["hists"] for one in frames])
    np.testing.assert_allclose(recording.camera_pose[:, :3], [one["pose"][:3] for one in frames])
    fields = recording.meta["publisher_fields"]
    assert recording.meta["reference_counts"] == [one["reference_hist"] for one in frames]
    for key in frames[0]["distances"][0]:
        assert recording.meta["on_chip"][key] == [one["distances"][0][key] for one in frames]
    for key in set(frames[0]) - {"hists", "pose", "reference_hist", "distances"}:
        assert fields[key] == [one[key] for one in frames]
    # Every interval but the turn to the next row took about as long; the counter wrapped once on the way.
    steps = np.diff(recording.timestamp_s)
    assert np.median(np.abs(steps / np.median(steps) - 1)) < 0.05
    assert recording.timestamp_s[-1] > 860


def test_depth_of_the_published_block_is_that_of_its_two_boxes(shared_data, rays_through):
    """Oracle: the slab method on the block and the table it stands on, corners read off the mesh by eye."""
    recording = tmf8820_json.stream(shared_data / PUBLISHED[1]).collect()
    boxes = [
        ((-0.0108, -0.5676, -0.1587), (0.0400, -0.5168, 0.0696)),
        ((-1.0660, -1.6050, -0.3587), (0.9340, 0.3950, -0.1587)),
    ]
    rays = rays_through(recording)
    for i in range(0, 128, 9):
        pose = recording.camera_pose[i]
        direction = rays @ pose[:3, :3].T
        nearest = np.full(rays.shape[:2], np.inf)
        for low, high in boxes:
            sides = np.sort([(np.array(side) - pose[:3, 3]) / direction for side in (low, high)], axis=0)
            enters, leaves = sides[0].max(axis=-1), sides[1].min(axis=-1)
            nearest = np.where((enters <= leaves) & (enters > 0), np.minimum(nearest, enters), nearest)
        off = np.abs(recording.depth_m[i] - nearest)
        # Corners are read to 0.1 mm, so a ray along an edge may fall on either side of it.
        assert np.quantile(off, 0.99) < 2e-4


def test_depth_and_incidence_of_the_published_pyramid(shared_data, rays_through):
    """Oracle: every ray against every triangle by Cramer's rule."""
    recording = tmf8820_json.stream(shared_data / PUBLISHED[2]).collect()
    content = (shared_data / "tmf8820_objects/pyramid2.stl").read_bytes()[84:]
    corners = np.array([struct.unpack("<12fH", content[at : at + 50])[3:12] for at in range(0, len(content), 50)])
    a, b, c = np.moveaxis(corners.reshape(-1, 3, 3), 1, 0)
    rays = rays_through(recording).reshape(-1, 3)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    for i in (3, 57, 110):
        pose = recording.camera_pose[i]
        direction, origin = rays @ pose[:3, :3].T, pose[:3, 3]
        matrix = np.stack(np.broadcast_arrays(-direction[:, None], b - a, c - a), axis=-1)
        with np.errstate(all="ignore"):
            scale = np.linalg.det(matrix)
            solve = [np.where(np.arange(3) == k, (origin - a)[None, :, :, None], matrix) for k in range(3)]
            depth, u, v = (np.linalg.det(one) / scale for one in solve)
        hit = (depth > 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (np.abs(scale) > 1e-12)
        depth = np.where(hit, depth, np.inf)
        first = depth.argmin(axis=1)
        nearest = depth.min(axis=1)
        cosine = np.abs((normal[first] * direction).sum(axis=1)) / np.linalg.norm(direction, axis=1)
        same = np.abs(recording.depth_m[i].ravel() - nearest) < 1e-4
        assert same.mean() > 0.995
        off = np.abs(recording.incidence_cosine[i].ravel() - cosine)[same]
        assert np.quantile(off, 0.99) < 1e-3


@pytest.mark.parametrize("name", OBJECTS)
def test_the_zone_table_is_turned_as_the_data_are(shared_data, name, rays_through):
    """Of the eight ways to turn and mirror the table, the published one puts each zone's light where it came."""
    path = shared_data / name
    recording, maps = tmf8820_json.stream(path).collect(), tmf8820_json.maps(path)
    length = np.linalg.norm(rays_through(recording), axis=-1)
    near = 1 / (recording.depth_m * length)
    counts = recording.counts.astype(float)
    counts -= np.median(counts[..., :8], axis=-1, keepdims=True)
    bins = np.arange(counts.shape[2]) + 0.5
    arrival = (counts * bins).sum(axis=-1) / counts.sum(axis=-1)
    images = maps.by_zone.reshape(9, *recording.depth_m.shape[1:])
    scores = {}
    for turned in (False, True):
        for flip in [(), (1,), (2,), (1, 2)]:
            image = np.flip(images.swapaxes(1, 2) if turned else images, flip)
            weight = image[None] * (near**2 * recording.incidence_cosine)[:, None]
            expected = (weight / near[:, None]).sum(axis=(2, 3)) / weight.sum(axis=(2, 3))
            across = [one - one.mean(axis=1, keepdims=True) for one in (expected, arrival)]
            scores[turned, flip] = np.corrcoef(*(one.ravel() for one in across))[0, 1]
    published = scores.pop((False, ()))
    assert published > 0.7
    assert published > max(scores.values()) + 0.4


def test_light_of_the_published_sweep_arrives_where_distance_says(shared_data):
    recording = tmf8820_json.stream(shared_data / PUBLISHED[0]).collect()
    distance = np.array(recording.meta["publisher_fields"]["dist_to_plane"])
    assert (recording.depth_m == distance.astype(np.float32)[:, None, None]).all()
    expected = (float(recording.time_zero_s) + 2 * distance / C) / float(recording.bin_width_s)
    far = distance > 0.05
    peak = recording.counts[far].argmax(axis=-1) + 0.5
    off = peak - expected[far, None]
    # The fit is of another unit and its tail; zones differ by half a bin either way.
    assert -1.2 < np.median(off) < 0
    assert np.abs(off).max() < 3

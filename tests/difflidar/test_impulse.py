import numpy as np
import pytest

from difflidar.cli import main
from physics.clock import Clock
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.pulse import two_piece_pulse
from physics.sensor_file import load_sensor
from recordings.files import save
from recordings.maps import ResponseMaps
from recordings.maps_file import save_maps
from recordings.recording import Recording

WIDTH = 1e-10
META = '{"image_size": [12, 12]}'


def run(*arguments):
    with pytest.raises(SystemExit) as ended:
        main([str(a) for a in arguments])
    return ended.value.code


@pytest.fixture
def sweep(tmp_path):
    """A plane swept in steps of a third of a bin, two zones, with its maps."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-2, 14, 6), np.linspace(-2, 14, 6)))
    blobs = np.stack([1e3 * np.exp(-(((x - a) / 4) ** 2) - ((y - 6) / 4) ** 2) for a in (3, 9)])
    maps = ResponseMaps(blobs.reshape(1, 2, -1), x, y, np.arange(x.size).astype(str), META)
    depth = np.broadcast_to((0.3 + 0.005 * np.arange(16))[:, None, None], (16, 12, 12)).astype(np.float32)
    intrinsics = np.array([[40.0, 0, 5.5], [0, 40, 5.5], [0, 0, 1]])
    clock = Clock(WIDTH, 64, np.full(2, 1e-9), two_piece_pulse(9e-11, 2e-10, WIDTH / 16))
    model = ForwardModel(direct_light(depth, intrinsics), footprints(maps, (12, 12)), clock, 1.0)
    expected = model.expected(3e3 / (model.expected() - 1).max())
    counts = np.random.default_rng(1).poisson(expected).astype(np.uint32)
    scene = {"depth_m": depth, "intrinsics": intrinsics, "image_size": np.array([12, 12])}
    save(Recording(counts, [1, 2], WIDTH, 1e-9, np.arange(16.0), **scene), tmp_path / "sweep.npz")
    save_maps(maps, tmp_path / "maps.npz")
    return tmp_path


def test_a_sensor_is_written_with_what_was_estimated(sweep, capsys):
    out, plot = sweep / "sensor.json", sweep / "response.png"
    assert run("impulse", sweep / "sweep.npz", "--calibration", sweep / "maps.npz", "--out", out, "--plot", plot) == 0
    said = capsys.readouterr().out
    assert "16 frames" in said
    assert "delays of the zones" in said
    sensor = load_sensor(out)
    assert sensor.response.probability.sum() == pytest.approx(1)
    assert "16 frames of sweep.npz" in sensor.sources["pulse"]
    mean = sensor.response.time_s @ sensor.response.probability
    true = two_piece_pulse(9e-11, 2e-10, WIDTH / 16)
    assert mean == pytest.approx(true.time_s @ true.probability, abs=0.05 * WIDTH)
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_zone_by_zone_there_is_a_sensor_each(sweep, capsys):
    arguments = ("--calibration", sweep / "maps.npz", "--out", sweep / "s.json", "--per-zone", "--laser-cycles", 1e6)
    assert run("impulse", sweep / "sweep.npz", *arguments) == 0
    assert [load_sensor(sweep / f"s-zone{p}.json").laser_cycles for p in (0, 1)] == [10**6, 10**6]
    assert "zone 1: mean" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ([], "no table of zones beside it, expected --calibration or --zones"),
        (["--zones", "other.json"], "expected a table named zone_spec.json"),
        (["--calibration", "maps.npz", "--every", "0"], "--every: 0 found"),
        (["--calibration", "maps.npz", "--nearest", "9"], "no frame has its median depth in 9 to inf m"),
        (["--calibration", "maps.npz", "--laser-cycles", "10"], "expected fewer than the 10 laser shots"),
    ],
)
def test_one_sentence_says_what_is_wrong(sweep, capsys, monkeypatch, options, sentence):
    monkeypatch.chdir(sweep)
    assert run("impulse", "sweep.npz", "--out", "sensor.json", *options) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1
    assert not (sweep / "sensor.json").exists()

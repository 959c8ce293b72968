"""Distance of the published plane from its histograms, beside the sensor's own distances and a centroid.

Run by `make ranging`. Even frames calibrate, odd frames test; every method has the same freedom. Nothing of the odd
frames' distances is used but to compare.
"""

import os
import sys
from pathlib import Path

import numpy as np
from scipy.constants import speed_of_light

from calibrate.impulse import fit_impulse
from calibrate.impulse.sweep import Sweep
from calibrate.ranging import plane_templates, ranges
from calibrate.ranging.centroid import centroid_bins
from calibrate.ranging.straighten import CURVES, LINES, SHARED, straighten
from recordings.files import load, maps_of

NEAREST_M, FARTHEST_M, ROUNDING_M = 0.030, 0.400, 1e-4
# 4000 k shots is the longest setting of the sensor; `--shots` of another number shows what it does.
SHOTS = 4000 * 1024
TEMPLATES_M = np.arange(0.015, 0.440, 0.0015)


def data() -> Path:
    """The published sweep."""
    root = Path(os.environ.get("DIFFLIDAR_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
    return root / "tmf8820_plane_sweep" / "distance_data.json"


def rms(errors: np.ndarray) -> float:
    """Root mean square, mm."""
    return float(np.sqrt(np.square(errors).mean())) * 1e3


def main(shots: float | None) -> None:
    """Print the tables."""
    path = data()
    if not path.is_file():
        sys.exit(f"the published plane sweep is not at {path}; set DIFFLIDAR_DATA to where the data are")
    recording = load(path)
    truth = np.asarray(recording.depth_m)[:, 0, 0].astype(float)
    kept = np.flatnonzero((truth > NEAREST_M - ROUNDING_M) & (truth < FARTHEST_M + ROUNDING_M))
    even, truth = kept % 2 == 0, truth[kept].round(6)
    sweep = Sweep.of(recording, maps_of(path), shots).part(kept)
    estimate = fit_impulse(sweep.part(np.flatnonzero(even)), per_zone=True)
    found = ranges(sweep.counts, plane_templates(sweep, estimate, TEMPLATES_M), shots)
    reference = np.array(recording.meta["reference_counts"], float)[kept]
    place = centroid_bins(reference, 3, 5, shots)
    late_m = place * estimate.bin_width_s * speed_of_light / 2
    chip = np.array(recording.meta["on_chip"]["depths_1"], float)[kept] * 1e-3
    methods = {
        "on-chip distances": chip,
        "centroid of five bins": centroid_bins(sweep.counts),
        "centroid of 15 bins, pile-up made good": centroid_bins(sweep.counts, 4, 10, shots),
        "likeliest range": found.range_m,
        "likeliest range less the reference pulse": found.range_m - late_m[:, None],
    }
    print(f"{(~even).sum()} odd frames x {chip.shape[1]} zones, {even.sum()} even frames fitted; shots: {shots}")
    print("rms error, mm: every zone and frame; in brackets its mean over the zones of a frame\n")
    print(f"{'':42}" + "".join(f"{name:>38}" for name in (LINES, SHARED, CURVES)))
    last = {}
    for name, readings in methods.items():
        row = ""
        for freedom in (LINES, SHARED, CURVES):
            errors = straighten(readings, truth, even, freedom).metres[~even] - truth[~even, None]
            last[name, freedom] = errors
            row += f"{f'{rms(errors):.3f} ({rms(errors.mean(axis=1)):.3f})':>38}"
        print(f"{name:42}{row}")
    bounds(found, last["likeliest range", CURVES], place[~even], estimate, even)


def bounds(found, errors: np.ndarray, place: np.ndarray, estimate, even: np.ndarray) -> None:
    """Print what the errors are made of: photon noise, what zones share, the laser's own moment."""
    common = errors.mean(axis=1)
    apart = errors - common[:, None]
    steady = np.polynomial.Polynomial.fit(np.arange(len(place)), place, 4)(np.arange(len(place)))
    jitter = (place - steady) * estimate.bin_width_s * speed_of_light / 2
    pairs = np.corrcoef(errors.T)[np.triu_indices(errors.shape[1], 1)]
    print(f"\nphoton noise alone (Cramer-Rao, rms): {rms(found.sigma_m[~even]):.3f} mm")
    print(f"likeliest range, {CURVES}: common to the zones {rms(common):.3f} mm, the rest {rms(apart):.3f} mm")
    print(
        f"correlation of two zones' errors: median {np.median(pairs):.2f}, from {pairs.min():.2f} to {pairs.max():.2f}"
    )
    correlation = np.corrcoef(common, jitter)[0, 1]
    print(
        f"common error with the reference pulse's: correlation {correlation:.2f}, rms of the pulse {rms(jitter):.3f} mm"
    )


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--shots") + 1] if "--shots" in sys.argv else SHOTS
    main(None if given == "none" else float(given))

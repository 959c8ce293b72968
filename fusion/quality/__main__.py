"""`python -m fusion.quality DATA DOCUMENT`: measure; tables go between the document's marks, pictures beside it."""

import sys
from pathlib import Path

import numpy as np

from fusion.quality.judge import judge
from fusion.quality.pictures import draw
from fusion.quality.tables import document
from fusion.quality.trial import record_trial
from recordings.maps_file import load_maps
from recordings.refusal import Refusal

SETS = ("rgbd_open3d", "rgbd_slambook2")
MAPS = "tmf8828_response_maps/spad_calib_3x3_longrange_bins15_35.npz"
# One draw of photons and reflectance says little: results differ by a tenth.
SEEDS = (1, 2, 3, 4)
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"


def main(data: Path, path: Path) -> None:
    """Measure on both sets."""
    before, begin, rest = path.read_text(encoding="utf-8").partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end):
        raise Refusal(f"{path}: has no marks {BEGIN} and {END}, expected both")
    missing = [name for name in (*SETS, MAPS) if not (data / name).exists()]
    if missing:
        raise Refusal(f"{data}: {', '.join(missing)} is not there, expected the published data")
    maps = load_maps(data / MAPS)
    draws = [[record_trial(data / name, maps, np.random.default_rng(seed)) for seed in SEEDS] for name in SETS]
    judged = [[judge(trial) for trial in trials] for trials in draws]
    text = document(draws, [[scores for scores, _ in of_set] for of_set in judged])
    for trials, of_set in zip(draws, judged, strict=True):
        draw(path.with_name(f"quality_{trials[0].name}.png"), trials[0], of_set[0][1])
    path.write_text(f"{before}{BEGIN}\n\n{text}\n{END}{after}", encoding="utf-8")
    print(text)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python -m fusion.quality DATA DOCUMENT")
    try:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
    except Refusal as refusal:
        print(refusal, file=sys.stderr)
        sys.exit(2)

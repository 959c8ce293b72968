"""Every method on every frame of a trial."""

from collections.abc import Iterable

import numpy as np

from fusion.motion import Earlier, Motion
from fusion.prior import Prior
from fusion.quality.alternatives import alternatives
from fusion.quality.metrics import coverage, errors
from fusion.quality.trial import Trial
from fusion.splat import splat
from fusion.unmix import PRIOR, unmix

ALTERNATIVES = ("nearest zone", "datasheet rectangles", "bilinear", "guided filter")
METHODS = ("splat", "unmix, each frame alone", "unmix")


def judge(trial: Trial) -> tuple[dict[str, list[dict[str, float]]], dict[str, list[np.ndarray]]]:
    """Errors of each frame and depth (H, W) of each frame, by method; METHODS have their coverage, too."""
    scores: dict[str, list[dict[str, float]]] = {name: [] for name in (*ALTERNATIVES, *METHODS)}
    images: dict[str, list[np.ndarray]] = {name: [] for name in scores}
    motions = motions_of(trial)
    for i, truth in enumerate(trial.depth_m):
        found = alternatives(trial.sight, trial.range_m[i], trial.rgb[i])
        given = {
            "splat": splat(trial.sight, trial.depths[i]),
            "unmix, each frame alone": unmix(trial.sight, trial.depths[i], trial.rgb[i]),
            "unmix": unmix(trial.sight, trial.depths[i], trial.rgb[i], motion=motions[i]),
        }
        found |= {name: images_of[0] for name, images_of in given.items()}
        for name, depth in found.items():
            scores[name].append(errors(depth, truth, trial.seen))
            images[name].append(depth)
        for name, (depth, sigma, *_) in given.items():
            scores[name][-1]["coverage"] = coverage(depth, sigma, truth, trial.seen)
    return scores, images


def rms_of(trial: Trial, prior: Prior = PRIOR) -> list[float]:
    """Rms error in metres of unmixing in each frame."""
    frames = zip(trial.depths, trial.rgb, motions_of(trial), trial.depth_m, strict=True)
    return [errors(unmix(trial.sight, z, c, motion=m, prior=prior)[0], t, trial.seen)["rms"] for z, c, m, t in frames]


def motions_of(trial: Trial) -> list[Motion | None]:
    """What a robot that takes the frames in their order has of earlier images at each."""
    earlier, motions = Earlier(trial.sight), []
    for depths, rgb, pose in zip(trial.depths, trial.rgb, trial.poses, strict=True):
        motions.append(earlier.motion(pose, depths.typical_m))
        earlier.add(rgb, pose, depths.typical_m)
    return motions


def best_of(trial: Trial, priors: Iterable[Prior]) -> Prior:
    """The prior with the least mean rms error on this trial."""
    return min(priors, key=lambda prior: float(np.mean(rms_of(trial, prior))))

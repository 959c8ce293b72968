"""`parallax`: the LiDAR is not where the camera is, so that footprints move with depth."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.emitter_profile import relit
from physics.footprint import Footprints
from physics.light import Light, Return
from physics.rendering import Rendering

# Part of its range that is left at least of what is beside the camera.
LEAST = 0.1


class Parallax(Effect):
    """A zone looks along rays from the LiDAR, at b = (x, y, 0) in the camera's frame, not from the camera.

    The scan saw the ray to X − b where it met the plane at z_cal: at b + (X − b)·z_cal/z, z the depth of X, hence
    beside the image u of X by K·b·(1/z_cal − 1/z). A pixel is weighed with the map there, that is, footprints move by
    f·b·(1/z − 1/z_cal), the disparity of a stereo pair (Hartley & Zisserman, Multiple View Geometry, 2nd ed., §9 and
    §11.12, for cameras with parallel axes) less its value in the scan. Where the depth of the scan is not known it is
    taken to have been far away. z is that of the surface lit directly, for every way light takes from a pixel.
    Surfaces that the LiDAR sees and the camera does not, or the other way round, are not followed.

    Light's way is from the LiDAR, too, if nobody has taken that into account: `ranges` 1 says so, and to a point that
    much nearer to b it is |X - b|, with strength by its inverse square. Whoever gives a zone one depth moves its map as
    a whole: `whole` is the part of the move that goes with the mean of 1/z, weighted as zones see it, frame by frame.
    Whoever moves the weights of pixels, not maps, has what lies between these: `by_pixels` 1, which differs where maps
    are cut.
    It may be the emitter alone that is beside the camera: `emitter` 1 says that its profile moves, as footprints would,
    and zones see where they saw (`relit`).
    """

    id = "parallax"
    acts_on = "optics"
    sentence = "LiDAR and camera are side by side: footprints move in the image, more for near surfaces."
    look_alikes = (
        LookAlike("footprint_shift", "Step the target in range: parallax goes with 1 / depth, a shift stays."),
        LookAlike("time_lag", "Hold sensor and scene still: parallax stays, a lag goes."),
        LookAlike("range_falloff", "Face a wide, even wall: falloff shows, parallax moves nothing that differs."),
    )
    forms = (("x", "y"), ("x", "y", "ranges"), ("x", "y", "whole"), ("x", "y", "by_pixels"), ("x", "y", "emitter"))
    parameters = (
        # It begins at a centimetre: chips and lenses of a shared mount are a few apart, known to within one. Where they
        # have no mount in common they may be half a metre off.
        *(
            Parameter(
                axis,
                unit="m",
                low=-0.5,
                high=0.5,
                start=0.01,
                vanishes_at=0.0,
                sentence=f"How far the LiDAR is from the camera, towards the image's {side}.",
            )
            for axis, side in (("x", "right"), ("y", "bottom"))
        ),
        Parameter(
            "ranges", "1", 0.0, 1.0, 0.0, "1 where ranges are the LiDAR's own, 0 where the camera's.", tries=(1.0,)
        ),
        Parameter("by_pixels", "1", 0.0, 1.0, 0.0, "1 where weights of pixels move, 0 where maps do.", tries=(1.0,)),
        Parameter(
            "emitter", "1", 0.0, 1.0, 0.0, "1 where the emitter's profile moves, 0 where zones do.", tries=(1.0,)
        ),
        Parameter(
            "whole", "1", 0.0, 1.0, 0.0, "1 where maps move by their mean, 0 where each pixel does.", tries=(1.0,)
        ),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """What surfaces send back directly, by the way from the LiDAR, lit as its emitter lights them."""
        light = rendering.light
        if not (values["x"] or values["y"]) or not (values["ranges"] or values["emitter"]):
            return light
        direct, *others = light.returns
        if values["emitter"]:
            brighter = relit(rendering.footprints, *self._moves(values, rendering))
            known = np.isfinite(direct.range_m)
            strength = np.where(known, direct.strength * (1 + values["emitter"] * (brighter - 1)), direct.strength)
            direct = replace(direct, strength=strength.astype(np.float32))
        if values["ranges"]:
            direct = self._from_lidar(direct, light.rays, values)
        return replace(light, returns=(direct, *others))

    def _from_lidar(self, direct: Return, rays: np.ndarray, values: Values) -> Return:
        """What comes back by the way from the LiDAR."""
        known = np.isfinite(direct.range_m) & (direct.range_m > 0)
        ranges = np.where(known, direct.range_m, 1).astype(float)
        rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
        beside = values["ranges"] * (rays[..., :2] @ np.array([values["x"], values["y"]]))
        square = values["ranges"] ** 2 * (values["x"] ** 2 + values["y"] ** 2)
        # |X - b|² = X² - 2 X·b + b²; nothing is nearer than a part of what the camera sees.
        nearer = np.sqrt(np.maximum(1 - 2 * beside / ranges + square / ranges**2, LEAST**2))
        moved = np.where(known, ranges * nearer, direct.range_m).astype(np.float32)
        strength = np.where(known, direct.strength / nearer**2, direct.strength).astype(np.float32)
        return replace(direct, range_m=moved, strength=strength)

    def moves_maps(self, values: Values) -> tuple[bool, bool]:
        """As things are nearer or farther in each frame."""
        return False, values["emitter"] < 1

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints, moved in every frame and pixel by what its depth says."""
        where, height_width = rendering.footprints, rendering.light.range_m.shape[1:]
        if values["emitter"] == 1:
            return where
        steps = (full / size for full, size in zip(where.field.full_size, height_width[::-1], strict=True))
        right, down = (
            (1 - values["emitter"]) * step * by for step, by in zip(steps, self._moves(values, rendering), strict=True)
        )
        return where.moved(right, down, values["by_pixels"])

    def _moves(self, values: Values, rendering: Rendering) -> list[np.ndarray]:
        """Pixels to the right and down, (F, H, W) each, by which what is seen from the LiDAR moves."""
        light, where = rendering.light, rendering.footprints
        known = np.isfinite(light.range_m) & (light.range_m > 0)
        ranges = np.where(known, light.range_m, 1).astype(float)
        nearer = np.linalg.norm(light.rays, axis=-1) / ranges - 1 / where.calibration_range_m
        # Pixels of unknown depth send no light.
        nearer = np.where(known, nearer, 0)
        if values["whole"]:
            weights = known * where.before_moving.weights.sum(axis=-3)
            mean = (weights * nearer).sum(axis=(1, 2)) / np.maximum(weights.sum(axis=(1, 2)), 1e-12)
            nearer = nearer + values["whole"] * (mean[:, None, None] - nearer)
        return [by * nearer for by in light.intrinsics[:2, :2] @ np.array([values["x"], values["y"]])]


effect = Parallax()

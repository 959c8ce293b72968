"""What surfaces are made of, as near-infrared light of one direction meets it."""

from dataclasses import dataclass

import numpy as np

from recordings.refusal import Refusal


@dataclass(frozen=True)
class Material:
    """reflectance: part of the light that returns, 0 to 1. specular: part of that in a lobe about the mirror direction.

    shininess: exponent of the lobe; 10 is satin, 1000 is polished. colour: to the eye, (3,) sRGB 0 to 1; None where
    nobody said: then no camera sees it, or it is grey beside others that have one.
    """

    reflectance: float = 1.0
    specular: float = 0.0
    shininess: float = 50.0
    colour: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        for name in ("reflectance", "specular"):
            if not 0 <= getattr(self, name) <= 1:
                raise Refusal(f"{name} is {getattr(self, name)}, expected 0 to 1")
        if not (np.isfinite(self.shininess) and self.shininess >= 0):
            raise Refusal(f"shininess is {self.shininess}, expected a finite number of 0 or more")
        if self.colour is not None and not (len(self.colour) == 3 and all(0 <= part <= 1 for part in self.colour)):
            raise Refusal(f"colour is {list(self.colour)}, expected red, green and blue from 0 to 1")

    def gloss(self, cosine: np.ndarray) -> np.ndarray:
        """How many times as bright as a matt surface, seen from where the light comes, at incidence of this cosine.

        The normalised Blinn-Phong lobe, ρ/π·((1 - s) + s·(m + 8)/8·cosᵐθ), whose half vector is here the ray itself
        (Akenine-Möller et al., Real-Time Rendering).
        """
        lobe = (self.shininess + 8) / 8 * np.clip(cosine, 0, 1) ** self.shininess
        return 1 - self.specular + self.specular * lobe


def reflectance_of_colour(rgb: np.ndarray) -> np.ndarray:
    """(H, W) float32 reflectance as a grey value: the mean of the linear sRGB channels (IEC 61966-2-1), at least 0.02.

    A stand-in where nothing is known of the near infrared: dyes that are dark to the eye are often bright there.
    """
    coded = np.arange(256) / 255
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return np.maximum(linear[rgb].mean(axis=-1), np.float32(0.02))

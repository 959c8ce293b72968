"""What nobody saw of light that bounces between surfaces: hidden sides, gleams, and what stands between them."""

from dataclasses import replace

from physics.arrivals import arrivals
from physics.bounce import bounces
from physics.owning import Unseen
from physics.rendering import Rendering
from physics.told_between import together


def hidden(rendering: Rendering, between: float, aimed: float, rough: float) -> Unseen:
    """How far counts of `physics.bounce` are off: by as much as they are, of which counts tell the part.

    The image shows one side of each surface, and matt patches stand for it. What is left out goes by the same ways,
    so that it is in proportion, and off alike where what is in it is. between, aimed, rough: as of `multipath`.
    """
    scene = rendering.light, rendering.footprints, rendering.clock
    added = between * bounces(*scene, aimed, rough)
    counts = rendering.gain * replace(arrivals(*scene), light=added).binned()
    return Unseen(counts**2, together(counts))

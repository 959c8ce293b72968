"""`footprint_blur`: zones see a wider, or a narrower, piece of the scene than their maps say."""

from physics.blurring import Blur
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class FootprintBlur(Effect):
    """Maps are blurred, in the full-size image, by a kernel of the variance given along each axis.

    The kernel is the discrete Gaussian, what diffusion on the pixels' lattice gives (Lindeberg, "Scale-space for
    discrete signals", IEEE PAMI 12(3), 1990, 234-254): nowhere negative, of exactly this variance, and two blurs are
    one of the sum of theirs, which a Gaussian read at pixels is not where it is narrow. No light passes the edge of
    the image: what would is reflected, and each zone keeps the sum of its map; or it is `lost`, as where zones see
    what no image shows.

    Scans with a patch of finite size give maps that are wider than the zones: by a twelfth of its side squared. Then
    the variance is negative, and maps are sharpened, w + amount · (w − blurred w), not below 0, and brought back to
    their sum, or to part of the way. With amount 1, to first order, their variance falls by as much as is said as long
    as nothing reaches 0. Where patch or motion are longer one way, the variance is exp(taller) times as large down
    the image, and as much smaller along it.

    Micro-optics that scatter add a `haze`: so much of each map is blurred by the wide variance, the rest is as it was;
    what of it would pass the edge of the image is reflected or lost likewise.
    A scan that counts bright places too few, as pile-up does, gives maps that fall off more slowly than zones, about as
    a power of them: zones are `steeper`, maps to the power of 1 + steeper, with the sum they had.

    Where maps were read at the camera's pixels and then blurred, the kernel is `coarse`: diffusion is on the lattice of
    these, and what maps hold between them, as noise of a fine scan, takes no part.
    """

    id = "footprint_blur"
    acts_on = "optics"
    grows = True
    order = 1  # In any order they are the same; after what moves maps, what was read where they are need not be anew.
    sentence = "The maps of all zones are blurred, or sharper than was assumed."
    look_alikes = (
        LookAlike("stray_light", "Show one zone alone a target: blur is in its neighbours, stray light in all zones."),
        LookAlike(
            "impulse_width",
            "Face a plane squarely: ranges that mix under a blur do not there, a wider pulse stays wide.",
        ),
        LookAlike("footprint_shift", "Let an edge enter the field from either side: a blur is early on both."),
    )
    forms = (
        ("variance",),
        ("variance", "coarse"),
        ("variance", "flat"),
        ("variance", "taller"),
        ("variance", "amount", "kept"),
        ("haze", "wide"),
        ("steeper",),
        ("variance", "taller", "amount", "kept"),
        ("haze", "wide", "lost"),
        ("variance", "lost"),
        ("variance", "taller", "lost"),
        ("variance", "coarse", "lost"),
        ("variance", "taller", "coarse", "lost"),
    )
    richer = forms[-6:]
    parameters = (
        # A choice: a standard deviation of 6 px, about a patch of 20.
        Parameter(
            "variance",
            unit="px²",
            low=-2500.0,
            high=10000.0,
            start=36.0,
            # What sharpens is no mirror image of what blurs: it cannot go below 0. A patch of 85 px, taken off, as less
            # hardly changes maps that are read off a coarse scan; and one of 42, as more leads astray on a fine one.
            tries=(36.0, -150.0, -600.0),
            vanishes_at=0.0,
            sentence="Square of the blur's standard deviation in pixels of the full-size image; negative sharpens.",
        ),
        Parameter(
            "taller",
            unit="1",
            low=-3.0,
            high=3.0,
            start=0.0,
            # Longer one way from the first: what is blurred along one axis hardly shows as a blur along both. A blur
            # that was found alike along both and is let be longer begins where it was, at the last.
            tries=(-2.0, 2.0, 0.0),
            sentence="Logarithm of how many times the variance there is down the image, and over how many along it.",
        ),
        Parameter(
            "flat",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.0,
            tries=(1.0,),
            sentence="Part of the kernel that is a round patch, even to its edge; the rest is a Gaussian.",
        ),
        Parameter(
            "amount",
            unit="1",
            low=0.01,
            high=5.0,
            start=1.0,
            sentence="How often what a blur takes away is added, where maps are sharpened.",
        ),
        Parameter(
            "kept",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            sentence="1 where sharpened maps have the sum they had, 0 where what would be below 0 is cut off.",
        ),
        Parameter("haze", "1", 0.0, 1.0, 0.05, "Part of each map that is blurred widely.", vanishes_at=0.0),
        # A standard deviation of 50 px, a third of a zone or so.
        Parameter("wide", "px²", 100.0, 40000.0, 2500.0, "Square of that blur's standard deviation."),
        Parameter("steeper", "1", -0.8, 3.0, 0.05, "Power of the maps that zones are, less 1.", vanishes_at=0.0),
        Parameter("coarse", "1", 0.0, 1.0, 0.0, "Part of the kernel that steps by the camera's pixels.", tries=(1.0,)),
        Parameter(
            "lost", "1", 0.0, 1.0, 0.0, "Part of what passes the image's edge that does not return.", tries=(1.0,)
        ),
    )

    def redraws_maps(self, values: Values) -> bool:
        """Wherever it is there."""
        return bool(values["variance"] or values["haze"] or values["steeper"])

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints of maps that are blurred or sharpened before they are moved."""
        if not self.redraws_maps(values):
            return rendering.footprints
        where = rendering.footprints
        wide, high = where.field.full_size
        rows, columns = where.x_px.shape[-2:]
        said = (values[parameter.name] for parameter in self.parameters)
        return where.redrawn(Blur(*said, steps_px=(high / rows, wide / columns)))


effect = FootprintBlur()

"""The departures that two calibrations are examined for. Adding one is adding an entry."""

from mismatch.calibrations import acting
from mismatch.calibrations.departure import Departure, LookAlike, Shape, Strength

SIDE = "log factor at the side"
REVERSED = "Scan the rows the other way: a lag turns round, a shift stays."
TURNED = "Scan the columns instead of the rows: a drift turns with it."
GREY = "Scan with a grey patch: losses of the bright go, blur stays."
BLOCKED = "Block the patch's light: stray light goes, an offset stays."
NEARER = "Scan again half a bin farther away: the rings move, falloff does not."
RINGS = "The largest bin is more or less, depending on where in its bin the pulse falls: rings of equal range."
STRAY = "In one of the two, every zone also receives a share of what all receive."
LOST = "The two lose counts differently where it is bright: shots in which a detector was already taken."
BRIGHTEST = "log factor at the brightest"
# Fewer bins make less than a ring over the field: a falloff, which has its own name.
RINGED = Shape("bins", "bins", 0.5, 4.0, 48.0)


def catalogue() -> tuple[Departure, ...]:
    """All departures in all forms."""
    return (*_moved(), *_shared(), *_counted(), *_factors())


def _moved() -> tuple[Departure, ...]:
    px = (Strength("x", "px", 6.0), Strength("y", "px", 6.0))
    turned = (*px, Strength("scale", "px at the side", 6.0), Strength("turn", "px at the side", 6.0))
    lag = LookAlike("time_lag", REVERSED)
    return (
        Departure(
            "footprint_shift", "", 10, "Patch or camera were displaced between the two scans.", px, acting.shift,
            look_alikes=(lag,),
        ),
        Departure(
            "footprint_shift", "turned", 10, "Patch or camera were displaced, turned or moved nearer between scans.",
            turned, acting.turn, look_alikes=(lag,),
        ),
        Departure(
            "time_lag", "", 10, "Image and histogram of one of the scans belong to different captures.",
            (Strength("captures", "captures", 0.5),), acting.lag, look_alikes=(LookAlike("footprint_shift", REVERSED),),
        ),
        Departure(
            "footprint_blur", "", 11, "One scan is blurred more: its patch was larger, or its image unsharp.",
            (Strength("variance", "px²", 60.0),), acting.blur, look_alikes=(LookAlike("pile_up", GREY),),
        ),
    )  # fmt: skip


def _shared() -> tuple[Departure, ...]:
    centre = (Shape("centre_x", "px", 20.0), Shape("centre_y", "px", 20.0))
    pedestal = LookAlike("ambient_pedestal", BLOCKED)
    return (
        Departure(
            "stray_light", "", 20, STRAY, (Strength("share", "1", 0.02),), acting.stray, look_alikes=(pedestal,)
        ),
        Departure(
            "stray_light", "per zone", 20, STRAY, (Strength("share", "1", 0.02, True),), acting.stray,
            look_alikes=(pedestal,),
        ),
        Departure(
            "stray_light", "mirrored", 20, "In one of the two, light is mirrored through a point: a ghost.",
            (Strength("share", "1", 0.03),), acting.ghost, centre, acting.centres,
        ),
        Departure(
            "ambient_pedestal", "", 60, "One of the two keeps an offset that the other does not have.",
            (Strength("offset", "1 of the peak", 0.01, True),), acting.pedestal,
            look_alikes=(LookAlike("stray_light", BLOCKED),),
        ),
    )  # fmt: skip


def _counted() -> tuple[Departure, ...]:
    look = (LookAlike("footprint_blur", GREY),)
    both = (Strength("own", BRIGHTEST, 0.7), Strength("all", BRIGHTEST, 0.7))
    more = tuple(Strength(name, BRIGHTEST, 0.7) for name in ("bent", "part"))
    each = (Strength("own", BRIGHTEST, 0.7, True), both[1])
    return (
        Departure("pile_up", "", 40, LOST, both, acting.pile_up, look_alikes=look),
        Departure("pile_up", "crowded", 40, LOST, (*both, *more), acting.crowding, look_alikes=look),
        Departure("pile_up", "per zone", 40, LOST, each, acting.pile_up, look_alikes=look),
    )


def _factors() -> tuple[Departure, ...]:
    smooth = tuple(Strength(name, SIDE, 0.5) for name in ("across", "down", "outward"))
    # Linear in time only: in a scan of rows, time is one axis of the image, and what bends is a falloff just as well.
    drifts = (Strength("linear", "log factor over the scan", 0.3),)
    rings = (Shape("foot_x", "px", 20.0), Shape("foot_y", "px", 20.0), RINGED)
    waves = [tuple(Strength(name, "log factor", 0.2, each) for name in ("cos", "sin")) for each in (False, True)]
    told = "the rings' spacing gives the width of the bin that causes them, hence the calibration"
    falloff = LookAlike("range_falloff", NEARER)
    return (
        Departure(
            "zone_gain", "", 50, "The relative sensitivities of the zones differ between the two.",
            (Strength("log_gain", "log factor", 0.5, True),), acting.gain,
        ),
        Departure(
            "range_falloff", "", 51, "The ratio of the two changes smoothly over the field, as a loss with range does.",
            smooth, acting.falloff,
            look_alikes=(
                LookAlike("window_clipping", "Widen the window: what it clipped comes back."),
                LookAlike("gain_drift", TURNED),
            ),
        ),
        Departure(
            "gain_drift", "", 51, "Laser power or sensitivity changed in the course of one of the scans.", drifts,
            acting.drift, look_alikes=(LookAlike("range_falloff", TURNED),),
        ),
        Departure(
            "bin_phase", "", 52, RINGS, waves[0], acting.phase, rings, acting.feet, told, (falloff,)
        ),
        Departure(
            "bin_phase", "per zone", 52, RINGS, waves[1], acting.phase, rings, acting.feet, told, (falloff,)
        ),
    )  # fmt: skip

"""What a parameter may have values of, one for each."""

from physics.patchwork import PATCHES


def sizes_along(zones: int, bins: int) -> dict[str, int]:
    """How many there are of what may have its own value of a parameter: as many edges as bins, one before each."""
    each = {"bin": bins, "edge": bins}
    return {"zone": zones, "patch": PATCHES} | each | {f"zone {axis}": zones * many for axis, many in each.items()}

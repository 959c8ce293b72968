"""A verdict in words, and numbers as people write them."""

import math
import re
from collections.abc import Iterable

from mismatch.verdict import Estimate, Verdict

PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
PREFIXED = ("s", "m", "Hz")
SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def plain_name(effect_id: str) -> str:
    """An effect's id as words."""
    return effect_id.replace("_", " ")


def number(value: float, digits: int = 3) -> str:
    """A number to so many digits, powers of ten where it is very large or small, a dash where it is none."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    if "e" not in text:
        return text.replace("-", "−")
    mantissa, exponent = text.split("e")
    return f"{mantissa}·10".replace("-", "−") + str(int(exponent)).translate(SUPERSCRIPT)


def quantity(value: float, sigma: float | None, unit: str) -> str:
    """value ± sigma in the unit, with a prefix where that makes it readable; digits as far as sigma allows."""
    size = max(abs(value), sigma or 0.0)
    power, prefix = 0, ""
    if unit in PREFIXED and 0 < size < math.inf:
        power = min(max(3 * math.floor(math.log10(size) / 3), -15), 9)
        prefix = PREFIXES[power]
    shown = f" {prefix}{unit}" if unit != "1" else ""
    value = value / 10**power
    if not sigma or not math.isfinite(sigma) or not math.isfinite(value):
        return number(value) + shown
    sigma = sigma / 10**power
    if sigma == 0:  # Too small for the prefix.
        return number(value) + shown
    decimals = 1 - math.floor(math.log10(sigma))
    if decimals > 6 or max(abs(value), sigma) >= 1e6:
        return f"{number(value)} ± {number(sigma, 2)}{shown}"
    decimals = max(decimals, 0)
    return f"{value:.{decimals}f} ± {sigma:.{decimals}f}{shown}".replace("-", "−")


def chance(p_value: float) -> str:
    """A p-value, from one in ten thousand on as a power of ten."""
    if p_value <= 0:
        return "below 10⁻³⁰⁰"
    return number(p_value, 2) if p_value >= 1e-4 else "10" + str(math.floor(math.log10(p_value))).translate(SUPERSCRIPT)


def grouped(parameters: Iterable[Estimate]) -> list[tuple[str, list[tuple[str, Estimate]]]]:
    """Parameters by name; of each the (zone's or bin's index, estimate), the index empty where there is one for all."""
    found: dict[str, list[tuple[str, Estimate]]] = {}
    for one in parameters:
        name, index = re.fullmatch(r"(.*?)(?:\[(\d+)\])?", one.name).groups()
        found.setdefault(name, []).append((index or "", one))
    return list(found.items())


def headline(verdict: Verdict) -> str:
    """The verdict in one line."""
    return {
        "agrees": "Recording and simulation agree",
        "explained": "The mismatch is explained",
        "unknown": "A mismatch stands that no known effect explains",
    }[verdict.verdict]


def found_in_words(verdict: Verdict) -> str:
    """What was found, in one plain paragraph."""
    fit = verdict.heldout
    noise = f"the floor that the data's own noise sets is {fit.floor:.3f}"
    if verdict.verdict == "agrees":
        return (
            "Nothing in the recording differs from its simulation by more than photon noise makes it. In frames that "
            f"took no part in the fit the misfit (Poisson deviance per cell) is {fit.nominal:.3f}; {noise}."
        )
    names = [plain_name(effect.id) for effect in verdict.effects]
    told = " ".join(effect.sentence for effect in verdict.effects)
    if not names:
        return (
            "The recording differs from its simulation, and no effect in the library explains any of it. In frames "
            f"that took no part in the fit the misfit (Poisson deviance per cell) is {fit.nominal:.3f}; {noise}."
            + _where(verdict)
        )
    closed = "" if verdict.gap_closed is None else f" That closes {100 * verdict.gap_closed:.0f} % of the gap."
    falls = (
        f"In frames that took no part in choosing or fitting, the misfit (Poisson deviance per cell) falls from "
        f"{fit.nominal:.3f} to {fit.explained:.3f}; {noise}.{closed}"
    )
    several = f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
    if verdict.verdict == "explained":
        return f"The recording differs from its simulation because of {several}. {told} {falls}"
    return (
        f"The recording differs from its simulation. Part of it goes with {several}, the rest with no effect in the "
        f"library, so these names may be wrong, too. {told} {falls}" + _where(verdict)
    )


def _where(verdict: Verdict) -> str:
    """The place of most of what is left."""
    if not verdict.unexplained:
        return ""
    return f" Most of what is left sits in {verdict.unexplained[0].sentence}."

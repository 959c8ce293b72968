"""`bin_nonlinearity`: the converter's bins are not equally wide."""

import numpy as np
from scipy.stats import f_oneway

from physics.bin_waves import telling_period
from physics.displaced_edges import counts_moved
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering

# Bins from one tap of a delay line, or tick of the clock it divides, to where its pattern begins again.
CYCLE = 8
# Part of the most by which a bin is wider whose light tells; chance of widths that would be called a zone's.
TOLD, CHANCE = 0.01, 1e-3
TAPS = tuple(f"tap_{k}" for k in range(1, CYCLE))


class BinNonlinearity(Effect):
    """The edge before bin t of T is displaced by edge_t + alternation · (-1)^t + slope · T/π · sin(π·t/T) +
    wave_sin · sin(2π·t/period) + wave_cos · (cos(2π·t/period) - 1) + Σ_{s<t} (tap_{s mod 8} - mean tap) bins.

    Bins of unequal width are displaced edges: a converter's delays add up, so that an edge lies where the widths before
    it end. Odd and even bins differ where a converter counts both flanks of a clock of unequal halves; the slow part
    bends the whole scale; a wave is that of a converter that interpolates between the ticks of a slower clock, and
    begins with nothing at the first edge, as widths that add up do; taps are a pattern that comes again every eighth
    bin, hence every fourth or second too. Signal between the displaced edges is read off its cumulative, which the
    arrivals give step by step of the pulse; what other effects and the background add is known by bin only, and is
    taken to be monotone cubic between the true edges. Every count is kept, for the outermost edges stay, and none turns
    negative; an edge that would lie before the one before it lies there.

    A bin whose place is kept by other means, or whose gate opens for longer or shorter, is wider or narrower where it
    is: it holds its own counts times its width, the distance of its edges. `moved` is the part of counts that goes with
    displaced edges, the rest stays in place. `width` is by how much a bin is wider in place beside that.

    Zones that have a converter each have a pattern each: `zone_edge` and `zone_width` are numbers of every zone's bins,
    zone by zone, beside those that all share.
    """

    id = "bin_nonlinearity"
    acts_on = "detector"
    sentence = "Some bins are wider and some narrower, so that they hold more and fewer counts, pulse or not."
    look_alikes = (
        LookAlike(
            "bin_width_error", "Look at a flat pedestal: unequal bins print their pattern on it, a clock does not."
        ),
        LookAlike("bin_phase", "Cover the emitter and look at the ambient pedestal: only unequal bins show there."),
    )
    forms = (
        ("edge",),
        ("width",),
        ("alternation", "slope", "moved"),
        ("wave_sin", "wave_cos", "period", "moved"),
        (*TAPS, "moved"),
        ("zone_edge",),
        ("zone_width",),
    )
    parameters = (
        Parameter(
            "edge",
            unit="bins",
            low=-4.0,
            high=4.0,
            start=0.05,
            vanishes_at=0.0,
            axis="edge",
            sentence="How much later the edge before a bin is; nothing for bin 0, where the window begins.",
        ),
        Parameter(
            "alternation",
            unit="bins",
            low=-0.4,
            high=0.4,
            start=0.05,
            vanishes_at=0.0,
            sentence="How much later every other edge between bins is, the rest earlier.",
        ),
        Parameter(
            "slope", "1", -0.15, 0.15, 1e-3, "How much wider the first bin is, the last narrower.", vanishes_at=0.0
        ),
        Parameter("wave_sin", "bins", -4.0, 4.0, 0.05, "Sine of a displacement that comes and goes.", vanishes_at=0.0),
        Parameter("wave_cos", "bins", -4.0, 4.0, 0.05, "Cosine of it, less 1.", vanishes_at=0.0),
        Parameter("period", "bins", 2.5, 200.0, 16.0, "Bins from one wave to the next."),
        Parameter(
            "width",
            unit="1",
            low=-0.9,
            high=2.0,
            start=0.05,
            vanishes_at=0.0,
            axis="bin",
            sentence="By what part a bin is wider in place, whose neighbours do not move.",
        ),
        Parameter(
            "zone_edge",
            unit="bins",
            low=-4.0,
            high=4.0,
            start=0.05,
            vanishes_at=0.0,
            axis="zone edge",
            sentence="How much later the edge before a bin of one zone is; nothing for bin 0.",
        ),
        Parameter(
            "zone_width",
            unit="1",
            low=-0.9,
            high=2.0,
            start=0.05,
            vanishes_at=0.0,
            axis="zone bin",
            sentence="By what part a bin of one zone is wider in place.",
        ),
        *(
            Parameter(
                tap,
                unit="bins",
                low=-0.5,
                high=0.5,
                start=0.05,
                vanishes_at=0.0,
                sentence=f"By how much bins {k}, {k + CYCLE} and so on are wider than bins 0, {CYCLE} and so on.",
            )
            for k, tap in enumerate(TAPS, start=1)
        ),
        Parameter(
            "moved",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            tries=(1.0, 0.0),
            sentence="Part of the counts that goes with edges that are displaced; 0 where bins are wider in place.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts between displaced edges, and of bins that are wider in place."""
        counts, late = rendering.expected, _displaced(values, rendering.expected.shape)
        if late.any():
            part = values["moved"]
            moved = part * counts_moved(counts, late, rendering) if part > 0 else 0.0
            counts = moved + (1 - part) * np.maximum(1 + np.diff(late), 0) * counts
        wider = values["width"] + _of_zones(values["zone_width"], counts.shape)
        return counts * (1 + wider) if np.any(wider) else counts

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """Whether it is no converter's pattern.

        A wave that does not come again within the window bends the whole scale; and where all bins of a zone are wider
        than another's, that zone is brighter.
        """
        if np.ndim(values["zone_width"]) and np.any(values["zone_width"]):
            return _as_zones(np.reshape(values["zone_width"], (-1, rendering.clock.bins)))
        return bool(values["wave_sin"] or values["wave_cos"]) and values["period"] > rendering.clock.bins / 2

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The wave that shows most, of bins that move and of those that stay."""
        period = self.parameter("period")
        return [
            {"period": telling_period(excess, expected, bool(moved), period.low, period.high), "moved": moved}
            for moved in self.parameter("moved").tries
        ]


def _displaced(values: Values, shape: tuple[int, ...]) -> np.ndarray:
    """(T + 1,) how much later each edge is, bins; (P, T + 1) where each zone has its own."""
    bins = shape[-1]
    even = np.arange(bins + 1.0)
    late = values["slope"] * bins / np.pi * np.sin(np.pi * even / bins) + values["alternation"] * (-1) ** even
    angle = 2 * np.pi * even / values["period"]
    late += values["wave_sin"] * np.sin(angle) + values["wave_cos"] * (np.cos(angle) - 1)
    taps = np.array([0.0, *(values[tap] for tap in TAPS)])
    late[1:] += np.cumsum(np.resize(taps - taps.mean(), bins))
    late[:-1] += values["edge"]
    own = _of_zones(values["zone_edge"], shape)
    if not np.any(own):
        return late
    late = np.broadcast_to(late, (*np.shape(own)[:-1], bins + 1)).copy()
    late[..., :-1] += own
    return late


def _of_zones(numbers: float | np.ndarray, shape: tuple[int, ...]) -> float | np.ndarray:
    """(P, T) numbers of every zone's bins, from (P·T,); one number as it is."""
    return np.reshape(numbers, shape[-2:]) if np.ndim(numbers) else numbers


def _as_zones(wider: np.ndarray) -> bool:
    """Whether widths (P, T) differ from zone to zone by more than from bin to bin, by analysis of variance.

    What no light reached tells nothing, and has none.
    """
    least = TOLD * np.abs(wider).max()
    # Of widths that are all the same there is no variance to analyse.
    groups = [told for zone in wider if len(told := zone[np.abs(zone) > least]) > 1 and np.ptp(told) > 0]
    return len(groups) > 1 and bool(f_oneway(*groups).pvalue < CHANCE)


effect = BinNonlinearity()

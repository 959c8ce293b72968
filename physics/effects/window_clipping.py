"""`window_clipping`: counts are looked for in a window, which cuts off part of a pulse."""

import numpy as np
from scipy.special import expit

from physics.about_highest import inside, told_window
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.rendering import Rendering
from physics.window_edges import emptied, share_lost, summed_window

# A choice: of what lies outside a window most is lost. With less it would stand for whatever dims the far or the near.
LEAST_LOST = 0.3
# What no division may meet, and bins that an edge takes which takes next to none.
NOTHING, SLIGHT = 1e-12, 0.5
EDGES = ("early", "late")


class WindowClipping(Effect):
    """Counts before and after the window are not there; of a bin that its edge divides, the part inside is.

    Where the edge is soft the part that is kept falls evenly over `softness` bins outwards from the edge: of bin t it
    is 1 - (early - t) / softness, within 0 and 1. Where it is rounded, as where a gate takes time to open, the part
    `rounded` of it goes by the logistic curve that is as steep where it falls to half, in the same place (an error
    function is within 1 % of one). Of what is not kept the share `lost` is lost, and of the background, which may be
    set aside before and put back, the share lost · background. Each zone may have a window of its own.

    A step that takes for the response of a zone what falls in such a window, scales all of its signal alike by the part
    that does (`summed` 1).

    A later step that looks for one pulse keeps what is `before` to `after` bins from the highest of each histogram, and
    of all else loses the share `aside`.
    """

    id = "window_clipping"
    acts_on = "estimator"
    sentence = "A later step keeps only the counts inside a window of bins and cuts off what reaches beyond it."
    look_alikes = (
        LookAlike(
            "range_falloff", "Step the target in range: falloff scales the pulse, a window cuts it in the same bins."
        ),
        LookAlike("range_aliasing", "Step the target in range: an aliased pulse comes back, one that is cut does not."),
    )
    forms = (
        ("early",),
        ("late",),
        ("early", "late"),
        ("early", "softness", "lost", "background"),
        ("late", "softness", "lost", "background"),
        ("early", "late", "softness", "lost", "background"),
        ("early", "softness", "rounded", "lost", "background"),
        ("late", "softness", "rounded", "lost", "background"),
        ("aside", "before", "after", "background"),
        ("early", "late", "softness", "summed"),
    )
    richer = forms[-4:-2]
    parameters = (
        Parameter(
            "early",
            unit="bins",
            low=0.0,
            high=65536.0,
            start=4.5,
            vanishes_at=0.0,
            axis="zone",
            placed=True,
            sentence="How many of the first bins lie outside the window.",
        ),
        Parameter(
            "late",
            unit="bins",
            low=0.0,
            high=65536.0,
            start=4.5,
            vanishes_at=0.0,
            axis="zone",
            placed=True,
            sentence="How many of the last bins lie outside the window.",
        ),
        Parameter(
            "softness",
            unit="bins",
            low=1.0,
            high=10.0,
            start=1.0,
            tries=(1.0, 4.0),
            sentence="Over how many bins the window closes, outwards from its edge; 1 where the edge is sharp.",
        ),
        Parameter(
            "rounded",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.0,
            sentence="How much its edges are rounded: 0 a straight ramp, 1 a logistic curve.",
        ),
        Parameter(
            "lost",
            unit="1",
            low=LEAST_LOST,
            high=1.0,
            start=1.0,
            sentence="Share of the counts outside the window that is lost; what lets more pass is no window.",
        ),
        Parameter(
            "aside",
            unit="1",
            low=0.0,
            high=1.0,
            start=0.2,
            vanishes_at=0.0,
            sentence="Share of the counts that is lost outside a window about the highest bin of each histogram.",
        ),
        Parameter("summed", "1", 0.0, 1.0, 0.0, "1 where all signal goes by the part in the window.", tries=(1.0,)),
        *(
            Parameter(side, "bins", 0.0, 65536.0, start, f"How far that window reaches {side} the highest bin.")
            for side, start in (("before", 2.0), ("after", 4.0))
        ),
        Parameter(
            "background",
            unit="1",
            low=0.0,
            high=1.0,
            start=1.0,
            tries=(0.0, 1.0),
            sentence="Whether the background is cut off as well: 1 where it is, 0 where only light of the laser is.",
        ),
    )

    def expected(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Counts less what lies outside the window."""
        bins = np.arange(rendering.expected.shape[-1])
        early, late = (np.atleast_1d(values[name])[:, None] for name in ("early", "late"))
        outside = _closed(values, early, bins) + _closed(values, late, bins[::-1])
        missed = values["lost"] * np.minimum(outside, 1)
        if values["aside"]:
            about = inside(rendering.expected, values["before"], values["after"])
            missed = np.minimum(missed + values["aside"] * (1 - about), 1)
        # Of what an effect before this one has taken away there cannot be more than there is.
        background = np.minimum(rendering.background, rendering.expected)
        cut = rendering.expected * (1 - missed) + background * (missed * (1 - values["background"]))
        if not values["summed"]:
            return cut
        signal = rendering.expected - background
        whole = np.maximum(signal.sum(axis=-1, keepdims=True), NOTHING)
        scaled = background + signal * (1 - (signal * missed).sum(axis=-1, keepdims=True) / whole)
        return cut + values["summed"] * (scaled - cut)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The edges beyond which one share of what is expected is lost most clearly, sharp and soft.

        And those beyond which all of it is, of each zone, and of all at the end where that is clearer. And how far from
        the highest bin counts are lost; and between which the part of a pulse says best how bright it is.
        """
        found, about = [], []
        for background in (1.0, 0.0):
            cut = expected - (1 - background) * np.minimum(rendering.background, expected)
            # Weighted least squares of a share of `cut`, of all bins up to each edge.
            weighted = cut / np.maximum(expected, 1)
            lacking, there = -(excess * weighted).sum(axis=0), (cut * weighted).sum(axis=0)
            alike = lacking.sum(axis=0), there.sum(axis=0)
            (early, *how_early), (late, *how_late) = (
                share_lost(*(one[::way] for one in alike), LEAST_LOST) for way in (1, -1)
            )
            # The clearer of the two says which share is lost.
            _, lost = max(how_early, how_late)
            own = emptied(lacking, there), emptied(lacking[:, ::-1], there[:, ::-1])
            clearer = {"early": early} if how_early > how_late else {"late": late}
            for softness in self.parameter("softness").tries:
                # The edge was taken where half of it is over.
                for edges, share in (((early, late), lost), (own, 1.0)):
                    ends = {name: at + (softness - 1) / 2 for name, at in zip(EDGES, edges, strict=True)}
                    found.append(ends | {"softness": softness, "lost": share, "background": background})
                alone = {name: at + (softness - 1) / 2 for name, at in clearer.items()}
                found.append(alone | {"softness": softness, "lost": 1.0, "background": background})
            before, after, aside = told_window(excess, expected, cut)
            if aside > 0:
                about.append({"aside": aside, "before": before, "after": after, "background": background})
        between = summed_window(excess, expected, rendering.background)
        for softness in self.parameter("softness").tries if between else ():
            # Where no edge is there is one to be moved none the less.
            ends = {e: max(at, SLIGHT) + (softness - 1) / 2 for e, at in zip(EDGES, between, strict=True)}
            about.append(ends | {"summed": 1.0, "softness": softness})
        return found + about


def _closed(values: Values, edge: np.ndarray, bins: np.ndarray) -> np.ndarray:
    """(P or 1, T) by how much a window is closed at bins counted from its end, with its edge after (P or 1, 1) bins."""
    beyond = (edge - bins) / values["softness"]
    # A slope of 1 in its middle, as the ramp; where there is no edge nothing closes.
    logistic = np.where(edge > 0, expit(4 * (beyond - 0.5)), 0)
    return (1 - values["rounded"]) * np.clip(beyond, 0, 1) + values["rounded"] * logistic


effect = WindowClipping()

"""Which position a scan visits next."""

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from calibrate.adaptive import AdaptivePlan
from calibrate.plan import ScanPlan
from calibrate.responses import responses
from calibrate.window import Window, choose_window
from devices.scan.journal import Sample
from devices.scan.motion_plan import MotionPlan
from devices.scan.survey import Survey
from recordings.maps import ResponseMaps

# Counts of so many positions are kept to learn where the patch's pulse is; later ones are cut to that at once.
LEARNT_FROM = 400


class Order(Protocol):
    """Positions of the patch pass."""

    def cells(self) -> Iterator[int]:
        """The cells to visit, one after another; more may come once these were seen."""

    def saw(self, sample: Sample) -> None:
        """Hear what was seen at a cell."""


class GridOrder:
    """Every cell once, in the order of the plan."""

    def __init__(self, plan: MotionPlan) -> None:
        visits = ScanPlan(plan.columns, plan.rows, order=plan.order).cells
        self._cells = (visits @ [1, plan.columns]).tolist()

    def cells(self) -> Iterator[int]:
        """All cells."""
        return iter(self._cells)

    def saw(self, sample: Sample) -> None:
        """What was seen changes nothing."""


class AdaptiveOrder:
    """Cells where the maps are least certain, until they are certain enough.

    The background is not known before the second pass; until then the median histogram of each zone stands in for it,
    as a zone sees the patch in a minority of positions.
    """

    def __init__(self, plan: MotionPlan, survey: Survey, zone_grid: tuple[int, int], prior: ResponseMaps | None = None):
        centres = survey.expected_px(np.arange(plan.size))
        radius = float(survey.target.radius[0])
        self.plan = AdaptivePlan(centres, radius, accuracy=plan.accuracy, zone_grid=zone_grid, prior=prior)
        self._first: list[np.ndarray] = []
        self._window: Window | None = None
        self._background: np.ndarray | None = None
        self._new: dict[int, np.ndarray] = {}
        self._seen: set[int] = set()

    def cells(self) -> Iterator[int]:
        """Batch after batch; what was seen of one decides on the next. The first is the same whatever was seen."""
        batch = self.plan.next()
        while len(batch):
            yield from (int(cell) for cell in batch if cell not in self._seen)
            self._learn()
            batch = self.plan.next()

    def saw(self, sample: Sample) -> None:
        """Keep the mean histogram of the position."""
        mean = np.mean([frame.counts for frame in sample.frames], axis=0)
        self._seen.add(sample.cell)
        self._new[sample.cell] = mean if self._window is None else mean[:, self._window.first : self._window.last + 1]
        if self._window is None and len(self._first) < LEARNT_FROM:
            self._first.append(mean)

    def _learn(self) -> None:
        """Hand responses of the cells seen since the last time to the plan."""
        if not self._new:
            return
        if self._window is None:
            self._learn_window()
        cells = np.array(list(self._new))
        seen = np.stack(list(self._new.values()))[..., : self._background.shape[-1]]
        dark = np.broadcast_to(self._background, seen.shape)
        found = responses(seen, dark, Window(0, seen.shape[-1] - 1, 1.0, (), "data"))
        self.plan.learn(cells, found.value, found.sigma, None)
        self._new.clear()

    def _learn_window(self) -> None:
        """From all that was seen so far: the bins of the patch's pulse, and what is there without it."""
        counts = np.stack(self._first)
        window = choose_window(counts.round().astype(np.int64), None)
        inside = slice(window.first, window.last + 1)
        self._background = np.median(counts, axis=0)[:, inside]
        self._new = {cell: mean[:, inside] for cell, mean in self._new.items()}
        self._window = window
        self._first.clear()

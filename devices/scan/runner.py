"""The scan itself: position after position, pass after pass, from wherever it was left."""

from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from itertools import islice

import numpy as np

from calibrate.patch_edge import Disc
from devices.captures import Settled
from devices.scan.holder import Holder
from devices.scan.journal import Journal
from devices.scan.motion_plan import MotionPlan
from devices.scan.order import AdaptiveOrder, GridOrder, Order
from devices.scan.sample import keep, sample_of
from devices.scan.station import Station
from devices.scan.survey import MOST_TILT_DEG, Survey, survey
from devices.scan.visit import Seen, Visit
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

# So many positions in a row without a patch where it must be: it fell off, or something moved.
MOST_UNSEEN = 5


class Scan:
    """One scan, to be `run` once; what it sees goes into the journal, and what is in the journal is not done again."""

    def __init__(
        self,
        plan: MotionPlan,
        station: Station,
        holder: Holder,
        journal: Journal,
        *,
        zone_grid: tuple[int, int],
        prior: ResponseMaps | None = None,
        watch: Callable[[Seen], None] = lambda seen: None,
        tell: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self._plan, self._station, self._holder, self._journal = plan, station, holder, journal
        self._zone_grid, self._prior, self._watch, self._tell = zone_grid, prior, watch, tell
        self._done = {name: set(journal.cells(name)) for name in ("patch", "background")}
        self._kept = sum(map(len, self._done.values()))
        self._since_monitor = 0
        self._unseen: list[int] = []
        self._writer = ThreadPoolExecutor(1, "journal")
        self._written: Future | None = None

    def run(self) -> None:
        """Scan what is not scanned yet; raises `Refusal` where it cannot go on, with everything so far kept."""
        try:
            found = self._surveyed()
            order = self._order(found)
            for sample in self._journal.samples("patch", pictures=False):
                order.saw(sample)
            passes = [name for name in ("patch", "background") if name == "patch" or self._plan.passes != "patch only"]
            block = self._plan.block if self._plan.passes == "interleaved" else None
            remaining = (cell for cell in order.cells() if cell not in self._done["patch"])
            while cells := self._pass("patch", islice(remaining, block), found, order):
                if block is None:
                    break
                if len(passes) > 1:
                    self._pass("background", self._behind(), found, order)
                if cells < block:
                    break
            if len(passes) > 1:
                self._pass("background", self._behind(), found, order)
            self._settle_journal()
        finally:
            self._writer.shutdown()

    def _behind(self) -> Iterator[int]:
        """Cells that were seen with the patch and not without, in the order in which they were."""
        return iter([cell for cell in self._journal.cells("patch") if cell not in self._done["background"]])

    def _order(self, found: Survey) -> Order:
        if self._plan.order == "adaptive":
            return AdaptiveOrder(self._plan, found, self._zone_grid, self._prior)
        return GridOrder(self._plan)

    def _surveyed(self) -> Survey:
        """Where the patch is at every cell: from the journal, or by looking."""
        kept = self._journal.said("survey")
        if kept is not None:
            return Survey.from_json(kept)
        self._tell("looking at positions spread over the grid, to learn where the patch is in the image")
        self._holder.show(True)
        found = survey(self._plan, lambda cell: self._look(cell))
        lens = self._station.camera.device.said.get("intrinsics")
        tilt = found.tilt_deg(lens["fx"]) if lens else 0.0
        if tilt > MOST_TILT_DEG:
            self._tell(
                f"the patch's plane is turned by about {tilt:.0f} degrees against the camera's image; a calibration "
                "takes them to be parallel: teach the corners anew"
            )
        self._journal.say("survey", found.to_json())
        return found

    def _look(self, cell: int) -> np.ndarray:
        """A picture (H, W, 3) with the arm at a cell."""
        self._move(cell)
        return self._station.picture().rgb

    def _pass(self, name: str, cells: Iterator[int], found: Survey, order: Order) -> int:
        """Visit cells; how many there were.

        While the arm moves to a cell the last is read out; where that turns out not to be whole it is visited again.
        """
        count, before = 0, None
        for cell in cells:
            if count == 0:
                self._expect_patch(name == "patch", cell, found)
            count += 1
            before = self._visit(name, cell, found, order, before)
            self._since_monitor += 1
            if name == "patch" and self._plan.monitor_every and self._since_monitor >= self._plan.monitor_every:
                self._since_monitor = 0
                before = self._visit("monitor", self._plan.middle, found, order, before)
        while before is not None:
            before = self._finish(before, found, order)
        self._settle_journal()
        return count

    def _expect_patch(self, there: bool, cell: int, found: Survey) -> None:
        """See that the patch is on its holder, or is not; have it changed where it is otherwise."""
        for ask in (True, False):
            if (found.find(self._look(cell), cell) is not None) == there:
                return
            if ask:
                self._holder.show(there)
        wanted, seen = ("on its holder", "not seen") if there else ("gone", "still seen")
        raise Refusal(f"the patch is {seen} at cell {cell}, expected it {wanted}; see to it and go on with --resume")

    def _visit(self, name: str, cell: int, found: Survey, order: Order, before: Visit | None) -> Visit:
        """Move, look; keep what was seen at the visit before, or go back there first."""
        if name in self._done:
            self._done[name].add(cell)
        while True:
            settled = self._move(cell)
            before = before and self._finish(before, found, order)
            if before is None:
                return Visit(name, cell, settled, self._station.see(self._plan.repeats, name != "background"))

    def _move(self, cell: int) -> Settled:
        return self._station.move(self._plan.poses(np.array([cell]))[0])

    def _finish(self, visit: Visit, found: Survey, order: Order) -> Visit | None:
        """Keep what was seen; where it is not whole, see it again, which is to be finished, too."""
        seen = visit.look.read()
        if seen is None:
            settled = self._move(visit.cell)
            return replace(
                visit, settled=settled, look=self._station.see(self._plan.repeats, visit.look.rgb is not None)
            )
        sample, rgb = sample_of(visit.name, visit.cell, visit.settled, seen), visit.look.rgb
        patch = None if rgb is None else found.find(rgb, visit.cell)
        pictures = [picture and picture.rgb for _, picture in seen]
        self._settle_journal()
        self._written = self._writer.submit(keep, self._journal, sample, pictures)
        if visit.name == "patch":
            self._expect_seen(visit.cell, patch)
            order.saw(sample)
        if visit.name != "monitor":
            self._kept += 1
            planned = self._plan.size * (1 if self._plan.passes == "patch only" else 2)
            self._watch(Seen(sample, rgb, patch, self._kept, planned))
        return None

    def _expect_seen(self, cell: int, patch: Disc | None) -> None:
        """Stop where the patch is not where the arm has it, position after position; what these saw is no scan."""
        self._unseen = [] if patch is not None else [*self._unseen, cell]
        if len(self._unseen) >= MOST_UNSEEN:
            self._settle_journal()
            self._journal.forget("patch", self._unseen)
            raise Refusal(
                f"the patch was not seen at {len(self._unseen)} positions in a row, the last of them cell {cell}: did "
                "it fall off, does the arm move, is the light on? See to it and go on with --resume"
            )

    def _settle_journal(self) -> None:
        """Wait until what was seen last is on disk; raises what went wrong with it."""
        written, self._written = self._written, None
        if written is not None:
            written.result()

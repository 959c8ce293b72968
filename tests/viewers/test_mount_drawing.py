"""The drawing: edges are seen or hidden as they are from there, and lengths are what the solids measure."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation

from calibrate.rig import Rig
from devices.parts.bracket import Bracket
from devices.parts.holder import Holder
from devices.parts.placed import Placed
from devices.parts.solids import box, cylinder
from viewers.mount_drawing import bracket_sheet, holder_sheet
from viewers.part_edges import Looking, edges

ABOVE = Looking((1, 0, 0), (0, 1, 0))
ASIDE = Looking((0.8, 0.6, 0), (-0.3, 0.4, np.sqrt(0.75)))


def length(pieces):
    return np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1).sum()


def test_a_pocket_in_the_base_is_hidden_from_above():
    solid = box((0, 0, 0), (10, 20, 5)) - box((2, 2, -1), (8, 8, 3))
    seen, hidden = edges(solid, ABOVE, [solid])
    # The pocket's rim and its floor's, 4 x 6 each; the body's top and base lie on one another.
    assert length(hidden) == pytest.approx(48, abs=1e-3)
    assert length(seen) == pytest.approx(120, abs=1e-3)


def test_of_a_box_from_a_corner_three_edges_are_hidden():
    solid = box((0, 0, 0), (10, 10, 10))
    right, up = np.array(ASIDE.right), np.array(ASIDE.up)
    shown = {axis: 10 * np.hypot(right[axis], up[axis]) for axis in range(3)}
    seen, hidden = edges(solid, ASIDE, [solid])
    assert length(hidden) == pytest.approx(sum(shown.values()), rel=0.02)
    assert length(seen) == pytest.approx(3 * sum(shown.values()), rel=0.02)


def test_what_stands_before_hides():
    low, lid = box((0, 0, 0), (10, 10, 1)), box((-1, -1, 5), (11, 11, 6))
    seen, _ = edges(low, ABOVE, [low, lid])
    assert not len(seen)


def test_a_cylinder_has_an_outline():
    solid = cylinder((0, 0, 0), 10, 8)
    seen, _ = edges(solid, Looking((1, 0, 0), (0, 0, 1)), [solid])
    # Two sides of 10, top and base seen edge-on: each is there as its nearer half.
    upright = np.abs(seen[:, 1] - seen[:, 0])[:, 1] > 1e-6
    assert length(seen[upright]) == pytest.approx(20, abs=0.1)
    assert np.abs(seen[upright][..., 0]).min() == pytest.approx(4, abs=0.01)


def words(sheet):
    FigureCanvasAgg(sheet.figure).draw()
    return [text.get_text() for text in sheet.axes.texts if not isinstance(text, Annotation) or text.get_text()]


def test_dimensions_say_what_the_rig_says():
    bracket = Bracket(Placed.of(Rig()))
    said = words(bracket_sheet(bracket, bracket.part, ["a note"]))
    for number in ("53", "24", "20", "45", "90", "73.2", "14.9", "LiDAR 52°", "camera 42°", "a note"):
        assert number in said, number


def test_the_holder_says_its_tool():
    said = words(holder_sheet(Holder.of(Rig())))
    for number in ("35 tool", "63", "112", "35.2", "50", "8", "30"):
        assert number in said, number

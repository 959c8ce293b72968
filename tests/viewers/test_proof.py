"""The picture of a proof: right answers lie along the diagonal."""

from collections import Counter

from matplotlib.figure import Figure

from viewers.proof import _in_one_order, _strengths


def test_answers_are_in_the_order_of_what_they_are_right_for():
    confusion = Counter([("b", "b"), ("a", "z"), ("a", "a"), ("b+c", "b+c"), ("m", "z"), ("nothing", "nothing")])
    truths, answers = _in_one_order(confusion)
    assert truths == ["a", "b", "nothing", "b+c", "m"]
    assert answers == ["a", "b", "nothing", "b+c", "z"]


def test_where_nobody_says_how_much_causes_move_the_picture_says_that():
    empty, full = Figure().subplots(1, 2)
    _strengths(empty, [(float("nan"), True)])
    _strengths(full, [(300.0, True), (5000.0, False)])
    assert [text.get_text() for text in empty.texts] == ["not stated of any single cause"]
    assert not full.texts
    assert full.get_xscale() == "log"

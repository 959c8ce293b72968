"""The picture of a proof: right answers lie along the diagonal."""

from collections import Counter

from viewers.proof import _in_one_order


def test_answers_are_in_the_order_of_what_they_are_right_for():
    confusion = Counter([("b", "b"), ("a", "z"), ("a", "a"), ("b+c", "b+c"), ("m", "z"), ("nothing", "nothing")])
    truths, answers = _in_one_order(confusion)
    assert truths == ["a", "b", "nothing", "b+c", "m"]
    assert answers == ["a", "b", "nothing", "b+c", "z"]

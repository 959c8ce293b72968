from html.parser import HTMLParser

import numpy as np
import pytest
from scipy.stats import poisson

from physics.effects import find_effect
from viewers import explain_figures as figures
from viewers.compared import bins_of_interest, compared, telling
from viewers.explain_report import write_report

NAME = "<b>scan & co</b>.rrd"
VOID = {"meta", "br", "path", "use", "image", "rect"}


class Page(HTMLParser):
    """What a page holds; fails where an element is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.links, self.said = [], [], [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for name, value in attrs if name in ("href", "src", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.said += data


@pytest.fixture(scope="module")
def pages(explanations, tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    texts = {}
    for kind, explanation in explanations.items():
        write_report(explanation, folder / "report.html", NAME)
        assert [path.name for path in folder.iterdir()] == ["report.html"]
        texts[kind] = (folder / "report.html").read_text(encoding="utf-8")
    return texts


KINDS = ("agrees", "explained", "unknown", "nothing fits")


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_stands_alone(pages, kind):
    page = Page(pages[kind])
    assert page.open == []
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert all(link.startswith(("#", "data:")) for link in page.links)
    assert "http" not in pages[kind]
    assert "@import" not in pages[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_given_is_text_not_markup(pages, kind):
    assert NAME in Page(pages[kind]).said
    assert "<b>" not in pages[kind]
    if kind == "explained":
        assert "Record <b>less</b> light." in Page(pages[kind]).said
        assert "<i>" in Page(pages[kind]).said


def test_each_verdict_says_its_own(pages):
    said = {kind: " ".join(Page(text).said.split()) for kind, text in pages.items()}
    assert "Recording and simulation agree" in said["agrees"]
    assert "The mismatch is explained" in said["explained"]
    assert "falls from 3.100 to 1.030" in said["explained"]
    assert "97 % is closed" in said["explained"]
    for kind in ("unknown", "nothing fits"):
        assert "A mismatch stands that no known effect explains" in said[kind]
    for words in ("The effects", "Record & see.", "0.200 ± 0.010", "−34.0 ± 3.0 ps", "afterpulsing", "0.75"):
        assert words in said["explained"]
        assert words not in said["agrees"]
    for name in ("share", "duration"):
        assert find_effect("impulse_tail").parameter(name).sentence in said["explained"]
    assert "none would show" in said["agrees"]
    assert "What is left" in said["unknown"]
    assert "What is left" not in said["explained"]


def test_the_same_counts_give_the_same_picture(explanations):
    shown = compared(explanations["explained"])
    one, other = (figures.histogram(shown, slice(5, 30), 1, None, 1e-10) for _ in range(2))
    assert one == other
    assert one.startswith("<svg")


def test_residuals_are_those_of_the_likelihood(explanations):
    """Deviance is twice the log-likelihood that the model lacks beside one that expects what was counted."""
    shown = compared(explanations["explained"])
    best = poisson.logpmf(shown.recorded, shown.recorded)
    gain = 2 * (poisson.logpmf(shown.recorded, shown.after) - poisson.logpmf(shown.recorded, shown.before))
    np.testing.assert_allclose(shown.improvement, gain.sum(axis=2), rtol=1e-6, atol=1e-6)
    lacks = 2 * (best - poisson.logpmf(shown.recorded, shown.before)).mean(axis=(1, 2))
    np.testing.assert_allclose(shown.by_frame()["before"], lacks, rtol=1e-6)
    summed, expected = shown.recorded.sum(axis=0), shown.before.sum(axis=0)
    residual = shown.residuals(0)[0]
    lacks = 2 * (poisson.logpmf(summed, summed) - poisson.logpmf(summed, expected))
    np.testing.assert_allclose(residual**2, lacks, rtol=1e-5, atol=1e-6)
    assert (np.sign(residual) == np.sign(summed - expected)).all()


def test_places_that_are_drawn(explanations):
    shown = compared(explanations["explained"])
    found = telling(shown, "explained")
    assert len(set(found)) == len(found) == 6
    frame, zone = found[0]
    assert shown.improvement[frame, zone] == shown.improvement.max()
    assert max(np.bincount([z for _, z in found])) <= 2
    mixed = telling(shown, "unknown")
    assert shown.remaining[mixed[3]] >= np.median(shown.remaining)
    bins = bins_of_interest(shown)
    peaks = shown.recorded.sum(axis=(0,)).argmax(axis=1)
    assert ((peaks >= bins.start) & (peaks < bins.stop)).all()

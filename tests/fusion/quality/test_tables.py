"""Tables that documents show."""

from fusion.quality.judge import ALTERNATIVES
from fusion.quality.tables import methods_table, verdict


def scores(unmixed):
    def frame(rms):
        return {"rms": rms, "median": 0.1, "close": 0.5, "edges": 0.2}

    found = {name: [frame(0.4 + k / 10), frame(0.5)] for k, name in enumerate(ALTERNATIVES)}
    return found | {"unmix": [frame(rms) | {"coverage": 0.9} for rms in unmixed]}


def test_the_verdict_names_the_best_alternative_and_counts_bad_frames():
    assert verdict([scores((0.27, 0.27))]) == (
        "Unmixing: rms 40% below the best alternative (nearest zone, 0.450 m), by draw 40%; "
        "above an alternative on 0 of 2 frames."
    )
    both = verdict([scores((0.27, 0.27)), scores((0.31, 0.55))])
    assert "by draw 40%, 4%" in both
    assert "on 1 of 4 frames" in both


def test_every_method_has_a_row_of_as_many_cells_as_the_head():
    rows = methods_table(scores((0.3, 0.31))).split("\n")
    assert len(rows) == 2 + len(ALTERNATIVES) + 1
    assert len({row.count("|") for row in rows}) == 1
    assert rows[-1] == "| unmix | 0.305 m | 0.100 m | 50% | 0.200 m | 0.310 m | 90% |"

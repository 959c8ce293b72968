import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.stats import poisson

from recordings.refusal import Refusal
from viewers.residual_session import verdict_text, write_residuals


@pytest.fixture(scope="module")
def session(explanations, tmp_path_factory):
    path = tmp_path_factory.mktemp("session") / "residuals.rrd"
    write_residuals(explanations["explained"], path)
    return path


@pytest.fixture(scope="module")
def rows(session):
    """Record batches by entity."""
    found = {}
    for chunk in RrdReader(session).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def test_is_a_sound_file_with_a_blueprint(session):
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", session], check=True, capture_output=True)
    assert RrdReader(session).blueprints()
    assert [path.name for path in session.parent.iterdir()] == ["residuals.rrd"]


def test_holds_every_frame(rows, simulation):
    frames, zones, _ = simulation.counts.shape
    counted = {entity: sum(batch.num_rows for batch in batches) for entity, batches in rows.items()}
    for name in ("before", "after"):
        assert counted[f"/residual/{name}"] == frames
    for p in range(zones):
        assert all(counted[f"/zone/{p}/{name}"] == frames for name in ("recorded", "before", "after"))
    for name in ("before", "after", "noise"):
        assert counted[f"/deviance/{name}"] == frames + 1  # and how it is drawn
    assert counted["/verdict"] == 1


def column(batches, ending):
    """All values of the component whose name ends so."""
    name = next(n for batch in batches for n in batch.schema.names if n.endswith(ending))
    return [row for batch in batches if name in batch.schema.names for row in batch.column(name).to_pylist()]


def test_deviance_is_that_of_the_likelihood(rows, explanations):
    explanation = explanations["explained"]
    counts = explanation.simulation.counts
    for name, fit in (("before", explanation.nominal), ("after", explanation.explained)):
        lacks = 2 * (poisson.logpmf(counts, counts) - poisson.logpmf(counts, fit.expected))
        shown = [row[0] for row in column(rows[f"/deviance/{name}"], "Scalars:scalars") if row]
        np.testing.assert_allclose(shown, lacks.mean(axis=(1, 2)), rtol=1e-6)


def test_the_verdict_is_in_it(rows, explanations):
    (text,) = column(rows["/verdict"], "TextDocument:text")[0]
    assert text == verdict_text(explanations["explained"].verdict)
    assert "impulse tail" in text
    assert "duration [1]: −34.0 ± 3.0 ps" in text


@pytest.mark.parametrize("kind", ["agrees", "unknown", "nothing fits"])
def test_every_verdict_can_be_shown(explanations, tmp_path, kind):
    write_residuals(explanations[kind], tmp_path / "a.rrd")
    assert (tmp_path / "a.rrd").stat().st_size > 1000


def test_nothing_is_left_where_it_cannot_be_written(explanations, tmp_path):
    with pytest.raises(Refusal, match="does not exist"):
        write_residuals(explanations["agrees"], tmp_path / "none" / "a.rrd")
    assert list(tmp_path.iterdir()) == []

"""The journal of a scan: what was told to be there is there, whatever happened in between."""

import os
import signal
import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from devices.scan.journal import Frame, Journal, Sample
from recordings.refusal import Refusal

WRITER = """
import sys, numpy as np
from devices.scan.journal import Frame, Journal, Sample
journal = Journal(sys.argv[1])
for cell in range(10 ** 9):
    journal.add(Sample("patch", cell, (Frame(float(cell), np.full((9, 128), cell, np.uint32), bytes(50000)),), {}))
    print(cell, flush=True)
"""


def sample(cell, name="patch", counts=None, rgb=None, **said):
    counts = np.arange(12, dtype=np.uint32).reshape(3, 4) + cell if counts is None else counts
    return Sample(name, cell, (Frame(1.5 * cell, counts, rgb), Frame(1.5 * cell + 1, 2 * counts, None)), said)


@given(counts=arrays(np.uint32, st.tuples(st.integers(1, 4), st.integers(1, 9))), rgb=st.none() | st.binary())
def test_what_goes_in_comes_out(tmp_path_factory, counts, rgb):
    journal = Journal(tmp_path_factory.mktemp("journal") / "s.scanning")
    given_ = sample(7, counts=counts, rgb=rgb, pose=[1.0, 2.0])
    journal.add(given_)
    (found,) = journal.samples("patch")
    assert (found.pass_name, found.cell, found.said) == ("patch", 7, {"pose": [1.0, 2.0]})
    for one, other in zip(found.frames, given_.frames, strict=True):
        assert (one.time_s, one.rgb) == (other.time_s, other.rgb)
        np.testing.assert_array_equal(one.counts, other.counts)
    journal.close()


def test_cells_come_in_the_order_of_their_visits_and_each_once(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    for cell in (5, 2, 9):
        journal.add(sample(cell))
    journal.add(sample(2, "background"))
    for _ in range(2):
        journal.add(sample(3, "monitor"))
    assert journal.cells("patch") == [5, 2, 9]
    assert [s.cell for s in journal.samples("monitor", pictures=False)] == [3, 3]
    with pytest.raises(Refusal, match="cannot be used as the journal"):
        journal.add(sample(2))
    assert journal.count() == 6
    journal.forget("patch", [2, 9])
    assert journal.cells("patch") == [5]
    journal.add(sample(2))
    assert journal.cells("patch") == [5, 2]


def test_it_is_the_same_when_it_is_opened_again(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    journal.say("plan", {"columns": 3})
    journal.add(sample(1))
    journal.close()
    again = Journal(tmp_path / "s.scanning")
    assert again.said("plan") == {"columns": 3}
    assert again.said("nothing") is None
    assert again.cells("patch") == [1]


def test_a_writer_that_is_killed_leaves_every_sample_it_spoke_of(tmp_path):
    path = tmp_path / "s.scanning"
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True)
    for line in writer.stdout:
        if int(line) == 20:
            os.kill(writer.pid, signal.SIGKILL)
            break
    spoken = 20 + sum(1 for line in writer.stdout if line.strip())
    writer.wait()
    journal = Journal(path)
    cells = [s.cell for s in journal.samples("patch")]
    assert cells == list(range(len(cells)))
    assert spoken < len(cells) <= spoken + 2


def test_a_full_disk_loses_nothing_that_was_there(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    journal.add(sample(0))
    # A database that may not grow says what one says that cannot.
    journal._base.execute("PRAGMA max_page_count = 1")
    with pytest.raises(Refusal, match=r"the disk is full; what was seen so far is kept: .*--resume"):
        journal.add(sample(1, rgb=bytes(1_000_000)))
    kept = journal.cells("patch")
    journal._base.execute("PRAGMA max_page_count = 1000000")
    journal.add(sample(200))
    assert journal.cells("patch") == [*kept, 200]
    assert len(list(journal.samples("patch"))) == len(kept) + 1


def test_two_scans_do_not_write_into_one_journal(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    with pytest.raises(Refusal, match="another scan writes into it"):
        Journal(tmp_path / "s.scanning")
    journal.close()
    Journal(tmp_path / "s.scanning").close()


def test_other_files_are_refused_and_left_alone(tmp_path):
    (tmp_path / "text").write_bytes(b"something else entirely, long enough to be no database" * 20)
    with pytest.raises(Refusal, match="cannot be used as the journal of a scan"):
        Journal(tmp_path / "text")
    with sqlite3.connect(tmp_path / "other") as base:
        base.execute("CREATE TABLE said (name TEXT PRIMARY KEY, value TEXT NOT NULL)")
        base.execute("INSERT INTO said VALUES ('kind', '\"another tool\"')")
    with pytest.raises(Refusal, match="a journal of kind 'another tool'"):
        Journal(tmp_path / "other")


def test_once_exported_nothing_stays(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    journal.add(sample(0))
    journal.remove()
    assert list(tmp_path.iterdir()) == []

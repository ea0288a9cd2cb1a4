"""What is missing of a study is simulated, in this process or in others, and progress is told in words."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core import InputError
from bristle.study import run
from bristle.study.plan import Block
from bristle.study.run import Ran, in_words, run_within, worst_runs
from bristle.study.store import Runs
from bristle.study.workers import Cluster, Crew, Here


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "1 s"), (1.6, "2 s"), (89.0, "89 s"), (90.0, "2 min"), (5399.0, "90 min"), (5400.0, "1.5 h"), (36_000.0, "10.0 h")],
)
def test_a_time_is_reported_in_words(seconds, words):
    assert in_words(seconds) == words


class Kept:
    """A folder of which the first block is there."""

    def __init__(self, present=(0,)):
        self.present, self.written = set(present), []
        blocks = tuple(Block(4 * k, 4 * k + 4) for k in range(4))
        self.study = Some(blocks=blocks, count=16)

    def blocks_present(self):
        return self.present

    def write(self, block, columns):
        self.written.append((block.first, columns))


def test_progress_counts_present_runs_and_the_remaining_time(monkeypatch):
    now = iter([0.0, 10.0, 40.0, 100.0])
    monkeypatch.setattr(run, "time", Some(monotonic=lambda: next(now)))
    reported, kept = [], Kept()
    ran = run_within(
        kept,
        workers=1,
        progress=lambda share, words: reported.append((share, words)),
        simulator=lambda study: Some(columns=lambda block: block.count),
    )
    assert ran == Ran(1, ())
    assert kept.written == [(4, 4), (8, 4), (12, 4)]
    # Thirty seconds for the second block leave as much for the last one.
    assert reported == [(0.25, "4 of 16 runs"), (0.5, "8 of 16 runs"), (0.75, "12 of 16 runs, 30 s left"), (1.0, "16 of 16 runs, 1 s left")]


def test_a_complete_study_starts_no_worker(monkeypatch):
    kept = Kept((0, 4, 8, 12))
    monkeypatch.setattr(run, "Simulator", None)
    assert run_within(kept) == Ran(4, ())
    assert kept.written == []


def simulator(in_batches):
    return lambda study: Some(in_batches=in_batches, columns=len)


@pytest.mark.parametrize(
    ("missing", "workers", "in_batches", "kind", "count"),
    [
        (3, 1, True, Here, 1),
        (3, 2, True, Crew, 2),
        (3, 8, True, Crew, 3),
        (3, None, True, Here, 6),
        (3, None, False, Crew, 3),
        (1, None, False, Here, 1),
        (0, None, True, Crew, 1),
        (0, 1, True, Crew, 1),
    ],
)
def test_the_crew_follows_the_missing_blocks(missing, workers, in_batches, kind, count, monkeypatch):
    monkeypatch.setattr(run, "Simulator", simulator(in_batches))
    monkeypatch.setattr(run, "core_count", lambda: 6)
    crew = run._crew(None, missing, workers, None, run.Simulator)
    assert (type(crew), crew.workers) == (kind, count)


def test_workers_and_a_scheduler_are_not_asked_for_together(monkeypatch):
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match=r"workers: cannot be chosen together with a scheduler"):
        run._crew(None, 3, 2, "tcp://a:1", None)
    assert isinstance(run._crew(None, 3, None, "tcp://a:1", None), Cluster)
    assert isinstance(run._crew(None, 0, None, "tcp://a:1", simulator(False)), Crew)


def test_of_equally_bad_runs_the_earlier_comes_first():
    columns = {"run": np.arange(10, 16), "m": np.array([1.0, 3.0, np.nan, 3.0, 9.0, 2.0])}
    columns["status"] = np.array(["ok", "ok", "ok", "tolerance_missed", "refused", "ok"])
    assert worst_runs(Runs({"metrics": ["m", "n"]}, columns), 3) == [11, 13, 15]
    assert worst_runs(Runs({"metrics": ["m"]}, columns), 9) == [11, 13, 15, 10]

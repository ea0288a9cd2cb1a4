"""A position that is somewhere else from one sample to the next is told; motion and gaps in time are not."""

import re

import numpy as np
import pytest
from tests.logs.conftest import csv_text
from tests.logs.test_spikes import MOTION, MOTIONS, TIME

from bristle.logs import Log, checked, read_log
from bristle.logs.lines import lost_in
from bristle.report.messages import message


def told_of(tmp_path, axis, q, kept=slice(None)):
    path = tmp_path / "log.csv"
    t, noise = TIME[kept], np.random.default_rng(1).normal(size=q.size)
    path.write_text(
        csv_text(
            {"t": t, "q": q, "r": 0.1 * np.sin(t), "u": np.sign(np.gradient(MOTION))[kept] + noise}
        )
    )
    return [
        message(result)
        for result in checked(read_log(path, axis), axis)
        if result.code == "rows_lost"
    ]


@pytest.mark.parametrize("step", [0.0, 1e-6, 5e-5])
@pytest.mark.parametrize("values", MOTIONS.values(), ids=MOTIONS)
def test_motion_is_no_jump(values, step):
    recorded = np.round(values / step) * step if step else values
    log = Log(time=1e-3 * np.arange(values.size), position=recorded)
    assert lost_in(log, step, 8.0).size == 0


@pytest.mark.parametrize(
    ("position", "words"),
    [
        # A counter that wraps.
        (
            (MOTION + 0.03) % 0.1,
            r"jumps by up to (100|99\.9\S*) mm.*first after t = .*\(number of jumps: .*counter wrapped",
        ),
        (
            np.where(np.arange(TIME.size) < 4321, MOTION, MOTION + 0.5),
            r"first after t = 4.32 s \(number of jumps: 1\)",
        ),
    ],
)
def test_the_place_and_size_of_jumps_are_reported(tmp_path, axis, position, words):
    (note,) = told_of(tmp_path, axis, position)
    assert re.search(words, note), note


def test_a_gap_in_time_is_no_jump(tmp_path, axis):
    kept = np.r_[0:2000, 3200:6000]
    moved = MOTION[kept] + np.where(kept > 3000, 0.5, 0.0)
    assert told_of(tmp_path, axis, moved, kept) == []

"""A position that is somewhere else from one sample to the next is told; motion and gaps in time are not."""

from dataclasses import replace

import numpy as np
import pytest
from tests.logs.conftest import csv_text
from tests.logs.test_spikes import MOTION, MOTIONS, TIME

from bristle.core.axis import Column
from bristle.logs import Log, checked, read_log
from bristle.logs.lines import lost_in
from bristle.report.messages import message


def told_of(tmp_path, axis, q, t=TIME):
    path = tmp_path / "log.csv"
    noise = np.random.default_rng(1).normal(size=q.size)
    path.write_text(csv_text({"t": t, "q": q, "r": 0.1 * np.sin(t), "u": np.sign(np.gradient(MOTION)) + noise}))
    return [message(result) for result in checked(read_log(path, axis), axis) if result.code == "rows_lost"]


@pytest.mark.parametrize("step", [0.0, 1e-6, 5e-5])
@pytest.mark.parametrize("values", MOTIONS.values(), ids=MOTIONS)
def test_motion_is_no_jump(values, step):
    recorded = np.round(values / step) * step if step else values
    log = Log(time=1e-3 * np.arange(values.size), position=recorded)
    assert lost_in(log, step, 8.0).size == 0


def test_a_counter_overflow_is_reported(tmp_path, axis):
    (note,) = told_of(tmp_path, axis, (MOTION + 0.03) % 0.1)
    assert "jumps by up to 100 mm" in note or "jumps by up to 99.9" in note
    assert "first after t = " in note
    assert "(number of jumps: " in note
    assert "counter wrapped" in note


def test_the_place_of_a_single_jump_is_reported(tmp_path, axis):
    moved = np.where(np.arange(TIME.size) < 4321, MOTION, MOTION + 0.5)
    (note,) = told_of(tmp_path, axis, moved)
    assert "first after t = 4.32 s (number of jumps: 1)" in note


def test_a_gap_in_time_is_no_jump(tmp_path, axis):
    kept = np.r_[0:2000, 3200:6000]
    noise = np.random.default_rng(1).normal(size=kept.size)
    path = tmp_path / "log.csv"
    path.write_text(
        csv_text(
            {
                "t": TIME[kept],
                "q": MOTION[kept] + np.where(kept > 3000, 0.5, 0.0),
                "r": MOTION[kept],
                "u": np.sign(np.gradient(MOTION))[kept] + noise,
            }
        )
    )
    log = read_log(path, axis)
    assert len(log.segments) == 2
    assert "rows_lost" not in [result.code for result in checked(log, axis)]


def test_a_column_that_is_used_twice_is_noted(tmp_path, axis):
    twice = replace(axis, columns=axis.columns | {"reference": Column("q", "m", "m")})
    path = tmp_path / "log.csv"
    path.write_text(csv_text({"t": TIME, "q": MOTION, "u": np.sign(np.gradient(MOTION)) + 0.1 * np.sin(TIME)}))
    assert "column q is used twice, as position and as reference. Check [columns]" in read_log(path, twice).notes

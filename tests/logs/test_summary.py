"""What is in a log: all of it, and every problem."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bristle.logs import summarize


def test_a_good_log(any_file, axis, recording):
    summary = summarize(any_file, axis)
    assert summary["problems"] == []
    assert summary["rate"] == pytest.approx(1000.0)
    assert summary["duration"] == pytest.approx(recording["t"].size * 1e-3)
    assert [channel["name"] for channel in summary["channels"]] == ["time", "position", "reference", "effort"]
    position = summary["channels"][1]
    assert position["step"] == pytest.approx(1e-5, rel=1e-9)
    assert position["max"] == recording["q"].max()
    assert json.loads(json.dumps(summary)) == summary


def test_every_problem_is_listed(write, axis, recording):
    effort, time = recording["u"].copy(), recording["t"].copy()
    effort[5] = np.nan
    time = np.random.default_rng(3).permutation(time)
    path = write(u=effort, t=time, r=np.full(time.size, 1.0))
    path.write_text(path.read_text().replace("t,q,r,u", "t,x,r,u"))
    text = "\n".join(summarize(path, axis)["problems"])
    for problem in ("no column 'q'", "has NaN"):
        assert problem in text
    path = write(t=time, r=np.full(time.size, 1.0))
    text = "\n".join(summarize(path, axis)["problems"])
    for problem in ("column 'r': is constant", "is not in order"):
        assert problem in text


@pytest.mark.parametrize("count", [2, 3, 50])
def test_a_log_too_short_for_anything_is_described(write, axis, count):
    path = write()
    path.write_text("\n".join(path.read_text().split("\n")[: count + 1]) + "\n")
    summary = summarize(path, axis)
    assert summary["columns"][0]["samples"] == count
    assert "is too short" in summary["problems"][0]


def test_time_that_is_not_finite_leaves_the_rate_open(write, axis, recording):
    time = recording["t"].copy()
    time[7] = np.nan
    summary = summarize(write(t=time), axis)
    assert summary["rate"] is None
    assert "column 't': has NaN" in summary["problems"][0]


def test_without_an_axis_the_columns_are_described_all_the_same(write):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", "a,b,c,d"))
    summary = summarize(path)
    assert [column["name"] for column in summary["columns"]] == ["a", "b", "c", "d"]
    assert summary["channels"] == []
    assert "Give an axis file" in summary["problems"][0]

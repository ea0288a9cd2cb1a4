"""What is in a log: all of it, and every problem."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bristle.logs import summarize


def test_a_good_log(any_file, axis, recording):
    summary = summarize(any_file, axis)
    assert (summary["problems"], summary["rate"], summary["duration"]) == (
        [],
        pytest.approx(1000.0),
        pytest.approx(1.2),
    )
    assert [channel["name"] for channel in summary["channels"]] == [
        "time",
        "position",
        "reference",
        "effort",
    ]
    position = summary["channels"][1]
    assert (position["step"], position["max"]) == (
        pytest.approx(1e-5, rel=1e-9),
        recording["q"].max(),
    )
    assert json.loads(json.dumps(summary)) == summary


def test_every_problem_is_listed(write, axis, recording):
    mixed = np.random.default_rng(3).permutation(recording["t"])
    path = write(
        u=np.where(recording["t"] == 0.005, np.nan, recording["u"]), t=mixed, r=np.ones(mixed.size)
    )
    path.write_text(path.read_text().replace("t,q,r,u", "t,x,r,u"))
    first = "\n".join(summarize(path, axis)["problems"])
    second = "\n".join(summarize(write(t=mixed, r=np.ones(mixed.size)), axis)["problems"])
    assert [words in first for words in ("no column 'q'", "has NaN")] == [True, True]
    assert [words in second for words in ("column 'r': is constant", "is not in order")] == [
        True,
        True,
    ]


@pytest.mark.parametrize("count", [2, 3, 50])
def test_a_log_too_short_for_anything_is_described(write, axis, count):
    path = write()
    path.write_text("\n".join(path.read_text().split("\n")[: count + 1]) + "\n")
    summary = summarize(path, axis)
    assert (summary["columns"][0]["samples"], "is too short" in summary["problems"][0]) == (
        count,
        True,
    )


def test_time_that_is_not_finite_leaves_the_rate_open(write, axis, recording):
    summary = summarize(write(t=np.where(recording["t"] == 0.007, np.nan, recording["t"])), axis)
    assert (summary["rate"], "column 't': has NaN" in summary["problems"][0]) == (None, True)


def test_without_an_axis_the_columns_are_described_all_the_same(write):
    path = write()
    path.write_text(path.read_text().replace("t,q,r,u", "a,b,c,d"))
    summary = summarize(path)
    assert ([column["name"] for column in summary["columns"]], summary["channels"]) == (
        ["a", "b", "c", "d"],
        [],
    )
    assert "Give an axis file" in summary["problems"][0]

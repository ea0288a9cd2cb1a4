"""Columns of a table become channels: units, times of their own, references, columns used twice."""

import numpy as np
import pytest

from bristle.core.axis import Axis, Column
from bristle.core.errors import InputError
from bristle.logs.gather import axis_of, gather
from bristle.logs.table import Table

TIME, X = np.arange(40.0), np.sin(0.3 * np.arange(40.0))


def table_of(units=None, stamps=None, **columns):
    return Table(columns, units or {}, names=tuple(columns), stamps=stamps or {}, format="MF4")


def axis_with(kind="translational", **columns):
    bases = {"time": "s", "effort": "N", "velocity": "m/s"}
    made = {name: entry if isinstance(entry, Column) else Column(entry, "", bases.get(name, "m")) for name, entry in columns.items()}
    return Axis(kind=kind, columns=made)


def test_columns_are_in_si_with_scale_and_shift():
    table = table_of({"q": "mm", "t": "ms"}, t=TIME, q=X, u=X)
    axis = axis_with(time="t", position=Column("q", "", "m", 2.0), effort=Column("u", "kN", "N", shift=5.0))
    result = gather(table, axis)
    assert result.channels["time"].values == pytest.approx(1e-3 * TIME)
    assert result.channels["position"].values == pytest.approx(2e-3 * X)
    assert result.channels["effort"].values == pytest.approx(1e3 * X + 5.0)
    assert [channel.unit for channel in result.channels.values()] == ["s", "m", "N"]
    assert result.problems == []


def test_a_column_without_a_unit_is_read_in_si_with_a_note():
    result = gather(table_of({"q": "m"}, t=TIME, q=X), axis_with(time="t", position="q"))
    assert result.notes == ["column t has no unit: bristle assumes s"]


def test_a_unit_of_the_axis_file_that_contradicts_the_log_is_a_problem():
    axis = axis_with(time="t", position=Column("q", "um", "m"))
    (problem,) = gather(table_of({"q": "mm", "t": "s"}, t=TIME, q=X), axis).problems
    assert "has another unit in the log than in the axis file" in str(problem)
    assert gather(table_of({"q": "um", "t": "s"}, t=TIME, q=X), axis).problems == []
    (problem,) = gather(table_of({"q": "Skt", "t": "s"}, t=TIME, q=X), axis_with(time="t", position="q")).problems
    assert "has an unknown unit" in str(problem)


def test_a_following_error_gives_a_missing_reference():
    axis = axis_with(time="t", position="q", following_error="e")
    units = {"t": "s", "q": "mm", "e": "mm"}
    result = gather(table_of(units, t=TIME, q=X, e=0.1 * X), axis)
    assert result.channels["reference"].values == pytest.approx(1.1e-3 * X)
    assert "following_error" not in result.channels
    both = axis_with(time="t", position="q", following_error="e", reference="r")
    result = gather(table_of(units | {"r": "mm"}, t=TIME, q=X, e=0.1 * X, r=3.0 * X), both)
    assert result.channels["reference"].values == pytest.approx(3e-3 * X)
    assert "bristle ignores the following error in column e, because the log has a reference" in result.notes
    alone = gather(table_of({"t": "s", "v": "m/s", "e": "m"}, t=TIME, v=X, e=X), axis_with(time="t", velocity="v", following_error="e"))
    assert "bristle ignores the following error in column e, because the log has no position" in alone.notes


def test_a_reference_without_a_unit_has_that_of_the_position():
    result = gather(table_of({"t": "s", "q": "mm"}, t=TIME, q=X, r=X), axis_with(time="t", position="q", reference="r"))
    assert result.channels["reference"].values == pytest.approx(1e-3 * X)
    assert "column r has no unit: bristle assumes the unit of the position, mm" in result.notes
    turned = axis_with(time="t", position=Column("q", "", "m", -2.0), reference="r")
    assert gather(table_of({"t": "s", "q": "mm"}, t=TIME, q=X, r=X), turned).channels["reference"].values == pytest.approx(2e-3 * X)
    shared_column = gather(table_of({"t": "s", "q": "mm", "r": "m"}, t=TIME, q=X, r=X), axis_with(time="t", position="q", reference="r"))
    assert shared_column.channels["reference"].values == pytest.approx(X)


def test_columns_used_twice_or_of_different_lengths_are_reported():
    units = {"t": "s", "q": "mm", "u": "N"}
    result = gather(table_of(units, t=TIME, q=X), axis_with(time="t", position="q", effort=Column("q", "", "")))
    assert "column q is used twice, as position and as effort. Check [columns]" in result.notes
    (problem,) = gather(table_of(units, t=TIME, q=X, u=X[:-1]), axis_with(time="t", position="q", effort="u")).problems
    assert "has columns with different numbers of samples (t: 40, q: 40, u: 39)" in str(problem)


def test_an_optional_column_that_is_missing_is_a_note_and_another_one_a_problem():
    units = {"t": "s", "q": "mm", "load_N": "N"}
    result = gather(
        table_of(units, t=TIME, q=X, load_N=X), axis_with(time="t", position="q", effort=Column("load_M", "", "N", optional=True))
    )
    assert result.problems == []
    assert any("optional column load_M is not in this log. If its name is 'load_N'" in note for note in result.notes)
    (problem,) = gather(table_of(units, t=TIME, q=X), axis_with(time="t", position="q", effort="u")).problems
    assert "has no column 'u' for the effort" in str(problem)
    (problem,) = gather(table_of(units, t=TIME, q=X), axis_with(time="t")).problems
    assert "names no column of the position" in str(problem)


def test_channels_with_separate_times_are_interpolated_to_the_position():
    late = TIME + 0.5
    table = table_of({"t": "ms", "t2": "ms", "q": "mm", "u": "N"}, {"q": "t", "u": "t2"}, t=TIME, q=X, t2=late, u=2.0 * late)
    result = gather(table, axis_with(time="t", position="q", effort="u"))
    assert result.channels["time"].values == pytest.approx(1e-3 * TIME[1:])
    assert result.channels["position"].values == pytest.approx(1e-3 * X[1:])
    assert result.channels["effort"].values == pytest.approx(2.0 * TIME[1:])
    assert "bristle ignores 1 sample, because some channels were not recorded at these times" in result.notes
    assert any("bristle ignores columns.time, because each column of this MF4 file has its own time" in note for note in result.notes)
    (finding,) = result.findings
    assert finding.code == "resampled"
    assert finding.numbers["percent"] == 100.0
    assert finding.numbers["sample_time"] == finding.numbers["own_sample_time"] == pytest.approx(1e-3)
    assert finding.numbers["error_percent"] == pytest.approx(0.0, abs=1e-6)


def test_a_channel_with_the_times_of_the_position_stays_unchanged():
    fast = np.arange(0.0, 40.0, 0.5)
    table = table_of({"t": "s", "t2": "s", "q": "mm", "u": "N"}, {"q": "t", "u": "t2"}, t=TIME, q=X, t2=fast, u=np.arange(80.0))
    result = gather(table, axis_with(position="q", effort="u"))
    assert result.channels["effort"].values.tolist() == np.arange(0.0, 80.0, 2.0).tolist()
    assert result.findings == []
    assert result.channels["time"].values == pytest.approx(TIME)


def test_a_contradicting_unit_in_the_name_of_the_effort_is_reported():
    units = {"t": "s", "q": "m", "u_kN": "N"}
    result = gather(table_of(units, t=TIME, q=X, u_kN=X), axis_with(time="t", position="q", effort="u_kN"))
    assert [finding.numbers for finding in result.findings] == [{"column": "u_kN", "called": "kN", "declared": "N"}]
    declared = axis_with(time="t", position=Column("q_mm", "m", "m"))
    assert gather(table_of({"t": "s"}, t=TIME, q_mm=X), declared).findings == []


def test_without_an_axis_file_usual_names_identify_the_columns():
    axis = axis_of(table_of({"Pos": "deg"}, T=TIME, Pos=X, torque=X))
    assert axis.kind == "rotational"
    assert {channel: column.name for channel, column in axis.columns.items()} == {"time": "T", "position": "Pos", "effort": "torque"}
    assert axis.columns["effort"].base == "N*m"
    assert axis_of(table_of({"v": "m/s"}, t=TIME, v=X)).kind == "translational"
    with pytest.raises(InputError, match="has no column with a usual name of a position"):
        axis_of(table_of(t=TIME, height=X))

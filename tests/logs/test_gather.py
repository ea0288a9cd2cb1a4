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
    made = {
        name: entry if isinstance(entry, Column) else Column(entry, "", bases.get(name, "m"))
        for name, entry in columns.items()
    }
    return Axis(kind=kind, columns=made)


SECONDS, MM = {"t": "s", "q": "m"}, {"t": "s", "q": "mm"}
PLAIN = {"t": TIME, "q": X}


@pytest.mark.parametrize(
    ("units", "columns", "named", "values"),
    [
        (
            {"q": "mm", "t": "ms"},
            PLAIN | {"u": X},
            {
                "time": "t",
                "position": Column("q", "", "m", 2.0),
                "effort": Column("u", "kN", "N", shift=5.0),
            },
            {"time": 1e-3 * TIME, "position": 2e-3 * X, "effort": 1e3 * X + 5.0},
        ),
        # A following error gives a missing reference.
        (
            MM | {"e": "mm"},
            PLAIN | {"e": 0.1 * X},
            {"position": "q", "following_error": "e"},
            {"position": 1e-3 * X, "reference": 1.1e-3 * X},
        ),
        (
            MM | {"e": "mm", "r": "mm"},
            PLAIN | {"e": 0.1 * X, "r": 3.0 * X},
            {"position": "q", "following_error": "e", "reference": "r"},
            {"position": 1e-3 * X, "reference": 3e-3 * X},
        ),
        # A reference without a unit has that of the position.
        (
            MM,
            PLAIN | {"r": X},
            {"position": "q", "reference": "r"},
            {"position": 1e-3 * X, "reference": 1e-3 * X},
        ),
        (
            MM,
            PLAIN | {"r": X},
            {"position": Column("q", "", "m", -2.0), "reference": "r"},
            {"position": -2e-3 * X, "reference": 2e-3 * X},
        ),
        (
            MM | {"r": "m"},
            PLAIN | {"r": X},
            {"position": "q", "reference": "r"},
            {"position": 1e-3 * X, "reference": X},
        ),
        # The axis file outranks the log, for a reference with the same header, too.
        (
            MM | {"r": "mm"},
            PLAIN | {"r": X},
            {"position": Column("q", "um", "m"), "reference": "r"},
            {"position": 1e-6 * X, "reference": 1e-6 * X},
        ),
        ({"q": "N"}, PLAIN, {"position": Column("q", "mm", "m")}, {"position": 1e-3 * X}),
    ],
)
def test_channels_are_in_si_with_scale_and_shift(units, columns, named, values):
    result = gather(table_of(units, **columns), axis_with(**{"time": "t"} | named))
    assert {
        name: channel.values.tolist() for name, channel in result.channels.items() if name in values
    } == {name: pytest.approx(expected) for name, expected in values.items()}
    assert {name: channel.unit for name, channel in result.channels.items()} == {"time": "s"} | {
        name: "N" if name == "effort" else "m" for name in values if name != "time"
    }
    assert result.problems == []


@pytest.mark.parametrize(
    ("units", "columns", "named", "note"),
    [
        ({"q": "m"}, PLAIN, {"position": "q"}, "column t has no unit: bristle assumes s"),
        (
            MM | {"e": "mm", "r": "mm"},
            PLAIN | {"e": X, "r": X},
            {"position": "q", "following_error": "e", "reference": "r"},
            "bristle ignores the following error in column e, because the log has a reference",
        ),
        (
            {"t": "s", "v": "m/s", "e": "m"},
            {"t": TIME, "v": X, "e": X},
            {"velocity": "v", "following_error": "e"},
            "bristle ignores the following error in column e, because the log has no position",
        ),
        (
            MM,
            PLAIN | {"r": X},
            {"position": "q", "reference": "r"},
            "column r has no unit: bristle assumes the unit of the position, mm",
        ),
        (
            MM,
            PLAIN,
            {"position": "q", "effort": Column("q", "", "")},
            "column q is used twice, as position and as effort. Check [columns]",
        ),
        (
            MM | {"load_N": "N"},
            PLAIN | {"load_N": X},
            {"position": "q", "effort": Column("load_M", "", "N", optional=True)},
            "optional column load_M is not in this log. If its name is 'load_N', write this name in the axis file",
        ),
        (
            MM,
            PLAIN,
            {"position": Column("q", "um", "m")},
            "column q has the unit 'mm' in the log, but um in the axis file: bristle uses um",
        ),
    ],
)
def test_assumptions_and_ignored_columns_are_noted(units, columns, named, note):
    assert note in gather(table_of(units, **columns), axis_with(**{"time": "t"} | named)).notes


@pytest.mark.parametrize(
    ("units", "columns", "named", "words"),
    [
        ({"t": "s", "q": "Skt"}, PLAIN, {"position": "q"}, "has the wrong unit; found 'Skt'"),
        (
            MM | {"v": "Hz"},
            PLAIN | {"v": X},
            {"position": "q", "velocity": Column("v", "", "rad/s")},
            'in the axis file, such as unit = "rev/s"',
        ),
        (
            MM | {"u": "%"},
            PLAIN | {"u": X},
            {"position": "q", "effort": "u"},
            'in the axis file, such as unit = "%"',
        ),
        (
            MM,
            PLAIN | {"u": X},
            {"position": "q", "effort": Column("u", "", "rated")},
            "allowed rated, or a unit that converts to it",
        ),
        (
            MM | {"u": "N"},
            PLAIN | {"u": X[:-1]},
            {"position": "q", "effort": "u"},
            "has columns with different numbers of samples (t: 40, q: 40, u: 39)",
        ),
        (MM, PLAIN, {"position": "q", "effort": "u"}, "has no column 'u' for the effort"),
        (MM, PLAIN, {}, "names no column of the position"),
    ],
)
def test_columns_that_cannot_be_used_are_a_problem(units, columns, named, words):
    (problem,) = gather(table_of(units, **columns), axis_with(**{"time": "t"} | named)).problems
    assert words in str(problem)


def test_channels_with_separate_times_are_interpolated_to_the_position():
    late = TIME + 0.5
    table = table_of(
        {"t": "ms", "t2": "ms", "q": "mm", "u": "N"},
        {"q": "t", "u": "t2"},
        t=TIME,
        q=X,
        t2=late,
        u=2.0 * late,
    )
    result = gather(table, axis_with(time="t", position="q", effort="u"))
    assert [channel.values.tolist() for channel in result.channels.values()] == [
        pytest.approx(1e-3 * TIME[1:]),
        pytest.approx(1e-3 * X[1:]),
        pytest.approx(2.0 * TIME[1:]),
    ]
    assert "bristle ignores 1 sample at the ends, where column u has no values" in result.notes
    assert any(
        "bristle ignores columns.time, because each column of this MF4 file has its own time"
        in note
        for note in result.notes
    )
    (finding,) = result.findings
    assert (finding.code, finding.numbers["percent"]) == ("resampled", 100.0)
    assert (
        finding.numbers["sample_time"] == finding.numbers["own_sample_time"] == pytest.approx(1e-3)
    )
    assert finding.numbers["error_percent"] == pytest.approx(0.0, abs=1e-6)


def test_a_channel_with_the_times_of_the_position_stays_unchanged():
    fast = np.arange(0.0, 40.0, 0.5)
    table = table_of(
        {"t": "s", "t2": "s", "q": "mm", "u": "N"},
        {"q": "t", "u": "t2"},
        t=TIME,
        q=X,
        t2=fast,
        u=np.arange(80.0),
    )
    result = gather(table, axis_with(position="q", effort="u"))
    assert (result.channels["effort"].values.tolist(), result.findings) == (
        np.arange(0.0, 80.0, 2.0).tolist(),
        [],
    )
    assert result.channels["time"].values == pytest.approx(TIME)


def test_a_contradicting_unit_in_the_name_of_the_effort_is_reported():
    units = {"t": "s", "q": "m", "u_kN": "N"}
    result = gather(
        table_of(units, t=TIME, q=X, u_kN=X), axis_with(time="t", position="q", effort="u_kN")
    )
    assert [finding.numbers for finding in result.findings] == [
        {"column": "u_kN", "called": "kN", "declared": "N"}
    ]
    declared = axis_with(time="t", position=Column("q_mm", "m", "m"))
    assert gather(table_of({"t": "s"}, t=TIME, q_mm=X), declared).findings == []


def test_without_an_axis_file_usual_names_identify_the_columns():
    axis = axis_of(table_of({"Pos": "deg"}, T=TIME, Pos=X, torque=X))
    assert {channel: column.name for channel, column in axis.columns.items()} == {
        "time": "T",
        "position": "Pos",
        "effort": "torque",
    }
    assert (axis.kind, axis.columns["effort"].base) == ("rotational", "N*m")
    assert axis_of(table_of({"v": "m/s"}, t=TIME, v=X)).kind == "translational"
    with pytest.raises(InputError, match="has no column with a usual name of a position"):
        axis_of(table_of(t=TIME, height=X))


@pytest.mark.parametrize(("gear", "is_noted"), [(None, True), (60.0, False), (1.0, False)])
def test_an_axis_file_without_a_gear_means_a_direct_drive(gear, is_noted):
    columns = {"position": Column("q", "rad", "rad"), "effort": Column("u", "%", "rated", 1.3)}
    notes = gather(
        table_of(q=X, u=X), Axis(kind="rotational", columns=columns, arm=1.0, gear=gear)
    ).notes
    assert (
        "the axis file states no gear_ratio: bristle takes the effort in column u as that of a direct drive"
        in " ".join(notes)
    ) is is_noted

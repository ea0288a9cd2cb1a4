"""Texts whose rows bring stamps: facts above the columns, dates, counts, columns with times of their own, archives."""

from pathlib import Path

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.layout import Layout, cells_of, is_number, layout_of, numbers_in
from bristle.logs.stamped_text import (
    amount_in,
    facts_above,
    head_of,
    is_archive,
    partly_empty,
    read_archive,
    read_scope,
    stamps_in,
    stated_period,
    units_of_labview,
    with_own_times,
)
from bristle.logs.table import ALL, Choice, Request

REQUEST = Request(Path("log.csv"), None, ALL, 2**20)


def layout(*names, numeric=None, first=1, comma=False, units=None):
    numeric = (True,) * len(names) if numeric is None else numeric
    return Layout(";", comma, first, numeric, names, units or ("",) * len(names))


def lists(table):
    """The numbers of each column by its name, and the times of each column that has its own."""
    return {name: values.tolist() for name, values in table.columns.items()}, {
        name: table.columns[time].tolist() for name, time in table.stamps.items()
    }


def test_lines_above_a_header_are_facts():
    lines = [
        "# Device: AX5000",
        '"Rated torque [Nm]";"2,4"',
        "",
        "Date = today;now",
        "x",
        "t;q",
        "0;1",
    ]
    facts = facts_above(lines, layout("t", "q", first=6))
    assert facts == {"Device": "AX5000", "Rated torque [Nm]": "2,4", "Date": "today now"}
    assert facts_above(lines, layout("t", "q", first=0)) == {}
    assert facts_above(["Sample period 2 ms", "1;2"], layout("column_1", "column_2")) == {
        "Sample period": "2 ms"
    }


@pytest.mark.parametrize(
    ("facts", "period"),
    [
        ({"Sample time": "2 ms"}, 2e-3),
        ({"Abtastzeit [us]": "250"}, 2.5e-4),
        ({"sample_rate": "2,5 kHz"}, 4e-4),
        ({"fs": "500"}, 2e-3),
        ({"dt": "0.5"}, 0.5),
        ({"dt": "0"}, None),
        ({"dt": "5 mm"}, None),
        ({"fs": "many"}, None),
        ({"name": "5 ms"}, None),
        ({"dt": "5 mm", "Takt": "3 ms"}, 3e-3),
        ({"Sample Period": "2 ms", "Scan rate": "500 samples per second"}, 2e-3),
        # The others are no sampling.
        ({"Sampling Rate": "500 S/s", "Recording time": "20 s", "Period": "1 s"}, 2e-3),
        ({"Sample time": "2 ms", "Trace cycle": "4 ms"}, None),
        # A comma of thousands, as no axis is sampled at 1 Hz.
        ({"Sampling rate": "1,000 Hz"}, 1e-3),
        ({"Sampling rate": "10,000 Hz"}, None),
    ],
)
def test_the_sample_time_is_stated_as_a_time_or_a_rate(facts, period):
    assert stated_period(facts) == (pytest.approx(period) if period else None)


@pytest.mark.parametrize(
    ("name", "text", "amount"),
    [
        ("Rated torque [Nm]", "2.4 mNm", (2.4, "mN*m")),
        ("speed", "-3e2", (-300.0, "")),
        ("x", "1.2.3", None),
        ("x", "about 3", None),
    ],
)
def test_an_amount_has_the_unit_behind_it_or_that_of_its_name(name, text, amount):
    assert amount_in(name, text) == amount


def test_units_of_labview_are_in_a_separate_row():
    lines = ["Y_Unit_Label;mm;N;", "X_Value;pos;force;Comment"]
    assert units_of_labview(lines, layout("X_Value", "pos", "force", first=2)) == {
        "pos": "mm",
        "force": "N",
    }
    assert units_of_labview(lines[1:], layout("X_Value", "pos", first=1)) == {}


@pytest.mark.parametrize(
    ("body", "numeric", "stamps"),
    [
        (
            "2024-03-01 23:59:59.5;23:59:59;1700000000000000000;7\n2024-03-02 00:00:01;00:00:01;1700000000250000000;7\n",
            (False, False, True, True),
            {0: [0.0, 1.5], 1: [0.0, 2.0], 2: [0.0, 0.25]},
        ),
        ("1.3.2024 9:05:00,5;x\n01.03.2024 09:05:02;x\n", (False, False), {0: [0.0, 1.5]}),
        # The clock stands still.
        ("2024-03-01 10:00:00;1\n2024-03-01 10:00:00;2\n", (False, True), {}),
    ],
)
def test_dates_times_of_day_and_counts_are_seconds_from_the_first_row(body, numeric, stamps):
    names = ("date", "clock", "time", "q")[: len(numeric)]
    result = stamps_in(body.encode(), layout(*names, numeric=numeric), "utf-8")
    assert {place: values.tolist() for place, values in result.items()} == stamps


@pytest.mark.parametrize(
    ("count", "per_second"),
    [("1700000000", 1.0), ("1700000000000", 1e3), ("1700000000000000", 1e6), ("1" * 19, 1e9)],
)
def test_digits_distinguish_counts_since_an_epoch(count, per_second):
    body = f"{count}.5;1\n{int(count) + 4}.5;2\n"
    assert stamps_in(body.encode(), layout("time", "q"), "utf-8")[0] == pytest.approx(
        [0.0, 4.0 / per_second]
    )


@pytest.mark.parametrize("body", [b"170000000;1\n170000003;2\n", b"999999998;1\n1000000001;2\n"])
def test_fewer_digits_in_the_first_row_are_no_count_since_an_epoch(body):
    assert stamps_in(body, layout("time", "q"), "utf-8") == {}


def test_columns_that_end_early_are_empty_cells():
    columns = partly_empty(b"0;1;5\n1;2\n2;3;\n3;4;\n", layout("t", "q", "u"), "utf-8")
    np.testing.assert_array_equal(
        [columns[1], columns[2]], [[1.0, 2.0, 3.0, 4.0], [5.0, np.nan, np.nan, np.nan]]
    )
    comma = partly_empty(b"0,5;1\n1,5;\n", layout("t", "q", comma=True), "utf-8")
    assert comma[0].tolist() == [0.5, 1.5]
    # Of ten: no column that ends early.
    one_missing = "".join(f"{k};{'' if k == 3 else k}\n" for k in range(10))
    assert [
        partly_empty(body, layout("t", "q"), "utf-8")
        for body in (b"0;1\n1;x\n", one_missing.encode())
    ] == [None, None]


def test_columns_belong_to_the_time_on_their_left():
    times, late = np.arange(6.0), 0.5 + np.arange(6.0)
    columns = {
        0: times,
        1: times**2,
        2: np.append(late[:4], [np.nan, np.nan]),
        3: np.append(late[:4], [np.nan, np.nan]),
    }
    table = with_own_times(
        columns,
        layout("time", "q", "time_2", "u", units=("ms", "mm", "", "N")),
        REQUEST,
        ("noted",),
    )
    values, stamps = lists(table)
    assert values["u"] == stamps["u"] == [0.5, 1.5, 2.5, 3.5]
    assert stamps["q"] == times.tolist()
    assert (table.units["q"], table.units[table.stamps["q"]]) == ("mm", "ms")
    assert (table.numbers["column_4"], table.notes) == ("u", ("noted",))
    assert with_own_times({0: times, 1: times**2}, layout("time", "q"), REQUEST, ()) is None
    sparse = {0: times, 1: np.array([1.0, np.nan, 3.0, np.nan, 5.0, np.nan])}
    assert lists(with_own_times(sparse, layout("time", "q"), REQUEST, ()))[0]["q"] == [
        1.0,
        3.0,
        5.0,
    ]


SCOPE = """File;trace.csv
Start;now

Name;ActPos;Name;ActTorque
SampleTime[ms];2;SampleTime[ms];1
Unit;(mm);Unit;(None)
ScaleFactor;1;ScaleFactor;0.5

0;1,5;0;10
2;2,5;1;20
;;2;30
EOF
"""


def test_a_trace_of_twincat_has_a_time_column_for_each_channel():
    lines = SCOPE.splitlines()
    head = head_of(lines)
    assert (head.delimiter, lines[head.first], head.facts) == (
        ";",
        "0;1,5;0;10",
        {"File": "trace.csv", "Start": "now"},
    )
    assert (head.of("unit", 1), head.of("unit", 9), head.of("offset", 1)) == ("(mm)", "", "")
    table = read_scope([*lines, ""], head, REQUEST)
    values, stamps = lists(table)
    assert (values["ActPos"], values["ActTorque"]) == ([1.5, 2.5], [10.0, 20.0, 30.0])
    assert stamps == {"ActPos": [0.0, 2.0], "ActTorque": [0.0, 1.0, 2.0]}
    assert table.units == {
        "ActPos": "mm",
        table.stamps["ActPos"]: "ms",
        table.stamps["ActTorque"]: "ms",
    }
    assert table.notes == (
        "the ScaleFactor of ActTorque is not applied, because the export may have applied it already",
    )
    cut = read_scope([*lines[:-2], ";;2;3"], head, REQUEST)
    assert lists(cut)[0]["ActTorque"] == [10.0, 20.0]
    assert any("does not end with a line break" in note for note in cut.notes)
    assert head_of(["t;q", "0;1"]) is None


def test_a_trace_without_times_has_those_of_its_sample_time():
    lines = ["Name;A;B", "SampleTime[ms];2;4", "Unit;mm;N", "1;10", "2;20", "3;30", ""]
    values, stamps = lists(read_scope(lines, head_of(lines), REQUEST))
    assert values["A"] == [1.0, 2.0, 3.0]
    assert stamps == {"A": [0.0, 2.0, 4.0], "B": [0.0, 4.0, 8.0]}


LINES = [f"{name} {2.0 * k + (name == 'u')} {k},5 GOOD" for k in range(6) for name in ("q", "u")]
DATED = [f"q,2024-03-01 10:00:{k:02d}.5,{k}" for k in range(10)] + ["u,2024-03-01 10:00:00.0,3"]


def test_an_archive_has_a_line_for_each_value_of_a_signal():
    table = read_archive([*LINES, "# end", "what is this"], REQUEST)
    values, stamps = lists(table)
    assert values["q"] == [0.5, 1.5, 2.5, 3.5, 4.5, 5.5]
    assert stamps == {"q": [0.0, 2.0, 4.0, 6.0, 8.0, 10.0], "u": [1.0, 3.0, 5.0, 7.0, 9.0, 11.0]}
    assert table.notes == (
        "bristle ignores 1 lines without a value of a signal",
        "bristle ignores the text behind the values",
    )


def test_dates_of_an_archive_are_seconds_and_a_choice_is_one_of_signals():
    assert lists(read_archive(DATED, REQUEST))[1]["q"] == [0.5 + k for k in range(10)]
    chosen = read_archive(DATED, REQUEST._replace(choice=Choice(frozenset({"u"}))))
    assert list(chosen.stamps) == ["u"]


def test_few_lines_other_cells_and_many_signals_are_no_archive():
    assert [is_archive(lines) for lines in (LINES[:9], ["1;2;3"] * 12)] == [False, False]
    with pytest.raises(InputError, match="names 1001 signals"):
        read_archive([f"s{k} 0 1" for k in range(1001)], REQUEST)


@pytest.mark.parametrize(
    ("call", "value"),
    [
        (lambda: cells_of('a; "b;c" ;"d"', ";"), ["a", "b;c", "d"]),
        (lambda: cells_of('a "b" c', None), ["a", "b", "c"]),
        (lambda: [is_number(cell, True) for cell in ("1,5", "1.5")], [True, True]),
        (
            lambda: [is_number(cell, False) for cell in ("1,5", "1D3", "-.5", "")],
            [False, True, True, False],
        ),
        (
            lambda: [
                is_number(cell, True) for cell in (",5", ".5", "NaN", "+inf", "Infinity", "1.#IND")
            ],
            [True] * 6,
        ),
        (
            lambda: [
                is_number(cell, False) for cell in ("time", "x1", "none", "item", "1_000", "\u0663")
            ],
            [False] * 6,
        ),
        (lambda: numbers_in(["an", "Off"], False), None),
        (lambda: numbers_in(["on", "Off", "TRUE", "2"], False).tolist(), [1.0, 0.0, 1.0, 2.0]),
    ],
)
def test_cells_are_parted_outside_of_quotes_and_numbers_in_any_notation(call, value):
    assert call() == value


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (
            ["t;q;word", "s;mm;", "0,5;1,5;a", "1,5;2,5;b", "2,5;3,5;c"],
            Layout(";", True, 2, (True, True, False), ("t", "q", "word"), ("s", "mm", "")),
        ),
        (
            ["position in mm, force/N, speed", "0,1,2", "1,2,3", "2,3,4"],
            Layout(
                ",",
                False,
                1,
                (True, True, True),
                ("position in mm", "force/N", "speed"),
                ("mm", "N", ""),
            ),
        ),
        (
            ["0 1", "1 2", "2 3"],
            Layout(None, False, 0, (True, True), ("column_1", "column_2"), ("", "")),
        ),
        (
            [";column_1", "0;1", "1;2", "2;3"],
            Layout(";", False, 1, (True, True), ("column_1_", "column_1"), ("", "")),
        ),
    ],
)
def test_the_layout_with_most_numbers_wins(lines, expected):
    assert layout_of(lines, Path("a.csv")) == expected

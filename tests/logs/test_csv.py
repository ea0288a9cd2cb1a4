"""The dialects of text files, and what is refused in them."""

from __future__ import annotations

import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from bristle.core.content import SIZE_LIMIT
from bristle.core.errors import InputError
from bristle.logs import csv
from bristle.logs.csv import _without_open_end
from bristle.logs.layout import Layout
from bristle.logs.table import ALL, Request, Table

HERE = Path("log.csv")


def read_csv(data: bytes, source: Path) -> Table:
    return csv.read_csv(data, Request(source, None, ALL, SIZE_LIMIT))


T = np.arange(30) * 0.5
X = np.linspace(-3.0, 4.0, 30)


def rows(delimiter=",", form="{:.4f}", comma=False):
    lines = [delimiter.join(form.format(cell) for cell in row) for row in zip(T, X, strict=True)]
    text = "\n".join(lines) + "\n"
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize(
    ("delimiter", "comma"),
    [
        (",", False),
        (";", False),
        (";", True),
        ("\t", False),
        ("\t", True),
        (" ", False),
        ("   ", True),
        (", ", False),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_every_dialect_holds_the_same_numbers(delimiter, comma, newline):
    text = delimiter.join(("t", "x")) + "\n" + rows(delimiter, comma=comma)
    table = read_csv(text.replace("\n", newline).encode(), HERE)
    assert list(table.columns) == ["t", "x"]
    np.testing.assert_allclose(table.columns["t"], T, atol=1e-12)
    np.testing.assert_allclose(table.columns["x"], X, atol=5.1e-5)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
def test_encodings_and_units_in_the_header(encoding):
    text = "Zeit [s];Größe (µm)\n" + rows(";")
    table = read_csv(text.encode(encoding), HERE)
    assert table.units == {"Zeit": "s", "Größe": "µm"}


@pytest.mark.parametrize(
    ("preamble", "names"),
    [
        ("", ["column_1", "column_2"]),
        ("t,x\n", ["t", "x"]),
        ("1_1,2_1\n", ["1_1", "2_1"]),  # which Python reads as 11 and 21
        ("\u0661,\u0662\n", ["\u0661", "\u0662"]),
        ("# t,x\n", ["t", "x"]),
        ('"t","x"\n', ["t", "x"]),
        ("t,x\n\n", ["t", "x"]),
        ("Drive export\nDate,2024-05-01\nRate,1000\nScale,0.5,0.25\n\nt,x\n", ["t", "x"]),
        ("t,x\n# from here on the recording\n", ["t", "x"]),
        ("t,t\n", ["t", "t_2"]),
        (",column_1\n", ["column_1_", "column_1"]),
        ("operator,Smith\nt,m\n", ["t", "m"]),
        ("sep=,\nt,x\n", ["t", "x"]),
    ],
)
def test_headers_and_preambles(preamble, names):
    table = read_csv((preamble + rows()).encode(), HERE)
    assert list(table.columns) == names
    assert all(column.size == T.size for column in table.columns.values())


LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\n"
    "Channels\t1\t\nSamples\t30\t\nDelta_X\t0.500000\t\n"
)


@pytest.mark.parametrize(
    ("text", "names", "units"),
    [
        ("time;travel\ns;mm\n" + rows(";"), ["time", "travel"], {"time": "s", "travel": "mm"}),
        # Where blanks separate
        (
            "# time [s]  actual (um)\n" + rows("  "),
            ["time", "actual"],
            {"time": "s", "actual": "um"},
        ),
        # A delimiter at the end of each row.
        ("t;x\n" + rows(";").replace("\n", ";\n"), ["t", "x"], {}),
        (
            LABVIEW
            + "X0\t0.0E+0\t\n***End_of_Header***\t\t\nX_Value\tForce\tComment\n"
            + rows("\t").replace("\n", "\t\n"),
            ["X_Value", "Force"],
            {},
        ),
    ],
)
def test_names_and_units_of_other_heads(text, names, units):
    table = read_csv(text.encode(), HERE)
    assert (list(table.columns), table.units) == (names, units)
    assert [column.size for column in table.columns.values()] == [T.size] * 2


def test_comments_and_blank_lines_between_rows_are_skipped():
    lines = ("t,x\n" + rows()).split("\n")
    text = "\n".join([*lines[:9], "# a remark, with a comma", "", *lines[9:]])
    assert read_csv(text.encode(), HERE).columns["x"].size == X.size


@pytest.mark.parametrize("delimiter", [",", "\t", ";"])
def test_rows_of_empty_cells_are_blank_lines_and_a_remark_may_follow_a_row(delimiter):
    lines = rows(delimiter).split("\n")
    empty = 3 * delimiter
    lines = [
        line.replace(delimiter, f"{delimiter}0{delimiter}7{delimiter}", 1) for line in lines if line
    ]
    lines[0] += " # begun"
    for at in (0, 5, 20):
        lines.insert(at, empty)
    table = read_csv(("\n".join([*lines, empty, empty]) + "\n").encode(), HERE)
    np.testing.assert_allclose(table.columns["column_1"], T, atol=1e-4)
    np.testing.assert_allclose(table.columns["column_4"], X, atol=1e-4)


def test_numbers_of_fortran_and_of_old_windows_are_read_correctly():
    cells = ["1.5D-3", "-2.5d+01", "1.#QNAN", "-1.#IND", "1.#INF", "-1.#INF00", "3E2", "NaN"]
    text = "t,x\n" + "".join(f"{k},{cell}\n" for k, cell in enumerate(cells))
    result = read_csv(text.encode(), HERE).columns["x"]
    np.testing.assert_array_equal(
        result, [1.5e-3, -25.0, np.nan, np.nan, np.inf, -np.inf, 300.0, np.nan]
    )


@pytest.mark.parametrize(
    "cell", ["2#3", "1.5#", "\u0661\u0662", "1_000", "0x1F", "--1", "1.5.2", "1e5e5"]
)
def test_a_cell_that_is_no_number_is_named_and_never_read_by_half(cell):
    text = "t,x\n" + "".join(f"{k},{cell if k == 25 else k}\n" for k in range(30))
    with pytest.raises(InputError, match=r"line 27, column 'x': is not a number") as caught:
        read_csv(text.encode(), HERE)
    assert caught.value.value == cell


@pytest.mark.parametrize("line", [2, 5, 29])
@pytest.mark.parametrize(
    ("cell", "said"),
    [("abc", "is not a number"), ("", "is empty"), ("1,5", "has 3 cells"), ("0.1.2", "is not a")],
)
def test_a_bad_cell_is_named_with_line_and_column(line, cell, said):
    lines = ("t,x\n" + rows()).split("\n")
    lines[line] = lines[line].split(",")[0] + f",{cell}"
    with pytest.raises(InputError, match=said) as caught:
        read_csv("\n".join(lines).encode(), HERE)
    assert f"line {line + 1}" in caught.value.path


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ('"1.234,5"', "is a number with thousands separators"),
        ('"1,234.5"', "is a number with thousands separators"),
        ("00:00:01.250", "is a time of day"),
        ("off", "is not a number"),
    ],
)
def test_a_column_of_malformed_numbers_is_refused_on_request(cell, said):
    text = "t,x\n" + "".join(f"{t},{cell}\n" for t in T)
    error = read_csv(text.encode(), HERE).missing("x", "position")
    assert str(error).startswith(
        f"log.csv: line 2, column 'x': {said}, but the axis needs the column as the position; found"
    )
    assert (error.value, bool(error.mend)) == (cell.strip('"'), True)


QUOTED = ("t,x\n" + rows()).replace("\n4.0000,-1.0690\n", '\n4.0000,"1.234,5"\n')
STATES = "t,x,state\n" + "".join(
    f"{t},{x},{s}\n" for t, x, s in zip(T, X, ["0"] * 4 + ["OK"] * 26, strict=True)
)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        *(
            (text.encode(), "holds no rows of numbers")
            for text in ("", "no numbers\nat all\n", "t,x\n", "t,x\n1,2\n", "1,2\n")
        ),
        (b"\x01\x02\0\0" * 50, "neither text nor"),
        (QUOTED.encode(), r"line 10, column 'x': is a number with thousands separ"),
        (STATES.encode(), "line 5, column 'state': is a number, but the cells below it are text"),
    ],
)
def test_text_without_whole_columns_of_numbers_is_refused(data, words):
    with pytest.raises(InputError, match=words):
        read_csv(data, HERE)


@given(cut=st.integers(1, len(rows().encode()) + 3))
def test_a_file_cut_anywhere_is_refused_or_its_whole_rows_are_read(cut):
    whole = ("t,x\n" + rows()).encode()
    part = whole[:cut]
    try:
        table = read_csv(part, HERE)
    except InputError as refusal:
        assert re.search("truncated|is incomplete|no rows of numbers", str(refusal))  # noqa: PT017
        return
    count = part.count(b"\n") - 1
    np.testing.assert_array_equal(table.columns["t"], T[:count])
    if not part.endswith(b"\n"):
        assert "its last row, which may be incomplete" in table.notes[-1]


@pytest.mark.slow
def test_a_million_rows_are_read_in_seconds():
    text = "t,q,r,u\n" + "0.001,1.25,1.5,-3.75\n" * 1_000_000
    start = time.perf_counter()
    table = read_csv(text.encode(), HERE)
    assert table.columns["u"].size == 1_000_000
    assert time.perf_counter() - start < 10


def test_the_size_limit_covers_channels_with_separate_times():
    lines = ["t1,a,t2,b", *(f"{0.1 * k},{k},{0.2 * k},{-k}" for k in range(20))]
    data = ("\n".join(lines) + "\n").encode()
    assert read_csv(data, HERE).columns["b"].size == 20
    with pytest.raises(InputError, match="more than the limit"):
        csv.read_csv(data, Request(HERE, None, ALL, 100))


@pytest.mark.parametrize(
    ("body", "numeric", "is_whole"),
    [
        (b"0;12\n1;34", (True, True), True),
        (b"0;12\n1;3", (True, True), False),  # shorter than any before
        (b"0;1\n0;12\n1;3", (True, True), True),
        (b"0;12\n1", (True, True), False),
        (b"0;12\n1;34;5", (True, True), False),
        (b"0;12\n1;3-", (True, True), False),
        (b"0;off\n1;off", (True, False), True),
        (b"0;off\n1;of", (True, False), False),
        (b"0;na\n\n1;na", (True, True), True),  # no number, and there before
    ],
)
def test_a_last_row_without_a_line_break_is_left_out_and_a_cut_row_is_refused(
    body, numeric, is_whole
):
    layout = Layout(";", False, 4, numeric, ("t", "q"), ("", ""))
    assert _without_open_end(body + b"\n", layout, Path("log.csv"), "utf-8") == (body + b"\n", [])
    if is_whole:
        kept, (note,) = _without_open_end(body, layout, Path("log.csv"), "utf-8")
        assert kept == body[: body.rindex(b"\n") + 1]
        assert "bristle ignores its last row, which may be incomplete" in note
    else:
        with pytest.raises(
            InputError,
            match=rf"line {5 + body.count(10)}: is incomplete: the file ends within this row",
        ):
            _without_open_end(body, layout, Path("log.csv"), "utf-8")


@pytest.mark.parametrize("blank", ["", "\n", "  \n\n"])
def test_dates_behind_blank_lines_are_seconds_from_the_first(blank):
    lines = "".join(f"2026-02-01 09:00:{k:02d};{k}\n" for k in range(20))
    table = read_csv(f"time;x\n{blank}{lines}".encode(), HERE)
    np.testing.assert_array_equal(table.columns["time"], np.arange(20.0))

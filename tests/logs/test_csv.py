"""The dialects of text files, and what is refused in them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bristle.core.content import SIZE_LIMIT
from bristle.core.errors import InputError
from bristle.logs import csv
from bristle.logs.csv import _without_open_end
from bristle.logs.layout import Layout
from bristle.logs.table import ALL, Request, Table, split_unit

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
    [(",", False), (";", False), (";", True), ("\t", False), ("\t", True), (" ", False), ("   ", True), (", ", False)],
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


def test_a_row_of_units_below_the_names():
    table = read_csv(("time;travel\ns;mm\n" + rows(";")).encode(), HERE)
    assert table.units == {"time": "s", "travel": "mm"}


def test_units_apart_from_names_where_blanks_separate():
    table = read_csv(("# time [s]  actual (um)\n" + rows("  ")).encode(), HERE)
    assert (list(table.columns), table.units) == (["time", "actual"], {"time": "s", "actual": "um"})


def test_a_delimiter_at_the_end_of_each_row():
    table = read_csv(("t;x\n" + rows(";").replace("\n", ";\n")).encode(), HERE)
    assert list(table.columns) == ["t", "x"]


def test_a_labview_measurement_file():
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\nChannels\t1\t\n"
    head += "Samples\t30\t\nDelta_X\t0.500000\t\nX0\t0.0E+0\t\n***End_of_Header***\t\t\nX_Value\tForce\tComment\n"
    body = "".join(f"{t:.6f}\t{x:.6f}\t\n" for t, x in zip(T, X, strict=True))
    table = read_csv((head + body).encode(), HERE)
    assert list(table.columns) == ["X_Value", "Force"]
    assert table.columns["X_Value"].size == T.size


def test_comments_and_blank_lines_between_rows_are_skipped():
    lines = ("t,x\n" + rows()).split("\n")
    text = "\n".join([*lines[:9], "# a remark, with a comma", "", *lines[9:]])
    assert read_csv(text.encode(), HERE).columns["x"].size == X.size


@pytest.mark.parametrize("delimiter", [",", "\t", ";"])
def test_rows_of_empty_cells_are_blank_lines_and_a_remark_may_follow_a_row(delimiter):
    lines = rows(delimiter).split("\n")
    empty = 3 * delimiter
    lines = [line.replace(delimiter, f"{delimiter}0{delimiter}7{delimiter}", 1) for line in lines if line]
    lines[0] += " # begun"
    for at in (0, 5, 20):
        lines.insert(at, empty)
    table = read_csv(("\n".join([*lines, empty, empty]) + "\n").encode(), HERE)
    np.testing.assert_allclose(table.columns["column_1"], T, atol=1e-4)
    np.testing.assert_allclose(table.columns["column_4"], X, atol=1e-4)


def test_numbers_of_fortran_and_of_old_windows_are_read_correctly():
    cells = ["1.5D-3", "-2.5d+01", "1.#QNAN", "-1.#IND", "1.#INF", "-1.#INF00", "3E2", "4"]
    text = "t,x\n" + "".join(f"{k},{cell}\n" for k, cell in enumerate(cells))
    result = read_csv(text.encode(), HERE).columns["x"]
    np.testing.assert_array_equal(result, [1.5e-3, -25.0, np.nan, np.nan, np.inf, -np.inf, 300.0, 4.0])


@pytest.mark.parametrize("cell", ["2#3", "1.5#", "\u0661\u0662", "1_000", "0x1F", "--1", "1.5.2", "1e5e5"])
def test_a_cell_that_is_no_number_is_named_and_never_read_by_half(cell):
    text = "t,x\n" + "".join(f"{k},{cell if k == 25 else k}\n" for k in range(30))
    with pytest.raises(InputError, match=r"line 27, column 'x': is not a number") as caught:
        read_csv(text.encode(), HERE)
    assert caught.value.value == cell


def test_a_text_column_is_left_out_with_a_note():
    text = "date;t;x\n" + "".join(f"01.02.2024;{t};{x}\n" for t, x in zip(T, X, strict=True))
    table = read_csv(text.replace(".", ",").replace("01,02,", "01.02.").encode(), HERE)
    assert list(table.columns) == ["t", "x"]
    assert table.notes == ("bristle ignores columns of text: date",)


@pytest.mark.parametrize("line", [1, 2, 5, 29])
@pytest.mark.parametrize(("cell", "said"), [("abc", "is not a number"), ("", "is empty"), ("1,5", "has 3 cells"), ("0.1.2", "is not a")])
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
    assert str(error).startswith(f"log.csv: line 2, column 'x': {said}, but the axis needs the column as the position; found")
    assert error.value == cell.strip('"')
    assert error.mend


def test_one_quoted_number_with_thousands_separators_is_named_with_line_and_column():
    lines = ("t,x\n" + rows()).split("\n")
    lines[9] = lines[9].split(",")[0] + ',"1.234,5"'
    with pytest.raises(InputError, match=r"line 10, column 'x': is a number with thousands separ"):
        read_csv("\n".join(lines).encode(), HERE)


def test_a_column_that_is_now_a_number_and_now_text_is_refused():
    states = ["0"] * 4 + ["OK"] * 26
    text = "t,x,state\n" + "".join(f"{t},{x},{s}\n" for t, x, s in zip(T, X, states, strict=True))
    with pytest.raises(InputError, match="line 5, column 'state': is a number, but the cells below it are text"):
        read_csv(text.encode(), HERE)


def test_missing_values_that_are_written_reach_the_checks():
    text = ("t,x\n" + rows()).replace("-3.0000", "NaN")
    assert np.isnan(read_csv(text.encode(), HERE).columns["x"][0])


@pytest.mark.parametrize("text", ["", "no numbers\nat all\n", "t,x\n", "t,x\n1,2\n", "1,2\n"])
def test_a_file_without_rows_of_numbers_is_refused(text):
    with pytest.raises(InputError, match="holds no rows of numbers"):
        read_csv(text.encode(), HERE)


def test_binary_content_is_refused():
    with pytest.raises(InputError, match="neither text nor"):
        read_csv(b"\x01\x02\0\0" * 50, HERE)


@given(cut=st.integers(1, len(rows().encode()) + 3))
def test_a_file_cut_anywhere_is_refused_or_its_whole_rows_are_read(cut):
    whole = ("t,x\n" + rows()).encode()
    part = whole[:cut]
    try:
        table = read_csv(part, HERE)
    except InputError as refusal:
        text = str(refusal)
    else:
        text = ""
    if text:
        assert "truncated" in text or "is incomplete" in text or "no rows of numbers" in text
        return
    count = part.count(b"\n") - 1
    np.testing.assert_array_equal(table.columns["t"], T[:count])
    if not part.endswith(b"\n"):
        assert "its last row, which may be incomplete" in table.notes[-1]


def test_a_header_is_split_into_name_and_unit():
    assert split_unit("actual position / mm") == ("actual position", "mm")
    assert split_unit("velocity[rad/s]") == ("velocity", "rad/s")
    assert split_unit("F (N)") == ("F", "N")


@pytest.mark.slow
def test_a_million_rows_are_read_in_seconds():
    import time

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
def test_a_last_row_without_a_line_break_is_left_out_and_a_cut_row_is_refused(body, numeric, is_whole):
    layout = Layout(";", False, 4, numeric, ("t", "q"), ("", ""))
    assert _without_open_end(body + b"\n", layout, Path("log.csv"), "utf-8") == (body + b"\n", [])
    if is_whole:
        kept, (note,) = _without_open_end(body, layout, Path("log.csv"), "utf-8")
        assert kept == body[: body.rindex(b"\n") + 1]
        assert "bristle ignores its last row, which may be incomplete" in note
    else:
        with pytest.raises(InputError, match=rf"line {5 + body.count(10)}: is incomplete: the file ends within this row"):
            _without_open_end(body, layout, Path("log.csv"), "utf-8")


@pytest.mark.parametrize("blank", ["", "\n", "  \n\n"])
def test_dates_behind_blank_lines_are_seconds_from_the_first(blank):
    lines = "".join(f"2026-02-01 09:00:{k:02d};{k}\n" for k in range(20))
    table = read_csv(f"time;x\n{blank}{lines}".encode(), HERE)
    np.testing.assert_array_equal(table.columns["time"], np.arange(20.0))

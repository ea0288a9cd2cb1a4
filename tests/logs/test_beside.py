"""A table of parameters beside the first rows of a text log: no row of the log is lost for it, and it is told."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.readers import read_table

COUNT = 60
T = np.arange(COUNT) / 1000
X = np.round(np.sin(20 * T), 6)
PARAMETERS = [("Mass", "12.5 kg"), ("Lead", "10"), ("Operator", "Smith"), ("Filter", ""), ("Rated torque", "2.4 Nm")]


def log(beside, header="time,position,,Parameter,Value", *, filled=True, units=""):
    """A log with such cells beside its first rows; the other rows have empty cells there, or none."""
    rest = ",,," if filled else ""
    cells = [f",,{name},{value}" for name, value in beside] + [rest] * (COUNT - len(beside))
    rows = [f"{t:.3f},{x:.6f}{more}" for t, x, more in zip(T, X, cells, strict=True)]
    return "\n".join([header, *([units] if units else []), *rows, ""])


def assert_whole(table):
    assert list(table.columns) == ["time", "position"]
    np.testing.assert_array_equal(table.columns["time"], T)
    np.testing.assert_array_equal(table.columns["position"], X)


@pytest.mark.parametrize("count", [1, 5, 18, 30])
@pytest.mark.parametrize("filled", [True, False])
@pytest.mark.parametrize("header", ["time,position,,Parameter,Value", "time,position"])
@pytest.mark.parametrize("dialect", ["comma", "semicolon", "tab", "blanks"])
def test_no_row_is_lost_for_a_table_beside_the_first_ones(count, filled, header, dialect):
    text = log((PARAMETERS * 6)[:count], header, filled=filled)
    if dialect == "semicolon":
        text = text.replace(",", ";").replace(".", ",")
    elif dialect != "comma":
        text = text.replace("12.5 kg", "12.5").replace("Rated torque", "Torque").replace("2.4 Nm", "2.4")
        text = text.replace(",", "\t") if dialect == "tab" else text.replace(",", " ")
    table = read_table(text.encode())
    assert_whole(table)
    rows = f"the first {count} rows" if count > 1 else "the first row"
    assert f"what stands beside {rows} was left out: Mass, 12" in table.notes[0]
    assert table.facts["Mass"].startswith("12")


def test_units_below_the_names_are_kept():
    table = read_table(log(PARAMETERS, filled=False, units="s,mm").encode())
    assert_whole(table)
    assert table.units == {"time": "s", "position": "mm"}


def test_the_sample_time_may_stand_there():
    text = "\n".join(line.split(",", 1)[1] for line in log([("Sample time", "2 ms")]).split("\n")[:-1])
    assert read_table(f"{text}\n".encode()).sample_time == 0.002


def test_a_cell_within_quotes_stays_one():
    text = log(PARAMETERS, filled=False).replace("time,position", '"t, raw",position').replace("Smith", '"Smith, J."')
    table = read_table(text.encode())
    assert list(table.columns) == ["t, raw", "position"]
    assert table.facts["Operator"] == "Smith, J."


def test_columns_of_numbers_that_end_early_are_no_such_table():
    early = [f",{k}.5,{value}" for k, (_, value) in enumerate([("", "Mass"), *[("", "")] * 29])]
    cells = early + [",,"] * (COUNT - len(early))
    rows = [f"{t:.3f},{x:.6f}{more}" for t, x, more in zip(T, X, cells, strict=True)]
    table = read_table("\n".join(["time,position,temperature,note", *rows, ""]).encode())
    np.testing.assert_array_equal(table.columns["temperature"], np.arange(30) + 0.5)
    np.testing.assert_array_equal(table.columns["position"], X)


@pytest.mark.parametrize("filled", [True, False])
def test_a_bad_cell_beside_such_a_table_is_named(filled):
    text = log(PARAMETERS * 3, filled=filled).replace(f"{X[7]:.6f}", "abc")
    with pytest.raises(InputError, match=r"line 9, column .*: is not a number; found 'abc'"):
        read_table(text.encode())

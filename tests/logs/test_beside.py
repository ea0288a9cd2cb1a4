"""A table of parameters beside the first rows of a text log: no row of the log is lost for it, since the file is refused."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.logs.readers import read_table

COUNT = 60
T = np.arange(COUNT) / 1000
X = np.round(np.sin(20 * T), 6)
PARAMETERS = [
    ("Mass", "12.5 kg"),
    ("Lead", "10"),
    ("Operator", "Smith"),
    ("Filter", ""),
    ("Rated torque", "2.4 Nm"),
]


def log(beside, header="time,position,,Parameter,Value", *, filled=True, units=""):
    """A log with such cells beside its first rows; the other rows have empty cells there, or none."""
    rest = ",,," if filled else ""
    cells = [f",,{name},{value}" for name, value in beside] + [rest] * (COUNT - len(beside))
    rows = [f"{t:.3f},{x:.6f}{more}" for t, x, more in zip(T, X, cells, strict=True)]
    return "\n".join([header, *([units] if units else []), *rows, ""])


@pytest.mark.parametrize("count", [1, 5, 18, 30])
@pytest.mark.parametrize("filled", [True, False])
@pytest.mark.parametrize("header", ["time,position,,Parameter,Value", "time,position"])
@pytest.mark.parametrize("dialect", ["comma", "semicolon", "tab", "blanks"])
def test_a_table_next_to_the_first_rows_loses_no_row_silently(count, filled, header, dialect):
    text = log((PARAMETERS * 6)[:count], header, filled=filled)
    if dialect == "semicolon":
        text = text.replace(",", ";").replace(".", ",")
    elif dialect != "comma":
        text = (
            text.replace("12.5 kg", "12.5")
            .replace("Rated torque", "Torque")
            .replace("2.4 Nm", "2.4")
        )
        text = text.replace(",", "\t") if dialect == "tab" else text.replace(",", " ")
    with suppress(InputError):
        table = read_table(text.encode())
        np.testing.assert_array_equal(table.columns["time"], T)
        np.testing.assert_array_equal(table.columns["position"], X)


def test_rows_with_additional_cells_are_refused_with_advice():
    with pytest.raises(
        InputError,
        match=r"line 3, column 'Value': is a number, but the cells below it are text; .* Delete the additional cells in this row",
    ):
        read_table(log(PARAMETERS, filled=False).encode())


def test_columns_of_numbers_may_end_early():
    early = [f",{k}.5,{value}" for k, (_, value) in enumerate([("", "Mass"), *[("", "")] * 29])]
    cells = early + [",,"] * (COUNT - len(early))
    rows = [f"{t:.3f},{x:.6f}{more}" for t, x, more in zip(T, X, cells, strict=True)]
    table = read_table("\n".join(["time,position,temperature,note", *rows, ""]).encode())
    np.testing.assert_array_equal(
        table.columns["temperature"], [*(np.arange(30) + 0.5), *[np.nan] * 30]
    )
    np.testing.assert_array_equal(table.columns["position"], X)


def test_text_next_to_the_first_rows_is_noted_and_their_numbers_are_read():
    table = read_table(log([("Mass", "12.5"), ("Lead", "10")]).encode())
    np.testing.assert_array_equal(table.columns["position"], X)
    assert "bristle ignores columns of text: column_3, Parameter" in table.notes

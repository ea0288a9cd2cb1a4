"""Tables of text."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bristle.report.table import (
    Quantity,
    Table,
    capital,
    fixed,
    interval_text,
    length_text,
    percent_text,
    short_text,
    span_text,
    stiffness_text,
)


def test_empty_column_is_left_out():
    table = Table("t", ["a", "b", "c"], [["1", "", "x"], ["2", "", ""]]).without_empty_columns()
    assert (table.heads, table.rows) == (["a", "c"], [["1", "x"], ["2", ""]])


def test_column_of_numbers_is_distinguished_from_words():
    table = Table("t", ["a", "b", "c"], [["−1.5", "–", "3 mm"], ["± 0.2", "∞", "4"]])
    assert [table.is_number(column) for column in range(3)] == [True, True, False]


@given(values=st.lists(st.floats(-1e3, 1e3).filter(lambda v: abs(v) > 1e-9), min_size=1, max_size=8))
def test_cells_of_a_column_have_the_same_decimals(values):
    column = Quantity.of("m", values)
    cells = [column.cell(value) for value in values]
    assert len({len(cell.partition(".")[2]) for cell in cells}) == 1
    top = max(values, key=abs)
    read = float(column.cell(top).replace("−", "-")) / column.scale.factor
    assert abs(read - top) <= 0.006 * abs(top)


@pytest.mark.parametrize(("digits", "cell"), [(2, "3.1"), (3, "3.14"), (4, "3.142"), (5, "3.1416")])
def test_largest_number_of_a_column_has_the_requested_digits(digits, cell):
    column = Quantity.of("m", [3.14159e-3, 1e-4, math.inf], digits)
    assert (column.head("Way"), column.cell(3.14159e-3)) == ("Way [mm]", cell)


def test_column_of_zeros_has_the_plain_unit():
    column = Quantity.of("m", [])
    assert (column.scale.unit, column.step, column.cell(0.0)) == ("m", 0.0, "0")


def test_rows_by_head_make_a_table():
    assert Table.of("t", [{"a": "1", "b": "2"}, {"a": "3", "b": "4"}]) == ("t", ["a", "b"], [["1", "2"], ["3", "4"]])
    assert Table.of("t", []) == ("t", [], [])
    assert not Table("t", ["a"], []).is_number(0)


@pytest.mark.parametrize(
    ("text", "is_number"), [("1.5e−7", True), ("± 3 ± 0.1", True), ("−∞", True), ("1,5", False), ("", False), ("3 N", False)]
)
def test_number_is_distinguished_from_a_word(text, is_number):
    assert Table("t", ["a"], [[text]]).is_number(0) is is_number


def test_column_of_dashes_is_left_out():
    assert Table("t", ["a", "b"], [["1", "–"], ["2", ""]]).without_empty_columns() == ("t", ["a"], [["1"], ["2"]])


@pytest.mark.parametrize(
    ("value", "kind", "text"),
    [
        (0.0, "translational", "0 m"),
        (4.19e-7, "translational", "0.419 µm"),
        (-4.19e-7, "rotational", "−0.419 µrad"),
        (1e-6, "translational", "1 µm"),
        (2.5e-3, "rotational", "2.5 mrad"),
    ],
)
def test_smallest_unit_of_lengths_is_the_micrometre(value, kind, text):
    assert length_text(value, kind).replace("\u00a0", " ") == text


def test_short_texts_of_numbers():
    assert fixed(8.25, "N") == "8.25\u00a0N"
    assert (short_text(3.14159), percent_text(12.345)) == ("3.14", "12.3\u00a0%")
    assert (span_text([3e-3, 1e-3, 2e-3], "m"), span_text([2e-3, 2e-3], "m")) == ("1 mm to 3 mm", "2 mm")
    assert (interval_text("1", "2"), interval_text("1", "1")) == ("1 to 2", "1, to the last digit")
    assert (stiffness_text(5e7, "translational"), stiffness_text(123.4, "rotational")) == ("50.0 N/µm", "123 N·m/rad")


def test_a_sentence_begins_with_a_capital_or_with_the_name_of_the_program():
    assert capital("the log is short") == "The log is short"
    assert capital("bristle removed a delay") == "bristle removed a delay"
    assert capital("") == ""

"""Tables of text."""

from hypothesis import given
from hypothesis import strategies as st

from bristle.report.table import Quantity, Table


def test_a_column_in_which_nothing_is_said_is_left_out():
    table = Table("t", ["a", "b", "c"], [["1", "", "x"], ["2", "", ""]]).without_empty_columns()
    assert (table.heads, table.rows) == (["a", "c"], [["1", "x"], ["2", ""]])


def test_a_column_of_numbers_is_told_from_one_of_words():
    table = Table("t", ["a", "b", "c"], [["−1.5", "–", "3 mm"], ["± 0.2", "∞", "4"]])
    assert [table.is_number(column) for column in range(3)] == [True, True, False]


@given(values=st.lists(st.floats(-1e3, 1e3).filter(lambda v: abs(v) > 1e-9), min_size=1, max_size=8))
def test_all_cells_of_a_column_have_the_same_decimals(values):
    column = Quantity.of("m", values)
    cells = [column.cell(value) for value in values]
    assert len({len(cell.partition(".")[2]) for cell in cells}) == 1
    top = max(values, key=abs)
    read = float(column.cell(top).replace("−", "-")) / column.scale.factor
    assert abs(read - top) <= 0.006 * abs(top)

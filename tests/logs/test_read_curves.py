"""Curves of a hysteresis from files: one array each, or one table with a column that tells them apart."""

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.files import describes_curves, read_curves
from bristle.files.curves import read_curve_columns

FAMILY = """
schema = 1
name = "sample"
kind = "magnetic"

[log]
tables = "curve_*"

[columns]
input = { column = "column_1", unit = "mT" }
output = { column = "column_2", unit = "A*m^2", sign = -1 }

[curves]
start = "saturated"
shortest = 5
"""

LOOPS = """
schema = 1
kind = "translational"

[columns]
input = { column = "x", unit = "um" }
output = "F"
curve = "run"
"""


@pytest.fixture
def family(tmp_path):
    (tmp_path / "axis.toml").write_text(FAMILY)
    fields = [np.linspace(low, 100.0, count) for low, count in ((50.0, 3), (0.0, 9), (-100.0, 17))]
    curves = {f"curve_{k}": np.column_stack([item, -1e-6 * item]) for k, item in enumerate(fields)}
    np.savez(tmp_path / "curves.npz", other=np.ones((4, 2)), **curves)
    return tmp_path


@pytest.fixture
def loops(tmp_path):
    (tmp_path / "axis.toml").write_text(LOOPS)
    lines = ["run,x,F [N]", *(f"{k // 20},{(k % 20) - 10},{0.1 * k}" for k in range(60))]
    (tmp_path / "loops.csv").write_text("\n".join(lines) + "\n")
    return tmp_path


def test_each_array_is_a_curve(family):
    result = read_curves(family / "curves.npz", family / "axis.toml")
    assert [curve.u.size for curve in result.curves] == [9, 17]
    ends = (*result.curves[1].u[[0, -1]], *result.curves[1].f[[0, -1]], result.full_scale)
    assert ends == pytest.approx((-0.1, 0.1, -1e-4, 1e-4, 1e-4))
    assert (result.kind, result.start, result.low, result.high) == (
        "magnetic",
        "saturated",
        -0.1,
        0.1,
    )
    assert any(
        "bristle ignores 1 curves with fewer than 5 samples" in note for note in result.notes
    )
    assert len(result.origin.checksum) == 64


def test_a_column_separates_curves(loops):
    result = read_curves(loops / "loops.csv", loops / "axis.toml")
    assert [curve.u.size for curve in result.curves] == [20, 20, 20]
    last = result.curves[2]
    assert (last.u[0], last.f[-1], result.history(last).size) == pytest.approx((-10e-6, 5.9, 0))


def test_saturation_lies_where_a_curve_heads_for(family):
    result = read_curves(family / "curves.npz", family / "axis.toml")
    rising = result.curves[0]
    assert result.history(rising) > 0.1
    assert result.history(type(rising)(rising.u[::-1], rising.f[::-1])) < -0.1


def test_a_curves_file_is_distinguished_from_an_axis_file(loops, tmp_path):
    (tmp_path / "of_axis.toml").write_text(
        'schema = 1\nkind = "rotational"\n[columns]\nposition = "q"\n'
    )
    (tmp_path / "family.toml").write_text(FAMILY)
    assert [
        describes_curves(tmp_path / name) for name in ("family.toml", "axis.toml", "of_axis.toml")
    ] == [True, True, False]


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ('unit = "mT"', 'unit = "mm"', "columns.input.unit"),
        ('kind = "magnetic"', 'kind = "electric"', "kind: is not valid"),
        ('"curve_*"', '"loop_*"', "does not match any table"),
        ('"column_2"', '"column_3"', "no column 'curve_0/column_3'"),
        ("shortest = 5", "shortest = 50", "has only curves with too few samples"),
        ("shortest = 5", "longest = 5", "curves.longest: unknown key"),
        ('start = "saturated"', 'start = "rest"', "curves.start"),
    ],
)
def test_a_malformed_curves_file_is_refused(family, was, now, said):
    (family / "axis.toml").write_text(FAMILY.replace(was, now))
    with pytest.raises(InputError, match=said):
        read_curves(family / "curves.npz", family / "axis.toml")


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("nan", "not a finite number"),
        ("1e200", "not a valid measurement"),
        ("1e308", "not a valid measurement"),
    ],
)
def test_samples_that_are_no_numbers_are_refused(loops, value, message):
    (loops / "loops.csv").write_text(
        (loops / "loops.csv").read_text().replace("0,-7,", f"0,{value},")
    )
    with pytest.raises(InputError, match=message):
        read_curves(loops / "loops.csv", loops / "axis.toml")


def test_a_signal_that_stands_still_is_no_input(loops):
    columns = read_curve_columns(loops / "axis.toml")
    (loops / "still.csv").write_text("run,x,F\n" + "0,1,2\n" * 30)
    with pytest.raises(InputError, match="is constant"):
        read_curves(loops / "still.csv", columns)


@pytest.mark.parametrize("header", ["run,x,F\n", ""])
def test_columns_may_be_called_by_their_numbers(loops, header):
    rows = (loops / "loops.csv").read_text().partition("\n")[2]
    by_name = read_curves(loops / "loops.csv", loops / "axis.toml").curves
    columns = {"input": {"column": 2, "unit": "um"}, "output": 3, "curve": 1}
    curves = read_curves(
        (header + rows).encode(), {"schema": 1, "kind": "translational", "columns": columns}
    ).curves
    assert len(curves) == len(by_name) == 3
    for item, other in zip(curves, by_name, strict=True):
        np.testing.assert_array_equal([item.u, item.f], [other.u, other.f])

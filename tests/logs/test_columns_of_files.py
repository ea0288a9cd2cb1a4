"""Columns by number, of one name, with units in their names; times that an axis file need not name."""

import numpy as np
import pytest
import scipy.io
from tests.logs.exports import EXPORTS, motion

from bristle.core.errors import InputError
from bristle.files.axis import axis_from
from bristle.logs import checked, read_log
from bristle.logs.readers import read_table
from bristle.logs.table import columns_named

MOTION = motion(1.0)


def axis(**columns):
    return axis_from({"schema": 1, "kind": "translational", "columns": columns})


def test_a_column_may_be_called_by_its_number(tmp_path):
    bare = EXPORTS["no header"].write(tmp_path, MOTION)
    named = EXPORTS["units behind strokes"].write(tmp_path, MOTION)
    by_number = axis(
        time={"column": 1, "unit": "s"}, position={"column": 2, "unit": "mm"}, effort=3
    )
    logs = [read_log(path, by_number) for path in (bare, named)]
    assert [log.position.column for log in logs] == ["column_2", "x/mm"]
    first, second = ([log.time, log.position, log.effort] for log in logs)
    np.testing.assert_array_equal(first, second)
    with pytest.raises(InputError, match="has no column 'column_9'"):
        read_log(named, axis(time=1, position=9))


@pytest.mark.parametrize("header", ["zeit;weg;kraft;puls;last\n", ""])
def test_a_known_input_and_a_known_column_may_be_called_by_their_numbers(header):
    rows = [
        f"{k / 1000};{np.sin(k / 50):.6f};{np.cos(k / 50):.6f};{k % 7};{k % 5}" for k in range(300)
    ]
    described = axis_from(
        {
            "schema": 1,
            "kind": "translational",
            "columns": {"time": 1, "position": 2, "effort": 3},
            "injected": [{"column": 4, "gain": "2 N"}],
            "known": [{"column": 5, "name": "last"}],
        }
    )
    log = read_log((header + "\n".join([*rows, ""])).encode(), described)
    np.testing.assert_allclose(log.injected[0].values, 2.0 * (np.arange(300) % 7))
    np.testing.assert_allclose(log.regressors[0].values, np.arange(300) % 5)


def test_a_column_number_works_in_any_file_with_a_single_table(tmp_path):
    t = np.arange(300) / 1000
    columns = {"zeit": t, "weg": np.sin(20 * t), "kraft": np.cos(20 * t)}
    scipy.io.savemat(tmp_path / "log.mat", columns)
    scipy.io.savemat(tmp_path / "matrix.mat", {"M": np.column_stack([*columns.values()])})
    np.savez(tmp_path / "log.npz", **columns)
    by_number = axis(time={"column": 1, "unit": "s"}, position={"column": 2, "unit": "m"}, effort=3)
    logs = [read_log(tmp_path / name, by_number) for name in ("log.mat", "matrix.mat", "log.npz")]
    assert [log.position.column for log in logs] == ["weg", "M[1]", "weg"]
    np.testing.assert_allclose([log.effort for log in logs], [columns["kraft"]] * 3)


def test_a_number_counts_the_columns_of_a_text_with_several_times():
    rows = [f"{k / 1000};{np.sin(k / 50):.6f};{k / 1000};{np.cos(k / 50):.6f}" for k in range(300)]
    text = "\n".join(["time 1;weg;time 2;kraft", *rows, ""]).encode()
    log = read_log(text, axis(time=1, position={"column": 2, "unit": "m"}, effort=4))
    assert (log.position.column, log.effort.column) == ("weg", "kraft")
    np.testing.assert_allclose(log.effort.values, np.round(np.cos(np.arange(300) / 50), 6))


def test_a_time_that_need_not_be_named_may_be(tmp_path):
    path = EXPORTS["twincat, full"].write(tmp_path, MOTION)
    position = {"column": "ActPos", "unit": "mm"}
    without, named = (
        read_log(path, axis(position=position, **more))
        for more in ({}, {"time": {"column": "Zeit"}})
    )
    np.testing.assert_array_equal(without.time.values, named.time.values)
    assert [
        any("bristle ignores columns.time" in note for note in log.notes)
        for log in (without, named)
    ] == [False, True]


@pytest.mark.parametrize(
    ("header", "unit", "told"),
    [
        ("speed_rpm [mm/s]", None, ("rpm", "mm/s")),
        ("speed_mm_s", "m/s", ("mm/s", "m/s")),
        ("speed_mm_s", "mm/s", None),
        ("speed_m", "mm/s", None),
    ],
)
def test_a_unit_in_a_name_that_its_numbers_contradict_is_reported(tmp_path, header, unit, told):
    path = tmp_path / "log.csv"
    rows = [f"{k / 1000},{80 * np.sin(k / 50):.6f},{1600 * np.cos(k / 50):.6f}" for k in range(300)]
    path.write_text("\n".join([f"t,q,{header}", *rows]) + "\n")
    velocity = {"column": header.split(" [")[0]} | ({"unit": unit} if unit else {})
    described = axis(
        time={"column": "t", "unit": "s"}, position={"column": "q", "unit": "mm"}, velocity=velocity
    )
    result = [
        item
        for item in checked(read_log(path, described), described)
        if item.code == "unit_contradicts"
    ]
    assert [(item.numbers["called"], item.numbers["declared"]) for item in result] == (
        [told] if told else []
    )


def test_a_file_of_one_long_line_is_read(tmp_path):
    path = EXPORTS["records"].write(tmp_path, motion(4.0))
    assert (path.read_text().count("\n"), path.stat().st_size > 131_072) == (0, True)
    assert len(read_log(path, axis(position="position"))) == 4000


def test_dates_of_an_archive_are_read_for_the_signals_that_are_asked_for_only():
    rows = [
        f"{name} 2026-02-{day:02d} 09:00:{k:02d} {k}"
        for k in range(20)
        for name, day in (("asked", 1), ("other", 30 if k else 1))
    ]
    table = read_table("\n".join([*rows, ""]).encode(), choice=columns_named(["asked"]))
    np.testing.assert_array_equal(table.columns["time"], np.arange(20.0))
    assert table.names == ("time", "asked", "other")

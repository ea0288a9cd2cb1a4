"""TOML as it is read and written, motions in the units of an axis, models with other values, arrays beside results."""

import math

import numpy as np
import pytest

from bristle import friction
from bristle.core.axis import Axis, Column
from bristle.core.content import NOWHERE
from bristle.core.errors import InputError
from bristle.files.motion import (
    Move,
    axis_of_motion,
    gcode_of,
    log_text,
    motion_columns,
    moves_table,
    write_motion,
)
from bristle.files.summary import as_json, plain, provenance
from bristle.files.toml import DEEPEST, Said, as_toml, quoted, read_toml
from bristle.files.varied import with_changes, with_columns

# --- TOML ------------------------------------------------------------------------------------------------------------


def test_valid_content_is_read(tmp_path):
    path = tmp_path / "x.toml"
    path.write_bytes(b"\xef\xbb\xbfa = inf\r\nb = -9223372036854775807\r\nc = 1e99\r\n")
    settings = read_toml(path)
    assert (settings.data, settings.source) == ({"a": math.inf, "b": -(2**63) + 1, "c": 1e99}, path)
    assert read_toml((".".join("a" * DEEPEST) + " = 1").encode()).data["a"]
    with pytest.raises(InputError, match=r"is not a text file in UTF-8 .byte 4."):
        read_toml(b"a = \xff")
    assert read_toml({"a": 1}).content is None


def test_tables_survive_a_round_trip():
    tables = {
        "schema": 1,
        "a key": 'ä "quoted"',
        "flag": True,
        "numbers": [1, 2.5, -0.0],
        "array": np.array([1.0, 2.0]),
        "inner": {"x": Said(3.0, "mm: a way"), "deeper": {"y": [[1.0], [2.0]]}},
        "each": [{"a": 1}, {"a": 2, "b": {"c": 3}}],
        "empty": {"only": {"z": 1}},
    }
    text = as_toml(tables)
    expected = tables | {"array": [1.0, 2.0], "inner": {"x": 3.0, "deeper": {"y": [[1.0], [2.0]]}}}
    assert read_toml(text.encode()).data == expected
    assert "\n\n[inner]\nx = 3.0 # mm: a way\n" in text
    assert "[empty]\n" not in text
    assert text == text.strip("\n") + "\n"


@pytest.mark.parametrize(
    ("count", "begin"), [(200, "# so many\nx = [0, 1"), (3, "x = [0, 1, 2] # so many\n")]
)
def test_a_comment_is_above_a_long_line_and_behind_a_short_one(count, begin):
    assert as_toml({"x": Said(list(range(count)), "so many")}).startswith(begin)


def test_values_beyond_toml_are_refused_with_their_place():
    with pytest.raises(InputError, match=r"a\.b: cannot be written.*text, a number, True or False"):
        as_toml({"a": {"b": None}})
    assert [quoted(value) for value in (True, 1, 1.0, "x", (1, "y"))] == [
        "true",
        "1",
        "1.0",
        '"x"',
        '[1, "y"]',
    ]


# --- motions ---------------------------------------------------------------------------------------------------------

MOTOR = Axis(
    kind="translational",
    columns={
        "time": Column("t [ms]", "ms", "s", 1.0),
        "position": Column("q", "rad", "rad", -2e-3),
        "effort": Column("i [A]", "A", "A", 50.0),
    },
)
BARE = Axis(kind="rotational")


FOLLOWED = Axis(
    kind="translational", columns=dict(MOTOR.columns) | {"reference": Column("r", "mm", "m", 1.0)}
)
TO_MOTOR, TO_MM = pytest.approx(-2e-3), pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("axis", "heads"),
    [
        (
            MOTOR,
            [
                ("t [ms]", TO_MM),
                ("q [rad]", TO_MOTOR),
                ("velocity [rad/s]", TO_MOTOR),
                ("acceleration [rad/s^2]", TO_MOTOR),
            ],
        ),
        (
            BARE,
            [
                ("time [s]", 1.0),
                ("position [rad]", 1.0),
                ("velocity [rad/s]", 1.0),
                ("acceleration [rad/s^2]", 1.0),
            ],
        ),
        (
            FOLLOWED,
            [
                ("t [ms]", TO_MM),
                ("r [mm]", TO_MM),
                ("velocity [mm/s]", TO_MM),
                ("acceleration [mm/s^2]", TO_MM),
            ],
        ),
    ],
)
def test_columns_of_a_motion_are_those_of_the_axis(axis, heads):
    assert list(motion_columns(axis).items()) == list(
        zip(("time", "position", "velocity", "acceleration"), heads, strict=True)
    )


def test_a_motion_and_a_log_are_written_in_units_of_the_axis(tmp_path):
    time = np.array([0.0, 0.5])
    write_motion(
        tmp_path / "m.csv",
        MOTOR,
        {"time": time, "position": 4e-3 * time, "velocity": time, "acceleration": time},
    )
    lines = (tmp_path / "m.csv").read_text().splitlines()
    assert lines == [
        "t [ms],q [rad],velocity [rad/s],acceleration [rad/s^2]",
        "0,-0,-0,-0",
        "500,-1,-250,-250",
    ]
    text = log_text(MOTOR, {"time": time, "position": 4e-3 * time, "effort": 100.0 * time})
    assert text.splitlines() == ["t [ms],q [rad],i [A]", "0,-0,0", "500,-1,1"]


def test_a_file_without_an_effort_is_a_motion(tmp_path):
    (tmp_path / "m.csv").write_text("t [ms],q [rad]\n0,0\n1,1\n2,2\n")
    (tmp_path / "l.csv").write_text("t [ms],q [rad],i [A]\n0,0,1\n1,1,1\n2,2,1\n")
    led = axis_of_motion(tmp_path / "m.csv", MOTOR)
    assert {channel: column.name for channel, column in led.columns.items()} == {
        "time": "t [ms]",
        "position": "q",
    }
    assert [
        axis_of_motion(tmp_path / name, axis)
        for name, axis in (("l.csv", MOTOR), ("m.csv", None), ("m.csv", BARE))
    ] == 3 * [None]


MOVES = [Move("run-in", 0.0, 0.1, 0.05, 2.0), Move("slow", 0.25, -0.02, 0.001, 1.0)]


def test_moves_are_listed_in_units_of_the_axis():
    head = "purpose,dwell [s],q [rad],velocity [rad/s],acceleration [rad/s^2]"
    assert moves_table(MOVES, MOTOR).split("\n") == [
        head,
        "run-in,0,-50,25,1000",
        "slow,0.25,10,0.5,500",
        "",
    ]


@pytest.mark.parametrize(
    ("moves", "axis", "part"),
    [
        (MOVES, MOTOR, "(omitted, because it is not a list of moves: chirp)\n"),
        (MOVES, MOTOR, "\nG90 G94 G21 (mm)\n"),
        (MOVES, MOTOR, "\nG1 X100.000000 F3000.0000\nG4 P0.250\nG1 X-20.000000 F60.0000\nM30\n"),
        (
            [Move("x", 0.0, math.pi, math.pi / 6.0, 1.0)],
            BARE,
            "G90 G94 (degrees)\nG1 A180.000000 F1800.0000\nM30",
        ),
    ],
)
def test_a_program_for_an_nc_is_in_millimetres_or_degrees_a_minute(moves, axis, part):
    assert part in gcode_of(moves, axis, ["chirp"])


# --- other values ----------------------------------------------------------------------------------------------------

STRIBECK = friction.stribeck(F_C=8.0, F_S=12.0, v_S=1e-3, F_v=30.0)


def test_a_change_keeps_all_other_values():
    assert with_changes(STRIBECK, {"F_C": "9 N"}, "friction") == STRIBECK.with_values(F_C=9.0)


@pytest.mark.parametrize(("level", "words"), [(-1.0, r"friction\.F_C"), (13.0, "F_S >= F_C")])
def test_a_change_out_of_range_is_refused(level, words):
    with pytest.raises(InputError, match=words):
        with_changes(STRIBECK, {"F_C": level}, "friction")


@pytest.mark.parametrize(
    ("columns", "rows"),
    [
        (
            {"F_C": np.array([8.0, 13.0, 9.0]), "F_v": np.array([1.0, 2.0, 3.0])},
            [{"F_C": 8.0, "F_v": 1.0}, None, {"F_C": 9.0, "F_v": 3.0}],
        ),
        ({"F_v": np.array([-1.0, 2.0])}, [None, {"F_v": 2.0}]),
        ({"F_v": np.array([np.nan, 2.0])}, [None, {"F_v": 2.0}]),
        ({"F_v": np.array(["1 N*s/m"])}, [{"F_v": 1.0}]),
    ],
)
def test_columns_give_a_model_for_each_row_that_holds(columns, rows):
    assert with_columns(STRIBECK, columns, "friction") == [
        row and STRIBECK.with_values(**row) for row in rows
    ]


# --- JSON ------------------------------------------------------------------------------------------------------------


def test_plain_data_have_only_finite_numbers():
    data = {
        1: np.array([1.0, np.nan]),
        "b": {3},
        "c": (True, None, 2),
        "d": np.float64(1.5),
        "e": math.inf,
    }
    assert plain(data) == {"1": [1.0, None], "b": [3], "c": [True, None, 2], "d": 1.5, "e": None}
    assert as_json({"a": 1}) == '{\n  "a": 1\n}\n'


def test_several_sources_are_numbered():
    record = provenance("bristle x", log=[NOWHERE, NOWHERE], axis=None)
    assert list(record) == ["bristle", "log", "log_sha256", "log_2", "log_2_sha256", "command"]
    assert record["command"] == "bristle x"
    assert list(provenance("bristle x", axis=NOWHERE)) == [
        "bristle",
        "axis",
        "axis_sha256",
        "command",
    ]

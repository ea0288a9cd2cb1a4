"""Axis files: what they say, in SI, and what is refused with key, value and mend."""

from __future__ import annotations

import copy
import datetime
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from bristle.core import units
from bristle.core.errors import InputError
from bristle.files.axis import axis_from, axis_text, read_axis
from bristle.files.toml import read_toml

EMPS = Path(__file__).parents[2] / "examples" / "emps" / "axis.toml"

LINEAR = {
    "schema": 1,
    "name": "stage",
    "kind": "translational",
    "columns": {
        "time": {"column": "t", "unit": "ms"},
        "position": {"column": "q", "unit": "mm"},
        "effort": {"column": "u", "unit": "N"},
    },
}


def changed(base=LINEAR, **tables):
    """The content of an axis file with some tables updated; None leaves a key out."""
    data = copy.deepcopy(base)
    for table, content in tables.items():
        if isinstance(content, dict) and isinstance(data.get(table), dict):
            data[table] |= content
        else:
            data[table] = content
    return data


def si(column, value=1.0):
    """A number of the log in SI of the axis."""
    return value * units.factor(column.unit or column.base, column.base) * column.scale


def test_the_axis_file_of_the_positioning_system():
    axis = read_axis(EMPS)
    assert (axis.name, axis.kind, axis.resolution) == ("EMPS", "translational", 50e-9)
    assert si(axis.columns["effort"]) == pytest.approx(35.1507, abs=1e-4)
    assert (axis.injected[0].gain * 5, axis.injected[0].optional) == (
        pytest.approx(5.0695 * 35.1507, rel=1e-5),
        True,
    )
    # The limit is that of the sum with the pulses.
    assert (axis.effort_limit, axis.controller.values["limit"]) == (
        pytest.approx(351.507, abs=1e-3),
        float("inf"),
    )
    assert (axis.cutoff, axis.decimation, axis.offset, axis.mass) == (100.0, 10, "identify", None)


def test_a_complete_axis_file_is_read():
    axis = axis_from(
        changed(
            plant={"mass": "95 kg", "offset": "-3 N", "presliding": "10 um"},
            timing={"sample_time": "0.5 ms", "delay": "250 us"},
            limits={"velocity": "300 mm/s", "stroke": ["0 mm", 0.25]},
            encoder={"resolution": "50 nm/count"},
            identification={"cutoff": "0.1 kHz", "decimation": 5, "loop": "closed"},
            effort={"lag": "300 us"},
            columns={"velocity": {"column": "v", "unit": "mm/s", "sign": -1}, "reference": "r"},
        )
    )
    assert (axis.mass, axis.offset, axis.presliding, axis.controller) == (95.0, -3.0, 1e-5, None)
    assert (axis.sample_time, axis.delay, axis.velocity_limit, axis.stroke) == (
        5e-4,
        2.5e-4,
        0.3,
        (0.0, 0.25),
    )
    assert (axis.resolution, axis.cutoff, axis.decimation) == (5e-8, 100.0, 5)
    assert (axis.loop, axis.lag, axis.seeks_lag) == ("closed", 3e-4, False)
    reference = axis.columns["reference"]
    assert (si(axis.columns["velocity"]), reference.unit, reference.base) == (-1e-3, "", "m")


def test_a_motor_with_gear_and_screw():
    axis = axis_from(
        changed(
            transmission={"gear_ratio": 2.0, "lead": "10 mm/rev"},
            columns={
                "position": {"column": "q", "unit": "rev", "side": "motor"},
                "velocity": {"column": "v", "unit": "rpm", "side": "load"},
                "effort": {"column": "i", "unit": "mA", "sign": -1},
                "reference": {"column": "r", "unit": "mm"},
            },
            effort={"torque_constant": "0.12 N*m/A", "limit": "5 A"},
        )
    )
    assert si(axis.columns["position"]) == pytest.approx(0.005)  # half a turn of the screw
    assert si(axis.columns["velocity"], 60.0) == pytest.approx(0.010)
    assert si(axis.columns["reference"]) == pytest.approx(1e-3)
    # 1 A: 0.12 N*m at the motor, 0.24 at the screw, and 2 pi / 10 mm of that is 150.8 N.
    assert si(axis.columns["effort"], 1000.0) == pytest.approx(-150.796, abs=1e-3)
    assert axis.effort_limit == pytest.approx(5 * 150.796, abs=5e-3)


def test_a_joint_in_percent_of_rated_and_counts():
    axis = axis_from(
        {
            "schema": 1,
            "kind": "rotational",
            "columns": {
                "position": {"column": "enc", "unit": "count"},
                "effort": {"column": "load", "unit": "%"},
            },
            "effort": {"rated": "2.4 N*m"},
            "transmission": {"gear_ratio": 50},
            "encoder": {"counts_per_rev": 40000, "side": "motor"},
            "plant": {"inertia": "4 kg*cm^2"},
        }
    )
    assert si(axis.columns["position"], 40000 * 50) == pytest.approx(2 * math.pi)
    assert si(axis.columns["effort"], 100.0) == pytest.approx(120.0)
    assert (axis.resolution, axis.mass) == (pytest.approx(2 * math.pi / 2e6), 4e-4)


def test_percent_of_a_rated_current():
    effort = {"rated": "3 A", "torque_constant": "0.5 Nm/A"}
    axis = axis_from(
        changed(
            kind="rotational",
            columns={"position": "q", "effort": {"column": "u", "unit": "%"}},
            effort=effort,
        )
    )
    assert si(axis.columns["effort"], 50.0) == pytest.approx(0.75)


def test_a_linear_scale_on_a_rotational_axis_is_converted():
    axis = axis_from(
        changed(
            kind="rotational",
            transmission={"lead": "5 mm"},
            columns={
                "position": {"column": "q", "unit": "um"},
                "effort": {"column": "u", "unit": "mN*m"},
            },
        )
    )
    assert si(axis.columns["position"], 5000.0) == pytest.approx(2 * math.pi)
    assert si(axis.columns["effort"]) == pytest.approx(1e-3)


@pytest.mark.parametrize("gain", [{"gain": "2 V"}, {"gain": "70 N"}, {"gain": 70.0}])
def test_a_known_input_in_any_unit_of_effort(gain):
    axis = axis_from(
        changed(
            effort={"force_constant": "35 N/V"},
            columns={"effort": {"column": "u", "unit": "V"}},
            injected=[{"column": "pulses", **gain}],
        )
    )
    assert axis.injected[0].gain == pytest.approx(70.0)


def column(**entry):
    return {"columns": entry}


BAD = [
    (
        {"schema": 2},
        "schema: is a schema that this version of bristle cannot read; found 2, allowed 1. Update bristle",
    ),
    (
        {"schema": datetime.date(1979, 5, 27)},
        "schema: is a schema that this version of bristle cannot read; found 1979-05-27",
    ),
    ({"schema": True}, "schema: is a schema that this version of bristle cannot read; found True"),
    ({"schema": 1.0}, "schema: is a schema that this version of bristle cannot read; found 1.0"),
    (
        {"kind": "round"},
        "kind: is not valid; found 'round', allowed 'translational' or 'rotational'",
    ),
    ({"columns": "time"}, "columns: is not valid; found 'time', allowed a table"),
    (
        column(position={"column": "q", "unit": "m", "sign": True}),
        "columns.position.sign: is not valid; found True",
    ),
    ({"log": {"span": [5]}}, "log.span: is not valid; found [5], allowed at least 2 values"),
    ({"columns": {"position": 5.5}}, "columns.position: is not valid; found 5.5, allowed "),
    ({"colums": {}}, "colums: unknown key"),
    ({"colums": {}}, "Did you mean 'columns'?"),
    (
        column(position={"column": "q", "units": "m"}),
        "columns.position.units: unknown key; allowed keys: column",
    ),
    (column(position={"unit": "m"}), "columns.position.column: is missing"),
    (
        column(position={"column": "q", "unit": "m", "sign": 0}),
        "columns.position.sign: is not valid",
    ),
    (
        column(position={"column": "q", "unit": "furlung"}),
        "columns.position.unit: is not a unit; found 'furlung'",
    ),
    (column(position={"column": "q", "unit": "kg"}), "columns.position.unit: has the wrong unit"),
    (column(position={"column": "q", "unit": "rad"}), 'lead = "5 mm"'),
    (
        column(position={"column": "q", "unit": "count"}),
        "columns.position.unit: needs the movement of the axis per count",
    ),
    (
        column(position={"column": "q", "unit": "m", "side": "motor"}),
        "but the motor side of a gear is rotational",
    ),
    (column(velocity={"column": "v", "unit": "Hz"}), "columns.velocity.unit: has the wrong unit"),
    (column(time={"column": "t", "unit": "m"}), "columns.time.unit: has the wrong unit"),
    (column(effort={"column": "u", "unit": "J"}), "An energy is not a torque"),
    (column(effort={"column": "u", "unit": "N*m"}), "columns.effort.unit: is measured as a torque"),
    (column(effort={"column": "u", "unit": "V"}), 'Write constant = "0.12 N*m/V" under [effort]'),
    (column(effort={"column": "u", "unit": "%"}), 'Write rated = "2.4 N*m" under [effort]'),
    (column(effort={"column": "u", "unit": "m"}), "columns.effort.unit: is not a unit of effort"),
    ({"effort": {"force_constant": "35 N"}}, "effort.force_constant: is not a drive constant"),
    ({"effort": {"force_constant": "35 N*m/A"}}, "effort.force_constant: is not a drive constant"),
    ({"effort": {"force_constant": "0 N/V"}}, "effort.force_constant: must be finite and not zero"),
    ({"effort": {"force_constant": 35.0}}, "effort.force_constant: is not valid"),
    ({"effort": {"force_constant": "1 N/V", "torque_constant": "1 N*m/A"}}, "Keep only one"),
    ({"effort": {"limit": "-0 N"}}, "effort.limit: must be positive"),
    (
        {"effort": {"limit": "10 A"}},
        "effort.limit: needs a drive constant, which converts it to a force or torque; found '10 A'",
    ),
    ({"effort": {"limit": "300 J"}}, "effort.limit: has the wrong unit; found '300 J'"),
    (
        column(effort={"column": "u", "unit": "J"}),
        "columns.effort.unit: has the wrong unit; found 'J'",
    ),
    ({"encoder": {"resolution": "5 N"}}, "encoder.resolution: has the wrong unit; found '5 N'"),
    (
        {"transmission": {"lead": "0 mm"}},
        "transmission.lead: must be positive and finite; found '0 mm'",
    ),
    ({"transmission": {"gear_ratio": -2.0}}, "transmission.gear_ratio: is not valid; found -2.0"),
    ({"plant": {"mass": "95 N"}}, "plant.mass: has the wrong unit"),
    ({"plant": {"mass": -1}}, "plant.mass: must be positive"),
    (
        {"plant": {"inertia": "1 kg*m^2"}},
        "plant.inertia: does not apply to a translational axis. Write mass",
    ),
    (
        {"plant": {"offset": "guess"}},
        "plant.offset: is not a number with a unit; found 'guess', allowed \"identify\"",
    ),
    ({"timing": {"sample_time": "1 kHz"}}, "timing.sample_time: has the wrong unit"),
    ({"timing": {"sample_time": 0}}, "timing.sample_time: must be positive"),
    (
        {"timing": {"delay": True}},
        "timing.delay: is not valid; found True, allowed a number, or text with a unit",
    ),
    ({"limits": {"stroke": ["1 m", "0 m"]}}, "limits.stroke: must be in ascending order"),
    ({"limits": {"stroke": ["1 m"]}}, "limits.stroke: is not valid"),
    ({"limits": {"velocity": "3000 rpm"}}, "limits.velocity: has the wrong unit"),
    ({"encoder": {"resolution": "1 um", "counts_per_rev": 10}}, "encoder: has both"),
    ({"encoder": {"counts_per_rev": 10}}, "encoder.counts_per_rev: is measured as an angle"),
    ({"identification": {"cutoff": "100 rad/s"}}, "divide rad/s by 2 pi"),
    ({"identification": {"decimation": 0}}, "identification.decimation: is not valid; found 0"),
    ({"identification": {"decimation": 2.5}}, "identification.decimation: is not valid; found 2.5"),
    ({"controller": {"k_p": 1}}, "controller: names no model"),
    ({"controller": {"model": "cascde"}}, "controller.model: "),
    ({"controller": 3}, "controller: is not valid; found 3"),
    (
        {"effort": {"held": True, "hold": "linear"}},
        "effort.hold: contradicts the key `held`; found 'linear'",
    ),
    (
        {"effort": {"held": False, "hold": "zero"}},
        "effort.hold: contradicts the key `held`; found 'zero'",
    ),
    (
        {"timing": {"sample_time": "1 ms", "sample_rate": "1 kHz"}},
        "timing: has both a sample_time and a sample_rate",
    ),
    ({"timing": {"sample_rate": 0}}, "timing.sample_rate: must be positive and finite"),
    (
        {"columns": {"position": None}},
        'columns.position: is missing. Write position = { column = "NAME", unit = "mm" }, or name a velocity column',
    ),
    ({"plant": {"stiffness": "1 N/m"}}, "plant.stiffness: needs an oscillator as the plant"),
    ({"plant": {"damping": "1 N*s/m"}}, "plant.damping: needs an oscillator as the plant"),
    ({"log": {"span": [5, 5]}}, "log.span: must be in ascending order"),
    ({"limits": {"stroke": [0.2, 0.2]}}, "limits.stroke: must be in ascending order"),
    ({"encoder": {"resolution": "0 mm"}}, "encoder.resolution: must be positive and finite"),
    (
        {"plant": {"gravity": "link"}},
        "bristle identifies the weight on a vertical axis as the constant offset",
    ),
    ({"injected": [{"column": "a", "gain": 1}, {"column": "b"}]}, "injected[1].gain: is missing"),
    (
        {"injected": [{"column": "a", "gain": 1.0, "unit": "N"}]},
        "injected[0].unit: was removed. Write the unit in the gain",
    ),
    ({"injected": [{"column": "a", "gain": "1 m"}]}, "injected[0].gain: is not a unit of effort"),
]


@pytest.mark.parametrize(("tables", "said"), BAD, ids=[message[:50] for _, message in BAD])
def test_refusals_name_key_value_and_remedy(tables, said):
    with pytest.raises(InputError, match=re.escape(said)):
        axis_from(changed(**tables))


SIDELESS = {"position": {"column": "q", "unit": "rad"}, "effort": "u"}
MISSPELT = {
    "schema": 1,
    "kind": "translational",
    "columns": {"time": "t", "positon": "q", "effort": "u"},
}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (
            changed(kind="rotational", transmission={"gear_ratio": 50}, columns=SIDELESS),
            r"has no key `side`, but a gear .* side = \"motor\"",
        ),
        # Before a missing column.
        (MISSPELT, r"columns\.positon: unknown key.*Did you mean 'position'"),
        (
            changed(identification={"global_search": True}),
            r"identification\.global_search.* was removed.*Leave it out",
        ),
        (
            changed(
                columns={"effort": {"column": "u", "unit": "A"}},
                effort={"constant": "61.2 N/A", "force_constant": "61.2 N/A"},
            ),
            "has both a force_constant and a constant",
        ),
        (
            changed(
                columns={"effort": {"column": "u", "unit": "%"}},
                effort={"rated": "2.4 N*m", "lead": "10 mm"},
            ),
            r"This key belongs under \[transmission\]",
        ),
        (
            changed(columns={"position": {"column": "q", "unit": "?"}}, effort={"rated": "?"}),
            r"columns\.position\.unit: is not filled in.*Also fill in effort\.rated",
        ),
        *(
            ({key: LINEAR[key] for key in LINEAR if key != name}, rf"^{name}: is missing")
            for name in ("schema", "columns")
        ),
        ({"schema": 1, "columns": {"position": "q"}}, "^kind: is missing"),
    ],
)
def test_missing_contradicting_misplaced_and_removed_keys_are_named(data, words):
    with pytest.raises(InputError, match=words):
        axis_from(data)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("gone.toml", "there is no such file"),
        (".", "is a folder"),
        ("axis.mat", "not a text file in UTF-8"),
    ],
)
def test_missing_files_binary_files_and_folders_are_refused(tmp_path, name, words):
    (tmp_path / "axis.mat").write_bytes(b"MATLAB\xff\xfe")
    with pytest.raises(InputError, match=words):
        read_toml(tmp_path / name)


@pytest.mark.parametrize(
    ("tables", "attributes"),
    [
        (
            {},
            {
                "held": None,
                "delay": 0.0,
                "seeks_delay": True,
                "seeks_lag": False,
                "at_rest": False,
                "keeps_rests": False,
            },
        ),
        # Either key sets a zero-order hold.
        ({"effort": {"held": True}}, {"held": True}),
        ({"effort": {"held": False}}, {"held": False}),
        ({"effort": {"hold": "zero"}}, {"held": True}),
        ({"effort": {"hold": "linear"}}, {"held": False}),
        ({"effort": {"held": True, "hold": "zero"}}, {"held": True}),
        ({"effort": {"held": False, "hold": "linear"}}, {"held": False}),
        # A delay is looked for unless it is stated, and a lag only on request.
        ({"timing": {"delay": "identify"}}, {"delay": 0.0, "seeks_delay": True}),
        ({"timing": {"delay": "-2 ms"}}, {"delay": -2e-3, "seeks_delay": False}),
        ({"timing": {"delay": 0.0}}, {"delay": 0.0, "seeks_delay": False}),
        ({"effort": {"lag": "identify"}}, {"seeks_lag": True}),
        ({"effort": {"lag": "2 ms"}}, {"lag": 2e-3, "seeks_lag": False}),
        # A log begins at rest, in a cycle, or in motion.
        ({"log": {"start": "rest"}}, {"at_rest": True, "in_cycle": False}),
        ({"log": {"start": "cycle"}}, {"at_rest": False, "in_cycle": True}),
        ({"log": {"start": "moving"}}, {"at_rest": False, "in_cycle": False}),
        ({"identification": {"rests": "keep"}}, {"keeps_rests": True}),
    ],
)
def test_settings_have_their_values_or_defaults(tables, attributes):
    axis = axis_from(changed(**tables))
    assert {name: getattr(axis, name) for name in attributes} == attributes


@pytest.mark.parametrize(
    ("timing", "step"),
    [({"sample_rate": "4 kHz"}, 2.5e-4), ({"sample_time": "250 us"}, 2.5e-4), ({}, None)],
)
def test_a_sample_rate_is_the_inverse_of_a_sample_time(timing, step):
    assert axis_from(changed(timing=timing)).sample_time == (step and pytest.approx(step))


def test_known_columns_are_named_by_letters_of_their_column_and_each_once():
    axis = axis_from(
        changed(
            known=[
                {"column": "T motor [degC]"},
                {"column": "%"},
                {"column": "p", "name": "air", "optional": True},
            ]
        )
    )
    assert [(column.column, column.name, column.optional) for column in axis.regressors] == [
        ("T motor [degC]", "T_motor_degC", False),
        ("%", "column_2", False),
        ("p", "air", True),
    ]
    with pytest.raises(InputError, match=r"known\[1\]\.name: is defined twice; found 'a_b'"):
        axis_from(changed(known=[{"column": "a b"}, {"column": "a-b"}]))


@pytest.mark.parametrize(("turn", "travel"), [("motor", 0.005), ("screw", 0.01)])
def test_a_turn_of_cogging_is_that_of_the_motor_or_of_the_screw(turn, travel):
    transmission = {"gear_ratio": 2.0, "lead": "10 mm"}
    axis = axis_from(
        changed(transmission=transmission, cogging=[{"turn": turn, "harmonics": [12, 6, 12]}])
    )
    assert (axis.cogging[0].turn, axis.cogging[0].harmonics) == (pytest.approx(travel), (6, 12))
    assert (
        axis_from(
            changed(transmission=transmission, cogging=[{"turn": turn, "harmonics": "identify"}])
        )
        .cogging[0]
        .harmonics
        is None
    )
    with pytest.raises(
        InputError, match=r"cogging\[0\]\.turn: needs the travel of the axis per turn"
    ):
        axis_from(changed(cogging=[{"turn": turn, "harmonics": [6]}]))
    with pytest.raises(InputError, match=r"cogging\[1\]\.turn: is defined twice"):
        axis_from(
            changed(transmission=transmission, cogging=2 * [{"turn": turn, "harmonics": [6]}])
        )


def test_the_movement_per_radian_is_known_for_rotational_axes_and_with_a_lead():
    assert axis_from(changed()).arm is None
    assert axis_from(
        changed(transmission={"gear_ratio": 2.0, "lead": "10 mm"})
    ).arm == pytest.approx(0.005 / (2.0 * math.pi))
    turning = {
        "schema": 1,
        "kind": "rotational",
        "columns": {"position": {"column": "q", "unit": "rad", "side": "load"}},
    }
    assert axis_from(turning | {"transmission": {"gear_ratio": 50}}).arm == pytest.approx(0.02)


def test_the_cycle_of_a_controller_is_read_and_written():
    text = (
        b'schema = 1\nkind = "translational"\n[columns]\ntime = { column = "t", unit = "s" }\nposition = { column = "q", unit = "m" }\n'
        b'effort = { column = "u", unit = "N" }\n[controller]\nmodel = "cascade"\nk_p = "60 1/s"\nk_v = "500 N*s/m"\n'
    )
    assert read_axis(text).cycle is None
    axis = read_axis(text + b'cycle = "0.25 ms"\n')
    assert (axis.cycle, axis.controller.values["k_p"]) == (pytest.approx(2.5e-4), 60.0)
    assert read_axis(axis_text(replace(axis, text=b""), None)).cycle == axis.cycle
    with pytest.raises(InputError, match=r"controller.cycle: .*found '0 s'"):
        read_axis(text + b'cycle = "0 s"\n')

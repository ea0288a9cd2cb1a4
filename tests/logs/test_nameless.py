"""Columns without names: roles with their evidence, on simulated joints and on measured logs without their headers."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from bristle.core import Content, InputError
from bristle.files import axes_in, propose_axis
from bristle.logs import read_log
from bristle.logs.nameless import is_nameless, proposed_roles
from bristle.logs.readers import read_table
from bristle.report.log import inspect_log

DT = 2e-3
T = np.arange(0.0, 12.0, DT)


@dataclass
class Joint:
    """Angle, speed and effort of a joint with inertia, friction and gravity."""

    seed: int
    gravity: float = 5.0

    def __post_init__(self):
        rng = np.random.default_rng(self.seed)
        rates, phases, sizes = (
            rng.uniform(0.5, 4.0, 4),
            rng.uniform(0.0, 6.0, 4),
            rng.uniform(0.2, 0.6, 4),
        )
        parts = [
            sizes * rates**n * np.sin(np.outer(T, rates) + phases + 0.5 * np.pi * n)
            for n in range(3)
        ]
        self.q, self.v, a = (part.sum(axis=1) for part in parts)
        self.u = (
            0.2 * a
            + np.sign(self.v)
            + 0.4 * self.v
            + self.gravity * np.sin(self.q)
            + 0.02 * rng.normal(size=T.size)
        )


def table_of(*columns, separator=","):
    rows = "\n".join(
        separator.join(f"{cell:.8g}" for cell in row) for row in np.column_stack(columns)
    )
    return f"{rows}\n".encode()


def roles(data):
    return {
        entry.column.removeprefix("column_"): (entry.role, entry.joint)
        for entry in proposed_roles(read_table(data))
    }


ONE = Joint(1)


NOISE = np.random.default_rng(0).normal(size=(4, T.size))


@pytest.mark.parametrize(
    ("columns", "separator", "expected"),
    [
        ((T, ONE.q, ONE.v, ONE.u), ",", ["time", "position", "velocity", "effort"]),
        ((ONE.u, np.degrees(ONE.q)), " ", ["effort", "position"]),
        # An acceleration is neither a velocity nor an effort.
        (
            (T, np.gradient(ONE.v, DT), ONE.v, ONE.q, ONE.u),
            ",",
            ["time", "", "velocity", "position", "effort"],
        ),
        # Of two almost equal columns the earlier is the reference.
        ((ONE.q[:-4], ONE.q[4:], ONE.u[:-4]), ",", ["position", "reference", "effort"]),
        ((ONE.q[:-20], ONE.q[20:], ONE.u[:-20]), ",", ["position", "reference", "effort"]),
        ((T, *NOISE), ",", ["time", "", "", "", ""]),
    ],
)
def test_a_matrix_of_one_axis_is_recognised_by_its_signals(columns, separator, expected):
    result = roles(table_of(*columns, separator=separator))
    assert list(result.values()) == [(role, 0 if role in ("", "time") else 1) for role in expected]


def in_blocks(joints):
    return [signal for name in "qvu" for signal in (getattr(joint, name) for joint in joints)]


def by_joint(joints):
    return [getattr(joint, name) for joint in joints for name in "uvq"]


@pytest.mark.parametrize("arranged", [in_blocks, by_joint])
def test_each_effort_belongs_to_the_joint_whose_direction_it_follows(arranged):
    joints = [Joint(seed) for seed in (1, 2, 3)]
    joints[1].u += 3.0 * np.sin(joints[0].q) + 0.3 * np.gradient(joints[2].v, DT)  # coupling
    names = {"q": "position", "v": "velocity", "u": "effort"}
    expected = {
        id(getattr(joint, name)): (role, number)
        for number, joint in enumerate(joints)
        for name, role in names.items()
    }
    columns = arranged(joints)
    _, *found = roles(table_of(T, *columns)).values()
    assert [role for role, _ in found] == [expected[id(column)][0] for column in columns]
    # A joint has one number, whichever it is.
    pairs = {
        (expected[id(column)][1], joint) for column, (_, joint) in zip(columns, found, strict=True)
    }
    assert sorted(number for number, _ in pairs) == [0, 1, 2]
    assert sorted(joint for _, joint in pairs) == [1, 2, 3]


def test_a_reversed_effort_a_constant_and_a_counter_are_stated():
    data = table_of(T, ONE.q, -ONE.u, np.full(T.size, 24.0), np.arange(T.size))
    entries = {entry.column: entry for entry in proposed_roles(read_table(data))}
    assert entries["column_3"].evidence.endswith("its sign is reversed")
    stated = [(entries[name].role, entries[name].evidence) for name in ("column_4", "column_5")]
    assert stated == [("", "it is constant"), ("", "it counts the rows")]
    assert (entries["column_2"].low, entries["column_2"].high) == pytest.approx(
        (ONE.q.min(), ONE.q.max()), rel=1e-6
    )


def test_names_with_a_meaning_are_no_numbers():
    assert not is_nameless(read_table(b"q1,q2\n" + table_of(ONE.q, ONE.v)))
    assert is_nameless(read_table(table_of(ONE.q, ONE.v)))


@pytest.mark.parametrize(
    ("heads", "unit"),
    [
        ("t,q1 [deg],q2 [deg],u1 [N*m],u2 [N*m]", 'position = { unit = "deg" }'),
        ("t,phi_1,phi_2,tau_1,tau_2", 'position = { unit = "?" }'),
        # Recognised by the signals only.
        ("t,J1_act,J2_act,J1_cur,J2_cur", 'position = { unit = "?" }'),
    ],
)
def test_numbered_names_are_joints(heads, unit):
    joints = [Joint(1), Joint(2)]
    data = table_of(T, *(joint.q for joint in joints), *(joint.u for joint in joints))
    proposal = propose_axis(f"{heads}\n".encode() + data)
    names = [head.partition(" ")[0] for head in heads.split(",")]
    found = {(entry.role, entry.joint): entry.column for entry in proposal.roles if entry.joint}
    expected = [("position", 1), ("position", 2), ("effort", 1), ("effort", 2)]
    assert found == dict(zip(expected, names[1:], strict=True))
    assert unit in proposal.text
    assert proposal.text.count("[[joint]]") == 2


def test_two_joints_give_an_axis_file_with_two_tables_and_no_channels(tmp_path):
    joints = [Joint(1), Joint(2)]
    path = tmp_path / "arm.csv"
    path.write_bytes(table_of(T, *in_blocks(joints)))
    inspected = inspect_log(path)
    assert inspected.summary["channels"] == []
    assert "uses no column before you accept its role" in inspected.summary["notes"][0]
    proposed = json.loads(json.dumps(inspected.summary["proposal"]))
    assert [entry["role"] for entry in proposed["roles"]][:2] == ["time", "position"]
    assert proposed["missing"] == [
        "columns.position.unit",
        "columns.velocity.unit",
        "columns.effort.unit",
    ]
    text = propose_axis(path).text
    assert text.count("[[joint]]") == 2
    for unit in ("rad", "rad/s", "N*m"):
        text = text.replace('unit = "?"', f'unit = "{unit}"', 1)
    axes = axes_in(Content(tmp_path / "axis.toml", text.encode()))
    assert list(axes) == ["joint_1", "joint_2"]
    for axis, joint in zip(axes.values(), joints, strict=True):
        log = read_log(path, axis)
        assert axis.kind == "rotational"
        np.testing.assert_allclose(
            [log.position.values, log.effort.values], [joint.q, joint.u], rtol=1e-7, atol=1e-6
        )


def test_a_log_without_names_is_refused_with_the_command_that_proposes_roles():
    with pytest.raises(InputError, match=r"bristle log LOG --write AXIS\.toml"):
        read_log(table_of(T, ONE.q, ONE.u))


MEASURED = Path(os.environ.get("BRISTLE_DATA", "missing"))
needs_data = pytest.mark.skipif(not MEASURED.exists(), reason="no measured logs")


@needs_data
@pytest.mark.parametrize("mixed", [False, True])
def test_the_columns_of_a_measured_robot_are_recognised(mixed):
    data = np.load(MEASURED / "industrial_robot" / "robot.npz")
    angles, efforts = (data[name][:, ::2] for name in ("y_train", "u_train"))
    if mixed:
        columns = [signal for pair in zip(efforts, angles, strict=True) for signal in pair]
        expected = [(role, joint) for joint in range(1, 7) for role in ("effort", "position")]
    else:
        columns, expected = (
            [*angles, *efforts],
            [(role, joint) for role in ("position", "effort") for joint in range(1, 7)],
        )
    assert list(roles(table_of(*columns)).values()) == expected


@needs_data
def test_the_columns_of_a_measured_ball_screw_are_recognised():
    data = {
        name: np.ravel(values)
        for name, values in scipy.io.loadmat(MEASURED / "emps" / "DATA_EMPS.mat").items()
        if name in ("t", "qm", "qg", "vir")
    }
    result = roles(table_of(data["t"], data["vir"], data["qm"], data["qg"]))
    assert [role for role, _ in result.values()] == ["time", "effort", "position", "reference"]


@needs_data
def test_the_columns_of_a_measured_motor_are_recognised():
    data = np.genfromtxt(MEASURED / "cogging" / "acc_current.txt", delimiter=",", skip_header=1)
    assert [role for role, _ in roles(table_of(*data[:, :4].T)).values()] == [
        "time",
        "position",
        "velocity",
        "effort",
    ]


def test_the_arrays_of_a_matlab_file_are_joints(tmp_path):
    rng, place = np.random.default_rng(0), tmp_path / "arm.mat"
    angles, efforts = rng.normal(size=(2, 3, 400)).cumsum(axis=2)
    scipy.io.savemat(
        place, {"u_train": efforts, "y_train": angles, "time_train": DT * np.arange(400)}
    )
    proposal = propose_axis(place)
    assert proposal.joints == 3
    text = proposal.text.replace('position = { unit = "?" }', 'position = { unit = "deg" }')
    axes = axes_in(
        Content(
            tmp_path / "joints.toml",
            text.replace('effort = { unit = "?" }', 'effort = { unit = "N*m" }').encode(),
        )
    )
    columns = [
        [axis.columns[channel].name for channel in ("position", "effort")] for axis in axes.values()
    ]
    assert columns == [[f"y_train[{joint}]", f"u_train[{joint}]"] for joint in range(3)]
    np.testing.assert_allclose(read_log(place, list(axes.values())[1]).effort.values, efforts[1])


def test_the_array_of_the_states_of_one_axis_is_no_joint(tmp_path):
    place = tmp_path / "axis.mat"
    scipy.io.savemat(place, {"u": np.sin(T), "y": np.stack([np.sin(T), np.cos(T)]), "time": T})
    assert propose_axis(place).joints == 0

"""The public entry for an arm in Python: bodies, axes of the joints, and their friction."""

from __future__ import annotations

import numpy as np
import pytest
from tests.apps.arm.conftest import DT, Pendulum, swing

import bristle as br
from bristle.apps.arm.report import arm_sentence, joints_table

JOINTS = """schema = 1
kind = "rotational"
[columns]
time = "t"
position = { column = "q", unit = "rad" }
effort = { column = "u", unit = "N*m" }
[identification]
decimation = 4
[[joint]]
name = "hinge"
"""
INERTIA, GRAVITY, ROTOR = 0.7, 9.81 * 2.4, 0.1


class Link(Pendulum):
    """The link of a pendulum, as a robot with one joint."""

    urdf = None

    def of(self, names):
        return self

    def effort(self, bodies, q, v, a):
        return np.einsum("ijk,k->ij", self.regressor(q, v, a), bodies.ravel())


@pytest.fixture
def identified(tmp_path, monkeypatch):
    """Return the identification of a pendulum with Coulomb friction of 3 N*m, damping of 2 N*m*s/rad and a further effort."""
    monkeypatch.setattr("bristle.apps.arm.identify.read_robot", lambda content: Link())

    def of(further=lambda q: 0.0 * q, joints=JOINTS, pressure=0.0, begin=0.0, seconds=40.0):
        t, q, v, a = swing(1, seconds, seed=3, amplitude=1.2)
        push = np.sin(5.0 * t)
        effort = (
            (INERTIA + ROTOR) * a
            + GRAVITY * np.sin(q)
            + 3.0 * np.sign(v)
            + 2.0 * v
            + further(q)
            + pressure * push[:, None]
        )
        np.savetxt(
            tmp_path / "arm.csv",
            np.column_stack([begin + t, q, effort, push]),
            "%.15g",
            ",",
            header="t,q,u,p",
            comments="",
        )
        (tmp_path / "arm.urdf").write_text("<robot/>")
        (tmp_path / "joints.toml").write_text(joints)
        return br.arm.identify_arm(
            tmp_path / "arm.csv", tmp_path / "arm.urdf", str(tmp_path / "joints.toml")
        )

    return of


@pytest.fixture
def arm(identified):
    return identified()


@pytest.mark.slow
def test_two_lines_of_python_identify_the_friction_of_each_joint(arm, tmp_path):
    axes = arm.write(tmp_path / "arm")
    assert [axis.name for axis in axes] == ["hinge"]
    assert "only in a sum with bodies" in (tmp_path / "arm" / "joints" / "hinge.toml").read_text()
    assert joints_table(arm).rows[0][-1].endswith("(only in a sum)")
    (axis,) = axes
    result = br.identify(
        tmp_path / "arm.csv", "coulomb_viscous", axis=axis, draws=0, method="inverse_dynamics"
    )
    assert type(result).__name__ == "Identified"
    assert result.best.parameters["F_C"].value == pytest.approx(3.0, rel=0.05)
    assert result.best.parameters["F_v"].value == pytest.approx(2.0, rel=0.1)
    assert result.best.parameters["known_arm"].value == 1.0


def test_a_file_without_joints_is_refused(arm, tmp_path):
    (tmp_path / "joints.toml").write_text(JOINTS.partition("[[joint]]")[0])
    with pytest.raises(br.core.InputError, match="joint: is missing"):
        br.arm.identify_arm(tmp_path / "arm.csv", tmp_path / "arm.urdf", tmp_path / "joints.toml")


def gravity_of(arm):
    return {entry.name: 9.81 * entry.value for entry in arm.dynamics.base}["hinge.mc_x"]


@pytest.mark.parametrize("line", ["", 'plant = { spring = "cubic" }'])
def test_a_cable_is_found_and_does_not_bend_the_bodies(identified, line):
    arm = identified(lambda q: 6.0 * q + 4.0 * q**2 + 8.0 * q**3, f"{JOINTS}{line}")
    assert arm.pulled == (() if line else ("hinge",))
    assert arm.tables["hinge"]["plant"]["spring"] == "cubic"
    assert gravity_of(arm) == pytest.approx(GRAVITY, rel=0.15)  # 1.6 of it without the cable
    assert ("spring or cable on hinge" in arm_sentence(arm)) is not bool(line)


@pytest.mark.parametrize("further", [lambda q: 0.0 * q, lambda q: 8.0 * q**3])
def test_no_spring_without_a_cable_or_against_the_axis_file(identified, further):
    final = JOINTS.replace("decimation = 4", "decimation = 4\nsettings = { lines_gain = 1 }")
    arm = identified(further, JOINTS if further(2.0) == 0.0 else final)
    assert (arm.pulled, "plant" in arm.tables["hinge"]) == ((), False)


def test_a_known_column_does_not_bend_the_bodies(identified):
    arm = identified(joints=f'{JOINTS}[[joint.known]]\ncolumn = "p"\n', pressure=20.0)
    assert gravity_of(arm) == pytest.approx(GRAVITY, rel=0.02)


@pytest.mark.slow
def test_an_arm_needs_neither_kind_nor_times_in_its_log(identified, tmp_path):
    joints = JOINTS.replace('kind = "rotational"\n', "").replace('time = "t"\n', "")
    arm = identified(joints=f"{joints}timing = {{ sample_time = {DT} }}\n")
    (axis,) = arm.write(tmp_path / "arm")
    assert axis.mass == pytest.approx(arm.dynamics.rotors[0])
    result = br.identify(
        tmp_path / "arm.csv", "coulomb_viscous", axis=axis, draws=0, method="inverse_dynamics"
    )
    assert result.best.parameters["F_C"].value == pytest.approx(3.0, rel=0.05)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("begin", "span"), [(1.7e9, ""), (7.0, '[log]\nspan = ["9 s", "29 s"]\n')])
def test_an_arm_is_identified_on_any_stretch_of_time(identified, tmp_path, begin, span):
    arm = identified(
        joints=JOINTS.replace("[[joint]]", f"{span}[[joint]]"), begin=begin, seconds=30.0
    )
    (axis,) = arm.write(tmp_path / "arm")
    result = br.identify(
        tmp_path / "arm.csv", "coulomb_viscous", axis=axis, draws=0, method="inverse_dynamics"
    )
    assert result.best.parameters["F_C"].value == pytest.approx(3.0, rel=0.05)

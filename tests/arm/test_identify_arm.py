"""The public entry for an arm in Python: bodies, axes of the joints, and their friction."""

from __future__ import annotations

import numpy as np
import pytest
from tests.arm.conftest import DT, Pendulum, swing

import bristle as br
from bristle.core import InputError
from bristle.report.arm import joints_table

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
def arm(tmp_path, monkeypatch):
    """Return an identified pendulum with Coulomb friction of 3 N*m and damping of 2 N*m*s/rad."""
    monkeypatch.setattr("bristle.arm.identify.read_robot", lambda content: Link())
    _, q, v, a = swing(1, 40.0, seed=3, amplitude=1.2)
    effort = (INERTIA + ROTOR) * a + GRAVITY * np.sin(q) + 3.0 * np.sign(v) + 2.0 * v
    rows = np.column_stack([DT * np.arange(len(q)), q, effort])
    np.savetxt(tmp_path / "arm.csv", rows, "%.12g", ",", header="t,q,u", comments="")
    (tmp_path / "arm.urdf").write_text("<robot/>")
    (tmp_path / "joints.toml").write_text(JOINTS)
    return br.arm.identify_arm(tmp_path / "arm.csv", tmp_path / "arm.urdf", str(tmp_path / "joints.toml"))


def test_two_lines_of_python_identify_the_friction_of_each_joint(arm, tmp_path):
    axes = arm.write(tmp_path / "arm")
    assert [axis.name for axis in axes] == ["hinge"]
    assert "only in a sum with bodies" in (tmp_path / "arm" / "joints" / "hinge.toml").read_text()
    assert joints_table(arm).rows[0][-1].endswith("(only in a sum)")
    (axis,) = axes
    result = br.identify(tmp_path / "arm.csv", "coulomb_viscous", axis=axis, draws=0, method="inverse_dynamics")
    assert type(result).__name__ == "Identified"
    assert result.best.parameters["F_C"].value == pytest.approx(3.0, rel=0.05)
    assert result.best.parameters["F_v"].value == pytest.approx(2.0, rel=0.1)
    assert result.best.parameters["known_arm"].value == 1.0


def test_a_file_without_joints_is_refused(arm, tmp_path):
    (tmp_path / "joints.toml").write_text(JOINTS.partition("[[joint]]")[0])
    with pytest.raises(InputError, match="joint: is missing"):
        br.arm.identify_arm(tmp_path / "arm.csv", tmp_path / "arm.urdf", tmp_path / "joints.toml")

"""One trace of several axes, and an arm: a row for each joint, and files for other programs."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.arm.conftest import DT, swing
from tests.arm.test_robot import BODIES, URDF

import bristle as br
from bristle import friction
from bristle.arm.parameters import names_of
from bristle.arm.robot import read_robot
from bristle.core import Content
from bristle.engine.motion import along
from bristle.files import read_model

JOINTS = """
schema = 1
kind = "rotational"
[columns]
time = "t"
position = { column = "q{joint}", unit = "rad" }
effort = { column = "u{joint}", unit = "N*m" }
[identification]
decimation = 4
[[joint]]
name = "turn"
[[joint]]
name = "lift"
"""
FRICTIONS = [friction.coulomb_viscous(F_C=level, F_v=damping) for level, damping in ((6.0, 3.0), (3.0, 2.0))]


def write_trace(folder, q, v, effort):
    rows = np.column_stack([DT * np.arange(len(q)), q, effort])
    np.savetxt(folder / "arm.csv", rows, "%.12g", ",", header="t,q1,q2,u1,u2", comments="")
    (folder / "joints.toml").write_text(JOINTS)


def friction_of(q, v):
    signals = [np.ascontiguousarray(signal) for signal in (v.T, (q + 0.5 * DT * v).T)]
    return np.stack([along(model, dt=DT, v=v, x=x) for model, v, x in zip(FRICTIONS, *signals, strict=True)], axis=1)


@pytest.mark.usefixtures("undrawn")
def test_each_axis_of_a_trace_is_a_row_and_a_model(tmp_path, monkeypatch, bristle):
    monkeypatch.chdir(tmp_path)
    _, q, v, a = swing(2, 16.0, seed=3)
    write_trace(tmp_path, q, v, friction_of(q, v) + a * [2.0, 0.5])
    ended = bristle("identify", "arm.csv", "--axis", "joints.toml", "--draws", 0, "--workers", 1, "--out", "out")
    assert ended.code == 0, ended.err
    data = br.read_study("out")
    assert data["log"].values.tolist() == ["turn: arm.csv", "lift: arm.csv"]
    assert data["plant.M"].values == pytest.approx([2.0, 0.5], rel=0.02)
    assert data["friction.F_C"].values == pytest.approx([6.0, 3.0], rel=0.05)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["verdict"]["words"] == "Axes identified"
    assert (tmp_path / "out/turn/model.toml").exists()
    repeated = bristle("identify", "arm.csv", "--axis", "joints.toml", "--draws", 0, "--workers", 1, "--out", "out")
    assert (repeated.code, len(list((tmp_path / "out/runs").iterdir()))) == (0, 2)
    assert read_model("out/lift/model.toml").friction.values["F_C"] == data["friction.F_C"].values[1]


def check_another_log(folder, robot, bristle):
    """Predict a motion with more weight on its bodies, in one command; the files of the joints belong to their own log."""
    (folder / "arm.csv").rename(folder / "first.csv")
    _, q, v, a = swing(2, 20.0, seed=11, amplitude=0.9)
    effort = robot.effort(BODIES, q, v, a) + friction_of(q, v) + a * [0.2, 0.1]
    write_trace(folder, q, v, effort)
    ended = bristle("predict", "out", "arm.csv", "--out", "second", "--json")
    assert ended.code == 0, ended.err
    errors = {name: entry["metrics"]["force_error_percent"] for name, entry in ended.data["joints"].items()}
    assert set(errors) == {"turn", "lift"}
    assert all(0.0 < error < 3.0 for error in errors.values()), errors
    assert all(50.0 < entry["inside_band_percent"] <= 100.0 for entry in ended.data["joints"].values())
    assert ended.data["verdict"]["words"] == "The model is valid"
    table = bristle("predict", "out", "arm.csv").out
    assert [line.split()[0] for line in table.splitlines() if line.strip().endswith("The model is valid")] == ["turn", "lift"]
    assert "lift" in (folder / "second/report.html").read_text()
    assert (folder / "second/lift/report.html").exists()
    of_first = bristle("predict", "out", "first.csv", "--json").data
    assert of_first["verdict"]["level"] == "with_care"
    assert "the model was fitted to this log" in of_first["verdict"]["reasons"][0]
    for axis, message in (
        ("out/joints/lift.toml", "known[0].file: holds the efforts of the bodies along another log"),
        ("joints.toml", "joint: this axis file describes several joints"),
    ):
        refused = bristle("predict", "out/lift/model.toml", "arm.csv", "--axis", axis)
        assert refused.code == 2
        assert message in " ".join(refused.err.split())
        assert "bristle predict DIR LOG" in " ".join(refused.err.split())
    no_arm = bristle("predict", "second", "arm.csv")
    assert "contains no arm.toml" in " ".join(no_arm.err.split())


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_an_arm_has_bodies_joints_and_files(tmp_path, monkeypatch, bristle):
    pytest.importorskip("pinocchio", reason="the dynamics of an arm need pip install bristle[arm]")
    monkeypatch.chdir(tmp_path)
    _, q, v, a = swing(2, 60.0, seed=5, amplitude=1.2)
    (tmp_path / "arm.urdf").write_text(URDF)
    robot = read_robot(Content(Path("arm.urdf"), URDF.encode()))
    write_trace(tmp_path, q, v, robot.effort(BODIES, q, v, a) + friction_of(q, v) + a * [0.2, 0.1])
    words = ["identify", "arm.csv", "--robot", "arm.urdf", "--axis", "joints.toml", "--model", "coulomb_viscous"]
    ended = bristle(*words, "--draws", 20, "--workers", 1, "--out", "out")
    assert ended.code == 0, ended.err
    base = json.loads((tmp_path / "out/summary.json").read_text())["arm"]["base_parameters"]
    names = dict(zip(names_of(("turn", "lift")), [0.2, 0.1, *BODIES.ravel().tolist()], strict=True))
    for name, entry in base.items():
        true = sum(factor * names[part] for part, factor in entry["sum_of"].items())
        assert entry["value"] == pytest.approx(true, abs=max(3.0 * entry["half_width"], 0.01)), name
    data = br.read_study("out")
    assert data["friction.F_C"].values == pytest.approx([6.0, 3.0], rel=0.1)
    assert set(data["plant.known_arm"].values) == {1.0}
    again = bristle("identify", "arm.csv", "--axis", "out/joints/lift.toml", "--model", "coulomb_viscous", "--draws", 0, "--json")
    assert json.loads(again.out)["parameters"]["F_C"]["value"] == data["friction.F_C"].values[1]
    assert 'frictionloss="' in (tmp_path / "out/arm.xml").read_text()
    check_another_log(tmp_path, robot, bristle)
    assert (tmp_path / "out/arm.urdf").read_text().count("<inertial>") == 2


def test_a_robot_needs_joints_and_one_log(here, bristle):
    pytest.importorskip("pinocchio", reason="the dynamics of an arm need pip install bristle[arm]")
    _, q, v, a = swing(2, 5.0)
    write_trace(here, q, v, a)
    (here / "arm.urdf").write_text(URDF)
    (here / "plain.toml").write_text(JOINTS.partition("[[joint]]")[0].replace("{joint}", "1"))
    command = ["identify", "arm.csv", "--robot", "arm.urdf", "--out", "out"]
    for more, message in (
        (["--axis", "plain.toml"], "joint: is missing"),
        ([], "needs one log of all joints and one axis file"),
        (["--axis", "joints.toml", "--axis", "joints.toml"], "needs one log of all joints and one axis file"),
    ):
        ended = bristle(*command, *more)
        assert ended.code == 2
        assert message in " ".join(ended.err.split())
    assert not (here / "out").exists()


def test_without_pinocchio_the_command_names_the_extra(here, monkeypatch, bristle):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    _, q, v, a = swing(2, 5.0)
    write_trace(here, q, v, a)
    (here / "arm.urdf").write_text(URDF)
    ended = bristle("identify", "arm.csv", "--robot", "arm.urdf", "--axis", "joints.toml", "--out", "out")
    assert ended.code != 0
    assert 'pip install "bristle[arm]"' in " ".join(ended.err.split())

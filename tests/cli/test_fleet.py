"""Several logs, axes and runs in one command: ``identify --each``, an arm, ``study``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from tests.apps.arm.conftest import DT, swing
from tests.apps.arm.test_robot import BODIES, URDF
from tests.apps.study.conftest import STUDY, Bench
from tests.apps.study.fleet.conftest import write_log
from tests.cli.conftest import progress_in_range
from tests.report.pages import Page

import bristle as br
from bristle.apps.arm.parameters import names_of
from bristle.apps.arm.robot import read_robot
from bristle.engine.motion import along

# --- a fleet ---------------------------------------------------------------------------------------------------------


AXIS = """
schema = 1
name = "press"
kind = "translational"
columns.time = { column = "time", unit = "s" }
columns.position = { column = "position", unit = "m" }
columns.effort = { column = "effort", unit = "N" }
columns.temperature = { column = "temperature", unit = "K" }
plant.mass = "12 kg"
"""
EACH = ("identify", "logs", "--each", "--axis", "axis.toml", "--draws", "0", "--workers", "1")


@pytest.fixture
def at(tmp_path, monkeypatch):
    """A folder with an axis file, a log, and a log that is cut off."""
    (tmp_path / "axis.toml").write_text(AXIS)
    write_log(tmp_path / "logs/left/left_2026-03-01.csv", rows=1500)
    (tmp_path / "logs/left/left_2026-03-17.csv").write_text("time,position\n0.0")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_each_log_is_a_row_and_the_axis_that_differs_is_named(bristle, at):
    rng = np.random.default_rng(8)
    for name in ("left", "right"):
        for day in range(1, 17):
            size = (
                5.0
                * (1.0 + 0.01 * rng.standard_normal())
                * (1.2 if name == "right" and day >= 11 else 1.0)
            )
            write_log(
                at / "logs" / name / f"{name}_2026-03-{day:02d}.csv", size, seed=day, rows=1500
            )
    text = bristle(
        *EACH,
        "--out",
        "fleet",
        code=0,
        shown=("32 of 33 logs were identified, 1 failed.", "left_2026-03-17.csv"),
    )
    summary = json.loads((at / "fleet" / "summary.json").read_text())
    assert (summary["logs"], summary["done"], summary["statuses"]) == (
        33,
        33,
        {"ok": 32, "refused": 1},
    )
    level = summary["parameters"]["friction.F_C"]
    assert level["count"] == 32
    assert level["median"] == pytest.approx(5.0, rel=0.03)
    assert {entry["folder"] for entry in level["apart"]} == {"right"}
    page = Page((at / "fleet" / "report.html").read_text())
    assert page.unbalanced == []
    assert "left_2026-03-17.csv" in page.words
    assert "friction.F_C" in page.words
    named = next(
        line for line in text.out.splitlines() if line.startswith("Outliers among the logs")
    )
    assert "from right in friction.F_C" in named
    assert "of left in friction.F_C" not in named


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (EACH, "needs a folder to write into"),
        ((*EACH, "--out", "x", "--force"), "cannot replace the results of --each"),
        (
            (*EACH, "--out", "x", "--format", "svg"),
            "with --each, the results have no figures. Read the rows",
        ),
        (("identify", "logs/left/left_2026-03-01.csv", "--workers", "2"), "applies to --each only"),
        (
            ("watch", "fleet", "--out", "watched"),
            "bristle watch was removed. Use bristle identify LOGS --each",
        ),
    ],
)
def test_conflicting_options_are_refused(bristle, at, options, message):
    bristle(*options, code=2, said=message)


def test_a_fleet_without_a_fitted_log_exits_with_1(bristle, at):
    (at / "logs/left/left_2026-03-01.csv").unlink()
    bristle(*EACH, "--out", "none", code=1, shown="0 of 1 logs were identified, 1 failed.")


@pytest.mark.slow
def test_a_broken_link_does_not_end_a_fleet(bristle, at):
    (at / "logs/left/left_2026-03-02.csv").symlink_to(at / "nowhere.csv")
    bristle(*EACH, "--out", "links", code=0, shown="1 of 3 logs were identified, 2 failed.")


# --- an arm ----------------------------------------------------------------------------------------------------------


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
FRICTIONS = [
    br.friction.coulomb_viscous(F_C=level, F_v=damping)
    for level, damping in ((6.0, 3.0), (3.0, 2.0))
]


def write_trace(folder, q, v, effort):
    rows = np.column_stack([DT * np.arange(len(q)), q, effort])
    np.savetxt(folder / "arm.csv", rows, "%.12g", ",", header="t,q1,q2,u1,u2", comments="")
    (folder / "joints.toml").write_text(JOINTS)


def friction_of(q, v):
    signals = [np.ascontiguousarray(signal) for signal in (v.T, (q + 0.5 * DT * v).T)]
    return np.stack(
        [along(model, dt=DT, v=v, x=x) for model, v, x in zip(FRICTIONS, *signals, strict=True)],
        axis=1,
    )


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_each_axis_of_a_trace_is_a_row_and_a_model(tmp_path, monkeypatch, bristle):
    monkeypatch.chdir(tmp_path)
    _, q, v, a = swing(2, 16.0, seed=3)
    write_trace(tmp_path, q, v, friction_of(q, v) + a * [2.0, 0.5])
    bristle(
        "identify",
        "arm.csv",
        "--axis",
        "joints.toml",
        "--draws",
        0,
        "--workers",
        1,
        "--out",
        "out",
        code=0,
    )
    data = br.read_study("out")
    assert data["log"].values.tolist() == ["turn: arm.csv", "lift: arm.csv"]
    assert data["plant.M"].values == pytest.approx([2.0, 0.5], rel=0.02)
    assert data["friction.F_C"].values == pytest.approx([6.0, 3.0], rel=0.05)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["verdict"]["words"] == "Axes identified"
    assert (tmp_path / "out/turn/model.toml").exists()
    repeated = bristle(
        "identify", "arm.csv", "--axis", "joints.toml", "--draws", 0, "--workers", 1, "--out", "out"
    )
    assert (repeated.code, len(list((tmp_path / "out/runs").iterdir()))) == (0, 2)
    assert (
        br.read_model("out/lift/model.toml").friction.values["F_C"]
        == data["friction.F_C"].values[1]
    )


def check_another_log(folder, robot, bristle):
    """Predict a motion with more weight on its bodies, in one command; the files of the joints belong to their own log."""
    (folder / "arm.csv").rename(folder / "first.csv")
    _, q, v, a = swing(2, 20.0, seed=11, amplitude=0.9)
    effort = robot.effort(BODIES, q, v, a) + friction_of(q, v) + a * [0.2, 0.1]
    write_trace(folder, q, v, effort)
    ended = bristle("predict", "out", "arm.csv", "--out", "second", "--json", code=0)
    errors = {
        name: entry["metrics"]["force_error_percent"]
        for name, entry in ended.data["joints"].items()
    }
    assert set(errors) == {"turn", "lift"}
    assert all(0.0 < error < 3.0 for error in errors.values()), errors
    assert all(
        50.0 < entry["inside_band_percent"] <= 100.0 for entry in ended.data["joints"].values()
    )
    assert ended.data["verdict"]["words"] == "The model is valid"
    table = bristle("predict", "out", "arm.csv").out
    assert [
        line.split()[0]
        for line in table.splitlines()
        if line.strip().endswith("The model is valid")
    ] == ["turn", "lift"]
    assert "lift" in (folder / "second/report.html").read_text()
    assert (folder / "second/lift/report.html").exists()
    of_first = bristle("predict", "out", "first.csv", "--json").data
    assert of_first["verdict"]["level"] == "with_care"
    assert "the model was fitted to this log" in of_first["verdict"]["reasons"][0]
    for axis, message in (
        (
            "out/joints/lift.toml",
            "known[0].file: holds the efforts of the bodies along another log",
        ),
        ("joints.toml", "joint: this axis file describes several joints"),
    ):
        bristle(
            "predict",
            "out/lift/model.toml",
            "arm.csv",
            "--axis",
            axis,
            code=2,
            said=(message, "bristle predict DIR LOG"),
        )
    bristle("predict", "second", "arm.csv", said="contains no arm.toml")


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_an_arm_has_bodies_joints_and_files(tmp_path, monkeypatch, bristle):
    pytest.importorskip("pinocchio", reason="the dynamics of an arm need pip install bristle[arm]")
    monkeypatch.chdir(tmp_path)
    _, q, v, a = swing(2, 60.0, seed=5, amplitude=1.2)
    (tmp_path / "arm.urdf").write_text(URDF)
    robot = read_robot(br.core.Content(Path("arm.urdf"), URDF.encode()))
    write_trace(tmp_path, q, v, robot.effort(BODIES, q, v, a) + friction_of(q, v) + a * [0.2, 0.1])
    words = [
        "identify",
        "arm.csv",
        "--robot",
        "arm.urdf",
        "--axis",
        "joints.toml",
        "--model",
        "coulomb_viscous",
    ]
    bristle(*words, "--draws", 20, "--workers", 1, "--out", "out", code=0)
    base = json.loads((tmp_path / "out/summary.json").read_text())["arm"]["base_parameters"]
    names = dict(zip(names_of(("turn", "lift")), [0.2, 0.1, *BODIES.ravel().tolist()], strict=True))
    for name, entry in base.items():
        true = sum(factor * names[part] for part, factor in entry["sum_of"].items())
        assert entry["value"] == pytest.approx(true, abs=max(3.0 * entry["half_width"], 0.01)), name
    data = br.read_study("out")
    assert data["friction.F_C"].values == pytest.approx([6.0, 3.0], rel=0.1)
    assert set(data["plant.known_arm"].values) == {1.0}
    again = bristle(
        "identify",
        "arm.csv",
        "--axis",
        "out/joints/lift.toml",
        "--model",
        "coulomb_viscous",
        "--draws",
        0,
        "--json",
    )
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
        (
            ["--axis", "joints.toml", "--axis", "joints.toml"],
            "needs one log of all joints and one axis file",
        ),
    ):
        bristle(*command, *more, code=2, said=message)
    assert not (here / "out").exists()


def test_without_pinocchio_the_command_names_the_extra(here, monkeypatch, bristle):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    _, q, v, a = swing(2, 5.0)
    write_trace(here, q, v, a)
    (here / "arm.urdf").write_text(URDF)
    ended = bristle(
        "identify",
        "arm.csv",
        "--robot",
        "arm.urdf",
        "--axis",
        "joints.toml",
        "--out",
        "out",
        said='pip install "bristle[arm]"',
    )
    assert ended.code != 0


# --- a study ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("bristle.apps.study.command.progress", progress_in_range)
    bench = Bench(tmp_path)
    bench.write(STUDY)
    return bench


def test_a_study_is_run_and_reported(bristle, bench, undrawn):
    words = {"said": "open out/report.html", "shown": ("90 % of the runs from", "rank correlation")}
    bristle("study", "study.toml", "--out", "out", "--workers", "1", code=0, **words)
    summary = json.loads((bench.folder / "out" / "summary.json").read_text())
    assert (summary["runs"], summary["done"], summary["statuses"]) == (12, 12, {"ok": 12})
    worst = summary["worst"]
    assert [entry["motion.peak_to_peak"] for entry in worst] == sorted(
        (entry["motion.peak_to_peak"] for entry in worst), reverse=True
    )
    assert (
        worst[0]["command"]
        == f"bristle study study.toml --run {worst[0]['run']} --out run_{worst[0]['run']}"
    )
    page = (bench.folder / "out" / "report.html").read_text()
    assert worst[0]["command"] in page
    assert summary["provenance"]["command"] == "bristle study study.toml --out out"


def test_the_numbers_are_those_of_the_run_that_is_repeated(bristle, bench, undrawn):
    kept = bristle("study", "study.toml", "--out", "out", "--workers", "1", "--json").data["worst"][
        0
    ]
    repeated = bristle(
        "study", "study.toml", "--run", kept["run"], "--json", "--out", "again", code=0
    ).data
    assert repeated["variants"]["base"]["motion"]["peak_to_peak"] == kept["motion.peak_to_peak"]
    assert repeated["run"] == kept["run"]
    table = pyarrow.parquet.read_table(bench.folder / "out" / "runs").to_pylist()[kept["run"]]
    assert repeated["seed"] == table["seed"]
    assert repeated["values"]["friction.F_C"] == table["friction.F_C"]
    assert (bench.folder / "again" / "report.html").is_file()
    assert (bench.folder / "again" / "log.csv").is_file()


@pytest.mark.slow
def test_a_report_of_a_grid_and_of_indices(bristle, bench, undrawn):
    grid = STUDY.replace("[keep]", '[grid]\n"effort.frequency" = ["2 Hz", "4 Hz"]\n[keep]')
    bench.write(grid, name="grid.toml")
    bristle("study", "grid.toml", "--out", "grid", "--workers", "1", code=0)
    page = (bench.folder / "grid" / "report.html").read_text()
    assert "effort.frequency 2" in page
    bench.write(
        STUDY.replace("runs = 12", "runs = 32").replace(
            "seed = 7", "seed = 7\nsobol_indices = true"
        ),
        "i.toml",
    )
    bristle("study", "i.toml", "--out", "indices", "--workers", "1", "--json", code=0)
    summary = json.loads((bench.folder / "indices" / "summary.json").read_text())
    assert [entry["cause"] for entry in summary["sobol_indices"]][:2] == ["friction.F_C", "plant.M"]
    assert "Sobol indices" in (bench.folder / "indices" / "report.html").read_text()


@pytest.mark.slow
def test_figures_of_a_study_replace_those_of_an_earlier_report(bristle, bench):
    bristle(
        "study",
        "study.toml",
        "--out",
        "out",
        "--workers",
        "1",
        "--format",
        "svg",
        "--format",
        "csv",
        code=0,
    )
    figures = bench.folder / "out" / "figures"
    names = {file.name for file in figures.iterdir()}
    assert {"spread.svg", "captions.txt"} <= names
    assert any(name.startswith("spread") and name.endswith(".csv") for name in names)
    page = (bench.folder / "out" / "report.html").read_text()
    assert page.count("<figure id=") == len(list(figures.glob("*.svg")))
    (figures / "mine.svg").write_text("of a person")
    bristle("study", "study.toml", "--out", "out", "--format", "pdf", code=0)
    drawn = {file.name for file in figures.iterdir()}
    assert {"mine.svg", "spread.pdf", "captions.txt"} <= drawn
    assert [name for name in drawn if name.endswith((".svg", ".csv"))] == ["mine.svg"]
    captions = (figures / "captions.txt").read_text()
    (figures / "captions.txt").write_text("of a person")
    bristle(
        "study",
        "study.toml",
        "--out",
        "out",
        "--format",
        "svg",
        code=2,
        said="were changed: figures/captions.txt",
    )
    assert (figures / "captions.txt").read_text() == "of a person"
    assert (figures / "spread.pdf").is_file()
    (figures / "captions.txt").write_text(captions)
    bristle("study", "study.toml", "--out", "out", "--format", "svg", code=0)
    assert {file.suffix for file in figures.iterdir()} == {".svg", ".txt"}
    assert (figures / "spread.svg").is_file()


def test_a_study_with_only_refused_runs_exits_with_1(bristle, bench, undrawn):
    never = '"run.settle" = { uniform = ["2 s", "3 s"] }'
    bench.write(STUDY.replace('"friction.F_C" = { normal = ["1 N", "0.1 N"] }', never))
    bristle(
        "study",
        "study.toml",
        "--out",
        "out",
        "--workers",
        "1",
        code=1,
        shown="12 of 12 runs failed: 12 refused.",
    )

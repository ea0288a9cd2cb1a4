"""``bristle demo``: the main job, start to finish, openly on a simulated axis."""

import importlib
import json
import os
import re
import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cli.conftest import written_in
from tests.docs.conftest import ROOT

from bristle.cli.demonstration import axis_simulated, truth
from bristle.cli.demonstration.axis_simulated import SAMPLE_TIME, motion
from bristle.cli.demonstration.run import BANNER, FITTED, UNSEEN, run
from bristle.core.contracts import Motion
from bristle.core.diagnostic import BestSoFar
from bristle.files.results import results_folder
from bristle.models.friction.irregular import spectrum


@pytest.mark.slow
def test_the_main_job_from_one_command(bristle, here):
    page = (ROOT / "docs" / "index.md").read_text()
    block = " ".join(re.search(r"```text\n(Type in.*?)```", page, re.DOTALL)[1].split())
    values, feedforward, rest = block.partition("Feedforward")
    bristle(
        "demo",
        code=0,
        shown=("simulated", "bristle identify YOUR.csv", values.strip(), feedforward + rest),
    )
    folder = Path("bristle-demo")
    assert written_in(folder) == {
        "axis.toml",
        "log.csv",
        "unseen.csv",
        "model.toml",
        "summary.json",
        "report.html",
        "drive_table.csv",
        "friction_curve.csv",
        "draws.parquet",
        "traces.parquet",
        "experiment.toml",
        "loop.csv",
    }
    assert "A simulated axis." in (folder / "report.html").read_text()
    assert json.loads((folder / "summary.json").read_text())["simulated"] is True
    assert "passive" in json.loads((folder / "summary.json").read_text())["certificates"]
    assert "Certificates of" in (folder / "report.html").read_text()

    # What the page on compensation tells of it is what it found.
    page = (ROOT / "docs" / "theory" / "compensation.md").read_text().replace("\n", " ")
    message = re.search(
        r"`bristle demo`.*?from ([\d.]+) mm as recorded to ([\d.]+) µm with .*?, and to ([\d.]+) µm",
        page,
    )
    loops = json.loads((folder / "summary.json").read_text())["compensation"]
    result = [
        loops[name]["following_error"]["peak_to_peak"]
        for name in ("as_recorded", "feedforward", "compensated")
    ]
    assert result == pytest.approx(
        [1e-3 * float(message[1]), 1e-6 * float(message[2]), 1e-6 * float(message[3])], rel=0.02
    )

    # What it wrote serves the other commands, and they agree with it.
    draws = json.loads((folder / "summary.json").read_text())["resampling"]["draws"]
    again = bristle(
        "identify",
        folder / "log.csv",
        "--axis",
        folder / "axis.toml",
        "--draws",
        str(draws),
        "--json",
    ).data
    values, values_again = (
        {
            model["name"]: {
                name: parameter["value"] for name, parameter in model["parameters"].items()
            }
            for model in summary["models"]
        }
        for summary in (json.loads((folder / "summary.json").read_text()), again)
    )
    assert values == values_again
    predicted = bristle(
        "predict",
        folder / "model.toml",
        folder / "unseen.csv",
        "--axis",
        folder / "axis.toml",
        "--mode",
        "closed-loop",
        "--json",
    )
    summary = json.loads((folder / "summary.json").read_text())
    assert predicted.data["metrics"] == summary["prediction"]["metrics"]


def test_a_place_that_was_named_is_kept_without_force(bristle, here):
    with results_folder("mine") as folder:
        folder.write("summary.json", "{}")
    bristle("demo", "--out", "mine", code=2, said="--force")
    assert (here / "mine" / "summary.json").read_text() == "{}"


@pytest.mark.slow
def test_an_interruption_of_its_identification_ends_it(bristle, here, monkeypatch):
    def interrupted(*values):
        os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(BestSoFar, "see", interrupted)
    outside = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        ended = bristle("demo")
    finally:
        signal.signal(signal.SIGTERM, outside)
    assert (ended.code, list(here.iterdir())) == (143, [])


# --- what it does one after the other, with the work itself left out -------------------------------------------------


# The package has the function by that name.
module = importlib.import_module("bristle.cli.demonstration.run")


class Folder:
    """A folder of results that notes what is written into it."""

    def __init__(self, path):
        self.path, self.written = path, {}

    def __truediv__(self, name):
        return self.path / name

    def write(self, name, content):
        self.written[name] = content
        (self.path / name).write_bytes(content)


def shown(monkeypatch, tmp_path):
    """The demonstration, what it reported, and what each part of its work was asked for."""
    reports, asked = [], {}
    outcome = SimpleNamespace(
        summary={"fits": 1}, write=lambda folder, simulated: asked.update(simulated=simulated)
    )
    log = SimpleNamespace(reference=SimpleNamespace(values=np.arange(3.0)), sample_time=1e-3)

    def identify(log, axis, progress):
        for share in (0.0, 0.5, 1.0):
            progress(share, f"fitted {share}")
        best = SimpleNamespace(plant="plant of the fit", friction="friction of the fit")

        def outcome_with(**facts):
            asked.update(outcome=facts)
            return outcome

        compensation = SimpleNamespace(rule="rule of the loop")
        return SimpleNamespace(
            finished=SimpleNamespace(
                best=best, settings="settings", compensation=compensation, outcome_with=outcome_with
            )
        )

    def experiment(plant, friction, model, controller, reference, sample_time, **facts):
        asked.update(
            experiment=(plant, friction, model, controller, reference.tolist(), sample_time),
            **facts,
        )
        return "experiment"

    monkeypatch.setattr(
        axis_simulated,
        "write_log",
        lambda path, seed: asked.setdefault("seeds", {}).update({path.name: seed}),
    )
    monkeypatch.setattr(
        module, "read_log", lambda path, axis: log if path.name == "log.csv" else "unseen"
    )
    monkeypatch.setattr(module, "identify", identify)
    monkeypatch.setattr(
        module, "predict", lambda *prediction: asked.update(predicted=prediction) or "prediction"
    )
    monkeypatch.setattr(module, "compensation_experiment", experiment)
    monkeypatch.setattr(module, "simulate", lambda experiment: f"simulated {experiment}")
    monkeypatch.setattr(
        module, "following_of", lambda *following: asked.update(following=following) or "following"
    )
    result = run(
        Folder(tmp_path),
        command="bristle demo",
        progress=lambda share, text: reports.append((share, text)),
    )
    return result, reports, asked, log


def test_a_model_of_one_log_is_predicted_on_another_and_run_on_the_axis_itself(
    monkeypatch, tmp_path
):
    result, reports, asked, log = shown(monkeypatch, tmp_path)
    assert [share for share, _ in reports] == sorted(share for share, _ in reports)
    axis = axis_simulated.axis()
    assert asked["seeds"] == {"log.csv": FITTED, "unseen.csv": UNSEEN}
    assert FITTED != UNSEEN
    assert asked["predicted"] == (
        "plant of the fit",
        "friction of the fit",
        "unseen",
        axis,
        "closed-loop",
    )
    plant, friction, model, controller, reference, sample_time = asked["experiment"]
    assert (plant, friction) == (axis_simulated.plant(), axis_simulated.friction())
    assert (model, controller, reference, sample_time) == (
        "friction of the fit",
        axis.controller,
        [0.0, 1.0, 2.0],
        1e-3,
    )
    assert (asked["resolution"], asked["effort_limit"]) == (axis.resolution, axis.effort_limit)
    assert asked["rule"] == "rule of the loop"
    assert asked["following"] == (log, "simulated experiment", "settings")
    assert asked["outcome"]["banner"] == BANNER
    assert asked["outcome"]["loop"] == ("simulated experiment", "prediction", "following")
    assert asked["simulated"] is True
    assert result.summary == {"fits": 1, "simulated": True}
    assert result.prediction == "prediction"
    assert result.outcome.summary == {"fits": 1}


# --- the axis: its friction, its motion and its logs are what they are said to be ------------------------------------


AXIS = axis_simulated.friction()
P = AXIS.parameters


def slid(speed, distance=1e-3, step=1e-6):
    """The force after a slide at a constant speed, and on the way there."""
    component = AXIS.component
    state, memory, x, forces = component.initial_state(P), component.new_memory(P), 0.0, []
    for _ in range(round(distance / step)):
        x += step * np.sign(speed)
        force, move = component.trial(state, memory, Motion(speed, x), step / abs(speed), P)
        state = component.commit(state, memory, move, P)
        forces.append(force)
    return np.array(forces)


def test_limits_fall_with_speed_and_differ_by_direction():
    assert truth.limit_of(1e-12, P) == pytest.approx(1.06 * 41.0)
    assert truth.limit_of(-1e-12, P) == pytest.approx(0.94 * 41.0)
    assert truth.limit_of(1.0, P) == pytest.approx(1.06 * 32.0)
    assert truth.limit_of(6e-3, P) == pytest.approx(1.06 * (32.0 + 9.0 / np.e))


def test_an_oil_film_has_half_of_its_friction_at_its_speed():
    for speed, share in ((1e-5, 1.0), (0.6, 0.5)):
        expected = truth.limit_of(speed, P) * np.sum(P.alpha_i) + share * 260.0 * speed
        assert slid(speed, 1e-4)[-1] == pytest.approx(expected, rel=1e-4)
    assert slid(-0.6, 1e-4)[-1] == pytest.approx(-(0.94 * 32.0 + 0.5 * 260.0 * 0.6), rel=1e-4)


def test_elements_slip_after_their_distances_and_all_of_them_at_7_micrometres():
    force = slid(1e-9, 1e-5, 1e-7)
    assert P.alpha_i.sum() == pytest.approx(1.0)
    shares, distances = spectrum(30, 7e-6, seed=7)
    assert (P.alpha_i.tolist(), P.r_i.tolist()) == (shares.tolist(), distances.tolist())
    assert (P.r_i.size, P.r_i.max()) == (30, pytest.approx(7e-6))
    # In the middle of a step.
    assert force[0] == pytest.approx(0.5e-7 * 41.0 * np.sum(P.alpha_i / P.r_i), rel=1e-6)
    assert force[-1] == pytest.approx(1.06 * 41.0, rel=1e-6)
    assert force[60] < force[-1]


def test_a_motion_is_made_of_moves_with_pauses_within_its_travel():
    x = motion(1, 10.0)
    assert x.size == 10_000
    assert np.all(x[:200] == 0.0)
    assert np.max(np.abs(x)) <= 0.15
    assert motion(1, 10.0).tolist() == x.tolist()
    assert motion(2, 10.0).tolist() != x.tolist()
    assert motion(1).size == 24_000
    moving = np.diff(x) != 0.0
    assert 0.3 < np.mean(moving) < 0.99
    speeds = np.abs(np.diff(motion(1))) / SAMPLE_TIME
    assert 0.1 < np.max(speeds) < 1.1 * 10**-0.6


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.1), (0.1, -0.05), (0.02, 0.0275)])
def test_a_move_is_a_rounded_trapezium(start, end):
    x = axis_simulated._move(start, end, 0.1, 2.0)
    v = np.diff(x, prepend=start) / SAMPLE_TIME
    assert x[-1] == pytest.approx(end, abs=1e-12)
    assert np.all(np.sign(end - start) * v >= -1e-12)
    top = min(0.1, np.sqrt(abs(end - start) * 2.0))
    assert np.max(np.abs(v)) == pytest.approx(top, rel=0.03)
    # An acceleration of 2 m/s^2, over 20 ms of rounding.
    assert np.max(np.abs(np.diff(v))) / SAMPLE_TIME <= 2.0 * 1.1
    expected = abs(end - start) / top + top / 2.0
    assert x.size * SAMPLE_TIME == pytest.approx(expected + 0.041, abs=2e-3)


def test_the_axis_follows_its_motion(tmp_path, monkeypatch):
    reference, described = motion(3, 1.0), axis_simulated.axis()
    monkeypatch.setattr(axis_simulated, "motion", lambda seed: reference)
    axis_simulated.write_log(tmp_path / "log.csv", 3)
    lines = (tmp_path / "log.csv").read_text().splitlines()
    assert lines[:2] == [
        "# simulated axis, not a measurement",
        "time [s],position [mm],reference [mm],motor_current [A]",
    ]
    assert len(lines) == 2 + reference.size
    _, position, desired, current = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=2).T
    assert desired == pytest.approx(1e3 * reference, abs=1e-6)
    assert np.max(np.abs(position - desired)) < 2.0
    counts = 1e-3 * position / described.resolution
    assert counts == pytest.approx(np.round(counts), abs=0.06)  # the file has 0.1 um
    assert np.max(np.abs(current)) <= described.effort_limit / 61.2 + 0.05

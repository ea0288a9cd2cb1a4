"""Models of an experiment file before its simulation, without the fits: kept, read, excited and written."""

from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.simulation.test_run import loop

from bristle import controllers, sensors
from bristle.core import Axis, InputError, Run
from bristle.engine import interpreted
from bristle.report import identified, prepared


@dataclass(frozen=True)
class Plan:
    """The entry of a model to identify in an experiment file."""

    name: str
    folder: Path
    is_current: bool = False
    logs: tuple = ()
    axis: object = None
    excited: object = None
    options: dict = field(default_factory=dict)
    note: tuple = ("depends_on.json", "digest")

    @property
    def path(self):
        return f"identify.{self.name}"


def written(tmp_path, monkeypatch, *plans):
    """An experiment file with these models to identify."""
    (tmp_path / "experiment.toml").write_text("schema = 1\n", encoding="utf-8")
    monkeypatch.setattr(prepared, "planned_in", lambda data, source, sources: {plan.name: plan for plan in plans})
    return tmp_path / "experiment.toml"


def test_present_models_are_not_fitted_again_and_keep_the_order(tmp_path, monkeypatch):
    plans = [Plan("first", tmp_path / "1"), Plan("second", tmp_path / "2", is_current=True), Plan("third", tmp_path / "3")]
    file, fitted, reports = written(tmp_path, monkeypatch, *plans), [], []

    def identify(plan, source, size_limit, progress):
        fitted.append((plan.name, source, size_limit))
        progress(0.0, "begins")
        progress(0.5, "goes on")
        return f"fit of {plan.name}"

    monkeypatch.setattr(prepared, "_identified", identify)
    result = prepared.prepare(file, size_limit="2 kB", progress=lambda share, text: reports.append(share))
    assert result == (
        prepared.Prepared("first", tmp_path / "1", "fit of first"),
        prepared.Prepared("second", tmp_path / "2", None),
        prepared.Prepared("third", tmp_path / "3", "fit of third"),
    )
    assert fitted == [("first", file, 2000), ("third", file, 2000)]
    assert reports == pytest.approx([0.0, 1.0 / 6.0, 2.0 / 3.0, 5.0 / 6.0])
    assert prepared.prepare(file)[0].best == "fit of first"  # whoever asks for no progress gets none


def identified_of(tmp_path, monkeypatch, plan):
    """The results of a plan without the fit: the requests and the files."""
    asked, files = {}, {}
    outcome = SimpleNamespace(provenance={"log": "sum"})

    @dataclass(frozen=True)
    class Outcome:
        provenance: dict

        def write(self, folder):
            files["outcome"] = self

    def outcome_with(command):
        asked["command"] = command
        return Outcome(outcome.provenance)

    def identify(logs, axis, progress, **options):
        asked.update(logs=logs, axis=axis, options=options)
        return SimpleNamespace(finished=SimpleNamespace(best="best", outcome_with=outcome_with))

    folder = SimpleNamespace(write=lambda name, text: files.update({name: text}))
    monkeypatch.setattr(prepared, "results_folder", lambda place, force: asked.update(force=force) or nullcontext(folder))
    monkeypatch.setattr("bristle.files.read_log", lambda log, axis, size_limit: (log, axis, size_limit))
    monkeypatch.setattr("bristle.files.read_axis", lambda file: f"axis of {file}")
    monkeypatch.setattr(identified, "identify", identify)
    best = prepared._identified(plan, Path("experiment.toml"), 1000, lambda share, text: None)
    return best, asked, files


def test_logs_are_read_with_their_axis_and_results_are_saved(tmp_path, monkeypatch):
    plan = Plan("axis_x", tmp_path / "identified" / "axis_x", logs=("a.csv", "b.csv"), axis="axis.toml", options={"model": "lugre"})
    best, asked, files = identified_of(tmp_path, monkeypatch, plan)
    expected = {"options": {"draws": 0, "model": "lugre"}, "command": "[identify.axis_x] of experiment.toml", "force": True}
    expected |= {"logs": [("a.csv", "axis of axis.toml", 1000), ("b.csv", "axis of axis.toml", 1000)]}
    assert {name: asked[name] for name in expected} == expected
    assert (best, files["outcome"].provenance, files["depends_on.json"]) == ("best", {"log": "sum"}, "digest")
    assert plan.folder.parent.is_dir()
    _, asked, _ = identified_of(tmp_path, monkeypatch, replace(plan, axis=None, options={"draws": 50}))
    assert (asked["axis"], asked["options"]) == (None, {"draws": 50})


def test_provenance_names_the_excited_rig_and_its_friction(tmp_path, monkeypatch):
    excited = loop(name="learning")
    monkeypatch.setattr(prepared, "_excited", lambda variant, axis: (["log of the run"], "axis of the run"))
    plan = Plan("axis_x", tmp_path / "identified" / "axis_x", excited=excited)
    _, asked, files = identified_of(tmp_path, monkeypatch, plan)
    assert (asked["logs"], asked["axis"]) == (["log of the run"], "axis of the run")
    provenance = files["outcome"].provenance
    assert provenance.items() >= {"identified from a run of": "experiment.toml: learning", "log": "sum"}.items()
    assert len(provenance) == 3


def test_run_of_a_loop_is_the_log_of_its_drive():
    with interpreted():
        (log,), axis = prepared._excited(loop(120, sensor=sensors.encoder(resolution=1e-4)), None)
    assert (axis.kind, axis.resolution, log.sample_time) == ("translational", 1e-4, pytest.approx(1e-2))
    assert log.position.values / 1e-4 == pytest.approx(np.round(log.position.values / 1e-4), abs=1e-6)
    assert log.reference.values[:30] == pytest.approx(1e-3 * np.arange(30))
    assert np.max(np.abs(log.effort.values)) > 3.0  # more than Coulomb friction
    known = Axis(resolution=2e-4)
    with interpreted():
        assert prepared._excited(loop(120), known)[1] is known


def test_diverged_loop_identifies_no_model():
    fast = controllers.cascade(k_p=10.0, k_v=1e8)
    wild = loop(200, controller=fast, run=Run(duration=2.0, sample_time=1e-2, substeps=1))
    refused = pytest.raises(InputError, match=r"compare\.loop: the simulation stopped early.*Correct this loop")
    with interpreted(), np.errstate(all="ignore"), refused:
        prepared._excited(wild, None)

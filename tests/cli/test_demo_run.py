"""What the demonstration does one after the other, with the work itself left out."""

import importlib
from types import SimpleNamespace

import numpy as np

from bristle.demo import axis_simulated
from bristle.demo.run import BANNER, FITTED, UNSEEN, run

module = importlib.import_module("bristle.demo.run")  # the package has the function by that name


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
    outcome = SimpleNamespace(summary={"fits": 1}, write=lambda folder, simulated: asked.update(simulated=simulated))
    log = SimpleNamespace(reference=SimpleNamespace(values=np.arange(3.0)), sample_time=1e-3)

    def identify(log, axis, progress):
        for share in (0.0, 0.5, 1.0):
            progress(share, f"fitted {share}")
        best = SimpleNamespace(plant="plant of the fit", friction="friction of the fit")

        def outcome_with(**facts):
            asked.update(outcome=facts)
            return outcome

        return SimpleNamespace(finished=SimpleNamespace(best=best, settings="settings", outcome_with=outcome_with))

    def experiment(plant, friction, model, controller, reference, sample_time, **facts):
        asked.update(experiment=(plant, friction, model, controller, reference.tolist(), sample_time), **facts)
        return "experiment"

    monkeypatch.setattr(axis_simulated, "write_log", lambda path, seed: asked.setdefault("seeds", {}).update({path.name: seed}))
    monkeypatch.setattr(module, "read_log", lambda path, axis: log if path.name == "log.csv" else "unseen")
    monkeypatch.setattr(module, "identify", identify)
    monkeypatch.setattr(module, "predict", lambda *prediction: asked.update(predicted=prediction) or "prediction")
    monkeypatch.setattr(module, "compensation_experiment", experiment)
    monkeypatch.setattr(module, "simulate", lambda experiment: f"simulated {experiment}")
    monkeypatch.setattr(module, "following_of", lambda *following: asked.update(following=following) or "following")
    result = run(Folder(tmp_path), command="bristle demo", progress=lambda share, text: reports.append((share, text)))
    return result, reports, asked, log


def test_a_model_of_one_log_is_predicted_on_another_and_run_on_the_axis_itself(monkeypatch, tmp_path):
    result, reports, asked, log = shown(monkeypatch, tmp_path)
    assert [share for share, _ in reports] == sorted(share for share, _ in reports)
    axis = axis_simulated.axis()
    assert asked["seeds"] == {"log.csv": FITTED, "unseen.csv": UNSEEN}
    assert FITTED != UNSEEN
    assert asked["predicted"] == ("plant of the fit", "friction of the fit", "unseen", axis, "closed-loop")
    plant, friction, model, controller, reference, sample_time = asked["experiment"]
    assert (plant, friction) == (axis_simulated.plant(), axis_simulated.friction())
    assert (model, controller, reference, sample_time) == ("friction of the fit", axis.controller, [0.0, 1.0, 2.0], 1e-3)
    assert (asked["resolution"], asked["effort_limit"]) == (axis.resolution, axis.effort_limit)
    assert asked["following"] == (log, "simulated experiment", "settings")
    assert asked["outcome"]["banner"] == BANNER
    assert asked["outcome"]["loop"] == ("simulated experiment", "prediction", "following")
    assert asked["simulated"] is True
    assert result.summary == {"fits": 1, "simulated": True}
    assert result.prediction == "prediction"
    assert result.outcome.summary == {"fits": 1}

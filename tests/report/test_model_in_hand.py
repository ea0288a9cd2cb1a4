"""An identified model: covariance, prediction with its treatment, and loading from a folder."""

import json
from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.core import InputError
from bristle.core.diagnostic import Diagnostic
from bristle.report import model_in_hand
from bristle.report.model_in_hand import Loaded, ModelInHand, load


def estimate(name, std=0.5, status="identified"):
    known = {"value": 3.0, "unit": "N", "robust_std": 0.6, "interval": (2.0, 4.0), "description": name, "interval_percent": 10.0}
    return Some(name=name, std=std, status=status, **known)


def in_hand(**changes):
    names = ("a", "gone", "b")
    correlation = [[1.0, 0.3, -0.5], [0.3, 1.0, 0.2], [-0.5, 0.2, 1.0]]
    items = (
        estimate("M", 2.0),
        estimate("a", 0.5),
        estimate("gone", 1.0, "held"),
        estimate("b", 4.0),
        estimate("c", None),
        estimate("d", np.inf),
    )
    known = {"estimates": items, "correlation_names": names, "correlation": correlation, "resampling": None, "friction": "f", "plant": "p"}
    known |= {"parameters": {item.name: item for item in items}, "diagnostics": (Diagnostic("switching_law", "", "warning"),)}
    model = ModelInHand()
    model.best, model.axis, model.treatment = Some(**known | changes), "axis", {"cutoff": 60.0, "decimation": 7.0, "rows": 3}
    return model


def test_inertia_from_before_the_fit_is_independent_in_the_covariance():
    model = in_hand()
    assert model.covariance_names == ("a", "b", "M")
    expected = [[0.25, -1.0, 0.0], [-1.0, 16.0, 0.0], [0.0, 0.0, 4.0]]
    np.testing.assert_allclose(model.covariance, expected)
    assert (model.model, model.plant) == ("f", "p")


def test_draws_equal_those_of_the_bands():
    assert in_hand().draws == {}
    bands = Some(draws={"a": [1.0, 2.0]})
    assert in_hand(resampling=Some(bands=bands)).draws["a"].tolist() == [1.0, 2.0]


def test_prediction_uses_the_treatment_of_the_fit(monkeypatch):
    called = []
    monkeypatch.setattr("bristle.prediction.predict", lambda *a, **k: called.append((a, k)))
    in_hand().predict("log")
    in_hand(resampling=Some(bands="bands")).predict("log", "open-loop", axis="other")
    assert called[0] == (("p", "f", "log", "axis", "inverse"), {"bands": None, "cutoff": 60.0, "decimation": 7})
    assert called[1][0] == ("p", "f", "log", "other", "open-loop")
    assert called[1][1]["bands"] == "bands"
    assert isinstance(called[0][1]["decimation"], int)


def test_drive_table_has_twenty_rows_by_default(monkeypatch):
    monkeypatch.setattr("bristle.prediction.drive_table", lambda best, entries: entries)
    assert (in_hand().drive_table(), in_hand().drive_table(7)) == (20, 7)


def test_a_data_frame_has_a_row_for_each_parameter():
    pytest.importorskip("pandas")
    frame = in_hand().to_dataframe()
    assert list(frame.index) == ["M", "a", "gone", "b", "c", "d"]
    assert frame.loc["a", ["value", "std", "robust_std", "low", "high"]].tolist() == [3.0, 0.5, 0.6, 2.0, 4.0]
    model = in_hand()
    model.best.parameters["a"].interval = None
    assert model.to_dataframe().loc["a", "low"] is None or np.isnan(model.to_dataframe().loc["a", "low"])


def test_text_of_a_diagnostic_is_its_sentence():
    (diagnostic,) = in_hand().diagnostics
    assert diagnostic.message.startswith("the control law chatters")
    assert str(diagnostic) == diagnostic.message


def test_saved_model_lists_the_next_models():
    summary = {"models": [{"name": "a"}, {"name": "b"}, {"name": "c"}], "provenance": {"log": "a.csv"}}
    loaded = Loaded(None, {}, None, summary, "page")
    assert loaded._words() == ("a.csv", ["next in rank: b, c"])
    assert Loaded(None, {}, None, {"models": [{"name": "a"}]}, "")._words() == ("", [])
    assert loaded.to_dict() == summary
    assert loaded.to_dict() is not summary


@pytest.mark.parametrize("missing", ["plant", "traces", "parameters"])
def test_folder_without_plant_or_traces_is_refused(tmp_path, monkeypatch, missing):
    summary = {} if missing == "parameters" else {"parameters": {}}
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    plant, traces = None if missing == "plant" else "p", {} if missing == "traces" else {"time": 1}
    monkeypatch.setattr(model_in_hand, "read_model", lambda *a, **k: (plant, "f", {"bands": None}))
    monkeypatch.setattr(model_in_hand, "read_arrays", lambda *a: traces)
    with pytest.raises(InputError, match="contains no identification"):
        load(tmp_path)


def test_summary_without_the_numbers_of_a_fit_is_refused(tmp_path, monkeypatch):
    (tmp_path / "summary.json").write_text('{"parameters": {}}')
    monkeypatch.setattr(model_in_hand, "read_model", lambda *a, **k: ("p", "f", {"bands": None}))
    monkeypatch.setattr(model_in_hand, "read_arrays", lambda *a: {"time": 1})
    with pytest.raises(InputError, match="has missing or invalid entries"):
        load(tmp_path)


def test_folder_is_loaded_with_its_axis_and_page(tmp_path, monkeypatch):
    (tmp_path / "summary.json").write_text('{"parameters": {}, "treatment": {"cutoff": 60.0}}')
    seen = []
    monkeypatch.setattr(model_in_hand, "read_model", lambda *a, allow_code: seen.append(allow_code) or ("p", "f", {"bands": None}))
    monkeypatch.setattr(model_in_hand, "read_arrays", lambda place, name: {"time": name})
    monkeypatch.setattr(model_in_hand, "fit_of", lambda *arguments: arguments)
    monkeypatch.setattr(model_in_hand, "read_axis", lambda file: file.name)
    bare = load(tmp_path)
    assert (bare.axis, bare.page, bare.treatment) == (None, "", {"cutoff": 60.0})
    assert bare.best[3:] == ({"time": "traces"}, {"time": "draws"}, None)
    (tmp_path / "axis.toml").write_text("")
    (tmp_path / "report.html").write_text("page")
    whole = load(tmp_path, allow_code=True)
    assert (whole.axis, whole.page) == ("axis.toml", "page")
    assert seen == [False, True]

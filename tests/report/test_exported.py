"""Files of an export for a target, and the loop in the folder of the model file."""

import json
from types import SimpleNamespace as Some

import pytest

from bristle.core import InputError
from bristle.report import exported
from bristle.report.exported import ExportedModel, _loop_beside


def written(effect=None, beside=(), error=None):
    product = Some(files={"a.c": "int a;", "a.h": b"h"}, effect=effect, notes=("one note",), error=error)
    return ExportedModel("c", product, "lugre", {"bristle": "0"}, beside)


def test_export_is_reported_with_files_and_notes():
    assert written(beside=("another",)).summary == {
        "target": "c",
        "model": "lugre",
        "files": ["a.c", "a.h"],
        "notes": ["one note", "another"],
        "effect": None,
        "provenance": {"bristle": "0"},
    }
    assert written(Some(as_data=lambda: {"gain": 2.0})).summary["effect"] == {"gain": 2.0}
    assert written(error={"rms_percent": 3.0}).summary["error"] == {"rms_percent": 3.0}


def test_export_writes_files_and_summary():
    folder = {}
    written().write(Some(write=folder.__setitem__))
    assert list(folder) == ["a.c", "a.h", "summary.json"]
    assert json.loads(folder["summary.json"])["target"] == "c"


def test_loop_of_the_folder_uses_the_model_as_feedforward(tmp_path, monkeypatch):
    file, axis = tmp_path / "experiment.toml", Some(controller="law")
    variants = [Some(feedforward=Some(friction=friction)) for friction in (None, "lugre", "dahl")]
    monkeypatch.setattr("bristle.files.read_experiment", lambda file: Some(variants=variants))
    assert _loop_beside(file, "dahl", axis) == (None, ())  # there is no such file
    file.write_text("")
    assert _loop_beside(file, "dahl", axis) == (variants[2], ())
    assert _loop_beside(file, "other", axis) == (None, ())
    assert _loop_beside(file, "dahl", None) == (None, ())
    assert _loop_beside(file, "dahl", Some(controller=None)) == (None, ())


def test_unreadable_loop_gives_a_remark(tmp_path, monkeypatch):
    def fails(file):
        raise InputError("is broken")

    monkeypatch.setattr("bristle.files.read_experiment", fails)
    file = tmp_path / "experiment.toml"
    file.write_text("")
    loop, (remark,) = _loop_beside(file, "dahl", Some(controller="law"))
    assert loop is None
    assert remark == "bristle did not simulate the loop of experiment.toml: is broken"


@pytest.mark.parametrize("holds_operator", [True, False])
def test_operator_is_exported_with_its_constant_and_models_if_admitted(holds_operator, monkeypatch):
    admitted = []
    monkeypatch.setattr("bristle.files.holds_operator", lambda file: holds_operator)
    monkeypatch.setattr("bristle.files.read_operator", lambda file: ("operator", 2.0, None))
    monkeypatch.setattr("bristle.files.read_model", lambda file, allow_code: ("plant", "friction", {"known": allow_code}))
    monkeypatch.setattr("bristle.hysteresis.with_constant", lambda operator, offset: (operator, offset))
    monkeypatch.setattr("bristle.testing.admit", admitted.append)
    reported = exported._read("file", allow_code=True)
    if holds_operator:
        assert reported == (None, ("operator", 2.0), {"uncertainty": {}, "treatment": {}})
        assert admitted == []
    else:
        assert reported == ("plant", "friction", {"known": True})
        assert admitted == ["friction"]

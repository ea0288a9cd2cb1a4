"""A log without sliding gives no level of friction to a drive."""

import numpy as np
import pytest

import bristle as br
from bristle.exports.described import Source
from bristle.exports.targets import Request
from bristle.exports.writing import files_for
from bristle.files.axis import axis_from
from bristle.files.model import read_model
from bristle.identification.settings import DEFAULT
from bristle.identification.structure import with_structure
from bristle.logs import Log
from bristle.prediction.drive_table import drive_table, level_values
from bristle.report.model_tables import values_to_enter

pytestmark = pytest.mark.usefixtures("undrawn")

DT = 2e-3
RATED = {
    "schema": 1,
    "kind": "translational",
    "columns": {name: {"column": name, "unit": unit} for name, unit in (("time", "s"), ("position", "m"), ("effort", "N"))},
    "effort": {"rated": "100 N"},
}


def pulled(step=1e-9, reach=5e-6, level=8.0):
    """Return a log of springs that slip in turn, deflected to half of the last slip."""
    t = DT * np.arange(4000)
    x = 1.8e-6 * np.sin(2.0 * np.pi * 0.7 * t) + 0.8e-6 * np.sin(2.0 * np.pi * 2.3 * t)
    limits, force = np.linspace(0.07, 1.0, 14) * reach, np.empty(t.size)
    bent = np.zeros(14)
    for k, way in enumerate(np.diff(x, prepend=0.0)):
        bent = np.clip(bent + way, -limits, limits)
        force[k] = level * np.mean(bent / limits)
    force += np.random.default_rng(0).normal(0.0, 0.01, t.size)
    return Log(time=t, position=np.round(x / step) * step, effort=force, sample_time=DT)


@pytest.fixture(scope="module")
def log():
    return pulled()


@pytest.fixture(scope="module")
def result(log):
    return br.identify(log, "preisach_contact", draws=0, blocks=0)


def test_level_above_the_effort_of_the_log_is_not_identified(log, result):
    level = result.best.parameters["f_p"]
    assert level.value > 1.2 * np.max(np.abs(log.effort.values))
    assert level.status == "unidentifiable"
    assert level.reason.code == "beyond_effort"
    (message,) = [diagnostic for diagnostic in result.best.diagnostics if diagnostic.code == "never_slides"]
    assert "f_p" in message.numbers["names"]


def test_log_without_sliding_gives_no_level_and_no_table(result, tmp_path):
    assert level_values(result.best) is None
    assert drive_table(result.best) == []
    assert values_to_enter(result.best, None).rows == []
    result.save(tmp_path / "out")
    assert not (tmp_path / "out" / "drive_table.csv").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("target", "points"), [("table", 20), ("table", 3), ("tf5200", 20)])
def test_drive_files_have_the_warning(result, tmp_path, target, points, monkeypatch):
    monkeypatch.setattr("bristle.exports.writing.effect_of_files", lambda *_, **__: None)  # it runs the model uncompiled
    result.save(tmp_path / "out")
    plant, friction, info = read_model(tmp_path / "out" / "model.toml")
    source = Source(info["provenance"], info["uncertainty"])
    requested = Request(friction, "axis_x", 1e-3, source, speed=0.1, points=points, plant=plant, axis=axis_from(RATED))
    product = files_for(target, requested)
    assert "do not use" in product.notes[0]
    assert "f_p" in product.notes[0]
    if target == "tf5200":
        assert "do not use" in product.files["axis_x.txt"]


@pytest.mark.slow
def test_level_within_the_effort_has_the_warning(result):
    entry = {"std": 0.1, "status": "identified", "note": "the log contains only pre-sliding"}
    friction = result.best.friction
    message = files_for("table", Request(friction, "x", 1e-3, Source({}, {"f_p": entry}), speed=0.1)).notes
    plain = files_for("table", Request(friction, "x", 1e-3, Source({}, {"f_p": {"status": "held"}}), speed=0.1)).notes
    assert len(message) == len(plain) + 1


def test_pre_sliding_is_named_before_position_dependence(log):
    fit = br.identify(log, "coulomb_viscous", draws=0, blocks=0).best
    named = [diagnostic for diagnostic in fit.diagnostics if diagnostic.code.startswith("missing_")]
    assert [diagnostic.code for diagnostic in named] == ["missing_presliding"]
    assert named[0].numbers["model"] == "preisach_contact"


def test_compared_models_are_not_suggested(log):
    fits = br.identify(log, "coulomb_viscous,preisach_contact", draws=0, blocks=0).fits
    static = next(fit for fit in fits if fit.name == "coulomb_viscous")
    named = with_structure(static, None, DEFAULT, compared=["preisach_contact"]).diagnostics[0].numbers
    assert (named["model"], named["compared"]) == ("", "preisach_contact")

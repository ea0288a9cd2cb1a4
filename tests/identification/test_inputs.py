"""Arguments of `identify` and `predict`: files and text with units, and errors."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
import pytest
from tests.identification.rigid import identify

from bristle.core import Axis, InputError
from bristle.files import load_code
from bristle.friction import coulomb, coulomb_viscous
from bristle.plants import inertia
from bristle.prediction import predict

AXIS = """
schema = 1
kind = "translational"
columns.time = { column = "t", unit = "s" }
columns.position = { column = "q", unit = "m" }
columns.effort = { column = "u", unit = "N" }
timing.delay = 0
"""
PLANT, FRICTION = inertia(M=12.0), coulomb_viscous(F_C=8.0, F_v=30.0)


@pytest.fixture
def files(tmp_path, stage):
    log = stage.log
    columns = [log.time.values, log.position.values, log.effort.values]
    np.savetxt(tmp_path / "log.csv", np.column_stack(columns), delimiter=",", header="t,q,u", comments="", fmt="%.12g")
    (tmp_path / "axis.toml").write_text(AXIS)
    return tmp_path / "log.csv", str(tmp_path / "axis.toml")


def test_files_replace_objects(files, stage):
    log, axis = files
    read = identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=0).best
    direct = identify(stage.log, "coulomb_viscous", axis=Axis(seeks_delay=False), blocks=0, draws=0).best
    assert read.friction.values["F_C"] == pytest.approx(direct.friction.values["F_C"], rel=1e-6)


def test_files_replace_objects_of_a_prediction(files, stage):
    log, axis = files
    error = predict(PLANT, FRICTION, str(log), axis).metrics["force_error_percent"]
    assert error == pytest.approx(predict(PLANT, FRICTION, stage.log).metrics["force_error_percent"], rel=1e-6)


def test_text_with_units_is_the_number_in_si(stage):
    as_text = identify(stage.log, "coulomb_viscous", blocks=0, mass="12000 g", offset="0.002 kN", cutoff="0.05 kHz", decimation=4, draws=0)
    as_number = identify(stage.log, "coulomb_viscous", blocks=0, mass=12.0, offset=2.0, cutoff=50.0, decimation=np.int64(4), draws=0)
    assert as_text.best.friction == as_number.best.friction
    assert as_text.treatment == as_number.treatment


def test_a_torque_is_known_in_the_units_of_a_rotational_axis(workbenches):
    known = identify(workbenches["rotational"].log, "coulomb_viscous", blocks=0, mass="4 kg*cm^2", offset="1 mN*m", draws=0).best
    assert known.plant.values["M"] == pytest.approx(4e-4)
    assert known.friction.values["offset"] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (None, "must be a name"),
        (FRICTION, "has values already"),
        ("coulomb,coulomb", "is requested twice"),
        (["coulomb", coulomb], "is requested twice"),
        ("coulomb+asymmetry+asymmetry", "has a slot twice"),
    ],
)
def test_invalid_models_are_rejected(stage, model, said):
    with pytest.raises(InputError, match=said):
        identify(stage.log, model, draws=0)


def test_a_user_model_is_not_taken_for_a_model_of_bristle(tmp_path, stage):
    (tmp_path / "own.py").write_text(Path(inspect.getfile(coulomb.trial)).read_text())
    with pytest.raises(InputError, match="is the name of a model of bristle; found 'coulomb'"):
        identify(stage.log, load_code(tmp_path / "own.py"), draws=0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((FRICTION, PLANT), "plant: must be a plant model, but is a friction model"),
        ((PLANT, None), "friction: must be a friction model with parameters"),
        ((PLANT, coulomb), "friction: must be a friction model with parameters"),
    ],
)
def test_a_prediction_needs_a_plant_and_a_friction_model(stage, arguments, said):
    with pytest.raises(InputError, match=said):
        predict(*arguments, stage.log)


@pytest.mark.parametrize("log", [None, np.zeros(9)])
def test_invalid_logs_are_rejected(log):
    with pytest.raises(InputError, match="log: must be a log"):
        identify(log, "coulomb_viscous", draws=0)
    with pytest.raises(InputError, match="log: must be a log"):
        predict(PLANT, FRICTION, log)

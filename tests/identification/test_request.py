"""Requested models, arguments, files and thresholds, and progress."""

import inspect
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle.core import Axis, InputError
from bristle.core.axis import Cogging
from bristle.files import load_code
from bristle.identification import least_squares
from bristle.identification.identify import _context
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.request import (
    freed,
    models_of,
    prior_knowledge_of,
    settings_of,
    treatment_of,
    with_method,
)
from bristle.identification.settings import DEFAULT, Settings
from bristle.identification.work import Work
from bristle.models.friction import MODELS, coulomb, coulomb_viscous
from bristle.models.plants import PLANTS, inertia
from bristle.prediction import predict
from bristle.report.model_tables import changed_settings

REFUSED = {"maxwell_stribeck"}  # its elements are given, not found
WITHOUT_LOAD = REFUSED | {"efficiency"}  # losses in proportion to a load


def names(model):
    return [item.name for item in models_of(model)]


def test_all_means_every_identifiable_model():
    assert set(names("all")) == set(MODELS) - WITHOUT_LOAD
    assert {model.name for model in models_of("all", transmits=True)} == set(MODELS) - REFUSED
    assert names("all+asymmetry") == [
        f"{name}+asymmetry" for name in MODELS if name not in WITHOUT_LOAD
    ]


def test_models_named_with_all_come_first_and_once():
    assert names("lugre, all")[0] == "lugre"
    assert sorted(names("lugre,all")) == sorted(names("all"))
    assert names(["all", "coulomb+asymmetry"])[0] == "coulomb+asymmetry"


@pytest.mark.slow
def test_among_all_models_the_true_one_is_not_beaten(monkeypatch):
    # The best of few candidates is one enough for a log so plain.
    monkeypatch.setattr(least_squares, "STARTS", 1)
    monkeypatch.setattr(least_squares, "CANDIDATES", 8)
    motion = sines(6.0, 4e-3)
    identification = identify(log_of(motion, sliding_effort(motion)), "all", blocks=3, draws=0)
    plain = [fit for fit in identification.fits if "+" not in fit.name]
    assert len(plain) + len(identification.left_out) == len(MODELS) - len(WITHOUT_LOAD)
    # The best of them with both directions apart, which this log does not ask for.
    assert [fit.name for fit in identification.fits if fit not in plain] == [
        "coulomb_viscous+asymmetry"
    ]
    assert identification.best.name == "coulomb_viscous"
    assert identification.best.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.01)


def test_arguments_override_the_axis_and_the_axis_overrides_the_search():
    known = Axis(mass=12.0, offset=2.0, plant="oscillator", damping=3.0, stiffness=40.0, pitch=0.01)
    prior = prior_knowledge_of(known, None, None, "translational")
    assert (prior.offset, prior.pitch, prior.plant) == (2.0, 0.01, PLANTS["oscillator"])
    assert sorted(prior.values.values()) == [3.0, 12.0, 40.0]
    asked = prior_knowledge_of(known, "500 g", "3 N", "translational")
    assert (asked.offset, sorted(asked.values.values())) == (3.0, [0.5, 3.0, 40.0])
    assert prior_knowledge_of(known, None, "identify", "translational").offset is None
    assert prior_knowledge_of(None, None, None, "rotational").offset is None
    assert prior_knowledge_of(None, 4.0, 0.0, "rotational") == PriorKnowledge(0.0, {"M": 4.0})
    for mass in (0.0, -1.0, 1e-16, float("inf")):
        with pytest.raises(InputError, match="mass"):
            prior_knowledge_of(known, mass, None, "translational")
    assert prior_knowledge_of(known, 1e-15, None, "translational").values["M"] == 1e-15
    with pytest.raises(InputError, match="offset"):
        prior_knowledge_of(known, None, float("nan"), "translational")


def test_turns_of_cogging_are_known_with_its_harmonics():
    axis = Axis(cogging=(Cogging("motor", 0.01, (6,)), Cogging("screw", 0.02, None)))
    prior = prior_knowledge_of(axis, None, None, "translational")
    assert (prior.values, prior.plant.orders) == ({"motor_turn": 0.01}, (("motor", 6),))


def test_shapes_are_freed_and_other_names_are_rejected():
    components = models_of("dahl, stribeck+position")
    assert freed(["exponent", "delta_S"], components) == ("exponent", "delta_S")
    for name in ("F_C", "exponents"):
        with pytest.raises(
            InputError, match=r"is not a shape parameter with a default value.*delta_S, exponent"
        ):
            freed([name], components)


def test_thresholds_and_method_are_as_requested():
    axis = Axis(settings={"unsure_std": 0.3, "sure": 4.0})
    assert settings_of(axis, {"sure": 6.0}) == Settings(unsure_std=0.3, sure=6.0)
    assert settings_of(axis, Settings()) == settings_of(None, None) == Settings()
    pairs = [("log", axis)]
    assert with_method(pairs, None) == pairs
    assert with_method(pairs, "output_error")[0][1].method == "output_error"
    assert (
        with_method([(SimpleNamespace(kind="rotational"), None)], "output_error")[0][1].kind
        == "rotational"
    )


@pytest.mark.parametrize("asked", [("0.2 kHz", 5), (None, None), (None, 1), (None, 10_000)])
def test_a_treatment_is_as_requested(asked):
    cutoff, decimation = asked
    assert treatment_of(cutoff, decimation, "translational") == (cutoff and 200.0, decimation)


@pytest.mark.parametrize("rows", [0, 10_001])
def test_a_decimation_out_of_range_is_rejected(rows):
    with pytest.raises(InputError, match="decimation"):
        treatment_of(None, rows, "translational")


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
    np.savetxt(
        tmp_path / "log.csv",
        np.column_stack(columns),
        delimiter=",",
        header="t,q,u",
        comments="",
        fmt="%.12g",
    )
    (tmp_path / "axis.toml").write_text(AXIS)
    return tmp_path / "log.csv", str(tmp_path / "axis.toml")


@pytest.mark.slow
def test_files_replace_objects(files, stage):
    log, axis = files
    read = identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=0).best
    direct = identify(
        stage.log, "coulomb_viscous", axis=Axis(seeks_delay=False), blocks=0, draws=0
    ).best
    assert read.friction.values["F_C"] == pytest.approx(direct.friction.values["F_C"], rel=1e-6)


def test_files_replace_objects_of_a_prediction(files, stage):
    log, axis = files
    error = predict(PLANT, FRICTION, str(log), axis).metrics["force_error_percent"]
    assert error == pytest.approx(
        predict(PLANT, FRICTION, stage.log).metrics["force_error_percent"], rel=1e-6
    )


@pytest.mark.slow
def test_text_with_units_is_the_number_in_si(stage):
    as_text = identify(
        stage.log,
        "coulomb_viscous",
        blocks=0,
        mass="12000 g",
        offset="0.002 kN",
        cutoff="0.05 kHz",
        decimation=4,
        draws=0,
    )
    as_number = identify(
        stage.log,
        "coulomb_viscous",
        blocks=0,
        mass=12.0,
        offset=2.0,
        cutoff=50.0,
        decimation=np.int64(4),
        draws=0,
    )
    assert as_text.best.friction == as_number.best.friction
    assert as_text.treatment == as_number.treatment


def test_a_torque_is_known_in_the_units_of_a_rotational_axis(workbenches):
    known = identify(
        workbenches["rotational"].log,
        "coulomb_viscous",
        blocks=0,
        mass="4 kg*cm^2",
        offset="1 mN*m",
        draws=0,
    ).best
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
        ("all+asymmetry+asymmetry", "has a slot twice"),
        ("all+speed", "no such slot"),
        ("every", "no such friction model"),
        ("karnopp", "no such friction model"),
        ("coulomb+humidity", "no such slot"),
        ("maxwell_stribeck", "lists of numbers"),
        ([], "names no friction model"),
        ([3.0], "must be a name"),
    ],
)
def test_invalid_models_are_rejected(stage, model, said):
    with pytest.raises(InputError, match=said) as caught:
        identify(stage.log, model, draws=0)
    assert caught.value.path == "model"


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


AS_TREATED = Axis(seeks_delay=False, cutoff=100.0)  # each model has its own inertia


@pytest.fixture(scope="module")
def log():
    motion = sines(6.0)
    return log_of(motion, sliding_effort(motion, noise=3.0))


def fitted(log, axis=AS_TREATED, blocks=0, **options):
    return identify(log, "coulomb_viscous", axis=axis, draws=0, blocks=blocks, **options)


def codes(result):
    return [diagnostic.code for diagnostic in result.best.diagnostics]


@pytest.fixture(scope="module")
def usual(log):
    """The result with all thresholds at their defaults."""
    return fitted(log)


def test_each_threshold_has_a_meaning_and_its_default_is_allowed():
    assert len(Settings.described()) > 20
    for threshold in Settings.described():
        assert len(threshold.meaning) > 10, threshold.name
        assert threshold.unit, threshold.name
        assert threshold.least <= threshold.default <= threshold.most, threshold.name
    assert (
        Settings.of({threshold.name: threshold.default for threshold in Settings.described()})
        == DEFAULT
    )


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"unsure": 1.0}, "settings.unsure"),
        ({"unsure_std": -1.0}, ">= 0"),
        ({"inseparable": 1.5}, "0 to 1"),
        ({"unsure_std": math.nan}, "settings.unsure_std"),
        ({"unsure_std": True}, "settings.unsure_std"),
        ({"unsure_std": "0.5"}, "settings.unsure_std"),
    ],
)
def test_an_unknown_or_out_of_range_threshold_is_rejected(given, told):
    with pytest.raises(InputError, match=told):
        Settings.of(given)


def test_thresholds_of_the_call_override_those_of_the_axis(log):
    axis = replace(AS_TREATED, settings={"unsure_std": 1e-9, "inseparable": 0.9})
    strict = fitted(log, axis)
    assert strict.best.parameters["M"].status == "unidentifiable"
    assert strict.settings.changed == {"unsure_std": 1e-9, "inseparable": 0.9}
    mild = fitted(log, axis, settings={"unsure_std": 0.5})
    assert {estimate.status for estimate in mild.best.estimates} == {"identified"}
    assert mild.settings.changed == {"inseparable": 0.9}
    # Nothing but what is said of the fit depends on them.
    for name, estimate in strict.best.parameters.items():
        assert estimate.value == mild.best.parameters[name].value
    with pytest.raises(InputError, match=r"identification\.settings\.nothing"):
        fitted(log, Axis(settings={"nothing": 1.0}))


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"acceleration_noise": 0.0}, "noisy_acceleration"),
        ({"poor_error": 0.0}, "unexplained"),
        ({"inseparable": 0.0}, "correlated"),
        ({"unsure_std": 1e-9}, "low_acceleration"),
    ],
)
def test_a_threshold_decides_the_diagnostics(log, usual, changed, code):
    assert code not in codes(usual)
    assert code in codes(fitted(log, settings=changed))


def test_rows_of_a_held_out_block_decide_the_number_of_blocks(log, usual):
    rows = usual.treatment["rows"]
    for least, blocks in ((rows // 10, 5), (rows // 4, 3)):
        found = fitted(
            log, blocks=None, settings={"held_out_rows": float(least), "lines_gain": 1.0}
        )
        assert len(found.best.held_out.block_errors_percent) == blocks
    assert "too_short" in codes(fitted(log, blocks=None, settings={"held_out_rows": float(rows)}))


def test_a_table_shows_the_thresholds_that_were_changed():
    changed = Settings.of({"unsure_std": 0.25})
    assert changed_settings(DEFAULT) is None
    table = changed_settings(changed)
    assert [tuple(row[:3]) for row in table.rows] == [("unsure_std", "0.25", "0.5")]
    # All of them stand in summary.json.
    assert set(changed.as_data()) == {threshold.name for threshold in Settings.described()}


THRESHOLDS_OF_0_2 = """
amplitude_half_cycles at_odds clear_std coloured_correlation coloured_error delay_inertia filter_seen flat_rise follows
half_sample_damping hopeless_std missing_effort missing_share missing_share_around moved negligible_force nested_loop
noisy_inertia repeated_overlap repeated_size reversal_error reversal_excess reversal_lag reversal_periods reversal_share seen_rise
stages_apart tremble unfinished_error white_lags white_level
"""


@pytest.mark.parametrize("name", THRESHOLDS_OF_0_2.split())
def test_a_threshold_of_the_last_release_is_refused_with_its_successor(name):
    assert name not in {threshold.name for threshold in Settings.described()}
    with pytest.raises(
        InputError,
        match=rf"settings\.{name}: is not a threshold of an identification.*missing_evidence replaces",
    ):
        Settings.of({name: 1.0})


MOTION = sines(6.0, dt=2e-3, amplitudes=(0.03, 0.008), frequencies=(0.25, 0.7), phases=(0.0, 1.0))
TURN = 0.01


@pytest.mark.parametrize("harmonics", [None, (6,)])
def test_harmonics_are_sought_in_the_log_if_the_axis_omits_them(harmonics):
    effort = sliding_effort(MOTION, noise=0.05) + 2.0 * np.sin(4.0 * np.pi * MOTION.position / TURN)
    axis = replace(STATED, cogging=(Cogging("motor", TURN, harmonics),))
    context = _context(
        [(log_of(MOTION, effort), axis)],
        PriorKnowledge(plant=inertia),
        DEFAULT,
        Work(least_squares.silent),
        None,
        None,
        100.0,
        4,
    )
    assert (
        context.prior.plant.orders == (("motor", 2),)
        if harmonics is None
        else context.prior.plant is inertia
    )


@pytest.mark.parametrize(
    ("expected", "ahead", "share", "left"),
    [
        (4.0, 3.0, 0.5, 3.0 + 2.0),
        (4.0, 3.0, 0.0, 3.0 + 6.0),
        (math.inf, 3.0, 0.5, 3.0 + 2.0),
        (4.0, math.inf, 0.5, math.inf),
        (4.0, 0.0, 1.0, 0.0),
    ],
)
def test_the_share_of_the_time_tells_the_remaining_time(monkeypatch, expected, ahead, share, left):
    clock, messages = Mock(side_effect=[0.0, 10.0, 12.0]), []
    monkeypatch.setattr("bristle.identification.work.perf_counter", clock)
    Work(lambda *told: messages.append(told), ahead, begun=clock()).task("fitting", expected)(
        share, "start 2"
    )
    assert messages == [(12.0 / (12.0 + left), "fitting, start 2")]

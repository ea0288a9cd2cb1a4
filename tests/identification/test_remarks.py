"""Diagnostics of a fit: residual, inertia, treatment, and missing forces."""

from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sliding_effort, strokes
from tests.identification.rigid import identify

from bristle.core.diagnostic import Diagnostic
from bristle.identification.dataset import Alignment
from bristle.identification.elasticity import Elastic
from bristle.identification.estimation import Estimation
from bristle.identification.excitation import with_checks
from bristle.identification.missing_force import Missing
from bristle.identification.settings import DEFAULT
from bristle.identification.structure import (
    _diagnostic,
    about_alignment,
    about_noise,
    about_residual,
    about_rise,
    about_treatment,
    noisy_inertia,
    with_structure,
)
from bristle.models.friction import coulomb, coulomb_viscous, lugre, stribeck, with_slots
from bristle.models.plants import inertia


def data(**changes):
    facts = {
        "sample_time": 1e-3,
        "cutoff": 100.0,
        "bandwidth": 50.0,
        "decimation": 10,
        "dropped": 50,
        "kind": "translational",
        "held": None,
        "alignment": None,
        "acceleration_noise_share": 0.02,
        "rest_share": 0.0,
        "keeps_rests": False,
        "creeping": False,
        "calmed_from": 0.0,
        "resolution": 1e-6,
    }
    return SimpleNamespace(**facts | changes)


def estimate(name, value=1.0, status="identified"):
    return SimpleNamespace(name=name, value=value, status=status)


def problem_of(component, dataset=None, values=None, **more):
    parameters = SimpleNamespace(
        component=component,
        plant=inertia,
        variables=inertia.variables | component.variables,
        free=("M", *component.variables),
        fixed={},
    )
    return SimpleNamespace(parameters=parameters, dataset=dataset or data(), values=values, **more)


FILTERED = Alignment(delay=0.0, smoothing=-3e-3, smoothing_half_width=1e-3)
FILTER = {"lag": 3e-3, "half_width": 1e-3}


def test_a_large_residual_is_unexplained():
    assert [(remark.code, remark.numbers) for remark in about_residual(41.0, DEFAULT)] == [
        ("unexplained", {"percent": 41.0})
    ]
    assert about_residual(39.0, DEFAULT) == ()


def test_rising_friction_is_reported_in_each_direction():
    values = {"F_C": 10.0, "F_S": 8.0, "v_S": 0.1, "F_v": 1.0}
    (remark,) = about_rise(problem_of(stribeck), values)
    assert (remark.code, remark.parameter) == ("rising_friction", "F_S")
    assert remark.numbers == {"first": 8.0, "level": 10.0, "speed": 0.1, "direction": ""}
    assert about_rise(problem_of(stribeck), values | {"F_S": 10.0}) == ()
    assert about_rise(problem_of(coulomb), {"F_C": 10.0}) == ()
    both = with_slots(stribeck, ["asymmetry"])
    values = {"F_C_pos": 10.0, "F_S_pos": 12.0, "F_C_neg": 10.0, "F_S_neg": 8.0, "v_S": 0.1}
    (remark,) = about_rise(problem_of(both), values)
    assert (remark.parameter, remark.numbers["direction"]) == ("F_S_neg", "backward")


def test_bias_of_the_inertia_by_noise_is_reported_if_the_inertia_is_identified():
    def message(share, status="identified"):
        return about_noise(
            problem_of(coulomb, data(acceleration_noise_share=share)),
            [estimate("M", status=status)],
            DEFAULT,
        )

    assert [len(message(share)) for share in (0.009, 0.01, 0.05, 0.051)] == [0, 1, 1, 0]
    assert message(0.02, "unidentifiable") == ()
    held = problem_of(coulomb)
    held.parameters.free = ("F_C",)
    assert about_noise(held, [estimate("M")], DEFAULT) == ()


def test_the_advised_cutoff_leaves_a_tenth_of_the_reported_noise():
    remark = noisy_inertia(data(acceleration_noise_share=0.032), "M", DEFAULT)
    assert remark.numbers["percent"] == pytest.approx(3.2)
    # The share grows with the fifth power of the frequency: of half of it a thirty-second part is left, of 0.032 a thousandth.
    assert remark.numbers["cutoff"] == pytest.approx(25.0)
    assert (remark.code, remark.parameter) == ("noisy_acceleration", "M")


def alignment_said(
    alignment, component=coulomb, fixed=None, change=0.0, error=1.0, settings=DEFAULT
):
    count = 3000
    rng = np.random.default_rng(1)
    column = rng.standard_normal(count)
    problem = problem_of(
        component,
        data(alignment=alignment),
        mechanical=lambda values: column,
        unit=lambda name: {name: 1.0},
    )
    problem.parameters.fixed = {} if fixed is None else {"M": fixed}
    jacobian = np.ones((count, 1))
    residual = change * column + error * rng.standard_normal(count)
    remarks = about_alignment(problem, SimpleNamespace(jacobian=jacobian), residual, settings)
    return {remark.code: remark for remark in remarks}


@pytest.mark.parametrize(
    ("alignment", "component", "code", "severity", "numbers"),
    [
        (
            Alignment(delay=2e-3, delay_half_width=6e-4),
            coulomb,
            "delay_found",
            "note",
            {"delay": 2e-3, "samples": 2.0, "half_width": 6e-4},
        ),
        (
            Alignment(delay=2e-3, delay_half_width=8e-4),
            coulomb,
            "delay_rough",
            "warning",
            {"samples": 2.0, "half_width": 8e-4},
        ),
        (Alignment(), coulomb, "delay_unknown", "warning", {}),
        (
            replace(FILTERED, smoothing=3e-3),
            coulomb,
            "filter_suspect",
            "warning",
            FILTER | {"channel": "effort"},
        ),
        (FILTERED, coulomb, "filter_suspect", "warning", FILTER | {"channel": "command"}),
        (
            replace(FILTERED, of_position=True),
            coulomb,
            "filter_suspect",
            "warning",
            FILTER | {"channel": "position"},
        ),
        (
            Alignment(delay=-2e-3, filter_open=True),
            coulomb,
            "delay_or_filter",
            "note",
            {"delay": 2e-3},
        ),
        # Models with bristles follow the motion before sliding, which a delay changes.
        (
            Alignment(delay=-2e-3, filter_open=True),
            lugre,
            "delay_or_filter",
            "warning",
            {"delay": 2e-3, "names": ("sigma_0", "sigma_1")},
        ),
    ],
)
def test_delays_and_filters_are_reported_as_surely_as_they_are_known(
    alignment, component, code, severity, numbers
):
    told = alignment_said(alignment, component)[code]
    assert told.severity == severity
    assert {name: told.numbers[name] for name in numbers} == numbers


@pytest.mark.parametrize("alignment", [Alignment(sought=False), None])
def test_a_delay_that_was_not_sought_is_not_reported(alignment):
    assert alignment_said(alignment) == {}


@pytest.mark.parametrize(
    ("change", "half_width", "error", "value"),
    [
        (0.5, 0.02, 0.1, None),  # 2 % and twice the noise of the acceleration
        (0.8, 0.02, 0.1, 10.8),
        (-0.8, 0.02, 0.1, 9.2),
        (0.8, 0.4, 0.1, 10.8),
        (0.8, 0.8, 0.1, None),
        (0.8, 0.02, 30.0, None),
        (0.8, None, 0.1, None),
    ],
)
def test_rows_that_contradict_the_measured_inertia_are_reported(change, half_width, error, value):
    fixed = SimpleNamespace(value=10.0, half_width=half_width)
    told = alignment_said(Alignment(delay=0.0), fixed=fixed, change=change, error=error)
    assert told.keys() == {"delay_found"} | (set() if value is None else {"stages_differ"})
    if value is not None:
        remark = told["stages_differ"]
        assert (remark.parameter, remark.severity) == ("M", "warning")
        assert remark.numbers == {"first": 10.0, "value": pytest.approx(value, abs=0.02)}


def test_each_treatment_of_a_log_is_reported():
    plain, errors = about_treatment(data())
    assert (plain.code, plain.numbers) == (
        "filtered",
        {"cutoff": 100.0, "dropped": 50, "decimation": 10},
    )
    assert errors.code == "standard_errors"
    remarks = about_treatment(data(calmed_from=0.4, rest_share=0.25, creeping=True))
    assert [(remark.code, remark.numbers) for remark in remarks[1:-1]] == [
        ("filtered", {"percent": 40.0, "decimation": 10}),
        ("rests", {"percent": 25.0}),
        ("rests", {"resolution": 1e-6}),
    ]
    assert {remark.severity for remark in remarks} == {"note"}
    assert len(about_treatment(data(rest_share=0.25, keeps_rests=True))) == 2


SLIDING = coulomb_viscous(F_C=8.0, F_v=30.0)
TRACES = SimpleNamespace(
    predicted=np.full(100, 9.0), mechanical=np.full(100, 5.0), residual=np.full(100, 2.0)
)


def lacking(cause, friction=SLIDING, compared=(), **facts):
    return _diagnostic(Missing(cause, 0.4, 2.0, **facts), 8.0, friction, compared)


def test_a_missing_force_is_reported_as_shares_of_friction_and_residual():
    remark = lacking("direction")
    assert remark.code == "missing_direction"
    assert (
        remark.numbers["force"],
        remark.numbers["percent"],
        remark.numbers["share_percent"],
    ) == (2.0, 25.0, 40.0)
    assert remark.numbers["model"] != ""
    known = lacking("direction", compared=[remark.numbers["model"]])
    assert (known.numbers["model"], known.numbers["compared"]) == ("", remark.numbers["model"])


def test_a_cause_has_its_code_and_its_numbers():
    assert lacking("presliding").numbers["model"] == "lugre"
    assert lacking("play", ratio=3.0).numbers["ratio"] == 3.0
    assert "model" not in lacking("play", ratio=3.0).numbers


@dataclass(frozen=True)
class FakeFit:
    friction: object
    traces: object
    diagnostics: tuple = ()
    estimates: tuple = field(default=())
    plant: object = field(default_factory=lambda: SimpleNamespace(component=inertia))


def test_the_residual_of_a_static_model_without_sliding_is_presliding():
    never = Diagnostic("never_slides")
    fit = with_structure(FakeFit(SLIDING, TRACES, (never,)), None, DEFAULT)
    remark, kept = fit.diagnostics
    assert kept is never
    assert (remark.code, remark.severity) == ("missing_presliding", "warning")
    assert (
        remark.numbers["force"],
        remark.numbers["percent"],
        remark.numbers["share_percent"],
    ) == (2.0, 50.0, 100.0)
    nothing = replace(
        fit,
        traces=SimpleNamespace(predicted=np.zeros(9), mechanical=np.zeros(9), residual=np.ones(9)),
        diagnostics=(never,),
    )
    assert with_structure(nothing, None, DEFAULT).diagnostics[0].numbers["percent"] == 100.0


def test_the_treatment_of_a_log_is_reported_in_numbers():
    motion = strokes(2)
    log = log_of(motion, sliding_effort(motion))
    result = identify(log, "coulomb_viscous", axis=STATED, draws=0, blocks=0)
    treatment = result.treatment
    assert (treatment["cutoff"], treatment["decimation"], treatment["dropped"]) == (
        100.0,
        10.0,
        50.0,
    )
    at_rest = 100.0 * float(np.mean(np.abs(motion.velocity) < 1e-6))
    assert treatment["rest_percent"] == pytest.approx(at_rest, abs=8.0)
    assert treatment["velocity_max"] == pytest.approx(np.max(np.abs(motion.velocity)), rel=0.01)
    assert treatment["rows"] == result.best.traces.residual.size
    assert "delay" not in treatment
    assert result.best.doubted == result.best.effective == ()
    traded = replace(
        result.best, diagnostics=(Diagnostic("one_speed", numbers={"names": ("F_v", "F_X")}),)
    )
    lacks = replace(
        result.best, diagnostics=(Diagnostic("structure", numbers={"names": ("F_C",)}),)
    )
    assert (lacks.effective, lacks.doubted, traded.doubted) == (("F_C",), (), ("F_v",))


def test_missing_forces_are_reported_together_then_singly_and_as_notes_if_small(monkeypatch):
    estimates, other = (estimate("F_C"), estimate("F_v", status="held")), Diagnostic("correlated")
    fit = FakeFit(SLIDING, TRACES, (other,), estimates)
    # Of a friction of 4 N; 0.6 % of it may matter.
    for scale, severity in ((1.0, "warning"), (0.0045, "note")):
        forces = (Missing("direction", 0.4, 3.0 * scale), Missing("speed", 0.2, 4.0 * scale))
        monkeypatch.setattr(
            "bristle.identification.structure.missing_in", lambda *_, forces=forces: (forces, 0.7)
        )
        structure, *named, last = with_structure(fit, None, DEFAULT).diagnostics
        expected = {"missing": 5.0 * scale, "percent": 125.0 * scale, "chance": 0.7}
        assert {name: structure.numbers[name] for name in expected} == pytest.approx(expected)
        assert (structure.numbers["names"], structure.numbers["causes"]) == (
            ("F_C",),
            ("direction", "speed"),
        )
        assert (structure.numbers["small"], last) == (int(severity == "note"), other)
        assert [item.code for item in named] == ["missing_direction", "missing_speed"]
        assert {item.severity for item in (structure, *named)} == {severity}
    monkeypatch.setattr("bristle.identification.structure.missing_in", lambda *_: ((), 0.0))
    assert with_structure(fit, None, DEFAULT) is fit


def test_an_elastic_coupling_is_not_taken_for_a_filter_and_names_no_model(monkeypatch):
    fit = FakeFit(
        SLIDING,
        TRACES,
        (Diagnostic("filter_suspect"), Diagnostic("correlated")),
        (estimate("F_C"),),
    )
    monkeypatch.setattr(
        "bristle.identification.structure.missing_in",
        lambda *_: ((Missing("direction", 0.4, 1.0),), 0.7),
    )
    _, named, *others = with_structure(fit, None, DEFAULT).diagnostics
    assert [named.code, *(item.code for item in others)] == [
        "missing_direction",
        "filter_suspect",
        "correlated",
    ]
    rows = SimpleNamespace(inverse=SimpleNamespace(dataset=SimpleNamespace(cutoff=8.0)))
    coupling = Elastic(43.0, 0.4, 55.0, 0.5, 0.7, 0.02, 12.0, 0.1, 0.0, 1e-4)
    coupled, *others = with_structure(fit, rows, DEFAULT, coupling=coupling).diagnostics
    assert (coupled.code, coupled.severity) == ("elastic_load", "warning")
    assert (coupled.numbers["antiresonance"], coupled.numbers["one_mass"]) == (43.0, 1)
    assert "model" not in coupled.numbers
    assert [item.code for item in others] == ["structure", "missing_direction", "correlated"]


def test_a_changed_estimation_seeks_missing_forces_anew():
    estimation = Estimation(None, None, None, (None, None), lambda rows: rows)
    estimation.missing.append(((), 0.7))
    assert (replace(estimation, further=1).missing, estimation.missing) == ([], [((), 0.7)])


@pytest.mark.parametrize(
    ("slots", "codes"),
    [
        ("coulomb_viscous", ["level_over_position", "one_speed"]),
        ("coulomb_viscous+position", ["one_speed"]),
    ],
)
def test_a_level_over_position_is_no_remark_on_a_model_that_has_it(slots, codes):
    found = (Diagnostic("level_over_position"), Diagnostic("one_speed"))
    fit = FakeFit(
        SimpleNamespace(name=slots, component=coulomb_viscous), None, estimates=(estimate("F_v"),)
    )
    assert [item.code for item in with_checks(fit, found).diagnostics] == codes

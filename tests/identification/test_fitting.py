"""Judgement of each parameter of a fit: uncertainty, reason, and edge."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort
from tests.identification.rigid import identify

from bristle.core import Variable
from bristle.friction import coulomb, coulomb_viscous, lugre, stribeck
from bristle.identification.estimate import Estimate
from bristle.identification.excitation import Excitation, shortest_zone
from bristle.identification.fitting import Judgement, about_estimates, about_fixed, about_level, combinations_of, effects_of, why_fixed
from bristle.identification.parameters import Fixed, Scales
from bristle.identification.settings import DEFAULT
from bristle.plants import inertia

SCALES = Scales(20.0, 50.0, 0.6, 1e-3, 3.0, 0.09, 1e-5, 10.0, 1e-3)
EFFORT = np.array([10.0, -10.0] * 50)
VALUES = {"M": 12.0, "F_C": 8.0, "F_v": 30.0}


def data(**changes):
    facts = {
        "kind": "translational",
        "effort": EFFORT,
        "acceleration": np.array([2.0, -5.0]),
        "velocity": np.linspace(0.01, 0.6, 100),
        "all_velocities": np.linspace(-0.1, 0.1, 1001),
        "acceleration_noise_share": 0.0,
        "resolution": 1e-6,
        "noise": 1e-7,
        "cutoff": 100.0,
        "sample_time": 1e-3,
        "reversals": ((10, 60),),
        "segments": (SimpleNamespace(position=1e-5 * np.arange(200.0), time=1e-3 * np.arange(200), effort=None),),
    }
    return SimpleNamespace(**facts | changes)


def judged(component=coulomb_viscous, values=None, std=0.1, at_edge=None, fixed=None, filtered=True, redundant=(), effects=None, **changes):
    """The estimates of a fit, by name, whose relative standard errors are given."""
    values, fixed = VALUES if values is None else values, fixed or {}
    variables = inertia.variables | {name: component.variables[name] for name in component.variables if name in values}
    dataset = data(**changes)
    free = {name: value for name, value in values.items() if name not in fixed}
    shares = std if isinstance(std, dict) else dict.fromkeys(free, std)
    deviations = np.array([shares[name] * abs(value) if value else shares[name] for name, value in free.items()])
    parameters = SimpleNamespace(
        fixed=fixed, component=component, variables=variables, plant=inertia, is_redundant=lambda name: name in redundant
    )
    problem = SimpleNamespace(parameters=parameters, dataset=dataset, mechanical=lambda values: 0.0 * EFFORT)
    solution = SimpleNamespace(values=free, at_edge=at_edge or {}, space=SimpleNamespace(names=tuple(free)))
    uncertainty = SimpleNamespace(std=deviations, robust_std=0.5 * deviations)
    excitation = Excitation(dataset, SCALES, values, variables, DEFAULT)
    return {entry.name: entry for entry in Judgement(problem, solution, uncertainty, excitation, effects or {}, filtered).estimates()}


FALL = {"M": 12.0, "F_C": 8.0, "F_S": 9.0, "v_S": 0.05, "F_v": 30.0}
SURE, OF_FALL = dict.fromkeys(VALUES, 0.1), {"component": stribeck, "values": FALL, "std": dict.fromkeys(FALL, 0.1)}
EFFECTS = {"F_C": 0.1, "F_v": 0.1}  # shares of friction per newton
SMALL = {"values": VALUES | {"F_C": 0.006}, "effects": EFFECTS}


@pytest.mark.parametrize(
    ("fitted", "name", "status", "code"),
    [
        # To half of its value.
        *(({"std": 0.49}, name, "identified", None) for name in VALUES),
        ({"std": SURE | {"F_v": 0.51}}, "F_v", "unidentifiable", "low_speed"),
        # A force is known to be small if its interval does not matter: 0.18 N of 10 N to either side.
        (SMALL | {"std": SURE | {"F_C": 15.0}}, "F_C", "identified", None),
        (SMALL | {"std": SURE | {"F_C": 20.0}}, "F_C", "unidentifiable", "few_strokes"),
        # What shapes friction is no force: it is known to half of itself, whatever its effect.
        ({"std": SURE | {"M": 20.0}, "effects": {"M": 1e-9}}, "M", "unidentifiable", "low_acceleration"),
        # A level above the effort is beyond it.
        ({"values": VALUES | {"F_C": 12.1}}, "F_C", "unidentifiable", "beyond_effort"),
        ({"values": VALUES | {"F_C": 11.9}}, "F_C", "identified", None),
        # Noise hides an inertia in filtered rows.
        ({"acceleration_noise_share": 0.051, "bandwidth": 50.0}, "M", "unidentifiable", "noisy_acceleration"),
        ({"acceleration_noise_share": 0.051, "filtered": False}, "M", "identified", None),
        ({"acceleration_noise_share": 0.05}, "M", "identified", None),
        # On an edge.
        ({"values": VALUES | {"F_v": 0.0}, "at_edge": {"F_v": "smallest"}}, "F_v", "at_edge", "edge_of_model"),
        ({"at_edge": {"F_v": "largest"}}, "F_v", "at_edge", "edge_of_search"),
        ({"at_edge": {"M": "smallest"}}, "M", "unidentifiable", "low_acceleration"),
        ({"values": VALUES | {"F_C": 0.0}, "at_edge": {"F_C": "smallest"}}, "F_C", "at_edge", "edge_of_model"),
        (
            {"values": VALUES | {"F_C": 0.0, "F_v": 0.0}, "at_edge": dict.fromkeys(("F_C", "F_v"), "smallest")},
            "F_C",
            "at_edge",
            "no_friction",
        ),
        # A fall is as uncertain as its force or velocity.
        *((OF_FALL, name, "identified", None) for name in FALL),
        (OF_FALL | {"std": OF_FALL["std"] | {"v_S": 0.9}}, "v_S", "unidentifiable", "no_fall"),
        (OF_FALL | {"std": OF_FALL["std"] | {"v_S": 0.9}}, "F_S", "unidentifiable", "no_fall"),
        (OF_FALL | {"std": OF_FALL["std"] | {"v_S": 0.9}}, "F_C", "identified", None),
        (OF_FALL | {"at_edge": {"F_S": "smallest"}}, "F_S", "at_edge", "edge_no_fall"),
        (OF_FALL | {"at_edge": {"F_S": "smallest"}}, "v_S", "unidentifiable", "no_fall"),
        (OF_FALL | {"fixed": {"v_S": Fixed(0.05, "no_fall", redundant=True)}, "redundant": ("v_S",)}, "F_S", "unidentifiable", "no_fall"),
        # What is not fitted.
        ({"fixed": {"F_v": Fixed(30.0, "held_known")}}, "F_v", "held", "held_known"),
        ({"fixed": {"F_v": Fixed(30.0, "no_fall", redundant=True)}}, "F_v", "unidentifiable", "no_fall"),
        ({"fixed": {"M": Fixed(12.0, "", half_width=1.96)}}, "M", "identified", None),
    ],
)
def test_a_parameter_has_a_status_and_a_reason(fitted, name, status, code):
    result = judged(**fitted)[name]
    assert (result.status, result.reason and result.reason.code) == (status, code)


def test_an_estimate_has_its_errors_and_unit():
    result = judged(std=0.49)
    assert (result["F_v"].std, result["F_v"].robust_std) == (pytest.approx(14.7), pytest.approx(7.35))
    assert (result["M"].unit, result["F_v"].unit) == ("kg", "N*s/m")
    measured = judged(fixed={"M": Fixed(12.0, "", half_width=1.96)})["M"]
    assert measured.std == pytest.approx(1.0, rel=1e-3)
    assert measured.interval == pytest.approx((10.04, 13.96))


@pytest.mark.parametrize(("share", "std", "percent"), [(0.51, 15.3, 51.0), (11.0, 330.0, None), (101.0, None, None), (np.inf, None, None)])
def test_a_meaningless_standard_error_is_omitted(share, std, percent):
    result = judged(std=SURE | {"F_v": share})["F_v"]
    assert result.std == (std and pytest.approx(std))
    assert result.reason.numbers.get("std_percent") == (percent and pytest.approx(percent))


def test_a_reason_has_its_numbers_and_severity():
    assert judged(values=VALUES | {"F_C": 12.1})["F_C"].reason.numbers == {"effort": 10.0}
    at_edge = judged(values=VALUES | {"F_v": 0.0}, at_edge={"F_v": "smallest"})["F_v"]
    assert (at_edge.reason.numbers["edge"], at_edge.reason.numbers["cause"]) == ("smallest", "low_speed")
    held, redundant = (judged(fixed={"F_v": fixed})["F_v"] for fixed in (Fixed(30.0, "held_known"), Fixed(30.0, "no_fall", redundant=True)))
    assert (held.reason.severity, redundant.reason.severity) == ("note", "warning")


def test_an_effect_is_the_share_of_friction_of_one_parameter():
    motion = sines(4.0)
    fit = identify(log_of(motion, sliding_effort(motion, F_C=8.0)), "coulomb_viscous", draws=0, blocks=0).best
    friction = np.linalg.norm(fit.traces.friction)
    assert fit.parameters["M"].effect == pytest.approx(np.linalg.norm(fit.traces.acceleration) / friction, rel=1e-2)
    assert fit.parameters["F_v"].effect == pytest.approx(np.linalg.norm(fit.traces.velocity) / friction, rel=1e-2)
    assert fit.parameters["F_v"].takes == pytest.approx(fit.parameters["F_v"].effect * fit.parameters["F_v"].value)


def test_an_undefined_effect_counts_as_large():
    problem = SimpleNamespace(
        parameters=SimpleNamespace(fixed={}, plant=inertia, component=SimpleNamespace(variables={"F_C": coulomb.variables["F_C"]})),
        friction=lambda values: np.ones(4),
        predicted=lambda values: np.full(4, values["M"] + (np.nan if values["F_C"] > 8.0 else 0.0)),
    )
    values = {"M": 12.0, "F_C": 8.0}
    assert effects_of(problem, values, problem.predicted(values), SCALES) == {"M": pytest.approx(1.0), "F_C": np.inf}


def cause_of(name, component=lugre, values=None, **changes):
    values = {"M": 12.0, "F_C": 8.0, "F_S": 9.0, "v_S": 0.05, "sigma_0": 1e6, "sigma_1": 10.0, "sigma_2": 3.0} | (values or {})
    outcome = Excitation(data(**changes), SCALES, values, inertia.variables | component.variables, DEFAULT)
    return outcome, outcome.cause(name)


@pytest.mark.parametrize(
    ("name", "changes", "code", "numbers"),
    [
        ("M", {}, "low_acceleration", {"acceleration": 5.0}),
        ("sigma_2", {}, "low_speed", {"speed": 0.6}),
        ("F_C", {}, "few_strokes", {"reversals": 2, "stroke": 0.09}),
        ("sigma_2", {"velocity": np.linspace(0.5, 0.6, 100)}, "few_speeds", None),
    ],
)
def test_the_cause_of_an_unidentified_parameter_follows_from_its_excitation(name, changes, code, numbers):
    _, cause = cause_of(name, **changes)
    assert (cause.code, cause.severity) == (code, "warning")
    assert numbers in (None, cause.numbers)


def test_an_invisible_fall_reports_the_number_of_slow_samples():
    _, cause = cause_of("v_S", values={"v_S": 0.02})
    assert cause.code == "no_fall"
    assert (cause.numbers["samples"], cause.numbers["speed"]) == (1001, 0.02)
    assert cause.numbers["slow_samples"] == pytest.approx(199, abs=2)


@pytest.mark.parametrize(
    ("changes", "hidden", "code", "numbers"),
    [
        # The zone is 20 N over the stiffness; samples are 10 um apart, a period of the filter is ten of them.
        ({}, False, "few_reversals", {"zone": pytest.approx(20.0 / 1.5e5), "samples": 14.0, "filter_samples": pytest.approx(10.0)}),
        ({"values": {"sigma_0": 3e5}}, True, "few_reversals", {}),
        ({"resolution": 3e-5}, True, "coarse_position", {"counts": 5.0, "resolution": 3e-5}),
        ({"noise": 1.4e-5}, True, "coarse_position", {"deviations": 10.0}),
        ({"values": {}, "reversals": ((),)}, True, "few_reversals", {}),
    ],
)
def test_presliding_is_hidden_within_a_period_of_the_filter_and_below_the_encoder(changes, hidden, code, numbers):
    outcome, cause = cause_of("sigma_0", **{"values": {"sigma_0": 1.5e5}} | changes)
    assert (outcome.is_hidden("sigma_0"), cause.code) == (hidden, code)
    assert cause.numbers.items() >= numbers.items()


def test_only_presliding_is_hidden_and_only_by_the_filter():
    fast, _ = cause_of("sigma_0", values={"sigma_0": 3e5})
    assert not fast.is_hidden("sigma_0", filtered=False)
    assert not fast.is_hidden("F_C")
    _, still = cause_of("sigma_0", reversals=((),))
    assert still.numbers == {}
    assert shortest_zone(data(), DEFAULT) == pytest.approx(5e-6)
    assert shortest_zone(data(noise=1e-6), DEFAULT) == pytest.approx(1e-5)


def entry(name, status="identified", value=2.0, std=0.1):
    return Estimate(name, "N", "", value, std, status=status, robust_std=0.3)


def test_correlated_pairs_of_identified_parameters_are_reported_once():
    correlation = np.array([[1.0, -0.995, 0.5], [-0.995, 1.0, 0.2], [0.5, 0.2, 1.0]])
    (pair,) = about_estimates([entry("a"), entry("b"), entry("c")], correlation, ["a", "b", "c"], 0.99)
    assert (pair.parameter, pair.numbers) == ("b", {"other": "a", "correlation": -0.995})
    assert about_estimates([entry("a"), entry("b", "unidentifiable"), entry("c")], correlation, ["a", "b", "c"], 0.99) == ()
    assert about_estimates([entry("a"), entry("b"), entry("c")], correlation, ["a", "b", "c"], 0.996) == ()


def test_a_level_without_its_curve_is_reported():
    outcome, _ = cause_of("M")
    (remark,) = about_level([entry("F_C"), entry("v_S", "unidentifiable")], outcome)
    assert (remark.code, remark.numbers) == ("level_as_seen", {"names": ("F_C",), "speed": 0.6})
    plain = Excitation(data(), SCALES, VALUES, inertia.variables | coulomb.variables, DEFAULT)
    for entries, of in (
        ([entry("F_C"), entry("v_S")], outcome),
        ([entry("F_C"), entry("sigma_2", "held")], outcome),
        ([entry("F_C", "unidentifiable")], outcome),
        ([entry("F_C")], plain),
    ):
        assert about_level(entries, of) == ()


def test_a_fixed_parameter_has_its_value_and_a_guessed_weight_a_warning():
    fixed = {
        "offset": Fixed(1.5, "held_constant", numbers={"levels": ("F_C_pos",)}),
        "v_S": Fixed(0.1, "no_fall"),
        "M": Fixed(12.0, "", half_width=0.5),
    }
    variables = {"offset": Variable("force", "offset"), "v_S": Variable("length/time", "velocity"), "M": Variable("mass", "mass")}
    problem = SimpleNamespace(parameters=SimpleNamespace(fixed=fixed, variables=variables), dataset=SimpleNamespace(kind="translational"))
    weight, reason = about_fixed(problem)
    assert (weight.code, weight.severity, weight.numbers["weight"]) == ("weight_guessed", "warning", 1.5)
    assert (reason.parameter, reason.numbers) == ("offset", {"value": 1.5, "unit": "N", "levels": ("F_C_pos",)})
    assert why_fixed("v_S", fixed["v_S"], variables["v_S"], "rotational").numbers["unit"] == "rad/s"


def test_products_of_a_redundant_factor_have_the_errors_of_the_other_factor():
    component = SimpleNamespace(
        redundancies=(SimpleNamespace(name="alpha", factor_of=("k",)),),
        variables={"alpha": Variable("1", "factor"), "k": Variable("force/length", "stiffness")},
    )
    (product,) = combinations_of(component, {"alpha": entry("alpha", value=-3.0), "k": entry("k")}, "translational")
    assert (product.name, product.unit, product.value) == ("alpha*k", "N/m", -6.0)
    assert (product.std, product.robust_std) == (pytest.approx(0.3), pytest.approx(0.9))


def test_in_a_simulation_two_samples_show_a_zone_and_one_does_not():
    for samples, is_hidden in ((1, True), (2, False), (3, False)):
        shown, _ = cause_of("sigma_0", values={"sigma_0": 20.0 / ((samples - 0.5) * 1e-5)})
        assert shown.is_hidden("sigma_0", filtered=False) is is_hidden

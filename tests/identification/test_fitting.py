"""Each parameter of a fit: its role, magnitude, standard error, reason, edge and interval."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from tests.identification.known_logs import STATED, Motion, log_of, sines, sliding_effort, strokes
from tests.identification.rigid import identify
from tests.identification.test_redundancy import one_way

from bristle.core import Axis, InputError, Variable
from bristle.core.diagnostic import Diagnostic
from bristle.core.dimensions import exponents_of
from bristle.identification import uncertainty
from bristle.identification.dataset import Alignment
from bristle.identification.estimate import Estimate
from bristle.identification.excitation import Excitation, shortest_zone
from bristle.identification.fitting import (
    Judgement,
    about_estimates,
    about_fixed,
    about_level,
    combinations_of,
    effects_of,
    why_fixed,
)
from bristle.identification.half_cycles import Disturbance
from bristle.identification.parameter_space import ParameterSpace, Solution
from bristle.identification.parameters import (
    Fixed,
    PriorKnowledge,
    Role,
    Scales,
    acts_in_sliding,
    constant_of,
    name_of,
    names_of,
    offset_of,
    parameters_of,
    scales_of,
    stroke_of,
)
from bristle.identification.preprocessing import treat
from bristle.identification.problem import Fold, _root
from bristle.identification.settings import DEFAULT
from bristle.identification.uncertainty import (
    _bands,
    _inflation,
    _judged,
    _refits_linearly,
    _with_interval,
)
from bristle.models.friction import coulomb, coulomb_viscous, find, lugre, stribeck, with_slots
from bristle.models.plants import inertia

SCALES = Scales(
    force=20.0,
    peak=50.0,
    speed=0.6,
    slowest=1e-3,
    acceleration=3.0,
    stroke=0.09,
    shortest=1e-5,
    duration=10.0,
    sample_time=1e-3,
)
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
        "segments": (
            SimpleNamespace(
                position=1e-5 * np.arange(200.0), time=1e-3 * np.arange(200), effort=None
            ),
        ),
    }
    return SimpleNamespace(**facts | changes)


def judged(
    component=coulomb_viscous,
    values=None,
    std=0.1,
    at_edge=None,
    fixed=None,
    filtered=True,
    redundant=(),
    effects=None,
    **changes,
):
    """The estimates of a fit, by name, whose relative standard errors are given."""
    values, fixed = VALUES if values is None else values, fixed or {}
    variables = inertia.variables | {
        name: component.variables[name] for name in component.variables if name in values
    }
    dataset = data(**changes)
    free = {name: value for name, value in values.items() if name not in fixed}
    shares = std if isinstance(std, dict) else dict.fromkeys(free, std)
    deviations = np.array(
        [shares[name] * abs(value) if value else shares[name] for name, value in free.items()]
    )
    parameters = SimpleNamespace(
        fixed=fixed,
        component=component,
        variables=variables,
        plant=inertia,
        is_redundant=lambda name: name in redundant,
    )
    problem = SimpleNamespace(
        parameters=parameters, dataset=dataset, mechanical=lambda values: 0.0 * EFFORT
    )
    solution = SimpleNamespace(
        values=free, at_edge=at_edge or {}, space=SimpleNamespace(names=tuple(free))
    )
    uncertainty = SimpleNamespace(std=deviations, robust_std=0.5 * deviations)
    excitation = Excitation(dataset, SCALES, values, variables, DEFAULT)
    return {
        entry.name: entry
        for entry in Judgement(
            problem, solution, uncertainty, excitation, effects or {}, filtered
        ).estimates()
    }


FALL = {"M": 12.0, "F_C": 8.0, "F_S": 9.0, "v_S": 0.05, "F_v": 30.0}
SURE, OF_FALL = (
    dict.fromkeys(VALUES, 0.1),
    {"component": stribeck, "values": FALL, "std": dict.fromkeys(FALL, 0.1)},
)
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
        (
            {"std": SURE | {"M": 20.0}, "effects": {"M": 1e-9}},
            "M",
            "unidentifiable",
            "low_acceleration",
        ),
        # A level above the effort is beyond it.
        ({"values": VALUES | {"F_C": 12.1}}, "F_C", "unidentifiable", "beyond_effort"),
        ({"values": VALUES | {"F_C": 11.9}}, "F_C", "identified", None),
        # Noise hides an inertia in filtered rows.
        (
            {"acceleration_noise_share": 0.051, "bandwidth": 50.0},
            "M",
            "unidentifiable",
            "noisy_acceleration",
        ),
        ({"acceleration_noise_share": 0.051, "filtered": False}, "M", "identified", None),
        ({"acceleration_noise_share": 0.05}, "M", "identified", None),
        # On an edge.
        (
            {"values": VALUES | {"F_v": 0.0}, "at_edge": {"F_v": "smallest"}},
            "F_v",
            "at_edge",
            "edge_of_model",
        ),
        ({"at_edge": {"F_v": "largest"}}, "F_v", "at_edge", "edge_of_search"),
        ({"at_edge": {"M": "smallest"}}, "M", "unidentifiable", "low_acceleration"),
        (
            {"values": VALUES | {"F_C": 0.0}, "at_edge": {"F_C": "smallest"}},
            "F_C",
            "at_edge",
            "edge_of_model",
        ),
        (
            {
                "values": VALUES | {"F_C": 0.0, "F_v": 0.0},
                "at_edge": dict.fromkeys(("F_C", "F_v"), "smallest"),
            },
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
        (
            OF_FALL
            | {"fixed": {"v_S": Fixed(0.05, "no_fall", redundant=True)}, "redundant": ("v_S",)},
            "F_S",
            "unidentifiable",
            "no_fall",
        ),
        # What is not fitted.
        ({"fixed": {"F_v": Fixed(30.0, "held_known")}}, "F_v", "held", "held_known"),
        (
            {"fixed": {"F_v": Fixed(30.0, "no_fall", redundant=True)}},
            "F_v",
            "unidentifiable",
            "no_fall",
        ),
        ({"fixed": {"M": Fixed(12.0, "", half_width=1.96)}}, "M", "identified", None),
    ],
)
def test_a_parameter_has_a_status_and_a_reason(fitted, name, status, code):
    result = judged(**fitted)[name]
    assert (result.status, result.reason and result.reason.code) == (status, code)


def test_an_estimate_has_its_errors_and_unit():
    result = judged(std=0.49)
    assert (result["F_v"].std, result["F_v"].robust_std) == (
        pytest.approx(14.7),
        pytest.approx(7.35),
    )
    assert (result["M"].unit, result["F_v"].unit) == ("kg", "N*s/m")
    measured = judged(fixed={"M": Fixed(12.0, "", half_width=1.96)})["M"]
    assert measured.std == pytest.approx(1.0, rel=1e-3)
    assert measured.interval == pytest.approx((10.04, 13.96))


@pytest.mark.parametrize(
    ("share", "std", "percent"),
    [(0.51, 15.3, 51.0), (11.0, 330.0, None), (101.0, None, None), (np.inf, None, None)],
)
def test_a_meaningless_standard_error_is_omitted(share, std, percent):
    result = judged(std=SURE | {"F_v": share})["F_v"]
    assert result.std == (std and pytest.approx(std))
    assert result.reason.numbers.get("std_percent") == (percent and pytest.approx(percent))


def test_a_reason_has_its_numbers_and_severity():
    assert judged(values=VALUES | {"F_C": 12.1})["F_C"].reason.numbers == {"effort": 10.0}
    at_edge = judged(values=VALUES | {"F_v": 0.0}, at_edge={"F_v": "smallest"})["F_v"]
    assert (at_edge.reason.numbers["edge"], at_edge.reason.numbers["cause"]) == (
        "smallest",
        "low_speed",
    )
    held, redundant = (
        judged(fixed={"F_v": fixed})["F_v"]
        for fixed in (Fixed(30.0, "held_known"), Fixed(30.0, "no_fall", redundant=True))
    )
    assert (held.reason.severity, redundant.reason.severity) == ("note", "warning")


def test_an_effect_is_the_share_of_friction_of_one_parameter():
    motion = sines(4.0)
    fit = identify(
        log_of(motion, sliding_effort(motion, F_C=8.0)), "coulomb_viscous", draws=0, blocks=0
    ).best
    friction = np.linalg.norm(fit.traces.friction)
    assert fit.parameters["M"].effect == pytest.approx(
        np.linalg.norm(fit.traces.acceleration) / friction, rel=1e-2
    )
    assert fit.parameters["F_v"].effect == pytest.approx(
        np.linalg.norm(fit.traces.velocity) / friction, rel=1e-2
    )
    assert fit.parameters["F_v"].takes == pytest.approx(
        fit.parameters["F_v"].effect * fit.parameters["F_v"].value
    )


def test_an_undefined_effect_counts_as_large():
    problem = SimpleNamespace(
        parameters=SimpleNamespace(
            fixed={},
            plant=inertia,
            component=SimpleNamespace(variables={"F_C": coulomb.variables["F_C"]}),
        ),
        friction=lambda values: np.ones(4),
        predicted=lambda values: np.full(4, values["M"] + (np.nan if values["F_C"] > 8.0 else 0.0)),
    )
    values = {"M": 12.0, "F_C": 8.0}
    assert effects_of(problem, values, problem.predicted(values), SCALES) == {
        "M": pytest.approx(1.0),
        "F_C": np.inf,
    }


def cause_of(name, component=lugre, values=None, **changes):
    values = {
        "M": 12.0,
        "F_C": 8.0,
        "F_S": 9.0,
        "v_S": 0.05,
        "sigma_0": 1e6,
        "sigma_1": 10.0,
        "sigma_2": 3.0,
    } | (values or {})
    outcome = Excitation(
        data(**changes), SCALES, values, inertia.variables | component.variables, DEFAULT
    )
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
def test_the_cause_of_an_unidentified_parameter_follows_from_its_excitation(
    name, changes, code, numbers
):
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
        (
            {},
            False,
            "few_reversals",
            {
                "zone": pytest.approx(20.0 / 1.5e5),
                "samples": 14.0,
                "filter_samples": pytest.approx(10.0),
            },
        ),
        ({"values": {"sigma_0": 3e5}}, True, "few_reversals", {}),
        ({"resolution": 3e-5}, True, "coarse_position", {"counts": 5.0, "resolution": 3e-5}),
        ({"noise": 1.4e-5}, True, "coarse_position", {"deviations": 10.0}),
        ({"values": {}, "reversals": ((),)}, True, "few_reversals", {}),
    ],
)
def test_presliding_is_hidden_within_a_period_of_the_filter_and_below_the_encoder(
    changes, hidden, code, numbers
):
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
    (pair,) = about_estimates(
        [entry("a"), entry("b"), entry("c")], correlation, ["a", "b", "c"], 0.99
    )
    assert (pair.parameter, pair.numbers) == ("b", {"other": "a", "correlation": -0.995})
    assert (
        about_estimates(
            [entry("a"), entry("b", "unidentifiable"), entry("c")],
            correlation,
            ["a", "b", "c"],
            0.99,
        )
        == ()
    )
    assert (
        about_estimates([entry("a"), entry("b"), entry("c")], correlation, ["a", "b", "c"], 0.996)
        == ()
    )


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
    variables = {
        "offset": Variable("force", "offset"),
        "v_S": Variable("length/time", "velocity"),
        "M": Variable("mass", "mass"),
    }
    problem = SimpleNamespace(
        parameters=SimpleNamespace(fixed=fixed, variables=variables),
        dataset=SimpleNamespace(kind="translational"),
    )
    weight, reason = about_fixed(problem)
    assert (weight.code, weight.severity, weight.numbers["weight"]) == (
        "weight_guessed",
        "warning",
        1.5,
    )
    assert (reason.parameter, reason.numbers) == (
        "offset",
        {"value": 1.5, "unit": "N", "levels": ("F_C_pos",)},
    )
    assert why_fixed("v_S", fixed["v_S"], variables["v_S"], "rotational").numbers["unit"] == "rad/s"


def test_products_of_a_redundant_factor_have_the_errors_of_the_other_factor():
    component = SimpleNamespace(
        redundancies=(SimpleNamespace(name="alpha", factor_of=("k",)),),
        variables={"alpha": Variable("1", "factor"), "k": Variable("force/length", "stiffness")},
    )
    (product,) = combinations_of(
        component, {"alpha": entry("alpha", value=-3.0), "k": entry("k")}, "translational"
    )
    assert (product.name, product.unit, product.value) == ("alpha*k", "N/m", -6.0)
    assert (product.std, product.robust_std) == (pytest.approx(0.3), pytest.approx(0.9))


def test_in_a_simulation_two_samples_show_a_zone_and_one_does_not():
    for samples, is_hidden in ((1, True), (2, False), (3, False)):
        shown, _ = cause_of("sigma_0", values={"sigma_0": 20.0 / ((samples - 0.5) * 1e-5)})
        assert shown.is_hidden("sigma_0", filtered=False) is is_hidden


def variable(quantity, **more):
    return Variable(quantity, "something", **more)


@pytest.mark.parametrize(
    ("quantity", "low", "high"),
    [
        ("length", 1e-5, 0.09),
        ("length/time", 1e-3, 0.2),
        ("force/length", 20.0 / 0.09, 20.0 / 1e-5),
        ("time", 1e-3, 10.0),
        ("1/time", 0.1, 1000.0),
        ("force/time", 2.0, 20_000.0),
        ("force", 0.02, 2000.0),
    ],
)
def test_an_unknown_magnitude_is_sought_in_the_range_of_the_log(quantity, low, high):
    assert SCALES.range(variable(quantity)) == pytest.approx((low, high))


def test_speeds_of_a_slow_log_are_sought_up_to_twice_its_slowest():
    assert SCALES._replace(slowest=0.3).range(variable("length/time")) == pytest.approx((0.3, 0.6))


@pytest.mark.parametrize(
    ("quantity", "typical"),
    [
        ("length", math.sqrt(0.09 * 1e-5)),
        ("length/time", math.sqrt(1e-3 * 0.6)),
        ("force/length", 20.0 / math.sqrt(0.09 * 1e-5)),
        ("1/length", 1.0 / 0.09),
        ("time", 0.1),
        ("1/time", 10.0),
        ("force/time", 200.0),
        ("force", 20.0),
        ("mass", 20.0 / 3.0),
        ("force*time/length", 20.0 / 0.6),
        ("force*time^2/length^2", 20.0 / 0.36),
    ],
)
def test_a_typical_value_follows_from_force_speed_and_acceleration(quantity, typical):
    assert SCALES.magnitude(variable(quantity)) == pytest.approx(typical)


def test_numbers_without_a_unit_and_of_a_drive_have_nominal_values():
    assert SCALES.magnitude(variable("1", nominal=2.0)) == 2.0
    assert SCALES.magnitude(variable("temperature", nominal=290.0)) == 290.0
    assert SCALES.magnitude(variable("force", nominal=7.0, excitation="drive")) == 7.0


def test_magnitudes_of_a_log_are_those_of_its_motion():
    motion = sines(6.0)
    dataset = treat(log_of(motion, sliding_effort(motion, noise=0.0), step=1e-6), STATED, 100.0, 10)
    scales = scales_of(dataset, 9.0)
    assert scales.force == 9.0
    assert scales.peak == pytest.approx(np.max(np.abs(dataset.effort)))
    assert scales.speed == pytest.approx(np.max(np.abs(motion.velocity)), rel=0.03)
    assert scales.slowest == pytest.approx(np.quantile(np.abs(motion.velocity), 0.01), rel=0.1)
    assert scales.acceleration == pytest.approx(np.sqrt(np.mean(motion.acceleration**2)), rel=0.02)
    assert scales.stroke == stroke_of(dataset) == pytest.approx(np.ptp(motion.position), rel=1e-3)
    assert scales.duration == pytest.approx(5.9, abs=0.02)
    assert scales.shortest == max(1e-6, scales.slowest * 1e-3)
    assert scales.sample_time == 1e-3


def test_a_log_with_rests_has_the_speeds_of_its_motion():
    motion = strokes(2)
    dataset = treat(log_of(motion, sliding_effort(motion), step=1e-6), STATED, 100.0, 10)
    scales = scales_of(dataset, 9.0)
    assert scales.slowest >= 1e-4 * scales.speed
    assert scales.slowest > 0.0


def test_the_stroke_is_that_of_a_single_segment():
    motion = sines(4.0, amplitudes=(0.02,), frequencies=(0.25,), phases=(0.0,))
    halves = log_of(motion, sliding_effort(motion), segments=(slice(0, 2000), slice(2000, 4000)))
    dataset = treat(halves, STATED, 100.0, 10)
    assert stroke_of(dataset) == pytest.approx(0.02, rel=0.01)


def test_roles_follow_from_quantity_and_excitation():
    assert {role: names_of(role, lugre.variables) for role in Role} == {
        **{role: [] for role in Role},
        Role.LEVEL: ["F_C"],
        Role.BREAK_AWAY: ["F_S"],
        Role.FALL: ["v_S"],
        Role.STIFFNESS: ["sigma_0"],
        Role.MICRO_DAMPING: ["sigma_1"],
        Role.VISCOUS: ["sigma_2"],
    }
    assert name_of(Role.LEVEL, lugre.variables) == "F_C"
    assert name_of(Role.INERTIA, lugre.variables) is None
    assert names_of(Role.LEVEL, with_slots(stribeck, ["asymmetry"]).variables) == [
        "F_C_pos",
        "F_C_neg",
    ]
    assert [name for name in lugre.variables if acts_in_sliding(lugre.variables[name])] == [
        "F_C",
        "F_S",
    ]


def test_the_constant_force_is_the_offset_plus_half_the_difference_of_levels():
    model = with_slots(coulomb_viscous, ["asymmetry"])(
        F_C_pos=9.0, F_C_neg=5.0, F_v_pos=1.0, F_v_neg=1.0, offset=1.5
    )
    variables, values = model.component.variables, model.values
    assert offset_of(variables, values) == 1.5
    assert constant_of(variables, values) == pytest.approx(3.5)
    assert offset_of(variables, {}) == offset_of({}, values) == 0.0
    assert constant_of(coulomb_viscous.variables, {"F_C": 3.0, "F_v": 1.0}) == 0.0


def held_by(name, velocity=(1.0, -1.0), effort=(8.0, -6.0), reach=0.03, **known):
    """The parameters of a model in a log of these rows, all of them fast, and of samples alike."""
    velocity, effort = (np.tile(signal, 50) for signal in (velocity, effort))
    segment = SimpleNamespace(position=np.array([0.01, 0.01 + reach]), surroundings={})
    facts = {
        "velocity": velocity,
        "all_velocities": velocity,
        "effort": effort,
        "acceleration": np.zeros(velocity.size),
    }
    dataset = SimpleNamespace(segments=(segment,), kind="translational", units={}, **facts)
    return parameters_of(find(name), PriorKnowledge(**known), dataset)


def test_redundant_parameters_are_fixed_at_round_numbers_and_known_ones_as_given():
    for reach, length in ((0.03, 0.01), (0.3, 0.1)):
        parameters = held_by("bouc_wen_classic", reach=reach)
        beta = parameters.fixed["beta"]
        assert parameters.is_redundant("beta")
        power = exponents_of(parameters.variables["beta"].quantity).get("length", 0.0)
        assert beta.value == pytest.approx(length**power)
        assert (beta.reason, beta.numbers) == (
            "redundant",
            {"products": ("beta*gamma", "beta*delta")},
        )
    known = held_by("coulomb_viscous", values={"M": 3.0}, offset=2.0, measured={"M": (4.0, 0.5)})
    assert (known.fixed["M"].value, known.fixed["M"].reason, known.held["offset"]) == (
        3.0,
        "held_known",
        2.0,
    )
    measured = held_by("coulomb_viscous", measured={"M": (4.0, 0.5)})
    assert (measured.fixed["M"].value, measured.fixed["M"].half_width, measured.free) == (
        4.0,
        0.5,
        ("F_v", "F_C", "offset"),
    )
    place = held_by("coulomb_viscous+position").held
    assert (place["x_0"], place["x_L"]) == pytest.approx((0.025, 0.015))
    shape = held_by("dahl")
    assert shape.fixed["exponent"].reason == "held_default"
    assert "exponent" in held_by("dahl", free=("exponent",)).free
    assert held_by("coulomb_viscous+periodic", pitch=0.005).fixed["pitch"].value == 0.005


def test_a_log_of_one_direction_does_not_identify_a_constant_with_a_level():
    for velocity, side in (((1.0,), "forward"), ((-1.0,), "backward")):
        offset = held_by("coulomb_viscous", velocity, (8.0,)).fixed["offset"]
        assert (offset.value, offset.reason, offset.numbers) == (
            0.0,
            "held_one_direction",
            {"level": "F_C", "direction": side},
        )
        with pytest.raises(InputError, match=f"the log contains only {side} motion"):
            held_by("coulomb_viscous+asymmetry", velocity, (8.0,))
    assert "offset" in held_by("coulomb_viscous").free


def test_a_constant_with_directional_levels_is_guessed_if_the_effort_keeps_its_sign():
    velocity = (1.0, 2.0, -1.0, -2.0)
    # Levels of 8 and 7, no weight.
    held = held_by("coulomb_viscous+asymmetry", velocity, (11.0, 14.0, 4.0, 1.0)).fixed["offset"]
    assert (held.reason, held.numbers) == ("held_constant", {"levels": ("F_C_pos", "F_C_neg")})
    assert held.value == pytest.approx(7.5)
    # Rows below a tenth of the largest speed are not asked.
    slow = held_by(
        "coulomb_viscous+asymmetry", (*velocity, 0.19, -0.19), (11.0, 14.0, 4.0, 1.0, 50.0, 50.0)
    ).fixed["offset"]
    assert slow.value == pytest.approx(7.5)
    none = held_by("coulomb_viscous+asymmetry", velocity, (8.0, 11.0, -6.0, -9.0)).fixed["offset"]
    assert (none.value, none.reason) == (0.0, "held_levels")


BLOCKS = 40  # over which residuals may be correlated
ROWS = 20 * BLOCKS


def one_way_log(**friction):
    # Ten samples a row, and fifty more at either edge.
    motion = Motion(*(signal[: 10 * ROWS + 100] for signal in one_way()))
    return log_of(motion, sliding_effort(motion, **friction))


def test_a_level_alone_is_a_mean():
    log, message = (
        one_way_log(F_v=0.0, offset=0.0),
        {"mass": 12.0, "offset": 0.0, "axis": Axis(held=False)},
    )
    fit = identify(log, "coulomb", blocks=0, draws=0, **message).best
    level, friction = fit.parameters["F_C"], fit.traces.friction
    assert friction.size == ROWS
    assert level.value == pytest.approx(friction.mean())
    assert level.std == pytest.approx(stats.sem(friction), rel=1e-9)
    # For errors that last: of the means over blocks, which are independent then.
    assert level.robust_std == pytest.approx(
        stats.sem(friction.reshape(BLOCKS, -1).mean(axis=1)), rel=1e-9
    )


def test_viscous_friction_with_an_offset_is_a_straight_line():
    fit = identify(one_way_log(F_C=0.0), "viscous", mass=12.0, blocks=0, draws=0).best
    line = stats.linregress(fit.traces.velocity, fit.traces.friction)
    slope, intercept = (fit.parameters[name] for name in ("F_v", "offset"))
    assert (slope.value, intercept.value) == pytest.approx((line.slope, line.intercept), rel=1e-6)
    assert (slope.std, intercept.std) == pytest.approx(
        (line.stderr, line.intercept_stderr), rel=1e-6
    )


def test_a_variance_negative_by_rounding_has_no_error():
    with np.errstate(all="raise"):
        assert _root(np.array([-1e-30, 0.0, 4.0])).tolist() == [np.inf, 0.0, 2.0]


# Patterns of eight rows that are orthogonal on each chunk of eight, so on each quarter of the rows too.
WALSH = [
    np.tile(part, 40)
    for part in ([1.0, -1.0] * 4, [1.0, 1.0, -1.0, -1.0] * 2, [1.0] * 4 + [-1.0] * 4, [1.0] * 8)
]
COUNT = 320


def fitted(values, columns, size, space=ParameterSpace):
    """The fit of a signal to columns, which leaves a residual of this size beside all of them, and its problem."""
    names, theta = tuple(values), np.array(list(values.values()))
    jacobian = np.column_stack(columns)
    signal = jacobian @ theta + size * WALSH[3]
    problem = SimpleNamespace(
        residual=lambda free: signal - jacobian @ np.array([free[name] for name in names]),
        dataset=SimpleNamespace(kind="translational"),
        parameters=SimpleNamespace(complete=dict),
    )
    ends = np.full(theta.size, np.inf)
    return problem, Solution(space(names, -ends, ends), theta, jacobian)


@pytest.mark.parametrize(
    ("quantity", "effect", "half_width", "status"),
    [
        ("mass", 1e-3, 1.1, "unidentifiable"),
        ("mass", 1e-3, 0.9, "identified"),
        ("mass", 0.1, 1.1, "identified"),  # it matters: known roughly
        ("force", 1e-3, 1.1, "identified"),  # known to be small
    ],
)
def test_a_parameter_of_small_effect_and_wide_interval_is_not_identified(
    quantity, effect, half_width, status
):
    estimate = Estimate(
        "M", "kg", "", 2.0, 0.1, interval=(2.0 - half_width, 2.0 + half_width), effect=effect
    )
    result = _judged(estimate, SimpleNamespace(quantity=quantity), "translational")
    assert result.status == status
    assert (result.reason.code if result.reason else None) == (
        "small_effect" if status == "unidentifiable" else None
    )


NEAR = (12.4, 12.8), (11.0, 11.6), (11.9, 12.1), (12.5, 12.8), (11.0, 11.5)
STAGES = Diagnostic("stages_differ", "M", "warning", {"first": 12.0, "value": 12.0})


@pytest.mark.parametrize(
    # Of replicates; of the first stage; of the estimate.
    ("name", "ends", "first", "interval", "warning"),
    [
        ("M", (12.6, 12.8), (12.0, 0.5), (11.5, 12.8), STAGES),
        ("M", (11.0, 11.4), (12.0, 0.5), (11.0, 12.5), STAGES),
        # What was fitted lies in its interval.
        *(
            ("M", ends, (12.0, 0.5), (min(ends[0], 12.0), max(ends[1], 12.0)), None)
            for ends in NEAR
        ),
        *(
            (name, (12.6, 12.8), first, (12.0, 12.8), None)
            for name, first in (("F_C", (12.0, 0.5)), ("M", (12.0, None)), ("M", (None, 0.5)))
        ),
        ("M", (12.6, 12.6), (12.0, 0.5), None, None),  # all replicates on the edge
        ("F_v", (12.6, 12.8), (12.0, 0.5), None, None),  # not fitted to replicates
    ],
)
def test_the_interval_of_an_inertia_includes_that_of_the_first_stage_if_disjoint(
    name, ends, first, interval, warning
):
    replicates = SimpleNamespace(reported=("M", "F_C"), interval=lambda name: ends)
    dataset = SimpleNamespace(
        alignment=Alignment(mass=first[0], mass_half_width=first[1]), kind="translational"
    )
    problem = SimpleNamespace(
        dataset=dataset,
        parameters=SimpleNamespace(plant=SimpleNamespace(variables=inertia.variables)),
    )
    estimate, told = _with_interval(Estimate(name, "kg", "", 12.0, 0.1), replicates, problem)
    assert estimate.interval == interval
    assert (told and replace(told, kind=STAGES.kind)) == warning


@pytest.mark.parametrize(("size", "factor"), [(0.5, 1.0), (3.0, 1.5)])
def test_bands_grow_until_they_contain_19_of_20_held_out_rows(monkeypatch, size, factor):
    problem, solution = fitted({"a": 2.0}, WALSH[:1], size)
    outside = np.arange(COUNT) < 160
    folds = [
        Fold(outside, ~outside, outside),
        Fold(outside, ~outside, np.zeros(COUNT, dtype=bool)),
        Fold(~outside, np.zeros(COUNT, dtype=bool), outside),
    ]
    problem.folds = lambda count: ("time blocks", folds)
    problem.effort_residual = lambda free, residual: residual
    monkeypatch.setattr(uncertainty, "half_width", lambda *_: np.full(COUNT, 2.0))
    fit, estimation = (
        SimpleNamespace(plant=None, friction=None),
        SimpleNamespace(resampled=(problem, solution)),
    )
    assert _inflation(None, fit, estimation, linear=True) == pytest.approx(factor)


@pytest.mark.parametrize(
    ("errors", "linear"),
    [((1e-6, None), [True, True]), ((None, 1.0), [False, True]), ((None, None), [False, False])],
)
def test_fits_to_replicates_of_a_position_and_of_a_loop_without_presliding_are_linear(
    errors, linear
):
    fits = [
        SimpleNamespace(friction=friction, position_rmse=errors[0], loop_rmse=errors[1])
        for friction in (lugre(F_C=1.0, F_S=2.0, v_S=1e-3, sigma_0=1e5), coulomb(F_C=8.0))
    ]
    assert list(map(_refits_linearly, fits)) == linear


@pytest.mark.parametrize(("position_rmse", "unexplained"), [(None, 0.3), (1e-6, 0.0)])
def test_bands_contain_the_draws_the_disturbance_and_the_unexplained_effort(
    position_rmse, unexplained
):
    problem = SimpleNamespace(row_time=0.01, parameters=SimpleNamespace(loop={"lag": None}))
    replicates = SimpleNamespace(
        members=[{"F_C": 1.0, "lag": 2.0}, {"F_C": 3.0, "lag": 4.0}],
        unexplained=0.3,
        residual=np.full(COUNT, 0.3),
        disturbance=Disturbance(0.0, 0.2, 1e-6, 1e-7),
        scatter=SimpleNamespace(value=0.0),
    )
    bands = _bands(
        replicates,
        SimpleNamespace(position_rmse=position_rmse),
        SimpleNamespace(resampled=(problem, None), finished=dict),
    )
    assert {name: draws.tolist() for name, draws in bands.draws.items()} == {"F_C": [1.0, 3.0]}
    assert (bands.scatter, bands.noise, bands.unexplained) == (0.0, 0.2, unexplained)
    assert (bands.left_in_closed_loop, bands.left_in_open_loop) == (1e-7, 1e-7)
    assert bands.lasting == pytest.approx(0.01 * COUNT / 40 if unexplained else 0.0)


class AskedError(Exception):
    """What a bootstrap is asked for."""


@pytest.mark.parametrize(
    ("structure", "scale"),
    [(None, 1.0), ((3.0, 4.0), 1.25), ((0.0, 4.0), 1.0), ((10.0, 4.0), 2.0), ((1.0, 0.0), 2.0)],
)
def test_errors_of_replicates_grow_by_a_missing_force_and_a_doubtful_treatment(
    monkeypatch, structure, scale
):
    problem, solution = fitted({"F_C": 2.0, "sigma_0": 3.0}, WALSH[:2], 0.5)
    problem.parameters.variables = lugre.variables
    asked = []

    def bootstrap(problem, solution, draws, **requested):
        asked.append(requested | {"draws": draws})
        raise AskedError

    monkeypatch.setattr(uncertainty, "bootstrap", bootstrap)
    about = (
        [Diagnostic("structure", numbers={"missing": structure[0], "chance": structure[1]})]
        if structure
        else []
    )
    for doubts, wide in (([], None), ([Diagnostic("delay_rough")], [1.0, 2.5])):
        fit = SimpleNamespace(estimates=[], diagnostics=[*about, *doubts], position_rmse=1e-6)
        with pytest.raises(AskedError):
            uncertainty.with_uncertainty(
                fit, SimpleNamespace(resampled=(problem, solution)), 7, DEFAULT
            )
        requested = asked[-1]
        assert (requested["draws"], requested["linear"], requested["scale"]) == (
            7,
            True,
            pytest.approx(scale),
        )
        assert (None if requested["wide"] is None else requested["wide"].tolist()) == wide

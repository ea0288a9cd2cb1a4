"""Every kernel is run once on numbers with the units that its parameters, states and inputs are declared to have."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pint
import pytest
from tests.contract.measured import Measured, Several, hold, let_kernels_measure, measured_fields, measured_parameters, plain
from tests.controllers.test_own_law import PID

from bristle import controllers, friction, hysteresis, plants
from bristle.controllers.feedforward import Shape, compensate
from bristle.controllers.law import law
from bristle.core.dimensions import unit_of
from bristle.core.motion import Motion, Reference
from bristle.core.variable import variables_of
from bristle.files import load_code
from bristle.friction.presliding import presliding
from bristle.hysteresis.everett import KERNELS
from bristle.testing import check_model
from bristle.testing.dimensions import one_dimension

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"
SLOTS = "+position+periodic+load+temperature"
DT = 1e-3
# Forward, back, at rest on either side, and far: in units of what the examples turn over.
SPEEDS = (1e-4, 1e-3, 5e-3, -1e-4, -1e-3, 0.0, -0.0, 2e-3, -5e-3, 1e-4, -2e-3)

# Values that lead along other ways through the kernels than those of the example.
OTHER_WAYS = {
    "stribeck": [{"delta_S": 1.3}],
    "dahl": [{"exponent": kernel} for kernel in (0.5, 1.0, 2.0, 3.0)],
    "bouc_wen": [{"alpha": 0.1, "exponent": 1.7}],
    "bouc_wen_classic": [{"delta": -3.0}, {"nu": 1.7}],
    "lugre": [{"v_d": math.inf}],
    "gap_slider": [{"n": 2.7}],
    "maxwell_stribeck": [{"v_r": 1e-3}],
    "preisach_contact": [{"kernel": kernel} for kernel in KERNELS],
    "preisach_lugre": [{"kernel": "dahl_masing", "transition": kernel, "exponent": 1.5} for kernel in ("paper", "leuven")]
    + [{"kernel": kernel} for kernel in KERNELS],
}
CANNOT = {"bouc_wen_classic nu=1.7": "its exponent is on a force, counted in units of 1 N"}
"""What cannot run on numbers with units, and why."""


def friction_cases():
    for name, component in friction.MODELS.items():
        yield name, component, {}
        for change in OTHER_WAYS.get(name, ()):
            yield f"{name} {','.join(f'{key}={value}' for key, value in change.items())}", component, change
    for name in (f"lugre{SLOTS}", "lugre+asymmetry", "gap_slider+asymmetry"):
        yield name, friction.find(name), {}
    yield "stribeck with pre-sliding", presliding(friction.stribeck), {**friction.stribeck.example, "presliding": 1e-6}
    yield "a user's own", load_code(EXAMPLE), {}


CASES = {name: (component, change) for name, component, change in friction_cases()}


@pytest.fixture
def measuring(monkeypatch):
    let_kernels_measure(monkeypatch)


def values_of(component, change):
    return component(**{**component.example, **change}, validate=False).values


def move_along(component, change, parameters=None, states=None):
    """Run every kernel of a friction model along a motion; units that do not agree raise."""
    p = measured_parameters(component, values_of(component, change), parameters or component.variables)
    states = states or variables_of(component.State)
    state = measured_fields(component.State, component.State()._asdict(), states)
    memory, second, x = Several([0.0] * component.memory_size(p)), Measured(1.0, "s"), 0.0
    forces = []
    for v in SPEEDS:
        x += v * DT
        motion = Motion(Measured(v, "m/s"), Measured(x, "m"), 1.1, Measured(300.0, "K"))
        force, move = component.trial(state, memory, motion, Measured(DT, "s"), p)
        hold(force, "N", "force of a trial")
        if component.rate is not None:
            force_now, d_state = component.rate(state, motion, p)
            hold(force_now, "N", "force of rate")
            for name, item in states.items():
                hold(getattr(d_state, name) * second, item.unit(), f"rate of {name}")
        if component.flow is not None:
            contact, piece = component.piece(state, memory, motion, p)
            force_now, d_contact, _ = component.flow(contact, piece, motion, p)
            hold(force_now, "N", "force of flow")
            for name in contact._fields:
                hold(getattr(contact, name), states[name].unit(), name)
                hold(getattr(d_contact, name) * second, states[name].unit(), f"rate of {name}")
            component.arrival(state, memory, contact, p)
        state = component.commit(state, memory, move, p)
        for name, item in states.items():
            hold(getattr(state, name), item.unit(), name)
        forces.append(plain(force))
    return forces


@pytest.mark.fast_cases(15)
@pytest.mark.parametrize("name", [name for name in CASES if name not in CANNOT])
def test_formulas_of_friction_models_are_dimensionally_consistent(measuring, name):
    move_along(*CASES[name])


@pytest.mark.parametrize("name", CANNOT)
def test_exceptions_for_numbers_with_units_are_needed(measuring, name):
    with pytest.raises(pint.DimensionalityError):
        move_along(*CASES[name])


@pytest.mark.parametrize("name", ["lugre", "preisach_lugre", "gms"])
def test_numbers_with_units_are_the_numbers_without(monkeypatch, name):
    component, change = CASES[name]
    model = component(**values_of(component, change))
    state, memory, x = component.State(), component.new_memory(model.parameters), 0.0
    forces = []
    for v in SPEEDS:
        x += v * DT
        force, move = component.trial(state, memory, Motion(v, x, 1.1, 300.0), DT, model.parameters)
        state = component.commit(state, memory, move, model.parameters)
        forces.append(force)
    let_kernels_measure(monkeypatch)
    assert move_along(component, change) == pytest.approx(forces, rel=1e-9)


def unseen(variables, run):
    """Which of these may be declared with a quantity of another dimension, and nothing of it is seen in a run."""
    names = []
    for name, item in variables.items():
        if item.quantity == "1":
            continue
        try:
            run({**variables, name: replace(item, quantity=f"{item.quantity}*temperature")})
        except pint.DimensionalityError:
            continue
        names.append(name)
    return names


@pytest.mark.parametrize("name", [*friction.MODELS, f"lugre{SLOTS}", "stribeck with pre-sliding", "a user's own"])
def test_a_wrong_unit_of_any_parameter_or_state_is_seen(measuring, name):
    component, change = CASES[name]
    states = variables_of(component.State)
    if "v_d" in component.variables:
        change = {**change, "v_d": 0.05}  # at infinity it acts on nothing
    assert unseen(component.variables, lambda selected: move_along(component, change, parameters=selected)) == []
    assert unseen(states, lambda selected: move_along(component, change, states=selected)) == []


FORMULA = "p.F_C * direction(v) + p.F_q * v * abs(v)"


@pytest.mark.parametrize(
    "formula",
    [
        FORMULA.replace(" * abs(v)", ""),
        FORMULA.replace(" + p.F_q", " * p.F_q"),
        FORMULA.replace("p.F_C", "(p.F_C + 1.0)"),
        FORMULA.replace("p.F_C", "p.F_C * power(abs(v), 1.5)"),
        FORMULA.replace("direction(v)", "tanh(v)"),
        FORMULA.replace("direction(v)", "direction(v) * max(abs(v), 1e-3)"),
    ],
)
def test_a_wrong_formula_is_seen(tmp_path, monkeypatch, formula):
    text = EXAMPLE.read_text(encoding="utf-8").replace(FORMULA, formula)
    text = text.replace("import direction", "import direction, power, tanh")
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    custom = load_code(tmp_path / "own.py")
    let_kernels_measure(monkeypatch)
    (check,) = check_model(custom, checks=(one_dimension,))
    assert not check.passed
    assert "changes with the unit of" in check.detail
    let_kernels_measure(monkeypatch)
    with pytest.raises(pint.DimensionalityError):
        move_along(custom, {})


@pytest.mark.parametrize("name", CASES)
def test_other_units_change_no_model_of_bristle(name):
    component, change = CASES[name]
    (check,) = check_model(component(**{**component.example, **change}, validate=False), checks=(one_dimension,))
    assert check.passed != (name in CANNOT), check.detail


def test_a_wrong_quantity_of_a_parameter_or_state_is_detected(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8")
    assert "force*time^2/length^2" in text
    (tmp_path / "own.py").write_text(text.replace("force*time^2/length^2", "force*time/length"), encoding="utf-8")
    (check,) = check_model(load_code(tmp_path / "own.py"), checks=(one_dimension,))
    assert check.detail == "the force changes with the unit of length"


@pytest.mark.parametrize(
    ("quantity", "formula"),
    [
        ("force*time^3/length^3", "p.F_C * direction(v) + p.F_q * v * v * v"),
        ("length/time", "p.F_C * direction(v) * (1.0 + power(abs(v) / p.F_q, 0.7))"),
        ("length", "p.F_C * direction(v) * (1.0 + tanh(motion.x / p.F_q))"),
        ("travel/length", "p.F_t * p.F_q * direction(v)"),
    ],
)
def test_a_sound_formula_is_met(tmp_path, quantity, formula):
    text = EXAMPLE.read_text(encoding="utf-8").replace(FORMULA, formula).replace("force*time^2/length^2", quantity)
    text = text.replace("import direction", "import direction, power, tanh").replace("125.0}", '125.0, "F_t": 5.0}')
    text = text.replace("class State", '    F_t: Annotated[float, Variable("force of travel", "friction of a nut")]\n\n\nclass State', 1)
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    (check,) = check_model(load_code(tmp_path / "own.py"), checks=(one_dimension,))
    assert check.passed, check.detail


# --- control laws -----------------------------------------------------------------------------------------------

ON_SURFACE = {"J": 2.0, "lambda_": 30.0, "K_1": 40.0, "cutoff": 200.0, "limit": 50.0}
LAWS = {
    "cascade": (controllers.cascade, {"k_p": 80.0, "k_v": 4e3, "k_i": 1e4, "k_ff": 0.5, "limit": 50.0}),
    "cascade of two samples": (controllers.cascade, {"k_p": 80.0, "k_v": 4e3, "averaging": 2}),
    "sliding_mode": (controllers.sliding_mode, {**ON_SURFACE, "K_2": 2.0, "phi": 0.01}),
    "sliding_mode by an observer": (controllers.sliding_mode, {**ON_SURFACE, "estimator": "tracking_observer"}),
    "super_twisting": (controllers.super_twisting, {**ON_SURFACE, "k_1": 0.5, "k_2": 5.0}),
    "disturbance_observer": (controllers.disturbance_observer, {**ON_SURFACE, "g": 60.0}),
    "lugre_observer": (
        controllers.lugre_observer,
        {**ON_SURFACE, "F_C": 3.0, "F_S": 4.0, "v_S": 0.2, "sigma_0": 1e3, "sigma_2": 2.0, "k": 0.5},
    ),
    "asymptotic_observer": (
        controllers.asymptotic_observer,
        {**ON_SURFACE, "g_1": 60.0, "g_2": 200.0, "F_C": 3.0, "sigma_0": 1e3, "K_I": 10.0, "band": 1e-3},
    ),
    "predictive_reversal": (
        controllers.predictive_reversal,
        {**ON_SURFACE, "F_C": 3.0, "F_S": 4.0, "v_S": 0.2, "F_v": 2.0, "lead": 1e-3, "x_0": 1e-3},
    ),
    "adaptive_hysteresis": (controllers.adaptive_hysteresis, {**ON_SURFACE, "reach": 0.01, "Gamma": 50.0, "w_max": 5.0, "delta": 0.01}),
    "pid": (PID, {"K_P": 2e3, "K_I": 2e4, "K_D": 80.0}),
}


def control_along(component, values, parameters=None, states=None):
    """Run a control law along a motion; units that do not agree raise."""
    values = component(**values).values
    p = measured_parameters(component, values, parameters or component.variables)
    states = states or variables_of(component.State)
    state = measured_fields(component.State, component.State()._asdict(), states)
    dt, limit, injected = Measured(DT, "s"), Measured(40.0, "N"), Measured(0.1, "N")
    for position, measurement in ((1e-3, 0.0), (2e-3, 1e-3), (0.1, 2e-3), (-1e-3, -1e-3)):
        desired = dict(zip(Reference._fields, (position, 0.3, -2.0, 5.0), strict=True))
        reference = measured_fields(Reference, desired)
        effort, state = law(state, reference, Measured(measurement, "m"), injected, limit, dt, p)
        hold(effort, "N", "effort")
        for name, item in states.items():
            hold(getattr(state, name), item.unit(), name)
    begun = component.start(*(Measured(1e-3, unit) for unit in ("m", "m/s", "m/s^2")), dt, p)
    for name, item in states.items():
        hold(getattr(begun, name), item.unit(), name)


def test_every_control_law_is_among_those_that_are_run():
    assert {component.name for component, _ in LAWS.values()} >= set(controllers.CONTROLLERS)


@pytest.mark.parametrize("name", LAWS)
def test_formulas_of_control_laws_are_dimensionally_consistent(measuring, name):
    control_along(*LAWS[name])


@pytest.mark.parametrize("name", LAWS)
def test_a_wrong_unit_of_any_gain_or_state_is_seen(measuring, name):
    component, values = LAWS[name]
    states = variables_of(component.State)
    assert unseen(component.variables, lambda selected: control_along(component, values, parameters=selected)) == []
    assert unseen(states, lambda selected: control_along(component, values, states=selected)) == []


def test_feedforward_has_the_dimension_of_a_force(measuring):
    component, change = CASES["lugre"]
    p = measured_parameters(component, values_of(component, change), component.variables)
    shape = dict(zip(Shape._fields, (0.8, 0.5, 0.1, 30.0, 1e4), strict=True))
    state, before = measured_fields(component.State, component.State()._asdict()), Measured(0.0, "N")
    for v in SPEEDS:
        motion = Motion(Measured(v, "m/s"), Measured(0.0, "m"), 1.0, Measured(300.0, "K"))
        before, state = compensate(state, (), motion, before, Measured(DT, "s"), measured_fields(Shape, shape), p)
        hold(before, "N", "effort fed forward")


# --- operators and plants ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", hysteresis.OPERATORS)
def test_formulas_of_operators_are_dimensionally_consistent(measuring, name):
    operator = hysteresis.OPERATORS[name]
    p = measured_parameters(operator, values_of(operator, {}), operator.variables)
    state, memory = operator.State(), Several([0.0] * operator.memory_size(p))
    for place in (1e-7, 1e-6, 2e-6, 5e-7, -1e-6, 3e-6):
        output, move = operator.trial(state, memory, Measured(place, unit_of(operator.input)), p)
        hold(output, unit_of(operator.output), "output")
        state = operator.commit(state, memory, move, p)
        for field, item in variables_of(operator.State).items():
            hold(getattr(state, field), item.unit(), field)


@pytest.mark.parametrize("name", plants.PLANTS)
def test_formulas_of_plants_are_dimensionally_consistent(measuring, name):
    plant = plants.PLANTS[name]
    values = {key: plant.example.get(key, item.nominal) for key, item in plant.variables.items()}
    p, dt = measured_parameters(plant, values, plant.variables), Measured(DT, "s")
    states = variables_of(plant.State)
    state = measured_fields(plant.State, dict.fromkeys(states, 1e-3))
    effort, force = Measured(3.0, "N"), Measured(1.0, "N")
    mean, compliance = plant.port(state, effort, dt, p)
    hold(mean, "m/s", "mean velocity")
    hold(compliance, "m/(s*N)", "velocity by force")
    output, after = plant.step(state, effort, force, dt, p)
    hold(output, "m", "output")
    for field, item in states.items():
        hold(getattr(after, field), item.unit(), field)
        hold(getattr(plant.rest(state, effort, dt, p), field), item.unit(), field)
        if plant.rate is not None:
            hold(getattr(plant.rate(state, effort, force, p), field) * Measured(1.0, "s"), item.unit(), field)

"""Every kernel is the same in other units of length, time and force: its sums, comparisons and functions are consistent."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.models.controllers.test_own_law import PID

from bristle import controllers, friction, hysteresis, plants
from bristle.contract import check_model
from bristle.contract.dimensions import one_dimension
from bristle.core.dimensions import exponents_of
from bristle.core.motion import Reference
from bristle.core.variable import variables_of
from bristle.files import load_code
from bristle.models.friction.presliding import presliding
from bristle.models.hysteresis.everett import KERNELS

EXAMPLE = Path(__file__).parents[2] / "examples" / "quadratic_drag.py"
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
    "preisach_lugre": [
        {"kernel": "dahl_masing", "transition": kernel, "exponent": 1.5}
        for kernel in ("paper", "leuven")
    ]
    + [{"kernel": kernel} for kernel in KERNELS],
}
CANNOT = {"bouc_wen_classic nu=1.7": "its exponent is on a force, counted in units of 1 N"}
"""What is another model in other units, and why."""


def friction_cases():
    for name, component in friction.MODELS.items():
        yield name, component, {}
        for change in OTHER_WAYS.get(name, ()):
            yield (
                f"{name} {','.join(f'{key}={value}' for key, value in change.items())}",
                component,
                change,
            )
    for name in (
        "lugre+position+periodic+load+temperature",
        "lugre+asymmetry",
        "gap_slider+asymmetry",
    ):
        yield name, friction.find(name), {}
    yield (
        "stribeck with pre-sliding",
        presliding(friction.stribeck),
        {**friction.stribeck.example, "presliding": 1e-6},
    )
    yield "a user's own", load_code(EXAMPLE), {}


CASES = {name: (component, change) for name, component, change in friction_cases()}


FORMULA = "p.F_C * direction(v) + p.F_q * v * abs(v)"


@pytest.mark.parametrize(
    ("formula", "quantity", "unit"),
    [
        (FORMULA.replace(" * abs(v)", ""), "force*time^2/length^2", ""),
        (FORMULA.replace(" + p.F_q", " * p.F_q"), "force*time^2/length^2", ""),
        (FORMULA.replace("p.F_C", "(p.F_C + 1.0)"), "force*time^2/length^2", ""),
        (FORMULA.replace("p.F_C", "p.F_C * power(abs(v), 1.5)"), "force*time^2/length^2", ""),
        (FORMULA.replace("direction(v)", "tanh(v)"), "force*time^2/length^2", ""),
        (
            FORMULA.replace("direction(v)", "direction(v) * max(abs(v), 1e-3)"),
            "force*time^2/length^2",
            "",
        ),
        (FORMULA, "force*time/length", "length"),
    ],
)
def test_a_wrong_formula_or_quantity_is_seen(tmp_path, formula, quantity, unit):
    text = (
        EXAMPLE.read_text(encoding="utf-8")
        .replace(FORMULA, formula)
        .replace("force*time^2/length^2", quantity)
    )
    (tmp_path / "own.py").write_text(
        text.replace("import direction", "import direction, power, tanh"), encoding="utf-8"
    )
    (check,) = check_model(load_code(tmp_path / "own.py"), checks=(one_dimension,))
    assert not check.passed
    assert f"changes with the unit of {unit}" in check.detail


@pytest.mark.parametrize("name", CASES)
def test_other_units_change_no_model_of_bristle(name):
    component, change = CASES[name]
    (check,) = check_model(
        component(**{**component.example, **change}, validate=False), checks=(one_dimension,)
    )
    assert check.passed != (name in CANNOT), check.detail


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
    text = (
        EXAMPLE.read_text(encoding="utf-8")
        .replace(FORMULA, formula)
        .replace("force*time^2/length^2", quantity)
    )
    text = text.replace("import direction", "import direction, power, tanh").replace(
        "125.0}", '125.0, "F_t": 5.0}'
    )
    text = text.replace(
        "class State",
        '    F_t: Annotated[float, Variable("force of travel", "friction of a nut")]\n\n\nclass State',
        1,
    )
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    (check,) = check_model(load_code(tmp_path / "own.py"), checks=(one_dimension,))
    assert check.passed, check.detail


ON_SURFACE = {"J": 2.0, "lambda_": 30.0, "K_1": 40.0, "cutoff": 200.0, "limit": 50.0}
LAWS = {
    "cascade": (
        controllers.cascade,
        {"k_p": 80.0, "k_v": 4e3, "k_i": 1e4, "k_ff": 0.5, "limit": 50.0},
    ),
    "cascade of two samples": (controllers.cascade, {"k_p": 80.0, "k_v": 4e3, "averaging": 2}),
    "sliding_mode": (controllers.sliding_mode, {**ON_SURFACE, "K_2": 2.0, "phi": 0.01}),
    "sliding_mode by an observer": (
        controllers.sliding_mode,
        {**ON_SURFACE, "estimator": "tracking_observer"},
    ),
    "super_twisting": (controllers.super_twisting, {**ON_SURFACE, "k_1": 0.5, "k_2": 5.0}),
    "disturbance_observer": (controllers.disturbance_observer, {**ON_SURFACE, "g": 60.0}),
    "lugre_observer": (
        controllers.lugre_observer,
        {
            **ON_SURFACE,
            "F_C": 3.0,
            "F_S": 4.0,
            "v_S": 0.2,
            "sigma_0": 1e3,
            "sigma_2": 2.0,
            "k": 0.5,
        },
    ),
    "asymptotic_observer": (
        controllers.asymptotic_observer,
        {
            **ON_SURFACE,
            "g_1": 60.0,
            "g_2": 200.0,
            "F_C": 3.0,
            "sigma_0": 1e3,
            "K_I": 10.0,
            "band": 1e-3,
        },
    ),
    "predictive_reversal": (
        controllers.predictive_reversal,
        {**ON_SURFACE, "F_C": 3.0, "F_S": 4.0, "v_S": 0.2, "F_v": 2.0, "lead": 1e-3, "x_0": 1e-3},
    ),
    "adaptive_hysteresis": (
        controllers.adaptive_hysteresis,
        {**ON_SURFACE, "reach": 0.01, "Gamma": 50.0, "w_max": 5.0, "delta": 0.01},
    ),
    "pid": (PID, {"K_P": 2e3, "K_I": 2e4, "K_D": 80.0}),
}


def test_every_control_law_is_among_those_that_are_run():
    assert {component.name for component, _ in LAWS.values()} >= set(controllers.CONTROLLERS)


def factors_of(unit):
    """Return by what a number of a quantity changes in a unit that is smaller by a power of two."""

    def factor(quantity):
        return 16.0 ** exponents_of(quantity).get(unit, 0.0)

    return factor


def in_unit(component, values, factor):
    """Return the component with these values in another unit."""
    quantities = {name: item.quantity for name, item in component.variables.items()}
    plain = component(validate=False, **values).values
    scaled = {
        name: value if isinstance(value, str) else np.multiply(value, factor(quantities[name]))
        for name, value in plain.items()
    }
    return component(validate=False, **scaled)


def back(factor, cls, value):
    """Return the fields of a state in SI."""
    return [
        getattr(value, name) / factor(item.quantity) for name, item in variables_of(cls).items()
    ]


def commands(component, values, factor):
    law, rows = in_unit(component, values, factor), []
    dt, rates = (
        1e-3 * factor("time"),
        [factor(item) for item in ("length", "length/time", "length/time^2", "force")],
    )
    state = component.start(*(1e-3 * by for by in rates[:3]), dt, law.parameters)
    for desired, measured in ((1e-3, 0.0), (2e-3, 1e-3), (0.1, 2e-3), (-1e-3, -1e-3)):
        reference = Reference(
            *(value * by for value, by in zip((desired, 0.3, -2.0, 5.0), rates, strict=True))
        )
        effort, state = component.step(state, reference, measured * rates[0], dt, law.parameters)
        rows += [effort / factor("force"), *back(factor, component.State, state)]
    return rows


def outputs(operator, values, factor):
    model, state, rows = in_unit(operator, values, factor), operator.State(), []
    memory = operator.new_memory(model.parameters)
    for place in (1e-7, 1e-6, 2e-6, 5e-7, -1e-6, 3e-6):
        output, move = operator.trial(
            state, memory, place * factor(operator.input), model.parameters
        )
        state = operator.commit(state, memory, move, model.parameters)
        rows.append(output / factor(operator.output))
    return rows


def moved(plant, values, factor):
    p, dt, effort = (
        in_unit(plant, values, factor).parameters,
        1e-3 * factor("time"),
        3.0 * factor("force"),
    )
    state = plant.State(
        *(1e-3 * factor(item.quantity) for item in variables_of(plant.State).values())
    )
    mean, compliance = plant.port(state, effort, dt, p)
    after = [plant.step(state, effort, factor("force"), dt, p)[1], plant.rest(state, effort, dt, p)]
    ratio = factor("length/time")
    return [
        mean / ratio,
        compliance / ratio * factor("force"),
        *(number for item in after for number in back(factor, plant.State, item)),
    ]


EVERY = [
    *((commands, component, values) for component, values in LAWS.values()),
    *((outputs, operator, operator.example) for operator in hysteresis.OPERATORS.values()),
    *(
        (
            moved,
            item,
            {key: item.example.get(key, part.nominal) for key, part in item.variables.items()},
        )
        for item in plants.PLANTS.values()
    ),
]


@pytest.mark.parametrize("unit", ["length", "time", "force"])
@pytest.mark.parametrize(
    ("run", "component", "values"), EVERY, ids=[item.name for _, item, _ in EVERY]
)
def test_other_units_change_no_law_operator_or_plant(run, component, values, unit):
    expected = run(component, values, factors_of(""))
    assert run(component, values, factors_of(unit)) == pytest.approx(expected, rel=1e-9, abs=1e-15)

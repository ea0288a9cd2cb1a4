"""An axis with its friction in python-control: the same values, in whatever order it asks for them."""

import sys

import control as ct
import numpy as np
import pytest

import bristle as br
from bristle.apps import targets as bridges
from bristle.apps.targets import to_control
from bristle.core.contracts import example_of
from bristle.core.errors import InputError, InputWarning, MissingExtraError

DT = 5e-4
PLANT = br.plants.inertia(M=28.0)
# Discrete memory of each kind: none but a jump, elements, turning points, a state that changes at reversals.
SAMPLED = ("coulomb", "maxwell_slip", "preisach_lugre", "maxwell_stribeck", "lugre")
ODES = ("dahl", "bouc_wen", "bouc_wen_classic", "lugre", "elastoplastic", "viscous")
INTEGRATED_LATER = ("bouc_wen", "bouc_wen_classic", "elastoplastic")


def effort_over(t):
    return 45.0 * np.sin(40.0 * t) + 12.0 * np.sin(171.0 * t)


def run(system, t, u, **options):
    return ct.input_output_response(system, t, u, **options)


@pytest.mark.parametrize("name", SAMPLED)
def test_a_sampled_axis_is_identical_to_the_engine(name):
    friction = example_of(br.friction.MODELS[name])
    t = DT * np.arange(400)
    trace = br.engine.run_open_loop(PLANT, friction, effort_over(t), DT, steps=2)
    result = run(to_control(friction, PLANT, dt=DT, steps=2), t, effort_over(t))
    for signal, row in zip(("position", "velocity", "friction"), result.outputs, strict=True):
        np.testing.assert_array_equal(row, getattr(trace, signal), err_msg=signal)
    assert np.ptp(result.outputs[0]) > 1e-6


@pytest.mark.parametrize("name", SAMPLED)
def test_a_sampled_contact_is_identical_to_response(name):
    friction = example_of(br.friction.MODELS[name])
    x = 3e-6 * np.sin(np.linspace(0.0, 20.0, 500)) * np.linspace(1.0, 0.3, 500)
    system = to_control(friction, dt=DT)
    result = run(system, DT * np.arange(x.size - 1), np.diff(x) / DT)
    np.testing.assert_array_equal(result.outputs, br.response(friction, x, DT)[1:])


@pytest.mark.parametrize("name", ["maxwell_slip", "preisach_lugre"])
def test_calls_in_any_order_give_the_same_results(name):
    friction = example_of(br.friction.MODELS[name])
    system = to_control(friction, PLANT, dt=DT)
    t = DT * np.arange(60)
    states = run(system, t, effort_over(t), return_states=True).states.T
    assert np.any(states[:, [label.startswith("memory") for label in system.state_labels]] != 0.0)
    for k in (40, 3, 57, 3, 40):
        handed = states[k].copy()
        system.output(t[k], handed, [-500.0])
        again = system.dynamics(t[k], handed, [effort_over(t[k])])
        np.testing.assert_array_equal(again, states[k + 1])
        np.testing.assert_array_equal(handed, states[k])


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name",
    [
        *(name for name in ODES if name not in INTEGRATED_LATER),
        *(pytest.param(name, marks=pytest.mark.slow) for name in INTEGRATED_LATER),
    ],
)
def test_an_integrated_differential_equation_agrees_with_the_engine(name):
    friction = example_of(br.friction.MODELS[name])
    t = 1e-3 * np.arange(30)
    trace = br.engine.run_open_loop(
        PLANT, friction, effort_over(t), 1e-3, steps=2000, hold="linear"
    )
    options = {"solve_ivp_method": "Radau", "solve_ivp_kwargs": {"rtol": 1e-9, "atol": 1e-13}}
    result = run(to_control(friction, PLANT), t, effort_over(t), **options)
    scale = np.ptp(trace.position)
    assert scale > 1e-6
    np.testing.assert_allclose(result.outputs[0], trace.position, atol=1e-5 * scale, rtol=0.0)
    np.testing.assert_allclose(
        result.outputs[1], trace.velocity, atol=1e-4 * np.ptp(trace.velocity), rtol=0.0
    )


@pytest.mark.slow
def test_friction_can_be_connected_to_a_user_mechanism():
    lugre = example_of(br.friction.lugre)
    mass = ct.nlsys(
        lambda t, x, u, params: [x[1], (u[0] - u[1]) / 28.0],
        lambda t, x, u, params: [x[0], x[1]],
        inputs=["effort", "friction"],
        outputs=["position", "velocity"],
        states=2,
        name="mass",
    )
    axis = ct.interconnect(
        [mass, to_control(lugre)], inputs=["effort"], outputs=["position", "velocity", "friction"]
    )
    t = 1e-3 * np.arange(20)
    options = {"solve_ivp_method": "Radau", "solve_ivp_kwargs": {"rtol": 1e-8, "atol": 1e-13}}
    result, alike = (
        run(system, t, effort_over(t), **options).outputs
        for system in (axis, to_control(lugre, PLANT))
    )
    np.testing.assert_allclose(result[0], alike[0], atol=1e-5 * np.ptp(alike[0]), rtol=0.0)
    np.testing.assert_allclose(result[2], alike[2], atol=1e-3, rtol=0.0)


def test_a_stuck_axis_has_the_poles_of_its_bristles():
    model = br.friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e4, sigma_2=200.0)
    poles = ct.linearize(to_control(model, PLANT), [0.0, 0.0, 0.0], [0.0], eps=1e-9).poles()
    oscillating = poles[np.abs(poles) > 1.0]
    assert np.abs(oscillating) == pytest.approx(2 * [np.sqrt(1e7 / 28.0)], rel=1e-4)
    assert oscillating.real == pytest.approx(2 * [-0.5 * (1e4 + 200.0) / 28.0], rel=1e-3)


ROTATING = to_control(
    br.friction.dahl(F_C="30 mN*m", sigma_0="90 N*m/rad"), br.plants.inertia(M="4e-4 kg*m^2")
)
TABLE = to_control(example_of(br.friction.maxwell_slip), PLANT, dt="1 ms", name="table")


@pytest.mark.parametrize(
    ("system", "name", "expected"),
    [
        (ROTATING, "input_labels", ["effort"]),
        (ROTATING, "output_labels", ["position", "velocity", "friction"]),
        (ROTATING, "state_labels", ["position", "velocity", "F"]),
        (
            ROTATING,
            "units",
            {
                "effort": "N*m",
                "position": "rad",
                "velocity": "rad/s",
                "friction": "N*m",
                "F": "N*m",
            },
        ),
        (TABLE, "dt", 1e-3),
        (TABLE, "name", "table"),
        (
            TABLE,
            "state_labels",
            [
                "position",
                "velocity",
                "memory_0",
                "memory_1",
                "memory_2",
                "solver_slope",
                "solver_acceleration",
            ],
        ),
    ],
)
def test_signals_have_names_and_units(system, name, expected):
    assert getattr(system, name) == expected
    assert "[N*m]" in str(ROTATING)
    assert TABLE.units["solver_acceleration"] == "m/s^2"


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("coulomb", "has a force that jumps at rest"),
        ("stribeck", "has a force that jumps at rest"),
        ("maxwell_slip", "changes its memory in jumps"),
        ("preisach_lugre", "changes its memory in jumps"),
        ("reformed_dahl", "has no `rate`"),
        ("gap_slider", "has no `rate`"),
    ],
)
@pytest.mark.parametrize("plant", [PLANT, None])
def test_models_without_a_differential_equation_are_refused_by_name(name, reason, plant):
    with pytest.raises(InputError, match=rf"friction: {reason}.*found '{name}'.*Give dt"):
        to_control(example_of(br.friction.MODELS[name]), plant)


ROTARY = br.friction.viscous(kind="rotational", F_v=1e-3)


@pytest.mark.parametrize(
    ("friction", "plant", "options", "words"),
    [
        (
            example_of(br.friction.lugre),
            br.plants.inertia(M="1 kg*m^2"),
            {},
            "plant: is not of the kind of friction",
        ),
        (example_of(br.friction.lugre), PLANT, {"steps": 2}, "steps: needs a sampled axis"),
        (example_of(br.friction.lugre), PLANT, {"dt": 0.0}, "dt: must be positive"),
        (
            ROTARY,
            br.plants.ball_screw(kind="rotational", J=1e-4, M=28.0, k=1e8, d=1e3, lead="10 mm"),
            {"dt": DT},
            "has a screw",
        ),
    ],
)
def test_invalid_arguments_are_refused(friction, plant, options, words):
    with pytest.raises(InputError, match=words):
        to_control(friction, plant, **options)


def test_a_full_memory_is_reported():
    tight = br.friction.MODELS["preisach_lugre"](**br.friction.preisach_lugre.example, capacity=4)
    x = 2e-6 * np.cos(np.linspace(0.0, 40.0, 400)) * np.linspace(1.0, 0.1, 400)
    with pytest.warns(InputWarning, match="Raise the parameter capacity"):
        run(to_control(tight, dt=DT), DT * np.arange(x.size - 1), np.diff(x) / DT)


@pytest.mark.parametrize(
    ("name", "module", "library"),
    [
        ("to_control", "system", "control"),
        ("DescribingFunction", "system", "control"),
        ("FrictionRegressor", "regressor", "sklearn"),
    ],
)
def test_without_its_library_a_bridge_names_the_install_command(monkeypatch, name, module, library):
    for part in [part for part in sys.modules if part.startswith(f"{library}.")]:
        monkeypatch.delitem(sys.modules, part)
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.delitem(sys.modules, f"bristle.apps.targets.{module}", raising=False)
    with pytest.raises(MissingExtraError, match=rf'pip install "bristle\[{library}\]"'):
        getattr(bridges, name)

"""Friction as equations and as samples: the vector of states, and how each goes on."""

import numpy as np
import pytest

from bristle import friction, plants
from bristle.core.errors import InputError
from bristle.engine import interpreted, run_open_loop
from bristle.engine.equations import (
    _virgin,
    axis_equations,
    axis_step,
    contact_equations,
    contact_step,
    system_of,
)

PLANT = plants.inertia(M=2.0)
DAHL = friction.dahl(F_C=20.0, sigma_0=1e6)
LUGRE = friction.lugre(F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=1e6, sigma_1=300.0, sigma_2=40.0)


def test_the_equations_of_an_axis_are_those_of_its_mass_and_its_bristles():
    # At a deflection of 5 um the force is 5 N, and a quarter of the motion is lost to slip.
    force, rate = axis_equations(PLANT, LUGRE)(np.array([0.7, 0.2, 5e-6]), 60.0)
    z_dot = 0.2 * (1.0 - 0.25)
    assert force == pytest.approx(5.0 + 300.0 * z_dot + 40.0 * 0.2)
    assert rate.tolist() == pytest.approx([0.2, (60.0 - force) / 2.0, z_dot])


def test_the_equations_of_a_contact_are_driven_by_its_velocity():
    force, rate = contact_equations(LUGRE)(np.array([0.7, 5e-6]), -0.2)
    z_dot = -0.2 * (1.0 + 0.25)
    assert force == pytest.approx(5.0 + 300.0 * z_dot - 40.0 * 0.2)
    assert rate.tolist() == pytest.approx([-0.2, z_dot])


PLACED = friction.find("viscous+position")(
    F_v=10.0, x_0=0.0, x_L=1.0, p_1=0.5, p_2=0.0, a_1=3.0, a_2=0.0
)


@pytest.mark.parametrize(
    ("equations", "state", "force"),
    [
        (contact_equations(friction.viscous(F_v=10.0)), ([0.0], -2.0), -20.0),
        (contact_equations(PLACED), ([0.4], 2.0), 20.0 * 1.2 + 3.0 * 0.4),
        (axis_equations(PLANT, PLACED), ([0.4, 2.0], 0.0), 20.0 * 1.2 + 3.0 * 0.4),
    ],
)
def test_friction_in_equations_sees_velocity_and_position(equations, state, force):
    assert equations(np.array(state[0]), state[1])[0] == pytest.approx(force)


def test_samples_of_an_axis_are_those_of_a_run():
    model, state, rows = (
        friction.maxwell_slip(F_C=20.0, k_i=[6e6, 3e6], nu_i=[0.5, 0.5]),
        np.zeros(6),
        [],
    )
    effort = np.array([10.0, 40.0, 40.0, -30.0, -60.0])
    with interpreted():
        trace, step = (
            run_open_loop(PLANT, model, effort, 1e-3, steps=2),
            axis_step(PLANT, model, 1e-3, 2),
        )
        for u in effort:
            before = state[:2].tolist()
            force, state = step(state, u)
            rows.append((*before, force))
    assert np.array_equal(np.array(rows).T, [trace.position, trace.velocity, trace.friction])
    assert state[2:4] == pytest.approx(trace.memory)


def test_samples_of_a_contact_are_steps_at_constant_velocity():
    with interpreted():
        step, state = contact_step(DAHL, 1e-3), np.zeros(2)
        first, state = step(state, 1e-3)
        assert state[0] == pytest.approx(1e-6)
        second, state = step(state, -1e-3)
    # The mean of a spring of 1e6 N/m over a micrometre, which loses little to slip.
    assert (first, second) == pytest.approx((0.5, 0.5), rel=0.1)
    assert state[0] == 0.0
    assert step(np.array([0.0, 3.0]), 0.0)[0] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("model", "plant", "dt", "states"),
    [
        (DAHL, None, None, {"position": "m", "F": "N"}),
        (DAHL, PLANT, None, {"position": "m", "velocity": "m/s", "F": "N"}),
        (
            DAHL,
            PLANT,
            1e-3,
            {
                "position": "m",
                "velocity": "m/s",
                "F": "N",
                "solver_slope": "1/s",
                "solver_acceleration": "m/s^2",
            },
        ),
        (DAHL, None, 1e-3, {"position": "m", "F": "N"}),
        (
            friction.maxwell_slip(F_C=1.0, k_i=[1.0, 1.0], nu_i=[0.5, 0.5]),
            None,
            1e-3,
            {"position": "m", "memory_0": "", "memory_1": ""},
        ),
        (
            friction.dahl(kind="rotational", F_C=20.0, sigma_0=1e6),
            None,
            None,
            {"position": "rad", "F": "N*m"},
        ),
    ],
)
def test_states_have_names_and_units_in_the_order_of_the_vector(model, plant, dt, states):
    with interpreted():
        system = system_of(model, plant, dt, 1, None, asked_by="here")
        rest = system.output(0.0, np.zeros(len(states)), [0.0], {})
    assert list(system.states.items()) == list(states.items())
    assert rest.tolist() == [0.0] * len(system.outputs)


@pytest.mark.parametrize(("plant", "before", "after"), [(None, 1, 0), (PLANT, 2, 2)])
def test_the_state_of_a_virgin_contact_follows_the_plant_or_the_position(plant, before, after):
    model = friction.preisach_lugre(**friction.preisach_lugre.example)
    contact = [
        *model.component.initial_state(model.parameters),
        *model.component.new_memory(model.parameters),
    ]
    with interpreted():
        size = len(system_of(model, plant, 1e-3, 1, None, asked_by="here").states)
    assert _virgin(model, plant, size).tolist() == [*[0.0] * before, *contact, *[0.0] * after]


def test_signals_have_the_units_of_the_kind_of_axis():
    with interpreted():
        alone, moved = (
            system_of(DAHL, plant, None, 1, None, asked_by="here") for plant in (None, PLANT)
        )
    assert (alone.inputs, alone.outputs) == ({"velocity": "m/s"}, {"friction": "N"})
    assert (moved.inputs, moved.outputs) == (
        {"effort": "N"},
        {"position": "m", "velocity": "m/s", "friction": "N"},
    )


COULOMB, SCREW = (
    friction.coulomb(F_C=20.0),
    plants.ball_screw(J=1e-4, M=28.0, k=1e8, d=1e3, lead="10 mm"),
)
SLIDERS, REFORMED = (
    friction.MODELS[name](**friction.MODELS[name].example)
    for name in ("maxwell_slip", "reformed_dahl")
)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: contact_equations(COULOMB),
            "friction: has a force that jumps at rest, where the contact sticks",
        ),
        (
            lambda: contact_equations(SLIDERS),
            "friction: changes its memory in jumps, at reversals or when an element slips",
        ),
        (
            lambda: contact_equations(REFORMED),
            "friction: has no `rate`.*A smooth model of your own can define `rate",
        ),
        *(
            (lambda model=model: axis_equations(PLANT, model), r'Give dt, such as dt="0.5 ms"')
            for model in (COULOMB, SLIDERS, REFORMED)
        ),
        (
            lambda: axis_equations(SCREW, friction.viscous(kind="rotational", F_v=1e-3)),
            r"plant: has no rate.*found 'ball_screw'",
        ),
        (
            lambda: system_of(DAHL, None, 1e-3, 2, None, asked_by="here"),
            "steps: needs a sampled axis",
        ),
        (
            lambda: system_of(DAHL, PLANT, None, 2, None, asked_by="here"),
            "steps: needs a sampled axis",
        ),
    ],
)
def test_what_is_no_differential_equation_is_refused_with_the_reason(call, words):
    with pytest.raises(InputError, match=words):
        call()

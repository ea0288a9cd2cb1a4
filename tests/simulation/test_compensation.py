"""What is fed forward along a desired motion, numbers by hand, and the experiments that compare it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants
from bristle.core.errors import InputError
from bristle.core.experiment import Feedforward, Start
from bristle.core.fingerprint import digest
from bristle.models.controllers.feedforward import Shape
from bristle.simulation.compensation import (
    carried_effort,
    compensation_experiment,
    compensator_of,
    feedforward_effort,
    friction_along,
    on_another_rig,
    open_loop_experiment,
    settling,
)

pytestmark = pytest.mark.usefixtures("in_plain_python")


DT = 0.1
COULOMB = friction.coulomb(F_C=20.0)
POSITION, ACCELERATION = np.array([0.0, 0.1, 0.3]), np.array([1.0, 2.0, 4.0])


SHAPED = Feedforward(mass=2.0, friction=COULOMB, gain=0.5, offset=1.0, asymmetry=0.1)
RISING = friction.find("viscous+position")(
    F_v=0.0, x_0=0.0, x_L=1.0, p_1=0.0, p_2=0.0, a_1=10.0, a_2=0.0
)
LIFTED = friction.find("coulomb_viscous")(F_C=20.0, F_v=20.0, offset=-3.0)
RISEN = friction.find("coulomb+transmitted")(F_C=20.0, c_T=0.5)
ARM = plants.find("inertia+gravity")(M=2.0, g_sin=3.0, g_cos=5.0, kind="rotational")
MIDDLE = np.array([0.05, 0.2, 0.3])


@pytest.mark.parametrize(
    ("fed", "acceleration", "effort"),
    [
        # The acceleration half way to the next sample.
        (Feedforward(mass=2.0), ACCELERATION, [3.0, 6.0, 8.0]),
        (SHAPED, ACCELERATION, [15.0, 18.0, 20.0]),
        (replace(SHAPED, along="measured"), ACCELERATION, [3.0, 6.0, 8.0]),
        # In the middles of the steps the axis is at 0.05, 0.2, and goes on at its last velocity to 0.4.
        (Feedforward(friction=RISING), 0.0 * ACCELERATION, [0.5, 2.0, 4.0]),
        (
            Feedforward(mass=2.0, plant=ARM),
            ACCELERATION,
            [3.0, 6.0, 8.0] + 3.0 * np.sin(MIDDLE) + 5.0 * np.cos(MIDDLE),
        ),
        (
            Feedforward(friction=RISEN, carries=plants.inertia(M=4.0)),
            ACCELERATION,
            [23.0, 26.0, 28.0],
        ),
    ],
)
def test_mass_plant_and_friction_along_the_desired_motion_are_fed_forward(
    fed, acceleration, effort
):
    assert feedforward_effort(fed, POSITION, acceleration, DT) == pytest.approx(effort)


@pytest.mark.parametrize(
    ("model", "rest", "force"),
    [
        (COULOMB, {}, [0.0, 20.0, 20.0, -20.0, -20.0]),
        (COULOMB, {"rest": "middle"}, [0.0, 20.0, 0.0, -20.0, 0.0]),
        (friction.viscous(F_v=2.0), {}, [0.0, 2.0, 0.0, -2.0, 0.0]),
        (friction.find("coulomb")(F_C=5.0, offset=1.5), {}, [1.5, 6.5, 6.5, -3.5, -3.5]),
    ],
)
def test_at_rest_the_friction_feedforward_keeps_its_side_or_takes_the_middle(model, rest, force):
    assert friction_along(model, np.array([0.0, 1.0, 0.0, -1.0, 0.0]), DT, **rest).tolist() == force


def test_transmitted_effort_is_that_of_the_plant_or_the_feedforward():
    fed = Feedforward(mass=2.0)
    assert carried_effort(fed, POSITION, ACCELERATION, DT).tolist() == pytest.approx(
        [3.0, 6.0, 8.0]
    )
    spring = plants.oscillator(M=2.0, c=3.0, k=10.0)
    # Half way: positions 0.05, 0.2, 0.3, velocities 1, 2, 2, accelerations 1.5, 3, 4.
    expected = [3.0 + 3.0 + 0.5, 6.0 + 6.0 + 2.0, 8.0 + 6.0 + 3.0]
    assert carried_effort(
        replace(fed, carries=spring), POSITION, ACCELERATION, DT
    ).tolist() == pytest.approx(expected)
    with pytest.raises(
        InputError,
        match=r"feedforward.carries: is a plant without inverse dynamics; found 'pulled_inertia', allowed inertia, oscillator.*Remove",
    ):
        carried_effort(
            replace(fed, carries=plants.pulled_inertia(M=1.0, k=1.0, v_e=0.0)),
            POSITION,
            ACCELERATION,
            DT,
        )


def test_a_compensator_runs_along_the_measured_motion_only_where_asked_for():
    assert compensator_of(Feedforward()) is None
    assert compensator_of(Feedforward(friction=COULOMB)) is None
    fed = Feedforward(
        friction=COULOMB,
        along="measured",
        gain=0.5,
        offset=1.0,
        asymmetry=0.1,
        limit=9.0,
        rate_limit=7.0,
    )
    compensator = compensator_of(fed, np.ones(3))
    assert compensator.shape == Shape(0.5, 1.0, 0.1, 9.0, 7.0)
    whole = compensator_of(
        replace(fed, friction=LIFTED, scaled="contact", return_distance=0.2, fade_time=0.5)
    ).shape
    assert whole == Shape(0.5, 1.0, 0.1, 9.0, 7.0, 0.2, 0.5, -3.0, 20.0)
    assert compensator.transmitted.tolist() == [1.0, 1.0, 1.0]


def test_a_compensator_is_conditioned_before_it_runs():
    sliders = friction.maxwell_slip(F_C=20.0, k_i=[2e6], nu_i=[1.0])
    virgin, conditioned = (
        friction_along(sliders, np.array([1e-6, -1e-6]), 1.0, conditioning=amount)
        for amount in (0.0, 1e-4)
    )
    assert virgin[0] == pytest.approx(1.0)
    assert conditioned[0] != pytest.approx(1.0)
    assert (
        compensator_of(Feedforward(friction=sliders, along="measured", conditioning=1e-4)).memory[0]
        != 0.0
    )


@pytest.mark.parametrize(("duration", "seconds"), [(4.0, 0.2), (10.0, 0.5), (100.0, 0.5)])
def test_a_loop_settles_a_twentieth_of_its_duration_and_half_a_second_at_most(duration, seconds):
    assert settling(duration) == pytest.approx(seconds)


def experiment(controller=None, **options):
    law = controllers.cascade(k_p=60.0, k_v=3000.0) if controller is None else controller
    reference = np.linspace(0.0, 1.0, 100)
    return compensation_experiment(
        plants.inertia(M=3.0),
        COULOMB,
        friction.coulomb(F_C=19.0),
        law,
        reference,
        "10 ms",
        **options,
    )


def test_three_loops_have_no_motion_and_friction_feedforward():
    recorded, fed, compensated = experiment().variants
    assert [item.name for item in (recorded, fed, compensated)] == [
        "as_recorded",
        "feedforward",
        "compensated",
    ]
    assert [item.feedforward.mass for item in (recorded, fed, compensated)] == [0.0, 3.0, 3.0]
    assert [item.controller.values["k_ff"] for item in (recorded, fed, compensated)] == [
        0.0,
        1.0,
        1.0,
    ]
    assert recorded.feedforward.friction is fed.feedforward.friction is None
    assert compensated.feedforward.friction.values["F_C"] == 19.0
    assert recorded.friction.values["F_C"] == 20.0


def test_the_loops_of_an_experiment_use_its_options():
    unseen, known, start = np.full(100, 2.0), np.full(100, 3.0), Start(0.1, 0.2)
    result = experiment(
        resolution="1 um",
        effort_limit=50.0,
        lag=1e-3,
        disturbance=unseen,
        injected=known,
        start=start,
        name="bench",
    )
    assert (result.name, result.kind) == ("bench", "translational")
    run = {
        "duration": 1.0,
        "sample_time": 0.01,
        "settle": 0.05,
        "effort_limit": 50.0,
        "current_lag": 1e-3,
    }
    for item in result.variants:
        assert {name: getattr(item.run, name) for name in run} == pytest.approx(run)
        assert (
            item.sensor.values["resolution"],
            item.disturbance[0],
            item.injected[0],
            item.start,
        ) == (1e-6, 2.0, 3.0, start)
    plain = experiment().variants[0]
    assert (plain.run.effort_limit, plain.run.current_lag, plain.sensor.values["resolution"]) == (
        math.inf,
        0.0,
        0.0,
    )


def test_a_law_with_an_inertia_gets_no_mass_feedforward():
    variables, defaults = (
        controllers.disturbance_observer.variables,
        controllers.disturbance_observer.defaults,
    )
    law = controllers.disturbance_observer(
        **dict.fromkeys([name for name in variables if name not in defaults], 1.0)
    )
    assert [item.feedforward.mass for item in experiment(law).variants] == [0.0, 0.0, 0.0]


def test_a_compensator_of_another_friction_is_noted():
    plain = experiment()
    fitted = {
        "its own": digest(COULOMB),
        "another": digest(friction.coulomb(F_C=1.0)),
        "nobody's": "",
    }
    variants = tuple(
        replace(
            plain.variants[2],
            name=name,
            feedforward=replace(plain.variants[2].feedforward, fitted_to=mark),
        )
        for name, mark in fitted.items()
    )
    notes = on_another_rig(replace(plain, variants=variants))
    assert list(notes) == ["another"]
    assert (notes["another"].code, notes["another"].severity, notes["another"].kind) == (
        "another_rig",
        "note",
        "translational",
    )


def test_an_open_loop_lasts_as_long_as_its_effort():
    (base,) = open_loop_experiment(
        plants.inertia(M=3.0), COULOMB, np.ones(50), "20 ms", settle=0.1
    ).variants
    assert (base.run.duration, base.run.sample_time, base.run.settle) == pytest.approx(
        (1.0, 0.02, 0.1)
    )
    assert base.sensor.values["resolution"] == 0.0
    assert base.effort.values.tolist() == [1.0] * 50

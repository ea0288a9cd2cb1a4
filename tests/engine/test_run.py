"""What the engine refuses before compiled code would run out of bounds with it."""

import math

import numpy as np
import pytest

from bristle import controllers, friction, response, sensors
from bristle.core import InputError
from bristle.engine import drivers, force_along, run_closed_loop, run_open_loop, settled
from bristle.models.plants import inertia

pytestmark = pytest.mark.usefixtures("in_plain_python")

MAXWELL = friction.maxwell_slip(F_C=1.0, k_i=[4e5, 1e5], nu_i=[0.5, 0.5])
LOOP = (
    inertia(M=1.0),
    friction.coulomb(F_C=1.0),
    controllers.cascade(k_p=1.0, k_v=1.0),
    sensors.encoder(),
)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: force_along(MAXWELL, np.ones(3), 1e-3, memory=np.zeros(1)), "memory.*size"),
        (lambda: force_along(MAXWELL, np.ones(3), 1e-3, np.ones(2)), "x: .*length"),
        (lambda: force_along(MAXWELL, np.ones(3), 0.0), "dt: must be positive"),
        (
            lambda: force_along(MAXWELL, [1.0, np.nan], 1e-3),
            "v: contains values that are not finite",
        ),
        (lambda: response(MAXWELL, [0.0, np.inf], 1e-3), "x: contains values that are not finite"),
        (lambda: response(MAXWELL, [[0.0, 1.0]], 1e-3), "1-D"),
        (lambda: response(MAXWELL, [0.0, 1.0], -1.0), "dt"),
        (lambda: response(MAXWELL, [0.0, 1.0], "1 mm"), "dt: has the wrong unit"),
        (lambda: response(MAXWELL, [0.0, 1.0], np.ones(2)), "dt: must be a number"),
        (lambda: response(MAXWELL, [0.0, 1j], 1e-3), "x: must hold real numbers"),
        (lambda: response(MAXWELL, ["1 mm"], 1e-3), "x: must hold real numbers"),
        (lambda: response(MAXWELL, [[1.0], [1.0, 2.0]], 1e-3), "x: must hold real numbers"),
        (
            lambda: response(MAXWELL, np.ma.masked_invalid([0.0, np.nan]), 1e-3),
            "x: has masked values",
        ),
        (
            lambda: response(MAXWELL, [0.0, 1e308, -1e308], 1e-3),
            "v: contains values that are not finite",
        ),
        (
            lambda: response(friction.coulomb, [0.0, 1.0], 1e-3),
            "model: must be a friction model or hysteresis operator with parameters",
        ),
        (
            lambda: response("coulomb", [0.0, 1.0], 1e-3),
            "model: must be a friction model or hysteresis operator with parameters",
        ),
        (
            lambda: friction.with_presliding(friction.coulomb(F_C=1.0), np.nan),
            "distance: must be a finite",
        ),
        (
            lambda: friction.with_presliding(friction.coulomb(F_C=1.0), 2e-6).with_values(
                presliding=-1.0
            ),
            "presliding",
        ),
        *(
            (lambda dt=dt: run_open_loop(*LOOP[:2], np.zeros(2), dt), "dt")
            for dt in (1.001e5, 0.0, -1e-3)
        ),
        # Values that are not validated keep kernels within their arrays.
        *(
            (
                lambda nu=nu: friction.maxwell_slip(
                    F_C=1.0, k_i=[4e5, 1e5], nu_i=nu, validate=False
                ),
                "of the same length",
            )
            for nu in ([0.5], [], [0.5, 0.3, 0.2])
        ),
        (
            lambda: friction.find("maxwell_slip+asymmetry")(
                F_C_pos=1, F_C_neg=1, k_i=[4e5, 1e5], nu_i=[0.5], validate=False
            ),
            "of the same length",
        ),
        (lambda: run_open_loop(*LOOP[:2], np.ones(3), 1e-3, steps=0), "steps"),
        (lambda: run_open_loop(*LOOP[:2], np.ones(3), 1e-3, steps=1.5), "steps"),
        (lambda: run_open_loop(*LOOP[:2], np.ones(3), 1e-3, hold="cubic"), "hold"),
        (lambda: run_open_loop(*LOOP[:2], [1.0, np.nan], 1e-3), "effort"),
        (lambda: run_open_loop(*LOOP[:2], np.ones(3), 1e-3, v=np.nan), "v: must be a finite"),
        (
            lambda: run_open_loop(inertia(M=1.0), MAXWELL, np.ones(3), 1e-3, memory=np.zeros(9)),
            "memory",
        ),
        (lambda: run_closed_loop(*LOOP, np.zeros((4, 10)), 1e-3, delay=-1), "delay"),
        (lambda: run_closed_loop(*LOOP, np.zeros((4, 10)), 1e-3, injected=np.zeros(5)), "injected"),
        (
            lambda: run_closed_loop(*LOOP, np.zeros((4, 10)), 1e-3, disturbance=np.zeros(5)),
            "disturbance",
        ),
        (lambda: run_closed_loop(*LOOP, np.zeros((3, 10)), 1e-3), "reference"),
        (lambda: run_closed_loop(*LOOP, np.full((4, 10), np.nan), 1e-3), "reference"),
    ],
)
def test_invalid_arguments_are_refused_by_name(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_text_for_a_time_step_is_the_number():
    x = [0.0, 1e-6, 5e-6]
    np.testing.assert_array_equal(response(MAXWELL, x, "2 ms"), response(MAXWELL, x, 2e-3))


def test_a_given_memory_is_not_changed():
    memory = np.array([1e-7, -2e-7])
    force_along(MAXWELL, np.ones(5), 1e-6, memory=memory)
    run_open_loop(inertia(M=1.0), MAXWELL, np.ones(5), 1e-3, memory=memory)
    assert memory.tolist() == [1e-7, -2e-7]


@pytest.mark.parametrize("v", [1e-4, -3e-2, 0.5])
@pytest.mark.parametrize("name", ["coulomb_viscous+asymmetry", "lugre+asymmetry", "maxwell_slip"])
def test_a_settled_model_stays_settled(name, v):
    component = friction.find(name)
    model = component(**component.example, offset=0.5)
    state, memory = settled(model, v)
    force = force_along(model, np.full(20, v), 1e-3, state=state, memory=memory)
    assert np.ptp(force) <= 1e-9 * abs(force[0])


def test_signals_of_a_run_have_separate_rows():
    rows = (
        "POSITION",
        "VELOCITY",
        "MEASURED",
        "COMMAND",
        "EFFORT",
        "FRICTION",
        "MOTOR_POSITION",
        "MOTOR_VELOCITY",
        "FED",
    )
    assert sorted(getattr(drivers, row) for row in rows) == list(range(drivers.ROWS))


FREE = (inertia(M=2.0), friction.viscous(F_v=0.0))


def test_by_default_a_run_begins_at_rest_at_the_origin():
    still, stepped = (
        run_open_loop(*FREE, np.zeros(5), 0.1),
        run_open_loop(*FREE, [2.0, 0.0, 0.0], 0.1),
    )
    linear = run_open_loop(*FREE, [2.0, 0.0, 0.0], 0.1, hold="linear")
    law = controllers.cascade(k_p=0.0, k_v=0.0)
    loop = run_closed_loop(*FREE, law, sensors.encoder(), np.zeros((4, 5)), 0.1)
    for trace in (still, loop):
        assert not np.any([trace.position, trace.velocity, trace.effort, trace.friction])
    assert stepped.velocity == pytest.approx([0.0, 0.1, 0.1])
    assert linear.velocity == pytest.approx([0.0, 0.05, 0.05])


@pytest.mark.parametrize(
    ("options", "effort"),
    [
        ({}, [1e9] * 6),
        ({"delay": 2}, [0.0] * 2 + [1e9] * 4),
        ({"delay": 2, "effort_before": 7.0}, [7.0] * 2 + [1e9] * 4),
        ({"limit": 5.0, "delay": 1}, [0.0] + [5.0] * 5),
    ],
)
def test_by_default_a_loop_has_no_delay_lag_or_limit(options, effort):
    reference = np.zeros((4, 6))
    reference[3] = 1e9  # fed forward
    loop = *FREE, controllers.cascade(k_p=0.0, k_v=0.0), sensors.encoder(), reference, 1e-3
    assert run_closed_loop(*loop, **options).effort.tolist() == effort
    # Of the impulse of a sample a drive with a lag as long gives 1/e.
    assert [
        run_closed_loop(*loop, **lag).velocity[1] for lag in ({}, {"lag": 1e-3})
    ] == pytest.approx([5e5, 5e5 * math.exp(-1.0)])


@pytest.mark.parametrize(
    ("name", "ends", "beyond"),
    [
        ("delay", (0, 3), (-1, 10**6 + 1, 0.5)),
        ("steps", (1, 3), (0, 10**6 + 1)),
        ("lag", (0.0, 1.0), (-1e-9,)),
        ("limit", (0.0, np.inf), (-1e-9,)),
    ],
)
def test_limits_of_loop_arguments_are_inclusive(name, ends, beyond):
    for value in ends:
        assert run_closed_loop(*LOOP, np.zeros((4, 3)), 1e-3, **{name: value}).time.size == 3
    for value in beyond:
        with pytest.raises(InputError, match=name):
            run_closed_loop(*LOOP, np.zeros((4, 3)), 1e-3, **{name: value})


def test_a_sample_may_last_a_day():
    assert run_open_loop(*FREE, np.zeros(2), 1e5).time.tolist() == [0.0, 1e5]


def test_models_are_equal_if_all_numbers_of_their_arrays_are_equal():
    again, other = (
        friction.maxwell_slip(F_C=1.0, k_i=[4e5, k], nu_i=[0.5, 0.5]) for k in (1e5, 2e5)
    )
    assert (again == MAXWELL, hash(again) == hash(MAXWELL), other == MAXWELL) == (True, True, False)


def test_a_map_with_presliding_has_its_distance_as_a_parameter():
    component = friction.find("stribeck+asymmetry")
    model = friction.with_presliding(component(**component.example, offset=0.5), 2e-6)
    assert (model.values["presliding"], model.values["offset"]) == (2e-6, 0.5)
    assert "presliding=2e-06 m" in repr(model)
    assert model.with_values(presliding=3e-6).values["presliding"] == 3e-6

"""Two ports for friction: a motor and a table with an elastic screw between them."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle import friction
from bristle.core.contracts import Motion
from bristle.core.errors import InputError
from bristle.core.status import Status
from bristle.engine import interpreted, run_adaptive, run_batch, run_closed_loop, run_open_loop
from bristle.engine.screwed import Memories, Pulled, screw_force, through_screw
from bristle.models.controllers import cascade
from bristle.models.plants import ball_screw, inertia
from bristle.models.sensors import encoder

ARM = 5e-3 / (2.0 * math.pi)  # [m] of travel for one radian
J, M, K = 1e-4, 20.0, 1e8
# One law on both sides, so that one compiled motion is enough.
LAW = friction.coulomb_viscous
FREE, LOOSE = LAW(kind="rotational", F_C=0.0, F_v=0.0), LAW(F_C=0.0, F_v=0.0)
MOTOR, TABLE = LAW(kind="rotational", F_C=0.02, F_v=0.0), LAW(F_C=40.0, F_v=0.0)


def screw(**values):
    return ball_screw(
        kind="rotational", **({"J": J, "M": M, "lead": 5e-3, "k": K, "d": 0.0} | values)
    )


def energy(trace, k=K):
    """Return the energy [J] of both masses and of the spring between them."""
    twist = trace.motor_position - trace.position
    both = J * trace.motor_velocity**2 + M * (ARM * trace.velocity) ** 2
    return 0.5 * (both + k * (ARM * twist) ** 2)


def test_free_vibration_has_the_frequency_of_two_masses_and_keeps_its_energy():
    h, effort = 1e-5, np.zeros(20_000)
    effort[0] = 1.0
    trace = run_open_loop(screw(), FREE, effort, h, table=LOOSE)
    twist = trace.motor_position - trace.position
    rising = np.flatnonzero((twist[1:-1] <= 0.0) & (twist[2:] > 0.0))
    result = 2.0 * math.pi * (rising.size - 1) / (h * (rising[-1] - rising[0]))
    assert result == pytest.approx(ARM * math.sqrt(K * (1.0 / J + 1.0 / (M * ARM**2))), rel=2e-4)
    assert np.ptp(energy(trace)[1:]) < 1e-12 * energy(trace)[1]


def test_a_stiff_screw_is_one_inertia_with_the_sum_of_both_frictions():
    h = 1e-4
    t = h * np.arange(4000)
    effort = 0.12 * np.sin(2.0 * np.pi * 4.0 * t)
    rigid = run_open_loop(
        inertia(kind="rotational", M=J + M * ARM**2),
        LAW(kind="rotational", F_C=0.02 + 40.0 * ARM, F_v=0.0),
        effort,
        h,
        steps=2,
    ).position
    missed = []
    for k, d in ((1e8, 2e3), (1e10, 1e5), (1e12, 2e6)):
        trace = run_open_loop(screw(k=k, d=d), MOTOR, effort, h, table=TABLE, steps=2)
        assert trace.status is Status.OK
        missed.append(np.max(np.abs(trace.position - rigid)))
    assert missed[0] > 5.0 * missed[1] > 25.0 * missed[2]
    assert missed[2] < 1e-3 * np.max(np.abs(rigid))


def test_backlash_agrees_with_a_solver_of_differential_equations():
    k, d, gap = 1e7, 3e3, 2.5e-5 / ARM
    h = 2e-5
    t = h * np.arange(6_500)

    def effort(at):
        return 0.1 * np.sin(2.0 * np.pi * 6.0 * at)

    def right_hand_side(at, y):
        twist = y[0] - y[2]
        touches = abs(twist) > gap
        force = (
            (k * (twist - math.copysign(gap, twist)) + d * (y[1] - y[3])) * ARM**2
            if touches
            else 0.0
        )
        return [
            y[1],
            (effort(at) - 1e-3 * y[1] - force) / J,
            y[3],
            (force - 200.0 * ARM**2 * y[3]) / (M * ARM**2),
        ]

    solved = solve_ivp(
        right_hand_side,
        (0.0, t[-1]),
        [0.0] * 4,
        method="Radau",
        rtol=1e-8,
        atol=1e-11,
        max_step=2e-4,
        t_eval=t,
    ).y
    plant = screw(k=k, d=d, backlash=5e-5)
    viscous, guides = LAW(kind="rotational", F_C=0.0, F_v=1e-3), LAW(F_C=0.0, F_v=200.0)
    errors = []
    for steps in (1, 4):
        trace = run_open_loop(
            plant, viscous, effort(t), h, table=guides, steps=steps, hold="linear"
        )
        errors.append(np.max(np.abs(trace.position - solved[2])))
    assert np.ptp(trace.motor_position - trace.position) > 1.9 * gap
    assert errors[1] < 0.4 * errors[0] < 1e-4 * np.ptp(solved[2])


def test_backlash_without_damping_conserves_energy():
    h, effort = 2e-5, np.zeros(10_000)
    effort[0] = 5.0
    trace = run_open_loop(screw(backlash=2e-5), FREE, effort, h, table=LOOSE)
    kinetic = 0.5 * (J * trace.motor_velocity**2 + M * (ARM * trace.velocity) ** 2)
    assert np.max(kinetic[1:]) <= kinetic[1] * (1.0 + 1e-9)
    assert np.max(np.diff(np.sign(trace.motor_velocity[1:] - trace.velocity[1:]))) > 0.0


def test_each_side_sticks_independently():
    h = 1e-4
    effort = np.concatenate((np.full(200, 0.03), np.full(400, 0.0)))
    trace = run_open_loop(screw(d=2e3), MOTOR, effort, h, table=TABLE)
    # 40 N at the table are 32 mN*m at the motor: the motor winds the screw up, and the table stays.
    assert np.all(trace.position == 0.0)
    assert np.all(trace.velocity == 0.0)
    fixed = trace.motor_position[150:200]
    assert fixed[0] > 0.0
    assert np.all(fixed == fixed[0])
    assert np.all(trace.motor_velocity[-100:] == 0.0)


def test_a_stopped_table_does_not_move():
    h = 1e-4
    effort = np.concatenate((np.full(300, 0.15), np.zeros(1500)))
    trace = run_open_loop(screw(d=2e3), MOTOR, effort, h, table=TABLE)
    assert trace.position[300] > 0.1
    last = slice(-200, None)
    assert np.all(trace.velocity[last] == 0.0)
    assert np.all(trace.motor_velocity[last] == 0.0)
    assert np.ptp(trace.position[last]) == np.ptp(trace.motor_position[last]) == 0.0


@pytest.mark.slow
def test_memory_of_both_sides_is_identical_in_plain_python():
    motor = friction.maxwell_slip(kind="rotational", F_C=0.02, k_i=[20.0, 5.0], nu_i=[0.5, 0.5])
    table = friction.gms(
        F_C=20.0, F_S=28.0, v_S=2e-3, C=2e3, k_i=[6e6, 3e6], nu_i=[0.5, 0.5], sigma_2=800.0
    )
    effort = 0.06 * np.sin(np.arange(150) * 0.1)
    compiled = run_open_loop(screw(d=2e3), motor, effort, 1e-4, table=table, steps=2)
    with interpreted():
        plain = run_open_loop(screw(d=2e3), motor, effort, 1e-4, table=table, steps=2)
    for name in ("position", "velocity", "motor_position", "motor_velocity", "friction"):
        assert np.array_equal(getattr(compiled, name), getattr(plain, name)), name


@pytest.mark.parametrize(
    ("side", "seen", "unseen"),
    [("motor", "motor_position", "position"), ("load", "position", "motor_position")],
)
def test_the_sensor_reads_either_side(side, seen, unseen):
    reference = np.zeros((4, 150))
    reference[0] = 0.5 * (1.0 - np.cos(0.05 * np.arange(150)))
    law, sensor = cascade(kind="rotational", k_p=40.0, k_v=0.02), encoder(kind="rotational")
    with interpreted():
        trace = run_closed_loop(
            screw(d=2e3, backlash=2e-5),
            MOTOR,
            law,
            sensor,
            reference,
            1e-3,
            table=TABLE,
            sensor_at=side,
            steps=4,
        )
    assert trace.status is Status.OK
    assert np.array_equal(trace.measured, getattr(trace, seen))
    assert np.max(np.abs(trace.measured - getattr(trace, unseen))) > 1e-5 / ARM


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: run_open_loop(inertia(M=1.0), TABLE, np.zeros(5), 1e-3, table=TABLE),
            "no table behind a screw",
        ),
        (
            lambda: run_open_loop(screw(), MOTOR, np.zeros(5), 1e-3, table=MOTOR),
            "must be translational",
        ),
        (lambda: run_batch(screw(), MOTOR, np.zeros(5), 1e-3), "simulates one mass only"),
        (
            lambda: run_adaptive(screw(), MOTOR, np.zeros(5), 1e-3, tolerance=1e-6),
            "simulates one mass only",
        ),
    ],
)
def test_invalid_arguments_are_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()


@pytest.mark.parametrize(
    ("twist", "turned", "force"),
    [
        (0.0, 0.05, 0.0),  # inside the gap
        # In touch throughout: the mean of 0.2 and 0.4, and damping.
        (0.3, 0.2, 10.0 * 0.3 + 2.0 * 0.4),
        (-0.3, -0.2, -10.0 * 0.3 - 2.0 * 0.4),
        # Comes into touch after a third of the way.
        (0.0, 0.3, (10.0 * 0.1 + 2.0 * 0.4) * 2.0 / 3.0),
        (0.3, 0.0, 10.0 * 0.2),
        (0.05, 0.0, 0.0),
    ],
)
def test_a_screw_pulls_by_its_stretch_beyond_the_gap(twist, turned, force):
    between = Pulled(None, k=10.0, d=2.0, gap=0.1, arm=1.0, v_m=0.0, twist=twist)
    assert screw_force(twist, turned, 0.5, between) == pytest.approx(force)


def test_a_screw_without_a_gap_acts_as_a_spring_at_once():
    assert screw_force(
        0.3, 0.0, 0.0, Pulled(None, k=10.0, d=2.0, gap=0.0, arm=1.0, v_m=0.0, twist=0.3)
    ) == pytest.approx(3.0)


def test_each_side_of_an_export_has_its_own_memory():
    """The same steps as with one array for both memories, whose sizes and contents differ."""
    motor = friction.maxwell_slip(kind="rotational", F_C=0.02, k_i=[40.0, 10.0], nu_i=[0.5, 0.5])
    table = friction.maxwell_slip(F_C=40.0, k_i=[4e7, 1e7, 3e6], nu_i=[0.3, 0.3, 0.4])
    forces = []
    for exported in (False, True):
        model = through_screw(screw(d=2e3), motor, table, exported=exported)
        component, p = model.component, model.parameters
        sizes = component.memory_sizes(p)
        arrays = [side.component.new_memory(side.parameters) for side in (motor, table)]
        memory = Memories(*arrays) if exported else np.concatenate(arrays)
        assert sizes == (len(arrays[0]), len(arrays[1]))
        state, x, efforts = component.initial_state(p), 0.0, []
        for v in 3.0 * np.sin(0.05 * np.arange(400)):
            force, move = component.trial(state, memory, Motion(v, x), 1e-4, p)
            state, x = component.commit(state, memory, move, p), x + 1e-4 * v
            efforts.append(force)
        forces.append(efforts)
    assert np.ptp(forces[0]) > 0.02
    assert forces[0] == forces[1]

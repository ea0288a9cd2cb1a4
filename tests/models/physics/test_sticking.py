"""Coulomb friction truly sticks: exact arrest, exact rest, the reaction, and break-away of second order."""

import numpy as np
import pytest

from bristle import friction
from bristle.core.status import Status
from bristle.engine import interpreted, run_open_loop
from bristle.models.plants import inertia


@pytest.mark.parametrize("h", [1e-4, 1.3e-3, 1e-2, 0.1, 0.7])
@pytest.mark.parametrize("v0", [1.0, -1.0])
def test_a_block_stops_at_the_exact_place(h, v0):
    M, F_C = 2.0, 3.0
    distance = 0.5 * M * v0**2 / F_C  # kinetic energy over force
    trace = run_open_loop(
        inertia(M=M), friction.coulomb(F_C=F_C), np.zeros(round(2.0 / h)), h, v=v0
    )
    assert trace.status == Status.OK
    assert abs(trace.position[-1] - np.sign(v0) * distance) < 1e-12
    after = trace.time > M / F_C + h
    assert np.all(trace.velocity[after] == 0.0)
    assert np.all(trace.position[after] == trace.position[-1])


def test_at_rest_the_reaction_is_the_effort_and_the_velocity_exactly_zero():
    u = 2.999 * np.sin(np.linspace(0.0, 40.0, 5000))
    trace = run_open_loop(inertia(M=0.7), friction.coulomb(F_C=3.0), u, 1e-3)
    assert np.all(trace.velocity == 0.0)
    assert np.all(trace.position == 0.0)
    np.testing.assert_allclose(trace.friction, u, rtol=1e-15, atol=0.0)


@pytest.mark.parametrize(("effort", "side"), [(4.9, 0.0), (5.1, 1.0), (-1.1, -1.0)])
def test_rest_under_an_offset_is_off_centre(effort, side):
    with interpreted():
        trace = run_open_loop(
            inertia(M=1.0), friction.find("coulomb")(F_C=3.0, offset=2.0), np.full(50, effort), 1e-3
        )
    assert np.sign(trace.position[-1]) == side


def test_break_away_is_found_to_second_order():
    # A ramp of effort: from break-away on, the excess force grows in proportion to time.
    M, F_C, ramp, end = 1.5, 2.0, 3.0, 1.0
    moved = end - F_C / ramp
    exact = ramp / M * moved**3 / 6.0
    errors = []
    for count in (50, 100, 200, 400, 800, 1600):
        h = end / count
        u = ramp * h * np.arange(count + 1)
        trace = run_open_loop(inertia(M=M), friction.coulomb(F_C=F_C), u, h, hold="linear")
        errors.append(abs(trace.position[-1] - exact))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert np.mean(orders) > 1.9, (errors, orders)


@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_friction_reversal_inside_a_step_is_followed(count):
    # Thrown up an incline of friction and gravity-like load: turns around, in one long step and in many.
    F_C, u, v0 = 1.0, -3.0, 2.0
    turn = v0 / (F_C - u)
    exact = 0.5 * v0 * turn + 0.5 * (u + F_C) * (1.0 - turn) ** 2
    trace = run_open_loop(
        inertia(M=1.0), friction.coulomb(F_C=F_C), np.full(count + 1, u), 1.0 / count, v=v0
    )
    assert trace.position[-1] == pytest.approx(exact, abs=1e-12)


def test_viscous_and_coulomb_friction_stop_at_the_theoretical_place():
    M, F_C, F_v, v0 = 2.0, 1.0, 0.8, 1.5
    # M v' = -F_C - F_v v from v0 to 0.
    distance = M / F_v * (v0 - F_C / F_v * np.log1p(F_v * v0 / F_C))
    errors = []
    for h in (4e-2, 2e-2, 1e-2):
        model = friction.coulomb_viscous(F_C=F_C, F_v=F_v)
        trace = run_open_loop(inertia(M=M), model, np.zeros(round(6.0 / h)), h, v=v0)
        assert trace.velocity[-1] == 0.0
        errors.append(abs(trace.position[-1] - distance))
    assert errors[-1] < 1e-5
    assert np.log2(errors[0] / errors[1]) > 1.7


@pytest.mark.parametrize(
    ("effort", "v", "slides"), [(1.9, 0.0, False), (2.1, 0.0, True), (1.9, 0.1, True)]
)
def test_stribeck_friction_has_its_stiction_spike(effort, v, slides):
    model = friction.stribeck(F_C=1.0, F_S=2.0, v_S=1e-2, F_v=0.0)
    trace = run_open_loop(inertia(M=1.0), model, np.full(1000, effort), 1e-3, v=v)
    assert bool(trace.velocity[-1] > 0.5) is slides
    assert slides or trace.position[-1] == 0.0

"""Adaptive steps: the tolerance is the global error, rest ends when it must, memory survives rejected steps."""

from functools import partial

import numpy as np
import pytest
from tests.contract.models import with_fast

from bristle import friction
from bristle.contract import example_of
from bristle.core.errors import InputError
from bristle.core.status import Status
from bristle.engine import adaptive, interpreted, run_adaptive, run_open_loop
from bristle.engine.adaptive import _stretches
from bristle.engine.loop import held
from bristle.models.plants import inertia, pulled_inertia

# A mass of 1 kg pulled at 0.1 m/s through a spring of 2 N/m: sticks for seconds, slips in tenths of one.
STICK_SLIP = pulled_inertia(M=1.0, k=2.0, v_e=0.1)
BRISTLES = {"F_C": 1.0, "F_S": 1.5, "v_S": 1e-3, "sigma_0": 1e5, "sigma_1": 316.2, "sigma_2": 0.4}
LUGRE = friction.lugre(**BRISTLES)
# A ball screw, in micrometres and millinewton-metres.
M, SPAN = 1.257e-4, 125.7
SLIDING = {"F_C": 100.0, "F_S": 130.0, "v_S": 239.0, "sigma_1": 0.1257, "sigma_2": 2.5e-3}


def dry(level):
    """Coulomb friction, as a case of a law that other tests compile too."""
    return friction.stribeck(F_C=level, F_S=level, v_S=1.0, F_v=0.0)


@pytest.fixture(scope="module")
def stick_slip():
    """Position from the equations of LuGre as they stand, by a library."""
    from scipy.integrate import solve_ivp

    F_C, F_S, v_S, sigma_0, sigma_1, sigma_2 = BRISTLES.values()

    def rates(t, y):
        x, v, z = y
        G = F_C + (F_S - F_C) * np.exp(-((v / v_S) ** 2))
        z_dot = v - sigma_0 * abs(v) / G * z
        return v, 2.0 * (0.1 * t - x) - sigma_0 * z - sigma_1 * z_dot - sigma_2 * v, z_dot

    times = 0.01 * np.arange(2000)
    result = solve_ivp(
        rates, (0.0, times[-1]), np.zeros(3), method="LSODA", rtol=1e-11, atol=1e-14, t_eval=times
    )
    return result.y


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
def test_stick_slip_against_a_library(stick_slip, tolerance):
    trace = run_adaptive(STICK_SLIP, LUGRE, np.zeros(2000), 0.01, tolerance=tolerance)
    assert trace.status == Status.OK
    assert np.max(np.abs(trace.position - stick_slip[0])) <= tolerance
    work = np.sum(trace.friction * np.diff(np.append(trace.position, trace.position[-1])))
    assert work > 0.0


def test_break_away_from_rest_is_found_in_one_long_step():
    # The spring pulls more and more; at 10 s its force is F_S, and both halves of a long step would have rested.
    model = friction.stribeck(F_C=1.0, F_S=2.0, v_S=1e-3, F_v=1.0)
    trace = run_adaptive(STICK_SLIP, model, np.zeros(1101), 0.01, tolerance=1e-6)
    rests = trace.time < 10.0
    assert np.count_nonzero(rests) > 900
    assert np.all(trace.velocity[rests] == 0.0)
    assert trace.velocity[np.searchsorted(trace.time, 10.02)] > 0.0
    assert run_adaptive(STICK_SLIP, model, np.zeros(999), 0.01, tolerance=1e-6).steps < 20


def test_at_rest_friction_is_the_pull_of_the_spring():
    trace = run_adaptive(STICK_SLIP, dry(2.0), np.zeros(900), 0.01, tolerance=1e-6)
    middle = trace.time + 0.005
    np.testing.assert_allclose(trace.friction, 2.0 * 0.1 * middle, rtol=1e-9)


def test_a_step_of_effort_is_met_at_its_instant():
    u = np.zeros(100)
    u[40:] = 3.0
    trace = run_adaptive(inertia(M=2.0), dry(1.0), u, 0.01, tolerance=1e-9, hold="zero")
    moved = np.maximum(trace.time - 0.4, 0.0)
    np.testing.assert_allclose(trace.position, 0.5 * moved**2, atol=1e-12)
    assert trace.steps < 60


@pytest.mark.slow
def test_rejected_steps_do_not_change_the_memory(in_plain_python):
    effort = 160.0 * np.sin(20.0 * np.pi * np.arange(0.0, 0.04, 2e-3))
    model = friction.preisach_lugre(kernel="dahl_masing", s=SPAN, f_p=156.0, **SLIDING)
    rough = run_adaptive(inertia(M=M), model, effort, 2e-3, tolerance=1e-3, hold="zero")
    # Rejects no step
    fixed = run_open_loop(inertia(M=M), model, effort, 2e-3, steps=200, hold="zero")
    assert rough.rejected > 5
    assert np.max(np.abs(rough.position - fixed.position)) < 3e-4


@pytest.mark.slow
def test_a_finer_tolerance_reveals_growth_of_errors():
    # The equations of the source paper on a spring: steady sliding is unstable, and so errors grow.
    model = friction.preisach_lugre(
        kernel="dahl_masing", s=SPAN, f_p=156.0, transition="paper", **SLIDING
    )
    plant, effort = pulled_inertia(M=M, k=20.0, v_e=200.0), np.zeros(1250)
    fine = run_open_loop(plant, model, effort, 2e-4, steps=200).position
    once = run_adaptive(plant, model, effort, 2e-4, tolerance=0.01)
    finer, finest = (
        run_adaptive(plant, model, effort, 2e-4, tolerance=0.01 * share) for share in (1e-2, 1e-3)
    )
    assert np.max(np.abs(once.position - fine)) > 0.01
    assert np.max(np.abs(finest.position - finer.position)) <= 0.01
    assert np.max(np.abs(finest.position - fine)) <= 0.01
    assert finest.status == Status.OK


@pytest.mark.parametrize("name", with_fast("stribeck", "lugre"))
def test_plain_python_is_identical(name):
    t = 1e-3 * np.arange(20)
    effort = 40.0 * np.sin(240.0 * t)  # to and fro
    run = partial(
        run_adaptive,
        inertia(M=2.0),
        example_of(friction.MODELS[name]),
        effort,
        1e-3,
        tolerance=1e-4,
        v=1e-3,
    )
    compiled = run()
    with interpreted():
        plain = run()
    assert compiled.steps == plain.steps
    for field in ("position", "velocity", "friction"):
        assert np.array_equal(getattr(compiled, field), getattr(plain, field)), field


def test_a_tolerance_of_zero_is_refused():
    with pytest.raises(InputError, match="tolerance"):
        run_adaptive(STICK_SLIP, LUGRE, np.zeros(3), 0.01, tolerance=0.0)


def test_a_diverged_run_has_a_status():
    trace = run_adaptive(inertia(M=1e-9), LUGRE, np.full(50, 1e300), 10.0, tolerance=1e-3)
    assert trace.status == Status.NOT_FINITE
    assert trace.position.size < 50


@pytest.mark.parametrize(
    ("effort", "hold", "knots", "starts", "ends"),
    [
        # Bends
        ([0.0, 1.0, 2.0, 3.0, 3.0, 3.0], "linear", [0.0, 1.5, 3.0], [0.0, 3.0], [3.0, 3.0]),
        ([2.0, 2.0, 5.0, 5.0], "zero", [0.0, 1.0, 2.0], [2.0, 5.0], [2.0, 5.0]),  # jumps
        ([0.0, 1.0, 2.0], "zero", [0.0, 0.5, 1.0, 1.5], [0.0, 1.0, 2.0], [0.0, 1.0, 2.0]),
        ([4.0], "linear", [0.0, 0.5], [4.0], [4.0]),
    ],
)
def test_collinear_samples_of_an_effort_form_one_stretch(effort, hold, knots, starts, ends):
    course = _stretches(np.array(effort), held(np.array(effort), hold), 0.5)
    assert [part.tolist() for part in course] == [knots, starts, ends]


DRY = friction.coulomb(F_C=1.0)


def stubbed(monkeypatch, model=DRY, reached=11, report=(7.0, 2.0, 0.0, 0.0), **options):
    """Return the trace of a run whose steps a stub makes, and what that was asked for."""
    requested = []

    def steps(entries, vectors, before, full_step, course, limits, samples, counts):
        requested.append((vectors, course, limits, before.memory is not vectors.memory))
        samples.x[:], samples.v[:], samples.impulse[:] = (
            np.arange(11.0),
            -np.arange(11.0),
            3.0 * samples.times,
        )
        counts[:] = report
        return reached

    monkeypatch.setattr(adaptive, "driver", lambda function: steps)
    with interpreted():
        trace = run_adaptive(
            inertia(M=1.0), model, np.ones(10), 0.2, **{"tolerance": 1e-4} | options
        )
    return trace, requested[0]


@pytest.mark.parametrize(
    ("reached", "report", "status", "size"),
    [
        (11, (7.0, 2.0, 0.0, 0.0), Status.OK, 10),
        (11, (7.0, 2.0, 0.0, 1.0), Status.SOLVE_INACCURATE, 10),
        (11, (7.0, 2.0, 1.0, 1.0), Status.TOLERANCE_MISSED, 10),
        (4, (7.0, 2.0, 1000.0, 0.0), Status.NOT_FINITE, 4),
        (4, (7.0, 2.0, 1001.0, 0.0), Status.TOLERANCE_MISSED, 4),
    ],
)
def test_the_status_of_a_run_is_its_worst_event(monkeypatch, reached, report, status, size):
    trace, _ = stubbed(monkeypatch, reached=reached, report=report)
    assert (trace.status, trace.steps, trace.rejected) == (status, 7, 2)
    assert (trace.position.tolist(), trace.velocity.tolist()) == (
        list(range(size)),
        [-k for k in range(size)],
    )
    assert trace.friction == pytest.approx(np.full(size, 3.0))
    assert trace.time == pytest.approx(0.2 * np.arange(size))


def test_a_tolerance_below_rounding_is_missed(monkeypatch):
    # The position goes to 10 m.
    assert [
        stubbed(monkeypatch, tolerance=tolerance)[0].status for tolerance in (1.7e-13, 1.5e-13)
    ] == [Status.OK, Status.TOLERANCE_MISSED]


def test_limits_are_shares_of_the_tolerance_and_of_the_presliding_distance(monkeypatch):
    _, (vectors, course, limits, has_own_memory) = stubbed(monkeypatch, x=0.5, v=-2.0)
    assert vectors.plant_state.tolist() == [0.5, -2.0]
    assert has_own_memory
    assert 2.0 * limits.per_time == limits.between < 1e-4
    assert (limits.longest, limits.far, limits.per_step) == (2.0, 0.0, np.inf)
    assert limits.shortest < limits.first < 1e-3
    assert course.knots[-1] > 2.0
    contact = friction.lugre(F_C=1.0, F_S=1.0, v_S=1.0, sigma_0=1e5)
    _, (_, _, finer, _) = stubbed(monkeypatch, contact, tolerance=1e-5, max_step=0.1)
    assert finer.per_time == pytest.approx(0.1 * limits.per_time)
    assert (finer.longest, finer.far / finer.per_step) == (0.1, pytest.approx(250.0))
    assert 0.0 < finer.per_step < 1e-5 < finer.far

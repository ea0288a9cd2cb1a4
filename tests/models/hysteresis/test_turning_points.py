"""The stack of turning points: what it keeps, what it forgets, and that it says so."""

import numpy as np
import pytest
from tests.models.hysteresis.paths import of, walk

from bristle import friction, hysteresis, plants, response
from bristle.core.errors import InputWarning
from bristle.core.status import Status
from bristle.engine import run_open_loop
from bristle.engine.path import after
from bristle.models.hysteresis.turning_points import (
    Stack,
    branch_at,
    branch_output,
    branch_point,
    branch_slope,
)


class Watched(np.ndarray):
    """A memory that counts what is read of it."""

    reads = 0

    def __getitem__(self, place):
        Watched.reads += 1
        return super().__getitem__(place)


def stored(operator, path):
    state, memory = after(operator, path)
    return memory[: state.depth].tolist(), state


@pytest.mark.parametrize(
    ("path", "points"),
    [
        ([3.0], []),
        ([3.0, -1.0, 2.0, 0.0], [3.0, -1.0, 2.0]),
        # Reaching an extremum is enough to close its loop.
        ([3.0, -1.0, 2.0, -1.0], [3.0]),
        ([3.0, -1.0, 3.0], []),
        # The first branch merges with the virgin curve on the other side.
        ([3.0, -3.0], []),
        ([3.0, -2.999], [3.0]),
        # Rounding is no reversal.
        (1.0 + 1e-13 * np.cumsum((-1.0) ** np.arange(1000)), []),
    ],
)
def test_turning_points_are_nested_and_closed_loops_remove_theirs(path, points):
    assert stored(of("dahl_masing"), path)[0] == points


@pytest.mark.parametrize(
    ("back", "points", "z"), [(0.9e-3, [], 1.0), (1.1e-3, [1.0], 1.0 - 1.1e-3)]
)
def test_only_a_reversal_beyond_the_tolerance_is_stored(back, points, z):
    found, state = stored(of("dahl_masing", tolerance=1e-3), [1.0, 1.0 - back])
    assert (found, state.z) == (points, z)


def test_few_points_are_read_on_a_way_that_forgets_a_hundred():
    state, memory = after(of("dahl_masing"), hysteresis.conditioned(3.0, 200))
    assert branch_at(state, memory.view(Watched), 2.0).depth < state.depth - 100
    assert Watched.reads < 20


@pytest.mark.parametrize("capacity", [4, 5, 33])
def test_overflow_is_counted_and_reported(capacity):
    small = of("reformed_dahl_exact", capacity=capacity)
    sweep = hysteresis.conditioned(3.0, 60)
    with pytest.warns(InputWarning, match=rf"Raise the parameter capacity above {capacity}"):
        response(small, sweep)
    with pytest.warns(InputWarning, match="lost its innermost pair"):
        points, state = stored(small, sweep)
    assert state.lost == (60 - capacity + 1) // 2
    assert len(points) <= capacity
    assert np.all(np.diff(np.abs(points)) < 0.0)
    assert np.all(np.diff(np.sign(points)) != 0.0)


def test_overflow_keeps_the_output_continuous_and_the_outer_loops():
    path = np.repeat(np.linspace(1.0, 0.0, 80), 2) * np.tile([1.0, -1.0], 80)
    fine = np.interp(np.linspace(0.0, path.size - 1.0, 20_000), np.arange(path.size), path)
    exact = response(of("dahl_masing"), fine)
    with pytest.warns(InputWarning):
        forgetful = response(of("dahl_masing", capacity=32), fine)
    # Going in, the point that is pushed is exact: forgetting changes what comes later, on the way out.
    assert np.max(np.abs(forgetful - exact)) <= 1e-15
    back = np.concatenate([fine, fine[::-1]])
    with pytest.warns(InputWarning):
        forgetful = response(of("dahl_masing", capacity=32), back)
    assert 0.01 < np.max(np.abs(forgetful - response(of("dahl_masing"), back))) < 0.15
    assert abs(forgetful[-1] - forgetful[0]) <= 1e-15


def test_a_walk_of_any_length_keeps_few_points():
    _, state = stored(of("dahl_masing"), walk(12, 50_000))
    assert (state.depth < 40, state.lost) == (True, 0)


@pytest.mark.parametrize("kernel", ["dahl_masing", "reformed_dahl_exact"])
def test_a_branch_is_valid_from_its_beginning_to_its_end(kernel):
    operator = of(kernel)
    q = operator.component.measure(operator.parameters)
    state, memory = after(operator, walk(13, 400))
    assert isinstance(state, Stack)
    for u in np.random.default_rng(14).uniform(-4.0, 4.0, 300).tolist():
        branch = branch_at(state, memory, u)
        assert branch.side * (u - branch.begin) >= 0.0
        assert branch.side * (branch.end - u) > 0.0
        f, _ = operator.component.trial(state, memory, u, operator.parameters)
        assert branch_output(branch, u, q) == f
        assert branch_at(state, memory, u)[:4] == branch[:4]
        step = 1e-6 * branch.side
        if min(abs(u - branch.begin), abs(u - branch.end), abs(u)) > 3e-6:
            rise = (branch_output(branch, u + step, q) - branch_output(branch, u - step, q)) / (
                2.0 * step
            )
            assert abs(branch_slope(branch, u, q) - rise) < 1e-8
            assert branch_point(branch, u, q) == (
                branch_output(branch, u, q),
                branch_slope(branch, u, q),
            )


def test_the_next_branch_continues_at_the_end_of_a_branch():
    operator = of("reformed_dahl_exact")
    q = operator.component.measure(operator.parameters)
    state, memory = after(operator, [3.0, -1.0, 2.0, 0.0, 0.5])
    ends = []
    u = state.z
    while np.isfinite(u):
        branch = branch_at(state, memory, u)
        ends.append(branch.end)
        if np.isfinite(branch.end):
            following = branch_at(state, memory, branch.end)
            assert (
                abs(branch_output(branch, branch.end, q) - branch_output(following, branch.end, q))
                <= 1e-15
            )
        u = branch.end
    assert ends == [2.0, 3.0, np.inf]


def composite(capacity):
    return friction.preisach_lugre(
        kernel="dahl_masing", s=1e6, f_p=150.0, F_C=100.0, F_S=120.0, v_S=1e-3, capacity=capacity
    )


@pytest.mark.slow
def test_lost_memory_is_reported_along_a_motion_and_in_a_simulation():
    x = 1e-5 * hysteresis.conditioned(1.0, 40)
    response(composite(64), x, 1e-3)
    with pytest.warns(InputWarning, match="preisach_lugre: the memory of turning points was full"):
        response(composite(8), x, 1e-3)
    effort = 50.0 * np.repeat(hysteresis.conditioned(1.0, 40), 40)
    plant = plants.inertia(M=0.1)
    assert run_open_loop(plant, composite(64), effort, 1e-4).status == Status.OK
    assert run_open_loop(plant, composite(8), effort, 1e-4).status == Status.MEMORY_OVERFLOW

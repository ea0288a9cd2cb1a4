"""The layer that scatters, waves and creeps around any friction model, step by step."""

import math

import pytest

from bristle import friction
from bristle.core.motion import Motion
from bristle.core.random_numbers import normal
from bristle.models.friction.uneven import uneven

COULOMB = friction.find("coulomb_viscous")(F_C=20.0, F_v=0.0, offset=3.0)


def moved(model, state, v, x, dt=1e-3):
    """Return the force of a step and the state after it."""
    component, p = model.component, model.parameters
    force, move = component.trial(state, (), Motion(v, x), dt, p)
    return force, component.commit(state, (), move, p)


def virgin(model):
    return model.component.initial_state(model.parameters)


def test_a_step_has_the_mean_of_the_creeping_force_at_its_ends():
    model = uneven(COULOMB, k_creep=50.0, tau=1e9)
    first, state = moved(model, virgin(model), 1.0, 0.1, 0.1)
    assert first == pytest.approx(23.0 + 2.5)
    assert moved(model, state, 1.0, 0.2, 0.1)[0] == pytest.approx(23.0 + 7.5)


def test_each_reversal_draws_a_level_and_no_step_between():
    model = uneven(COULOMB, unevenness=0.1, travel=1e-9, seed=4)
    state, levels, counts = virgin(model), [], []
    for v in (1.0, 1.0, -1.0, -1.0, 1.0):
        _, state = moved(model, state, v, 0.0)
        levels.append(state.aim)
        counts.append(state.reversals)
    assert counts == [1, 1, 2, 2, 3]
    assert levels == [1.0 + 0.1 * normal(4, draw) for draw in (0, 0, 1, 1, 2)]
    assert [state.side, state.factor] == pytest.approx([1.0, state.aim], rel=1e-5)
    # The force of the next step has it.
    assert moved(model, state, 1.0, 0.0)[0] == pytest.approx(3.0 + 20.0 * state.factor)


@pytest.mark.parametrize(("v", "draws"), [(4.9e-8, 0), (5.1e-8, 1), (-4.9e-8, 0), (-5.1e-8, 1)])
def test_a_reversal_slower_than_noise_is_ignored(v, draws):
    model = uneven(COULOMB, unevenness=0.1)
    _, state = moved(model, virgin(model), v, 0.0)
    assert (state.reversals, state.side) == (draws, math.copysign(1.0, v) if draws else 0.0)


def test_a_level_changes_over_its_travel():
    model = uneven(COULOMB, unevenness=0.1, travel=1e-3)
    start = virgin(model)._replace(side=1.0, aim=1.4)
    # As long a way as the travel: half of the change, by one implicit step.
    _, state = moved(model, start, 1.0, 0.0)
    assert state.scale == pytest.approx(1.2)
    for _ in range(1000):
        _, start = moved(model, start, 1.0, 0.0, 1e-6)
    assert start.scale == pytest.approx(1.4 - 0.4 * math.exp(-1.0), rel=1e-3)


def test_a_drawn_level_keeps_at_least_a_twentieth():
    model = uneven(COULOMB, unevenness=0.3)
    deep = next(seed for seed in range(10_000) if normal(seed, 0) < -3.4)
    _, state = moved(model.with_values(seed=deep), virgin(model), 1.0, 0.0)
    assert state.aim == 0.05

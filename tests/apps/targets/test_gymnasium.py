"""The example with Gymnasium: its checker, the motion of bristle, draws, and a tracking reward."""

import numpy as np
import pytest
from tests.examples.data import loaded

import bristle as br

pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env

MASS, DT = 28.0, 1e-3
TABLE = br.plants.inertia(M=MASS)
ELEMENTS = br.friction.maxwell_slip(F_C="20 N", k_i=["6 N/um", "3 N/um"], nu_i=[0.4, 0.6])
DRAWS = {
    "F_C": [15.0, 25.0, 20.0],
    "nu_i": [[0.4, 0.6], [0.5, 0.5], [0.3, 0.7]],
    "M": [27.0, 29.0, 28.0],
    "offset": [0.0, 1.0, 2.0],
}


@pytest.fixture
def env():
    return loaded("gymnasium_environment.py").AxisEnv(ELEMENTS, TABLE, DRAWS)


def episode(env, law, seed, samples=500):
    """Return positions over the amplitude, actions and the sum of rewards of an episode."""
    observation, info = env.reset(seed=seed)
    positions, actions, total = [], [], 0.0
    for _ in range(samples):
        positions.append(observation[1] - observation[0])
        actions.append(np.float32(law(observation)))
        observation, reward, terminated, truncated, _ = env.step(np.array([actions[-1]]))
        assert not terminated | truncated
        total += reward
    return np.array(positions), np.array(actions, dtype=float), total, info["parameters"]


def test_the_checker_of_gymnasium_accepts_it(env):
    check_env(env, skip_render_check=True)


def test_an_episode_is_the_motion_of_bristle_with_the_drawn_parameters(env):
    positions, actions, _, drawn = episode(env, lambda o: np.sin(3.0 * o[1]), seed=5)
    friction, plant = (
        ELEMENTS.with_values(F_C=drawn["F_C"], nu_i=drawn["nu_i"]),
        br.plants.inertia(M=drawn["M"]),
    )
    expected = br.engine.run_open_loop(plant, friction, 100.0 * actions, DT).position
    assert np.allclose(1e-2 * positions, expected[: positions.size], rtol=0.0, atol=1e-15)


def test_resets_draw_all_rows_and_a_seed_repeats_them(env):
    drawn = [env.reset(seed=seed)[1]["parameters"]["F_C"] for seed in range(20)]
    assert set(drawn) == {15.0, 25.0, 20.0}
    assert drawn == [env.reset(seed=seed)[1]["parameters"]["F_C"] for seed in range(20)]


def test_a_feedback_earns_more_than_no_effort(env):
    feedback = [
        episode(env, lambda o: np.clip(4.0 * o[0] + 1.0 * (o[3] - o[2]), -1.0, 1.0), seed)[2]
        for seed in range(3)
    ]
    idle = [episode(env, lambda o: 0.0, seed)[2] for seed in range(3)]
    assert max(idle) < 0.5 * max(feedback) < 0.0

"""A recorded motion on the page: its turns are kept, and the force of the model along it has the bits of Python."""

import json

import numpy as np
import pytest
from tests.lab.scripts import data_of, needs_node, node

from bristle.core.contracts import Motion
from bristle.lab import lab_page
from bristle.lab.described import described, example_named
from bristle.lab.packing import plain
from bristle.lab.rows import MOST, decimated, replay_of_traces, turns_of

COUNT = 40_000


def shaken(count=COUNT, noise=0.0):
    """Return time, position and effort of a motion of two sines, with a rest in it."""
    t = 1e-3 * np.arange(count)
    x = 0.1 * np.sin(0.7 * t) + 2e-3 * np.sin(9.0 * t) * (t > 5.0)
    x[count // 2 : count // 2 + 2000] = x[count // 2]
    x += noise * np.random.default_rng(3).normal(size=count)
    return t, x, 20.0 * np.sign(np.gradient(x)) + 3.0 * np.gradient(x, t)


def extremes(x):
    """Return where a smooth motion is highest or lowest, by the samples beside it."""
    inner = np.flatnonzero(((x[1:-1] > x[:-2]) & (x[1:-1] > x[2:])) | ((x[1:-1] < x[:-2]) & (x[1:-1] < x[2:])))
    return inner + 1


def test_no_turn_of_a_smooth_motion_is_lost():
    t, x, f = shaken()
    replay = decimated([[t, x, f]], has_inertia=True)
    assert replay.time.size <= MOST
    assert replay.depth == 0.0
    assert len(extremes(x)) > 15
    assert set(t[extremes(x)]) <= set(replay.time)
    chosen = np.searchsorted(t, replay.time)
    travel = np.ptp(x)
    assert replay.position == pytest.approx(x[chosen] - x.min(), abs=1e-8 * travel)


def test_of_a_noisy_one_the_deep_turns_are_kept_and_the_depth_is_told():
    t, x, f = shaken(noise=1e-4)
    replay = decimated([[t, x, f]], has_inertia=True)
    assert replay.time.size <= MOST
    assert 0.0 < replay.depth < 2e-3
    deep = turns_of(x, 2e-3)
    assert len(deep) > 8
    kept = set(replay.time)
    assert all(t[i] in kept for i in deep)


def test_turns_are_where_the_motion_goes_back_by_more_than_the_depth():
    x = np.array([0.0, 1.0, 3.0, 2.9, 4.0, 4.0, 1.0, 1.5, 0.0])
    assert turns_of(x, 0.0).tolist() == [0, 2, 3, 5, 6, 7, 8]
    assert turns_of(x, 0.3).tolist() == [0, 5, 6, 7, 8]
    assert turns_of(x, 1.0).tolist() == [0, 5, 8]
    assert turns_of(np.zeros(5), 0.0).tolist() == [0, 4]


def test_stretches_begin_anew():
    t, x, f = shaken(400)
    replay = decimated([[t, x, f], [t + 9.0, -x, f]], has_inertia=False)
    assert replay.begins == (0, 400)
    assert replay.time[400] == 9.0


def test_rows_that_a_model_was_fitted_to_make_a_motion_without_the_rests_between():
    t = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(5.0, 6.0, 0.01)])
    replay = replay_of_traces(t, np.full(t.size, 0.5), np.ones(t.size))
    assert np.ptp(replay.position) == pytest.approx(0.5 * 2.0 - 0.005, abs=6e-3)
    assert replay.friction.tolist() == [1.0] * t.size


@needs_node
@pytest.mark.parametrize("name", ["lugre", "gms"])
def test_the_page_leads_the_model_along_the_log_as_python_does(name, tmp_path):
    t, x, f = shaken(3000)
    replay = decimated([[t[:2000], x[:2000], f[:2000]], [t[2000:], x[2000:], f[2000:]]], has_inertia=True, most=900)
    model = example_named(name)
    page = lab_page(model, source="m.toml", replay=replay)
    data = data_of(page)
    script = f"""
    const recorded = recordedMotion({json.dumps(data["replay"])}), contact = await loaded(models[0]);
    say([[...recorded.t], [...recorded.x], [...recorded.measured], [...contact.along(recorded)]]);
    """
    times, places, measured, forces = node(tmp_path, [plain(described(model, named="m"))], script)
    assert times == replay.time.tolist()
    assert places == replay.position.tolist()
    assert measured == [float(value) for value in replay.friction]
    component, p = model.component, model.parameters
    wanted = []
    for k, (time, place) in enumerate(zip(times, places, strict=True)):
        if k in replay.begins:
            state, memory, force = component.initial_state(p), component.new_memory(p), 0.0
        else:
            dt = time - times[k - 1]
            force, move = component.trial(state, memory, Motion((place - places[k - 1]) / dt, place), dt, p)
            state = component.commit(state, memory, move, p)
        wanted.append(force)
    assert forces == wanted


def test_the_largest_replay_adds_less_than_a_quarter_of_a_megabyte():
    t, x, f = shaken(noise=1e-4)
    replay = decimated([[t, x, f + np.random.default_rng(1).normal(size=f.size)]], has_inertia=True)
    model = example_named("lugre")
    plain, full = lab_page(model, source="m.toml"), lab_page(model, source="m.toml", replay=replay)
    assert len(full) - len(plain) < 250_000

"""Derivatives of a simulated axis: those of its own runs beside each other, where it slides, sticks and stops."""

import numpy as np
import pytest
from tests.engine.test_derivatives import model_of
from tests.engine.translation.complex_step import directions_of

from bristle import controllers, plants, sensors
from bristle.core.contracts import Model, Reference
from bristle.core.packing import pack, structure_of, unpacker
from bristle.core.tangent import DIRECTIONS
from bristle.engine import conditioned, interpreted, run_closed_loop, run_open_loop
from bristle.engine.loop import begun, held
from bristle.engine.loop_derivatives import (
    Sensitive,
    closed_loop_with_derivatives,
    open_loop_with_derivatives,
)
from bristle.models.friction import MODELS, coulomb, lugre, viscous

DT, STEPS = 1e-4, (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
FAST = ("stribeck", "lugre", "preisach_lugre", "coulomb_viscous+transmitted")
# Further on, differences of two runs of these scatter by more than the slope is accurate.
SAMPLES = {"dahl": 300, "preisach_lugre": 80, "efficiency": 100}
PLANT = plants.inertia(M=2.0)


def plant_of(model):
    return PLANT if model.kind == "translational" else plants.inertia(J=2.0)


def efforts(model, count):
    """An effort that lets the axis slide, turn and stick."""
    t, size = (
        DT * np.arange(count),
        1.6 * max(abs(float(np.max(np.atleast_1d(model.values.get("F_C", 8.0))))), 4.0),
    )
    return size * np.sin(2.0 * np.pi * 31.0 * t) * np.where(t > 0.7 * DT * count, 0.3, 1.0)


def moved(model, tangent, step):
    """The model with its packed parameters further along a direction."""
    numbers = pack(model.parameters) + step * np.where(
        np.isfinite(pack(model.parameters)), tangent, 0.0
    )
    return Model(model.component, unpacker(structure_of(model.parameters))(numbers), model.kind)


def mixed(model):
    """One direction that all parameters take part in, each by so much of itself."""
    return directions_of(model) @ np.linspace(0.5, 1.0, directions_of(model).shape[1])


def open_loops(model, count):
    plant, effort, tangent = plant_of(model), efforts(model, count), mixed(model)
    sensitive = (
        Sensitive(plant, np.array([[0.3], *[[0.0]] * (pack(plant.parameters).size - 1)])),
        Sensitive(model, tangent[:, None]),
    )
    position, slope = open_loop_with_derivatives(*sensitive, effort, held(effort, "linear"), DT, 1)
    assert (
        position.tobytes()
        == run_open_loop(plant, model, effort, DT, hold="linear").position.tobytes()
    )

    def beside(step):
        heavier = moved(plant, np.eye(pack(plant.parameters).size)[0], 0.3 * step)
        return run_open_loop(
            heavier, moved(model, tangent, step), effort, DT, hold="linear"
        ).position

    # The largest step may turn a small distance negative: such a run ends early.
    runs = [(step, beside(step), beside(-step)) for step in STEPS]
    return slope[:, 0], [
        (further - back) / (2.0 * step)
        for step, further, back in runs
        if further.size == back.size == count
    ]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name",
    [
        *FAST,
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in (*MODELS, "stribeck+transmitted")
            if name not in FAST
        ),
    ],
)
def test_open_loop_derivatives_agree_with_differences_of_runs(name):
    with interpreted():
        base, *slots = name.split("+")
        slope, differences = open_loops(model_of(base, tuple(slots)), SAMPLES.get(name, 280))
    assert np.isfinite(slope).all()
    assert min(
        np.linalg.norm(slope - difference) for difference in differences
    ) < 1e-4 * np.linalg.norm(slope)


def test_the_stopping_distance_under_coulomb_friction_changes_as_in_its_formula():
    u, F, M, dt, count = 20.0, 8.0, 2.0, 1e-3, 40
    effort = np.where(np.arange(120) < count, u, 0.0)
    sensitive = (
        Sensitive(plants.inertia(M=M), np.array([[1.0, 0.0]])),
        Sensitive(coulomb(F_C=F), np.array([[0.0, 1.0]])),
    )
    with interpreted():
        position, slopes = open_loop_with_derivatives(*sensitive, effort, effort, dt, 1)
    time = count * dt

    def stop(M, F):
        return (u - F) * time**2 / (2.0 * M) + ((u - F) * time) ** 2 / (2.0 * M * F)

    assert position[-1] == pytest.approx(stop(M, F), rel=1e-9)
    by_mass, by_friction = (
        (stop(M + h, F + k) - stop(M - h, F - k)) / 2e-6 for h, k in ((1e-6, 0.0), (0.0, 1e-6))
    )
    assert slopes[-1] == pytest.approx([by_mass, by_friction], rel=1e-7)
    assert np.array_equal(slopes[-1], slopes[-10])  # it rests


def test_a_diverged_motion_has_no_derivatives():
    effort = np.full(50, 1e99)
    with interpreted():
        position, slope = open_loop_with_derivatives(
            Sensitive(PLANT, np.zeros((1, 1))),
            Sensitive(viscous(F_v=4.0), np.ones((1, 1))),
            effort,
            effort,
            10.0,
            1,
        )
    assert np.isnan(position[-1])
    assert np.isnan(slope[-1]).all()


def test_many_directions_are_columns_of_their_own():
    model, effort = viscous(F_v=4.0), efforts(viscous(F_v=4.0), 60)
    many = np.linspace(1.0, 2.0, DIRECTIONS + 3)[None, :]
    with interpreted():
        position, slopes = open_loop_with_derivatives(
            Sensitive(PLANT, 0.0 * many), Sensitive(model, many), effort, effort, DT, 4
        )
        assert position.tobytes() == run_open_loop(PLANT, model, effort, DT).position[::4].tobytes()
    assert slopes.shape == (15, DIRECTIONS + 3)
    assert slopes[-1] == pytest.approx(slopes[-1, 0] * many[0])


CONTROLLER = controllers.cascade(k_p=80.0, k_v=300.0, k_i=4000.0)


def closed_loops(model, x=0.02, v=0.05, count=90):
    """The effort of a loop that begins in motion, behind a drive that lags, and its differences."""
    dt, lag, t = 1e-3, 2e-3, 1e-3 * np.arange(count)
    reference = np.stack(
        [
            x + v * t + 2e-3 * np.sin(60.0 * t),
            v + 0.12 * np.cos(60.0 * t),
            -7.2 * np.sin(60.0 * t),
            0.0 * t,
        ]
    )
    injected, disturbance, tangent = 0.5 * np.sin(90.0 * t), 0.3 * np.cos(70.0 * t), mixed(model)
    loop = {"dt": dt, "steps": 4, "limit": 60.0, "effort_before": 1.5}

    def start(friction, step):
        state, memory = conditioned(friction, 1e-3)
        return state, memory * (1.0 + 0.2 * step)

    def run(step):
        friction, plant = moved(model, tangent, step), moved(PLANT, np.ones(1), 0.3 * step)
        state, memory = start(friction, step)
        return run_closed_loop(
            plant, friction, CONTROLLER, sensors.encoder(resolution=0.0), reference, lag=lag + 1e-3 * step, injected=injected,
            disturbance=disturbance, x=x, v=v, state=state, memory=memory, **loop,
        ).command  # fmt: skip

    state, memory = start(model, 0.0)
    (state_up, memory_up), (state_down, memory_down) = (
        start(moved(model, tangent, step), step) for step in (1e-6, -1e-6)
    )
    slopes = (
        (pack(state_up) - pack(state_down))[:, None] / 2e-6,
        (memory_up - memory_down)[:, None] / 2e-6,
    )
    friction = Sensitive(model, tangent[:, None], state, memory, *slopes)
    law_state = begun(CONTROLLER, Reference(*reference[:, 0]), x, v, 0.0, None, dt)
    command, slope = closed_loop_with_derivatives(
        Sensitive(PLANT, np.array([[0.3]])), friction, CONTROLLER, law_state, reference, injected, disturbance,
        lag=lag, lag_tangents=np.array([1e-3]), x=x, v=v, **loop,
    )  # fmt: skip
    assert command.tobytes() == run(0.0).tobytes()
    return slope[:, 0], [(run(step) - run(-step)) / (2.0 * step) for step in STEPS]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name", ["stribeck", "lugre", pytest.param("preisach_lugre", marks=pytest.mark.slow)]
)
def test_closed_loop_derivatives_agree_with_differences_of_runs(name):
    with interpreted():
        slope, differences = closed_loops(model_of(name))
    assert min(
        np.linalg.norm(slope - difference) for difference in differences
    ) < 1e-4 * np.linalg.norm(slope)


def test_each_block_of_directions_begins_with_the_given_memory():
    model = model_of("preisach_lugre")
    state, memory = conditioned(model, 1e-3)
    before, tangent = memory.copy(), np.repeat(mixed(model)[:, None], DIRECTIONS + 1, axis=1)
    friction = Sensitive(model, tangent, state, memory)
    effort = efforts(model, 60)
    with interpreted():
        _, slopes = open_loop_with_derivatives(
            Sensitive(PLANT, np.zeros((1, DIRECTIONS + 1))), friction, effort, effort, DT, 1
        )
    assert np.array_equal(memory, before)
    assert np.array_equal(slopes[:, 0], slopes[:, -1])


@pytest.mark.slow
def test_compiled_loop_derivatives_agree_with_plain_python():
    model = lugre(F_C=8.0, F_S=10.0, v_S=0.02, sigma_0=1e5, sigma_1=100.0, sigma_2=20.0)
    for loops in (lambda: open_loops(model, 200), lambda: closed_loops(model, count=45)):
        compiled = loops()[0]
        with interpreted():
            plain = loops()[0]
        assert compiled == pytest.approx(plain, rel=1e-9, abs=1e-9 * np.abs(plain).max())

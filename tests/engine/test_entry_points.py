"""Entries in plain Python: what they take from vectors, and what they leave there."""

import math

import numpy as np
import pytest

from bristle import controllers, friction, hysteresis, sensors
from bristle.engine import entry_points
from bristle.engine.entry_points import (
    make_compensate,
    make_compensate_along,
    make_control,
    make_force_along,
    make_output_along,
    make_sense,
    make_substeps,
)
from bristle.engine.instance import Instance
from bristle.models.controllers.feedforward import Shape
from bristle.models.plants import inertia

COULOMB = friction.coulomb(F_C=20.0)
# Gain, offset, asymmetry, limit and rate limit: each makes another effort of 20 N.
SHAPES = {
    "gain": ((0.5, 0.0, 0.0, math.inf, math.inf), (10.0, -10.0)),
    "offset": ((1.0, 3.0, 0.0, math.inf, math.inf), (23.0, -17.0)),
    "asymmetry": ((1.0, 0.0, 0.1, math.inf, math.inf), (22.0, -18.0)),
    "limit": ((1.0, 0.0, 0.0, 15.0, math.inf), (15.0, -15.0)),
    "rate limit": ((1.0, 0.0, 0.0, math.inf, 300.0), (3.0, 0.0)),
    "all": ((2.0, 3.0, 0.1, 30.0, 1000.0), (10.0, 0.0)),
}


def test_results_have_distinct_indices():
    names = [
        "FORCE",
        "FAILED",
        "SLOPE",
        "FAILED_SO_FAR",
        "ACCELERATION",
        "SLACK",
        "DRIVE_EFFORT",
        "DRIVE_LAG",
    ]
    assert sorted(getattr(entry_points, name) for name in names) == list(
        range(entry_points.OUT_SIZE)
    )


@pytest.mark.parametrize("name", SHAPES)
def test_a_compensator_along_either_motion_shapes_its_force(name):
    shape, expected = SHAPES[name]
    part, effort, nothing = Instance(COULOMB), np.empty(2), np.zeros(2)
    along = make_compensate_along(*part.structures)
    along(
        part.parameters,
        part.state,
        np.zeros(0),
        np.array(Shape(*shape)),
        np.array([1.0, -1.0]),
        nothing,
        nothing,
        0.01,
        effort,
    )
    assert effort.tolist() == pytest.approx(list(expected))
    part, memory = Instance(COULOMB), np.array([*Shape(*shape), 5.0, 0.0, 0.0])
    measured = make_compensate(*part.structures)
    result = [
        measured(part.parameters, part.state, np.zeros(0), memory, place, 0.0, 0.01)
        for place in (5.001, 5.0)
    ]
    assert result == pytest.approx(list(expected))
    assert memory[-3:].tolist() == [5.0, shape[0], result[-1]]


def test_a_compensator_computes_the_velocity_from_the_last_measured_position():
    part = Instance(friction.viscous(F_v=3.0))
    memory = np.array([*Shape(), 5.0, 0.0, 0.0])
    assert make_compensate(*part.structures)(
        part.parameters, part.state, np.zeros(0), memory, 5.2, 0.0, 0.1
    ) == pytest.approx(6.0)


def test_the_share_returns_in_motion_and_fades_at_rest():
    """Of 20 N + 3 N s/m: the viscous part and the constant force stay whole, the rest gets a share."""
    model = friction.find("coulomb_viscous")(F_C=20.0, F_v=3.0, offset=2.0)
    shape = Shape(gain=0.8, return_distance=1.0, fade_time=0.5, constant=2.0, viscous=3.0)
    v = np.array([10.0, 10.0, 0.0, 0.0, -10.0])
    shares = [0.4, 0.6]  # half of the difference over each metre
    shares += [0.6 * 5.0 / 6.0, 0.6 * (5.0 / 6.0) ** 2]  # a tenth of a second over half a second
    shares += [shares[-1] + 0.5 * (0.8 - shares[-1])]
    expected = [
        2.0 + 3.0 * speed + share * 20.0 * np.sign(speed)
        for speed, share in zip(v, shares, strict=True)
    ]
    part, effort, nothing = Instance(model), np.empty(5), np.zeros(5)
    along = make_compensate_along(*part.structures)
    along(
        part.parameters, part.state, np.zeros(0), np.array(shape), v, nothing, nothing, 0.1, effort
    )
    assert effort.tolist() == pytest.approx(expected)
    part, memory = Instance(model), np.array([*shape, 0.0, 0.0, 0.0])
    measured = make_compensate(*part.structures)
    result = [
        measured(part.parameters, part.state, np.zeros(0), memory, place, 0.0, 0.1)
        for place in np.cumsum(0.1 * v)
    ]
    assert result == pytest.approx(expected)


def test_a_compensator_updates_its_state():
    model = friction.lugre(F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=1e6)
    shape, effort, nothing = np.array(Shape()), np.empty(2), np.zeros(2)
    along, measured = Instance(model), Instance(model)
    entry = make_compensate_along(*along.structures)
    assert (
        entry(
            along.parameters,
            along.state,
            np.zeros(0),
            shape,
            np.full(2, 1e-6),
            nothing,
            nothing,
            0.01,
            effort,
        )
        == 0.0
    )
    assert along.state_now.z == pytest.approx(2e-8, rel=1e-3)
    make_compensate(*measured.structures)(
        measured.parameters,
        measured.state,
        np.zeros(0),
        np.array([*shape, 0.0, 0.0, 0.0]),
        1e-8,
        0.0,
        0.01,
    )
    assert measured.state_now.z == pytest.approx(1e-8, rel=1e-3)


def test_without_a_compensator_the_feedforward_is_zero():
    assert entry_points.compensate_nothing(None, None, None, None, 1.0, 2.0, 0.1) == 0.0


def test_a_compensator_receives_the_transmitted_effort():
    model = friction.find("coulomb+transmitted")(F_C=20.0, c_T=0.1)
    part, effort = Instance(model), np.empty(2)
    plain, still = np.array(Shape()), np.zeros(2)
    along = make_compensate_along(*part.structures)
    along(
        part.parameters,
        part.state,
        np.zeros(0),
        plain,
        np.ones(2),
        still,
        np.array([0.0, -50.0]),
        0.1,
        effort,
    )
    assert effort.tolist() == pytest.approx([20.0, 25.0])
    measured = make_compensate(*part.structures)(
        part.parameters, part.state, np.zeros(0), np.array([*plain, 0.0, 0.0, 0.0]), 1.0, 50.0, 0.1
    )
    assert measured == pytest.approx(25.0)


def test_a_friction_model_along_a_motion_updates_its_state():
    model = friction.lugre(F_C=20.0, F_S=20.0, v_S=1.0, sigma_0=1e6)
    part, force = Instance(model), np.empty(2)
    around = (
        np.zeros(0).repeat(2)
        if not part.motion._field_defaults
        else np.repeat(list(part.motion._field_defaults.values()), 2)
    )
    done = make_force_along(*part.structures, part.motion)(
        part.parameters,
        part.state,
        np.zeros(0),
        np.full(2, 1e-6),
        np.array([1e-8, 2e-8]),
        around,
        1e-2,
        force,
    )
    assert done == 0.0
    assert force == pytest.approx([5e-3, 15e-3], rel=1e-3)  # the mean of a spring over each step
    assert part.state_now.z == pytest.approx(2e-8, rel=1e-3)


def test_an_operator_along_an_input_updates_its_state():
    part, output = Instance(hysteresis.stop(r=1.0)), np.empty(3)
    assert (
        make_output_along(*part.structures)(
            part.parameters, part.state, np.zeros(0), np.array([0.5, 3.0, 2.5]), output
        )
        == 0.0
    )
    assert output.tolist() == [0.5, 1.0, 0.5]
    make_output_along(*part.structures)(
        part.parameters, part.state, np.zeros(0), np.array([2.5, 2.0, -1.0]), output
    )
    assert output.tolist() == [0.5, 0.0, -1.0]


def test_a_sensor_continues_its_noise_from_sample_to_sample():
    part = Instance(sensors.encoder(noise=0.1, seed=3))
    entry = make_sense(*part.structures)
    readings = [entry(part.parameters, part.state, 7.0, 1e-3) for _ in range(200)]
    assert len(set(readings)) == 200
    assert np.mean(readings) == pytest.approx(7.0, abs=0.03)
    assert np.std(readings) == pytest.approx(0.1, rel=0.2)


def test_a_controller_returns_its_command_and_updates_its_integral():
    part = Instance(controllers.cascade(k_p=2.0, k_v=3.0, k_i=4.0))
    entry = make_control(*part.structures)
    state = part.state.copy()
    first = entry(part.parameters, part.state, 1.0, 0.0, 0.0, 7.0, 0.0, 0.5, math.inf, 0.1)
    assert not np.array_equal(state, part.state)
    second = entry(part.parameters, part.state, 1.0, 0.0, 0.0, 7.0, 0.0, 0.5, math.inf, 0.1)
    assert second > first > 7.5
    assert entry(part.parameters, part.state, 1.0, 0.0, 0.0, 7.0, 0.0, 0.5, 2.0, 0.1) <= 2.0


def test_substeps_write_their_results_to_their_indices():
    plant, model, out = (
        Instance(inertia(M=2.0)),
        Instance(friction.coulomb_viscous(F_C=2.0, F_v=3.0)),
        np.zeros(entry_points.OUT_SIZE),
    )
    plant.state[1] = 1.0
    vectors = entry_points.MechanismVectors(
        plant.parameters, plant.state, model.parameters, model.state, np.zeros(0), out
    )
    out[entry_points.DRIVE_LAG], out[entry_points.DRIVE_EFFORT] = 0.1, 5.0
    entry = make_substeps(*plant.structures, *model.structures)
    assert entry(vectors, 5.0, 5.0, 0.1, 20) == 0.0
    # 2 v' = 5 - 2 - 3 v stays at rest with itself.
    assert plant.state.tolist() == pytest.approx([0.1, 1.0])
    results = [
        out[getattr(entry_points, name)]
        for name in ("FORCE", "ACCELERATION", "FAILED", "FAILED_SO_FAR", "DRIVE_EFFORT")
    ]
    assert results == pytest.approx([5.0, 0.0, 0.0, 0.0, 5.0], abs=1e-9)
    entry(vectors, 6.0, 6.0, 0.1, 20)
    assert out[entry_points.DRIVE_EFFORT] == pytest.approx(6.0 - math.exp(-1.0))

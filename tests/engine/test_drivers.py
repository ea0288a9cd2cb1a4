"""Drivers in plain Python: in which order a run senses, commands, moves and records, sample by sample."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from bristle.engine import drivers
from bristle.engine.drivers import (
    Compensation,
    Controller,
    Driven,
    Efforts,
    Mechanisms,
    Records,
    Sampling,
    Sensor,
    Signals,
)
from bristle.engine.entry_points import FAILED, FAILED_SO_FAR, FORCE, OUT_SIZE, MechanismVectors


def substeps(vectors, effort, effort_end, dt, steps):
    """Move by the effort; leave both efforts as friction, and one failure."""
    vectors.plant_state[0] += dt * effort
    vectors.plant_state[1] = effort
    vectors.out[FORCE], vectors.out[FAILED] = effort + 100.0 * effort_end + 1e4 * steps, 1.0


def vectors_of(count=1):
    return MechanismVectors(
        *(np.zeros(size) for size in (count, 2 * count, count, count, 0, count * OUT_SIZE))
    )


def rows(history, count):
    return history.reshape(drivers.ROWS, count)


def test_an_open_loop_records_the_state_before_and_the_friction_of_each_step():
    vectors, history = vectors_of(), np.zeros(drivers.ROWS * 3)
    done = drivers.open_loop(
        Driven(substeps, vectors, vectors.plant_state),
        np.array([1.0, 2.0, 3.0]),
        np.array([4.0, 5.0, 6.0]),
        0.5,
        7,
        history,
    )
    result = rows(history, 3)
    assert done == 3
    assert (
        result[drivers.POSITION].tolist()
        == result[drivers.MOTOR_POSITION].tolist()
        == [0.0, 0.5, 1.5]
    )
    assert (
        result[drivers.VELOCITY].tolist()
        == result[drivers.MOTOR_VELOCITY].tolist()
        == [0.0, 1.0, 2.0]
    )
    assert result[drivers.EFFORT].tolist() == [1.0, 2.0, 3.0]
    assert result[drivers.FRICTION].tolist() == [70401.0, 70502.0, 70603.0]
    assert vectors.out[FAILED_SO_FAR] == 3.0


def test_load_and_motor_have_separate_rows():
    history = np.zeros(drivers.ROWS * 2)
    drivers.record(history, 2, 1, [1.0, 2.0], [3.0, 4.0])
    result = rows(history, 2)
    assert result[:, 0].tolist() == [0.0] * drivers.ROWS
    places = (drivers.POSITION, drivers.VELOCITY, drivers.MOTOR_POSITION, drivers.MOTOR_VELOCITY)
    assert [result[place, 1] for place in places] == [1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("lost", "dt", "reached"),
    [
        (1e101, 1.0, 2),
        (1e101, 0.0, 2),
        (-1e101, 0.0, 2),
        (math.nan, 1.0, 2),
        (1e90, 1e11, 2),
        (1e99, 1.0, 4),
    ],
)
def test_a_diverged_run_ends_after_its_last_finite_sample(lost, dt, reached):
    effort = np.array([1.0, lost, 0.0, 0.0])
    vectors = vectors_of()
    assert (
        drivers.open_loop(
            Driven(substeps, vectors, vectors.plant_state),
            effort,
            effort,
            dt,
            1,
            np.zeros(drivers.ROWS * 4),
        )
        == reached
    )
    vectors = vectors_of(2)
    records = Records(np.full(8, 9.0), np.full(8, 9.0), np.full(8, 9.0), 2)
    assert (
        drivers.open_loops(
            Mechanisms(substeps, vectors), 0, 1, Efforts(effort, effort, 1), dt, 1, records
        )
        == 0
    )
    assert np.flatnonzero(records.v == 9.0).tolist() == list(range(reached, 8))


def looped(delay, before=-1.0):
    """Return the rows of a loop of four samples in which everything that is asked is told apart by its size."""
    asked = []

    def control(
        parameters, state, position, velocity, acceleration, effort, measured, injected, limit, dt
    ):
        asked.append((position, velocity, acceleration, effort, measured, injected, limit, dt))
        return 10.0 * len(asked)

    def compensate(parameters, state, memory, shape, measured, transmitted, dt):
        return 1000.0 * transmitted + measured

    def sense(parameters, state, x, dt):
        return x + 0.25

    vectors, history = vectors_of(), np.zeros(drivers.ROWS * 4)
    empty, reference = np.zeros(0), np.arange(16.0)
    done = drivers.closed_loop(
        Controller(control, empty, empty),
        Compensation(compensate, empty, empty, empty, empty, np.array([1.0, 2.0, 3.0, 4.0])),
        Sensor(sense, empty, empty, vectors.plant_state),
        Driven(substeps, vectors, vectors.plant_state),
        Signals(reference, np.array([0.1, 0.2, 0.3, 0.4]), np.array([0.0, 1.0, 0.0, 0.0])),
        Sampling(0.5, 3, delay, 77.0, before),
        history,
    )
    return SimpleNamespace(
        done=done, rows=rows(history, 4), asked=asked, failures=vectors.out[FAILED_SO_FAR]
    )


@pytest.mark.parametrize(
    ("delay", "applied"),
    [(0, [10.0, 20.0, 30.0, 40.0]), (1, [-1.0, 10.0, 20.0, 30.0]), (3, [-1.0, -1.0, -1.0, 10.0])],
)
def test_a_command_acts_after_its_delay_and_the_effort_before_until_then(delay, applied):
    result = looped(delay)
    assert (result.done, result.failures) == (4, 4.0)
    assert result.rows[drivers.COMMAND].tolist() == [10.0, 20.0, 30.0, 40.0]
    assert result.rows[drivers.EFFORT].tolist() == applied


def test_a_controller_receives_reference_measurement_and_feedforward():
    result = looped(0)
    # The plant has moved by half of 10, and of 20 less the disturbance, and of 30.
    assert result.rows[drivers.POSITION].tolist() == [0.0, 5.0, 14.5, 29.5]
    assert result.rows[drivers.MEASURED].tolist() == [0.25, 5.25, 14.75, 29.75]
    assert result.rows[drivers.FED].tolist() == [1000.25, 2005.25, 3014.75, 4029.75]
    assert result.asked[1] == (1.0, 5.0, 9.0, 13.0 + 2005.25, 5.25, 0.2, 77.0, 0.5)
    assert result.asked[3][:4] == (3.0, 7.0, 11.0, 15.0 + 4029.75)


def test_a_disturbance_acts_against_the_effort_and_is_not_measured():
    result = looped(0)
    assert result.rows[drivers.VELOCITY].tolist() == [0.0, 10.0, 19.0, 30.0]
    assert result.rows[drivers.FRICTION].tolist() == [
        30000.0 + 101.0 * pushed for pushed in (10.0, 19.0, 30.0, 40.0)
    ]


def test_a_diverged_loop_ends_after_its_last_finite_sample():
    assert looped(1, before=1e101).done == 1


def test_a_sensor_reads_every_position():
    measured, empty = np.zeros(3), np.zeros(0)
    sensor = Sensor(lambda p, s, x, dt: 10.0 * x + dt, empty, empty, np.array([1.0, 2.0, 3.0]))
    assert drivers.readings(sensor, 0.5, measured) == 0
    assert measured.tolist() == [10.5, 20.5, 30.5]


@pytest.mark.parametrize("columns", [1, 3])
def test_each_mechanism_has_its_column_of_efforts_or_a_common_column(columns):
    vectors = vectors_of(3)
    start = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])[:, :columns].ravel()
    records = Records(*np.full((3, 6), -9.0), 3)
    drivers.open_loops(
        Mechanisms(substeps, vectors), 1, 3, Efforts(start, 2.0 * start, columns), 1.0, 0, records
    )
    v = [1.0, 4.0] * 2 if columns == 1 else [2.0, 5.0, 3.0, 6.0]
    assert records.x.tolist() == [-9.0, -9.0, 0.0, v[0], 0.0, v[2]]
    assert records.v.tolist() == records.x.tolist()
    assert records.force.tolist() == [-9.0, -9.0, *(201.0 * item for item in v)]
    assert vectors.out.reshape(3, -1)[:, FAILED_SO_FAR].tolist() == [0.0, 2.0, 2.0]


def test_the_vectors_of_a_mechanism_are_its_share_of_all_vectors():
    vectors = MechanismVectors(*(10.0 * k + np.arange(6.0) for k in range(6)))
    assert [part.tolist() for part in drivers.of_one(vectors, 1, 3)] == [
        [10.0 * k + 2.0, 10.0 * k + 3.0] for k in range(6)
    ]

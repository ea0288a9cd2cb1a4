"""Forces that a model may lack lie in the columns of their causes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import columns_by_cause, lagging_columns
from bristle.identification.missing_rows import Rows

DT = 2e-3
TIME = DT * np.arange(5000)
SPEED = 2.0 * np.pi * 0.4


def rows_of(amplitude=0.05, kind="translational", **surroundings):
    x = amplitude * np.sin(SPEED * TIME + 0.3) + 0.2 * amplitude * np.sin(3.1 * SPEED * TIME)
    v = amplitude * SPEED * (np.cos(SPEED * TIME + 0.3) + 0.62 * np.cos(3.1 * SPEED * TIME))
    a = np.gradient(v, DT)
    friction = 8.0 * np.sign(v) + 30.0 * v
    cycles = Groups(np.cumsum(np.diff(np.sign(v), prepend=1.0) != 0.0))
    predicted, none = friction + 3.0 * a, np.zeros_like(x)
    return Rows(
        TIME, x, v, a, predicted, none, none[:, None], predicted, friction, np.sign(v), cycles, surroundings, 50.0, kind, none, 10.0
    )


def left(columns, force):
    """What columns do not take of a force, as a share of it."""
    rest = force - columns @ np.linalg.lstsq(columns, force, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(force))


def test_friction_that_grows_with_what_is_passed_on():
    rows = rows_of()
    force = 0.2 * np.abs(3.0 * rows.acceleration) * np.sign(rows.velocity)
    assert left(columns_by_cause(rows)["transmitted"], force) < 1e-9


@pytest.mark.parametrize("channel", ["load", "temperature"])
def test_friction_that_grows_with_a_channel(channel):
    signal = 1.0 + 0.3 * np.sin(0.9 * TIME) ** 2
    rows = rows_of(**{channel: signal})
    assert left(columns_by_cause(rows)[channel], 0.1 * rows.friction * (signal - np.mean(signal))) < 1e-9


def test_the_weight_of_a_link_of_a_large_angle_only():
    rows = rows_of(1.2, "rotational")
    assert left(columns_by_cause(rows)["gravity"], 20.0 * np.sin(rows.position + 0.4)) < 1e-9
    assert "gravity" not in columns_by_cause(rows_of(0.2, "rotational"))
    assert "gravity" not in columns_by_cause(rows_of(1.2))


@pytest.mark.parametrize("share", [0.05, 0.2, 0.6])
def test_a_fall_with_the_speed(share):
    rows = rows_of()
    speed = np.abs(rows.velocity)
    force = 5.0 * np.exp(-speed / (share * np.quantile(speed, 0.99))) * np.sign(rows.velocity)
    assert left(columns_by_cause(rows)["speed"], force) < 0.02


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("lag", [0.01, 0.04])
@pytest.mark.parametrize("share", [0.003, 0.01, 0.03, 0.1])
def test_a_fall_that_lags_behind_the_speed(lag, share):
    rows = rows_of()
    speed = np.abs(rows.velocity)

    def rate(time, late):
        return (np.interp(time, TIME, speed) - late) / lag

    late = solve_ivp(rate, (0.0, TIME[-1]), speed[:1], t_eval=TIME, rtol=1e-7, atol=1e-10, max_step=DT).y[0]
    fall = share * np.quantile(speed, 0.99)
    force = 5.0 * (np.exp(-late / fall) - np.exp(-speed / fall)) * np.sign(rows.velocity)
    assert left(lagging_columns(rows), force) < 0.12

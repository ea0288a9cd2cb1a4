"""A recorded velocity is compared with the position."""

from dataclasses import replace

import numpy as np
import pytest

from bristle.core.axis import Axis, Column
from bristle.logs import checked, read_log
from bristle.report.messages import message

W = 2 * np.pi / 0.617


@pytest.fixture
def with_velocity(axis) -> Axis:
    return replace(axis, columns={**axis.columns, "velocity": Column("v", "m/s", "m/s")})


def velocity(recording, seed=3):
    return 0.25 * W * np.sin(W * recording["t"]) + np.random.default_rng(seed).normal(
        0.0, 0.02, recording["t"].size
    )


def said_of(write, axis, v):
    result = checked(read_log(write(v=v), axis), axis)
    return " | ".join(message(item) for item in result if item.code == "velocity_contradicts")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda v: 1000.0 * v, "is 1000 times the derivative of the position"),
        (lambda v: 60.0 * v / (2 * np.pi), "is 9.55 times the derivative of the position"),
        (lambda v: -v, "is -1 times the derivative of the position"),
        (np.gradient, "times the derivative of the position (correlation"),
        (lambda v: np.roll(v, 12), "lags the derivative of the position by "),
    ],
)
def test_a_wrong_unit_sign_or_signal_is_reported(write, with_velocity, recording, change, said):
    assert said in said_of(write, with_velocity, change(velocity(recording)))


def test_a_speed_beyond_the_limit_is_reported(write, axis, recording):
    # The recording reaches 2.55 m/s.
    assert not read_log(write(), replace(axis, velocity_limit=2.6)).notes
    (text,) = read_log(write(), replace(axis, velocity_limit=2.0)).notes
    assert "up to 2.5" in text
    assert "limit of 2 m/s" in text

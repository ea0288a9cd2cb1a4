"""Lost readings and numbers that are not a measurement are named; stick-slip, counts and hard stops are no such thing."""

from __future__ import annotations

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.engine import run_open_loop
from bristle.logs import read_log, summarize
from bristle.logs.problems import far_outside, quantisation, spikes
from bristle.models.friction import lugre
from bristle.models.plants import inertia

TIME = np.arange(6000) * 1e-3
MOTION = 0.1 * np.sin(3.0 * TIME) + 0.02 * np.sin(11.0 * TIME)


def found_in(values):
    return spikes(values, quantisation(values))


@pytest.mark.parametrize("length", [1, 2, 5])
@pytest.mark.parametrize("step", [0.0, 1e-7, 1e-5])
def test_a_lost_reading_is_found_where_it_is(length, step):
    values = np.round(MOTION / step) * step if step else MOTION.copy()
    values[2345 : 2345 + length] = 0.5
    (item,) = found_in(values)
    assert (item.start, item.length) == (2345, length)
    assert item.size == pytest.approx(0.5 - MOTION[2345], abs=2e-3)


def stick_slip():
    """A mass that a slow sine of the effort drags over a contact with a large break-away force."""
    friction = lugre(F_C=5.0, F_S=9.0, v_S=1e-3, sigma_0=1e6, sigma_1=300.0)
    return run_open_loop(inertia(M=1.0), friction, 9.5 * np.sin(6.0 * TIME), 1e-3, steps=4).position


MOTIONS = {
    "smooth": MOTION,
    "stick-slip": stick_slip(),
    "stick-slip, slow": stick_slip()[::10],
    "hard turns": np.abs((TIME * 0.4) % 2.0 - 1.0),
    "noise": MOTION + np.random.default_rng(3).normal(0.0, 1e-4, TIME.size),
    "flicker": np.where(np.random.default_rng(4).random(TIME.size) < 0.01, 1e-6, 0.0),
    "one move": np.concatenate([np.zeros(9000), np.linspace(0.0, 1e-3, 30), np.full(900, 1e-3)]),
}


@pytest.mark.parametrize("step", [0.0, 1e-6, 5e-5])
@pytest.mark.parametrize("values", MOTIONS.values(), ids=MOTIONS)
def test_motion_of_an_axis_is_no_lost_reading(values, step):
    recorded = np.round(values / step) * step if step else values
    assert found_in(recorded) == []
    assert far_outside(recorded).size == 0


@pytest.mark.parametrize(
    ("column", "change", "words"),
    [
        (
            "q",
            lambda x: np.where(np.arange(x.size) == 600, 9.0, x),
            "q': jumps by .* m and returns after 1 sample at sample 600",
        ),
        ("u", lambda x: np.where(np.arange(x.size) == 600, 1e308, x), "u': has 1e.308 N at sam"),
        ("u", lambda x: 1e40 * x, "cannot be a measurement"),
        # A motion finer than any axis counts as rest.
        ("q", lambda x: 1e-60 * x, "is constant"),
        ("u", lambda x: 1e-60 * x, "is constant"),
    ],
)
def test_a_log_with_numbers_that_no_axis_has_is_refused_with_its_column(
    write, recording, axis, column, change, words
):
    path = write(**{column: change(recording[column])})
    with pytest.raises(InputError, match=words):
        read_log(path, axis)
    assert len(summarize(path, axis)["problems"]) == 1

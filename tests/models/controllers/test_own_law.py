"""A control law of one's own declares what its gains are, whatever product that is."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from bristle import friction, sensors
from bristle.core import Axis, Column, Controller, InputError, Variable, kernel
from bristle.engine import interpreted, run_closed_loop
from bristle.files.components import in_effort
from bristle.models.plants import inertia

DT = 1e-3


class Gains(NamedTuple):
    K_P: Annotated[float, Variable("force/length", "proportional gain", min=0.0)]
    K_I: Annotated[float, Variable("force/length/time", "integral gain", min=0.0)]
    K_D: Annotated[float, Variable("force*time/length", "derivative gain", min=0.0)]


class State(NamedTuple):
    e: Annotated[float, Variable("length", "error one sample ago")] = 0.0
    total: Annotated[float, Variable("length*time", "integral of the error")] = 0.0


@kernel
def step(state, reference, measured, dt, p):
    e = reference.position - measured
    total = state.total + e * dt
    return p.K_P * e + p.K_I * total + p.K_D * (e - state.e) / dt, State(e, total)


def start(measured, velocity, acceleration, dt, p):
    return State()


PID = Controller(
    name="pid",
    description="a law of one's own",
    Parameters=Gains,
    State=State,
    step=step,
    start=start,
)


def test_the_gains_have_units_on_either_kind_of_axis():
    assert [variable.unit() for variable in PID.variables.values()] == ["N/m", "N/(m*s)", "N*s/m"]
    assert PID.variables["K_I"].unit("rotational") == "N*m/(rad*s)"
    assert repr(PID(K_P=1.0, K_I=2.0, K_D=3.0)) == "pid(K_P=1 N/m, K_I=2 N/(m*s), K_D=3 N*s/m)"


@pytest.mark.parametrize("text", ["20 N/(mm*s)", "20000 N/m/s", "0.02 N/(um*s)", 2e4])
def test_the_integral_gain_is_read_with_its_unit(text):
    assert PID(K_P=1.0, K_I=text, K_D=0.0).values["K_I"] == pytest.approx(2e4, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "text", "words"),
    [
        (None, "5 N/m", r"K_I: has the wrong unit; found '5 N/m', allowed a value in N/\(m\*s\)"),
        ("translational", "5 N*m/(rad*s)", "unit is for a rotational axis"),
    ],
)
def test_the_integral_gain_of_another_quantity_is_refused(kind, text, words):
    with pytest.raises(InputError, match=words):
        PID(kind=kind, K_P=1.0, K_I=text, K_D=0.0)


def test_the_integral_gain_is_shown_in_the_units_of_a_drive():
    columns = {
        "effort": Column("u", "V", "V", 35.0),
        "position": Column("q", "count", "count", -1e-6),
    }
    axis = Axis(kind="translational", columns=columns)
    quantity = PID.variables["K_I"].quantity
    for text, value in (("3 V/(m*s)", 105.0), ("3 V/(count*s)", 105e6), ("3 N/(count*s)", 3e6)):
        assert in_effort(text, quantity, axis.kind, axis, "K_I") == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("gain", "left"), [("0 N/(m*s)", 5.0 / 2000.0), ("20 N/(mm*s)", 0.0)])
def test_the_integral_removes_the_error_of_a_constant_force(gain, left):
    desired = np.zeros((4, 1500))
    desired[0] = 1e-2
    law = PID(K_P="2 N/mm", K_I=gain, K_D="80 N*s/m")
    with interpreted():
        trace = run_closed_loop(
            inertia(M=2.0),
            friction.viscous(F_v=1.0),
            law,
            sensors.encoder(),
            desired,
            DT,
            disturbance=np.full(1500, 5.0),
            steps=1,
        )
    assert abs(desired[0, -1] - trace.position[-1]) == pytest.approx(left, rel=1e-3, abs=1e-5)

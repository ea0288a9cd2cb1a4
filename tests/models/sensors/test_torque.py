"""What a torque sensor between motor and screw sees."""

import numpy as np
import pytest

from bristle import friction
from bristle.engine import run_open_loop
from bristle.models.plants import inertia
from bristle.models.sensors import torque_seen

J, SHARE, DT = 4e-4, 0.3, 1e-4


def axis(effort):
    model = friction.lugre(
        kind="rotational", F_C=0.034, F_S=0.04, v_S=0.5, sigma_0=30.0, sigma_1=0.04, sigma_2=3e-3
    )
    return run_open_loop(inertia(kind="rotational", M=J), model, effort, DT)


def test_the_sensor_reads_friction_only_without_acceleration():
    trace = axis(np.full(40_000, 0.06))
    seen = torque_seen(trace.effort, trace.velocity, DT, SHARE * J)
    late = slice(-1000, None)
    assert seen[late] == pytest.approx(trace.friction[:-1][late], rel=1e-6)
    early = slice(0, 1000)
    assert np.max(np.abs(seen[early] - trace.friction[:-1][early])) > 0.2 * np.max(trace.friction)


def test_the_sensor_also_reads_the_inertia_behind_it():
    trace = axis(0.06 * np.sin(2.0 * np.pi * 20.0 * DT * np.arange(5000)))
    beyond = torque_seen(trace.effort, trace.velocity, DT, SHARE * J) - trace.friction[:-1]
    behind = (1.0 - SHARE) * J * np.diff(trace.velocity) / DT
    assert beyond == pytest.approx(behind, abs=1e-9)
    # In front of all inertia it sees nothing but the friction.
    assert torque_seen(trace.effort, trace.velocity, DT, J) == pytest.approx(
        trace.friction[:-1], abs=1e-9
    )

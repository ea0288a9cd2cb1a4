"""The axis of the demonstration: its friction, its motion and its logs are what they are said to be."""

import numpy as np
import pytest

from bristle.core.contracts import Motion
from bristle.demo import axis_simulated, truth
from bristle.demo.axis_simulated import SAMPLE_TIME, motion
from bristle.paper.rig import spectrum

AXIS = axis_simulated.friction()
P = AXIS.parameters


def slid(speed, distance=1e-3, step=1e-6):
    """The force after a slide at a constant speed, and on the way there."""
    component = AXIS.component
    state, memory, x, forces = component.initial_state(P), component.new_memory(P), 0.0, []
    for _ in range(round(distance / step)):
        x += step * np.sign(speed)
        force, move = component.trial(state, memory, Motion(speed, x), step / abs(speed), P)
        state = component.commit(state, memory, move, P)
        forces.append(force)
    return np.array(forces)


def test_limits_fall_with_speed_and_differ_by_direction():
    assert truth.limit_of(1e-12, P) == pytest.approx(1.06 * 41.0)
    assert truth.limit_of(-1e-12, P) == pytest.approx(0.94 * 41.0)
    assert truth.limit_of(1.0, P) == pytest.approx(1.06 * 32.0)
    assert truth.limit_of(6e-3, P) == pytest.approx(1.06 * (32.0 + 9.0 / np.e))


def test_an_oil_film_has_half_of_its_friction_at_its_speed():
    for speed, share in ((1e-5, 1.0), (0.6, 0.5)):
        expected = truth.limit_of(speed, P) * np.sum(P.alpha_i) + share * 260.0 * speed
        assert slid(speed, 1e-4)[-1] == pytest.approx(expected, rel=1e-4)
    assert slid(-0.6, 1e-4)[-1] == pytest.approx(-(0.94 * 32.0 + 0.5 * 260.0 * 0.6), rel=1e-4)


def test_elements_slip_after_their_distances_and_all_of_them_at_7_micrometres():
    force = slid(1e-9, 1e-5, 1e-7)
    assert P.alpha_i.sum() == pytest.approx(1.0)
    shares, distances = spectrum(30, 7e-6, seed=7)
    assert (P.alpha_i.tolist(), P.r_i.tolist()) == (shares.tolist(), distances.tolist())
    assert (P.r_i.size, P.r_i.max()) == (30, pytest.approx(7e-6))
    assert force[0] == pytest.approx(0.5e-7 * 41.0 * np.sum(P.alpha_i / P.r_i), rel=1e-6)  # in the middle of a step
    assert force[-1] == pytest.approx(1.06 * 41.0, rel=1e-6)
    assert force[60] < force[-1]


def test_a_motion_is_made_of_moves_with_pauses_within_its_travel():
    x = motion(1, 10.0)
    assert x.size == 10_000
    assert np.all(x[:200] == 0.0)
    assert np.max(np.abs(x)) <= 0.15
    assert motion(1, 10.0).tolist() == x.tolist()
    assert motion(2, 10.0).tolist() != x.tolist()
    assert motion(1).size == 24_000
    moving = np.diff(x) != 0.0
    assert 0.3 < np.mean(moving) < 0.99
    speeds = np.abs(np.diff(motion(1))) / SAMPLE_TIME
    assert 0.1 < np.max(speeds) < 1.1 * 10**-0.6


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.1), (0.1, -0.05), (0.02, 0.0275)])
def test_a_move_is_a_rounded_trapezium(start, end):
    x = axis_simulated._move(start, end, 0.1, 2.0)
    v = np.diff(x, prepend=start) / SAMPLE_TIME
    assert x[-1] == pytest.approx(end, abs=1e-12)
    assert np.all(np.sign(end - start) * v >= -1e-12)
    top = min(0.1, np.sqrt(abs(end - start) * 2.0))
    assert np.max(np.abs(v)) == pytest.approx(top, rel=0.03)
    # An acceleration of 2 m/s^2, over 20 ms of rounding.
    assert np.max(np.abs(np.diff(v))) / SAMPLE_TIME <= 2.0 * 1.1
    expected = abs(end - start) / top + top / 2.0
    assert x.size * SAMPLE_TIME == pytest.approx(expected + 0.041, abs=2e-3)


def test_the_axis_follows_its_motion(tmp_path, monkeypatch):
    reference, described = motion(3, 1.0), axis_simulated.axis()
    monkeypatch.setattr(axis_simulated, "motion", lambda seed: reference)
    axis_simulated.write_log(tmp_path / "log.csv", 3)
    lines = (tmp_path / "log.csv").read_text().splitlines()
    assert lines[:2] == ["# simulated axis, not a measurement", "time [s],position [mm],reference [mm],motor_current [A]"]
    assert len(lines) == 2 + reference.size
    _, position, desired, current = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=2).T
    assert desired == pytest.approx(1e3 * reference, abs=1e-6)
    assert np.max(np.abs(position - desired)) < 2.0
    counts = 1e-3 * position / described.resolution
    assert counts == pytest.approx(np.round(counts), abs=0.06)  # the file has 0.1 um
    assert np.max(np.abs(current)) <= described.effort_limit / 61.2 + 0.05

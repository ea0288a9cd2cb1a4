"""The picture of lost motion: what both encoders show is the deflection of a coupling with play, whatever their zero."""

from types import SimpleNamespace

import numpy as np
import pytest

from bristle.figures.two_masses import lost_motion

SOFTNESS, PLAY, ZERO = 1.0 / 2e7, 6e-6, 40e-6  # m/N, m, m between the zeros of both encoders


def two_encoders():
    """An axis with a sensor of force in the coupling, as an identification has it."""
    time = 1e-3 * np.arange(4000)
    force = 100.0 * np.sin(2.0 * np.pi * time)
    deflection = SOFTNESS * force + 0.5 * PLAY * np.sign(force)
    load = 0.02 * np.sin(np.pi * time)
    plant = SimpleNamespace(kind="translational")

    def side(position, signal):
        traces = SimpleNamespace(time=time, measured=signal, residual=np.zeros(time.size))
        log = SimpleNamespace(time=SimpleNamespace(values=time), position=SimpleNamespace(values=position))
        return SimpleNamespace(best=SimpleNamespace(traces=traces, plant=plant), log=log)

    sides = {"motor": side(load + deflection + ZERO, 2.0 * force), "load": side(load, force)}
    named = {"stiffness": SimpleNamespace(value=1.0 / SOFTNESS), "play": SimpleNamespace(value=PLAY)}
    return SimpleNamespace(two_masses=SimpleNamespace(sides=sides, measured=True, by_name=named))


def test_measured_points_lie_on_the_line_of_stiffness_and_play():
    (axes,) = lost_motion(two_encoders()).axes
    lines = {line.get_label(): line for line in axes.lines}
    force, twist = lines["measured"].get_data()
    along, deflection = lines["model"].get_data()
    moved = np.abs(force) > 1.0
    expected = [np.interp(f, along[:2], deflection[:2]) if f < 0.0 else np.interp(f, along[2:], deflection[2:]) for f in force[moved]]
    assert twist[moved] == pytest.approx(expected, abs=0.02 * np.ptp(twist))
    # 100 N deflect the coupling by 5 µm, and half of the play is 3 µm.
    assert max(deflection) == pytest.approx(8.0, rel=0.01)
    assert [along[1], along[2]] == [0.0, 0.0]
    assert deflection[2] - deflection[1] == pytest.approx(6.0, rel=0.01)

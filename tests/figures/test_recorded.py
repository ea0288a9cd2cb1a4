"""Passages of a log are shaded by what they are, its loops drawn over position, and recorded curves beside those predicted."""

from types import SimpleNamespace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.figures.gallery import F, T, X, log

from bristle.figures import recorded, report_figure, two_masses
from bristle.logs.passages import Passage


def test_a_kind_of_passages_is_named_once():
    item, _ = log()
    kinds = (("moves", 0.0), ("moves", 1.0), ("rest", 2.0), ("chirp", 3.0))
    axes, _ = recorded.passages(item, [Passage(kind, slice(0, 9), begin, begin + 0.5) for kind, begin in kinds]).axes
    drawn = [(patch.get_label(), patch.get_x(), patch.get_width()) for patch in axes.patches]
    assert drawn == [("moves", 0.0, 0.5), ("_moves", 1.0, 0.5), ("chirp", 3.0, 0.5)]
    item.effort = None
    assert len(recorded.passages(item, []).axes) == 1


def test_a_few_of_very_many_samples_are_drawn():
    count = 45_000
    values = np.arange(float(count))
    item = Some(kind="translational", time=Some(values=values), position=Some(values=values), effort=Some(values=values))
    (axes,) = recorded.loops_of_log(item, [Passage("break_away", slice(0, count), 0.0, 1.0)]).axes
    assert axes.get_lines()[0].get_xdata().size == count // 2


def test_effort_is_drawn_over_the_slope_of_the_position_without_a_velocity():
    item, segments = log()
    item.velocity = None
    assert recorded.effort_over_velocity(item).axes[0].get_lines()[0].get_xdata().max() == pytest.approx(1e3 * np.gradient(X, T).max())
    assert report_figure.FIGURES["recorded.passages"].alternative(item, segments).startswith("Position and effort over time")


@pytest.mark.parametrize(("count", "drawn"), [(24, 24), (25, 13), (48, 24), (49, 17)])
def test_a_few_of_many_curves_are_drawn(count, drawn):
    curves = [(X[:4], F[:4] + k) for k in range(count)]
    given = curves, [f for _, f in curves], "rotational"
    (overlay,), (left,) = recorded.recorded_curves(*given).axes, recorded.curve_errors(*given).axes
    assert bool(report_figure.FIGURES["recorded.curves"].caption(Some(curves=curves), ())) == (count > 24)
    assert len(left.get_lines()) == drawn
    assert len(overlay.get_lines()) == 2 * drawn


@pytest.mark.parametrize(("kind", "is_loop"), [("loops", True), ("moves", False), ("break_away", True)])
def test_loops_and_break_aways_count_as_loops(kind, is_loop):
    assert report_figure.FIGURES["recorded.loops"].applies(log()[0], [Passage(kind, slice(0, 1), 0.0, 1.0)]) == is_loop


# --- The picture of lost motion: what both encoders show is the deflection of a coupling with play, whatever their zero


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
    (axes,) = two_masses.lost_motion(two_encoders()).axes
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

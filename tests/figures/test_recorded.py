"""Passages of a log are shaded by what they are, its loops drawn over position, and recorded curves beside those predicted."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.figures.gallery import F, T, X, log

from bristle.figures.recorded import curve_errors, effort_over_velocity, loops_of_log, passages, recorded_curves
from bristle.figures.report_figure import FIGURES
from bristle.logs.passages import Passage


def test_a_passage_is_shaded_from_begin_to_end_and_named_once():
    item, _ = log()
    segments = [
        Passage(kind, slice(0, 9), begin, begin + 0.5) for kind, begin in (("moves", 0.0), ("moves", 1.0), ("rest", 2.0), ("chirp", 3.0))
    ]
    axes, effort = passages(item, segments).axes
    assert effort.get_ylabel() == "Force [N]"
    assert [(patch.get_label(), patch.get_x(), patch.get_width()) for patch in axes.patches] == [
        ("moves", 0.0, 0.5),
        ("_moves", 1.0, 0.5),
        ("chirp", 3.0, 0.5),
    ]
    assert axes.get_figure().get_size_inches()[1] == pytest.approx(4.4)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Time [s]", "Position [mm]")
    assert all(patch.get_zorder() == 0 for patch in axes.patches)


def test_loops_begin_at_zero_position():
    item, segments = log()
    (loops,) = loops_of_log(item, segments).axes
    x, force = loops.get_lines()[0].get_data()
    assert x[0] == 0.0
    assert x == pytest.approx(1e3 * (X[:500] - X[0]))
    assert force == pytest.approx(F[:500])
    assert (loops.get_xlabel(), loops.get_ylabel()) == ("Position [mm]", "Force [N]")
    item.effort = None
    assert len(passages(item, segments).axes) == 1


def test_a_few_of_very_many_samples_are_drawn():
    count = 45_000
    values = np.arange(float(count))
    item = Some(kind="translational", time=Some(values=values), position=Some(values=values), effort=Some(values=values))
    (axes,) = loops_of_log(item, [Passage("break_away", slice(0, count), 0.0, 1.0)]).axes
    assert axes.get_lines()[0].get_xdata().size == count // 2


def test_effort_is_drawn_over_velocity():
    item, segments = log()
    (axes,) = effort_over_velocity(item).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Velocity [mm/s]", "Force [N]")
    assert axes.get_lines()[0].get_xdata().max() == pytest.approx(1e3 * item.velocity.values.max())
    item.velocity = None
    assert effort_over_velocity(item).axes[0].get_lines()[0].get_xdata().max() == pytest.approx(1e3 * np.gradient(X, T).max())
    assert FIGURES["recorded.passages"].alternative(item, segments).startswith("Position and effort over time")


def test_recorded_curves_are_drawn_with_predictions_and_differences():
    given = [(X, F), (2.0 * X, F)], [0.9 * F, 0.9 * F], "translational"
    (overlay,), (left,) = recorded_curves(*given).axes, curve_errors(*given).axes
    assert [line.get_label() for line in overlay.get_lines()][:2] == ["recorded", "predicted"]
    assert len([line for line in overlay.get_lines() if not line.get_label().startswith("_")]) == 2
    assert left.get_lines()[0].get_ydata() == pytest.approx(0.1 * F * (1e3 if "mN" in left.get_ylabel() else 1.0))
    assert left.get_lines()[1].get_xdata() == pytest.approx(2e3 * X)
    assert overlay.get_xlabel() == left.get_xlabel() == "Position [mm]"
    assert T.size == X.size


@pytest.mark.parametrize(("count", "drawn"), [(24, 24), (25, 13), (48, 24), (49, 17)])
def test_a_few_of_many_curves_are_drawn(count, drawn):
    curves = [(X[:4], F[:4] + k) for k in range(count)]
    given = curves, [f for _, f in curves], "rotational"
    (overlay,), (left,) = recorded_curves(*given).axes, curve_errors(*given).axes
    assert bool(FIGURES["recorded.curves"].caption(Some(curves=curves), ())) == (count > 24)
    assert len(left.get_lines()) == drawn
    assert len(overlay.get_lines()) == 2 * drawn


def test_loops_and_break_aways_count_as_loops():
    item, segments = log()
    assert FIGURES["recorded.loops"].applies(item, segments)
    assert not FIGURES["recorded.loops"].applies(item, [Passage("moves", slice(0, 1), 0.0, 1.0)])
    assert FIGURES["recorded.loops"].applies(item, [Passage("break_away", slice(0, 1), 0.0, 1.0)])

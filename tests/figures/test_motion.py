"""A motion, a panel for each purpose, and the friction to expect: loops over position, steady slides over speed."""

from types import SimpleNamespace as Some

import numpy as np
import pytest

from bristle.excitation.purposes import PURPOSES
from bristle.figures.motion import _parts, _steady, expected, motion

T = 0.01 * np.arange(401)


def piece(purpose, duration=1.0):
    return Some(purpose=purpose, duration=duration)


def planned(*purposes, kind="translational", velocity=None):
    """A motion of a second for each piece, which begins at 7 mm."""
    position = 7e-3 + 1e-3 * np.sin(2.0 * np.pi * T)
    return Some(
        time=T,
        position=position,
        velocity=np.gradient(position, T) if velocity is None else velocity,
        start=7e-3,
        kind=kind,
        pieces=[piece(purpose) for purpose in purposes],
        begins=[float(k) for k in range(len(purposes))],
    )


def test_pieces_of_a_purpose_in_a_row_are_a_single_part():
    parts = _parts(planned("presliding", "presliding", "stribeck", "inertia"))
    assert parts == {"presliding": slice(0, 200), "stribeck": slice(200, 300), "inertia": slice(300, 400)}


def test_the_motion_of_a_purpose_begins_at_zero():
    figure = motion(planned("presliding", "presliding", "stribeck"))
    line, other = (axes.get_lines()[0] for axes in figure.axes)
    assert [axes.get_title(loc="right") for axes in figure.axes] == ["presliding", "stribeck"]
    assert [*line.get_xdata()[[0, -1]], other.get_xdata()[0]] == pytest.approx([0.0, 1.99, 2.0])
    assert (line.get_ydata()[0], line.get_ydata().max(), line.get_ydata().min()) == pytest.approx((0.0, 1.0, -1.0))
    assert motion(planned("stribeck", kind="rotational")).axes[0].get_ylabel() == "Angle [mrad]"


def test_a_slide_is_represented_by_its_second_half():
    velocity = np.zeros(401)
    velocity[20:60], velocity[80:84], velocity[100:140] = 2e-3, 5e-3, -4e-3  # the second one is too short to be steady
    velocity[60:80] = np.linspace(2.1e-3, 4.9e-3, 20)
    friction = np.arange(401.0)
    slides = _steady(planned("stribeck", velocity=velocity), friction, slice(10, 401))
    # A slide of 40 samples has 39 steps: from the 20th on they count, the last one left out.
    assert slides == pytest.approx(np.array([[2e-3, np.arange(39, 58).mean()], [-4e-3, np.arange(119, 138).mean()]]))


@pytest.mark.parametrize(("steps", "slides"), [(0, 0), (4, 0), (5, 1)])
def test_a_slide_has_more_than_four_steps_at_the_same_speed(steps, slides):
    velocity = np.linspace(0.0, 1e-3, 401)
    velocity[100 : 101 + steps] = 5e-3
    assert _steady(planned("stribeck", velocity=velocity), np.ones(401), slice(0, 401)).shape == (slides, 2)


def test_expected_friction_is_loops_over_position_and_levels_over_speed():
    velocity = np.where(T < 1.0, 1e-3 * np.cos(2.0 * np.pi * T), np.where(T < 2.0, -2e-2, 5e-3))
    friction = 4.0 * np.sign(velocity)
    course = planned("presliding", "stribeck", "stribeck", velocity=velocity)
    loops, speeds = expected(course, friction).axes
    line = loops.get_lines()[0]
    assert line.get_xdata() == pytest.approx(1e3 * (course.position[:100:4] - 7e-3))
    assert line.get_ydata() == pytest.approx(friction[:100:4])
    x, y = speeds.get_lines()[0].get_data()
    assert x == pytest.approx([20.0, 5.0])
    assert y == pytest.approx([4.0, 4.0])
    assert speeds.xaxis.get_major_formatter()(20.0, 0) == "20"
    speeds.set_xlim(1.0, 100.0)
    assert {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0} <= set(np.round(speeds.xaxis.get_majorticklocs(), 9))


@pytest.mark.parametrize("purpose", PURPOSES)
def test_a_motion_for_a_single_purpose_has_one_panel_of_its_expected_friction(purpose):
    speed = np.where(T < 2.0, 2e-3, -2e-3)
    (axes,) = expected(planned(purpose, velocity=speed), np.sin(T)).axes
    assert axes.lines[0].get_xdata().size > 0
    assert axes.get_xlabel() == ("Speed [mm/s]" if purpose == "stribeck" else "Position [mm]")

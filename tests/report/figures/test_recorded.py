"""Passages of a log are shaded by what they are, its loops drawn over position, and recorded curves beside those predicted."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.report.figures.gallery import F, T, X, log

from bristle.logs.passages import Passage
from bristle.prediction.excitation.purposes import PURPOSES
from bristle.report.figures import recorded, report_figure, two_masses
from bristle.report.figures.motion import _parts, _steady, expected, motion


def test_a_kind_of_passages_is_named_once():
    item, _ = log()
    kinds = (("moves", 0.0), ("moves", 1.0), ("rest", 2.0), ("chirp", 3.0))
    axes, _ = recorded.passages(
        item, [Passage(kind, slice(0, 9), begin, begin + 0.5) for kind, begin in kinds]
    ).axes
    drawn = [(patch.get_label(), patch.get_x(), patch.get_width()) for patch in axes.patches]
    assert drawn == [("moves", 0.0, 0.5), ("_moves", 1.0, 0.5), ("chirp", 3.0, 0.5)]
    item.effort = None
    assert len(recorded.passages(item, []).axes) == 1


def test_a_few_of_very_many_samples_are_drawn():
    count = 45_000
    values = np.arange(float(count))
    item = Some(
        kind="translational",
        time=Some(values=values),
        position=Some(values=values),
        effort=Some(values=values),
    )
    (axes,) = recorded.loops_of_log(item, [Passage("break_away", slice(0, count), 0.0, 1.0)]).axes
    assert axes.get_lines()[0].get_xdata().size == count // 2


def test_effort_is_drawn_over_the_slope_of_the_position_without_a_velocity():
    item, segments = log()
    item.velocity = None
    assert recorded.effort_over_velocity(item).axes[0].get_lines()[
        0
    ].get_xdata().max() == pytest.approx(1e3 * np.gradient(X, T).max())
    assert (
        report_figure.FIGURES["recorded.passages"]
        .alternative(item, segments)
        .startswith("Position and effort over time")
    )


@pytest.mark.parametrize(("count", "drawn"), [(24, 24), (25, 13), (48, 24), (49, 17)])
def test_a_few_of_many_curves_are_drawn(count, drawn):
    curves = [(X[:4], F[:4] + k) for k in range(count)]
    given = curves, [f for _, f in curves], "rotational"
    (overlay,), (left,) = recorded.recorded_curves(*given).axes, recorded.curve_errors(*given).axes
    assert bool(report_figure.FIGURES["recorded.curves"].caption(Some(curves=curves), ())) == (
        count > 24
    )
    assert len(left.get_lines()) == drawn
    assert len(overlay.get_lines()) == 2 * drawn


@pytest.mark.parametrize(
    ("kind", "is_loop"), [("loops", True), ("moves", False), ("break_away", True)]
)
def test_loops_and_break_aways_count_as_loops(kind, is_loop):
    assert (
        report_figure.FIGURES["recorded.loops"].applies(
            log()[0], [Passage(kind, slice(0, 1), 0.0, 1.0)]
        )
        == is_loop
    )


# --- The picture of lost motion: what both encoders show is the deflection of a coupling with play, whatever their zero


SOFTNESS, PLAY, ZERO = 1.0 / 2e7, 6e-6, 40e-6  # m/N, m, m between the zeros of both encoders


def two_encoders():
    """An axis with a sensor of force in the coupling, as an identification has it."""
    time = 1e-3 * np.arange(4000)
    force = 100.0 * np.sin(2.0 * np.pi * time)
    deflection = SOFTNESS * force + 0.5 * PLAY * np.sign(force)
    load = 0.02 * np.sin(np.pi * time)
    plant = Some(kind="translational")

    def side(position, signal):
        traces = Some(time=time, measured=signal, residual=np.zeros(time.size))
        log = Some(time=Some(values=time), position=Some(values=position))
        return Some(best=Some(traces=traces, plant=plant), log=log)

    sides = {"motor": side(load + deflection + ZERO, 2.0 * force), "load": side(load, force)}
    named = {"stiffness": Some(value=1.0 / SOFTNESS), "play": Some(value=PLAY)}
    return Some(two_masses=Some(sides=sides, measured=True, by_name=named))


def test_measured_points_lie_on_the_line_of_stiffness_and_play():
    (axes,) = two_masses.lost_motion(two_encoders()).axes
    lines = {line.get_label(): line for line in axes.lines}
    force, twist = lines["measured"].get_data()
    along, deflection = lines["model"].get_data()
    moved = np.abs(force) > 1.0
    expected = [
        np.interp(f, along[:2], deflection[:2])
        if f < 0.0
        else np.interp(f, along[2:], deflection[2:])
        for f in force[moved]
    ]
    assert twist[moved] == pytest.approx(expected, abs=0.02 * np.ptp(twist))
    # 100 N deflect the coupling by 5 µm, and half of the play is 3 µm.
    assert max(deflection) == pytest.approx(8.0, rel=0.01)
    assert [along[1], along[2]] == [0.0, 0.0]
    assert deflection[2] - deflection[1] == pytest.approx(6.0, rel=0.01)


# --- A motion, a panel for each purpose, and the friction to expect: loops over position, steady slides over speed


TIME = 0.01 * np.arange(401)


def piece(purpose, duration=1.0):
    return Some(purpose=purpose, duration=duration)


def planned(*purposes, kind="translational", velocity=None):
    """A motion of a second for each piece, which begins at 7 mm."""
    position = 7e-3 + 1e-3 * np.sin(2.0 * np.pi * TIME)
    return Some(
        time=TIME,
        position=position,
        velocity=np.gradient(position, TIME) if velocity is None else velocity,
        start=7e-3,
        kind=kind,
        pieces=[piece(purpose) for purpose in purposes],
        begins=[float(k) for k in range(len(purposes))],
    )


def test_pieces_of_a_purpose_in_a_row_are_a_single_part():
    parts = _parts(planned("presliding", "presliding", "stribeck", "inertia"))
    assert parts == {
        "presliding": slice(0, 200),
        "stribeck": slice(200, 300),
        "inertia": slice(300, 400),
    }


def test_the_motion_of_a_purpose_begins_at_zero():
    figure = motion(planned("presliding", "presliding", "stribeck"))
    line, other = (axes.get_lines()[0] for axes in figure.axes)
    assert [axes.get_title(loc="right") for axes in figure.axes] == ["presliding", "stribeck"]
    assert [*line.get_xdata()[[0, -1]], other.get_xdata()[0]] == pytest.approx([0.0, 1.99, 2.0])
    assert (line.get_ydata()[0], line.get_ydata().max(), line.get_ydata().min()) == pytest.approx(
        (0.0, 1.0, -1.0)
    )
    assert motion(planned("stribeck", kind="rotational")).axes[0].get_ylabel() == "Angle [mrad]"


def test_a_slide_is_represented_by_its_second_half():
    velocity = np.zeros(401)
    # The second one is too short to be steady.
    velocity[20:60], velocity[80:84], velocity[100:140] = (2e-3, 5e-3, -4e-3)
    velocity[60:80] = np.linspace(2.1e-3, 4.9e-3, 20)
    friction = np.arange(401.0)
    slides = _steady(planned("stribeck", velocity=velocity), friction, slice(10, 401))
    # A slide of 40 samples has 39 steps: from the 20th on they count, the last one left out.
    assert slides == pytest.approx(
        np.array([[2e-3, np.arange(39, 58).mean()], [-4e-3, np.arange(119, 138).mean()]])
    )


@pytest.mark.parametrize(("steps", "slides"), [(0, 0), (4, 0), (5, 1)])
def test_a_slide_has_more_than_four_steps_at_the_same_speed(steps, slides):
    velocity = np.linspace(0.0, 1e-3, 401)
    velocity[100 : 101 + steps] = 5e-3
    assert _steady(planned("stribeck", velocity=velocity), np.ones(401), slice(0, 401)).shape == (
        slides,
        2,
    )


def test_expected_friction_is_loops_over_position_and_levels_over_speed():
    velocity = np.where(
        TIME < 1.0, 1e-3 * np.cos(2.0 * np.pi * TIME), np.where(TIME < 2.0, -2e-2, 5e-3)
    )
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
    assert {1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0} <= set(
        np.round(speeds.xaxis.get_majorticklocs(), 9)
    )


@pytest.mark.parametrize("purpose", PURPOSES)
def test_a_motion_for_a_single_purpose_has_one_panel_of_its_expected_friction(purpose):
    speed = np.where(TIME < 2.0, 2e-3, -2e-3)
    (axes,) = expected(planned(purpose, velocity=speed), np.sin(TIME)).axes
    assert axes.lines[0].get_xdata().size > 0
    assert axes.get_xlabel() == ("Speed [mm/s]" if purpose == "stribeck" else "Position [mm]")

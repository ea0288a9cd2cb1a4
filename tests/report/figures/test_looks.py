"""Every figure of the gallery looks as it was frozen: its panels, each line and mark with its numbers, and what stands at the axes."""

import inspect
from types import SimpleNamespace as Some

import pytest
from tests.report.figures import gallery as made_up
from tests.report.figures.gallery import PLAIN, F, T, X, figure_of, gallery, looped, simulated
from tests.report.figures.looks import differences, frozen, look_of

from bristle.apps.design import loop_design
from bristle.apps.paper import rig_layout
from bristle.apps.study import many_runs
from bristle.core.palette import LIGHT
from bristle.report.figures import (
    bars,
    comparison,
    first_screen,
    fit,
    following_error,
    loop_rows,
    motion,
    preisach,
    recorded,
    small_multiples,
    style,
)

FROZEN = frozen()
MODULES = (
    bars,
    comparison,
    first_screen,
    fit,
    inspect.getmodule(following_error),
    loop_design,
    loop_rows,
    many_runs,
    motion,
    preisach,
    recorded,
)
MODULES += (rig_layout, small_multiples)


@pytest.mark.parametrize("name", gallery())
def test_a_figure_looks_as_frozen(name):
    assert list(differences(FROZEN[name], look_of(figure_of(name)))) == []


def test_a_changed_look_is_reported_with_its_place():
    was = {"panels": [{"box": [1.0, 2.0], "titles": ["a"]}]}
    assert list(differences(was, {"panels": [{"box": [1.0, 2.00001], "titles": ["a"]}]})) == []
    assert list(differences(was, {"panels": [{"box": [1.0, 2.1], "titles": ["a"]}]})) == [
        "/panels/0/box: [1.0, 2.0] became [1.0, 2.1]"
    ]
    assert list(differences(was, {"panels": [{"box": [1.0], "titles": ["b"]}]})) == [
        "/panels/0/box: [1.0, 2.0] became [1.0]",
        "/panels/0/titles/0: a became b",
    ]


def test_the_gallery_draws_every_figure():
    styled = {
        name
        for module in MODULES
        for name, function in vars(module).items()
        if getattr(function, "__module__", "") == module.__name__
        and hasattr(function, "__wrapped__")
    }
    assert len(styled) > 25
    assert {name for name in styled if f"{name}(" not in inspect.getsource(gallery)} == set()


def test_figures_are_as_wide_as_the_page_and_their_lines_have_colors_of_the_style():
    assert {figure["size"][0] for figure in FROZEN.values()} == {
        style.WIDTH,
        first_screen.SIDE,
        1.7 * style.WIDTH,
    }
    lines = [
        artist
        for figure in FROZEN.values()
        for panel in figure["panels"]
        for artist in panel["artists"]
        if artist[0] == "line"
    ]
    known = {look["color"] for look in (*style.LINES, style.AID, style.DASHED)}
    assert sum(line[2] in known or line[2] in LIGHT.values() for line in lines) > 0.95 * len(lines)


def with_values(item, **values):
    vars(item).update(values)
    return item


def loops_of(result, name, signals):
    """A result whose two loops have these signals."""
    for item, signal in zip(
        (result if isinstance(result, dict) else result.variants).values(), signals, strict=True
    ):
        setattr(item, name, signal)
    return result


def compared(**values):
    return comparison.comparison(with_values(made_up.compared(), **values)).axes


def predicted(a, b, **values):
    signals = {
        "effort": a * F,
        "effort_predicted": b * F,
        "position": a * X,
        "position_predicted": b * X,
    }
    return fit.prediction(
        with_values(made_up.predicted(), half_width=None, **signals | values)
    ).axes


def turned(a, b):
    return compared(
        turns=(
            Some(
                name="forward_to_backward", time=T[:90] - T[30], before=a * X[:90], after=b * X[:90]
            ),
        )
    )


def fitted(a, b):
    best = made_up.fit(PLAIN, "lugre")
    with_values(best.traces, measured=a * F, predicted=b * F)
    return fit.effort_over_time(best).axes


def covered(a, b):
    return recorded.recorded_curves(
        [(a * X, a * F), (b * X, b * F)], [0.9 * a * F, 0.9 * b * F], "translational"
    ).axes


def round_about(a, b):
    circles = made_up.circles_of(PLAIN)
    deviation = circles[1].deviation
    made = [
        with_values(circle, deviation=1e3 * size * deviation)
        for circle, size in zip(circles, (a, b), strict=True)
    ]
    return loop_design.circles(made, "translational").axes


def touched(a, b):
    return small_multiples.minor_loops({"a": (a * X, a * F), "b": (b * X, b * F)}).axes


FOLLOWED = inspect.getmodule(following_error)
SMALLER = {"N": "mN", "mm": "µm", "N·m": "mN·m"}
# Two signals, each so many times as large: the panel and the axis of it that both are drawn along, and its unit where one is large.
UNITS = {
    "effort of a log": (fitted, 0, "y", "N"),
    "predicted effort": (predicted, 0, "y", "N"),
    "predicted position": (lambda a, b: predicted(a, b, effort=None), 0, "y", "mm"),
    "error over a cycle": (
        lambda a, b: compared(course=Some(time=T, motion=X, before=a * X, after=b * X)),
        1,
        "y",
        "mm",
    ),
    "error at a turn": (turned, 2, "y", "mm"),
    "friction at a speed": (
        lambda a, b: compared(friction_curve=[(0.01, Some(before=9.0 * a, after=9.0 * b))]),
        3,
        "y",
        "N",
    ),
    "recorded input": (covered, 0, "x", "mm"),
    "recorded output": (covered, 0, "y", "N"),
    "difference of outputs": (
        lambda a, b: (
            recorded.curve_errors(
                [(a * X, a * F), (b * X, b * F)], [0.0 * F] * 2, "translational"
            ).axes
        ),
        0,
        "y",
        "N",
    ),
    "effort of an open loop": (
        lambda a, b: FOLLOWED.open_loop(loops_of(looped(PLAIN), "effort", (a * F, b * F))).axes,
        3,
        "y",
        "N",
    ),
    "error of a loop": (
        lambda a, b: (
            following_error(loops_of(looped(PLAIN), "measured", (X - a * X, X - b * X))).axes
        ),
        1,
        "y",
        "mm",
    ),
    "effort of a loop": (
        lambda a, b: following_error(loops_of(looped(PLAIN), "effort", (a * F, b * F))).axes,
        -1,
        "y",
        "N",
    ),
    "torque of a loop": (
        lambda a, b: (
            loop_rows.control_effort(
                loops_of(simulated(PLAIN), "effort", (a * F, b * F)), 0.5, (1.0, 2.0)
            ).axes
        ),
        *(0, "y", "N·m"),
    ),
    "motion of a loop": (
        lambda a, b: (
            loop_rows.tracking_error(
                loops_of(simulated(PLAIN), "reference", (a * X, b * X)), 0.5
            ).axes
        ),
        *(0, "y", "mm"),
    ),
    "position of a contact": (touched, 0, "x", "mm"),
    "force of a contact": (touched, 0, "y", "N"),
    "deviation of a circle": (round_about, 1, "y", "mm"),
}


@pytest.mark.parametrize("name", UNITS)
def test_units_suit_the_largest_signal(name):
    draw, panel, side, unit = UNITS[name]
    labels = [
        getattr(draw(*sizes)[panel], f"get_{side}label")()
        for sizes in ((1.0, 1e-3), (1e-3, 1.0), (1e-3, 1e-3))
    ]
    assert [label.partition(" [")[2] for label in labels] == [
        f"{unit}]",
        f"{unit}]",
        f"{SMALLER[unit]}]",
    ]

"""Force over position of several models: titles by what was found, letters at turns, loops upon loops."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.report.figures.gallery import lines
from tests.report.figures.test_figures import assert_legible
from tests.simulation.certificates.ballscrew import UM, composite, lugre, maxwell_slip

from bristle import figures, hysteresis
from bristle.core.errors import InputError
from bristle.engine.path import after
from bristle.report.figures import preisach, small_multiples
from bristle.simulation.certificates import Path, check, traced

X = np.linspace(0.0, 2e-6, 21)
UP = np.concatenate([X, X[::-1]])
FORCE = np.concatenate([4.0 * X / 2e-6, 4.0 * X[::-1] / 2e-6])
TRACES = {"a": (UP, FORCE), "b": (UP, 2.0 * FORCE)}


def titles(figure):
    return [axes.get_title(loc="right") for axes in figure.axes]


def test_forces_have_the_same_unit_and_a_margin():
    units = small_multiples.loop_units(
        [(X, -4.0 * X / 2e-6), (X, 1e-3 + X)], "translational", "rotational"
    )
    assert (units.x, units.y) == ("Position [µm]", "Friction torque [N·m]")
    assert units.height([(X, np.array([-4.0, 1.0])), (X, np.array([0.0, 6.0]))]) == pytest.approx(
        (-4.5, 6.5)
    )
    assert units.height([(X, np.array([-4.0, 6.0]))], 0.1) == pytest.approx((-5.0, 7.0))
    axes = Figure().add_subplot()
    units.plot(axes, 2e-6, 3.0, "o")
    assert axes.get_lines()[0].get_data() == (pytest.approx([2.0]), pytest.approx([3.0]))


def test_panels_are_in_rows_of_three_with_numbers_at_the_first():
    figure = small_multiples.minor_loops(dict.fromkeys("abcd", (UP, FORCE)))
    assert titles(figure) == list("abcd")
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "Friction force [N]",
        "",
        "",
        "Friction force [N]",
    ]
    assert all(axes.get_ylim() == pytest.approx((-0.2, 4.2)) for axes in figure.axes)


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (2.1e-12, "0.0021 nm"),
        (1.9e-12, "no drift"),
        (-2.1e-12, "−0.0021 nm"),
        (0.0, "no drift"),
        (5e-7, "500 nm"),
    ],
)
def test_a_drift_below_a_millionth_of_the_way_is_zero(step, text):
    figure = small_multiples.drift({"a": (UP, FORCE)}, {"a": step})
    assert titles(figure) == [f"a: {text}"]
    assert figure.axes[0].get_xlim() == pytest.approx((-0.06, 2.06))
    assert lines(figure.axes[0])["first loading"].get_xdata().size == 21


@pytest.mark.parametrize(
    ("share", "text"), [(-0.307, "−30.7 %"), (4e-5, "closes"), (6e-5, "0.0 %"), (0.0, "closes")]
)
def test_a_loop_that_misses_less_than_a_hundredth_of_a_percent_closes(share, text):
    figure = small_multiples.closure({"a": (UP, FORCE)}, {"a": share})
    assert titles(figure) == [f"a: {text}"]
    drawn = lines(figure.axes[0])
    ends = [float(part[0]) for name in ("left", "returned") for part in drawn[name].get_data()]
    assert ends == pytest.approx([2.0, 4.0, 0.0, 0.0])


def letters(axes):
    return [(text.get_text(), text.get_ha()) for text in axes.texts]


def test_letters_of_turns_are_away_from_the_middle():
    figure = small_multiples.marked_path(
        TRACES, {"a": [0, 20, 41], "b": [0, 20, 41]}, "abc", {"a": "A", "b": "B"}
    )
    assert letters(figure.axes[0]) == [("a", "right"), ("b", "left"), ("c", "right")]
    blank = small_multiples.marked_path(
        TRACES, {"a": [0, 20, 41], "b": [0, 20, 41]}, "a a", {"a": "A", "b": "B"}
    ).axes[0]
    assert letters(blank) == [("a", "right")]  # the same letter at the same place is written once


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (2, 2), (3, 2), (4, 2)])
def test_marked_paths_are_in_rows_of_two(count, columns):
    traces, turns = (
        dict.fromkeys("abcd"[:count], (UP, FORCE)),
        {name: [0, 20, 41] for name in "abcd"[:count]},
    )
    figure = small_multiples.marked_path(traces, turns, "xyz", dict.fromkeys("abcd", ""))
    assert len({round(axes.get_position().x0, 6) for axes in figure.axes}) == columns
    assert [bool(axes.get_ylabel()) for axes in figure.axes] == [True, False, True, False][:count]


def test_a_letter_is_written_twice_if_the_points_are_apart():
    axes = Figure().add_subplot()
    axes.set_ylim(0.0, 100.0)
    small_multiples._write_letters(axes, np.zeros(4), np.array([10.0, 12.0, 14.0, 50.0]), "aaab")
    drawn = [(text.get_text(), text.xy[1], text.xyann) for text in axes.texts]
    assert drawn == [("a", 10.0, (5, 2)), ("a", 14.0, (5, -9)), ("b", 50.0, (5, 2))]
    left = Figure().add_subplot()
    small_multiples._write_letters(left, np.array([0.0, 2.0]), np.array([0.1, 0.9]), "xy")
    assert [text.xyann for text in left.texts] == [(-5, -9), (5, 2)]


def test_a_family_of_loops_has_the_same_name_and_lies_in_the_same_height():
    loops = [(UP, FORCE), (UP, 2.0 * FORCE)]
    figure = small_multiples.loop_family(
        {"A": {"one": loops, "two": loops[:1]}, "B": {"two": loops}}
    )
    widths = [[line.get_linewidth() for line in axes.get_lines()] for axes in figure.axes]
    assert widths == [[2.2, 2.2, 0.9], [0.9, 0.9]]
    assert [axes.get_ylim() for axes in figure.axes] == [pytest.approx((-0.4, 8.4))] * 2
    alone = small_multiples.loop_family({"A": {"one": loops}})
    assert [alone.axes[0].get_legend(), *alone.legends] == [None]
    assert alone.get_size_inches()[1] == pytest.approx(3.5)


def test_break_away_is_marked_where_the_largest_force_is_nearly_reached():
    figure = small_multiples.break_away(
        {"a": (X, 4.0 * X / 2e-6), "b": (X, X)}, {"a": 1e-6, "b": np.nan}, 1.5e-6
    )
    (axes,) = figure.axes
    drawn = lines(axes)
    assert drawn["the paper"].get_xdata()[0] == pytest.approx(1.5)
    assert drawn["_a, reached"].get_data() == (pytest.approx([1.0]), pytest.approx([2.0]))
    assert "_b, reached" not in drawn


@pytest.mark.parametrize(
    ("count", "height"), [(1, 1.6 + 2.2 + 0.4), (2, 1.6 + 2.2 + 0.4), (3, 1.6 + 4.4 + 0.4)]
)
def test_a_ripple_is_above_a_panel_for_each_contact(count, height):
    traces = dict.fromkeys("abc"[:count], (UP, FORCE))
    time = np.linspace(0.0, 0.2, 42)
    figure = small_multiples.ripple(
        time, FORCE, traces, 20, {name: name.upper() for name in traces}
    )
    _, *below = figure.axes
    assert figure.get_size_inches()[1] == pytest.approx(height)
    assert [axes.get_ylabel() for axes in below] == [
        "Friction force [N]",
        "",
        "Friction force [N]",
    ][:count]
    assert all(axes.get_ylim() == pytest.approx((-0.2, 4.2)) for axes in below)


# --- Figures of friction with memory: drift, closure, and loops side by side


MODELS = {
    "LuGre": lugre(),
    "as printed": composite("paper"),
    "gate": composite(),
    "Maxwell slip": maxwell_slip(),
}
RIPPLE, LOOP = (0.04, 0.08), (3 * UM, 1.5 * UM)


@pytest.fixture(scope="module")
def result():
    return {name: check(model, force_ripple=RIPPLE, loop=LOOP) for name, model in MODELS.items()}


def drift_of(result):
    traces = {
        name: traced(model, Path.to_force, [RIPPLE[1], *(RIPPLE * 4)])
        for name, model in MODELS.items()
    }
    return figures.drift(
        traces, {name: item["drift"].value for name, item in result.items()}, "rotational"
    )


def closure_of(result):
    traces = {
        name: traced(model, Path.to_position, [*LOOP, LOOP[0]]) for name, model in MODELS.items()
    }
    return figures.closure(
        traces, {name: item["closure"].value for name, item in result.items()}, "rotational"
    )


def loops_of(result):
    turns = [5 * UM, -5 * UM, UM, -2 * UM, UM, 5 * UM]
    return figures.minor_loops(
        {name: traced(m, Path.to_position, turns) for name, m in MODELS.items()}, "rotational"
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("draw", [drift_of, closure_of, loops_of])
def test_every_model_has_a_legible_panel_of_one_scale(draw, result):
    figure = draw(result)
    assert_legible(figure)
    assert len(figure.axes) == len(MODELS)
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    for axes in figure.axes:
        assert re.fullmatch(r"Angle \[[µm]?rad\]", axes.get_xlabel())
    assert "torque [mN·m]" in figure.axes[0].get_ylabel()


def test_drawn_cycles_drift_as_far_as_the_certificate_states(result):
    x, force = traced(MODELS["LuGre"], Path.to_force, [RIPPLE[1], *(RIPPLE * 4)])
    tops = x[np.isclose(force, RIPPLE[1], rtol=1e-9)]
    assert np.diff(tops)[-1] == pytest.approx(result["LuGre"]["drift"].value, rel=1e-6)


def test_the_drawn_loop_misses_the_force_of_the_certificate(result):
    x, force = traced(MODELS["LuGre"], Path.to_position, [*LOOP, LOOP[0]])
    first, last = force[x == LOOP[0]]
    assert (last - first) / 0.13 == pytest.approx(result["LuGre"]["closure"].value, rel=1e-9)


# --- Figures of hysteresis operators: what they show, legible and with units


SIZES = {"translational": {"s": 1.25e7, "f_p": 150.0}, "rotational": {"s": 100.0, "f_p": 0.15}}
EXTENT = {"translational": 5e-5, "rotational": 6e-3}
HISTORY = (0.9, -0.6, 0.5, -0.1, 0.3)


@pytest.mark.parametrize("kind", SIZES)
def test_figures_of_operators_are_legible_and_named_for_their_axis(kind):
    exact = hysteresis.preisach(kernel="reformed_dahl_exact", kind=kind, **SIZES[kind])
    figure = figures.preisach_plane(exact, EXTENT[kind] * np.array(HISTORY))
    assert_legible(figure)
    words = " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in figure.axes)
    foreign = r"\[[kmµ]?N\]|\[[mµn]?m\]|Force" if kind == "rotational" else r"rad|N·m|torque"
    assert not re.search(foreign, words, re.IGNORECASE)
    assert all(re.search(r"\[[^\]]+\]$", ax.get_xlabel()) for ax in figure.axes)


@pytest.mark.parametrize("history", [HISTORY, (0.7,), (-0.7,), (0.8, -0.3), (-0.9, 0.4, -0.2, 0.1)])
def test_below_the_staircase_are_the_relays_that_are_up(history):
    operator = hysteresis.preisach(s=1.0, f_p=1.0)
    grid = hysteresis.relays_of(operator, 1.0, 40)
    _, relays = after(grid, history)
    state, memory = after(operator, history)
    beta, alpha = preisach.staircase(memory[: state.depth], state.z).T
    cells = 0.5 * (grid.parameters.levels[1:] + grid.parameters.levels[:-1])
    for i, j, relay in zip(*np.tril_indices(40), relays, strict=True):
        if relay and abs(cells[i] + cells[j]) > 1e-9:
            # The line falls from the left: at a threshold beta its height is that of the corner before it.
            height = (
                -cells[j]
                if cells[j] < beta[0]
                else float(alpha[np.searchsorted(beta, cells[j], "right") - 1])
            )
            assert relay == (1.0 if cells[i] < height else -1.0)


@pytest.mark.parametrize(
    ("operator", "history", "words"),
    [
        (hysteresis.play(r=1.0), [1.0], "has no turning points"),
        (hysteresis.preisach(s=1.0, f_p=1.0), [], "is empty"),
    ],
)
def test_an_operator_without_turning_points_has_no_plane(operator, history, words):
    with pytest.raises(InputError, match=words):
        figures.preisach_plane(operator, history)

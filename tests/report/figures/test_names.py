"""Names as people choose them: every figure takes them, shows them as they are, and has room for them."""

import csv
import io
import re
from collections import defaultdict
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from tests.report.figures.gallery import LONG, NAMES, PLAIN, figure_of, gallery
from tests.report.figures.test_figures import assert_legible

from bristle import figures
from bristle.report.figures import as_csv, numbers_of, style
from bristle.report.figures.drawing import (
    GREY,
    INK,
    one_line,
    printable,
    shortened,
    shortened_apart,
    width,
)

# Figures in which no name stands that a person chose.
NAMELESS = {
    "change_at_reversal",
    "changes",
    "comparison",
    "curve_errors",
    "effort_at_reversal",
    "effort_over_time",
    "effort_over_velocity",
    "expected",
    "fleet_parameter",
    "friction_after_reversals",
    "friction_over_speed",
    "friction_over_velocity",
    "gain_at_reversal",
    "log_over_time",
    "loops_of_log",
    "margins",
    "motion",
    "passages",
    "prediction",
    "prediction_error",
    "preisach_plane",
    "preisach_stages",
    "recorded_curves",
    "residuals",
    "rig_layout",
}
# Every way in which a name gets into a figure: axes of two kinds, legends of three, titles with and without a number.
WAYS = ("closure", "errors_by_loop", "following_error", "loop_family", "tracking")
FORBIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def letters(svg):
    return "".join(ElementTree.fromstring(svg).itertext())


def named(names, many=None):
    """The figures in which names stand."""
    return {name: draw for name, draw in gallery(names, many).items() if name not in NAMELESS}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "only"),
    [(NAMES[:2], None), (NAMES[2:7], WAYS), (NAMES[7:12], WAYS), (NAMES[12:], WAYS)],
    ids=["marks", "empty", "foreign", "odd"],
)
def test_every_figure_takes_every_name(names, only):
    draws = named(names)
    for name in only or draws:
        svg = figures.inline_svg(draws[name](), "a", names[0])
        tree = ElementTree.fromstring(svg)
        assert {item.tag for item in tree.iter()} <= {
            "svg",
            "defs",
            "style",
            "g",
            "path",
            "text",
            "use",
            "clipPath",
            "rect",
            "pattern",
        }, name
        assert FORBIDDEN.search(svg) is None, name
        # The names of the lines stand in `data-panels` as written.
        used = set(
            re.findall(
                r'<[^>]*(?:href="#|url\(#)([^")]+)', re.sub(r' data-panels="[^"]*"', "", svg)
            )
        )
        assert used <= {item.get("id") for item in tree.iter()}, name


@pytest.mark.parametrize(
    "name",
    [
        name if name in WAYS else pytest.param(name, marks=pytest.mark.slow)
        for name in named(NAMES[:2])
    ],
)
def test_a_name_appears_in_its_figure_as_written(name):
    short = ('<b d="1.23456"', "_$x_1^2$ 5%")
    text = letters(figures.inline_svg(gallery(short)[name](), "a", ""))
    assert all(item in text for item in short)


MIXED = ["<b>&amp;", "short", f"{LONG}_2", "_c", "W" * 50]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "many", "ways"),
    [
        pytest.param((f"{LONG}_1", f"{LONG}_2"), None, None, marks=pytest.mark.slow),
        pytest.param(MIXED[:3], MIXED, None, marks=pytest.mark.slow),
        (MIXED[:3], MIXED, WAYS),
    ],
    ids=["long", "mixed", "mixed, some figures"],
)
def test_names_of_any_length_neither_overlap_nor_leave_the_figure(names, many, ways):
    for name, draw in named(names, many).items():
        if ways is None or name in ways:
            assert_legible(draw())


def test_a_long_name_is_cut_visibly_and_a_number_after_it_is_kept():
    draws = gallery([f"{LONG}_{k}" for k in range(5)])
    for name, behind in (("closure", "−30.0 %"), ("marked_path", "0.5 µm")):
        titles = [
            item for item in (axes.get_title(loc="right") for axes in draws[name]().axes) if item
        ]
        assert len(titles) == 5
        for number, title in enumerate(titles):
            assert re.fullmatch(rf"a.*….*{number}: {re.escape(behind)}", title)


@pytest.mark.parametrize("name", [LONG, "שם " * 40, "轴的名称" * 30, "W" * 200, "x" * 100_000])
@pytest.mark.parametrize("room", [0.3, 1.0, 3.0])
def test_a_name_is_as_long_as_there_is_room(name, room):
    text = shortened(name, room)
    assert "…" in text
    assert width(text, 8.5) <= room < width(text, 8.5) + 0.35


def test_names_with_the_same_short_form_are_numbered():
    names = [f"{LONG}{k}{LONG}" for k in range(3)] + ["short", "short"]
    result = shortened_apart(names, 1.5)
    assert len(set(result)) == 4
    assert [item[-4:] for item in result[1:3]] == [" (2)", " (3)"]
    assert max(width(item, 8.5) for item in result) <= 1.5


def test_characters_forbidden_in_a_page_are_marked():
    assert printable("a\x00\x1f\ud800\ufffe\U0010ffff\u202eb\tc\n") == "a" + 6 * "�" + "b\tc\n"
    assert one_line(" a\n\x0b\u2028 b ") == "a b"


def test_a_number_after_a_right_to_left_name_stays_after_it():
    mark = "\u200e"
    assert one_line("שלום") == f"שלום{mark}"
    assert one_line("שלום 12") == f"שלום{mark} 12"
    assert one_line(f"שלום{mark}: 3") == f"שלום{mark}: 3"


@style.styled
def labelled(text):
    figure, ((axes,),) = style.panels(2.0)
    axes.set_xlabel(text)
    return figure


def test_forbidden_characters_are_also_marked_while_drawing():
    svg = figures.inline_svg(labelled("a\x00b\ud800c"), "a", "\x01")
    assert FORBIDDEN.search(svg) is None
    assert "a�b�c" in letters(svg)


@pytest.mark.slow
def test_many_loops_have_a_legend_above_all_panels():
    names = [f"variant number {k}" for k in range(11)]
    assert_legible(gallery(names[:2], names)["following_error"]())


# --- What a figure draws is read back, all of it and nothing else, in the units of its axes, named as in its legend


def rows_of(panel):
    """The lines of the file of a panel, by column."""
    return list(csv.DictReader(io.StringIO(as_csv(panel))))


def read(figure):
    """The heads of the only panel, and for each series and mark the points of its strokes, as a file tells them."""
    (panel,) = numbers_of(figure)
    head, *lines = csv.reader(io.StringIO(as_csv(panel)))
    result = {}
    for _, series, mark, stroke, *cells in lines:
        result.setdefault((series, mark), {}).setdefault(stroke, []).append(
            [float(cell) for cell in cells[:2]]
        )
    return head, {name: list(strokes.values()) for name, strokes in result.items()}


@pytest.fixture
def axes():
    return Figure().add_subplot()


@pytest.mark.fast_cases(20)
@pytest.mark.parametrize("name", sorted(set(gallery()) - {"rig_layout"}))
def test_every_point_that_a_figure_plots_is_in_its_numbers_under_a_head_and_a_name(
    name, monkeypatch
):
    plotted, plot = defaultdict(set), Axes.plot

    def noting(axes, *values, **how):
        x, y = (np.atleast_1d(side).astype(float) for side in values[:2])
        plotted[axes] |= {
            (f"{a:.12g}", f"{b:.12g}") for a, b in np.broadcast(x, y) if np.isfinite(a + b)
        }
        return plot(axes, *values, **how)

    monkeypatch.setattr(Axes, "plot", noting)
    figure = gallery()[name]()
    drawn = [axes for axes in figure.axes if axes.lines or axes.collections or axes.patches]
    for axes, panel in zip(drawn, numbers_of(figure), strict=True):
        assert plotted[axes] <= {
            tuple(line[4:6]) for line in csv.reader(io.StringIO(as_csv(panel)))
        }
        assert len({panel.x, panel.y, "", "x", "y"}) == 5
        assert all(series.strip("_ ") and item.strokes for series, item in panel.drawn)


def test_places_of_a_diagram_are_no_numbers():
    assert numbers_of(figure_of("rig_layout")) == []


def test_panels_without_numbers_at_an_axis_share_those_of_their_neighbour():
    assert [panel.y for panel in numbers_of(figure_of("loop_family"))] == ["Friction force [N]"] * 2
    assert [panel.x for panel in numbers_of(figure_of("margins"))[::2]] == ["Frequency [Hz]"] * 2


def test_a_panel_of_another_quantity_keeps_its_head():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    for item in (left, right):
        item.plot([1.0, 2.0], [1.0, 2.0])
    left.set_ylabel("Force [N]")
    assert [item.y for item in numbers_of(figure)] == ["Force [N]", "y"]


def test_names_are_those_of_the_legend_at_any_place():
    for panel in numbers_of(figure_of("following_error"))[1:]:
        assert [series for series, item in panel.drawn if item.mark != "area"] == list(PLAIN)
    _, poles, _ = numbers_of(figure_of("margins"))
    assert [name for name, item in poles.drawn if item.mark == "points"] == [
        "small motions",
        "large motions",
    ]


def test_a_colour_of_another_panel_gives_no_name():
    over_time, spread, _ = numbers_of(figure_of("residuals"))
    assert [[name for name, _ in panel.drawn] for panel in (over_time, spread)] == [
        ["Residual"],
        ["normal", "residual"],
    ]


def test_a_series_is_named_by_its_hidden_label(axes):
    axes.plot([0.0, 1.0], [0.0, 1.0], color="#aa0000", label="rig")
    axes.plot(1.0, 1.0, "o", color="#aa0000", label="_reached")
    axes.vlines([0.2, 0.4], 0.0, 1.0, color="#aa0000")
    axes.plot([0.0, 1.0], [1.0, 0.0], color="#aa0000", label="rig")
    assert sorted(name for name, _ in numbers_of(axes.figure)[0].drawn) == [
        "reached",
        "rig",
        "rig",
        "y",
    ]


def test_things_without_a_label_are_counted(axes):
    axes.axvline(1.0, color=GREY, linestyle=":", label="the paper")
    axes.axhline(0.0, color=GREY)
    axes.plot([0.0, 1.0], [0.0, 1.0], color=INK, linewidth=3.0)
    axes.plot([0.0, 1.0], [0.0, 2.0], color=INK, linewidth=4.0)
    assert [name for name, _ in numbers_of(axes.figure)[0].drawn] == [
        "the paper",
        "line 1",
        "line 2",
        "line 3",
    ]


def test_logarithmic_axes_have_the_numbers_themselves(axes):
    axes.loglog([1.0, 100.0, 1e4], [0.01, 10.0, 1e6], label="a")
    axes.set_xlim(1.0, 1e5)
    axes.axhline(10.0, label="level")
    _, result = read(axes.figure)
    assert result["a", "line"] == [[[1.0, 0.01], [100.0, 10.0], [1e4, 1e6]]]
    assert result["level", "line"][0] == [pytest.approx([1.0, 10.0]), pytest.approx([1e5, 10.0])]


def test_gaps_divide_a_line(axes):
    axes.plot([0.0, 1.0, 2.0, 3.0, 4.0], [5.0, np.nan, 7.0, 8.0, np.nan], label="a")
    axes.plot([0.0, 1.0, 2.0], [1.0, np.nan, 3.0], "o", label="b")
    _, result = read(axes.figure)
    assert result["a", "line"] == [[[0.0, 5.0]], [[2.0, 7.0], [3.0, 8.0]]]
    assert result["b", "points"] == [[[0.0, 1.0], [2.0, 3.0]]]


def test_bars_are_read_at_their_ends_with_their_names(axes):
    axes.bar([0, 1], [3.0, 5.0], width=0.4, label="up")
    axes.set_xticks([0, 1], ["first", "second"])
    _, result = read(axes.figure)
    assert result == {("up", "bars"): [[[0.0, 3.0], [1.0, 5.0]]]}
    assert [item["name at x"] for item in rows_of(numbers_of(axes.figure)[0])] == [
        "first",
        "second",
    ]


def test_horizontal_bars_have_the_name_of_their_row(axes):
    axes.barh([-0.2, 0.8], [3.0, 5.0], height=0.3, label="a")
    axes.set_yticks([0, 1], ["first", "second"])
    assert [(item["x"], item["name at y"]) for item in rows_of(numbers_of(axes.figure)[0])] == [
        ("3", "first"),
        ("5", "second"),
    ]


def test_ticks_with_numbers_are_no_names(axes):
    axes.plot([1.0, 10.0], [1.0, 2.0])
    axes.set_xticks([1.0, 10.0], ["1", "−10"])
    assert "name at x" not in as_csv(numbers_of(axes.figure)[0])


def test_areas_and_steps(axes):
    axes.fill_between([0.0, 1.0], [2.0, 3.0], [4.0, 5.0], label="band")
    axes.stairs([1.0, 3.0], [0.0, 0.5, 1.0], label="shares")
    axes.axvspan(0.25, 0.75, label="window")
    axes.set_ylim(0.0, 8.0)
    _, result = read(axes.figure)
    (band,) = result["band", "area"]
    assert {(0.0, 2.0), (1.0, 3.0), (1.0, 5.0), (0.0, 4.0)} <= {tuple(share) for share in band}
    (shares,) = result["shares", "steps"]
    assert {(0.0, 1.0), (0.5, 1.0), (0.5, 3.0), (1.0, 3.0)} <= {tuple(share) for share in shares}
    (window,) = result["window", "area"]
    assert {(x, round(y, 9)) for x, y in window} == {
        (0.25, 0.0),
        (0.75, 0.0),
        (0.75, 8.0),
        (0.25, 8.0),
    }


def test_contours_and_cells_are_no_areas(axes):
    axes.contour(np.arange(9.0).reshape(3, 3))
    axes.pcolormesh([0.0, 1.0, 2.0], [0.0, 2.0], [[5.0, 6.0]])
    assert numbers_of(axes.figure) == []


@pytest.mark.parametrize("name", ["errors_by_truth", "break_away"])
def test_marks_of_several_series_have_the_names_of_their_series(name):
    marks = {
        series
        for panel in numbers_of(figure_of(name))
        for series, item in panel.drawn
        if item.mark == "points"
    }
    assert marks
    assert not marks & {"loop", "reached"}


def test_marks_placed_relative_to_the_panel_are_not_numbers(axes):
    axes.plot([0.0, 1.0], [0.0, 1.0], transform=axes.transAxes)
    axes.add_patch(Rectangle((0.1, 0.1), 0.2, 0.2, transform=axes.transAxes))
    axes.add_patch(FancyArrowPatch((0.0, 0.0), (1.0, 1.0)))
    axes.plot([0.0, 1.0], [0.0, 1.0], visible=False)
    axes.imshow(np.zeros((2, 2, 3)))  # a photograph
    assert numbers_of(axes.figure) == []


def test_round_edges_are_cut_into_straight_ones(axes):
    axes.add_patch(Circle((0.0, 0.0), 100.0, label="round"))
    _, result = read(axes.figure)
    (edge,) = result["round", "area"]
    assert np.hypot(*np.transpose(edge)) == pytest.approx(100.0, rel=1e-3)


def test_columns_with_the_same_head_are_distinguished(axes):
    axes.plot([0.0, 1.0], [0.0, 1.0])
    axes.set_xlabel("Position [mm]")
    axes.set_ylabel("Position [mm]")
    assert read(axes.figure)[0][4:] == ["x: Position [mm]", "y: Position [mm]"]


def test_digits_are_enough_to_draw_it_again(axes):
    x = 1e3 + 1e-7 * np.arange(5)
    axes.plot(x, np.pi * 1e-9 * x, label="a")
    _, result = read(axes.figure)
    points = np.array(result["a", "line"][0])
    assert points == pytest.approx(np.column_stack([x, np.pi * 1e-9 * x]), rel=1e-11)
    assert len(np.unique(points[:, 0])) == 5


def test_any_name_stays_in_its_cell():
    for panel in numbers_of(gallery((NAMES[1], NAMES[7]))["errors_by_loop"]()):
        head, *lines = csv.reader(io.StringIO(as_csv(panel)))
        assert {len(line) for line in lines} == {len(head)}

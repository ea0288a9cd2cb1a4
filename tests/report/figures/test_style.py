"""The common look of figures: words and units of axes, panels to the inch, titles and legends that have room."""

import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.transforms import IdentityTransform

from bristle.report.figures import drawing, files, style
from bristle.report.figures.legibility import illegible_texts, texts_of, unlabelled_axes


@pytest.fixture(autouse=True)
def common_look():
    with drawing.own_settings():
        yield


def inches(axes):
    """Left, right, lower and upper edge of a panel, from the edges of its figure [inch]."""
    wide, tall = axes.figure.get_size_inches()
    box = axes.get_position()
    return tuple(
        round(float(edge), 9)
        for edge in (box.x0 * wide, (1.0 - box.x1) * wide, box.y0 * tall, (1.0 - box.y1) * tall)
    )


def of_arrays(function):
    """Return the function for lists, which gives lists."""

    def called(*given):
        found = function(
            *(np.array(item, dtype=float) if isinstance(item, list) else item for item in given)
        )
        return found.tolist() if isinstance(found, np.ndarray) else found

    return called


LARGEST, ENVELOPE, RUNS, SPREAD, SHARES, WINDOW = map(
    of_arrays, (style.largest, style.envelope, style.runs, style.spread, style.shares, style.window)
)


@pytest.mark.parametrize(
    ("told", "given", "result"),
    [
        # Words for effort and position depend on the kind of axis.
        (style.effort_word, ("translational",), "Force"),
        (style.position_word, ("translational",), "Position"),
        (style.effort_word, ("rotational",), "Torque"),
        (style.position_word, ("rotational",), "Angle"),
        (style.effort_word, ("magnetic",), "Moment"),
        (style.position_word, ("magnetic",), "Field"),
        (style.effort_word, ("piezo",), "Displacement"),
        (style.position_word, ("piezo",), "Voltage"),
        # The largest of signals ignores infinities.
        (LARGEST, ([1.0, -3.0], [np.nan, np.inf, 2.0]), 3.0),
        (LARGEST, (), 0.0),
        (LARGEST, ([np.nan],), 0.0),
        (LARGEST, ([],), 0.0),
        # A column keeps the ends and the extremes.
        (ENVELOPE, ([0.0] * 8, 2), list(range(8))),
        (
            ENVELOPE,
            ([0.0, 5.0, 1.0, -4.0, 2.0, 0.0, 1.0, 2.0, 3.0, 4.0, 9.0], 2),
            [0, 1, 3, 5, 6, 10],
        ),
        # A single sample is a stretch.
        (RUNS, ([0.0], [0.0]), [slice(0, 1)]),
        (RUNS, ([0.0, 1.0, 2.0], [1.0, np.nan, 2.0]), [slice(0, 1), slice(2, 3)]),
        (RUNS, ([0.0, np.nan, 2.0], [0.0] * 3), [slice(0, 1), slice(2, 3)]),
        (RUNS, ([0.0, 1.0, 2.0], [np.nan, np.inf, np.nan]), []),
        # A cloud has a point in each cell.
        (SPREAD, ([], [], (9, 9)), []),
        (SPREAD, ([1.0] * 3, [1.0] * 3, (9, 9)), [0]),
        (SPREAD, ([0.0, 1.0, 2.0, 3.0], [0.0] * 4, (2, 1)), [0, 2, 3]),
        (
            SPREAD,
            ([0.0, 0.0, 0.0, 1.0, 1.0, 1.0], [0.0, 0.5, 1.0, 0.5, 0.0, 1.0], (2, 3)),
            list(range(6)),
        ),
        # Shares are percent of all values.
        (SHARES, ([1.0, 2.0, 3.0, 9.0], [0.0, 2.5, 5.0]), [50.0, 25.0]),
        (SHARES, ([], [0.0, 1.0]), [0.0]),
        # A window of a short log is all of the log.
        (WINDOW, ([float(k) for k in range(30)], [0.0] * 30), slice(0, 30)),
    ],
)
def test_signals_are_drawn_by_what_of_them_can_be_seen(told, given, result):
    assert told(*given) == result


def test_a_common_multiple_of_the_unit_suits_all_signals():
    scale = style.scale_for("length", "translational", np.array([1e-7]), np.array([-2e-6]))
    assert (scale.unit, scale.factor) == ("µm", pytest.approx(1e6))
    scale, word = style.effort_scale("rotational", np.array([5e-3]))
    assert (scale.unit, word) == ("mN·m", "Torque")


@pytest.mark.parametrize(
    ("end", "unit", "factor"),
    [(3.0, "s", 1.0), (0.5, "s", 1.0), (0.49, "ms", 1e3), (2e-4, "µs", 1e6)],
)
def test_time_is_in_milliseconds_below_half_a_second(end, unit, factor):
    scale = style.time_scale(np.array([0.0, end]))
    assert (scale.unit, scale.factor) == (unit, pytest.approx(factor))


def test_a_signal_of_four_samples_a_column_is_drawn_whole():
    assert style.envelope(np.zeros(4 * 480)).size == 4 * 480
    assert style.envelope(np.zeros(4 * 480 + 1)).size < 2 * 480


@pytest.mark.parametrize(("step", "parts"), [(1.4, 1), (1.6, 2)])
def test_a_step_of_more_than_half_above_the_usual_is_a_gap(step, parts):
    x = np.array([0.0, 1.0, 2.0, 2.0 + step, 3.0 + step, 4.0 + step])
    assert len(style.runs(x, x)) == parts


def test_stretches_of_equal_length_have_the_same_share_of_the_width():
    t = np.concatenate([np.arange(4000.0), 9000.0 + np.arange(4000.0)])
    x, _ = style.line(t, np.random.default_rng(1).normal(size=8000))
    first, second = np.count_nonzero(x < 5000.0), np.count_nonzero(x > 5000.0)
    assert 0.8 * 960 < first <= 960
    assert second == pytest.approx(first, rel=0.05)
    assert [side.size for side in style.line(t, np.full(8000, np.nan))] == [0, 0]


def test_the_grid_of_a_cloud_is_240_by_120_wherever_it_lies():
    x, y = (side.ravel() for side in np.meshgrid(np.arange(480.0), np.arange(240.0)))
    assert 240 * 120 <= style.spread(x, y).size <= 240 * 120 + 4
    cloud = np.random.default_rng(2).normal(size=(2, 500))
    assert (
        style.spread(*cloud, (8, 6)).tolist()
        == style.spread(cloud[0] + 90.0, cloud[1] - 40.0, (8, 6)).tolist()
    )


def test_lines_differ_in_lightness_or_dashes_and_series_in_marks():
    light, dark = (
        np.dot(to_rgb(look["color"]), (0.299, 0.587, 0.114))
        for look in (style.MEASURED, style.PREDICTED)
    )
    assert light > 2.0 * dark
    assert style.MEASURED["linewidth"] > 2.0 * style.PREDICTED["linewidth"]
    assert len({look["linestyle"] for look in style.LINES[1:]}) == 4
    assert [look["marker"] for look in style.SERIES] == list("os^Dv")
    assert [look["color"] for look in style.SERIES] == [look["color"] for look in style.LINES]


@pytest.mark.parametrize(
    ("names", "over", "lines"),
    [((), True, 0), (("a",), False, 0), (("a",), True, 1), (["n" * 40] * 8, False, 2)],
)
def test_room_is_made_for_the_lines_of_a_legend(names, over, lines):
    figure, ((axes,),) = style.panels(3.0, names=names, over_titles=over)
    assert figure.get_size_inches()[1] == pytest.approx(3.0 + 0.18 * lines)
    assert inches(axes)[3] == pytest.approx(0.32 + 0.18 * lines)
    assert figure.has_room_above == (lines > 0)


@pytest.mark.parametrize(("count", "rows", "columns"), [(1, 1, 1), (2, 1, 2), (3, 2, 2), (5, 3, 2)])
def test_a_grid_has_the_given_number_of_panels(count, rows, columns):
    figure, axes = style.grid_of(count)
    assert figure.axes == axes
    assert figure.get_size_inches()[1] == pytest.approx(0.32 + 2.2 * rows)
    assert len({round(item.get_position().x0, 6) for item in axes}) == columns
    assert [item.get_position().y0 for item in axes] == sorted(
        (item.get_position().y0 for item in axes), reverse=True
    )
    assert style.grid_of(count, top=0.5)[0].get_size_inches()[1] == pytest.approx(0.5 + 2.2 * rows)


@pytest.mark.parametrize(
    ("name", "left"), [("a", 1.0), ("i" * 18, 0.45 + 18 * 0.085), ("W" * 90, 0.45 + 2.4)]
)
def test_names_of_rows_have_room_up_to_the_longest(name, left):
    figure, (axes,) = style.named_rows([name])
    assert left - 0.15 < inches(axes)[0] <= left + 1e-9
    axes.set(xlabel="Error [m]")
    assert illegible_texts(figure) == []


def test_names_of_rows_are_cut_if_room_is_short_and_may_be_none():
    assert 1.9 < inches(style.named_rows(["W" * 90], longest=1.6)[1][0])[0] <= 0.45 + 1.6
    assert inches(style.named_rows([])[1][0])[0] == pytest.approx(1.0)


def test_a_title_is_cut_to_the_panel_and_keeps_the_number_after_the_name():
    _, ((axes, _),) = style.panels(3.0, columns=2)
    available, name = 7.2 * axes.get_position().width, "W" * 60
    whole = []
    for beside in (0.0, 1.0):
        style.title(axes, f"{name}: 5 %", name, beside)
        text = axes.get_title(loc="right")
        assert text.endswith(": 5 %")
        assert drawing.width(text, 8.5) <= available - beside < drawing.width(text, 8.5) + 0.3
        whole.append(text)
    assert len(whole[1]) < len(whole[0])
    style.title(axes, f"of {name}", name)
    assert re.match("of W+…", axes.get_title(loc="right"))
    style.title(axes, name)
    assert drawing.width(axes.get_title(loc="right"), 8.5) > available - 0.3
    style.title(axes, "short", "short")
    assert axes.get_title(loc="right") == "short"


def test_no_line_joins_the_two_sides_of_rest():
    _, ((axes,),) = style.panels(3.0)
    points = np.array([[-2.0, -5.0], [-0.0, 4.0], [0.0, -4.0], [2.0, 5.0]])
    for drawn, name in ((points, "model"), (points[2:], "forward")):
        style.plot_by_side(axes, drawn, name, style.DASHED)
    lines = [(line.get_label(), line.get_ydata().tolist()) for line in axes.get_lines()]
    assert lines == [("model", [-4.0, 5.0]), ("_same", [-5.0, 4.0]), ("forward", [-4.0, 5.0])]


def named(*names, **layout):
    figure, row = style.panels(3.0, names=names, **layout)
    for name in names:
        row[0][-1].plot([0.0, 1.0], [0.0, 1.0], label=name)
    return figure, row[0][-1]


def test_a_panel_without_names_has_no_legend():
    figure, axes = named()
    style.legend(axes)
    assert [axes.get_legend(), *figure.legends] == [None]


def test_a_legend_of_few_names_is_a_single_line_above_the_panel_from_the_left():
    figure, axes = named("measured", "predicted", "a third", "a fourth", "a fifth")
    style.legend(axes)
    assert axes.get_legend()._ncols == 5
    boxes = [box for text, box in texts_of(figure) if text.get_text() in ("measured", "a fifth")]
    assert all(box.y0 > axes.bbox.y1 for box in boxes)


@pytest.mark.parametrize(("letters", "columns"), [(3, 6), (10, 3), (20, 3), (26, 2), (40, 4)])
def test_names_that_fit_in_full_take_at_most_three_lines(letters, columns):
    _, axes = named(*("n" * letters + str(k) for k in range(6)))
    style.legend(axes)
    assert (axes.get_legend() or axes.figure.legends[0])._ncols == columns


def test_a_long_name_takes_the_room_that_short_names_leave():
    figure, axes = named("a", "W" * 200)
    style.legend(axes)
    texts = {
        text.get_text()[0]: box for text, box in texts_of(figure) if text.get_text()[0] in "aW"
    }
    assert texts["W"].width / figure.dpi > 4.5
    assert texts["W"].x1 < figure.bbox.x1


def test_two_long_names_share_the_room_of_a_legend():
    figure, axes = named("W" * 60, "V" * 60)
    style.legend(axes)
    first, second = (
        box.width / figure.dpi for text, box in texts_of(figure) if text.get_text()[0] in "WV"
    )
    assert first == pytest.approx(second, rel=0.1)
    assert 2.4 < first < 3.3
    assert illegible_texts(figure) == []


def test_a_legend_without_room_to_the_right_begins_further_left():
    figure, axes = named("the name of the first variant", "and that of another one", columns=3)
    style.legend(axes)
    boxes = [box for text, box in texts_of(figure) if text.get_text()[:3] in ("the", "and")]
    assert max(box.x1 for box in boxes) <= figure.bbox.x1
    assert min(box.x0 for box in boxes) < axes.bbox.x0
    assert max(box.x1 for box in boxes) > figure.bbox.x1 - 0.5 * figure.dpi


def test_a_legend_in_the_corner_returns_its_height():
    figure, axes = named("one", "two")
    reach = style.legend_in_corner(figure, axes)
    (legend,) = figure.legends
    assert legend._ncols == 2
    end = max(box.x1 for text, box in texts_of(figure) if text.get_text() in ("one", "two"))
    assert reach == pytest.approx((end - axes.bbox.x0) / figure.dpi, abs=0.35)
    assert reach > (end - axes.bbox.x0) / figure.dpi
    figure, axes = named("i", columns=3)
    assert style.legend_in_corner(figure, axes) == 0.0


@pytest.mark.parametrize("worst", [500, 0, 999])
def test_a_window_is_around_the_largest_error_and_within_the_log(worst):
    error = np.zeros(1000)
    error[worst] = -0.5
    error[[10, 20]] = np.nan, np.inf
    assert style.window(np.arange(2000.0), np.tile(error, 2)) == slice(
        max(worst - 30, 0), max(worst - 30, 0) + 60
    )
    assert style.window(np.arange(1000.0), error, 0.03) == slice(
        min(max(worst - 20, 0), 960), min(max(worst - 20, 0), 960) + 40
    )


def test_a_function_of_figures_draws_with_the_common_look():
    @style.styled
    def drawn(height, *, rows):
        """Words."""
        return style.panels(height, rows=rows)[0]

    assert isinstance(drawn(3.0, rows=1), files.Drawing)
    assert drawn.__doc__ == "Words."


# --- A long signal is drawn short, and nothing that a line of this width can show is lost


SIGNALS = arrays(float, st.integers(1, 600), elements=st.floats(-1e3, 1e3))


@given(y=SIGNALS, columns=st.integers(1, 40))
def test_extremes_and_ends_are_kept_exactly(y, columns):
    kept = style.envelope(y, columns)
    assert kept.size <= max(4 * columns, 1)
    assert np.all(np.diff(kept) > 0)
    assert (kept[0], kept[-1]) == (0, y.size - 1)
    assert (y[kept].min(), y[kept].max()) == (y.min(), y.max())


@pytest.mark.slow
@given(y=SIGNALS, columns=st.integers(1, 40))
def test_each_sample_lies_between_kept_samples_nearby(y, columns):
    kept = style.envelope(y, columns)
    reach = -(-y.size // columns)
    for k in range(y.size):
        near = y[kept[np.abs(kept - k) <= reach]]
        assert near.min() <= y[k] <= near.max()


@given(lengths=st.lists(st.integers(2, 50), min_size=1, max_size=5))
def test_a_line_breaks_only_at_gaps(lengths):
    starts = np.cumsum([0, *(1.0 + 0.01 * n for n in lengths[:-1])])
    t = np.concatenate(
        [start + 0.01 * np.arange(n) for start, n in zip(starts, lengths, strict=True)]
    )
    x, y = style.line(t, np.cos(t))
    assert np.isnan(y).sum() == len(lengths) - 1
    assert set(x[np.isfinite(x)]) <= set(t)
    assert [part.stop - part.start for part in style.runs(t, t)] == lengths


def test_short_stretches_do_not_make_a_long_stretch_coarse():
    lengths = [9000, *[5] * 60]
    starts = np.cumsum([0.0, *(2.0 + n for n in lengths[:-1])])
    t = np.concatenate([start + np.arange(n) for start, n in zip(starts, lengths, strict=True)])
    y = np.sin(0.05 * t)
    x, kept = style.line(t, y)
    long = np.isfinite(x) & (x < lengths[0])
    # Straight lines between what is drawn stay close to the signal.
    assert np.max(np.abs(np.interp(t[: lengths[0]], x[long], kept[long]) - y[: lengths[0]])) < 0.35
    assert x.size < 4 * 480 + 12 * len(lengths)


@settings(max_examples=50)
@given(
    points=arrays(float, st.tuples(st.just(2), st.integers(1, 400)), elements=st.floats(-10, 10))
)
def test_every_point_of_a_cloud_is_near_a_drawn_point(points):
    x, y = points
    cells = (12, 8)
    kept = style.spread(x, y, cells)
    assert kept.size <= 12 * 8 + 4
    cell = np.array([np.ptp(x) / cells[0], np.ptp(y) / cells[1]])
    apart = np.abs(points[:, :, None] - points[:, None, kept]) <= cell[:, None, None] + 1e-9
    assert apart.all(axis=0).any(axis=1).all()
    for ends in (x, y):
        assert (ends[kept].min(), ends[kept].max()) == (ends.min(), ends.max())


# --- What makes a figure illegible: axes without a name or a unit, texts on one another or outside of the page


@pytest.fixture
def axes():
    figure = Figure(figsize=(4.0, 3.0), dpi=100.0)
    panel = figure.add_axes((0.2, 0.2, 0.6, 0.6))
    panel.set(xlabel="Time [s]", ylabel="Force [N]")
    return panel


def at(figure, x, y, text="word", **how):
    """A text whose lower left corner is at these pixels."""
    return figure.text(x, y, text, transform=IdentityTransform(), ha="left", va="bottom", **how)


def box_of(text):
    figure = Figure(figsize=(4.0, 3.0), dpi=100.0)
    at(figure, 100.0, 100.0, text)
    ((_, box),) = texts_of(figure)
    return box


def test_axes_with_a_name_and_a_unit_pass(axes):
    assert unlabelled_axes(axes.figure) == []


@pytest.mark.parametrize("word", "xy")
def test_numbers_without_a_name_fail_and_a_bare_axis_passes(axes, word):
    axes.set(**{f"{word}label": ""})
    assert unlabelled_axes(axes.figure) == [f"an axis {word} has no label"]
    axes.tick_params(labelbottom=False, labelleft=False)
    assert unlabelled_axes(axes.figure) == []


@pytest.mark.parametrize("word", "xy")
def test_a_name_ends_with_its_unit_unless_the_axis_has_names(axes, word):
    axes.set(**{f"{word}label": "Share [%] of all"})
    assert unlabelled_axes(axes.figure) == [f"the axis {word}, 'Share [%] of all', has no unit"]
    getattr(axes, f"set_{word}ticks")([0.0, 1.0], ["first", "second"])
    assert unlabelled_axes(axes.figure) == []


@pytest.mark.parametrize("hide", [("set_axis_off",), ("set_visible", False)])
def test_hidden_panels_have_no_faults(axes, hide):
    axes.set(xlabel="", ylabel="")
    getattr(axes, hide[0])(*hide[1:])
    assert unlabelled_axes(axes.figure) == []


def test_exactly_the_visible_texts_of_a_figure_are_found(axes):
    figure = axes.figure
    axes.plot([0.0, 1.0], [0.0, 1.0], label="of the panel")
    axes.legend()
    figure.legend(*axes.get_legend_handles_labels(), loc="lower left").get_texts()[0].set_text(
        "of the page"
    )
    for place in ("left", "center", "right"):
        axes.set_title(place, loc=place)
    axes.text(0.5, 0.5, "inside")
    axes.text(0.5, 0.5, "hidden").set_visible(False)
    axes.text(0.5, 0.5, "")
    at(figure, 10.0, 10.0, "aside")
    axes.set_xticks([0.0, 0.1 + 0.2, 1.0], ["zero", "some", "beyond"])
    axes.set_xlim(0.3, 0.0)  # against the usual way, and a rounding below the tick
    axes.set_yticks([])
    named = {
        "of the panel",
        "of the page",
        "left",
        "center",
        "right",
        "inside",
        "aside",
        "zero",
        "some",
        "Time [s]",
        "Force [N]",
    }
    assert sorted(text.get_text() for text, _ in texts_of(figure)) == sorted(named)


@pytest.mark.parametrize("ticks", [[-0.5, 0.0, 0.5, 1.0], [0.0, 0.5, 1.0, 1.5]])
def test_ticks_beyond_the_ends_are_ignored(axes, ticks):
    axes.set_xticks(ticks)
    axes.set_xlim(0.0, 1.0)
    axes.set_yticks([])
    assert sorted(text.get_text() for text, _ in texts_of(axes.figure)) == [
        "0.0",
        "0.5",
        "1.0",
        "Force [N]",
        "Time [s]",
    ]


@pytest.mark.parametrize(("overlap", "faults"), [(0.5, 0), (1.5, 1)])
@pytest.mark.parametrize("beside", [True, False])
def test_texts_may_touch_by_a_pixel(overlap, faults, beside):
    figure, box = Figure(figsize=(4.0, 3.0), dpi=100.0), box_of("word")
    at(figure, 100.0, 100.0)
    at(
        figure,
        100.0 + (box.width - overlap) * beside,
        100.0 + (box.height - overlap) * (not beside),
    )
    assert illegible_texts(figure) == ["'word' and 'word' overlap"] * faults


@pytest.mark.parametrize(
    ("angles", "faults"), [((45.0, 45.0), 0), ((45.0, 0.0), 1), ((30.0, 30.0), 1)]
)
def test_texts_with_the_same_slant_do_not_overlap(angles, faults):
    figure = Figure(figsize=(4.0, 3.0), dpi=100.0)
    for angle in angles:
        at(figure, 100.0, 100.0, rotation=angle)
    assert len(illegible_texts(figure)) == faults


@pytest.mark.parametrize("side", ["left", "right", "below", "above"])
@pytest.mark.parametrize(("beyond", "faults"), [(0.5, 0), (1.5, 1)])
def test_a_text_may_reach_a_pixel_over_the_edge_of_the_page(side, beyond, faults):
    figure, box = Figure(figsize=(4.0, 3.0), dpi=100.0), box_of("word")
    x = {"left": -beyond, "right": 400.0 - box.width + beyond}.get(side, 100.0)
    y = {"below": -beyond, "above": 300.0 - box.height + beyond}.get(side, 100.0)
    shift = box.y0 - 100.0  # letters may begin beside the place of their text
    at(figure, x - (box.x0 - 100.0), y - shift)
    assert illegible_texts(figure) == ["'word' lies outside of the figure"] * faults

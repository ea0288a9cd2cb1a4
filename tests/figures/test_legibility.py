"""What makes a figure illegible: axes without a name or a unit, texts on one another or outside of the page."""

import pytest
from matplotlib.figure import Figure
from matplotlib.transforms import IdentityTransform

from bristle.figures.legibility import illegible_texts, texts_of, unlabelled_axes


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


def test_hidden_panels_have_no_faults(axes):
    axes.set(xlabel="", ylabel="")
    axes.set_axis_off()
    assert unlabelled_axes(axes.figure) == []
    axes.set_axis_on()
    axes.set_visible(False)
    assert unlabelled_axes(axes.figure) == []


def test_exactly_the_visible_texts_of_a_figure_are_found(axes):
    figure = axes.figure
    axes.plot([0.0, 1.0], [0.0, 1.0], label="of the panel")
    axes.legend()
    figure.legend(*axes.get_legend_handles_labels(), loc="lower left").get_texts()[0].set_text("of the page")
    for place in ("left", "center", "right"):
        axes.set_title(place, loc=place)
    axes.text(0.5, 0.5, "inside")
    axes.text(0.5, 0.5, "hidden").set_visible(False)
    axes.text(0.5, 0.5, "")
    at(figure, 10.0, 10.0, "aside")
    axes.set_xticks([0.0, 0.1 + 0.2, 1.0], ["zero", "some", "beyond"])
    axes.set_xlim(0.3, 0.0)  # against the usual way, and a rounding below the tick
    axes.set_yticks([])
    named = {"of the panel", "of the page", "left", "center", "right", "inside", "aside", "zero", "some", "Time [s]", "Force [N]"}
    assert sorted(text.get_text() for text, _ in texts_of(figure)) == sorted(named)


@pytest.mark.parametrize("ticks", [[-0.5, 0.0, 0.5, 1.0], [0.0, 0.5, 1.0, 1.5]])
def test_ticks_beyond_the_ends_are_ignored(axes, ticks):
    axes.set_xticks(ticks)
    axes.set_xlim(0.0, 1.0)
    axes.set_yticks([])
    assert sum(text.get_text() in ("0.0", "0.5", "1.0") for text, _ in texts_of(axes.figure)) == 3
    assert len(texts_of(axes.figure)) == 5


@pytest.mark.parametrize(("overlap", "faults"), [(0.5, 0), (1.5, 1)])
@pytest.mark.parametrize("beside", [True, False])
def test_texts_may_touch_by_a_pixel(overlap, faults, beside):
    figure, box = Figure(figsize=(4.0, 3.0), dpi=100.0), box_of("word")
    at(figure, 100.0, 100.0)
    at(figure, 100.0 + (box.width - overlap) * beside, 100.0 + (box.height - overlap) * (not beside))
    assert illegible_texts(figure) == ["'word' and 'word' overlap"] * faults


@pytest.mark.parametrize(("angles", "faults"), [((45.0, 45.0), 0), ((45.0, 0.0), 1), ((30.0, 30.0), 1)])
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

"""Names as people choose them: every figure takes them, shows them as they are, and has room for them."""

import re
from xml.etree import ElementTree

import pytest
from tests.figures.gallery import gallery
from tests.figures.hostile_names import LONG, NAMES
from tests.figures.test_figures import assert_legible

from bristle import figures
from bristle.figures import style
from bristle.figures.drawing import one_line, printable, shortened, shortened_apart, width

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
        assert {item.tag for item in tree.iter()} <= {"svg", "defs", "style", "g", "path", "text", "use", "clipPath", "rect", "pattern"}, (
            name
        )
        assert FORBIDDEN.search(svg) is None, name
        # The names of the lines stand in `data-panels` as written.
        used = set(re.findall(r'<[^>]*(?:href="#|url\(#)([^")]+)', re.sub(r' data-panels="[^"]*"', "", svg)))
        assert used <= {item.get("id") for item in tree.iter()}, name


@pytest.mark.parametrize("name", [name if name in WAYS else pytest.param(name, marks=pytest.mark.slow) for name in named(NAMES[:2])])
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
    for name, behind in (("closure", "−30.0 %"), ("ripple", "0.5 µm"), ("marked_path", "0.5 µm")):
        titles = [item for item in (axes.get_title(loc="right") for axes in draws[name]().axes) if item]
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

"""The skeleton of a report: figures in place, no empty sections, and faults without further loss."""

import datetime
import json
import re
import subprocess
import warnings
from importlib import resources
from types import SimpleNamespace as Some

import pytest
from markupsafe import Markup
from matplotlib.figure import Figure
from tests.apps.lab.scripts import NODE, needs_node

from bristle.core import InputWarning
from bristle.core.palette import DARK, LIGHT, colour_variables
from bristle.report import page, table
from bristle.report.figures import ReportFigure, style

ONE, TWO = (page.Picture(f"figure-{name}", Markup("<svg/>"), name) for name in ("one", "two"))


def test_line_under_the_heading_begins_with_the_date():
    assert (
        page.about("log a.csv", "", "model b")
        == f"{datetime.date.today().isoformat()} · log a.csv · model b"
    )


@pytest.mark.parametrize(
    ("reasons", "more"), [(None, False), ((), False), (("a",), False), (("a", "b"), True)]
)
def test_a_tab_lists_the_reasons_if_there_are_several(reasons, more):
    assert (
        page.Front("a", "b", None if reasons is None else page.Ruling("no", "No", reasons)).has_more
        is more
    )


TABLE = table.Table("t", ["a"], [["1"]])


@pytest.mark.parametrize(
    ("identifier", "blocks", "filled"),
    [
        # Figures are in place or at the end.
        ("a", ["text"], ["text", ONE, TWO]),
        ("a", [page.Figures("a"), "text"], [ONE, TWO, "text"]),
        ("other", [page.Figures("a"), "text"], [ONE, TWO, "text"]),
        ("b", ["text"], ["text"]),
        # Empty blocks are left out.
        (
            "s",
            [
                None,
                "",
                page.Block("items", []),
                page.Block("items", ["x"]),
                table.Table("t", [], []),
                TABLE,
            ],
            [page.Block("items", ["x"]), TABLE],
        ),
    ],
)
def test_a_section_has_its_figures_and_no_empty_blocks(identifier, blocks, filled):
    assert (
        page._filled(page.Section(identifier, "A", blocks), {"a": [ONE, TWO], "b": []}).blocks
        == filled
    )


def rendered(sections, **options):
    known = {"command": "do", "provenance": {"bristle": "0"}}
    return page.report_page("log", {}, page.Front("heading", "facts"), sections, **known | options)


def test_empty_sections_are_left_out_and_the_banner_is_first():
    text = rendered(
        [page.Section("kept", "Kept", ["words"]), page.Section("gone", "Gone", [None])],
        banner="Unfinished.",
    )
    assert text.index("Unfinished.") < text.index("Kept")
    assert not re.search("Gone|Further figures", text)


def custom(draw, takes="log"):
    return ReportFigure(
        name="mine", takes=takes, draw=draw, caption="See.", alternative="mine", title="Mine"
    )


def broken(log):
    raise ValueError("a fault")


@pytest.mark.parametrize(
    ("figure", "facts", "words"),
    [
        (custom(broken), {"log": 1}, r"mine is not drawn: ValueError: a fault"),
        (custom(broken), {}, "mine: the figure mine is not drawn: this report has no log"),
        (custom(broken, ("log", "design")), {}, "this report has no log and no design"),
    ],
)
def test_failing_figure_of_the_user_is_a_remark(figure, facts, words):
    with pytest.warns(InputWarning, match=words):
        (remark,) = page._own_blocks(figure, facts)
    assert "<h3>Mine</h3><p>" in remark
    assert "not drawn" in remark


def test_figure_of_the_user_is_under_its_title_and_published():
    with page.plates() as collected:
        title, drawing = page._own_blocks(custom(lambda log: style.panels(2.0)[0]), {"log": 1})
    assert (title, drawing.id, drawing.caption) == ("<h3>Mine</h3>", "figure-own-mine", "See.")
    (plate,) = collected
    assert (plate.name, plate.alternative, plate.caption, plate.own) == (
        "mine",
        "mine",
        "See.",
        True,
    )
    assert page._plates.get() is None


def test_fault_in_a_figure_leaves_the_other_figures(monkeypatch):
    figure = custom(broken)
    place = Some(section="front", name="fit.BROKEN", is_taken=lambda facts: True, figure=figure)
    skipped = Some(section="front", name="x", is_taken=lambda facts: False)
    monkeypatch.setitem(
        __import__("bristle.report.figures.on_reports", fromlist=["REPORTS"]).REPORTS,
        "log",
        (skipped, place),
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        pictures, (remark,) = page._pictures("log", {"log": 1})
    assert pictures == {"front": []}
    assert remark == "<p>the figure fit.BROKEN is not drawn: ValueError: a fault.</p>"
    (warning,) = caught
    assert issubclass(warning.category, page.FaultWarning)
    assert isinstance(warning.message.__cause__, ValueError)


BREAKABLE = page._environment().filters["breakable"]


@pytest.mark.parametrize(
    ("written", "text", "shown"),
    [
        # Units after numbers are typeset.
        (page.typeset_sentence, "5 N*m and 3 kg*m^2", "5 N·m and 3 kg·m²"),
        (page.typeset_sentence, "at 2 m/s", "at 2 m/s"),
        (page.typeset_sentence, "N*m alone", "N*m alone"),
        (page.typeset_sentence, "3 uN", "3 µN"),
        # Commands are code, and markup is unchanged.
        (page.worded, "see `a_b` and `c`", "see <code>a_b</code> and <code>c</code>"),
        (page.worded, Markup("<b>x</b>"), "<b>x</b>"),
        # Long names can break.
        (BREAKABLE, "short_name x", "short_name x"),
        (BREAKABLE, "twelve_words", "twelve_words"),
        (BREAKABLE, "thirteen_word", "thirteen_<wbr>word"),
        (BREAKABLE, "a_rather_long x_y", "a_<wbr>rather_<wbr>long x_y"),
        (BREAKABLE, "<" * 13, "&lt;" * 13),
    ],
)
def test_a_text_is_written_for_a_page(written, text, shown):
    assert written(text) == shown


def test_long_and_unbroken_texts_and_prose_are_told_apart():
    tests = page._environment().tests
    assert [tests["long"]("x" * count) for count in (40, 41)] == [False, True]
    assert [tests["unbroken"](" ".join(["y" * 30, "x" * count])) for count in (40, 41)] == [
        False,
        True,
    ]
    assert (tests["prose"]("x"), tests["prose"](Markup("x")), tests["prose"](3)) == (
        True,
        False,
        False,
    )


def test_sections_with_the_same_tab_share_it():
    text = rendered(
        [
            page.Section("a", "A", ["x"], "Both"),
            page.Section("b", "B", ["y"], "Both"),
            page.Section("c", "C", ["z"]),
        ]
    )
    assert re.findall(r"<label[^>]*>(.*?)</label>", text) == ["Both", "C", "Repeat"]


# --- The colours of all pages: letters stay readable on their grounds in light and dark, and paper is light


LETTERS = ("ink", "soft", "accent", "with", "usable", "care", "alert")


def luminance(colour):
    channels = [int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
    linear = [
        channel / 12.92 if channel <= 0.04045 else ((channel + 0.055) / 1.055) ** 2.4
        for channel in channels
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first, second):
    """Contrast of two colours by WCAG 2.1."""
    dark, light = sorted((luminance(first), luminance(second)))
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("colours", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("name", LETTERS)
def test_letters_are_readable_on_page_and_card(colours, name):
    assert min(contrast(colours[name], colours[ground]) for ground in ("ground", "card")) >= 4.5


def test_dark_has_every_colour_and_paper_is_light():
    assert list(LIGHT) == list(DARK)
    light, dark = colour_variables(":root").split("@media")
    assert dict(re.findall(r"--([a-z]+):(#[0-9a-f]{6});", light)) == LIGHT
    assert dict(re.findall(r"--([a-z]+):(#[0-9a-f]{6});", dark)) == DARK
    assert dark.startswith(" screen and (prefers-color-scheme:dark)")


# --- The script of the plots: its scales are those of matplotlib, and its marks are round


def computed(folder, expression):
    """Return a value of the functions of the script that need no page."""
    text = (
        resources.files("bristle.report")
        .joinpath("templates", "plots.js")
        .read_text(encoding="utf-8")
    )
    file = folder / "plots.js"
    file.write_text(
        f"{text[: text.index('class Plot {')]}\nconsole.log(JSON.stringify({expression}));\n",
        encoding="utf-8",
    )
    return json.loads(
        subprocess.run([NODE, str(file)], capture_output=True, text=True, check=True).stdout
    )


@needs_node
@pytest.mark.parametrize(
    ("scale", "ends", "values"),
    [
        ("linear", (-3.0, 7.0), (-3.0, 0.0, 6.5)),
        ("log", (0.01, 100.0), (0.02, 1.0, 70.0)),
        ("symlog", (-200.0, 50.0), (-150.0, -2.0, -0.5, 0.0, 1.0, 1.5, 30.0)),
    ],
)
def test_a_value_lies_where_matplotlib_draws_it(scale, ends, values, tmp_path):
    axes = Figure().add_subplot()
    axes.set_xscale(scale, **({"linthresh": 1.0, "linscale": 1.0} if scale == "symlog" else {}))
    axes.set_xlim(*ends)
    drawn = axes.transAxes.inverted().transform(
        axes.transData.transform([[value, 0.5] for value in values])
    )[:, 0]
    side = json.dumps({"ends": ends, "scale": scale, "linear": 1.0})
    shares = computed(tmp_path, f"{json.dumps(values)}.map(scaleOfSide({side}).at)")
    assert shares == pytest.approx(drawn.tolist(), abs=1e-9)
    back = computed(tmp_path, f"{json.dumps(shares)}.map(scaleOfSide({side}).value)")
    assert back == pytest.approx(list(values), abs=1e-9)


@needs_node
def test_marks_are_round_and_inside(tmp_path):
    sides = (
        "-0.13, 0.62, 4, true",
        "0.5, 200, 4, false",
        "-20, 0.5, 4, false",
        "18.7, 19.9, 8, true",
    )
    plain, decades, signed, fine = computed(
        tmp_path, f"[{', '.join(f'ticksBetween({side})' for side in sides)}]"
    )
    assert (plain, decades, signed[:2]) == ([0.0, 0.2, 0.4, 0.6], [1, 10, 100], [-10, -1])
    assert fine == pytest.approx([18.8, 19.0, 19.2, 19.4, 19.6, 19.8])

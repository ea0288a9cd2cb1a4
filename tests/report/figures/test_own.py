"""A figure of a user's own: what its file has to say, on which reports it can stand, and that results stay as they are."""

import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace as Some

import pytest
from markupsafe import escape
from tests.report.all_reports import rendered, report_of

from bristle import figures
from bristle.core import InputError
from bristle.report.figures import ReportFigure, legibility, on_reports, own, report_figure, style
from bristle.report.figures.contract import EXAMPLES

FILE = """
from bristle.report.figures import ReportFigure, style
def draw(simulation):
    return style.panels(2.0)[0]
FIGURE = ReportFigure(name="{name}", title="{title}", caption="{caption}", alternative="{alternative}", takes={takes}, draw={draw})
"""
USUAL = {
    "name": "mine",
    "title": "Mine",
    "caption": "See.",
    "alternative": "mine",
    "takes": '"simulation"',
    "draw": "draw",
}


def written(folder, **changes):
    file = folder / "figure.py"
    file.write_text(FILE.format(**USUAL | changes))
    return file


def test_a_file_defines_a_figure(tmp_path):
    figure = own.load_figure_file(written(tmp_path))
    assert (figure.name, figure.needs) == ("mine", ("simulation",))
    assert own.load_figure_file(written(tmp_path, name="a" + "b" * 40)).name == "a" + "b" * 40
    assert own.load_figure_file(written(tmp_path, takes='("log", "design")')).needs == (
        "log",
        "design",
    )


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"name": "Mine"}, "an invalid name"),
        ({"name": "1mine"}, "an invalid name"),
        ({"name": "a" + "b" * 41}, "an invalid name"),
        ({"name": "following"}, "an invalid name"),
        ({"title": " "}, "has no title"),
        ({"caption": ""}, "has no caption"),
        ({"alternative": ""}, "has no alternative"),
        ({"draw": "3"}, "has no function `draw`"),
        ({"takes": '"weather"'}, "takes results that no report has.*weather"),
        ({"takes": "()"}, "takes results that no report has"),
        ({"takes": '("log", "weather")'}, "takes results that no report has.*weather"),
    ],
)
def test_an_incomplete_file_is_refused(tmp_path, changes, words):
    with pytest.raises(InputError, match=words):
        own.load_figure_file(written(tmp_path, **changes))


def figure(name="mine", takes="simulation", draw=lambda simulation: style.panels(2.0)[0], **more):
    return ReportFigure(
        name=name, takes=takes, draw=draw, caption="See.", alternative="mine", **more
    )


@pytest.mark.parametrize(
    ("takes", "report", "others", "words"),
    [
        (
            "simulation",
            "study",
            1,
            r"the report of study lacks.*simulation.*bristle identify or bristle run",
        ),
        (("study", "design"), "study", 0, r"lacks(?!.*Use the figure with)"),
        ("simulation", "run", 2, "another figure has the same name"),
    ],
)
def test_a_figure_is_on_reports_with_its_inputs(takes, report, others, words):
    own.refuse_unfit(figure(), "run", [figure()], "")
    with pytest.raises(InputError, match=words):
        own.refuse_unfit(figure(takes=takes), report, [figure()] * others, "")


def test_figures_are_given_as_objects_or_files(tmp_path):
    first, second = own.figures_named([figure("other"), written(tmp_path)], "run")
    assert (first.name, second.name) == ("other", "mine")
    assert own.figures_named((), "run") == ()
    with pytest.raises(InputError, match="another figure has the same name"):
        own.figures_named([figure(), written(tmp_path)], "run")


def test_a_figure_is_drawn_from_copies():
    facts = {"simulation": {"a": [1]}}

    def draw(simulation):
        simulation["a"].append(2)
        return style.panels(2.0)[0]

    assert own.draw_own(figure(draw=draw), facts).axes
    assert facts == {"simulation": {"a": [1]}}
    with pytest.raises(InputError, match="returned a int, not a Figure"):
        own.draw_own(figure(draw=lambda simulation: 3), facts)


def test_a_figure_is_not_kept_by_the_stateful_interface(monkeypatch):
    closed = []
    monkeypatch.setitem(own.sys.modules, "matplotlib.pyplot", Some(close=closed.append))
    drawing = own.draw_own(figure(), {"simulation": 1})
    assert closed == [drawing]


def test_a_figure_applies_with_all_its_inputs_and_takes_optional_results():
    item = figure(takes=("log", "fit"), may_take=("more",))
    assert item.missing({"log": 1, "fit": None}) == ("fit",)
    assert item.arguments({"log": 1, "fit": 2}) == (1, 2, None)
    assert [item.applies_to(facts) for facts in ({"log": 1, "fit": 2}, {"log": 1})] == [True, False]
    choosy = figure(takes=("log",), applies=lambda log: log > 1)
    assert [choosy.applies_to(facts) for facts in ({"log": 1}, {"log": 2}, {})] == [
        False,
        True,
        False,
    ]


# --- A figure is a file and a line: what is registered is drawn, and what is drawn stands on the page


FOLDER = Path(figures.__file__).parent
FACT = {
    "identification": "fit",
    "comparison": "comparison",
    "excitation": "motion",
    "operator": "recorded",
    "arm": "joints",
}


@pytest.mark.slow
def test_every_figure_of_a_file_is_on_a_report_and_every_line_is_a_figure():
    for module in (
        *(f"bristle.report.figures.{file.stem}" for file in FOLDER.glob("[a-z]*.py")),
        *on_reports.OF_APPS.values(),
    ):
        import_module(module)
    assert set(report_figure.FIGURES) == {
        place.name for places in on_reports.REPORTS.values() for place in places
    }
    assert all(
        isinstance(place.figure, ReportFigure)
        for places in on_reports.REPORTS.values()
        for place in places
    )


@pytest.mark.slow
@pytest.mark.parametrize("report", on_reports.REPORTS)
def test_every_drawn_figure_is_on_the_page(report):
    pages = [report_of(report)]
    pages += [rendered(report, by_position=True)] if report == "identification" else []
    for page, _, drawn in pages:
        assert drawn
        assert re.findall(r'<figure id="figure-(\w+)"', page) == [plate.name for plate in drawn]
        assert all(str(escape(plate.caption)) in page for plate in drawn)


UNLABELLED = {
    ("design", "loops"): "the axis y, 'Loop', has no unit",
    ("design", "margins"): "the axis y, 'Open loop, gain', has no unit",
    ("design", "circles"): "an axis x has no label",
}
"""Figures of bristle with an axis that has no unit, such as a ratio or a number of a log; the first such axis of each."""


@pytest.mark.slow
@pytest.mark.parametrize("report", on_reports.REPORTS)
def test_figures_of_bristle_meet_the_contract_of_figures(report):
    for plate in report_of(report)[2]:
        faults = legibility.unlabelled_axes(plate.figure)
        assert faults[:1] == [
            fault for key, fault in UNLABELLED.items() if key == (report, plate.name)
        ], plate.name
        assert legibility.illegible_texts(plate.figure) == [], plate.name
        assert not plate.caption or plate.caption.endswith((".", "!", "?")), plate.name
        assert "\n" not in plate.alternative.strip(), plate.name
        points = sum(
            len(stroke)
            for panel in figures.numbers_of(plate.figure)
            for _, drawn in panel.drawn
            for stroke in drawn.strokes
        )
        assert points > 1, plate.name
    assert figures.figure_file(plate.figure, "pdf", plate.alternative), plate.name


@pytest.mark.slow
def test_nearly_every_registered_figure_is_drawn_from_the_small_results():
    missing = set()
    for report, places in on_reports.REPORTS.items():
        drawn = {plate.name for plate in report_of(report)[2]}
        missing |= {(report, place.figure.name) for place in places} - {
            (report, name) for name in drawn
        }
    # An open loop, a loop without a pair, a log that only sticks, a log with loops, pre-sliding, two masses, and several numbers.
    assert missing == {
        ("simulation", "motion"),
        ("simulation", "reversal"),
        ("identification", "effort"),
        ("identification", "loops"),
        ("identification", "reversals"),
        ("log", "loops"),
        ("identification", "sides"),
        ("identification", "frictions"),
        ("identification", "lost_motion"),
        ("identification", "response"),
        ("fleet", "joints"),
        ("study", "spread"),
        ("fleet", "parameter_2"),
        ("fleet", "parameter_3"),
        ("fleet", "fleet"),
    }


@pytest.mark.slow
@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("report", "section"),
    [
        (report, section)
        for report in on_reports.REPORTS
        for section in sorted({place.section for place in on_reports.REPORTS[report]})
    ],
)
def test_a_figure_added_to_a_section_is_on_the_page(report, section, monkeypatch):
    monkeypatch.setitem(
        sys.modules, "bristle.report.figures.added", ModuleType("bristle.report.figures.added")
    )
    added = ReportFigure(
        name="added",
        takes=FACT.get(report, report),
        draw=lambda fact: style.panels(2.0)[0],
        alternative="added",
        caption="Added.",
    )
    monkeypatch.setitem(report_figure.FIGURES, "added.added", added)
    places = [
        place
        for place in on_reports.REPORTS[report]
        if section != "front" or place.section != "front"
    ]
    monkeypatch.setitem(
        on_reports.REPORTS, report, (*places, on_reports.Place(section, "added.added"))
    )
    assert (
        'id="figure-added"'
        in rendered(report, **({"by_position": True} if section == "position" else {}))[0]
    )


@pytest.mark.slow
def test_sample_results_exist_for_every_input_of_a_figure():
    assert {name for names in report_figure.FACTS.values() for name in names} == set(EXAMPLES)

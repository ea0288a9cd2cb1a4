"""A figure is a file and a line: what is registered is drawn, and what is drawn stands on the page."""

import re
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from markupsafe import escape
from tests.report.all_reports import rendered, report_of

from bristle import figures
from bristle.figures import ReportFigure, legibility, on_reports, report_figure, style
from bristle.testing.figures import EXAMPLES

pytestmark = pytest.mark.slow

FOLDER = Path(figures.__file__).parent
FACT = {"identification": "fit", "comparison": "comparison", "excitation": "motion", "operator": "recorded", "arm": "joints"}


def test_every_figure_of_a_file_is_on_a_report_and_every_line_is_a_figure():
    for file in FOLDER.glob("[a-z]*.py"):
        import_module(f"bristle.figures.{file.stem}")
    assert set(report_figure.FIGURES) == {place.name for places in on_reports.REPORTS.values() for place in places}
    assert all(isinstance(place.figure, ReportFigure) for places in on_reports.REPORTS.values() for place in places)


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


@pytest.mark.parametrize("report", on_reports.REPORTS)
def test_figures_of_bristle_meet_the_contract_of_figures(report):
    for plate in report_of(report)[2]:
        faults = legibility.unlabelled_axes(plate.figure)
        assert faults[:1] == [fault for key, fault in UNLABELLED.items() if key == (report, plate.name)], plate.name
        assert legibility.illegible_texts(plate.figure) == [], plate.name
        assert not plate.caption or plate.caption.endswith((".", "!", "?")), plate.name
        assert "\n" not in plate.alternative.strip(), plate.name
        points = sum(len(stroke) for panel in figures.numbers_of(plate.figure) for _, drawn in panel.drawn for stroke in drawn.strokes)
        assert points > 1, plate.name
    assert figures.figure_file(plate.figure, "pdf", plate.alternative), plate.name


def test_nearly_every_registered_figure_is_drawn_from_the_small_results():
    missing = set()
    for report, places in on_reports.REPORTS.items():
        drawn = {plate.name for plate in report_of(report)[2]}
        missing |= {(report, place.figure.name) for place in places} - {(report, name) for name in drawn}
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


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("report", "section"),
    [(report, section) for report in on_reports.REPORTS for section in sorted({place.section for place in on_reports.REPORTS[report]})],
)
def test_a_figure_added_to_a_section_is_on_the_page(report, section, monkeypatch):
    monkeypatch.setitem(sys.modules, "bristle.figures.added", ModuleType("bristle.figures.added"))
    added = ReportFigure(
        name="added", takes=FACT.get(report, report), draw=lambda fact: style.panels(2.0)[0], alternative="added", caption="Added."
    )
    monkeypatch.setitem(report_figure.FIGURES, "added.added", added)
    places = [place for place in on_reports.REPORTS[report] if section != "front" or place.section != "front"]
    monkeypatch.setitem(on_reports.REPORTS, report, (*places, on_reports.Place(section, "added.added")))
    assert 'id="figure-added"' in rendered(report, **({"by_position": True} if section == "position" else {}))[0]


def test_sample_results_exist_for_every_input_of_a_figure():
    assert {name for names in report_figure.FACTS.values() for name in names} == set(EXAMPLES)

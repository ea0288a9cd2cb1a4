"""A figure is a file and a line: what is registered is drawn, and what is drawn stands on the page."""

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from markupsafe import escape
from tests.report.all_reports import rendered, report_of

from bristle import figures
from bristle.figures import ReportFigure, style
from bristle.figures.on_reports import REPORTS, Place
from bristle.figures.report_figure import FACTS
from bristle.testing.figures import EXAMPLES

FOLDER = Path(figures.__file__).parent
FACT = {"identification": "fit", "comparison": "comparison", "excitation": "motion", "operator": "recorded"}


def test_every_figure_of_a_file_is_on_a_report_and_every_line_is_a_figure():
    defined = {(file.stem, name) for file in FOLDER.glob("*.py") for name in re.findall(r"(?m)^(\w+) = ReportFigure\(", file.read_text())}
    placed = {
        tuple(place.name.split(".")) if "." in place.name else (place.name, "FIGURE") for places in REPORTS.values() for place in places
    }
    assert defined == placed
    assert all(isinstance(place.figure, ReportFigure) for places in REPORTS.values() for place in places)


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("report", REPORTS)
def test_every_figure_that_is_drawn_stands_on_the_page(report):
    pages = [report_of(report)]
    pages += [rendered(report, by_position=True)] if report == "identification" else []
    for page, _, drawn in pages:
        assert drawn
        assert re.findall(r'<figure id="figure-(\w+)"', page) == [plate.name for plate in drawn]
        assert all(str(escape(plate.caption)) in page for plate in drawn)


def test_nearly_every_figure_of_the_registry_is_drawn_of_the_small_results():
    missing = set()
    for report, places in REPORTS.items():
        drawn = {plate.name for plate in report_of(report)[2]}
        missing |= {(report, place.figure.name) for place in places} - {(report, name) for name in drawn}
    assert missing == {("simulation", "motion")}  # that of an open loop


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("report", "section"), [(report, section) for report in REPORTS for section in sorted({place.section for place in REPORTS[report]})]
)
def test_a_figure_that_is_added_to_a_section_stands_on_the_page(report, section, monkeypatch):
    module = ModuleType("bristle.figures.added")
    module.FIGURE = ReportFigure(
        name="added", takes=FACT.get(report, report), draw=lambda fact: style.panels(2.0)[0], alternative="added", caption="Added."
    )
    monkeypatch.setitem(sys.modules, module.__name__, module)
    places = [place for place in REPORTS[report] if section != "front" or place.section != "front"]
    monkeypatch.setitem(REPORTS, report, (*places, Place(section, "added")))
    assert 'id="figure-added"' in rendered(report, **({"by_position": True} if section == "position" else {}))[0]


def test_what_a_figure_may_take_is_there_to_try_it():
    assert {name for names in FACTS.values() for name in names} == set(EXAMPLES)

"""A figure is a file and a line: what is registered is drawn, and what is drawn stands on the page."""

import re
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest
from markupsafe import escape

from bristle import figures
from bristle.figures import ReportFigure, style
from bristle.figures.on_reports import ELSEWHERE, REPORTS, Place, names_on_reports
from bristle.figures.report_figure import FACTS
from bristle.prediction import drive_table
from bristle.report.comparison import comparison_report
from bristle.report.design import design_report
from bristle.report.identification import identification_report
from bristle.report.log import log_report
from bristle.report.page import plates
from bristle.report.prediction import prediction_report
from bristle.report.simulation import simulation_report
from bristle.report.study import study_report, study_summary
from bristle.testing.figures import EXAMPLES, example_facts

FOLDER = Path(figures.__file__).parent
TOLD = {"command": "bristle", "provenance": {}}
FACT = {"identification": "fit", "prediction": "prediction", "simulation": "simulation", "log": "log"}


def page_of(report, by_position=False):
    """The report of small results, with all that it may have."""
    facts = example_facts("translational")
    identification, log = facts["identification"], facts["log"]
    best = identification.best
    if report == "identification":
        if by_position:
            best = replace(best, position_rmse=1e-6, position_error_percent=1.0)
            identification = replace(identification, fits=(best, *identification.fits[1:]))
        return identification_report(
            identification,
            prediction=facts["prediction"],
            simulation=facts["simulation"],
            table=drive_table(best, 10),
            axis_name="axis",
            **TOLD,
        )
    if report == "prediction":
        return prediction_report(facts["prediction"], plant=best.plant, friction=best.friction, log=log, axis_name="axis", **TOLD)
    if report == "simulation":
        return simulation_report(facts["simulation"], **TOLD)
    return log_report(log, (), name="axis", **TOLD)


def test_every_file_with_a_figure_is_on_a_report_and_every_line_is_a_figure():
    files = {file.stem for file in FOLDER.glob("*.py") if re.search(r"^FIGURE = ", file.read_text(), re.MULTILINE)}
    assert files == {place.module for places in REPORTS.values() for place in places}
    assert all(isinstance(place.figure, ReportFigure) for places in REPORTS.values() for place in places)


@pytest.mark.parametrize("report", REPORTS)
def test_every_figure_that_is_drawn_stands_on_the_page(report):
    for by_position in {False, report == "identification"}:
        with plates() as drawn:
            page = page_of(report, by_position)
        assert drawn
        assert re.findall(r'<figure id="figure-(\w+)"', page) == [plate.name for plate in drawn]
        assert all(str(escape(plate.caption)) in page for plate in drawn)


def test_nearly_every_figure_of_the_registry_is_drawn_of_the_small_results():
    drawn = set()
    for report in REPORTS:
        with plates() as collected:
            page_of(report)
        drawn |= {plate.name for plate in collected}
    registered = {place.figure.name for places in REPORTS.values() for place in places}
    assert registered - drawn == {"motion"}  # that of an open loop


@pytest.mark.parametrize(
    ("report", "section"), [(report, section) for report in REPORTS for section in sorted({place.section for place in REPORTS[report]})]
)
def test_a_figure_that_is_added_to_a_section_stands_on_the_page(report, section, monkeypatch):
    module = ModuleType("bristle.figures.added")
    module.FIGURE = ReportFigure(
        name="added", takes=FACT[report], draw=lambda fact: style.panels(2.0)[0], alternative="added", caption="Added."
    )
    monkeypatch.setitem(sys.modules, module.__name__, module)
    places = [place for place in REPORTS[report] if section != "front" or place.section != "front"]
    monkeypatch.setitem(REPORTS, report, (*places, Place(section, "added")))
    assert 'id="figure-added"' in page_of(report, by_position=section == "position")


def test_reports_without_a_list_draw_what_no_figure_of_ones_own_is_called():
    facts = example_facts("translational")
    runs = facts["study"]
    with plates() as drawn:
        design_report(facts["design"], **TOLD)
        comparison_report(facts["comparison"], name="axis", **TOLD)
        study_report(runs, study_summary(runs, **TOLD), command="bristle")
    names = {plate.name for plate in drawn}
    assert names == set(ELSEWHERE)
    assert names <= names_on_reports()


def test_what_a_figure_may_take_is_there_to_try_it():
    assert {name for names in FACTS.values() for name in names} == set(EXAMPLES)

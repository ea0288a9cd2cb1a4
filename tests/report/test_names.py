"""Names from users and files stay text in every kind of report."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.excitation.axes import STAGE
from tests.figures.gallery import gallery
from tests.figures.hostile_names import LONG, NAMES
from tests.report.pages import Page, without_plots
from tests.report.test_pages import identification_page, prediction_page, simulation_page

from bristle import hysteresis
from bristle.excitation import excite
from bristle.hysteresis.identification.result import OperatorPrediction
from bristle.logs.curves import Curve, Curves
from bristle.paper.page import paper_report
from bristle.paper.reproduced import Reproduced
from bristle.report import page
from bristle.report.excitation import excitation_report
from bristle.report.log import log_report
from bristle.report.operators import operator_prediction_report
from bristle.report.results import log_names

ALL = " ".join(NAMES)
FILE = ALL.replace("/", "").replace("\x00", "")
COMMON = {"command": ALL, "provenance": {ALL: ALL}}
FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def assert_harmless(text):
    """User text stays text, and the page has only allowed tags."""
    page = Page(without_plots(text))
    assert page.unbalanced == []
    assert {tag for tag, _ in page.tags} & {"script", "img", "b", "iframe", "object", "link"} == set()
    assert all(attrs["href"].startswith(("#", "data:text/csv")) for attrs in page.named("a"))
    assert [name for _, attributes in page.tags for name in attributes if name.startswith("on")] == []
    assert "alert(1)" in page.words
    assert FORBIDDEN.search(text) is None
    pictures = re.findall(r"<svg.*?</svg>", text, re.DOTALL)
    assert pictures
    for picture in pictures:
        ElementTree.fromstring(picture)


def hostile_log(bench):
    return replace(bench.log, position=replace(bench.log.position, column=ALL), source=Path(FILE), notes=(ALL,))


def hostile_loop(bench):
    names = dict(zip(bench.looped.variants, NAMES[1:], strict=False))
    experiment = bench.looped.experiment
    variants = tuple(replace(variant, name=names[variant.name]) for variant in experiment.variants)
    results = {names[name]: replace(variant, name=names[name]) for name, variant in bench.looped.variants.items()}
    return replace(bench.looped, experiment=replace(experiment, name=ALL, variants=variants), variants=results)


def renamed(fit, name):
    return replace(fit, friction=replace(fit.friction, component=replace(fit.friction.component, name=name)))


def identification(bench):
    fits = tuple(renamed(fit, name) for fit, name in zip(bench.identified.fits, NAMES[1:], strict=False))
    result = replace(bench.identified, log=hostile_log(bench), fits=fits)
    return identification_page(bench, identification=result, axis_name=ALL, simulation=hostile_loop(bench), banner=ALL, **COMMON)


def operator(bench):
    u = np.linspace(-1e-6, 1e-6, 50)
    recorded = Curves((Curve(u, 1e6 * u),), source=Path(FILE), notes=(ALL,))
    model = hysteresis.preisach(s=1.25e7, f_p=150.0)
    return operator_prediction_report(OperatorPrediction((1e6 * u,), 0.1, 1.0), model, recorded, name=ALL, **COMMON)


def paper(bench):
    draw = gallery(NAMES[1:4])["ripple"]
    item = Reproduced(2, "found", [ALL], draw, Path(FILE), {}, extras={"more": (draw, ALL, ALL)})
    return paper_report([item], **COMMON)


REPORTS = {
    "identification": identification,
    "log": lambda bench: log_report(hostile_log(bench), [], name=ALL, **COMMON),
    "operator": operator,
    "paper": paper,
    "prediction": lambda bench: prediction_page(bench, log=hostile_log(bench), axis_name=ALL, banner=ALL, **COMMON),
    "simulation": lambda bench: simulation_page(bench, result=hostile_loop(bench), banner=ALL, **COMMON),
    "excitation": lambda bench: excitation_report(excite(replace(STAGE, name=ALL), rehearsed=False), identify=ALL, **COMMON),
}


def test_every_template_escapes_text():
    folder = Path(page.__file__).with_name("templates")
    for item in folder.iterdir():
        assert re.search(r"\|\s*safe|autoescape|Markup", item.read_text(encoding="utf-8")) is None, item.name


@pytest.mark.parametrize("names", [("A", "a"), ("x y", "x_y"), (LONG, "b"), ("轴" * 80, "b")])
def test_logs_with_unsuitable_file_names_are_numbered(names):
    assert list(log_names(names).values()) == ["log_1.csv", "log_2.csv"]


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("kind", REPORTS)
def test_hostile_names_stay_text(kind, stage):
    assert_harmless(REPORTS[kind](stage))


@pytest.mark.slow
@pytest.mark.parametrize("kind", REPORTS)
def test_hostile_names_stay_text_in_figures(kind, stage):
    assert_harmless(REPORTS[kind](stage))

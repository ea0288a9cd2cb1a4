"""Each report is a well-formed, self-contained file that escapes text and names its units."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.prediction.excitation.axes import STAGE
from tests.report.figures.gallery import LONG, NAMES, gallery
from tests.report.pages import Page, without_plots

from bristle import hysteresis
from bristle.apps.paper.page import paper_report
from bristle.apps.paper.reproduced import Reproduced
from bristle.identification.hysteresis.result import OperatorPrediction
from bristle.logs.curves import Curve, Curves
from bristle.prediction.excitation import excite
from bristle.report import excitation, log, operators, page, prediction, simulation
from bristle.report.identification import identification_report
from bristle.report.results import log_names

COMMON = {"command": "bristle do it", "provenance": {"bristle": "0.1.0", "log": "stage.csv"}}


def identification_page(bench, **changes):
    values = (
        {
            "prediction": bench.predicted,
            "simulation": bench.looped,
            "table": bench.table,
            "axis_name": "stage",
        }
        | COMMON
        | changes
    )
    identified = values.pop("identification", bench.identified)
    return identification_report(identified, **values)


def simulation_page(bench, **changes):
    values = COMMON | changes
    return simulation.simulation_report(values.pop("result", bench.looped), **values)


def prediction_page(bench, **changes):
    best = bench.identified.best
    values = (
        {"plant": best.plant, "friction": best.friction, "log": bench.log, "axis_name": "stage"}
        | COMMON
        | changes
    )
    return prediction.prediction_report(bench.predicted, **values)


PAGES = {
    "prediction": prediction_page,
    "simulation": simulation_page,
    "identification": identification_page,
}


@pytest.fixture(scope="module")
def rendered():
    """The pages that were rendered so far, for tests that only read them."""
    return {}


@pytest.fixture(params=PAGES)
def text(request, workbench, rendered):
    key = request.param, workbench.axis.kind
    return rendered.get(key) or rendered.setdefault(key, PAGES[request.param](workbench))


@pytest.mark.fast_cases(1)
def test_page_loads_without_external_resources(text):
    assert not re.search(
        r"https?:|//[a-z]|\bsrc\s*=|@import|url\((?!#)|<script|<link|<iframe", without_plots(text)
    )
    policy = next(attrs["content"] for attrs in Page(text).named("meta") if "http-equiv" in attrs)
    assert policy.startswith("default-src 'none'")


@pytest.mark.fast_cases(1)
def test_page_is_accessible(text):
    page = Page(text)
    assert page.named("html")[0]["lang"] == "en"
    assert next(tag for tag, _ in page.tags if re.fullmatch(r"h\d", tag)) == "h1"
    assert len(page.named("h1")) == len(page.named("title")) == 1
    assert len(page.named("caption")) == len(page.named("table")) > 1
    assert all(attrs.get("scope") in ("row", "col") for attrs in page.named("th"))
    assert len(page.named("figcaption")) == len(page.named("figure")) > 0
    assert all(attrs["role"] == "img" and attrs["aria-label"] for attrs in page.named("svg"))


@pytest.mark.fast_cases(1)
def test_page_has_command_and_provenance(text):
    words = Page(text).words
    assert "bristle do it" in words
    assert "0.1.0" in words


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_same_results_give_the_same_bytes(name, stage):
    assert PAGES[name](stage) == PAGES[name](stage)


@pytest.mark.slow
@pytest.mark.parametrize("name", PAGES)
def test_kind_of_axis_decides_the_units(name, workbenches):
    words = {kind: Page(PAGES[name](bench)).words for kind, bench in workbenches.items()}
    assert not re.search(r"\brad\b|N·m|Torque", words["translational"])
    assert not re.search(r"\[[kmµ]?N\]|\d [kmµ]?N\b(?!·m)|m/s|Force", words["rotational"])


@pytest.mark.usefixtures("undrawn")
def test_banner_is_first(stage):
    words = Page(simulation_page(stage, banner="This is a simulated axis.")).words
    assert words.index("This is a simulated axis.") < words.index("stage: simulated", 20)


@pytest.mark.slow
@pytest.mark.parametrize(
    "left_out",
    [("prediction",), ("simulation",), ("table",), ("prediction", "simulation", "table")],
)
def test_report_without_optional_results_is_complete(left_out, stage):
    page = Page(identification_page(stage, **dict.fromkeys(left_out)))
    assert page.unbalanced == []
    ids = {attrs["id"] for tag in ("figure", "h2") for attrs in page.named(tag) if "id" in attrs}
    part = {"prediction": "figure-prediction", "simulation": "figure-following", "table": "drive"}
    assert {part[name] for name in part if name not in left_out} == ids & set(part.values())


@pytest.mark.slow
def test_report_of_a_single_model_has_no_comparison(stage):
    alone = replace(stage.identified, fits=stage.identified.fits[:1])
    page = Page(identification_page(stage, identification=alone))
    assert "models" not in {attrs.get("id") for attrs in page.named("h2")}


# --- Names from users and files stay text in every kind of report


ALL = " ".join(NAMES)
FILE = ALL.replace("/", "").replace("\x00", "")
HOSTILE_COMMON = {"command": ALL, "provenance": {ALL: ALL}}
FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def assert_harmless(text):
    """User text stays text, and the page has only allowed tags."""
    page = Page(without_plots(text))
    assert page.unbalanced == []
    assert {tag for tag, _ in page.tags} & {
        "script",
        "img",
        "b",
        "iframe",
        "object",
        "link",
    } == set()
    assert all(attrs["href"].startswith(("#", "data:text/csv")) for attrs in page.named("a"))
    assert [
        name for _, attributes in page.tags for name in attributes if name.startswith("on")
    ] == []
    assert "alert(1)" in page.words
    assert FORBIDDEN.search(text) is None
    pictures = re.findall(r"<svg.*?</svg>", text, re.DOTALL)
    assert pictures
    for picture in pictures:
        ElementTree.fromstring(picture)


def hostile_log(bench):
    return replace(
        bench.log, position=replace(bench.log.position, column=ALL), source=Path(FILE), notes=(ALL,)
    )


def hostile_loop(bench):
    names = dict(zip(bench.looped.variants, NAMES[1:], strict=False))
    experiment = bench.looped.experiment
    variants = tuple(replace(variant, name=names[variant.name]) for variant in experiment.variants)
    results = {
        names[name]: replace(variant, name=names[name])
        for name, variant in bench.looped.variants.items()
    }
    return replace(
        bench.looped, experiment=replace(experiment, name=ALL, variants=variants), variants=results
    )


def renamed(fit, name):
    return replace(
        fit, friction=replace(fit.friction, component=replace(fit.friction.component, name=name))
    )


def identification(bench):
    fits = tuple(
        renamed(fit, name) for fit, name in zip(bench.identified.fits, NAMES[1:], strict=False)
    )
    result = replace(bench.identified, log=hostile_log(bench), fits=fits)
    return identification_page(
        bench,
        identification=result,
        axis_name=ALL,
        simulation=hostile_loop(bench),
        banner=ALL,
        **HOSTILE_COMMON,
    )


def operator(bench):
    u = np.linspace(-1e-6, 1e-6, 50)
    recorded = Curves((Curve(u, 1e6 * u),), source=Path(FILE), notes=(ALL,))
    model = hysteresis.preisach(s=1.25e7, f_p=150.0)
    return operators.operator_prediction_report(
        OperatorPrediction((1e6 * u,), 0.1, 1.0), model, recorded, name=ALL, **HOSTILE_COMMON
    )


def paper(bench):
    draw = gallery(NAMES[1:4])["ripple"]
    item = Reproduced(2, "found", [ALL], draw, Path(FILE), {}, extras={"more": (draw, ALL, ALL)})
    return paper_report([item], **HOSTILE_COMMON)


REPORTS = {
    "identification": identification,
    "log": lambda bench: log.log_report(hostile_log(bench), [], name=ALL, **HOSTILE_COMMON),
    "operator": operator,
    "paper": paper,
    "prediction": lambda bench: prediction_page(
        bench, log=hostile_log(bench), axis_name=ALL, banner=ALL, **HOSTILE_COMMON
    ),
    "simulation": lambda bench: simulation_page(
        bench, result=hostile_loop(bench), banner=ALL, **HOSTILE_COMMON
    ),
    "excitation": lambda bench: excitation.excitation_report(
        excite(replace(STAGE, name=ALL), rehearsed=False), identify=ALL, **HOSTILE_COMMON
    ),
}


def test_every_template_escapes_text():
    folder = Path(page.__file__).with_name("templates")
    for item in folder.iterdir():
        assert (
            re.search(r"\|\s*safe|autoescape|Markup", item.read_text(encoding="utf-8")) is None
        ), item.name


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

"""Each report is a well-formed, self-contained file that escapes text and names its units."""

import re
from dataclasses import replace

import pytest
from tests.report.pages import Page, without_plots

from bristle.report.identification import identification_report
from bristle.report.prediction import prediction_report
from bristle.report.simulation import simulation_report

COMMON = {"command": "bristle do it", "provenance": {"bristle": "0.1.0", "log": "stage.csv"}}


def identification_page(bench, **changes):
    values = {"prediction": bench.predicted, "simulation": bench.looped, "table": bench.table, "axis_name": "stage"} | COMMON | changes
    identified = values.pop("identification", bench.identified)
    return identification_report(identified, **values)


def simulation_page(bench, **changes):
    values = COMMON | changes
    return simulation_report(values.pop("result", bench.looped), **values)


def prediction_page(bench, **changes):
    best = bench.identified.best
    values = {"plant": best.plant, "friction": best.friction, "log": bench.log, "axis_name": "stage"} | COMMON | changes
    return prediction_report(bench.predicted, **values)


PAGES = {"prediction": prediction_page, "simulation": simulation_page, "identification": identification_page}


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
    assert not re.search(r"https?:|//[a-z]|\bsrc\s*=|@import|url\((?!#)|<script|<link|<iframe", without_plots(text))
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
@pytest.mark.parametrize("left_out", [("prediction",), ("simulation",), ("table",), ("prediction", "simulation", "table")])
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

"""The report of a loop that is designed: what it tells, and gains that can be copied into an experiment file."""

import re
import tomllib
from dataclasses import replace

import pytest
from tests.loop.conftest import loop
from tests.report.pages import Page
from tests.report.test_names import ALL, assert_harmless
from tests.report.test_pages import COMMON

from bristle import controllers
from bristle.core.experiment import Experiment, Feedforward
from bristle.files.components import controller_from
from bristle.loop import design
from bristle.report.design import budget_table, design_report, design_ruling, design_sentences, design_summary, margin_table
from bristle.report.loops import controller_text


@pytest.fixture(scope="module")
def designed():
    return design(Experiment("bench", "translational", (loop("plain", None), loop())))


@pytest.mark.slow
def test_the_page_is_whole_and_asks_for_nothing(designed):
    text = design_report(designed, **COMMON)
    page = Page(text)
    assert page.unbalanced == []
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids)) > 5
    assert not re.search(r"https?:|//[a-z]|\bsrc\s*=|@import|url\((?!#)|<script|<link|<iframe", text)
    assert [item["id"] for item in page.named("figure")] == ["figure-loops", "figure-margins", "figure-circles"]
    assert "$" not in page.words


def with_errors(designed, *peaks):
    """The design with following errors of our own [m]."""
    error = designed.proposals[0].following_error
    loops = [
        replace(proposal, following_error=replace(error, peak_to_peak=peak))
        for proposal, peak in zip(designed.proposals, peaks, strict=True)
    ]
    return replace(designed, proposals=tuple(loops))


def test_the_verdict_names_the_loop_that_errs_less(designed):
    ruling = design_ruling(with_errors(designed, 2e-6, 1e-6, 3e-6))
    assert (ruling.level, ruling.words) == ("with_care", "Change the gains")
    assert "the loop tuned has a following error of 1\u00a0µm instead of 2\u00a0µm" in ruling.reasons[0]
    assert design_summary(designed, provenance={})["verdict"] == design_ruling(designed).as_data()


def test_a_loop_that_none_proposed_betters_is_kept(designed):
    assert design_ruling(with_errors(designed, 2e-6, 1.7e-6, 3e-6))[:2] == ("usable", "Keep it")


def test_the_first_page_tells_what_to_type_in_and_what_it_takes(designed):
    words = Page(design_report(with_errors(designed, 2e-6, 1e-6, 3e-6), **COMMON)).words
    tuned = designed.proposals[1]
    assert f"kp {tuned.variant.controller.values['k_p']:.4g} 1/s" in words
    assert "acceleration × 20 kg fed forward" in words
    assert "following error 1 µm instead of 2 µm" in words


def test_one_loop_has_one_word(designed):
    page = Page(design_report(designed, **COMMON))
    assert "as it is" not in page.cells
    assert page.cells.count(designed.variant.name) >= 2


def test_what_a_person_wrote_is_escaped(designed):
    variant = replace(designed.variant, name=ALL)
    hostile = replace(designed, experiment=replace(designed.experiment, name=ALL), variant=variant)
    hostile = replace(hostile, assessments=tuple(replace(assessment, name=ALL) for assessment in designed.assessments))
    hostile = replace(hostile, circles=tuple(replace(assessment, variant=ALL) for assessment in designed.circles))
    assert_harmless(design_report(hostile, **COMMON))


def test_variants_that_are_one_loop_share_its_rows(designed):
    rows = margin_table(designed).rows
    assert rows[0][0] == "plain, fed"
    assert {row[0] for row in rows[1:]} == {""}
    assert {row[2] for row in rows} == {"none", "stuck", "sliding"}


def test_the_budget_holds_its_numbers(designed):
    table = budget_table(designed)
    assert table.heads[1].endswith("[µm]")
    for row, entry in zip(table.rows, designed.budget.entries, strict=False):
        assert row[0] == entry.cause
        assert float(row[1]) == pytest.approx(1e6 * entry.alone.peak_to_peak, abs=0.51)
    assert [row[0] for row in table.rows[-2:]] == ["all of them", "none of them"]
    assert table.rows[-1][3] == ""
    late = replace(designed, budget=replace(designed.budget, no_cause=designed.budget.all_causes))
    assert "the law itself" in budget_table(late).rows[-1][3]


def test_where_no_cause_counts_by_itself_none_is_said_to_weigh_most(designed):
    assert any("No cause weighs more" in line for line in design_sentences(designed))
    whole = designed.budget.all_causes
    large = replace(whole, peak_to_peak=5.0 * whole.peak_to_peak)
    causes = tuple(replace(entry, without=whole, alone=large if entry.cause == "shape" else whole) for entry in designed.budget.entries)
    message = " ".join(design_sentences(replace(designed, budget=replace(designed.budget, entries=causes))))
    assert "weighs more" not in message
    assert "causes cancel each other" in message
    assert "Alone, shape makes the most" in message


@pytest.mark.parametrize(
    "law",
    [
        controllers.cascade(k_p=80.0, k_v=4000.0, averaging=2),
        controllers.sliding_mode(J=600.0, lambda_=300.0, K_1=200.0, K_2=5e-3, phi=2e-5, estimator="tracking_observer"),
        controllers.disturbance_observer(kind="rotational", J=4e-4, lambda_=300.0, K_1=200.0, g=60.0, cutoff=400.0),
    ],
)
def test_a_law_is_told_as_an_experiment_file_takes_it(law):
    variant = loop(controller=law, feedforward=Feedforward(mass=20.0))
    table = tomllib.loads(controller_text(variant))["controller"]
    assert table.pop("feedforward") == {"mass": "20 " + {"translational": "kg", "rotational": "kg*m^2"}[law.kind]}
    assert controller_from(table, kind=law.kind, path="controller") == law


@pytest.mark.slow
def test_an_unstable_loop_is_told_with_what_is_stable():
    unstable = loop(run=replace(loop().run, delay=9))
    result = design(Experiment("slow", "translational", (unstable,)))
    words = design_sentences(result)
    assert design_ruling(result)[:2] == ("no", "Do not run it")
    assert "pole at" in words[0]
    assert "nine samples of delay" in words[0]
    page = Page(design_report(result, **COMMON))
    assert page.unbalanced == []
    assert "What it errs by" not in page.words
    assert "with an observer" in page.words

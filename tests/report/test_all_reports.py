"""Rules for all reports: figures name their log, verdicts agree, and bad logs give no values to enter."""

import re

import numpy as np
import pytest
from tests.report.all_reports import (
    DOUBTED,
    KINDS,
    LOGS,
    identification,
    rendered,
    report_of,
    results,
)
from tests.report.pages import Page

from bristle.prediction import compensation_of
from bristle.report.figures.on_reports import REPORTS
from bristle.report.model_tables import comparison_table
from bristle.report.sentences import SENTENCES

pytestmark = pytest.mark.slow

OF_A_LOG = ("identification", "prediction", "log", "comparison", "operator")
WITH_VERDICT = [kind for kind in KINDS if kind != "study"]
WITH_CARDS = [kind for kind in KINDS if kind != "arm"]  # the joints of an arm are rows of a table


def test_every_kind_of_report_is_tested():
    assert set(KINDS) == set(REPORTS)


@pytest.mark.parametrize("kind", KINDS)
def test_report_is_well_formed_html_with_a_figure(kind):
    text, _, drawn = report_of(kind)
    page = Page(text)
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert (page.unbalanced, len(ids)) == ([], len(set(ids)))
    assert len(page.named("figure")) == len(drawn) > 0
    assert not re.search(r"\b(nan|None|inf)\b|\{\{|\{%", page.words)


@pytest.mark.parametrize("kind", OF_A_LOG)
def test_every_figure_names_its_log(kind):
    first, _, rest = report_of(kind)[0].partition('<div class="tabs">')
    title = re.search(r"<small>\((.*?)\)</small>", first)[1]
    assert all(name in title for name in (LOGS if kind == "comparison" else LOGS[:1]))
    names = ", ".join(LOGS) if kind == "comparison" else LOGS[0]
    captions = re.findall(r"<figcaption>(.+?)</figcaption>", rest, re.DOTALL)
    assert all(caption == names or caption.endswith(f" Log: {names}.") for caption in captions)


MOST_WORDS = 60


def first_screen(page):
    """Everything above the tabs."""
    return page.partition("<main>")[2].partition('<div class="tabs">')[0]


@pytest.mark.parametrize("kind", WITH_CARDS)
def test_first_screen_has_title_picture_cards_next_step_and_few_words(kind):
    first = first_screen(report_of(kind)[0])
    page = Page(re.sub(r"<(svg|code)\b.*?</\1>", " ", first, flags=re.DOTALL))
    assert len(page.named("figure")) >= 1
    assert re.search(r"\d", re.search(r"<h2>(.*?)</h2>", first, re.DOTALL)[1]) or kind == "log"
    assert 1 <= first.count('<div class="card-of') <= 4
    assert re.search(r'class="next"><strong>Next:</strong> .+? <code>bristle', first)
    assert len(re.findall(r"[^\W\d]{2,}", " ".join(" ".join(page.text).split()))) <= MOST_WORDS


def test_first_screen_of_an_identification_judges_the_feedforward(monkeypatch):
    usable, summary, _ = report_of("identification")
    promised = compensation_of(results()["identification"].best.friction, None, {"stiffness": 1e6})
    monkeypatch.setattr("bristle.report.summary.compensation_in", lambda result: promised)
    doubted, *summaries = (
        rendered("identification", **DOUBTED)[0],
        identification()[1],
        identification(**DOUBTED)[1],
    )
    assert [len(each["feedforward"]["claims"]) for each in summaries] == [1, 0]
    # This log does not show the stiffness of its position loop, so no moves are named.
    assert (summary["feedforward"]["first_gain"], summary["feedforward"]["claims"]) == (0.25, [])
    assert "Feedforward: safe to try at gain 0.25" in Page(first_screen(usable)).words
    assert re.search(
        "Measure again.*Feedforward: |Feedforward: .*Measure again",
        Page(first_screen(doubted)).words,
    )
    # A log to measure again has no values to enter.
    assert ['id="values"' in page for page in (usable, doubted)] == [True, False]


def cards_of(kind):
    """The cards of a first screen: the value of each by its label."""
    found = re.findall(
        r'class="label">(.*?)</span>\s*<strong>(.*?)</strong>',
        first_screen(report_of(kind)[0]),
        re.DOTALL,
    )
    return {label: value.replace("\u00a0", " ") for label, value in found}


def numbers_of_cards():
    """A number of a card of each kind, and the same number of the results."""
    facts, (_, runs, _), (_, logs, _) = results(), report_of("study"), report_of("fleet")
    loops, metrics = facts["simulation"].variants, facts["prediction"].metrics
    best = min(loops.values(), key=lambda loop: loop.following_error.peak_to_peak)
    fit, log, chosen = facts["identification"].best, facts["log"], facts["design"].chosen
    return {
        "identification": ("Model error", "%", fit.error_percent),
        "prediction": ("Effort error, rms", "mN", 1e3 * metrics["force_rmse"]),
        "simulation": ("Error, peak to peak", "mm", 1e3 * best.following_error.peak_to_peak),
        "log": ("Stroke", "mm", 1e3 * float(np.ptp(log.position.values))),
        "design": ("Following error", "µm", 1e6 * chosen.peak_to_peak),
        "comparison": (
            "Following error, peak",
            "%",
            facts["comparison"].changes["following_error.peak"].change_percent,
        ),
        "excitation": ("Travel", "mm", 1e3 * float(np.ptp(facts["excitation"].motion.position))),
        "study": ("Median", "µm", 1e6 * runs["metrics"]["following_error.rms"]["median"]),
        "fleet": ("F_C", "N", logs["parameters"]["friction.F_C"]["median"]),
        "operator": ("Error", "mN", 100.0),
    }


@pytest.mark.parametrize("kind", WITH_CARDS)
def test_number_of_a_card_is_that_of_the_results(kind):
    label, unit, value = numbers_of_cards()[kind]
    number, shown = cards_of(kind)[label].split()
    assert (float(number.replace("−", "-")), shown) == (pytest.approx(value, rel=6e-3), unit)


@pytest.mark.parametrize("kind", WITH_VERDICT)
def test_page_and_summary_have_the_same_verdict(kind):
    text, summary, _ = report_of(kind)
    assert f'<strong class="pill {summary["verdict"]["level"]}">' in text
    words = Page(text).words
    # The title of a prediction states the first reason.
    reasons = summary["verdict"]["reasons"][kind == "prediction" : 4]
    assert all(Page(f"<p>{reason}</p>").words[:12] in words for reason in reasons)


@pytest.mark.parametrize("options", [{}, DOUBTED])
def test_verdict_and_warnings_agree(options):
    text, summary, _ = rendered("identification", **options)
    severities = {diagnostic["severity"] for diagnostic in summary["diagnostics"]}
    assert (summary["verdict"]["level"] == "measure_again") == ("error" in severities)
    graves = [
        diagnostic["code"]
        for diagnostic in summary["diagnostics"]
        if diagnostic["severity"] == "error"
    ]
    assert all(SENTENCES[code].means in summary["verdict"]["reasons"] for code in graves)
    assert ('<ul class="warnings">' in text) == bool(summary["warnings"])


@pytest.mark.parametrize("kind", [kind for kind in WITH_VERDICT if kind != "identification"])
def test_usable_verdict_has_no_warnings(kind):
    text, summary, _ = report_of(kind)
    doubts = [
        diagnostic
        for diagnostic in summary.get("diagnostics", ())
        if diagnostic["severity"] != "note"
    ]
    if summary["verdict"]["level"] == "usable":
        assert not doubts
        assert '<ul class="warnings">' not in text


def test_information_criteria_are_only_on_the_page():
    heads = comparison_table(results()["identification"]).heads
    details = {"AIC, above the best", "BIC, above the best", "Condition number"}
    assert (
        set(heads) - set(comparison_table(results()["identification"], details=False).heads)
        == details
    )
    assert all(head in Page(report_of("identification")[0]).words for head in details)

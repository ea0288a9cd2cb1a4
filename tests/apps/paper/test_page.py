"""The report of the source paper: one page, each figure beside the words of the paper, no outside request."""

import json
import re

import pytest
from matplotlib.figure import Figure
from tests.report.pages import Page, without_plots

from bristle.apps.paper import FIGURES, equations, errata, reproduced
from bristle.apps.paper.page import paper_front, paper_report, paper_ruling, paper_summary
from bristle.core.content import NOWHERE
from bristle.files.summary import as_json


@pytest.fixture(scope="module")
def html(paper):
    return paper_report(list(paper.values()), command="bristle paper", provenance={"bristle": "0"})


@pytest.mark.slow
def test_each_figure_has_its_claim_and_its_result(html, paper):
    page = Page(html)
    assert page.unbalanced == []
    ids = [item["id"] for item in page.named("figure")]
    assert [item for item in ids if item.startswith("fig-")] == [
        f"fig-{number}" for number in FIGURES
    ]
    assert len(ids) == len(set(ids))
    for item in paper.values():
        assert " ".join(item.words.quotation.split()) in page.words
        assert " ".join(item.words.differs.split()) in page.words
        assert item.verdict in page.words


@pytest.mark.slow
def test_all_identifiers_are_used_once(html):
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))
    for used in re.findall(r'(?:href="#|url\(#)([^")]+)', html):
        assert used in ids


@pytest.mark.slow
def test_the_page_is_self_contained(html):
    addresses = set(re.findall(r"""(?:src|href)=["']([^"'#][^"']*)""", html)) | set(
        re.findall(r"url\((?!#)[^)]*\)", html)
    )
    assert addresses == set()
    assert "<script" not in without_plots(html)
    # Names of namespaces are no addresses that are asked for.
    assert set(re.findall(r"https?://[^\s\"'<)]+", html)) <= {
        "http://www.w3.org/2000/svg",
        "http://www.w3.org/1999/xlink",
    }


@pytest.mark.slow
def test_every_erratum_is_listed_with_its_kind(html):
    page = Page(html)
    for item in errata.ERRATA:
        assert " ".join(item.correct.split()) in page.words
        assert page.cells.count(item.kind) == len(errata.errata_of(item.kind))
    for what in errata.KINDS.values():
        assert what[1:] in page.words


@pytest.mark.slow
def test_every_equation_is_listed(html):
    cells = Page(html).cells
    for equation in equations.EQUATIONS:
        start = cells.index(equation.title) - 1
        assert cells[start : start + 5] == [
            f"({equation.number})",
            equation.title,
            equation.stands,
            equation.file,
            equation.run,
        ]


@pytest.mark.slow
def test_the_numbers_are_plain_json(paper):
    data = json.loads(as_json(paper_summary(list(paper.values()), provenance={})))
    assert list(data["figures"]) == [str(number) for number in FIGURES]
    for item in data["figures"].values():
        assert set(item) == {"title", "claim", "verdict", "found", "numbers", "experiment"}
    assert data["figures"]["6"]["numbers"]["error_percent"]["tabulated surface"][0] is None


@pytest.mark.slow
def test_the_whole_paper_needs_few_entries(paper, entries):
    assert len(paper) == len(FIGURES) == 14
    assert 10 < len(entries) <= 40


# --- The first page of the report: which claims hold, told by what came out


NONE, PRINTED, PAPER = "none", "printed", "paper"


def rebuilt(number, verdict, **numbers):
    return reproduced.Reproduced(
        number, verdict, [f"It came out as {number}."], Figure, NOWHERE, numbers
    )


def loop(verdict="found in part"):
    return rebuilt(
        12,
        verdict,
        peak_to_peak={NONE: 1.472e-6, PRINTED: 0.613e-6, PAPER: 0.69e-6},
        peak_to_peak_spread={NONE: 0.04e-6, PRINTED: 0.01e-6, PAPER: 0.01e-6},
    )


@pytest.mark.parametrize(
    ("verdicts", "level", "words"),
    [
        (("found", "found"), "usable", "2 of 2 claims"),
        (("found", "shown", "refuted"), "with_care", "1 of 2 claims"),
        (("refuted", "found in part"), "with_care", "0 of 2 claims"),
        (("refuted", "refuted"), "no", "0 of 2 claims"),
        (("found",), "usable", "Its claim holds"),
        (("refuted",), "no", "Its claim does not hold"),
        (("shown",), "with_care", "The figure makes no testable claim"),
    ],
)
def test_the_verdict_counts_the_claims_that_hold(verdicts, level, words):
    ruling = paper_ruling([rebuilt(number, verdict) for number, verdict in enumerate(verdicts, 1)])
    assert ruling.level == level
    assert ruling.words.startswith(words)
    assert len(ruling.reasons) == len(set(verdicts) - {"shown"})


def test_each_claim_is_listed_with_its_figure_by_status():
    reasons = paper_ruling(
        [rebuilt(1, "found"), rebuilt(3, "found"), rebuilt(2, "refuted")]
    ).reasons
    assert reasons == (
        "independent of the setup: 2, LuGre does not close its loop (1), the contact does not drift (3)",
        "does not hold: 1, LuGre drifts (2)",
    )


def test_a_property_built_into_the_rig_is_no_confirmed_claim():
    verdicts = {1: "built in in part", 2: "found", 3: "built in", 8: "calibrated", 9: "built in"}
    ruling = paper_ruling([rebuilt(number, verdict) for number, verdict in verdicts.items()])
    assert ruling.words == "1 of 5 claims of the paper hold here, independently of the setup"
    counted = [reason.partition(",")[0] for reason in ruling.reasons]
    assert counted == [
        "independent of the setup: 1",
        "built into the rig: 2",
        "calibrated: 1",
        "one half independent",
    ]


def test_each_claim_that_can_be_tested_has_its_words():
    assert {number for number in FIGURES if rebuilt(number, "found").words.short} == set(
        FIGURES
    ) - {7}


def test_the_errors_of_the_loop_are_compared_with_those_of_the_paper():
    front = paper_front([loop()])
    assert front.title == "Compensator of the paper: 1.47 → 0.613\u00a0µm peak to peak, ×2.4"
    assert [
        (card.label, card.value.replace("\u00a0", " "), card.remark.replace("\u00a0", " "))
        for card in front.cards
    ] == [
        ("Claims that hold", "0 of 1", ""),
        ("No compensator", "1.472 ± 0.040 µm", "paper: 1.46 µm"),
        ("Its compensator", "0.613 ± 0.010 µm", "paper: 0.69 µm"),
    ]


def test_without_the_loop_there_are_no_cards():
    front = paper_front([rebuilt(3, "found")])
    assert (front.figures, front.cards, front.title) == ((), (), "")


def test_the_page_begins_with_it_and_json_has_it():
    figures = [rebuilt(1, "found"), loop()]
    page = Page(paper_report(figures, command="bristle paper", provenance={}))
    assert "1 of 2 claims of the paper hold here" in page.words
    assert page.words.index("1 of 2 claims") < page.words.index("Claims of the paper")
    assert "holds in part, independent of the setup: 1," in page.words
    assert paper_summary(figures, provenance={})["verdict"]["level"] == "with_care"

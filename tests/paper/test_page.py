"""The report of the source paper: one page, each figure beside the words of the paper, no outside request."""

import json
import re

import pytest
from tests.report.pages import Page, without_plots

from bristle.files.summary import as_json
from bristle.paper import FIGURES, equations, errata, paper_report, paper_summary

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def html(paper):
    return paper_report(list(paper.values()), command="bristle paper", provenance={"bristle": "0"})


def test_each_figure_has_its_claim_and_its_result(html, paper):
    page = Page(html)
    assert page.unbalanced == []
    ids = [item["id"] for item in page.named("figure")]
    assert [item for item in ids if item.startswith("fig-")] == [f"fig-{number}" for number in FIGURES]
    assert len(ids) == len(set(ids))
    for item in paper.values():
        assert " ".join(item.words.quotation.split()) in page.words
        assert " ".join(item.words.differs.split()) in page.words
        assert item.verdict in page.words


def test_all_identifiers_are_used_once(html):
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))
    for used in re.findall(r'(?:href="#|url\(#)([^")]+)', html):
        assert used in ids


def test_the_page_is_self_contained(html):
    addresses = set(re.findall(r"""(?:src|href)=["']([^"'#][^"']*)""", html)) | set(re.findall(r"url\((?!#)[^)]*\)", html))
    assert addresses == set()
    assert "<script" not in without_plots(html)
    # Names of namespaces are no addresses that are asked for.
    assert set(re.findall(r"https?://[^\s\"'<)]+", html)) <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_every_erratum_is_listed_with_its_kind(html):
    page = Page(html)
    for item in errata.ERRATA:
        assert " ".join(item.correct.split()) in page.words
        assert page.cells.count(item.kind) == len(errata.errata_of(item.kind))
    for what in errata.KINDS.values():
        assert what[1:] in page.words


def test_every_equation_is_listed(html):
    cells = Page(html).cells
    for equation in equations.EQUATIONS:
        start = cells.index(equation.title) - 1
        assert cells[start : start + 5] == [f"({equation.number})", equation.title, equation.stands, equation.file, equation.run]


def test_the_numbers_are_plain_json(paper):
    data = json.loads(as_json(paper_summary(list(paper.values()), provenance={})))
    assert list(data["figures"]) == [str(number) for number in FIGURES]
    for item in data["figures"].values():
        assert set(item) == {"title", "claim", "verdict", "found", "numbers", "experiment"}
    assert data["figures"]["6"]["numbers"]["error_percent"]["tabulated surface"][0] is None


def test_the_whole_paper_needs_few_entries(paper, entries):
    assert len(paper) == len(FIGURES) == 14
    assert 10 < len(entries) <= 40

"""A figure inside a page: the same bytes each time, nothing from outside, no identifier twice, and small."""

import html
import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from bristle.figures import inline_svg
from bristle.figures.fit import effort_over_time, residuals
from bristle.figures.style import panels, styled


@styled
def labelled(text):
    figure, ((axes,),) = panels(2.0)
    axes.plot([0.0, 1.0], [0.123456789, 2.0], marker="o")
    axes.set_xlabel(text)
    return figure


def test_the_same_figure_has_the_same_bytes(stage):
    best = stage.identified.best
    assert inline_svg(residuals(best), "a", "") == inline_svg(residuals(best), "a", "")


def test_figures_share_no_identifiers_and_all_references_resolve(stage):
    best = stage.identified.best
    page = inline_svg(residuals(best), "a", "") + inline_svg(residuals(best), "b", "")
    ids = re.findall(r'\bid="([^"]+)"', page)
    assert len(ids) == len(set(ids)) > 4
    assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', page)) <= set(ids)


def test_svg_has_no_external_resources_and_no_dates(stage):
    text = inline_svg(effort_over_time(stage.identified.best), "a", "")
    assert not re.search(r"https?:|<metadata|<!DOCTYPE|<\?xml|xlink", text)


def test_it_is_well_formed_and_described():
    tree = ElementTree.fromstring(inline_svg(labelled("x"), "a", 'effort <& "more">'))
    assert tree.get("role") == "img"
    assert tree.get("aria-label") == 'effort <& "more">'


@pytest.mark.parametrize("text", ["<script>alert(1)</script>", "1.23456789", "$\\alpha$ & co", 'd="M 1.23456"'])
def test_text_is_unchanged(text):
    svg = inline_svg(labelled(text), "a", "")
    assert "<script" not in svg
    assert text in "".join(ElementTree.fromstring(svg).itertext())


def test_a_log_of_25000_samples_stays_small(stage):
    n = 25_000
    rng = np.random.default_rng(0)
    signal = rng.normal(size=n)
    traces = replace(
        stage.identified.best.traces,
        time=1e-3 * np.arange(n),
        velocity=rng.normal(size=n),
        acceleration=rng.normal(size=n),
        measured=signal,
        predicted=signal + rng.normal(size=n),
    )
    fit = replace(stage.identified.best, traces=traces)
    for draw in (effort_over_time, residuals):
        assert len(inline_svg(draw(fit), "a", "")) < 200_000


def test_a_page_knows_where_the_panels_and_their_lines_are():
    svg = inline_svg(labelled("Time [s]"), "a", "")
    (panel,) = json.loads(html.unescape(re.search(r'data-panels="(.*?)"', svg)[1]))
    left, top, right, bottom = panel["box"]
    points = re.search(r'data-curve="0".*?d="(.*?)"', svg, re.DOTALL)[1]
    (x, y), *_ = [tuple(map(float, pair.split())) for pair in re.findall(r"[ML] ([\d.]+ [\d.]+)", points)]
    low, high = panel["x"]["ends"]
    assert x == pytest.approx(left + (0.0 - low) / (high - low) * (right - left), abs=0.05)
    low, high = panel["y"]["ends"]
    assert y == pytest.approx(bottom - (0.123456789 - low) / (high - low) * (bottom - top), abs=0.05)
    assert (panel["x"]["word"], panel["x"]["scale"]) == ("Time [s]", "linear")

"""A figure as a file: text is text, fonts are inside, the ground is white, and the bytes are the same each time."""

import html
import io
import json
import re
import struct
import warnings
import zlib
from dataclasses import replace
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from tests.report.figures.gallery import NAMES, figure_of, gallery

from bristle.core.errors import InputWarning
from bristle.report.figures import figure_file, files, inline_svg, style
from bristle.report.figures.fit import effort_over_time, residuals

FORMATS = ("svg", "pdf", "png")
TWO_COLUMNS = 7.21  # inches: 183 mm


@pytest.fixture(scope="module")
def margins():
    return gallery()["margins"]()


@pytest.fixture(scope="module")
def pdf(margins):
    return figure_file(margins, "pdf", "Poles")


def streams_of(pdf):
    """What lies compressed in a file of PDF, joined."""
    result = []
    for part in re.findall(rb"stream\r?\n(.*?)endstream", pdf, re.DOTALL):
        try:
            result.append(zlib.decompress(part))
        except zlib.error:
            result.append(part)
    return b"\n".join(result)


def test_svg_has_text_on_white_without_external_resources(margins):
    text = figure_file(margins, "svg", "Poles & margins <of a loop>").decode()
    tree = ElementTree.fromstring(text)
    words = " ".join(tree.itertext())
    assert all(
        message in words
        for message in (
            "Frequency [Hz]",
            "small motions",
            "Phase [°]",
            "Poles & margins <of a loop>",
        )
    )
    ground = next(item for item in tree.iter("{http://www.w3.org/2000/svg}path"))
    assert ground.get("style") == "fill: #ffffff"
    assert not re.search(r"<image|@import|<script|dc:date|xlink:href=\"(?!#)", text)


def test_pdf_embeds_fonts_as_letters_not_outlines(pdf):
    whole = pdf + streams_of(pdf)
    assert [part in whole for part in (b"/FontFile2", b"/Type3", b"CreationDate")] == [
        True,
        False,
        False,
    ]
    assert re.search(rb"/Title[^>]*Poles", whole)


def test_a_figure_is_as_wide_as_two_columns_of_a_journal(margins, pdf):
    _, _, wide, _ = re.search(rb"/MediaBox \[ ?([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+)", pdf).groups()
    assert 6.8 < float(wide) / 72.0 < TWO_COLUMNS
    svg = figure_file(margins, "svg", "").decode()
    assert 6.8 < float(re.search(r'width="([\d.]+)pt"', svg)[1]) / 72.0 < TWO_COLUMNS


@pytest.mark.slow
def test_png_has_300_dots_an_inch_on_white(margins):
    png = figure_file(margins, "png", "")
    wide, high = struct.unpack(">II", png[16:24])
    assert wide >= 6.8 * 300
    place = png.index(b"pHYs") + 4
    assert struct.unpack(">I", png[place : place + 4])[0] * 0.0254 == pytest.approx(300.0, rel=1e-3)
    pixels = imread(io.BytesIO(png))
    assert pixels.shape[:2] == (high, wide)
    # White, and nothing shines through.
    assert [pixels[0, 0].min(), pixels[..., 3].min()] == [1.0, 1.0]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("form", FORMATS)
def test_the_same_figure_has_the_same_bytes_for_any_settings(form):
    first = figure_file(gallery()["expected"](), form, "a")
    settings = {
        "font.size": 31,
        "svg.fonttype": "path",
        "pdf.fonttype": 3,
        "savefig.dpi": 20,
        "savefig.facecolor": "red",
    }
    with matplotlib.rc_context(settings):
        assert figure_file(gallery()["expected"](), form, "a") == first
        assert matplotlib.rcParams["svg.fonttype"] == "path"


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMATS)
def test_any_name_can_be_drawn(form):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        assert (
            len(
                figure_file(
                    gallery(NAMES[:2], NAMES)["minor_loops"](),
                    form,
                    "\x00\ud800 \n" + "".join(NAMES),
                )
            )
            > 1000
        )


def test_missing_letters_are_reported_once_and_other_warnings_remain():
    class Lacking(Figure):
        def savefig(self, *_, **__):
            for letter in (36724, 30340):
                warnings.warn(
                    f"Glyph {letter} missing from font(s) DejaVu Sans.", UserWarning, stacklevel=2
                )
            warnings.warn("another", DeprecationWarning, stacklevel=2)

    with pytest.warns() as caught:
        files.figure_file(Lacking(), "png", "")
    assert [(item.category, str(item.message)[:7]) for item in caught] == [
        (DeprecationWarning, "another"),
        (InputWarning, "letters"),
    ]
    assert caught[-1].filename == __file__


def test_a_figure_of_very_many_panels_has_fewer_dots_an_inch_as_png(monkeypatch):
    monkeypatch.setattr(files, "MOST_PIXELS", 1e5)
    sides = np.frombuffer(
        figure_file(Figure(figsize=(3.0, 4.0)), "png", "")[16:24], dtype=">u4"
    ).astype(float)
    assert np.prod(sides) == pytest.approx(1e5, rel=1e-2)


# --- A figure inside a page: the same bytes each time, nothing from outside, no identifier twice, and small


@style.styled
def labelled(text):
    figure, ((axes,),) = style.panels(2.0)
    axes.plot([0.0, 1.0], [0.123456789, 2.0], marker="o")
    axes.set_xlabel(text)
    return figure


def test_the_same_figure_has_the_same_bytes():
    assert inline_svg(labelled("x"), "a", "") == inline_svg(labelled("x"), "a", "")


def test_figures_share_no_identifiers_and_all_references_resolve():
    page = "".join(inline_svg(figure_of("errors_by_loop"), name, "") for name in "ab")
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


@pytest.mark.parametrize(
    "text", ["<script>alert(1)</script>", "1.23456789", "$\\alpha$ & co", 'd="M 1.23456"']
)
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
    (x, y), *_ = [
        tuple(map(float, pair.split())) for pair in re.findall(r"[ML] ([\d.]+ [\d.]+)", points)
    ]
    low, high = panel["x"]["ends"]
    assert x == pytest.approx(left + (0.0 - low) / (high - low) * (right - left), abs=0.05)
    low, high = panel["y"]["ends"]
    assert y == pytest.approx(
        bottom - (0.123456789 - low) / (high - low) * (bottom - top), abs=0.05
    )
    assert (panel["x"]["word"], panel["x"]["scale"]) == ("Time [s]", "linear")


# --- A figure in a notebook is a picture, and the same whatever the notebook has set


def test_a_notebook_shows_the_figure_and_not_its_name():
    draw = gallery()["effort_over_time"]
    picture = draw()._repr_svg_()
    assert picture.lstrip().startswith("<?xml")
    assert "</svg>" in picture
    width, height = (
        float(re.search(rf'<svg[^>]* {side}="([\d.]+)pt"', picture)[1])
        for side in ("width", "height")
    )
    assert 100.0 < height < width
    with matplotlib.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "black"}):
        assert re.findall(r'<path d="[^"]*"', draw()._repr_svg_()) == re.findall(
            r'<path d="[^"]*"', picture
        )


def test_a_figure_has_the_colours_of_the_notebook_and_identifiers_of_its_own():
    one, other = (gallery()[name]()._repr_html_() for name in ("effort_over_time", "minor_loops"))
    for part in (
        "--ink:light-dark(#1b2430,#e8ecf1);",
        '[data-jp-theme-light="false"]',
        "var(--rule,#d5dae0)",
    ):
        assert part in one
    assert not re.search(r"stroke: #[0-9a-f]{6}", one)
    assert re.search(r'aria-label="Figure: [^"]*\[', one)
    identifiers = [set(re.findall(r'\bid="([^"]*)"', html)) for html in (one, other)]
    assert not identifiers[0] & identifiers[1]
    assert all(identifiers)

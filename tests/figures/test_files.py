"""A figure as a file: text is text, fonts are inside, the ground is white, and the bytes are the same each time."""

import re
import struct
import warnings
import zlib
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from tests.figures.gallery import gallery
from tests.figures.hostile_names import NAMES

from bristle.core.errors import InputWarning
from bristle.figures import figure_file, files

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
    assert all(message in words for message in ("Frequency [Hz]", "small motions", "Phase [°]", "Poles & margins <of a loop>"))
    ground = next(item for item in tree.iter("{http://www.w3.org/2000/svg}path"))
    assert ground.get("style") == "fill: #ffffff"
    assert not re.search(r"<image|@import|<script|dc:date|xlink:href=\"(?!#)", text)


def test_pdf_embeds_fonts_as_letters_not_outlines(pdf):
    whole = pdf + streams_of(pdf)
    assert [part in whole for part in (b"/FontFile2", b"/Type3", b"CreationDate")] == [True, False, False]
    assert re.search(rb"/Title[^>]*Poles", whole)


def test_a_figure_is_as_wide_as_two_columns_of_a_journal(margins, pdf):
    _, _, wide, _ = re.search(rb"/MediaBox \[ ?([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+)", pdf).groups()
    assert 6.8 < float(wide) / 72.0 < TWO_COLUMNS
    svg = figure_file(margins, "svg", "").decode()
    assert 6.8 < float(re.search(r'width="([\d.]+)pt"', svg)[1]) / 72.0 < TWO_COLUMNS


def test_png_has_300_dots_an_inch_on_white(margins, tmp_path):
    png = figure_file(margins, "png", "")
    wide, high = struct.unpack(">II", png[16:24])
    assert wide >= 6.8 * 300
    place = png.index(b"pHYs") + 4
    assert struct.unpack(">I", png[place : place + 4])[0] * 0.0254 == pytest.approx(300.0, rel=1e-3)
    (tmp_path / "a.png").write_bytes(png)
    pixels = imread(tmp_path / "a.png")
    assert pixels.shape[:2] == (high, wide)
    assert np.all(pixels[0, 0] == 1.0)
    assert pixels[..., 3].min() == 1.0  # nothing shines through


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("form", FORMATS)
def test_the_same_figure_has_the_same_bytes_for_any_settings(form):
    first = figure_file(gallery()["expected"](), form, "a")
    settings = {"font.size": 31, "svg.fonttype": "path", "pdf.fonttype": 3, "savefig.dpi": 20, "savefig.facecolor": "red"}
    with matplotlib.rc_context(settings):
        assert figure_file(gallery()["expected"](), form, "a") == first
        assert matplotlib.rcParams["svg.fonttype"] == "path"


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMATS)
def test_any_name_can_be_drawn(form):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        assert len(figure_file(gallery(NAMES[:2], NAMES)["minor_loops"](), form, "\x00\ud800 \n" + "".join(NAMES))) > 1000


def test_missing_letters_are_reported_once_and_other_warnings_remain():
    class Lacking(Figure):
        def savefig(self, *_, **__):
            for letter in (36724, 30340):
                warnings.warn(f"Glyph {letter} missing from font(s) DejaVu Sans.", UserWarning, stacklevel=2)
            warnings.warn("another", DeprecationWarning, stacklevel=2)

    with pytest.warns() as caught:
        files.figure_file(Lacking(), "png", "")
    assert [(item.category, str(item.message)[:7]) for item in caught] == [(DeprecationWarning, "another"), (InputWarning, "letters")]
    assert caught[-1].filename == __file__


def test_a_figure_of_very_many_panels_has_fewer_dots_an_inch_as_png(monkeypatch):
    monkeypatch.setattr(files, "MOST_PIXELS", 1e5)
    sides = np.frombuffer(figure_file(Figure(figsize=(3.0, 4.0)), "png", "")[16:24], dtype=">u4").astype(float)
    assert np.prod(sides) == pytest.approx(1e5, rel=1e-2)

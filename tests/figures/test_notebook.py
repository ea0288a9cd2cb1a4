"""A figure in a notebook is a picture, and the same whatever the notebook has set."""

import re

import matplotlib
from tests.figures.gallery import gallery


def test_a_notebook_shows_the_figure_and_not_its_name():
    draw = gallery()["effort_over_time"]
    picture = draw()._repr_svg_()
    assert picture.lstrip().startswith("<?xml")
    assert "</svg>" in picture
    width, height = (float(re.search(rf'<svg[^>]* {side}="([\d.]+)pt"', picture)[1]) for side in ("width", "height"))
    assert 100.0 < height < width
    with matplotlib.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "black"}):
        assert re.findall(r'<path d="[^"]*"', draw()._repr_svg_()) == re.findall(r'<path d="[^"]*"', picture)


def test_a_figure_has_the_colours_of_the_notebook_and_identifiers_of_its_own():
    one, other = (gallery()[name]()._repr_html_() for name in ("effort_over_time", "minor_loops"))
    for part in ("--ink:light-dark(#1b2430,#e8ecf1);", '[data-jp-theme-light="false"]', "var(--rule,#d5dae0)"):
        assert part in one
    assert not re.search(r"stroke: #[0-9a-f]{6}", one)
    assert re.search(r'aria-label="Figure: [^"]*\[', one)
    identifiers = [set(re.findall(r'\bid="([^"]*)"', html)) for html in (one, other)]
    assert not identifiers[0] & identifiers[1]
    assert all(identifiers)

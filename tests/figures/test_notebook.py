"""A figure in a notebook is a picture, and the same whatever the notebook has set."""

import re

import matplotlib
from tests.figures.gallery import gallery


def test_a_notebook_shows_the_figure_and_not_its_name():
    draw = gallery()["following_error"]
    picture = draw()._repr_svg_()
    assert picture.lstrip().startswith("<?xml")
    assert "</svg>" in picture
    width, height = (float(re.search(rf'<svg[^>]* {side}="([\d.]+)pt"', picture)[1]) for side in ("width", "height"))
    assert 300.0 < height < width
    with matplotlib.rc_context({"lines.linewidth": 9.0, "axes.facecolor": "black"}):
        assert re.findall(r'<path d="[^"]*"', draw()._repr_svg_()) == re.findall(r'<path d="[^"]*"', picture)

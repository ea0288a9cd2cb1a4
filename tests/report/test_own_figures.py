"""``report(path, figures=[...])``: figures of the user from Python."""

from pathlib import Path

import numpy as np
import pytest

import bristle as br
from bristle.core import InputError
from bristle.core.errors import InputWarning
from bristle.figures import ReportFigure, style

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_figure.py"


@pytest.fixture(scope="module")
def identified():
    t = np.arange(4000) * 1e-3
    position = 0.02 * np.sin(3.0 * t) + 0.01 * np.sin(11.0 * t)
    velocity = np.gradient(position, t)
    effort = 12.0 * np.gradient(velocity, t) + 5.0 * np.sign(velocity) + 80.0 * velocity
    return br.identify({"time": t, "position": position, "effort": effort}, "coulomb_viscous", draws=0)


def figure(draw, **parts):
    parts = {"title": "Mine", "caption": "What to see.", "alternative": "what", "takes": "identification"} | parts
    return ReportFigure(name="mine", draw=draw, **parts)


@pytest.mark.usefixtures("undrawn")
def test_figures_of_the_user_are_on_the_report(identified, tmp_path):
    mine = figure(lambda identification: style.panels(2.0)[0])
    page = identified.report(tmp_path / "a.html", figures=[EXAMPLE, mine]).read_text(encoding="utf-8")
    assert page.index('id="figure-own-residual-over-position"') < page.index('id="figure-own-mine"')
    without = identified.report(tmp_path / "b.html").read_text(encoding="utf-8")
    assert 'id="further"' not in without


@pytest.mark.slow
def test_failing_figure_gives_a_warning_and_the_report_is_written(identified, tmp_path):
    mine = figure(lambda identification: identification.nothing)
    with pytest.warns(InputWarning, match="mine: the figure mine is not drawn: AttributeError"):
        page = identified.report(tmp_path / "a.html", figures=[mine]).read_text(encoding="utf-8")
    assert "is not drawn: AttributeError" in page
    assert 'id="figure-residuals"' in page


def test_figure_with_unavailable_facts_is_refused(identified, tmp_path):
    with pytest.raises(InputError, match="results that the report of identify lacks"):
        identified.report(tmp_path / "a.html", figures=[figure(lambda motion: None, takes="motion")])
    assert not (tmp_path / "a.html").exists()

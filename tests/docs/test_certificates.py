"""The table of certificates is what comes out, and the numbers that the pages quote are in it."""

import importlib.util
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "theory" / "which-model-fails-which-certificate.md").read_text()

_spec = importlib.util.spec_from_file_location("certificates", DOCS / "images" / "certificates.py")
pictures = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(pictures)


@pytest.fixture(scope="module")
def result():
    return pictures.certificates()


def test_the_table_matches_the_computed_certificates(result):
    assert pictures.table(result) in PAGE, "run: python docs/images/certificates.py"


def test_the_setting_matches_the_page():
    assert (round(pictures.F_C), round(pictures.F_S), round(pictures.STIFFNESS / 1e6)) == (
        126,
        163,
        158,
    )
    assert [round(force) for force in pictures.RIPPLE] == [50, 101]


@pytest.mark.parametrize("draw", ["drift", "closure", "loops"])
def test_pictures_are_drawn_from_every_model(draw, result):
    function = getattr(pictures, draw)
    figure = function(result) if draw != "loops" else function()
    titles = [axes.get_title(loc="right").partition(":")[0] for axes in figure.axes]
    assert titles == list(pictures.MODELS)
    assert (DOCS / "images" / f"certificates-{draw}.svg").is_file()

"""``--figure my_figure.py``: a figure of a person's own on the report, and one that fails costs nothing but itself."""

import csv
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from bristle.core.content import content_of
from bristle.files.permission import is_allowed

pytestmark = pytest.mark.slow

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_figure.py"
PREDICT = ("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--out", "run")
IDENTIFY = ("identify", "log.csv", "--axis", "axis.toml", "--model", "coulomb_viscous", "--draws", "0", "--out", "run")
RUN = ("run", "experiment.toml", "--out", "run")
DESIGN = ("design", "experiment.toml", "--out", "run")
COMPARE = ("compare", "log.csv", "later.csv", "--axis", "axis.toml", "--out", "run")
STUDY = ("study", "study.toml", "--out", "run", "--workers", "1")
STUDY_FILE = """
schema = 1
experiment = "experiment.toml"
runs = 4
seed = 7
[vary]
"friction.F_C" = { normal = ["8 N", "0.5 N"] }
"""
OWN = """import sys
from matplotlib.figure import Figure
from bristle.figures import ReportFigure, style
from bristle.figures.files import Drawing


def draw({takes}):
    figure, ((axes,),) = style.panels(2.0)
    axes.plot([0.0, 1.0], [0.0, 2.0])
    axes.set_xlabel("Time [s]")
    axes.set_ylabel("Force [N]")
    {line}
    return figure


FIGURE = ReportFigure(
    name="mine", title="A <title>", caption="What to see.", alternative="what it is", takes="{takes}", draw=draw)
"""


def own(line="axes.grid(True)", takes="prediction", name="mine.py", **parts):
    text = OWN.format(line=line, takes=takes)
    for part, value in parts.items():
        text = re.sub(rf"\b{part}=\"[^\"]*\"", f"{part}={value!r}", text)
    Path(name).write_text(text, encoding="utf-8")
    return "--figure", name


def page():
    return Path("run/report.html").read_text(encoding="utf-8")


@pytest.fixture
def later(place):
    """The log again, of an axis that follows better; and a study of the experiment."""
    table = np.loadtxt("log.csv", delimiter=",", skiprows=1)
    names = Path("log.csv").read_text().splitlines()[0]
    q, r = names.split(",").index("q"), names.split(",").index("r")
    table[:, q] = table[:, r] + 0.5 * (table[:, q] - table[:, r])
    np.savetxt("later.csv", table, delimiter=",", header=names, comments="", fmt="%.9g")
    Path("study.toml").write_text(STUDY_FILE)
    return place


@pytest.mark.parametrize(
    ("command", "takes"),
    [
        (PREDICT, "log"),
        (RUN, "simulation"),
        (IDENTIFY, "identification"),
        (COMPARE, "comparison"),
        (DESIGN, "design"),
        ((*STUDY, "--run", "2"), "simulation"),
        (STUDY, "study"),
        pytest.param(PREDICT, "prediction", marks=pytest.mark.slow),
    ],
    ids=["log", "run", "identify", "compare", "design", "run of a study", "study", "predict"],
)
def test_a_user_figure_follows_the_others_and_is_a_file(bristle, later, command, takes):
    result = bristle(*command, *own(takes=takes), "--format", "svg", "--format", "csv", "--json")
    assert result.code == 0, result.err
    text = page()
    behind = text.split('<h2 id="further">')[1]
    assert "<h3>A &lt;title&gt;</h3>" in behind
    assert '<figure id="figure-own-mine">' in behind
    assert "<figcaption>What to see.</figcaption>" in behind
    assert 'aria-label="what it is"' in behind
    with Path("run/figures/mine.csv").open(encoding="utf-8") as file:
        head, first, second = csv.reader(file)
    assert (head[4:], first[4:], second[4:]) == (["Time [s]", "Force [N]"], ["0", "0"], ["1", "2"])
    assert Path("run/figures/mine.svg").is_file()
    assert "mine\n" in Path("run/figures/captions.txt").read_text(encoding="utf-8")
    assert result.data["provenance"]["figure"] == "mine.py"
    assert len(result.data["provenance"]["figure_sha256"]) == 64
    assert text.count("<figure id=") == len(list(Path("run/figures").glob("*.svg"))) > 1


def test_the_example_shows_the_residual_along_the_travel(bristle, place):
    shutil.copy(EXAMPLE, "own_figure.py")
    result = bristle(*IDENTIFY, "--figure", "own_figure.py", "--format", "csv")
    assert result.code == 0, result.err
    with Path("run/figures/residual_over_position.csv").open(encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head[4:] == ["Position [mm]", "Residual, mean [N]"]
    assert {row[1] for row in rows} == {"forward", "backward"}
    places = [float(row[4]) for row in rows]
    assert -51.0 < min(places) < -45.0
    assert 45.0 < max(places) < 51.0


def written_in_figures():
    return {file.name for file in Path("run/figures").iterdir()}


def test_a_figure_that_fails_on_saving_omits_only_that_file(bristle, place):
    body = "figure.__class__ = Bad"
    option = own(body)
    bad = (
        "class Bad(Drawing):\n    def savefig(self, file, **options):\n        if options['format'] == 'pdf':\n"
        "            raise ValueError('no pdf')\n        super().savefig(file, **options)\n\n\ndef draw("
    )
    Path("mine.py").write_text(Path("mine.py").read_text().replace("def draw(", bad))
    result = bristle(*PREDICT, *option, "--format", "svg", "--format", "pdf")
    assert result.code == 0
    assert "mine.py, line 10: the figure mine is not written as a file: ValueError: no pdf" in result.err
    assert {"prediction.svg", "prediction.pdf", "mine.svg"} <= written_in_figures()
    assert "mine.pdf" not in written_in_figures()
    assert "mine\n" not in Path("run/figures/captions.txt").read_text(encoding="utf-8")
    assert 'id="figure-own-mine"' in page()


@pytest.mark.parametrize(
    ("command", "parts", "said"),
    [
        (RUN, {"takes": "prediction"}, "results that the report of run lacks; found 'prediction', allowed simulation"),
        (PREDICT, {"takes": "identification"}, "Use the figure with bristle identify"),
        (DESIGN, {"takes": "simulation"}, "Use the figure with bristle identify or bristle run"),
        (COMPARE, {"name": "worst", "takes": "comparison"}, "an invalid name; found 'worst'"),
        (STUDY, {"takes": "comparison"}, "results that the report of study lacks"),
        (PREDICT, {"takes": "model"}, "results that no report has; found 'model'"),
        (PREDICT, {"name": "prediction"}, "an invalid name; found 'prediction'"),
        (PREDICT, {"name": "../mine"}, "an invalid name"),
        (PREDICT, {"caption": " "}, "its figure has no caption"),
        (PREDICT, {"title": ""}, "its figure has no title"),
        (PREDICT, {"alternative": ""}, "its figure has no alternative"),
    ],
)
def test_an_unsuitable_figure_is_refused_before_any_work(bristle, place, command, parts, said):
    own(**{key: value for key, value in parts.items() if key == "takes"})
    text = Path("mine.py").read_text()
    for part, value in parts.items():
        text = re.sub(rf"(FIGURE = (?:.|\n)*?\b{part}=)\"[^\"]*\"", lambda m, value=value: m[1] + repr(value), text)
    Path("mine.py").write_text(text)
    ended = bristle(*command, "--figure", "mine.py")
    assert ended.code == 2
    assert said in ended.err
    assert "mine.py" in ended.err
    assert not Path("run").exists()


def test_naming_a_figure_allows_its_code_and_check_tests_it(bristle, place):
    own("axes.set_title('allowed')")
    checksum = content_of("mine.py").checksum
    assert not is_allowed(checksum)
    result = bristle("check", "mine.py", "--json")
    assert (result.code, result.data["model"]) == (0, "mine")
    assert is_allowed(checksum)
    own("axes.set_ylabel('Force')")
    failed = bristle("check", "mine.py")
    assert failed.code == 1
    assert "Contract of the figure mine" in failed.out
    assert "labelled axes: the axis y, 'Force', has no unit (translational axis)." in failed.err

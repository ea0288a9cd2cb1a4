"""Code of a person: a slot is identified and predicted with, a target is as those of bristle, figures are drawn, and are files."""

import csv
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import typer
from tests.cli.conftest import written_in
from tests.exports.test_targets import EXAMPLE as EXPORTER, target_file
from tests.files.own_slot import AXIS, SLOT, TRUTH, write_bench

from bristle.cli.application import application
from bristle.core.content import content_of
from bristle.files.permission import is_allowed
from bristle.files.results import SUMMARY

# --- a slot ----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_from_the_log_to_the_prediction(bristle, here, monkeypatch):
    write_bench(here)
    models = "coulomb_viscous+oiled.py,coulomb_viscous"
    requested = ("identify", "log.csv", "--axis", "axis.toml", "--model", models, "--draws", "50")
    result = bristle(*requested, "--out", "results", "--json", code=0)
    assert result.data["models"][0]["name"] == "coulomb_viscous+oiled"
    fall = result.data["parameters"]["a"]
    low, high = fall["interval"]
    assert fall["status"] == "identified"
    assert low < TRUTH["a"] < high
    assert high - low < 0.1 * TRUTH["a"]
    assert result.data["parameters"]["b_0"]["status"] == "held"
    errors = [item["metrics"]["force_error_percent"] for item in result.data["models"]]
    assert errors[0] < 0.2 * errors[1]
    assert 'model = "coulomb_viscous+oiled.py"' in Path("results/model.toml").read_text()
    assert Path("results/oiled.py").read_text() == SLOT
    assert result.data["provenance"]["code"] == "oiled.py"

    message = bristle(
        "predict", "results/model.toml", "log.csv", "--axis", "axis.toml", "--json", code=0
    )
    assert message.data["metrics"]["force_error_percent"] == pytest.approx(errors[0], rel=0.1)
    Path("dry.toml").write_text(
        "\n".join(line for line in AXIS.splitlines() if "pressure" not in line)
    )
    for command in (
        ("predict", "results/model.toml", "log.csv"),
        ("identify", "log.csv", "--model", "lugre+oiled.py"),
    ):
        refused = bristle(
            *command,
            "--axis",
            "dry.toml",
            said=(
                "has no pressure, needed by +oiled",
                'pressure = { column = "...", unit = "N/m^2" }',
            ),
        )
        assert refused.code != 0

    monkeypatch.setenv("BRISTLE_STATE_DIR", str(here / "another person"))
    refused = bristle(
        "predict",
        "results/model.toml",
        "log.csv",
        "--axis",
        "axis.toml",
        said=("oiled.py (SHA-256", "needs permission to run"),
    )
    assert refused.code != 0
    assert (
        bristle(
            "predict", "results/model.toml", "log.csv", "--axis", "axis.toml", "--allow-code"
        ).code
        == 0
    )


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_it_is_shown_with_its_channel(bristle, here):
    Path("oiled.py").write_text(SLOT)
    shown = bristle("models", "lugre+oiled.py", "--json").data["models"][0]
    assert shown["name"] == "lugre+oiled"
    assert {"F_S", "a", "b_0"} <= set(shown["parameters"])
    assert shown["channels"] == ["pressure"]
    alone = bristle(
        "models",
        "oiled.py",
        shown="Needs channel pressure of the log: pressure of the oil, >= 0 N/m^2",
    )
    assert "e^" in alone.out or "exp" in alone.out


@pytest.mark.usefixtures("undrawn")
@pytest.mark.slow
def test_it_is_checked(bristle, here):
    Path("oiled.py").write_text(SLOT)
    checked = bristle("check", "oiled.py", "--json", code=0)
    assert checked.data["model"] == "oiled"
    assert {"neutral defaults", "same bits along its channel", "same bits exported"} <= set(
        checked.data["certificates"]
    )
    Path("oiled.py").write_text(
        SLOT.replace('nominal=1e-5, excitation="channel")] = 0.0', 'excitation="channel")] = 1e-6')
    )
    drifted = bristle("check", "oiled.py", "--json", code=1)
    assert drifted.data["certificates"]["neutral defaults"]["passed"] is False


# --- a target --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_a_user_target_is_used_like_a_built_in_target(bristle, place):
    shutil.copy(EXPORTER, "own_exporter.py")
    line = (
        "export",
        "model.toml",
        "--to",
        "own_exporter.py",
        "--speed",
        "200 mm/s",
        "--axis",
        "axis.toml",
    )
    result = bristle(*line, "--name", "knee", "--out", "out", "--json")
    assert (result.code, result.data["target"], result.data["files"]) == (0, "acme", ["knee.toml"])
    assert result.data["provenance"]["target"] == "own_exporter.py"
    assert len(result.data["provenance"]["target_sha256"]) == 64
    assert written_in("out") == {"knee.toml", "summary.json"}
    bristle(*line, "--out", "other", code=0, shown="Note: the drive takes 16 entries")
    assert bristle(*line, "--out", "out").code == 2  # it is there already
    assert (
        bristle(*line, "--tunable", "--out", "third").err.count(
            "acme: does not support parameters that change"
        )
        == 1
    )
    assert not Path("third").exists()


@pytest.mark.usefixtures("undrawn")
def test_a_failing_target_leaves_no_files_and_reports_its_line(bristle, place):
    target_file(place, "1 // 0")
    bristle(
        "export",
        "model.toml",
        "--to",
        "mine.py",
        "--out",
        "out",
        code=2,
        said=("mine.py, line 3: stops with ZeroDivisionError", "bristle check mine.py"),
    )
    assert not Path("out").exists()


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("TARGET =", "TARGETS =", "defines no target of the export"),
        ("name='mine'", "name='c'", "the name of a target of bristle; found 'c'"),
        ("name='mine'", "name='My drive'", "has no valid name"),
        ("description='something'", "description=' '", "target mine: has no valid description"),
        ("write=write", "write=None", "target mine: has no valid write"),
    ],
)
def test_a_file_that_is_no_target_is_refused_before_anything_is_read(
    bristle, place, old, new, said
):
    file = target_file(place)
    file.write_text(file.read_text().replace(old, new))
    bristle(
        "export", "nowhere.toml", "--to", "mine.py", "--out", "out", code=2, said=(said, "mine.py")
    )


@pytest.mark.usefixtures("undrawn")
def test_check_runs_the_contract_of_a_target(bristle, place):
    target_file(place)
    result = bristle("check", "mine.py", "--json")
    assert (result.code, result.data["model"], result.data["passed"]) == (0, "mine", True)
    target_file(place, "Product({'a.txt': 'a'}, ('note',))")
    bristle(
        "check",
        "mine.py",
        code=1,
        said="notes in words: a note is 'note'",
        shown="Contract of the export target mine",
    )


# --- a figure --------------------------------------------------------------------------------------------------------


EXAMPLE = Path(__file__).parents[2] / "examples" / "own_figure.py"
PREDICT = ("predict", "model.toml", "log.csv", "--axis", "axis.toml", "--out", "run")
IDENTIFY = (
    "identify",
    "log.csv",
    "--axis",
    "axis.toml",
    "--model",
    "coulomb_viscous",
    "--draws",
    "0",
    "--out",
    "run",
)
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
from bristle.report.figures import ReportFigure, style
from bristle.report.figures.files import Drawing


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


@pytest.mark.slow
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
    result = bristle(
        *command, *own(takes=takes), "--format", "svg", "--format", "csv", "--json", code=0
    )
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


@pytest.mark.slow
def test_the_example_shows_the_residual_along_the_travel(bristle, place):
    shutil.copy(EXAMPLE, "own_figure.py")
    bristle(*IDENTIFY, "--figure", "own_figure.py", "--format", "csv", code=0)
    with Path("run/figures/residual_over_position.csv").open(encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head[4:] == ["Position [mm]", "Residual, mean [N]"]
    assert {row[1] for row in rows} == {"forward", "backward"}
    places = [float(row[4]) for row in rows]
    assert -51.0 < min(places) < -45.0
    assert 45.0 < max(places) < 51.0


def written_in_figures():
    return {file.name for file in Path("run/figures").iterdir()}


@pytest.mark.slow
def test_a_figure_that_fails_on_saving_omits_only_that_file(bristle, place):
    body = "figure.__class__ = Bad"
    option = own(body)
    bad = (
        "class Bad(Drawing):\n    def savefig(self, file, **options):\n        if options['format'] == 'pdf':\n"
        "            raise ValueError('no pdf')\n        super().savefig(file, **options)\n\n\ndef draw("
    )
    Path("mine.py").write_text(Path("mine.py").read_text().replace("def draw(", bad))
    bristle(
        *PREDICT,
        *option,
        "--format",
        "svg",
        "--format",
        "pdf",
        code=0,
        said="mine.py, line 10: the figure mine is not written as a file: ValueError: no pdf",
    )
    assert {"prediction.svg", "prediction.pdf", "mine.svg"} <= written_in_figures()
    assert "mine.pdf" not in written_in_figures()
    assert "mine\n" not in Path("run/figures/captions.txt").read_text(encoding="utf-8")
    assert 'id="figure-own-mine"' in page()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "parts", "said"),
    [
        (
            RUN,
            {"takes": "prediction"},
            "results that the report of run lacks; found 'prediction', allowed simulation",
        ),
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
        text = re.sub(
            rf"(FIGURE = (?:.|\n)*?\b{part}=)\"[^\"]*\"",
            lambda m, value=value: m[1] + repr(value),
            text,
        )
    Path("mine.py").write_text(text)
    bristle(*command, "--figure", "mine.py", code=2, said=(said, "mine.py"))
    assert not Path("run").exists()


@pytest.mark.slow
def test_naming_a_figure_allows_its_code_and_check_tests_it(bristle, place):
    own("axes.set_title('allowed')")
    checksum = content_of("mine.py").checksum
    assert not is_allowed(checksum)
    result = bristle("check", "mine.py", "--json")
    assert (result.code, result.data["model"]) == (0, "mine")
    assert is_allowed(checksum)
    own("axes.set_ylabel('Force')")
    bristle(
        "check",
        "mine.py",
        code=1,
        said="labelled axes: the axis y, 'Force', has no unit (translational axis).",
        shown="Contract of the figure mine",
    )


# --- figures of every report as files --------------------------------------------------------------------------------


COMMANDS = typer.main.get_command(application()).commands
WITHOUT_FIGURES = {"export", "lab", "demo", "tune"}
WITH_RESULTS = sorted(
    name
    for name, item in COMMANDS.items()
    if name not in WITHOUT_FIGURES and any("--out" in each.opts for each in item.params)
)


@pytest.mark.parametrize("name", WITH_RESULTS)
def test_every_command_with_a_report_accepts_formats(name):
    options = {option for param in COMMANDS[name].params for option in param.opts}
    assert "--format" in options


@pytest.mark.slow
def test_formats_captions_and_numbers_are_in_the_folder_of_the_report(bristle, place):
    bristle(
        "log",
        "log.csv",
        "--axis",
        "axis.toml",
        "--out",
        "run",
        "--format",
        "SVG",
        "--format",
        "csv",
        code=0,
    )
    names = {name.name for name in Path("run/figures").iterdir()}
    assert {"passages.svg", "captions.txt"} <= names
    assert {"passages.pdf", "passages.png"} & names == set()
    tables = [name for name in names if name.endswith(".csv")]
    assert tables
    with (Path("run/figures") / sorted(tables)[0]).open(encoding="utf-8") as file:
        head, *lines = csv.reader(file)
    assert head[:6] == ["panel", "series", "mark", "stroke", "Time [s]", "Position [mm]"]
    assert len(lines) > 100
    assert (Path("run") / SUMMARY).is_file()
    # They are results like all others: replaced with them, and kept once they were changed.
    assert bristle("log", "log.csv", "--axis", "axis.toml", "--out", "run", "--force").code == 0
    assert not Path("run/figures").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("run", "experiment.toml"),
        ("predict", "model.toml", "log.csv", "--axis", "axis.toml"),
        ("identify", "log.csv", "--axis", "axis.toml", "--draws", "0"),
        ("log", "log.csv", "--axis", "axis.toml"),
        ("design", "experiment.toml", "--variant", "base"),
    ],
    ids=lambda item: item[0],
)
def test_each_figure_of_the_page_is_a_file(bristle, place, command):
    assert bristle(*command, "--out", "run", "--format", "svg").code == 0
    page = Path("run/report.html").read_text(encoding="utf-8")
    assert page.count("<figure id=") == len(list(Path("run/figures").glob("*.svg"))) > 0


def test_a_log_with_problems_has_no_figures(bristle, place):
    Path("flat.csv").write_text("t,q\n" + "".join(f"{k},nan\n" for k in range(20)))
    assert bristle("log", "flat.csv", "--out", "run", "--format", "svg").code == 1
    assert not Path("run/figures").exists()


@pytest.mark.slow
def test_figures_of_the_paper_by_their_numbers(bristle, here):
    bristle("paper", "--figure", "4", "--format", "svg", "--format", "csv", "--out", "run", code=0)
    names = {item.name for item in Path("run/figures").iterdir()}
    assert names == {
        "figure-04.svg",
        "captions.txt",
        *(f"figure-04-panel-{k}.csv" for k in range(1, 6)),
    }
    message = Path("run/figures/captions.txt").read_text(encoding="utf-8")
    result = json.loads(Path("run/summary.json").read_text())["figures"]["4"]["found"]
    assert result
    for sentence in result:
        assert sentence in message
    assert "The rig is simulated." in message

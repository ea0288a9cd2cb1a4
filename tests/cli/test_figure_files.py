"""``--format``: the figures of every report as files, beside the report."""

import csv
import json
from pathlib import Path

import pytest
import typer

from bristle.cli.application import app
from bristle.files.results import SUMMARY

COMMANDS = typer.main.get_command(app).commands
WITHOUT_FIGURES = {"bench", "export", "lab", "demo", "tune"}
WITH_RESULTS = sorted(
    name for name, item in COMMANDS.items() if name not in WITHOUT_FIGURES and any("--out" in each.opts for each in item.params)
)


@pytest.mark.parametrize("name", WITH_RESULTS)
def test_every_command_with_a_report_accepts_formats(name):
    options = {option for param in COMMANDS[name].params for option in param.opts}
    assert "--format" in options


def test_formats_captions_and_numbers_are_in_the_folder_of_the_report(bristle, place):
    result = bristle("log", "log.csv", "--axis", "axis.toml", "--out", "run", "--format", "SVG", "--format", "csv")
    assert result.code == 0, result.err
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


def test_figures_of_the_paper_by_their_numbers(bristle, here):
    result = bristle("paper", "--figure", "4", "--format", "svg", "--format", "csv", "--out", "run")
    assert result.code == 0, result.err
    names = {item.name for item in Path("run/figures").iterdir()}
    assert names == {"figure-04.svg", "captions.txt", *(f"figure-04-panel-{k}.csv" for k in range(1, 6))}
    message = Path("run/figures/captions.txt").read_text(encoding="utf-8")
    result = json.loads(Path("run/summary.json").read_text())["figures"]["4"]["found"]
    assert result
    for sentence in result:
        assert sentence in message
    assert "The rig is simulated." in message

"""Figures of a report as separate files in several formats, with captions and numbers."""

import csv
from pathlib import Path

import pytest
from tests.figures.gallery import gallery

from bristle.core import InputError
from bristle.files.results import results_folder
from bristle.report.page import Plate, picture, plates
from bristle.report.results import captions, figure_files

DRAW = gallery()


def write(out: Path, formats=(), names=("expected", "errors_by_loop")) -> dict[str, int]:
    """Draw figures for a report; return the sizes of the files."""
    with results_folder(out) as folder, figure_files(folder, formats):
        for name in names:
            picture(name.replace("_", "-"), DRAW[name], "what it is", "what to see: 5 um, at F_s")
        folder.write("report.html", "")
    return {item.name: item.stat().st_size for item in (out / "figures").glob("*")}


@pytest.fixture
def unencoded(monkeypatch):
    """Figures become files of their format's name: what is in them is said elsewhere."""
    monkeypatch.setattr("bristle.figures.figure_file", lambda figure, form, title: form.encode())


@pytest.mark.usefixtures("unencoded")
def test_each_figure_is_written_in_each_format_with_its_numbers(tmp_path):
    result = write(tmp_path / "run", ["svg", "pdf", "png", "csv", "svg"])
    files = {f"{name}.{form}" for name in ("expected", "errors-by-loop") for form in ("svg", "pdf", "png")}
    assert set(result) == files | {"expected-panel-1.csv", "expected-panel-2.csv", "errors-by-loop.csv", "captions.txt"}
    with (tmp_path / "run/figures/errors-by-loop.csv").open(encoding="utf-8") as file:
        assert next(csv.reader(file))[4:7] == ["Error [µm]", "Loop", "name at y"]


def test_captions_are_written_only_for_pictures(tmp_path):
    assert set(write(tmp_path / "a", ["csv"], names=("errors_by_loop",))) == {"errors-by-loop.csv"}
    assert write(tmp_path / "b") == {}
    assert not (tmp_path / "b/figures").exists()


@pytest.mark.parametrize("formats", [["svg"], ["csv"]])
def test_figures_without_a_folder_are_refused_early(formats):
    with pytest.raises(InputError, match="--format"), figure_files(None, formats):
        pytest.fail("the work must not begin")


def test_captions_list_each_figure_by_file_name():
    text = captions([Plate("figure-06-economy", None, "short", "at 5 um of F_s"), Plate("other", None, "", "second")])
    assert text == "figure-06-economy\n  at 5 µm of F_s\n\nother\n  second\n"


def test_each_collector_keeps_only_its_figures():
    with plates() as outer:
        picture("a", DRAW["expected"], "", "one", file="first", published="another")
        with plates() as inner:
            picture("b", DRAW["expected"], "", "two")
    picture("c", DRAW["expected"], "", "three")
    assert [(item.name, item.caption) for item in outer] == [("first", "another")]
    assert [(item.name, item.caption) for item in inner] == [("b", "two")]


def test_report_does_not_depend_on_figure_files(tmp_path):
    alone = picture("a", DRAW["errors_by_loop"], "x", "y")
    with results_folder(tmp_path / "run") as folder, figure_files(folder, ["svg", "csv"]):
        assert picture("a", DRAW["errors_by_loop"], "x", "y") == alone

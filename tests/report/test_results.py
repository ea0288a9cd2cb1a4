"""File names of a result, its figures with captions, and logs of simulated variants."""

import csv
from pathlib import Path
from types import SimpleNamespace as Some

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.report.figures.gallery import gallery
from tests.report.known import columns

import bristle as br
from bristle.core import InputError, InputWarning
from bristle.files.results import results_folder
from bristle.report import page, results
from bristle.report.figures import ReportFigure, style
from bristle.report.page import FaultWarning, Plate, picture, plates


@pytest.mark.parametrize(
    ("names", "files"),
    [
        (["any thing"], ["log.csv"]),
        (["as recorded", "b.2-c"], ["log_as_recorded.csv", "log_b.2-c.csv"]),
        (["x" * 200, "b"], [f"log_{'x' * 200}.csv", "log_b.csv"]),
        (["x" * 201, "b"], ["log_1.csv", "log_2.csv"]),  # too long for a file
    ],
)
def test_names_of_variants_are_names_of_files(names, files):
    assert results.log_names(names) == dict(zip(names, files, strict=True))


class Folder(dict):
    def write(self, name, content):
        self[name] = content

    def __truediv__(self, name):
        return name


def plate(name="one", own=False, panels=1):
    figure = Figure()
    for axes in np.ravel(figure.subplots(1, panels)):
        axes.plot([0.0, 1.0], [0.0, 1.0])
    return Plate(name, figure, "a figure", "See  5 N*m.", own)


def test_each_panel_has_a_separate_csv_file():
    for panels, forms, files in (
        (1, ["csv", "svg"], ["one.csv", "one.svg"]),
        (2, ["csv"], ["one-panel-1.csv", "one-panel-2.csv"]),
    ):
        folder = Folder()
        assert results._is_written(folder, plate(panels=panels), forms)
        assert list(folder) == [f"figures/{file}" for file in files]


@pytest.mark.parametrize(("own", "category"), [(True, InputWarning), (False, FaultWarning)])
def test_unwritable_figure_gives_a_warning(own, category, monkeypatch):
    def fails(*_):
        raise ValueError("a fault")

    monkeypatch.setattr("bristle.report.figures.figure_file", fails)
    with pytest.warns(
        InputWarning, match=r"the figure one is not written as a file: ValueError: a fault$"
    ) as caught:
        assert not results._is_written(Folder(), plate(own=own), ["svg"])
    assert caught[0].category is category


def test_full_disk_is_an_error():
    def fails(*_):
        raise OSError

    with pytest.raises(OSError):
        results._is_written(Some(write=fails), plate(), ["csv"])


@pytest.mark.parametrize(
    ("formats", "with_captions"),
    [(["csv"], False), (["svg"], True), (["csv", "svg", "svg"], True), ([], False), (None, False)],
)
def test_captions_are_written_with_figures(formats, with_captions):
    folder = Folder()
    with results.figure_files(folder, formats):
        page._plates.get().append(plate())
    assert ("figures/captions.txt" in folder) is with_captions
    assert len(folder) == len(set(formats or ())) + with_captions


def test_no_figures_need_no_folder_and_leave_no_captions():
    with results.figure_files(None, ()):
        page._plates.get().append(plate())
    folder = Folder()
    with results.figure_files(folder, ["svg"]):
        pass
    assert folder == {}


@pytest.mark.parametrize("is_open", [True, False])
def test_log_of_a_variant_is_the_record_of_its_drive(is_open, monkeypatch):
    written = {}
    monkeypatch.setattr(results, "log_text", lambda *of: of)
    monkeypatch.setattr(results, "write_whole", lambda name, of: written.update({name: of}))
    outcome = Some(time=1, measured=2, command=3, reference=4, is_open=is_open)
    variants = [
        Some(name=name, axis=axis, plant=Some(kind="rotational"))
        for name, axis in (("a", None), ("b", "known"), ("gone", None))
    ]
    result = Some(variants={"a": outcome, "b": outcome}, experiment=Some(variants=variants))
    assert results.write_logs(Folder(), result) == {"a": "log_a.csv", "b": "log_b.csv"}
    (axis, signals), (known, _) = (written.pop(f"log_{name}.csv") for name in "ab")
    assert (axis.kind, known, written) == ("rotational", "known", {})
    assert signals == {"time": 1, "position": 2, "effort": 3} | (
        {} if is_open else {"reference": 4}
    )


# --- Figures of a report as separate files in several formats, with captions and numbers


DRAW = gallery()


def test_each_figure_is_written_in_each_format_with_its_numbers(tmp_path, monkeypatch):
    # What is in the files is said elsewhere.
    monkeypatch.setattr(
        "bristle.report.figures.figure_file", lambda figure, form, title: form.encode()
    )
    with (
        results_folder(tmp_path / "run") as folder,
        results.figure_files(folder, ["svg", "pdf", "png", "csv", "svg"]),
    ):
        for name in ("expected", "errors_by_loop"):
            picture(name.replace("_", "-"), DRAW[name], "what it is", "what to see: 5 um, at F_s")
        folder.write("report.html", "")
    files = {
        f"{name}.{form}"
        for name in ("expected", "errors-by-loop")
        for form in ("svg", "pdf", "png")
    }
    assert {item.name for item in (tmp_path / "run/figures").iterdir()} == files | {
        "expected-panel-1.csv",
        "expected-panel-2.csv",
        "errors-by-loop.csv",
        "captions.txt",
    }
    with (tmp_path / "run/figures/errors-by-loop.csv").open(encoding="utf-8") as file:
        assert next(csv.reader(file))[4:7] == ["Error [µm]", "Loop", "name at y"]


@pytest.mark.parametrize("formats", [["svg"], ["csv"]])
def test_figures_without_a_folder_are_refused_early(formats):
    with (
        pytest.raises(InputError, match="--format: needs a folder"),
        results.figure_files(None, formats),
    ):
        pytest.fail("the work must not begin")


def test_captions_list_each_figure_by_file_name():
    text = results.captions(
        [
            Plate("figure-06-economy", None, "short", "at  5 um of F_s"),
            Plate("other", None, "", "second"),
        ]
    )
    assert text == "figure-06-economy\n  at 5 µm of F_s\n\nother\n  second\n"


def test_each_collector_keeps_only_its_figures():
    with plates() as outer:
        picture("a", DRAW["expected"], "", "one", file="first", published="another")
        with plates() as inner:
            picture("b", DRAW["expected"], "", "two")
    picture("c", DRAW["expected"], "", "three")
    assert [[(item.name, item.caption) for item in each] for each in (outer, inner)] == [
        [("first", "another")],
        [("b", "two")],
    ]


def test_report_does_not_depend_on_figure_files(tmp_path):
    alone = picture("a", DRAW["errors_by_loop"], "x", "y")
    with results_folder(tmp_path / "run") as folder, results.figure_files(folder, ["svg", "csv"]):
        assert picture("a", DRAW["errors_by_loop"], "x", "y") == alone


# --- ``report(path, figures=[...])``: figures of the user from Python


EXAMPLE = Path(__file__).parents[2] / "examples" / "own_figure.py"


@pytest.fixture(scope="module")
def identified():
    return br.identify(columns(), "coulomb_viscous", draws=0)


def figure(draw, **parts):
    parts = {
        "title": "Mine",
        "caption": "What to see.",
        "alternative": "what",
        "takes": "identification",
    } | parts
    return ReportFigure(name="mine", draw=draw, **parts)


@pytest.mark.usefixtures("undrawn")
def test_figures_of_the_user_are_on_the_report(identified, tmp_path):
    mine = figure(lambda identification: style.panels(2.0)[0])
    page = identified.report(tmp_path / "a.html", figures=[EXAMPLE, mine]).read_text(
        encoding="utf-8"
    )
    assert page.index('id="figure-own-residual-over-position"') < page.index('id="figure-own-mine"')
    assert 'id="further"' not in identified.report(tmp_path / "b.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_failing_figure_gives_a_warning_and_the_report_is_written(identified, tmp_path):
    mine = figure(lambda identification: identification.nothing)
    with pytest.warns(InputWarning, match="mine: the figure mine is not drawn: AttributeError"):
        page = identified.report(tmp_path / "a.html", figures=[mine]).read_text(encoding="utf-8")
    assert "is not drawn: AttributeError" in page
    assert 'id="figure-residuals"' in page


def test_figure_with_unavailable_facts_is_refused(identified, tmp_path):
    with pytest.raises(InputError, match="results that the report of identify lacks"):
        identified.report(
            tmp_path / "a.html", figures=[figure(lambda motion: None, takes="motion")]
        )
    assert not (tmp_path / "a.html").exists()

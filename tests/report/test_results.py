"""File names of a result, its figures with captions, and logs of simulated variants."""

from types import SimpleNamespace as Some

import numpy as np
import pytest
from matplotlib.figure import Figure

from bristle.core import InputError, InputWarning
from bristle.report import page, results
from bristle.report.page import FaultWarning, Plate
from bristle.report.results import _is_written, captions, figure_files, log_names, write_logs


def test_log_of_a_single_variant_is_log_csv():
    assert log_names(["any thing"]) == {"any thing": "log.csv"}
    assert log_names(["as recorded", "b.2-c"]) == {"as recorded": "log_as_recorded.csv", "b.2-c": "log_b.2-c.csv"}


@pytest.mark.parametrize(("letters", "numbered"), [(200, False), (201, True)])
def test_names_too_long_for_a_file_are_numbered(letters, numbered):
    assert (log_names(["x" * letters, "b"])["b"] == "log_2.csv") is numbered


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
    folder = Folder()
    assert _is_written(folder, plate(), ["csv", "svg"])
    assert list(folder) == ["figures/one.csv", "figures/one.svg"]
    folder.clear()
    assert _is_written(folder, plate(panels=2), ["csv"])
    assert list(folder) == ["figures/one-panel-1.csv", "figures/one-panel-2.csv"]


@pytest.mark.parametrize(("own", "category"), [(True, InputWarning), (False, FaultWarning)])
def test_unwritable_figure_gives_a_warning(own, category, monkeypatch):
    def fails(*_):
        raise ValueError("a fault")

    monkeypatch.setattr("bristle.figures.figure_file", fails)
    with pytest.warns(InputWarning, match=r"the figure one is not written as a file: ValueError: a fault$") as caught:
        assert not _is_written(Folder(), plate(own=own), ["svg"])
    assert caught[0].category is category


def test_full_disk_is_an_error():
    def fails(*_):
        raise OSError

    with pytest.raises(OSError):
        _is_written(Some(write=fails), plate(), ["csv"])


def test_captions_are_listed_by_file_name():
    assert captions([plate(), plate("two")]) == "one\n  See 5 N·m.\n\ntwo\n  See 5 N·m.\n"


@pytest.mark.parametrize(
    ("formats", "with_captions"), [(["csv"], False), (["svg"], True), (["csv", "svg", "svg"], True), ([], False), (None, False)]
)
def test_captions_are_written_with_figures(formats, with_captions):
    folder = Folder()
    with figure_files(folder, formats):
        page._plates.get().append(plate())
    assert ("figures/captions.txt" in folder) is with_captions
    assert len(folder) == len(set(formats or ())) + with_captions


def test_figures_need_a_folder():
    with pytest.raises(InputError, match="--format: needs a folder"), figure_files(None, ["svg"]):
        pass
    with figure_files(None, ()):
        page._plates.get().append(plate())
    folder = Folder()
    with figure_files(folder, ["svg"]):
        pass
    assert folder == {}


@pytest.mark.parametrize("is_open", [True, False])
def test_log_of_a_variant_is_the_record_of_its_drive(is_open, monkeypatch):
    written = {}
    monkeypatch.setattr(results, "write_log", lambda name, axis, signals: written.update({name: (axis, signals)}))
    outcome = Some(time=1, measured=2, command=3, reference=4, is_open=is_open)
    variants = [Some(name=name, axis=axis, plant=Some(kind="rotational")) for name, axis in (("a", None), ("b", "known"), ("gone", None))]
    result = Some(variants={"a": outcome, "b": outcome}, experiment=Some(variants=variants))
    assert write_logs(Folder(), result) == {"a": "log_a.csv", "b": "log_b.csv"}
    assert set(written) == {"log_a.csv", "log_b.csv"}
    axis, signals = written["log_a.csv"]
    assert axis.kind == "rotational"
    assert signals == {"time": 1, "position": 2, "effort": 3} | ({} if is_open else {"reference": 4})
    assert written["log_b.csv"][0] == "known"

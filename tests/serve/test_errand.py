"""What a job is to do, and what it leaves: curves of few points, archives that are alike."""

import zipfile
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from bristle.core.errors import InputError
from bristle.files import NOTE
from bristle.server.errand import BUCKETS, Errand, thinned, zipped


def errand_of(tmp_path, **changed):
    """An errand as the server asks for it."""
    request = {
        "folder": str(tmp_path),
        "logs": [(str(tmp_path / "file-1"), "log.csv", "fit"), (str(tmp_path / "file-2"), "later.csv", "held_out")],
        "axis_text": "schema = 1\n",
        "axis_label": "stage.toml",
        "options": {},
        "size_limit": 1000,
        "results": None,
    }
    return Errand.of(request | changed, lambda share, text: None, nullcontext)


def test_an_errand_is_the_request_of_the_server(tmp_path):
    errand = errand_of(tmp_path, results=str(tmp_path / "results"))
    assert (errand.folder, errand.model) == (tmp_path, tmp_path / "results")
    assert [(log.label, log.role, log.place.name) for log in errand.logs] == [
        ("log.csv", "fit", "file-1"),
        ("later.csv", "held_out", "file-2"),
    ]
    assert [log.label for log in errand.fitted] == ["log.csv"]
    assert (errand.axis_file.source, errand.size_limit) == (Path("stage.toml"), 1000)


def test_a_log_is_its_bytes_under_its_label(tmp_path):
    (tmp_path / "file-1").write_bytes(b"time,x\n")
    content = errand_of(tmp_path).fitted[0].content
    assert (content.source, bytes(content.data)) == (Path("log.csv"), b"time,x\n")


def test_missing_files_are_reported(tmp_path):
    with pytest.raises(InputError, match="Drop a log to fit"):
        _ = errand_of(tmp_path, logs=[("file-2", "later.csv", "held_out")]).fitted
    with pytest.raises(InputError, match="Identify a model first"):
        _ = errand_of(tmp_path).model


def test_options_are_text_and_whole_numbers(tmp_path):
    errand = errand_of(tmp_path, options={"name": "  x axis ", "points": 12, "draws": -1, "models": 3})
    assert (errand.text("name"), errand.text("target", "table"), errand.text("travel")) == ("x axis", "table", "")
    assert (errand.count("points", 20), errand.count("others", 20)) == (12, 20)
    for ask in (lambda: errand.count("draws", 1), lambda: errand.text("models")):
        with pytest.raises(InputError):
            ask()


def test_a_short_curve_keeps_all_of_its_points():
    time, signal = np.arange(2.0 * BUCKETS), np.sin(np.arange(2.0 * BUCKETS))
    rows = thinned(time, signal, 2.0 * signal)
    assert [len(row) for row in rows] == 3 * [2 * BUCKETS]
    assert rows[0] == time.tolist()
    assert rows[2] == pytest.approx(2.0 * signal, rel=1e-7)
    assert [len(thinned(np.arange(float(count)), np.arange(float(count)))[0]) for count in (3000, 3001)] == [3000, 3000]


def test_a_long_curve_keeps_its_ends_and_every_extreme():
    count = 40 * BUCKETS
    signal = np.random.default_rng(1).normal(size=count)
    signal[12_345], signal[54_321] = 50.0, -60.0
    time, first, second = thinned(np.arange(float(count)), signal, np.arange(float(count)))
    assert len(time) == len(first) == len(second) <= 2 * BUCKETS + 2
    assert (time[0], time[-1]) == (0.0, count - 1.0)
    assert time == sorted(set(time))
    assert second == time
    assert (first[time.index(12_345.0)], first[time.index(54_321.0)]) == (50.0, -60.0)
    # Nearly each stretch of forty samples keeps its largest and its smallest one: edges are rounded.
    whole, kept = signal.reshape(BUCKETS, 40), set(np.round(first, 5))
    for extremes in (whole.max(axis=1), whole.min(axis=1)):
        assert len(set(np.round(extremes, 5)) & kept) > 0.95 * BUCKETS


def test_a_missing_number_is_a_gap_on_the_page():
    rows = thinned(np.arange(3.0), np.array([1.0, np.nan, np.inf]))
    assert rows == [[0.0, 1.0, 2.0], [1.0, None, None]]
    gap = np.where(np.arange(4.0 * BUCKETS) < 10, np.nan, 1.0)
    assert thinned(np.arange(gap.size), gap)[1][0] is None


def test_curves_have_eight_digits():
    assert thinned(np.zeros(1), np.array([1.0 / 3.0]))[1] == [0.33333333]


def test_the_same_files_make_the_same_archive_without_the_note(tmp_path):
    archives = []
    for name in ("one", "other"):
        folder = tmp_path / name
        (folder / "figures").mkdir(parents=True)
        for file, text in (("b.csv", "1,2\n" * 500), ("a.txt", "first"), ("figures/a.svg", "<svg/>"), (NOTE, name)):
            (folder / file).write_text(text)
        zipped(folder)
        archives.append((tmp_path / f"{name}.zip").read_bytes())
    assert archives[0] == archives[1]
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        assert archive.namelist() == ["a.txt", "b.csv", "figures/a.svg"]
        assert archive.read("a.txt") == b"first"
        packed = archive.getinfo("b.csv")
        assert packed.compress_size < packed.file_size // 10

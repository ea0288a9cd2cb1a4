"""A study as a labelled data set."""

import sys

import numpy as np
import pytest
from tests.study.conftest import STUDY

import bristle as br
from bristle.study import run_study

GRID = STUDY.replace("[keep]", '[grid]\n"effort.frequency" = ["2 Hz", "4 Hz"]\n[keep]').replace("runs = 12", "runs = 4")


def test_a_study_is_read_with_its_units(bench):
    run_study(bench.study(), bench.folder / "out", workers=1)
    data = br.read_study(bench.folder / "out")
    assert dict(data.sizes) == {"run": 12}
    assert data["friction.F_C"].attrs == {"units": "N", "role": "drawn"}
    assert data["motion.peak_to_peak"].attrs["units"] == "m"
    assert data.run.values.tolist() == list(range(12))
    assert set(data.status.values) == {"ok"}
    assert data.attrs["seed"] == 7


def test_a_grid_becomes_dimensions(bench):
    run_study(bench.study(GRID), bench.folder / "out", workers=1)
    data = br.read_study(bench.folder / "out")
    assert dict(data.sizes) == {"draw": 4, "effort.frequency": 2}
    assert data["effort.frequency"].values.tolist() == [2.0, 4.0]
    assert data["effort.frequency"].attrs["units"] == "Hz"
    assert data["run"].values.tolist() == [[0, 1], [2, 3], [4, 5], [6, 7]]
    # One draw is the same at both frequencies, and its axis moves differently.
    assert np.all(data["friction.F_C"].values[:, 0] == data["friction.F_C"].values[:, 1])
    assert np.all(data["motion.peak_to_peak"].values[:, 0] != data["motion.peak_to_peak"].values[:, 1])


def test_missing_runs_are_nan(bench):
    run_study(bench.study(GRID), bench.folder / "out", workers=1)
    (bench.folder / "out" / "runs" / "0000000004.parquet").unlink()
    data = br.read_study(bench.folder / "out")
    assert data["run"].values[2:].tolist() == [[-1, -1], [-1, -1]]
    assert np.all(np.isnan(data["motion.peak_to_peak"].values[2:]))
    assert np.all(np.isfinite(data["motion.peak_to_peak"].values[:2]))


def test_a_folder_without_a_study_is_refused(tmp_path):
    with pytest.raises(br.core.InputError, match=r"has no study[.]json"):
        br.read_study(tmp_path)


def test_without_pyarrow_the_install_command_is_shown(bench, monkeypatch):
    run_study(bench.study(), bench.folder / "out", workers=1)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    for message in (lambda: br.read_study(bench.folder / "out"), lambda: run_study(bench.study(), bench.folder / "new")):
        with pytest.raises(br.core.errors.MissingExtraError, match=r'bristle study .* pip install "bristle\[study\]"'):
            message()

"""Many logs, each a row: numbers with intervals, failures with reasons, gone on with, grown, and killed."""

import json
import os
import sys

import numpy as np
import pytest
from tests.apps.study.conftest import content
from tests.apps.study.fleet.conftest import AXIS, OPTIONS, write_log
from tests.apps.study.processes import end_once

import bristle as br
import bristle.apps.study.fleet.identify as module
from bristle.apps.study.fleet.identify import Identifier
from bristle.apps.study.store import runs_in
from bristle.core.axis import Column
from bristle.core.errors import InputError
from bristle.identification.result import Identification

pytestmark = pytest.mark.usefixtures("undrawn")


def each(logs, out, **options):
    return br.apps.study.fleet.identify_each(
        [logs] if not isinstance(logs, list) else logs,
        out,
        axis=AXIS,
        **OPTIONS | {"workers": 1} | options,
    )


@pytest.mark.slow
def test_every_log_is_a_row_and_a_failed_log_has_its_reason(logs, tmp_path):
    assert each(logs, tmp_path / "out").is_whole
    data = br.read_study(tmp_path / "out")
    assert data["log"].values.tolist() == [f"press_2026-03-0{day}T06-30.csv" for day in (1, 2, 3)]
    assert set(data["folder"].values.tolist()) == {"press_3"}
    assert data["status"].values.tolist() == ["ok", "ok", "refused"]
    assert "press_2026-03-03T06-30.csv" in data["reason"].values[2]
    assert np.datetime_as_string(data["time_of_log"].values[1], "m") == "2026-03-02T06:30"
    alone = br.identify(
        logs / "press_2026-03-02T06-30.csv", "coulomb_viscous", axis=AXIS, **OPTIONS
    )
    level = alone.parameters["F_C"]
    assert float(data["friction.F_C"][1]) == level.value == pytest.approx(5.5, rel=0.02)
    half = 0.5 * float(data["friction.F_C.upper"][1] - data["friction.F_C.lower"][1])
    assert half == pytest.approx(1.96 * max(level.std, level.robust_std), rel=1e-3)
    assert data["friction.F_C"].attrs["units"] == "N"
    assert float(data["held_out_error"][1]) == pytest.approx(
        0.01 * alone.best.held_out.mean_percent
    )
    assert float(data["temperature"][0]) == 293.0
    assert data["plant.M.status"].values.tolist()[:2] == ["held", "held"]
    assert np.isnan(data["friction.F_C"].values[2])


@pytest.mark.slow
def test_intervals_and_scatter_are_those_of_the_draws(logs, tmp_path):
    first = logs / "press_2026-03-01T06-30.csv"
    each([first], tmp_path / "out", draws=20)
    row = {name: column[0] for name, column in runs_in(tmp_path / "out").columns.items()}
    alone = br.identify(first, "coulomb_viscous", axis=AXIS, draws=20, blocks=2)
    assert (row["friction.F_C.lower"], row["friction.F_C.upper"]) == alone.parameters[
        "F_C"
    ].interval
    scatter = alone.best.resampling.scatter
    assert (row["scatter"], row["scatter.lower"], row["scatter.upper"]) == tuple(scatter)


@pytest.mark.slow
def test_a_fleet_continues_and_grows_and_logs_keep_their_numbers(logs, tmp_path, monkeypatch):
    each(logs, tmp_path / "out")
    (tmp_path / "out" / "runs" / "0000000001.parquet").unlink()
    # Sorts between those that are there.
    write_log(logs / "press_2026-03-02T01-00.csv", 5.2, seed=9)
    identified, columns = [], Identifier.columns
    monkeypatch.setattr(
        Identifier,
        "columns",
        lambda self, block: identified.append(block.first) or columns(self, block),
    )
    each(logs, tmp_path / "out")
    assert identified == [1, 3]
    names = [
        entry["log"] for entry in json.loads((tmp_path / "out" / "study.json").read_text())["logs"]
    ]
    assert names == [
        f"press_2026-03-0{day}.csv" for day in ("1T06-30", "2T06-30", "3T06-30", "2T01-00")
    ]
    identified.clear()
    # The others are not named, and stay.
    each([logs / "press_2026-03-02T01-00.csv"], tmp_path / "out")
    assert identified == []
    assert runs_in(tmp_path / "out").count == 4


@pytest.mark.slow
def test_a_changed_log_and_another_model_are_refused(logs, tmp_path):
    each(logs, tmp_path / "out")
    before = content(tmp_path / "out")
    write_log(logs / "press_2026-03-01T06-30.csv", 7.0)
    with pytest.raises(
        InputError, match=r"already in this fleet, with different content.*name another folder"
    ):
        each(logs, tmp_path / "out")
    with pytest.raises(InputError, match='"coulomb_viscous" and is now "stribeck"'):
        each(logs, tmp_path / "out", model="stribeck")
    assert content(tmp_path / "out") == before


def test_wrong_arguments_are_refused_before_any_work(logs, tmp_path):
    first = logs / "press_2026-03-01T06-30.csv"
    for names, message in (
        ([logs / "gone.csv"], "there is no such file"),
        ([logs, first], "is named twice"),
        ([f"{first}::*"], "contains no table with such a name.*allowed a file with several tables"),
    ):
        with pytest.raises(InputError, match=message):
            each(names, tmp_path / "out")
    several = {"model": "coulomb,stribeck"}, "takes one model"
    misspelt = {"cutof": 5}, "cutof: is no argument of identify. Did you mean 'cutoff'"
    negative = {"mass": -1.0}, "mass: out of range"
    unknown = {"settings": {"no_such": 1}}, "no_such: is not a threshold"
    for options, message in (
        several,
        misspelt,
        negative,
        unknown,
        ({"cutoff": -1.0}, "cutoff: must be positive"),
    ):
        with pytest.raises(InputError, match=message):
            each(logs, tmp_path / "out", **options)
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="holds no log"):
        each(tmp_path / "empty", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_tables_of_a_file_are_logs(tmp_path):
    t = np.arange(3000) * 1e-3
    tables = {
        f"test_{k}": np.column_stack((t, np.sin((3.0 + k) * t), np.sign(np.cos((3.0 + k) * t))))
        for k in (1, 2)
    }
    np.savez(tmp_path / "all.npz", **tables, rest=np.zeros((3000, 3)))
    columns = {
        name: Column(f"column_{k}", "", unit)
        for k, (name, unit) in enumerate((("time", "s"), ("position", "m"), ("effort", "N")), 1)
    }
    br.apps.study.fleet.identify_each(
        [f"{tmp_path}/all.npz::test_*"],
        tmp_path / "out",
        axis=br.Axis(columns=columns, mass=1.0),
        workers=1,
        **OPTIONS,
    )
    columns = runs_in(tmp_path / "out").columns
    assert columns["log"].tolist() == ["all.npz::test_1", "all.npz::test_2"]
    assert columns["status"].tolist() == ["ok", "ok"]


class DeadlyOnce(Identifier):
    """An identifier whose process is killed, once."""

    def columns(self, block):
        end_once(os.environ["MARK"])
        return super().columns(block)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="kills processes as POSIX does")
def test_a_killed_worker_loses_no_rows(logs, tmp_path, monkeypatch):
    monkeypatch.setenv("MARK", str(tmp_path / "ended"))
    monkeypatch.setattr(module, "Identifier", DeadlyOnce)
    ran = each(logs, tmp_path / "out", workers=2)
    assert (tmp_path / "ended").exists()
    assert ran.is_whole
    assert runs_in(tmp_path / "out").columns["run"].tolist() == [0, 1, 2]
    monkeypatch.undo()
    each(logs, tmp_path / "alone")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.warns(br.core.InputWarning, match="--workers needs an optional dependency"):
        each(logs, tmp_path / "threads", workers=3)
    assert content(tmp_path / "out") == content(tmp_path / "threads") == content(tmp_path / "alone")


def test_an_interruption_during_a_fit_leaves_no_partial_row(logs, tmp_path, monkeypatch):
    def interrupted(log, model, **options):
        return Identification((), log, unfinished="interrupted")

    monkeypatch.setattr(module, "identify", interrupted)
    with pytest.raises(KeyboardInterrupt):
        each(logs, tmp_path / "out")
    assert list((tmp_path / "out" / "runs").iterdir()) == []

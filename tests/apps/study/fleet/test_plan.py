"""A fleet as data: a row for each log, a column for each parameter with its interval, and logs that keep their numbers."""

import importlib
from pathlib import Path
from types import SimpleNamespace as Some

import pytest

from bristle.apps.study.fleet.identify import Identifier, _of_estimate, fleet_of
from bristle.apps.study.fleet.plan import OF_FIT, RUN, Fleet
from bristle.apps.study.plan import Block
from bristle.core import Axis, InputError
from bristle.identification import models_of
from bristle.identification.result import Identification
from bristle.logs import LogFile

identify = importlib.import_module("bristle.apps.study.fleet.identify")


def log(name, checksum="0", place="", folder="press"):
    return LogFile(place or f"{folder}/{name}", folder, name, checksum, None)


def fleet(*logs, model="coulomb_viscous", kind="translational"):
    (component,) = models_of(model)
    return Fleet("press", logs, (None,), kind, component, {}, (), 10**9, {})


def test_each_log_is_a_separate_block():
    item = fleet(log("a"), log("b"), log("c"))
    assert item.count == 3
    assert item.blocks == (Block(0, 1), Block(1, 2), Block(2, 3))


def test_a_parameter_has_the_status_and_the_ends_in_the_unit():
    columns = fleet().columns
    assert list(columns)[: len(RUN)] == list(RUN)
    assert columns["friction.F_C"] | {"description": ""} == {
        "role": "parameter",
        "unit": "N",
        "description": "",
    }
    assert columns["friction.F_C.status"]["role"] == "run"
    for end in ("lower", "upper"):
        assert columns[f"friction.F_C.{end}"] == {
            "role": "interval",
            "unit": "N",
            "description": f"{end} end of the 95 % interval of friction.F_C",
        }
    assert {name: columns[name]["unit"] for name in OF_FIT} == {
        name: unit for name, (unit, _) in OF_FIT.items()
    }
    assert {"scatter.lower", "scatter.upper"} <= set(columns)
    assert "error.lower" not in columns
    assert fleet(kind="rotational").columns["friction.F_C"]["unit"] == "N*m"


def entry(item):
    return {"folder": item.folder, "log": item.name, "sha256": item.checksum, "time": item.time}


def test_listed_logs_keep_their_numbers_and_new_logs_follow():
    a, b, c = log("a", "1"), log("b", "2"), log("c", "3")
    past = [entry(b), entry(log("gone", "9"))]
    following = fleet(a, b, c).following(past)
    assert [item.name for item in following.logs] == ["b", "gone", "a", "c"]
    assert [bool(item.place) for item in following.logs] == [True, False, True, True]


def test_a_log_of_the_same_name_with_different_content_is_refused():
    with pytest.raises(
        InputError, match=r"press/a.*is already in this fleet, with different content"
    ):
        fleet(log("a", "1")).following([entry(log("a", "2"))])


def estimate(status="identified", ends=(4.0, 6.0)):
    return Some(status=status, value=5.0, ends=ends)


@pytest.mark.parametrize(
    ("item", "row"),
    [
        (estimate(), {"p.status": "identified", "p": 5.0, "p.lower": 4.0, "p.upper": 6.0}),
        (estimate("held", None), {"p.status": "held", "p": 5.0}),
        (estimate("at_edge", (4.0, float("inf"))), {"p.status": "at_edge", "p": 5.0}),
        (estimate("unidentifiable"), {"p.status": "unidentifiable"}),
    ],
)
def test_a_row_has_value_and_ends_of_a_parameter(item, row):
    assert _of_estimate("p", item) == row


@pytest.mark.parametrize(
    ("error", "status", "reason"),
    [
        (InputError("is wrong"), "refused", "is wrong"),
        (MemoryError(), "raised", "there is not enough memory for this log"),
        (ValueError("x" * 400), "raised", "ValueError: xxx"),
    ],
)
def test_a_failed_log_is_a_row_with_the_reason(error, status, reason, monkeypatch):
    item = fleet(log("a"), LogFile("press/b", "press", "b", "1", 1.5))

    def fails(self, entry):
        raise error

    monkeypatch.setattr(Identifier, "_numbers", fails)
    columns = Identifier(item).columns(Block(0, 2))
    assert columns["run"] == [0, 1]
    assert columns["status"] == [status] * 2
    assert reason in columns["reason"][0]
    assert len(columns["reason"][0]) <= 300
    assert columns["time_of_log"] == [None, 1_500_000]
    assert columns["diagnostics"] == ["", ""]
    assert columns["friction.F_C"][0] != columns["friction.F_C"][0]  # no number


def test_a_readable_log_is_a_row_with_the_numbers(monkeypatch):
    monkeypatch.setattr(Identifier, "_numbers", lambda self, entry: {"error": 0.5})
    columns = Identifier(fleet(log("a"))).columns(Block(0, 1))
    assert (columns["status"], columns["reason"], columns["error"], columns["log"]) == (
        ["ok"],
        [""],
        [0.5],
        ["a"],
    )


def test_fleets_differ_by_model_and_options(logs):
    names = [logs]
    first = fleet_of(names, options={"draws": 0})
    assert first.described["fleet"] == {"model": "coulomb_viscous", "draws": 0}
    assert first.kind == "translational"
    assert [item.axis for item in first.logs] == [0, 0, 0]
    assert first.described["columns"] == sorted(first.columns)
    assert fleet_of(names, model="stribeck").described != first.described
    with pytest.raises(InputError, match=r"takes one model.*coulomb, stribeck"):
        fleet_of(names, model="coulomb,stribeck")


def test_errors_of_a_fit_are_shares_in_a_row(monkeypatch):
    recorded = Some(
        origin=Some(checksum="0"),
        kind="translational",
        duration=4.0,
        temperature=Some(values=[290.0, 292.0]),
    )
    doubts = [
        Some(code=code, severity=severity)
        for code, severity in (("a", "warning"), ("b", "note"), ("a", "warning"))
    ]
    held_out = Some(mean_percent=6.0)
    result = Some(
        diagnostics=doubts,
        error_percent=5.0,
        held_out=held_out,
        resampling=None,
        parameters={"F_C": estimate()},
    )
    monkeypatch.setattr(identify, "read_log", lambda place, axis, size_limit: recorded)
    settings = []

    def identified(log, model, axis, **options):
        settings.append(options["settings"])
        return Identification((result,), log)

    monkeypatch.setattr(identify, "identify", identified)
    row = Identifier(fleet(log("a")))._numbers(log("a"))
    assert [
        row[name] for name in ("error", "held_out_error", "duration", "temperature")
    ] == pytest.approx([0.05, 0.06, 4.0, 291.0])
    # The logs of a fleet have the same plant: no second pass.
    assert settings == [{"lines_gain": 1.0}]
    Identifier(fleet(log("a")), models=Path())._numbers(log("a"))
    assert settings[1:] == [{}]  # the axes of a trace may have different plants
    assert (row["diagnostics"], row["friction.F_C"], row["friction.F_C.upper"]) == ("a", 5.0, 6.0)
    with pytest.raises(InputError, match="has changed since the command began"):
        Identifier(fleet(log("a")))._numbers(log("a", "1"))
    with pytest.raises(
        InputError, match="is the log of a translational axis, but this fleet has rotational axes"
    ):
        Identifier(fleet(log("a"), kind="rotational"))._numbers(log("a"))


@pytest.mark.parametrize(
    ("axes", "fits"),
    [
        ([{}], True),
        ([{}, {}, {}], True),
        ([{}, {"gravity": True}, {}], False),
        ([{}, {"kind": "rotational"}, {}], False),
        ([{"plant": "oscillator"}] * 3, True),
        ([{}, {}, {"plant": "oscillator"}], False),
        ([{"mass": 3.0}, {"mass": 4.0}, {}], True),
    ],
)
def test_axes_of_a_fleet_are_of_a_single_kind_and_plant(logs, axes, fits):
    described = [Axis(**axis) for axis in axes]
    if fits:
        item = fleet_of([logs], axes=described)
        assert [log.axis for log in item.logs] == ([0, 0, 0] if len(axes) == 1 else [0, 1, 2])
    else:
        with pytest.raises(InputError, match="describe axes of different kinds"):
            fleet_of([logs], axes=described)


def test_axes_of_a_common_trace_may_have_different_terms(logs):
    trace = next(path for path in Path(logs).rglob("*") if path.is_file())
    columns = fleet_of([trace], axes=[Axis(name="turn"), Axis(name="lift", spring="cubic")]).columns
    assert {"plant.M", "plant.spring_3", "friction.F_C"} <= set(columns)


def test_fleets_differ_by_the_axes_and_not_by_their_order(logs):
    def identity(*axes):
        return fleet_of([logs], axes=axes).described["axes"]

    heavy, light = Axis(mass=4.0), Axis(mass=3.0)
    assert identity() == []
    assert len(identity(light)) == len(identity(light, light, light)) == 1
    assert identity(light) != identity(heavy)
    assert identity(light, light, heavy) == identity(heavy, light, light)
    read, written = (Axis(mass=3.0, text=text) for text in (b"mass = 3", b"mass = 3.0"))
    assert identity(read) != identity(written)  # of two files each counts as it is written

"""Misuse from Python: it works as it would if it were written properly, or one line says what is wrong, and where."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.misuse.broken import MODEL as BROKEN
from tests.misuse.proper import Call, axis, calls, experiment, parts, recorded, variant
from tests.misuse.values import MOSTLY, NEVER, Column, Evasive, Hostile

import bristle as br
from bristle import (
    engine,
    exports,
    figures,
    friction,
    hysteresis,
    logs,
    plants,
    prediction,
    references,
)
from bristle.apps import tune
from bristle.apps.lab import Widget, lab_page
from bristle.apps.study import fleet
from bristle.apps.study.run import run_within
from bristle.core import Axis, Experiment, Feedforward, InputError, Run, unit_of
from bristle.core.edge import amount, guarded
from bristle.core.errors import BristleError
from bristle.core.status import Status
from bristle.core.variable import Variable
from bristle.files.operator import write_operator
from bristle.logs.log import Channel, Log
from bristle.prediction import comparison
from bristle.report.model_in_hand import ModelInHand

CALLS = calls()
# Where what is right takes its time, only what is wrong is handed in.
SLOW = ("design", "simulate", "excite", "identify", "compare", "predict")
# Arguments that may be a file: what is wrong in it is told with its place in the file.
FILES = ("path", "given", "axis", "log", "experiment", "model", "origins")
# Other names by which an argument may be called: of two that disagree, the message may name the other one.
ALIASES = {
    "path": "log|axis|experiment|model|file|size",
    "name": "model",
    "everett": "E",
    "given": "log",
    "v": "x",
    "slots": "slot",
    "s": "x_r",
    "f_p": "x_r",
    "radius": "duration",
    "feed": "duration",
    "sample_time": "duration",
    "cutoff": "log",
}


def one_line(error: BristleError) -> str:
    text = str(error)
    assert text.isprintable(), text
    assert len(text) < 3000
    return text


def hand_in(call: Call, argument: str, values: dict[str, Any]) -> None:
    """Hand in each value for an argument: it works, or the error says in one line which argument it is."""
    for name, value in values.items():
        try:
            call(**{argument: value})
        except BristleError as error:
            text = one_line(error)
            is_file = (
                argument in FILES and isinstance(value, (str, bytes, dict, list))
            ) or "Path" in type(value).__name__
            named = (
                argument,
                ALIASES.get(argument, argument),
                getattr(call.function, "name", argument),
            )
            names = "|".join(named)
            assert is_file or re.search(rf"\b({names})\b", text), f"{name}: {text}"
        except Exception as error:
            raise AssertionError(f"{argument} = {name}") from error


@pytest.mark.fast_cases(24)
@pytest.mark.parametrize("name", [name for name in CALLS if name not in SLOW])
def test_any_argument_is_accepted_or_refused_by_name(name):
    for argument in CALLS[name].arguments:
        never = {
            key: item
            for key, item in NEVER.items()
            if not (callable(item) and argument in ("progress", "everett"))
        }
        hand_in(CALLS[name], argument, never | MOSTLY)


@pytest.mark.parametrize("name", SLOW)
def test_errors_are_refused_before_the_work_begins(name):
    for argument in CALLS[name].arguments:
        for key, value in NEVER.items():
            if argument == "progress" and callable(value):
                continue
            with pytest.raises(InputError) as caught:
                CALLS[name](**{argument: value})
            assert re.search(rf"\b{argument}\b", one_line(caught.value)), (
                f"{argument} = {key}: {caught.value}"
            )


WRONG: list[tuple[str, str, list[Any]]] = [
    ("compare", "before", [None, [], 5, recorded().position]),
    ("compare", "after", [None, [], 5, True]),
    ("compare", "axis", [5, True, [axis()] * 3]),
    ("compare", "window", [0.0, -1.0, math.nan, "5 kg", "x", True]),
    ("identify", "draws", [-1, 1.5, "many", True, None, 5, 10**18, math.nan, math.inf]),
    ("identify", "blocks", [1, -1, 1.5, "x", True, 10**18]),
    ("identify", "progress", [5, "x", [], True]),
    ("identify", "model", [None, [], {}, 5, "x", "", "+", [None], parts()["friction"], True]),
    ("identify", "free", ["x", 5, None, ["x"], [5], True]),
    ("identify", "mass", [math.nan, -1.0, 0.0, math.inf, "5 N", "x", True, [1.0], 10**5000]),
    ("identify", "offset", [math.nan, "x", "5 kg", True]),
    ("identify", "cutoff", [0.0, -1.0, math.nan, "5 kg", True, 1e9]),
    ("identify", "decimation", [0, -1, 1.5, "x", True, 10**5000]),
    ("identify", "method", ["x", 5, True, ["output_error"]]),
    ("identify", "log", [None, [], 5, recorded().position]),
    ("identify", "axis", [5, True, [axis(), axis()]]),
    ("predict", "plant", [None, plants.inertia, parts()["friction"], 5]),
    ("predict", "friction", [None, friction.coulomb, parts()["plant"], "coulomb"]),
    ("predict", "mode", ["x", None, 5, "Inverse", True]),
    ("predict", "decimation", [0, 1.5, 10**5000]),
    ("predict", "velocity_max", [-1.0, math.nan, "x", True]),
    ("predict", "delay", [math.nan, "x", True, "1 mm", 1e9]),
    ("predict", "lag", [-1.0, math.nan, True]),
    ("predict", "bands", [5, {}, "x"]),
    ("excite", "duration", [1.0, -1, math.nan, "x", "5", True, 10**18]),
    ("excite", "travel", [0.0, -1.0, "1 s", math.nan, True]),
    ("excite", "purposes", ["x", 5, [5], True]),
    ("excite", "rehearsed", [1, None, "x"]),
    ("excite", "draws", [-1, 1.5, True, None, 5, 10**18]),
    ("excite", "allow_code", [1, None, "yes"]),
    ("excite", "progress", [5, True]),
    ("design", "variant", ["x", 5, True]),
    (
        "design",
        "bandwidth",
        [0.0, -1.0, math.nan, math.inf, "x", "30", "30 mm", True, "-30 Hz", 10**5000],
    ),
    ("design", "progress", [5, True]),
    ("design", "experiment", [None, 5, [], True, replace(experiment(), variants=())]),
    ("simulate", "experiment", [None, 5, [], variant(), True]),
    ("simulate", "progress", [5, True]),
    ("check", "model", [friction.lugre, None, parts()["plant"]]),
    (
        "check",
        "force_ripple",
        [1.0, (1.0,), (1.0, math.nan), (1, 2, 3), ("1 mm", "2 mm"), (True, False), "x"],
    ),
    ("check", "loop", [1.0, (1.0,), ("1 N", "2 N"), (math.inf, 0.0)]),
    ("identify_operator", "stops", [0, -1, 1.5, "x", True, 10**9]),
    ("identify_operator", "cells", [0, 1, 1.5, True, 10**9]),
    ("identify_operator", "folds", [1, -1, 1.5, True]),
    ("identify_operator", "model", [None, [], "x", ["x", 5], True]),
    ("response", "dt", [0.0, -1.0, None, "1 mm", math.nan, True]),
    ("response", "model", [parts()["plant"], friction.lugre, None]),
    ("run_open_loop", "plant", [parts()["friction"], plants.inertia]),
    ("run_open_loop", "steps", [0, -1, 1.5, True, 10**18]),
    ("run_open_loop", "state", [5, (), ("x",), parts()["friction"].parameters]),
    ("run_open_loop", "memory", [np.zeros(3), "x"]),
    ("run_adaptive", "tolerance", [0.0, -1.0, math.nan, math.inf, None, True]),
    ("run_batch", "threads", [0, -1, 1.5, True, 10**9]),
    ("run_batch", "plant", [[], [None], [parts()["plant"]] * 3 + [5]]),
    ("transition_branches", "x_r", [1e18, 0.0, "1 s"]),
    ("torque_seen", "velocity", [np.ones(3), [1.0, math.inf], None]),
    ("Run", "duration", [0.0, -1.0, 1e9, None, "5 m", math.inf, 1e-6]),
    ("Run", "settle", [-1.0, math.nan, 1e3]),
    ("run_open_loop", "friction", [friction.viscous(kind="rotational", F_v=1.0)]),
    ("predict", "friction", [friction.viscous(kind="rotational", F_v=1.0)]),
    ("move", "distance", [math.nan, "1 N"]),
    ("move", "speed", [0.0, -1.0, math.nan]),
    ("move", "count", [0, -1, 1.5]),
    ("force", "v", [math.nan, "1 N"]),
    ("legs_through", "points", [[math.nan], 5]),
    ("legs_through", "velocity", [0.0, math.nan]),
    ("legs_through", "acceleration", [-1.0]),
    ("legs_through", "jerk", [0.0]),
    ("with_terms", "cogging", [{"belt": (1,)}, {"motor": (0,)}, {"motor": (1.5,)}]),
    ("with_terms", "spring", ["cubik"]),
    ("with_terms", "plant", [parts()["plant"]]),
    ("Limits", "travel", [(1.0, -1.0), (0.0, 1.0, 2.0)]),
    ("Limits", "effort", [-10.0, 0.0]),
    ("Limits", "following_error", [math.nan]),
    ("Options", "duration", [-1.0, math.nan]),
    ("Options", "draws", [-5, 1.5]),
    ("run_circles", "feed", [0.0, "1 mm"]),
    ("run_circles", "variants", [()]),
    ("Run", "delay", [-1, 1.5, 65, True]),
    ("Run", "effort_limit", [-1.0, math.nan, "5 mm", None]),
    ("Experiment", "variants", [None, [None], (variant(), variant())]),
    ("Log", "position", [None, np.ones(3), [math.nan] * 600, "x"]),
    ("Axis", "mass", [0.0, -1.0, math.nan, "5 N", True]),
    ("Axis", "stroke", [(1.0,), 1.0, (0.0, math.nan), ("x", 1.0), (1.0, -1.0), (1.0, 1.0)]),
    ("Axis", "delay", [1e9, "11 s", math.nan]),
    ("predict", "delay", [9.0, -9.0]),
    ("predict", "stiffness", [math.nan, -1.0, "1 N"]),
    ("compare", "window", [1e9, 0.61]),
    ("Axis", "columns", [{"x": None}, {"position": "q"}, [], None]),
]


P, PLAY, TURNING = parts(), hysteresis.play(r=1e-6), friction.coulomb(F_C="1 N*m")
FAST, FALL, QUICK = (
    np.full(20, 200.0),
    (np.linspace(1.0, -1.0, 9),) * 2,
    references.chirp(amplitude=1e-3, f_0=1.0, f_1=2e3, duration=1.0),
)
REFUSED: list[tuple[str, Callable[[Any], Any]]] = [
    ("mass: has no effect on c", lambda out: br.export(P["friction"], "c", out, mass=3.0)),
    (
        "mass: has no effect on fmu3",
        lambda out: br.export(P["friction"], "fmu3", out, plant=P["plant"], mass=3.0),
    ),
    ("points: has no effect on c", lambda out: br.export(P["friction"], "c", out, points=7)),
    (
        "table: has no effect on c",
        lambda out: br.export(P["friction"], "c", out, table=P["friction"]),
    ),
    (
        "plant: applies to a model only",
        lambda out: br.export(variant(), "c", out, plant=P["plant"]),
    ),
    ("rest: applies to a model only", lambda out: br.export(variant(), "c", out, rest="held")),
    (
        "treatment.cutoff: must be finite",
        lambda out: br.write_model(out, P["plant"], P["friction"], treatment={"cutoff": math.nan}),
    ),
    (
        "treatment.cutoff: must be positive",
        lambda out: br.write_model(out, P["plant"], P["friction"], treatment={"cutoff": -5.0}),
    ),
    ("path: must be a path", lambda out: br.write_model(5, P["plant"], P["friction"])),  # type: ignore[arg-type]
    ("operator: must be a hysteresis operator", lambda out: write_operator(out, P["friction"])),
    ("offset: must be a finite number", lambda out: write_operator(out, PLAY, math.nan)),
    ("mass: must be positive", lambda out: lab_page(mass=-1.0)),
    ("draws: out of range", lambda out: ModelInHand.known_truth(None, draws=0)),  # type: ignore[arg-type]
    ("workers: out of range", lambda out: run_within(None, workers=0)),
    (
        "variants: .* the same name; found 'base'",
        lambda out: Experiment("two", "translational", (variant(), variant())),
    ),
    ("duration: gives", lambda out: Run(duration="1 day", sample_time="1 us")),
    ("out: must be a path; found 5", lambda out: br.export(P["friction"], "c", 5)),  # type: ignore[arg-type]
    (
        "source: must be an object of class Source",
        lambda out: br.export(P["friction"], "c", out, source=5),
    ),  # type: ignore[arg-type]
    ("tunable: must be True or False", lambda out: br.export(P["friction"], "c", out, tunable=1)),  # type: ignore[arg-type]
    ("step: has no effect on mjcf", lambda out: br.export(P["friction"], "mjcf", out, step=1e-3)),
    ("speed: has no effect on wasm", lambda out: br.export(P["friction"], "wasm", out, speed=0.1)),
    ("speed: has no effect on fmu3", lambda out: br.export(P["friction"], "fmu3", out, speed=0.1)),
    (
        "table: applies to a plant with a screw",
        lambda out: br.export(P["friction"], "fmu3", out, table=P["friction"]),
    ),
    (
        "axis.kind: is of another kind than",
        lambda out: br.export(P["friction"], "c", out, axis=Axis(kind="rotational")),
    ),
    (
        "has no valid name",
        lambda out: exports.Target(name="My target", description="d", write=print),
    ),
    (
        "target my: has no valid description",
        lambda out: exports.Target(name="my", description=" ", write=print),
    ),
    (
        "target my: has no valid write",
        lambda out: exports.Target(name="my", description="d", write=5),
    ),  # type: ignore[arg-type]
    (
        "target my: has no valid reads",
        lambda out: exports.Target(name="my", description="d", write=print, reads=5),
    ),  # type: ignore[arg-type]
    (
        "target my: has no valid rest",
        lambda out: exports.Target(name="my", description="d", write=print, rest="top"),
    ),
    (
        r"estimates\[0\]: has no std",
        lambda out: br.write_model(out, P["plant"], P["friction"], estimates=[5]),
    ),
    (
        "treatment.cutoff: must be a number",
        lambda out: br.write_model(out, P["plant"], P["friction"], treatment={"cutoff": "a"}),
    ),  # type: ignore[dict-item]
    ("logs: must be a list; found 'log.csv'", lambda out: fleet.identify_each("log.csv", out)),
    ("logs: has no logs", lambda out: fleet.identify_each([], out)),
    ("before: has no logs", lambda out: comparison.compare([], [(recorded(), None)])),
    (
        "everett: returns no finite number",
        lambda out: hysteresis.tabulated(lambda a, b: math.nan, 1.0),
    ),
    ("everett: must return a number", lambda out: hysteresis.tabulated(lambda a, b: "x", 1.0)),  # type: ignore[arg-type,return-value]
    ("cutoff: is above half the sample rate", lambda out: logs.low_passed(np.zeros(99), 1e6, 1e-3)),
    ("signal: is too short for the filter", lambda out: logs.low_passed(np.zeros(9), 50.0, 1e-3)),
    ("kind: is not a valid choice", lambda out: unit_of("force", "linear")),  # type: ignore[arg-type]
    ("min of 'd': is above max", lambda out: Variable("force", "d", min=2.0, max=1.0)),
    ("nominal of 'd': must be finite", lambda out: Variable("force", "d", nominal=math.nan)),
    (
        "recorded_step: out of range",
        lambda out: Channel(values=np.zeros(9), unit="m", column="x", recorded_step=-1.0),
    ),
    (
        "friction: is of another kind of axis",
        lambda out: engine.run_batch(P["plant"], [P["friction"], TURNING], FAST, 1e-3),
    ),
    (
        "per_cycle: has other names than traces",
        lambda out: figures.drift({"a": (FAST, FAST)}, {"b": 1.0}),
    ),
    (
        "traces.a: needs a force for each position",
        lambda out: figures.drift({"a": (FAST, FAST[1:])}, {"a": 1.0}),
    ),
    (
        "distance: out of range",
        lambda out: figures.friction_after_reversals(
            type("Fit", (), {"traces": None, "plant": P["plant"]}), -1.0
        ),
    ),  # type: ignore[arg-type]
    ("operator: has no turning points", lambda out: figures.preisach_plane(P["friction"], [1.0])),
    ("form: is not a valid choice", lambda out: figures.figure_file(Figure(), "svgg", "a")),
    ("title: must be text", lambda out: figures.figure_file(Figure(), "svg", 5)),  # type: ignore[arg-type]
    ("log: must be a log", lambda out: figures.log_over_time({})),  # type: ignore[arg-type]
    ("figure: must be a figure", lambda out: figures.figure_file(5, "svg", "a")),  # type: ignore[arg-type]
    (
        "position: has more or fewer rows",
        lambda out: tune.Recording(np.zeros(5), np.zeros(3), np.zeros(5)),
    ),
    (
        "model: must be a pair",
        lambda out: br.excite(axis(), model=(P["plant"], P["friction"], P["friction"])),
    ),
    (r"model\[1\]: must be a friction", lambda out: br.excite(axis(), model=(None, P["plant"]))),
    (
        "curves: contains two curves from the same turn",
        lambda out: hysteresis.from_reversal_curves([FALL, FALL]),
    ),
    ("step: out of range", lambda out: br.export(P["friction"], "c", out, step=1e9)),
    (
        "reference.f_1: is not sampled",
        lambda out: br.simulate(
            Experiment("q", "translational", replace(variant(), reference=QUICK))
        ),
    ),
    ("fit: must be a model with its traces", lambda out: figures.friction_after_reversals(5)),  # type: ignore[arg-type]
    (
        "target my: has no valid tunable",
        lambda out: exports.Target(name="my", description="d", write=print, tunable=1),
    ),  # type: ignore[arg-type]
    ("fastest: out of range", lambda out: Widget(P["friction"], fastest=-1.0)),
    ("folder: must be a path", lambda out: br.load(5)),  # type: ignore[arg-type]
    (
        r"columns\[0\]: is empty",
        lambda out: plants.with_terms(plants.PLANTS["inertia"], columns=("",)),
    ),
]


@pytest.mark.parametrize(("words", "call"), REFUSED, ids=[item[0] for item in REFUSED])
def test_a_refused_call_names_its_argument_and_writes_no_file(words, call, tmp_path):
    with pytest.raises(InputError, match=words):
        call(tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "argument", "values"), WRONG, ids=[f"{item[0]}.{item[1]}" for item in WRONG]
)
def test_impossible_arguments_are_refused_by_name(name, argument, values):
    for value in values:
        with pytest.raises(InputError) as caught:
            CALLS[name](**{argument: value})
        assert re.search(rf"\b{argument}\b", one_line(caught.value)), caught.value


# As people write it, and as it is: both give the same.
ALIKE: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("response", {"dt": "100 ms"}, {"dt": 0.1}),
    ("response", {"x": (0, 1e-3, 2e-3)}, {"x": np.array([0.0, 1e-3, 2e-3])}),
    ("response", {"x": Column([0.0, 1e-3])}, {"x": [0.0, 1e-3]}),
    ("response", {"dt": np.array(0.1)}, {"dt": 0.1}),
    ("response of an operator", {"history": [1]}, {"history": np.array([1.0])}),
    (
        "run_open_loop",
        {"x": "1 mm", "v": "2 mm/s", "dt": "1 ms"},
        {"x": 1e-3, "v": 2e-3, "dt": 1e-3},
    ),
    ("run_open_loop", {"steps": np.int64(2)}, {"steps": 2}),
    ("run_open_loop", {"steps": 2.0}, {"steps": 2}),
    ("run_open_loop", {"effort": Column([20.0] * 5)}, {"effort": [20.0] * 5}),
    (
        "run_adaptive",
        {"tolerance": "1 um", "max_step": "1 s"},
        {"tolerance": 1e-6, "max_step": 1.0},
    ),
    ("run_batch", {"x": [1e-3]}, {"x": 1e-3}),
    (
        "run_closed_loop",
        {"limit": "100 N", "lag": "0 s", "x": "1 um"},
        {"limit": 100.0, "lag": 0.0, "x": 1e-6},
    ),
    ("force_along", {"v": Column([1.0]), "x": [0.1]}, {"v": np.ones(1), "x": np.array([0.1])}),
    ("check", {"force_ripple": ["2 N", "4 N"]}, {"force_ripple": np.array([2.0, 4.0])}),
    ("predict", {"cutoff": "0.1 kHz", "delay": "1 ms"}, {"cutoff": 100.0, "delay": 1e-3}),
    ("predict", {"velocity_max": "100 mm/s"}, {"velocity_max": 0.1}),
    ("identify", {"mass": "12000 g", "blocks": np.int32(0)}, {"mass": 12.0}),
    ("identify", {"model": ["coulomb", "viscous"]}, {"model": "coulomb, viscous"}),
    ("excite", {"duration": "20 s", "purposes": ["presliding"]}, {"purposes": "presliding, "}),
    ("hysteresis.conditioned", {"amplitude": "4 m"}, {}),
    ("transition_branches", {"s": "1 N/m", "x_r": "2 m"}, {}),
    ("torque_seen", {"dt": "100 ms", "J_m": "0.1 kg*m^2", "effort": [1, 1]}, {}),
    ("feedforward_effort", {"position": [0.0, 1e-3, 2e-3, 1e-3]}, {}),
    ("friction_along", {"velocity": [1, 1, 1], "dt": "1 ms"}, {}),
    ("with_presliding", {"distance": "1 um"}, {}),
    ("substeps_for", {"sample_time": "1 ms"}, {}),
    ("with_terms", {"gravity": np.True_}, {"gravity": True}),
    (
        "Run",
        {"duration": "1000 ms", "sample_time": "1 ms", "effort_limit": "5 N", "settle": "0.1 s"},
        {},
    ),
    ("Run", {"effort_limit": "5 N*m"}, {}),
    ("Feedforward", {"mass": "1000 g", "limit": "5 N"}, {}),
    ("Learning", {"cutoff": "50 Hz", "trials": np.int64(3)}, {}),
    ("Experiment", {"variants": variant()}, {}),
    ("Experiment", {"variants": [variant()]}, {}),
    (
        "Axis",
        {
            "mass": "1000 g",
            "stroke": ["0 mm", "1000 mm"],
            "resolution": "0.1 um",
            "cutoff": "50 Hz",
        },
        {},
    ),
]


@pytest.mark.parametrize(
    ("name", "written", "proper"), ALIKE, ids=[f"{item[0]}-{next(iter(item[1]))}" for item in ALIKE]
)
def test_frequent_spellings_are_understood(name, written, proper):
    same(CALLS[name](**written), CALLS[name](**proper))


def same(result: Any, wanted: Any) -> None:
    if isinstance(result, np.ndarray):
        np.testing.assert_allclose(result, wanted, rtol=1e-12)
    elif isinstance(result, float):
        assert result == pytest.approx(wanted, rel=1e-12, nan_ok=True)
    elif isinstance(result, (tuple, list)):
        assert len(result) == len(wanted)
        for item, other in zip(result, wanted, strict=True):
            same(item, other)
    elif isinstance(result, dict):
        same(list(result.values()), list(wanted.values()))
    elif (
        hasattr(result, "__dict__")
        and type(result).__module__.startswith("bristle")
        and not hasattr(result, "component")
    ):
        same(vars(result), vars(wanted))
    else:
        assert type(result) is type(wanted)


def test_a_bandwidth_is_a_frequency_or_an_angular_frequency(monkeypatch):
    from bristle.apps.design import design as module_function

    message = []
    module = __import__("sys").modules[module_function.__module__]
    monkeypatch.setattr(
        module, "proposals_for", lambda variant, bandwidth, **_: message.append(bandwidth) or ()
    )
    monkeypatch.setattr(module, "error_budget", lambda *_: None)
    for bandwidth in ("30 Hz", "0.03 kHz", 60.0 * math.pi, f"{60.0 * math.pi} rad/s"):
        br.design(experiment(), bandwidth=bandwidth)
    assert message == pytest.approx([60.0 * math.pi] * 4)


def test_a_log_of_plain_columns_is_the_log_of_channels():
    whole = recorded()
    columns = {name: Column(channel.values) for name, channel in whole.channels()}
    plain = Log(**columns)
    assert plain.sample_time == pytest.approx(1e-3, rel=1e-9)
    assert plain.segments == (slice(0, 600),)
    assert plain.effort.unit == "N"
    assert Log(time=[0, 1], position=[0, 1], kind="rotational").position.unit == "rad"
    both = [
        br.identify(item, "coulomb_viscous", draws=0, blocks=0).best.friction.values["F_C"]
        for item in (plain, whole)
    ]
    assert both[0] == pytest.approx(both[1], rel=1e-9)
    with pytest.raises(InputError, match="time: must increase"):
        Log(time=[0.0, 1.0, 0.5], position=[1.0, 2.0, 3.0])


def test_a_file_is_accepted_in_place_of_its_object(tmp_path):
    path = tmp_path / "axis.toml"
    path.write_text(
        'schema = 1\nkind = "translational"\nplant.presliding = "7 um"\nencoder.resolution = "0.1 um"\n'
        'columns.position = { column = "q", unit = "m" }\n'
    )
    for values in (path, str(path), path.read_bytes()):
        assert (
            br.excite(values, duration=20.0, purposes="presliding", rehearsed=False).axis.presliding
            == 7e-6
        )
    tables = {
        "schema": 1,
        "friction": {"model": "coulomb", "F_C": "8 N"},
        "plant": {"M": "12 kg"},
        "controller": {"model": "cascade", "k_p": 80, "k_v": "3000 N*s/m"},
        "reference": {"model": "sine", "amplitude": "1 mm", "frequency": "5 Hz"},
        "run": {"duration": "20 ms", "sample_time": "1 ms"},
    }
    assert br.simulate(tables).variants["base"].status is Status.OK


def test_units_are_those_of_the_kind_of_axis():
    turning = {"plant": plants.inertia(M="1 kg*m^2"), "friction": friction.coulomb(F_C="1 N*m")}
    assert CALLS["run_open_loop"](**turning, x="1 mrad").position[0] == pytest.approx(1e-3)
    with pytest.raises(InputError, match="x: has the wrong unit"):
        CALLS["run_open_loop"](**turning, x="1 mm")
    with pytest.raises(InputError, match="resolution: has the wrong unit"):
        Axis(resolution="1 mrad")
    assert Axis(kind="rotational", resolution="1 mrad").resolution == 1e-3


# The guard itself.


def test_a_guard_keeps_the_errors_of_python():
    @guarded(dt=amount(Variable("time", "time")))
    def message(first: Any, dt: Any = 1.0, *, last: OnlyForTypeCheckers[int] | None = None) -> Any:  # type: ignore[name-defined]  # noqa: F821
        return first, dt, last

    assert message(1, "2 s", last=3) == (1, 2.0, 3)
    assert message(1) == (1, 1.0, None)
    for wrong in (
        message,
        lambda: message(1, 2, 3),
        lambda: message(1, first=2),
        lambda: message(1, other=2),
    ):
        with pytest.raises(TypeError):
            wrong()
    with pytest.raises(TypeError, match="has no arguments nothing"):
        guarded(nothing=amount(Variable("time", "time")))(message)


def test_values_without_a_repr_are_refused_in_a_single_line():
    for item in (Hostile(), Evasive(), [Hostile()], {"x": Hostile()}):
        with pytest.raises(InputError) as caught:
            br.response(parts()["friction"], item, 0.1)
        assert one_line(caught.value).startswith("x: ")


def test_messages_are_always_a_single_line():
    for value in (np.ones((30, 30)), "a\nb\x1b[2J\u202e", list(range(10**6)), [10**5000] * 30):
        text = one_line(InputError("is wrong\nindeed", path="p\0", value=value))
        assert "p\\x00: is wrong indeed" in text
    assert "shape (30, 30)" in str(InputError("is wrong", value=np.ones((30, 30))))


class Counted:
    """It counts how often it is shown."""

    shown = 0

    def __repr__(self) -> str:
        Counted.shown += 1
        return "one"


def test_of_a_list_without_end_only_the_first_are_shown():
    text = str(InputError("is wrong", value=[Counted()] * 10**4))
    assert text.endswith("...]")
    assert Counted.shown < 100


# Numbers that are none.


def entry_points() -> dict[str, Callable[[Any], Any]]:
    plant, log, loop = parts()["plant"], recorded(), experiment()
    fed = replace(variant(), feedforward=Feedforward(friction=parts()["friction"]))

    def simulated(**changes: Any) -> Any:
        return br.simulate(replace(loop, variants=(replace(fed, **changes),)))

    return {
        "response": lambda bad: br.response(bad, [0.0, 1.0], 0.1),
        "force_along": lambda bad: engine.force_along(bad, [1.0], 0.1),
        "settled": lambda bad: engine.settled(bad, 1.0),
        "conditioned": lambda bad: engine.conditioned(bad.with_values(v_most=0.0), 1.0),
        "check": br.check,
        "feedforward": lambda bad: simulated(feedforward=Feedforward(friction=bad)),
        "predict": lambda bad: br.predict(plant, bad, log, axis=Axis()),
        "predict open loop": lambda bad: br.predict(plant, bad, log, Axis(), "open-loop"),
        "unexplained_force": lambda bad: prediction.unexplained_force(plant, bad, log),
        "identify": lambda bad: br.identify(log, bad.component, draws=0, blocks=0),
        "design": lambda bad: br.design(
            replace(loop, variants=(replace(variant(), friction=bad),))
        ),
    }


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("beyond", [0.0, 1.0])
@pytest.mark.parametrize("name", entry_points())
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning", "ignore:overflow:RuntimeWarning")
def test_a_model_that_gives_no_number_is_named(name, beyond):
    with (
        engine.interpreted(),
        pytest.raises(InputError, match=r"(model|friction): the output of broken is not finite"),
    ):
        entry_points()[name](BROKEN(F_C=8.0, v_most=1e-3, beyond=beyond))


@pytest.mark.parametrize(
    "run",
    [
        lambda bad: engine.run_open_loop(parts()["plant"], bad, FAST, 1e-3),
        lambda bad: engine.run_adaptive(parts()["plant"], bad, FAST[:3], 1e-3, tolerance=1e-3),
        lambda bad: engine.run_batch(parts()["plant"], bad, FAST, 1e-3),
        lambda bad: br.simulate(
            replace(experiment(), variants=(replace(variant(), friction=bad),))
        ).variants["base"],
        lambda bad: br.simulate(
            replace(
                experiment(),
                variants=(
                    replace(variant(), feedforward=Feedforward(friction=bad, along="measured")),
                ),
            )
        ).variants["base"],
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning", "ignore:overflow:RuntimeWarning")
def test_a_simulation_with_nan_reports_it_in_its_status(run):
    for beyond in (0.0, 1.0):
        with engine.interpreted():
            status = run(BROKEN(F_C=8.0, v_most=1e-3, beyond=beyond)).status
        assert status != Status.OK
        assert status != (Status.OK,)


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning", "ignore:overflow:RuntimeWarning")
def test_parameters_that_overflow_a_law_are_reported():
    huge, inverse = (
        friction.viscous(F_v=1e100),
        hysteresis.inverse_of(hysteresis.preisach(s=1.0, f_p=1.0)),
    )
    for match, run in (
        ("model: the output of viscous", lambda: br.response(huge, [0.0, 1e250], 1.0)),
        ("v: contains values that are not finite", lambda: br.response(huge, [0.0, 1e300], 1e-10)),
        ("model: the output of inverse_preisach", lambda: br.response(inverse, [0.5, 1e9])),
    ):
        with engine.interpreted(), pytest.raises(InputError, match=match):
            run()

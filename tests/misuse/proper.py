"""A proper call of every public function and constructor: what misuse is made of, one argument at a time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

import bristle as br
from bristle import (
    controllers,
    engine,
    friction,
    hysteresis,
    logs,
    plants,
    prediction,
    references,
    sensors,
)
from bristle.apps import design as loop, tune
from bristle.core import Axis, Column, Experiment, Feedforward, Injected, Run, Variant
from bristle.core.experiment import Learning
from bristle.logs.curves import Curve, Curves
from bristle.logs.log import Channel, Log
from bristle.models.plants import with_terms
from bristle.models.references.legs import legs_through

MASS = 12.0


@dataclass(frozen=True)
class Call:
    """A function, and arguments that it takes; those in `lean` may be left out and are made anything first."""

    function: Callable[..., Any]
    arguments: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, **changed: Any) -> Any:
        return self.function(**{**self.arguments, **changed})


@cache
def recorded(effort: float = 1.0) -> Log:
    """A log of 0.6 s of two sines, without a simulation; with more effort, of an axis that changed."""
    dt = 1e-3
    t = dt * np.arange(600)
    x = 0.01 * np.sin(20.0 * t) + 0.002 * np.sin(61.0 * t)
    v = np.gradient(x, dt)
    u = effort * (MASS * np.gradient(v, dt) + 8.0 * np.sign(v) + 30.0 * v)
    return Log(
        time=Channel(t, "s", "t"),
        position=Channel(x, "m", "q"),
        effort=Channel(u, "N", "u"),
        reference=Channel(x, "m", "r"),
        sample_time=dt,
        segments=(slice(0, t.size),),
    )


@cache
def parts() -> dict[str, Any]:
    """The components of a loop of ten samples, and what stands for the rest."""
    return {
        "plant": plants.inertia(M=MASS),
        "friction": friction.coulomb_viscous(F_C=8.0, F_v=30.0),
        "controller": controllers.cascade(k_p=80.0, k_v=3000.0),
        "sensor": sensors.encoder(resolution=1e-7),
        "reference": references.sine(amplitude=1e-3, frequency=5.0),
    }


@cache
def variant() -> Variant:
    return Variant(
        name="base",
        **parts(),
        feedforward=Feedforward(mass=MASS),
        run=Run(duration=0.05, sample_time=1e-3),
    )


@cache
def experiment() -> Experiment:
    return Experiment(name="small", kind="translational", variants=(variant(),))


@cache
def axis() -> Axis:
    return Axis(
        resolution=1e-7, sample_time=1e-3, presliding=7e-6, controller=parts()["controller"]
    )


@cache
def curves() -> Curves:
    u = np.array([1.0, 0.5, 0.0, -0.5, -1.0, -0.5, 0.0, 0.5, 1.0] * 12)
    f = br.response(hysteresis.play(r=0.3), u)
    return Curves((Curve(u, f),))


REVERSALS = [(np.linspace(top, -1.0, 9), np.linspace(top, -1.0, 9) ** 3) for top in (1.0, 0.5, 0.0)]
X = np.array([0.0, 1e-3, 2e-3, 1e-3])
NOTHING = np.zeros(10)


@cache
def calls() -> dict[str, Call]:
    """Every public function and constructor with a proper call, which is fast."""
    p = parts()
    mechanism = {"plant": p["plant"], "friction": p["friction"]}
    driven = mechanism | {"effort": np.full(10, 20.0), "dt": 1e-3}
    where = {"x": 0.0, "v": 0.0}
    run = {"steps": 1, "hold": "zero", **where}
    stress = {"model": p["friction"], "v": np.diff(X) / 0.1, "dt": 0.1, "x": X[1:]}
    around = {"load": 1.0, "temperature": 293.0}
    result = {
        "response": Call(br.response, {"model": p["friction"], "x": X, "dt": 0.1, "history": ()}),
        "Contact": Call(engine.Contact, {"model": p["friction"]}),
        "move": Call(
            engine.Contact(p["friction"]).move, {"distance": 1e-3, "speed": 1e-3, "count": 2}
        ),
        "force": Call(engine.Contact(p["friction"]).force, {"v": 1e-3}),
        "legs_through": Call(
            legs_through, {"points": [0.1], "velocity": 1.0, "acceleration": 1.0, "jerk": 100.0}
        ),
        "with_terms": Call(
            with_terms,
            {
                "plant": plants.inertia,
                "gravity": True,
                "cogging": {"motor": {1}},
                "columns": ("a",),
                "spring": "linear",
            },
        ),
        "without_presliding": Call(friction.without_presliding, {"friction": p["friction"]}),
        "Limits": Call(
            tune.Limits, {"following_error": 1e-3, "effort": 10.0, "travel": (-1.0, 1.0)}
        ),
        "Options": Call(tune.Options, {"models": "coulomb", "duration": 20.0, "draws": 0}),
        "assess": Call(loop.assess, {"variant": variant()}),
        "run_circles": Call(
            loop.run_circles,
            {"variants": [variant()], "radius": 1e-3, "feed": 0.1, "progress": None},
        ),
        "response of an operator": Call(
            br.response, {"model": hysteresis.play(r=0.3), "x": [1.0, 0.0], "history": [1.0]}
        ),
        "check": Call(
            br.check, {"model": p["friction"], "force_ripple": (2.0, 4.0), "loop": (1e-6, 0.0)}
        ),
        "design": Call(
            br.design,
            {"experiment": experiment(), "variant": "base", "bandwidth": None, "progress": None},
        ),
        "simulate": Call(br.simulate, {"experiment": experiment(), "progress": None}),
        "excite": Call(
            br.excite,
            {
                "axis": axis(),
                "duration": 20.0,
                "travel": 0.01,
                "purposes": "presliding",
                "model": None,
                "log": None,
                "rehearsed": False,
                "draws": 0,
                "allow_code": False,
                "progress": None,
            },
        ),
        "compare": Call(
            br.compare, {"before": recorded(), "after": recorded(1.1), "axis": None, "window": None}
        ),
        "identify": Call(
            br.identify,
            {
                "log": recorded(),
                "model": "coulomb_viscous",
                "axis": None,
                "cutoff": None,
                "decimation": None,
                "blocks": 0,
                "offset": None,
                "mass": None,
                "free": (),
                "draws": 0,
                "method": None,
                "progress": None,
            },
        ),
        "predict": Call(
            br.predict,
            {
                **mechanism,
                "log": recorded(),
                "axis": axis(),
                "mode": "inverse",
                "cutoff": None,
                "decimation": None,
                "velocity_max": None,
                "delay": None,
                "lag": None,
                "bands": None,
            },
        ),
        "identify_operator": Call(
            br.identify_operator,
            {
                "recorded": curves(),
                "model": "prandtl_ishlinskii",
                "stops": 5,
                "cells": 4,
                "folds": 0,
                "progress": None,
            },
        ),
        "read_log": Call(
            br.read_log,
            {
                "path": b"time [s],position [m]\n"
                + b"".join(b"%.3f,%.4f\n" % (1e-3 * i, 1e-4 * i) for i in range(200)),
                "axis": None,
                "size_limit": 10**6,
            },
        ),
        "read_axis": Call(
            br.read_axis,
            {
                "path": {
                    "schema": 1,
                    "kind": "translational",
                    "columns": {"position": {"column": "q", "unit": "m"}},
                }
            },
        ),
        "read_experiment": Call(br.read_experiment, {"path": None}),
        "read_model": Call(br.read_model, {"path": None}),
        "read_curves": Call(
            br.read_curves,
            {
                "path": b"u [m],f [N]\n0,0\n1,1\n2,1\n1,0\n",
                "axis": {
                    "schema": 1,
                    "kind": "translational",
                    "columns": {"input": "u", "output": "f"},
                },
                "size_limit": 10**6,
            },
        ),
        "run_open_loop": Call(
            engine.run_open_loop, driven | run | {"table": None, "state": None, "memory": None}
        ),
        "run_adaptive": Call(
            engine.run_adaptive,
            driven
            | where
            | {"tolerance": 1e-6, "hold": "zero", "max_step": 1.0, "state": None, "memory": None},
        ),
        "run_batch": Call(engine.run_batch, driven | run | {"threads": 1}),
        "run_closed_loop": Call(
            engine.run_closed_loop,
            mechanism
            | where
            | {
                "controller": p["controller"],
                "sensor": p["sensor"],
                "reference": np.zeros((4, 10)),
                "dt": 1e-3,
                "table": None,
                "sensor_at": "load",
                "steps": 1,
                "compensator": None,
                "injected": NOTHING,
                "disturbance": NOTHING,
                "limit": 100.0,
                "delay": 0,
                "lag": 0.0,
                "effort_before": 0.0,
                "acceleration": 0.0,
                "state": None,
                "memory": None,
            },
        ),
        "force_along": Call(engine.force_along, stress | around | {"state": None, "memory": None}),
        "engine.conditioned": Call(engine.conditioned, {"model": p["friction"], "amplitude": 1e-5}),
        "settled": Call(engine.settled, {"model": p["friction"], "v": 0.1}),
        "hysteresis.conditioned": Call(hysteresis.conditioned, {"amplitude": 4.0, "reversals": 4}),
        "saturated": Call(hysteresis.saturated, {"extent": 1.0}),
        "inverse_of": Call(
            hysteresis.inverse_of, {"operator": hysteresis.preisach(s=1.0, f_p=1.0)}
        ),
        "relays_of": Call(
            hysteresis.relays_of,
            {"operator": hysteresis.preisach(s=1.0, f_p=1.0), "extent": 1.0, "count": 3},
        ),
        "transition_branches": Call(
            hysteresis.transition_branches,
            {"s": 1.0, "f_p": 1.0, "x_r": 2.0, "count": 3, "kind": "translational"},
        ),
        "tabulated": Call(
            hysteresis.tabulated,
            {
                "everett": lambda a, b: 0.25 * (a - b) ** 2,
                "extent": 1.0,
                "rows": 5,
                "columns": 5,
                "kind": "rotational",
            },
        ),
        "table_of_curves": Call(
            hysteresis.table_of_curves, {"curves": REVERSALS, "columns": 5, "kind": "magnetic"}
        ),
        "from_reversal_curves": Call(
            hysteresis.from_reversal_curves,
            {"curves": REVERSALS, "rows": 5, "columns": 5, "kind": "rotational"},
        ),
        "torque_seen": Call(
            sensors.torque_seen,
            {"effort": np.ones(2), "velocity": np.array([0.0, 0.5]), "dt": 0.1, "J_m": 0.1},
        ),
        "find": Call(friction.find, {"name": "lugre+asymmetry"}),
        "with_presliding": Call(
            friction.with_presliding, {"friction": p["friction"], "distance": 1e-6}
        ),
        "is_static": Call(friction.is_static, {"friction": p["friction"]}),
        "base_of": Call(friction.base_of, {"component": friction.lugre}),
        "unvaried": Call(friction.unvaried, {"friction": p["friction"]}),
        "slotted": Call(friction.slotted, {"model": friction.lugre, "asymmetry": True}),
        "with_slots": Call(friction.with_slots, {"model": friction.lugre, "slots": ["asymmetry"]}),
        "substeps_for": Call(br.simulation.substeps_for, {"sample_time": 1e-3}),
        "statistics_of": Call(br.simulation.statistics_of, {"signal": np.arange(3.0)}),
        "friction_along": Call(
            br.simulation.friction_along,
            {"model": p["friction"], "velocity": np.ones(3), "dt": 1e-3, "conditioning": 0.0},
        ),
        "feedforward_effort": Call(
            br.simulation.feedforward_effort,
            {"feedforward": Feedforward(mass=MASS), "position": X, "acceleration": X, "dt": 1e-3},
        ),
        "compensation_experiment": Call(
            br.simulation.compensation_experiment,
            mechanism
            | {
                "compensator": p["friction"],
                "controller": p["controller"],
                "reference": X,
                "sample_time": 1e-3,
                "resolution": 0.0,
                "effort_limit": 100.0,
                "disturbance": None,
                "name": "axis",
            },
        ),
        "drive_table": Call(
            prediction.drive_table,
            {
                "fit": br.identify(recorded(), "coulomb_viscous", draws=0, blocks=0).best,
                "entries": 20,
            },
        ),
        "unexplained_force": Call(
            prediction.unexplained_force, {**mechanism, "log": recorded(), "axis": None}
        ),
        "checked": Call(logs.checked, {"log": recorded(), "axis": Axis(mass=12.0)}),
        "passages": Call(logs.passages, {"log": recorded(), "axis": axis()}),
        "summarize": Call(
            logs.summarize, {"given": b"t,q\n0,1\n1,2\n2,3\n", "axis": None, "size_limit": 10**6}
        ),
        "Run": Call(
            Run,
            {
                "duration": 1.0,
                "sample_time": 1e-3,
                "substeps": 4,
                "delay": 0,
                "effort_limit": 5.0,
                "settle": 0.1,
                "current_lag": 1e-4,
                "seeds": 1,
            },
        ),
        "Feedforward": Call(
            Feedforward,
            {
                "mass": 1.0,
                "friction": p["friction"],
                "gain": 1.0,
                "offset": 0.0,
                "asymmetry": 0.0,
                "limit": 5.0,
                "rate_limit": 5.0,
                "conditioning": 0.0,
                "along": "desired",
            },
        ),
        "Learning": Call(Learning, {"trials": 3, "k_e": 1.0, "k_d": 0.0, "cutoff": 50.0}),
        "Variant": Call(
            Variant,
            {
                "name": "base",
                **p,
                "feedforward": Feedforward(),
                "run": Run(1.0, 1e-3),
                "disturbance": np.zeros(3),
                "learning": None,
                "table": None,
                "sensor_at": "load",
                "axis": None,
            },
        ),
        "Experiment": Call(
            Experiment,
            {
                "name": "small",
                "kind": "translational",
                "variants": (variant(),),
                "source": None,
                "origins": {},
            },
        ),
        "Column": Call(
            Column,
            {"name": "q", "unit": "mm", "base": "m", "scale": 1.0, "optional": False, "shift": 0.0},
        ),
        "Injected": Call(Injected, {"column": "extra", "gain": 1.0, "optional": False}),
        "Axis": Call(
            Axis,
            {
                "name": "axis",
                "kind": "translational",
                "columns": {"position": Column("q", "mm", "m")},
                "injected": (Injected("extra", 1.0),),
                "table": None,
                "sample_time": 1e-3,
                "delay": 0.0,
                "seeks_delay": False,
                "mass": 1.0,
                "plant": "inertia",
                "stiffness": None,
                "damping": None,
                "offset": "identify",
                "resolution": 1e-7,
                "effort_limit": 5.0,
                "held": None,
                "hold": "linear",
                "lag": 0.0,
                "seeks_lag": False,
                "periodic": None,
                "at_rest": False,
                "in_cycle": False,
                "span": (0.0, 1.0),
                "velocity_limit": 1.0,
                "acceleration_limit": 1.0,
                "jerk_limit": 1.0,
                "stroke": (0.0, 1.0),
                "controller": None,
                "pitch": 0.01,
                "presliding": 1e-6,
                "cutoff": 50.0,
                "decimation": 2,
                "keeps_rests": False,
                "method": "output_error",
                "loop": "open",
            },
        ),
        "Channel": Call(Channel, {"values": np.ones(3), "unit": "m", "column": "q"}),
        "Log": Call(
            Log,
            {
                **{
                    name: getattr(recorded(), name)
                    for name in ("time", "position", "velocity", "effort", "reference")
                },
                "load": None,
                "temperature": None,
                "injected": (),
                "sample_time": 1e-3,
                "segments": (slice(0, 600),),
                "notes": (),
                "kind": "translational",
            },
        ),
        "Log.from_columns": Call(
            Log.from_columns,
            {
                "columns": {
                    "time": recorded().time,
                    "position": recorded().position,
                    "effort": recorded().effort,
                },
                "axis": None,
                "kind": None,
                "sample_time": None,
            },
        ),
        "Curves": Call(
            Curves,
            {"curves": curves().curves, "start": "virgin", "kind": "translational", "notes": ()},
        ),
    }
    for item in (
        *friction.MODELS.values(),
        *hysteresis.OPERATORS.values(),
        *plants.PLANTS.values(),
        *controllers.CONTROLLERS.values(),
        *sensors.SENSORS.values(),
        *references.REFERENCES.values(),
    ):
        result[f"{item.family}.{item.name}"] = Call(
            item, {**_example(item), "kind": None, "validate": True}
        )
    return result


def _example(component: Any) -> dict[str, Any]:
    variables = component.variables.items()
    usual: dict[str, Any] = {
        name: item.choices[0] if item.choices else max(item.nominal, item.min)
        for name, item in variables
    }
    usual |= {name: [1.0, 1.0, 1.0] for name in usual if component.is_array(name)}
    return {**usual, **component.defaults, **component.example}

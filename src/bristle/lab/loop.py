"""The tracking loop of the page: two laws and an encoder as a module, and the setting of the source paper.

The mass, its friction and what is fed forward are modules of friction models, which the page has already. A law begins
as a simulation does; what it is told at a sample lies in what lasts of it.
"""

import tomllib
from functools import cache
from importlib import resources
from typing import Any
from urllib.parse import urlencode

import numpy as np

from bristle.controllers.law import law
from bristle.core.contracts import Controller, Model, Reference
from bristle.core.experiment import Experiment
from bristle.core.units import quantity
from bristle.core.variable import Variable
from bristle.exports.build import Builder
from bristle.exports.scope import defined
from bristle.exports.tree import REAL, Array, type_of
from bristle.exports.wasm import Part, module_of_parts
from bristle.files.experiment import read_experiment
from bristle.friction import find
from bristle.lab.packing import packed
from bristle.sensors.encoder import MODEL as ENCODER

# What lasts of a law: whether it has begun, what it is told, and from there on its state.
BEGUN, SAMPLE = 0, ("position", "velocity", "acceleration", "effort")
STATE = 1 + len(SAMPLE)
LAW = """
def command(lasting, x, dt, p):
    state = State({load})
    if lasting[0] == 0.0:
        state = start(x, lasting[2], lasting[3], dt, p)
    reference = Reference(lasting[1], lasting[2], lasting[3], lasting[4])
    effort, after = law(state, reference, x, 0.0, LIMIT, dt, p)
    lasting[0] = 1.0
{store}
    return effort
"""
SENSE = """
def sense(lasting, x, dt, p):
    read, after = step(State(int(lasting[0])), x, dt, p)
    lasting[0] = after.samples
    return read
"""
LIMIT = 1e300  # [N or N*m]


def law_kernel(component: Controller) -> Any:
    """Return the law of a controller as a kernel of what lasts, the position read, the time step and parameters."""
    names = component.State._fields
    load = ", ".join(f"lasting[{STATE + i}]" for i in range(len(names)))
    store = "\n".join(f"    lasting[{STATE + i}] = after.{name}" for i, name in enumerate(names))
    scope = {"State": component.State, "start": component.start, "Reference": Reference, "law": law, "LIMIT": LIMIT}
    return defined("command", LAW.format(load=load, store=store), {"__name__": __name__, **scope})


@cache
def paper_experiment() -> Experiment:
    """Return the tracking experiment of the paper."""
    with resources.as_file(resources.files("bristle").joinpath("paper", "experiments")) as folder:
        return read_experiment(folder / "set_a.toml")


@cache
def loop_described() -> dict[str, Any]:
    """Return what the page knows of the loop: its module, and the numbers of the paper."""
    from bristle.lab.described import body_described

    variants = {variant.name: variant for variant in paper_experiment().variants}
    plain, observing = variants["none"], variants["observer"]
    builder = Builder()
    parts = {
        "sliding": law_part(builder, plain.controller),
        "observer": law_part(builder, observing.controller),
        "sense": sensor_part(builder, plain.sensor),
    }
    binary, addresses = module_of_parts(builder, parts)
    law_values, sensor, motion = plain.controller.values, plain.sensor.values, plain.reference.values
    return {
        "code": packed(binary),
        "size": len(binary),
        "parts": addresses,
        "rig": body_described(plain.friction),
        "paper": {
            "M": plain.plant.values["M"],
            "gain": law_values["lambda_"],
            "K_2": law_values["K_2"],
            "g": observing.controller.values["g"],
            "resolution": sensor["resolution"],
            "amplitude": float(max(motion["amplitudes"])),
            "frequency": motion["frequency"],
        },
        "sampleTime": plain.run.sample_time,
        "delay": plain.run.delay,
    }


def law_part(builder: Builder, controller: Model, state: Any = None) -> Part:
    """Return a law as a part of a module; it begins by itself where no state is given."""
    begin = np.zeros(STATE + len(controller.component.State._fields))
    if state is not None:
        begin[BEGUN], begin[STATE:] = 1.0, state
    component = controller.component
    assert isinstance(component, Controller)
    entry = builder.function(law_kernel(component), [Array(begin.size, writable=True), REAL, REAL, type_of(controller.parameters)])
    return Part(entry, begin, controller)


def sensor_part(builder: Builder, sensor: Model) -> Part:
    """Return an encoder as a part of a module."""
    scope = {"__name__": __name__, "State": ENCODER.State, "step": ENCODER.step}
    kernel = defined("sense", SENSE, scope)
    entry = builder.function(kernel, [Array(1, writable=True), REAL, REAL, type_of(sensor.parameters)])
    return Part(entry, np.zeros(1), sensor)


LENGTH, SPEED = Variable("length", "turn"), Variable("length/time", "speed")
LUGRE, PRINTED, GATE = "LuGre", "equations (5)–(7)", "with a gate"
ON_PATHS = (
    ("Figure 1: nonlocal memory, LuGre", "fig_01", LUGRE),
    ("Figure 1: nonlocal memory, with a gate", "fig_01", GATE),
    ("Figure 8: break-away, equations as printed", "fig_08", PRINTED),
    ("Figure 9: wiping-out, with a gate", "fig_09", GATE),
)
AT_REST = (("Figure 2: drift, LuGre", "fig_02", LUGRE), ("Figure 2: drift, equations as printed", "fig_02", PRINTED))
CONTACTS = "fig_01"  # what a figure has no contact of its own of


def presets() -> list[dict[str, str]]:
    """Return the name of each figure, and the state of the page that shows it."""
    rows = []
    for word, file, contact in ON_PATHS:
        setting = _setting(file)
        turns = np.array([0.0, *(quantity(turn, LENGTH, "translational") for turn in setting["path"]["turns"])])
        speed = quantity(setting["path"]["speed"], SPEED, "translational")
        amplitude = float(np.max(np.abs(turns)))
        path = {
            "path": "drawn",
            "turns": " ".join(f"{turn:.4g}" for turn in turns / amplitude),
            "amplitude": amplitude,
            "period": 4.0 * amplitude / speed,
        }
        rows.append({"word": word, "state": _state(_contact(setting, contact), path)})
    for word, file, contact in AT_REST:
        rows.append({"word": word, "state": _state(_contact(_setting(file), contact), {"path": "presliding"})})
    variants = {variant.name: variant for variant in paper_experiment().variants}
    numbers = loop_described()["paper"]
    named = {"M": "M", "gain": "gain", "K_2": "K_2", "g": "g", "resolution": "resolution", "amplitude": "A", "frequency": "f"}
    loop = {"loop_body": 1} | {f"loop_{name}": numbers[key] for key, name in named.items()}
    for word, name in (("equations as printed", "printed"), ("LuGre", "lugre")):
        fed = variants[name].feedforward
        assert fed.friction is not None
        rows.append({"word": f"Figure 11: tracking, {word}", "state": _state(fed.friction, loop, offset=fed.offset)})
    return sorted(rows, key=lambda row: int(row["word"].split(":")[0].split()[1]))


def _setting(name: str) -> dict[str, Any]:
    file = resources.files("bristle").joinpath("paper", "experiments", f"{name}.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


def _contact(setting: dict[str, Any], name: str) -> Model:
    table = dict(setting["contact"].get(name) or _setting(CONTACTS)["contact"][name])
    return find(table.pop("model"))(**table)


def _state(model: Model, rest: dict[str, Any], **changes: float) -> str:
    """Return what the link to a page holds: the model with its values, and the rest."""
    numbers = {}
    for name, value in (dict(model.values) | changes).items():
        variable = model.component.variables.get(name)
        if variable is None or not variable.choices:
            numbers[name] = " ".join(repr(float(number)) for number in np.atleast_1d(value))
        else:
            numbers[name] = str(variable.choices.index(str(value)))
    return urlencode({"model": model.name, **numbers, **rest})

"""The tracking loop of the page: two laws and an encoder as a module, and the setting of the source paper.

The mass, its friction and what is fed forward are modules of friction models, which the page has already. A law begins
as a simulation does; what it is told at a sample lies in what lasts of it.
"""

from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from bristle.controllers.law import law
from bristle.core.contracts import Controller, Model, Reference
from bristle.core.experiment import Experiment
from bristle.exports.build import Builder
from bristle.exports.scope import defined
from bristle.exports.tree import REAL, Array, type_of
from bristle.exports.wasm import Part, module_of_parts
from bristle.files.experiment import read_experiment
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
    return parts_described(plain.sensor, sliding=(plain.controller, None), observer=(observing.controller, None)) | {
        "rig": body_described(plain.friction),
        "paper": {
            "K_2": plain.controller.values["K_2"],
            "g": observing.controller.values["g"],
            "frequency": plain.reference.values["frequency"],
        },
        "sampleTime": plain.run.sample_time,
        "delay": plain.run.delay,
    }


def parts_described(sensor: Model, **laws: tuple[Model, Any]) -> dict[str, Any]:
    """Return a module of laws, each with the state in which it begins, and an encoder, as a page unpacks it."""
    builder = Builder()
    parts = {name: law_part(builder, law, state) for name, (law, state) in laws.items()}
    binary, addresses = module_of_parts(builder, parts | {"sense": sensor_part(builder, sensor)})
    return {"code": packed(binary), "size": len(binary), "parts": addresses}


def law_part(builder: Builder, controller: Model, state: Any) -> Part:
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

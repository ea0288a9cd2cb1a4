"""Data of a friction model for a page: its module, its parameters with sliders, its scales and its walks.

A page repeats walks to show that its results equal those of Python. A walk has hashes of blocks of the forces of a contact along
positions, and of the positions of a mass on a spring with random pushes against friction. The kernels run uncompiled.
"""

import inspect
import json
import math
from collections.abc import Callable, Container, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from markupsafe import escape

from bristle.apps.targets.page.packing import packed, plain
from bristle.apps.targets.page.sliders import (
    AROUND,
    Scales,
    conditions_of,
    elements_of,
    pulled_by,
    scales_of,
    shares_of,
    slider_for,
)
from bristle.apps.targets.wasm import Module, module_of
from bristle.core import (
    GREEK,
    FrictionModel,
    Model,
    Variable,
    example_of,
    symbolic,
    typeset,
    unit_of,
)
from bristle.engine.mechanism import Mechanism, mechanism
from bristle.engine.translation.build import Builder
from bristle.engine.translation.tree import Function
from bristle.exports.cycle import OVERFLOW, REFUSED, STATE, at_rest_of
from bristle.exports.subject import (
    FACTOR,
    SEED,
    TERM,
    Subject,
    Walk,
    forces_of,
    hash_of,
    presliding_distance,
    subject_of,
    walk_of,
)
from bristle.files.components import key_of
from bristle.files.user_model import code_of
from bristle.models.friction import MODELS, base_of, channel_slots_of, find
from bristle.models.friction.next_model import goes_by_name
from bristle.models.friction.resting import rest_rule, with_rest
from bristle.models.friction.slots import variations_of
from bristle.models.hysteresis.turning_points import Stack

STEP = 5e-4  # of the walk of a contact [s]
BLOCK = 1000
# Steps of a model of the package, and of a model whose walk is computed while a page is written.
LONG = 20 * BLOCK
SHORT = 4 * BLOCK
PUSHED = 500
# Steps with each set of slots, one per step length; sets in a block.
STEPS_WITH_SLOTS = 500
TOGETHER = 16


def walked(subject: Subject, plant: Model, scales: Scales, count: int) -> dict[str, Any]:
    """Return the walks of a model, each with the hashes of its blocks."""
    walk = walk_of(subject, STEP)
    forces = subject.forces(walk.positions(count), STEP)
    # At this step the largest push moves a free mass by about the pre-sliding distance.
    dt = math.sqrt(presliding_distance(subject) * plant.values["M"] / scales.force)
    push = 2.0 * scales.force / 32768.0
    places = _pushed(subject, plant, push, dt)
    return {
        "contact": {
            "scales": list(walk.scales),
            "dt": STEP,
            "count": count,
            "hashes": _hashes(forces),
        },
        "mass": {"push": push, "dt": dt, "count": PUSHED, "hashes": _hashes(places)},
    }


def walked_together(
    models: Sequence[Model],
    arounds: Sequence[Sequence[float]],
    walks: Mapping[str, Any],
    plant: Model,
) -> dict[str, Any]:
    """Return the walks of one contact with several sets of slots, each in its surroundings, and of the mass with the last set."""
    contact = walks["contact"]
    mass = walks["mass"]
    positions = Walk(tuple(contact["scales"]), STEP).positions(STEPS_WITH_SLOTS)
    forces = [
        forces_of(model, positions, STEP, *around)
        for model, around in zip(models, arounds, strict=True)
    ]
    places = _pushed(subject_of(models[-1]), plant, mass["push"], mass["dt"])
    return {
        "count": STEPS_WITH_SLOTS,
        "together": TOGETHER,
        "hashes": _hashes(np.concatenate(forces), STEPS_WITH_SLOTS * TOGETHER),
        "mass": _hashes(places),
    }


@cache
def stored() -> dict[str, Any]:
    """Return the stored walks of the models of the package, with their examples."""
    return json.loads(
        resources.files("bristle.apps.targets.page")
        .joinpath("walks.json")
        .read_text(encoding="utf-8")
    )


def _hashes(values: np.ndarray, block: int = BLOCK) -> list[str]:
    return [f"{hash_of(values[k : k + block].tolist()):016x}" for k in range(0, len(values), block)]


def _pushed(subject: Subject, plant: Model, push: float, dt: float) -> np.ndarray:
    """Return the positions of a mass under a different push in every step."""
    p = subject.model.parameters
    q = plant.parameters
    body = plant.component.initial_state(q)
    now = Mechanism(body, subject.virgin, 0.0, 0.0, 0.0, 0.0, 0.0)
    memory = subject.model.component.new_memory(p)
    x = np.zeros(PUSHED)
    bits = SEED
    for k in range(PUSHED):
        bits = (bits * FACTOR + TERM) % 2**32
        effort = ((bits >> 16) - 32768.0) * push
        after = mechanism(now, memory, effort, effort, 0.0, 0.0, dt, 1, q, p)
        # State as in an export: the effort of the drive and the start values of the solve.
        now = Mechanism(
            after.plant, after.friction, after.effort, after.slope, after.acceleration, 0.0, 0.0
        )
        x[k] = after.plant.x
    return x


UNITS = {"position": "length", "velocity": "length/time", "force": "force"}


def example_named(name: str) -> Model:
    """Return a friction model of the package with the values of its example, without slots except the offset."""
    return example_of(find(name))


def walks_of(model: Model, count: int = LONG) -> dict[str, Any]:
    """Return newly computed walks of a model."""
    subject = subject_of(model)
    scales = scales_of(subject)
    return walked(subject, pulled_by(scales, model), scales, count)


def model_described(
    model: Model,
    *,
    uncertainty: Mapping[str, Mapping[str, Any]] | None = None,
    mass: float | None = None,
    fastest: float = 0.0,
    named: str = "",
    around: float = AROUND,
    proven: bool = True,
    led: Model | None = None,
) -> dict[str, Any]:
    """Return the data of a friction model for a page."""
    subject = subject_of(model)
    moving = subject_of(led or model)
    scales = scales_of(moving)
    plant = pulled_by(scales, model, mass)
    module, facts = _module(subject, plant, {"rest": lambda builder: at_rest_of(subject, builder)})
    if proven:
        saved = stored().get(moving.model.name)
        is_example = saved is not None and moving.model == example_named(moving.model.name)
        facts["walks"] = saved
        if not is_example:
            facts["walks"] = walked(moving, plant, scales, SHORT)
    return facts | {
        "name": named or model.name,
        "model": model.name,
        "description": model.component.description,
        "variables": variables_of(model, module.places, scales.force, uncertainty or {}, around),
        "pull": variables_of(plant, module.places, scales.force, {}),
        "conditions": conditions_of(model.component),
        "shares": shares_of(model.component),
        "units": {name: typeset(unit_of(quantity, model.kind)) for name, quantity in UNITS.items()},
        "scales": scales._asdict(),
        "head": head_of(model.component),
        "fastest": fastest,
        "mass": mass,
        "varies": bool(variations_of(model.component)),
        "holds": bool(rest_rule(with_rest(model, "held"))),
    }


def body_described(model: Model) -> dict[str, Any]:
    """Return the data of a friction model that acts only on a mass in a loop."""
    subject = subject_of(model)
    module, facts = _module(subject, pulled_by(scales_of(subject), model), {})
    values = {name: value for name, value in model.values.items() if name in module.places}
    return facts | {
        "values": {
            name: np.atleast_1d(value).astype(float).tolist() for name, value in values.items()
        }
    }


def _module(
    subject: Subject, plant: Model, functions: Mapping[str, Callable[[Builder], Function]]
) -> tuple[Module, dict[str, Any]]:
    """Return the module of a friction model with further functions, and its data."""
    module = module_of(subject, plant, choices=True, others=functions)
    stack = None
    # The addresses of input, direction and depth in its state.
    if isinstance(subject.virgin, Stack):
        names = [name for name, _ in subject.state.fields]
        stack = {name: STATE + names.index(name) for name in ("z", "side", "depth")}
    return module, module_described(module) | {
        "kind": subject.model.kind,
        "refused": REFUSED,
        "overflow": OVERFLOW,
        "stack": stack,
        "elements": elements_of(subject.model, subject.memory_size),
        "still": module.still,
    }


def module_described(module: Module, before: bytes = b"") -> dict[str, Any]:
    """Return a module in packed form; it may refer to the bytes `before` it."""
    numbers = {
        name: getattr(module, name)
        for name in ("lasting", "contact", "body", "parameters", "places")
    }
    return {"code": packed(module.binary, before)} | numbers


def variables_of(
    model: Model,
    movable: Container[str],
    force: float,
    uncertainty: Mapping[str, Mapping[str, Any]],
    around: float = AROUND,
) -> list[dict[str, Any]]:
    """Return the data of the parameters of a model for a page; those in `movable` have sliders.

    `force` [N or N*m] is the range of the slider of a force whose value is 0. The other sliders reach from the value over
    `around` to the value times `around`.
    """
    rows = []
    for name, variable in model.component.variables.items():
        value = model.values[name]
        facts = uncertainty.get(name, {})
        numbers = _numbers(variable, value)
        interval = None
        if len(numbers) == 1:
            interval = facts.get("interval")
        span = 0.0
        if variable.quantity == "force":
            span = force
        symbol = str(symbolic(name))
        if name in GREEK or len(name) == 1:
            symbol = f"<i>{escape(GREEK.get(name, name))}</i>"
        directional = {}
        if variable.directional:
            directional = {"directional": True}
        rows.append(
            {
                "name": name,
                "key": key_of(name),
                "symbol": symbol,
                "values": numbers,
                "unit": typeset(variable.unit(model.kind)),
                "description": " ".join(variable.description.split()),
                "min": variable.min,
                "max": variable.max,
                "choices": list(variable.choices),
                "array": np.ndim(value) == 1,
                "whole": model.component.is_integer(name) and not variable.choices,
                "fixed": name not in movable,
                "interval": list(interval) if interval else None,
                "status": str(facts.get("status", "")),
                "sliders": [
                    slider_for(
                        variable, number, interval=interval, span=span, around=around
                    )._asdict()
                    for number in numbers
                ],
            }
            | directional
        )
    return rows


def widget_described(
    model: Model, *, uncertainty: Mapping[str, Mapping[str, Any]] | None, fastest: float
) -> dict[str, Any]:
    """Return the data of a friction model for a widget, readable by a script."""
    return plain(model_described(model, uncertainty=uncertainty, fastest=fastest, proven=False))


def values_of(model: Model) -> dict[str, Any]:
    """Return the values of a model for a page: a list of numbers for each parameter."""
    return plain(
        {
            name: _numbers(variable, model.values[name])
            for name, variable in model.component.variables.items()
        }
    )


def _numbers(variable: Variable, value: Any) -> list[float]:
    """Return the numbers of a parameter for a page; a choice becomes its index."""
    coded = value
    if isinstance(value, str):
        coded = variable.choices.index(value)
    return [float(number) for number in np.atleast_1d(coded)]


def head_of(component: FrictionModel) -> dict[str, str]:
    """Return the name of a model in a model file and in Python."""
    base, *slots = component.name.split("+")
    inner = base_of(component)
    files = {
        slot.name: code.source.name
        for slot in channel_slots_of(component)
        if (code := code_of(slot)) is not None
    }
    slots = [files.get(slot, slot) for slot in slots]
    if MODELS.get(base) is inner:
        python = ""
        if goes_by_name(component):
            python = f'br.friction.find("{component.name}")'
        return {"toml": f'model = "{"+".join([base, *slots])}"', "python": python}
    file = inspect.getfile(inner.trial).replace("\\", "/").rpartition("/")[2]
    beside = ""
    if slots:
        beside = f"\nslots = {slots}".replace("'", '"')
    return {"toml": f'file = "{file}"{beside}', "python": ""}

"""Slots that a page can switch: a module with all slots, and the initial values of each slot.

A page has two modules of a model. The plain module has separate parameters per direction, as ``+asymmetry`` needs, and is
fast. The wide module has every slot; an inactive slot has neutral coefficients, which change no bit of the results. The page
assembles the list of parameters. Load, temperature and effort, inputs of a kernel at each step, are parameters of an
outer layer: they are constant, and have sliders.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import compress, product
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from bristle.apps.targets.page.described import (
    example_named,
    model_described,
    module_described,
    variables_of,
    walked_together,
    walks_of,
)
from bristle.apps.targets.page.packing import as_json, packed, unpacked
from bristle.apps.targets.page.sliders import Scales, Slider, pulled_by, scales_of
from bristle.apps.targets.wasm import Module, module_of
from bristle.core import InputError, Surrounding, Variable, kernel, symbolic
from bristle.core.contracts import (
    NOMINAL_LOAD,
    NOMINAL_TEMPERATURE,
    NOTHING_TRANSMITTED,
    FrictionModel,
    Kind,
    Model,
    Motion,
    make_model,
)
from bristle.core.dispatch import friction_trial
from bristle.core.lazy import once
from bristle.exports.cycle import at_rest_of
from bristle.exports.subject import subject_of
from bristle.models.friction import MODELS, base_of, channel_slots_of, with_slots
from bristle.models.friction.enclosing import CoefficientsModel, enclosed
from bristle.models.friction.level import LEVELS, RISES_WITH as RISING, Rise, has_level
from bristle.models.friction.slots import WHAT_SLOTS_DO, SlottedModel, by_direction
from bristle.models.friction.variation import (
    ADDS,
    SMALLEST_FACTOR,
    VARIATIONS,
    VARIES_WITH as VARYING,
    Place,
)


class Surroundings(NamedTuple):
    """Load, temperature and effort; their names are those of no parameter of a model."""

    around_load: Annotated[float, Variable("1", "load over its nominal value")] = NOMINAL_LOAD
    around_temperature: Annotated[float, Variable("temperature", "temperature")] = (
        NOMINAL_TEMPERATURE
    )
    around_transmitted: Annotated[float, Variable("force", "transmitted effort")] = (
        NOTHING_TRANSMITTED
    )


# Inputs besides the motion, by slot.
AROUND = {
    "load": "around_load",
    "temperature": "around_temperature",
    "transmitted": "around_transmitted",
}


class Surrounded(NamedTuple):
    """Parameters of a model and of its surroundings."""

    inner: Any
    around: Surroundings


@kernel
def trial(state, memory, motion, dt, p):
    """Return the mean force [N or N*m] and the move of the inner model in its surroundings."""
    passed = motion.transmitted + p.around.around_transmitted
    around = Motion(motion.v, motion.x, p.around.around_load, p.around.around_temperature, passed)
    force, move = friction_trial(state, memory, around, dt, p.inner)
    return force, move


@dataclass(frozen=True, kw_only=True)
class SurroundedModel(CoefficientsModel):
    """A friction model with its surroundings as parameters."""

    coefficients = Surroundings
    of_slot = MappingProxyType({"around": Surroundings._fields})
    without_default = ()
    depends_on = MappingProxyType({})

    @property
    def surroundings(self) -> tuple[Surrounding, ...]:
        """Surroundings without a parameter."""
        return tuple(
            item
            for item in self.inner.surroundings
            if f"around_{item.name}" not in Surroundings._fields
        )

    @property
    def defaults(self) -> dict[str, Any]:
        """The parameters that have a default value."""
        return self.inner.defaults | Surroundings._field_defaults


@once
def surrounded(model: FrictionModel) -> SurroundedModel:
    """Return a friction model with its surroundings as parameters."""
    return enclosed(
        SurroundedModel,
        model,
        name=model.name,
        description=model.description,
        Parameters=Surrounded,
        trial=trial,
        slots=("around",),
    )


SLOTS = (*LEVELS, *VARIATIONS, "asymmetry")  # all available slots, in the order of a name
SIDES = {"_pos": 1.1, "_neg": 0.9}  # initial value of a parameter per direction, over that of both


class Start(NamedTuple):
    """Initial value of a number, over a scale of the model if it has one, and ends of its slider."""

    value: float
    scale: str = ""
    ends: tuple[float, float] | None = None


MODULE = ("code", "lasting", "contact", "body", "parameters", "places", "still")
EITHER_WAY = (-1.0, 1.0)
# A path is ten pre-sliding distances long from end to end.
STARTS = {
    "x_0": Start(0.0, "reach", (-20.0, 20.0)),
    "x_L": Start(5.0, "reach"),
    "p_1": Start(0.2),
    "p_2": Start(0.0, "", (-0.8, 0.8)),
    "a_1": Start(0.0, "force", EITHER_WAY),
    "a_2": Start(0.0, "force", EITHER_WAY),
    "pitch": Start(4.0, "reach"),
    "c_1": Start(0.1, "force", EITHER_WAY),
    "s_1": Start(0.0, "force", EITHER_WAY),
    "c_2": Start(0.0, "force", EITHER_WAY),
    "s_2": Start(0.0, "force", EITHER_WAY),
    "k_L": Start(0.5),
    "k_T": Start(-0.01),
    "c_T": Start(0.2),
    "h_c1": Start(0.2, "force", EITHER_WAY),
    "h_s1": Start(0.0, "force", EITHER_WAY),
    "h_c2": Start(0.0, "force", EITHER_WAY),
    "h_s2": Start(0.0, "force", EITHER_WAY),
    "around_load": Start(1.5, "", (0.0, 5.0)),
    "around_temperature": Start(NOMINAL_TEMPERATURE + 10.0, "", (233.15, 393.15)),
    "around_transmitted": Start(1.0, "force", (-4.0, 4.0)),
}
# Neutral values of the numbers of slots.
NEUTRAL = Place._field_defaults | Rise._field_defaults | Surroundings._field_defaults
SYMBOLS = {
    "around_load": "<i>L</i>",
    "around_temperature": "<i>T</i>",
    "around_transmitted": "<i>τ</i>",
}
POSITIVE = "1 + <i>p</i><sub>1</sub> ξ + <i>p</i><sub>2</sub> ξ² &gt; 0 for ξ from −1 to 1"


def slots_of(model: Model) -> tuple[str, ...]:
    """Return the slots of a friction model, in the order of a name."""
    return tuple(slot for slot in SLOTS if slot in model.name.split("+")[1:])


def offered(model: Model) -> tuple[str, ...]:
    """Return the slots that affect a friction model; a model without a level cannot rise."""
    base = base_of(model.component)
    levels = has_level(base)
    directional = any(variable.directional for variable in base.variables.values())
    return tuple(
        slot
        for slot in SLOTS
        if (levels or slot not in LEVELS) and (directional or slot != "asymmetry")
    )


def plain_of(model: Model) -> Model:
    """Return a friction model without these slots, with the mean of parameters that differ by direction."""
    component = _with(model, ())
    values: dict[str, Any] = {"offset": model.values.get("offset", 0.0)}
    for name in component.inner.variables:
        sides = [model.values[key] for key in by_direction(model.component, name)]
        if len(sides) == 1:
            values[name] = sides[0]
        else:
            values[name] = _rounded(0.5 * (sides[0] + sides[1]))
    return make_model(component, values, kind=model.kind, validate=False)


def _with(model: Model, slots: Sequence[str]) -> SlottedModel:
    return with_slots(base_of(model.component), slots)


def begun(plain: Model, slots: Sequence[str], scales: Scales) -> Model:
    """Return a plain friction model with some slots at their initial values."""
    component = _with(plain, [slot for slot in SLOTS if slot in slots])
    values: dict[str, Any] = {}
    for name in component.variables:
        own = _of_both(name, plain)
        side = name[len(own) :]
        if own in plain.values:
            value = plain.values[own]
        else:
            value = start_of(own, scales)
        values[name] = value
        if side:
            values[name] = _rounded(SIDES[side] * value)
    return make_model(component, values, kind=plain.kind, validate=False)


def start_of(name: str, scales: Scales) -> float:
    """Return the initial value of a number of a slot."""
    start = STARTS[name]
    if start.scale:
        return float(f"{start.value * getattr(scales, start.scale):.3g}")
    return start.value


def _rounded(value: Any) -> Any:
    """Return a number without the extra digits of a product."""
    if np.ndim(value) == 0:
        return float(f"{value:.12g}")
    return np.array([_rounded(float(number)) for number in value])


def combinations(slots: Sequence[str], *, complete: bool) -> list[tuple[str, ...]]:
    """Return the combinations of slots for walks: all combinations, or each slot alone and all together."""
    if complete:
        return [
            tuple(compress(slots, chosen)) for chosen in product((False, True), repeat=len(slots))
        ]
    return [*((slot,) for slot in slots), tuple(slots)]


def slot_walks(
    plain: Model, plant: Model, scales: Scales, walks: Mapping[str, Any], *, complete: bool
) -> dict[str, Any]:
    """Return the walks of a model with sets of slots and with the surroundings of these slots, at their initial values."""
    sets = combinations(offered(plain), complete=complete)
    models = [begun(plain, slots, scales) for slots in sets]
    return walked_together(models, [_around(slots, scales) for slots in sets], walks, plant) | {
        "complete": complete
    }


def _around(slots: Sequence[str], scales: Scales) -> list[float]:
    """Return load, temperature and effort: initial values of those that a slot depends on, else neutral ones, as on the page."""
    felt = {AROUND[slot] for slot in slots if slot in AROUND}
    around = NEUTRAL | {name: start_of(name, scales) for name in felt}
    return [around[name] for name in Surroundings._fields]


def all_walks(model: Model) -> dict[str, Any]:
    """Return the walks of a friction model without slots and with every set of slots."""
    walks = walks_of(model)
    scales = scales_of(subject_of(model))
    return walks | {
        "slots": slot_walks(model, pulled_by(scales, model), scales, walks, complete=True)
    }


def slots_described(kind: Kind) -> dict[str, Any]:
    """Return the data of the slots for a page: the parameters of each, over the scales of a model."""
    component = surrounded(with_slots(MODELS["coulomb"], SLOTS[:-1]))
    values = dict.fromkeys(component.variables, 1.0)
    values |= {name: STARTS[name].value for name in values if name in STARTS}
    model = make_model(component, values, kind=kind, validate=False)
    rows = {row["name"]: row for row in variables_of(model, STARTS, 1.0, {})}
    for name, start in STARTS.items():
        rows[name]["scale"] = start.scale
        if start.ends is not None:
            rows[name]["sliders"] = [Slider(*start.ends, logarithmic=False)._asdict()]
        rows[name] |= {
            "slot": True,
            "symbol": SYMBOLS.get(name, rows[name]["symbol"]),
            "nothing": NEUTRAL[name],
        }
    slots: dict[str, Any] = {
        "asymmetry": {"cause": "direction", "does": WHAT_SLOTS_DO["asymmetry"]}
    }
    for slot, names in {**LEVELS, **VARIATIONS}.items():
        cause = (RISING | VARYING | ADDS)[slot]
        slots[slot] = {
            "cause": cause,
            "does": WHAT_SLOTS_DO[slot],
            "rows": [rows[name] for name in names],
        }
        if slot in AROUND:
            slots[slot]["around"] = rows[AROUND[slot]]
    (relation,) = with_slots(MODELS["viscous"], ["position"]).relations
    condition = {
        "text": POSITIVE,
        "mend": str(symbolic(relation.mend)),
        "least": SMALLEST_FACTOR,
        "advisory": False,
    }
    slots["position"]["condition"] = condition
    return slots


def switched(
    model: Model,
    *,
    uncertainty: Mapping[str, Mapping[str, Any]] | None = None,
    mass: float | None = None,
    **known: Any,
) -> dict[str, Any]:
    """Return the data of a friction model with switchable slots for a page, with the parameters of `model_described`."""
    # Modules are packed with `common_module` as a dictionary, the wide module also with the plain one.
    over = channel_slots_of(model.component)
    if over:
        names = ", ".join(slot.name for slot in over)
        raise InputError(
            "has a slot that needs a channel of the log, but a page has no log",
            path="model",
            value=names,
            mend="Remove the slot",
        )
    plain = plain_of(model)
    slots = slots_of(model)
    uncertainties = uncertainty or {}
    of_plain = uncertainties
    if slots:
        of_plain = {}
    facts = model_described(plain, uncertainty=of_plain, mass=mass, led=model, **known)
    leans = base_of(plain.component).trial_sided is not None
    if leans:
        # With equal directions it is identical to the plain model.
        component = _with(plain, ["asymmetry"])
        values = {name: plain.values[_of_both(name, plain)] for name in component.variables}
        directed = make_model(component, values, kind=plain.kind, validate=False)
        module = model_described(directed, mass=mass, proven=False, led=model)
        facts |= {key: module[key] for key in MODULE}
    binary = unpacked(facts["code"])
    common = common_module()
    scales = Scales(**facts["scales"])
    plant = pulled_by(scales, plain, mass)
    wide, levels = _wide(plain, plant)
    if "slots" not in facts["walks"]:
        facts["walks"] = facts["walks"] | {
            "slots": slot_walks(plain, plant, scales, facts["walks"], complete=False)
        }
    facts |= {
        "code": packed(binary, before=common),
        "offered": list(offered(plain)),
        "leans": leans,
        "wide": module_described(wide, before=common + binary) | {"levels": levels},
    }
    if slots:
        rows = variables_of(model, {*wide.places, *facts["places"]}, scales.force, uncertainties)
        base = base_of(plain.component).variables
        for row in rows:
            if _of_both(row["name"], plain) not in (*base, "offset"):
                row["slot"] = True
        facts["own"] = {"slots": list(slots), "rows": rows}
    return facts


@cache
def common_module() -> bytes:
    """Return the module that serves as a dictionary for all others: the smallest model with every slot."""
    plain = example_named("coulomb")
    return _wide(plain, pulled_by(scales_of(subject_of(plain)), plain))[0].binary


def _wide(plain: Model, plant: Model) -> tuple[Module, list[int]]:
    """Return the module of a friction model with every slot at neutral values, and the addresses of the levels."""
    component = surrounded(_with(plain, offered(plain)))
    neutral = component.defaults | dict(plain.values) | NEUTRAL
    values = {name: neutral[_of_both(name, plain)] for name in component.variables}
    subject = subject_of(make_model(component, values, kind=plain.kind, validate=False))
    functions = {"rest": lambda builder: at_rest_of(subject, builder)}
    module = module_of(subject, plant, choices=True, others=functions)
    varying = {address for address, _ in module.still}
    levels = [
        address
        for name, rows in module.places.items()
        if _of_both(name, plain) in plain.values and component.variables[name].quantity == "force"
        for row in rows
        for address in row
        if address in varying
    ]
    return module, levels


def _of_both(name: str, plain: Model) -> str:
    """Return the name of the common parameter for a parameter of one direction."""
    if name not in plain.values and name.endswith(tuple(SIDES)):
        return name[: -len("_pos")]
    return name


@cache
def example_described(name: str) -> dict[str, Any]:
    """Return the data of a friction model of the package with the values of its example, for a page."""
    return switched(example_named(name))


def common_described() -> dict[str, Any]:
    """Return the packed dictionary of the modules of all models."""
    common = common_module()
    return {"code": packed(common)}


def lab_described(first: str | Model, loop: Mapping[str, Any], **options: Any) -> dict[str, Any]:
    """Return the data of the lab: the examples of all models, the first model, slots and a loop.

    `first` is the name of an example, or a model with given values; options of such a model are those of `switched`.
    """
    models = [example_described(name) for name in MODELS]
    place = 0
    if isinstance(first, str):
        place = list(MODELS).index(first)
    else:
        models.insert(0, switched(first, **options))
    data = {
        "models": models,
        "first": place,
        "loop": loop,
        "common": common_described(),
        "slots": {kind: slots_described(kind) for kind in sorted({row["kind"] for row in models})},
    }
    content = as_json(data).encode("utf-8")
    return {"code": packed(content)}

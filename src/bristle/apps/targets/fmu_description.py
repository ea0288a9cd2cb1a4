"""modelDescription.xml of an FMU, for FMI 2.0 and FMI 3.0."""

import math
from collections.abc import Mapping
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from bristle.apps.targets.fmu_content import (
    CONSTANT,
    INPUT,
    MARGIN,
    OUTPUT,
    PARAMETER,
    RATE,
    START,
    STATE,
    TIME,
    Content,
    Port,
    Setting,
)
from bristle.core.dimensions import Kind, exponents_of
from bristle.exports.c import FLAGS
from bristle.exports.described import LICENCE, copyright_line, model_version, version
from bristle.exports.printing import element

# Quantities without a longer form, in SI base units.
BASE: dict[Kind, dict[str, dict[str, int]]] = {
    "translational": {"force": {"kg": 1, "m": 1, "s": -2}, "length": {"m": 1}},
    "rotational": {"force": {"kg": 1, "m": 2, "s": -2}, "length": {"rad": 1}},
}
EVERYWHERE = {
    "force of travel": {"kg": 1, "m": 1, "s": -2},
    "travel": {"m": 1},
    "time": {"s": 1},
    "temperature": {"K": 1},
}


class Role(NamedTuple):
    """Attributes of a variable in the standard."""

    causality: str
    variability: str = "continuous"
    initial: str = ""


ROLES = {
    TIME: Role("independent"),
    INPUT: Role("input"),
    OUTPUT: Role("output", initial="calculated"),
    START: Role("output", initial="exact"),
    PARAMETER: Role("parameter", "tunable", "exact"),
    CONSTANT: Role("local", "constant", "exact"),
    STATE: Role("local", initial="calculated"),
    RATE: Role("local", initial="calculated"),
    MARGIN: Role("local", initial="calculated"),
}


TOKENS = {2: "guid", 3: "instantiationToken"}  # attribute of the token, by FMI


def description_text(content: Content, setting: Setting, token: str) -> str:
    """Return modelDescription.xml."""
    ports = content.ports
    source = setting.source
    fmi = setting.fmi
    file = source.provenance.get("model") or source.provenance.get("experiment")
    made = f"bristle {version()}"
    author = made
    if file:
        author += f", from {file}"
    rights = f"{LICENCE} for the text that bristle wrote; the model and its numbers are yours"
    facts = {
        "fmiVersion": f"{fmi}.0",
        "modelName": setting.name,
        TOKENS[fmi]: token,
        "description": content.title,
        "version": model_version(source),
        "author": author,
        "copyright": copyright_line(),
        "license": rights,
        "generationTool": made,
        "variableNamingConvention": "structured",
    }
    if fmi == 2 and ports.states:
        facts |= {"numberOfEventIndicators": str(len(ports.in_role(MARGIN)))}
    common = {"stepSize": repr(setting.step)}
    if ports.states:
        common["tolerance"] = "1e-06"
    model = element("Model", sha256=source.model_hash)
    tools = element("VendorAnnotations", element("Tool", model, name="bristle"))
    annotations = element("Annotation", model, type="bristle")
    inside = [
        *_kinds(setting, exchanged=bool(ports.states)),
        _units(content),
        element(
            "LogCategories",
            element("Category", name="logStatusError", description="reason of a refused call"),
        ),
        element("DefaultExperiment", startTime="0", **common),
    ]
    if fmi == 2 and source.model_hash:
        inside += [tools]
    inside += [
        element(
            "ModelVariables",
            *(_variable(i, port, content, fmi) for i, port in enumerate(ports.listed)),
        ),
        _structure(content, fmi),
    ]
    if fmi == 3 and source.model_hash:
        inside += [element("Annotations", annotations)]
    return _xml(element("fmiModelDescription", *inside, **facts))


def _xml(root: Element) -> str:
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _kinds(setting: Setting, *, exchanged: bool) -> list[Element]:
    """Return the capabilities of each kind of FMU."""
    source = []
    fixed = {}
    if setting.fmi == 2:
        source = [element("SourceFiles", element("File", name=f"{setting.name}.c"))]
        able = {
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
            "canNotUseMemoryManagementFunctions": "true",
        }
        without = {"completedIntegratorStepNotNeeded": "true"}
        derived = {"providesDirectionalDerivative": "true"}
    else:
        able = {"canGetAndSetFMUState": "true", "canSerializeFMUState": "true"}
        without = {"needsCompletedIntegratorStep": "false"}
        derived = {"providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true"}
        fixed = {"fixedInternalStepSize": repr(setting.step)}
    kinds = {}
    if exchanged:
        kinds = {"ModelExchange": without | able | derived}
    kinds["CoSimulation"] = {"canHandleVariableCommunicationStepSize": "true"} | able | fixed
    return [
        element(tag, *source, modelIdentifier=setting.name, **facts) for tag, facts in kinds.items()
    ]


def _units(content: Content) -> Element:
    quantities = {
        port.variable.unit(content.kind): port.variable.quantity for port in content.ports.listed
    }
    bases = {
        unit: _base(quantity, content.kind) for unit, quantity in quantities.items() if unit != "1"
    }
    written = {
        unit: {symbol: str(power) for symbol, power in base.items()} for unit, base in bases.items()
    }
    definitions = element("UnitDefinitions")
    for unit, powers in written.items():
        entry = element("Unit", name=unit)
        if powers:
            entry.append(element("BaseUnit", **powers))
        definitions.append(entry)
    return definitions


INFINITE = {math.inf: "INF", -math.inf: "-INF"}


def _variable(reference: int, port: Port, content: Content, fmi: int) -> Element:
    """Return a variable; for states of an importer also the nominal value, for rates the state."""
    role = ROLES[port.role]
    unit = port.variable.unit(content.kind)
    states = content.ports.states
    rates = content.ports.in_role(RATE)
    head = {
        "name": port.name,
        "valueReference": str(reference),
        "description": port.variable.description,
    }
    if port.sure:
        head["description"] += f" ({port.sure})"
    head |= {"causality": role.causality, "variability": role.variability}
    number = {}
    if unit != "1":
        number["unit"] = unit
    if port.role != TIME:
        bounds = {"min": float(port.variable.min), "max": float(port.variable.max)}
        number |= {name: repr(bound) for name, bound in bounds.items() if math.isfinite(bound)}
    if port.role != TIME and role.initial != "calculated":
        number["start"] = INFINITE.get(port.value, repr(port.value))
    if reference in states:
        number["nominal"] = repr(port.variable.nominal)
    elif reference in rates:
        number["derivative"] = str(states[rates.index(reference)] + COUNTED_FROM[fmi])
    if role.initial:
        head |= {"initial": role.initial}
    if fmi == 2:
        return element("ScalarVariable", element("Real", **number), **head)
    return element("Float64", **head, **number)


# In FMI 2.0 indices count from 1, and are not value references.
COUNTED_FROM = {2: 1, 3: 0}


def _structure(content: Content, fmi: int) -> Element:
    ports = content.ports
    structure = element("ModelStructure")
    rates = ports.in_role(RATE)
    known = ()
    of_first = ()
    if ports.states:
        known = (*ports.in_role(INPUT), *ports.states)
        of_first = None
    # Force and rates depend on the states; with a mass, the force does not depend directly on the effort.
    on_force = known
    if ports.states and ports.in_role(START):
        on_force = ports.states
    outputs = dict.fromkeys(ports.in_role(START, OUTPUT), on_force)
    outputs |= {i: (i,) for i in outputs if i in ports.states}
    first = dict.fromkeys((*ports.in_role(OUTPUT, STATE), *rates), of_first)
    lists: dict[str, Mapping[int, tuple[int, ...] | None]] = {
        "Output": outputs,
        "ContinuousStateDerivative": dict.fromkeys(rates, known),
        "InitialUnknown": first,
        "EventIndicator": dict.fromkeys(ports.in_role(MARGIN), known),
    }
    heads = {
        "Output": "Outputs",
        "ContinuousStateDerivative": "Derivatives",
        "InitialUnknown": "InitialUnknowns",
    }
    for name, unknowns in lists.items():
        if fmi == 2 and (
            name not in heads or (name == "ContinuousStateDerivative" and not ports.states)
        ):
            continue
        rows = []
        for unknown, depends in sorted(unknowns.items()):
            on = {}
            if depends is not None:
                places = (str(place + COUNTED_FROM[fmi]) for place in sorted(depends))
                on = {"dependencies": " ".join(places)}
            at = str(unknown + COUNTED_FROM[fmi])
            if fmi == 2:
                rows.append(element("Unknown", index=at, **on))
            else:
                rows.append(element(name, valueReference=at, **on))
        if fmi == 2:
            rows = [element(heads[name], *rows)]
        structure.extend(rows)
    return structure


def build_text(name: str) -> str:
    """Return buildDescription.xml of FMI 3.0, the build instructions of the source."""
    files = element(
        "SourceFileSet",
        element("SourceFile", name=f"{name}.c"),
        language="C99",
        compilerOptions=FLAGS,
    )
    configuration = element("BuildConfiguration", files, modelIdentifier=name)
    return _xml(element("fmiBuildDescription", configuration, fmiVersion="3.0"))


def _base(quantity: str, kind: Kind) -> dict[str, int]:
    """Return the powers of base units of a quantity; empty if a power is not an integer."""
    total: dict[str, float] = {}
    for name, power in exponents_of(quantity).items():
        for symbol, inner in (BASE[kind] | EVERYWHERE)[name].items():
            total[symbol] = total.get(symbol, 0.0) + power * inner
    is_integral = all(power == int(power) for power in total.values())
    if is_integral:
        return {symbol: int(power) for symbol, power in total.items() if power}
    return {}

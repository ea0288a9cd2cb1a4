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


def description_text(content: Content, setting: Setting, token: str) -> str:
    """Return modelDescription.xml."""
    ports, source, fmi = content.ports, setting.source, setting.fmi
    file = source.provenance.get("model") or source.provenance.get("experiment")
    made, rights = (
        f"bristle {version()}",
        f"{LICENCE} for the text that bristle wrote; the model and its numbers are yours",
    )
    facts = {
        "fmiVersion": f"{fmi}.0",
        "modelName": setting.name,
        "guid" if fmi == 2 else "instantiationToken": token,
    }
    facts |= {
        "description": content.title,
        "version": model_version(source),
        "author": made + (f", from {file}" if file else ""),
    }
    facts |= {
        "copyright": copyright_line(),
        "license": rights,
        "generationTool": made,
        "variableNamingConvention": "structured",
    }
    facts |= (
        {"numberOfEventIndicators": str(len(ports.in_role(MARGIN)))}
        if fmi == 2 and ports.states
        else {}
    )
    common = {"stepSize": repr(setting.step)} | ({"tolerance": "1e-06"} if ports.states else {})
    model = element("Model", sha256=source.model_hash)
    tools, annotations = (
        element("VendorAnnotations", element("Tool", model, name="bristle")),
        element("Annotation", model, type="bristle"),
    )
    inside = [*_kinds(setting, exchanged=bool(ports.states)), _units(content)]
    inside += [
        element(
            "LogCategories",
            element("Category", name="logStatusError", description="reason of a refused call"),
        )
    ]
    inside += [element("DefaultExperiment", startTime="0", **common)]
    inside += [tools] if fmi == 2 and source.model_hash else []
    inside += [
        element(
            "ModelVariables",
            *(_variable(i, port, content, fmi) for i, port in enumerate(ports.listed)),
        )
    ]
    inside += [_structure(content, fmi)]
    inside += [element("Annotations", annotations)] if fmi == 3 and source.model_hash else []
    return _xml(element("fmiModelDescription", *inside, **facts))


def _xml(root: Element) -> str:
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _kinds(setting: Setting, *, exchanged: bool) -> list[Element]:
    """Return the capabilities of each kind of FMU."""
    second, state = setting.fmi == 2, "state" if setting.fmi == 2 else "State"
    able = {f"canGetAndSetFMU{state}": "true", f"canSerializeFMU{state}": "true"}
    able |= {"canNotUseMemoryManagementFunctions": "true"} if second else {}
    source = [element("SourceFiles", element("File", name=f"{setting.name}.c"))] if second else []
    without = (
        {"completedIntegratorStepNotNeeded": "true"}
        if second
        else {"needsCompletedIntegratorStep": "false"}
    )
    derived = {"providesDirectionalDerivative": "true"} if second else {}
    derived |= (
        {}
        if second
        else {"providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true"}
    )
    kinds = {"ModelExchange": without | able | derived} if exchanged else {}
    fixed = {} if second else {"fixedInternalStepSize": repr(setting.step)}
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
    units = (
        element("Unit", *([element("BaseUnit", **powers)] if powers else []), name=unit)
        for unit, powers in written.items()
    )
    return element("UnitDefinitions", *units)


def _variable(reference: int, port: Port, content: Content, fmi: int) -> Element:
    """Return a variable; for states of an importer also the nominal value, for rates the state."""
    role, unit = ROLES[port.role], port.variable.unit(content.kind)
    states, rates = content.ports.states, content.ports.in_role(RATE)
    head = {"name": port.name, "valueReference": str(reference)}
    head["description"] = port.variable.description + (f" ({port.sure})" if port.sure else "")
    head |= {"causality": role.causality, "variability": role.variability}
    number = {} if unit == "1" else {"unit": unit}
    bounds = (
        {}
        if port.role == TIME
        else {"min": float(port.variable.min), "max": float(port.variable.max)}
    )
    number |= {name: repr(bound) for name, bound in bounds.items() if math.isfinite(bound)}
    if port.role != TIME and role.initial != "calculated":
        number["start"] = (
            ("INF" if port.value > 0 else "-INF") if math.isinf(port.value) else repr(port.value)
        )
    if reference in states:
        number["nominal"] = repr(port.variable.nominal)
    elif reference in rates:
        number["derivative"] = str(states[rates.index(reference)] + (1 if fmi == 2 else 0))
    head |= {"initial": role.initial} if role.initial else {}
    return (
        element("ScalarVariable", element("Real", **number), **head)
        if fmi == 2
        else element("Float64", **head, **number)
    )


def _structure(content: Content, fmi: int) -> Element:
    ports, structure = content.ports, element("ModelStructure")
    rates = ports.in_role(RATE)
    known = (*ports.in_role(INPUT), *ports.states) if ports.states else ()
    # Force and rates depend on the states; with a mass, the force does not depend directly on the effort.
    on_force = ports.states if ports.states and ports.in_role(START) else known
    outputs = {i: (i,) if i in ports.states else on_force for i in ports.in_role(START, OUTPUT)}
    first = dict.fromkeys((*ports.in_role(OUTPUT, STATE), *rates), None if ports.states else ())
    lists: dict[str, Mapping[int, tuple[int, ...] | None]] = {
        "Output": outputs,
        "ContinuousStateDerivative": dict.fromkeys(rates, known),
        "InitialUnknown": first,
        "EventIndicator": dict.fromkeys(ports.in_role(MARGIN), known),
    }
    # In FMI 2.0 indices count from 1, and are not value references.
    by, counted_from = ("index", 1) if fmi == 2 else ("valueReference", 0)
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
            on = (
                {}
                if depends is None
                else {
                    "dependencies": " ".join(str(place + counted_from) for place in sorted(depends))
                }
            )
            rows.append(
                element("Unknown" if fmi == 2 else name, **{by: str(unknown + counted_from)}, **on)
            )
        structure.extend([element(heads[name], *rows)] if fmi == 2 else rows)
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
    return {symbol: int(power) for symbol, power in total.items() if power} if is_integral else {}

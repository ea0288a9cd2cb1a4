"""modelDescription.xml of an FMU, as FMI 2.0 and FMI 3.0 have it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from bristle.core.dimensions import Kind, exponents_of
from bristle.exports.described import Source
from bristle.exports.fmu_variables import CONSTANT, INPUT, MARGIN, OUTPUT, PARAMETER, RATE, START, STATE, TIME, Port, Ports
from bristle.exports.identity import LICENCE, copyright_line, model_version
from bristle.exports.rendering import version

__all__ = ["Description", "build_text"]

# What the quantities that are short for no other are made of, in SI base units.
BASE: dict[Kind, dict[str, dict[str, int]]] = {
    "translational": {"force": {"kg": 1, "m": 1, "s": -2}, "length": {"m": 1}},
    "rotational": {"force": {"kg": 1, "m": 2, "s": -2}, "length": {"rad": 1}},
}
EVERYWHERE = {"force of travel": {"kg": 1, "m": 1, "s": -2}, "travel": {"m": 1}, "time": {"s": 1}, "temperature": {"K": 1}}
CAUSALITY = {
    TIME: "independent",
    INPUT: "input",
    OUTPUT: "output",
    START: "output",
    PARAMETER: "parameter",
    CONSTANT: "local",
    STATE: "local",
    RATE: "local",
    MARGIN: "local",
}
COMPUTED = (OUTPUT, STATE, RATE, MARGIN)
VARIABILITY = {PARAMETER: "tunable", CONSTANT: "constant"}
INITIAL = {START: "exact", PARAMETER: "exact", CONSTANT: "exact"} | dict.fromkeys(COMPUTED, "calculated")
TOLERANCE = "1e-06"
FLAGS = "-std=c99 -ffp-contract=off"


@dataclass(frozen=True)
class Description:
    """What an FMU says of itself."""

    name: str
    title: str
    kind: Kind
    ports: Ports
    step: float
    token: str
    source: Source

    def text(self, fmi: int) -> str:
        """Return the file."""
        root = Element("fmiModelDescription", fmiVersion=f"{fmi}.0", modelName=self.name)
        root.set("guid" if fmi == 2 else "instantiationToken", self.token)
        root.set("description", self.title)
        root.set("version", model_version(self.source))
        root.set("author", self._author())
        root.set("copyright", copyright_line())
        root.set("license", f"{LICENCE} for the text that bristle wrote; the model and its numbers are yours")
        root.set("generationTool", f"bristle {version()}")
        root.set("variableNamingConvention", "structured")
        if self.ports.states:
            self._model_exchange(root, fmi)
        self._co_simulation(root, fmi)
        self._units(root)
        category = SubElement(SubElement(root, "LogCategories"), "Category", name="logStatusError")
        category.set("description", "why something was refused")
        experiment = SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(self.step))
        if self.ports.states:
            experiment.set("tolerance", TOLERANCE)
        if fmi == 2 and self.source.model_hash:
            tool = SubElement(SubElement(root, "VendorAnnotations"), "Tool", name="bristle")
            SubElement(tool, "Model", sha256=self.source.model_hash)
        if fmi == 2 and self.ports.states:
            root.set("numberOfEventIndicators", str(len(self.ports.margins)))
        variables = SubElement(root, "ModelVariables")
        for reference, port in enumerate(self.ports.listed):
            (self._scalar if fmi == 2 else self._float)(variables, reference, port)
        self._structure(root, fmi)
        if fmi == 3 and self.source.model_hash:
            annotation = SubElement(SubElement(root, "Annotations"), "Annotation", type="bristle")
            SubElement(annotation, "Model", sha256=self.source.model_hash)
        ElementTree.indent(root)
        return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"

    def _author(self) -> str:
        """Return what wrote the model, and from which file where it was one."""
        provenance = self.source.provenance
        file = provenance.get("model") or provenance.get("experiment")
        return f"bristle {version()}" + (f", from {file}" if file else "")

    def _model_exchange(self, root: Element, fmi: int) -> None:
        element = SubElement(root, "ModelExchange", modelIdentifier=self.name)
        element.set(*(("completedIntegratorStepNotNeeded", "true") if fmi == 2 else ("needsCompletedIntegratorStep", "false")))
        self._able(element, fmi)

    def _co_simulation(self, root: Element, fmi: int) -> None:
        element = SubElement(root, "CoSimulation", modelIdentifier=self.name)
        element.set("canHandleVariableCommunicationStepSize", "true")
        self._able(element, fmi)
        if fmi == 3:
            element.set("fixedInternalStepSize", repr(self.step))

    def _able(self, element: Element, fmi: int) -> None:
        """Tell what both kinds of an FMU can do."""
        state = "state" if fmi == 2 else "State"
        element.set(f"canGetAndSetFMU{state}", "true")
        element.set(f"canSerializeFMU{state}", "true")
        if fmi == 2:
            element.set("canNotUseMemoryManagementFunctions", "true")
            SubElement(SubElement(element, "SourceFiles"), "File", name=f"{self.name}.c")

    def _units(self, root: Element) -> None:
        quantities = {port.variable.unit(self.kind): port.variable.quantity for port in self.ports.listed}
        units = SubElement(root, "UnitDefinitions")
        for unit, quantity in quantities.items():
            if unit != "1":
                element = SubElement(units, "Unit", name=unit)
                base = _base(quantity, self.kind)
                if base:
                    SubElement(element, "BaseUnit", {symbol: str(power) for symbol, power in base.items()})

    def _common(self, port: Port) -> tuple[dict[str, str], dict[str, str]]:
        """Return attributes of the variable, and those of its number."""
        text = port.variable.description + (f" ({port.sure})" if port.sure else "")
        variable = {"description": text, "causality": CAUSALITY[port.role]}
        variable["variability"] = VARIABILITY.get(port.role, "continuous")
        number = {} if port.variable.unit(self.kind) == "1" else {"unit": port.variable.unit(self.kind)}
        if port.role != TIME and math.isfinite(port.variable.min):
            number["min"] = repr(float(port.variable.min))
        if port.role != TIME and math.isfinite(port.variable.max):
            number["max"] = repr(float(port.variable.max))
        if port.role not in (TIME, *COMPUTED):
            number["start"] = _number(port.value)
        return variable, number

    def _of_states(self, reference: int, counted_from: int) -> dict[str, str]:
        """Return what a variable says of what an importer integrates: the size of a state, whose rate one is."""
        states, rates = self.ports.states, self.ports.rates
        if reference in states:
            return {"nominal": repr(self.ports.listed[reference].variable.nominal)}
        return {"derivative": str(states[rates.index(reference)] + counted_from)} if reference in rates else {}

    def _scalar(self, variables: Element, reference: int, port: Port) -> None:
        variable, number = self._common(port)
        number |= self._of_states(reference, 1)
        if port.role in INITIAL:
            variable["initial"] = INITIAL[port.role]
        head = {"name": port.name, "valueReference": str(reference)}
        SubElement(SubElement(variables, "ScalarVariable", head | variable), "Real", number)

    def _float(self, variables: Element, reference: int, port: Port) -> None:
        variable, number = self._common(port)
        if port.role in INITIAL:
            variable["initial"] = INITIAL[port.role]
        head = {"name": port.name, "valueReference": str(reference)}
        SubElement(variables, "Float64", head | variable | number | self._of_states(reference, 0))

    def _structure(self, root: Element, fmi: int) -> None:
        structure = SubElement(root, "ModelStructure")
        states, rates = self.ports.states, self.ports.rates
        inputs = self._in_role(INPUT)
        known = (*inputs, *states) if states else ()
        # Force and rates follow from what varies; a mass stands between an effort and the force.
        on_force = states if states and self._in_role(START) else known
        outputs = {i: (i,) if i in states else on_force for i in self._in_role(START, OUTPUT)}
        outputs = {i: outputs[i] for i in sorted(outputs)}
        of_rates = dict.fromkeys(rates, known)
        first = dict.fromkeys((*self._in_role(OUTPUT, STATE), *rates), None if states else ())
        if fmi == 2:
            self._listed(SubElement(structure, "Outputs"), "Unknown", outputs, "index", 1)
            if states:
                self._listed(SubElement(structure, "Derivatives"), "Unknown", of_rates, "index", 1)
            self._listed(SubElement(structure, "InitialUnknowns"), "Unknown", first, "index", 1)
            return
        self._listed(structure, "Output", outputs)
        self._listed(structure, "ContinuousStateDerivative", of_rates)
        self._listed(structure, "InitialUnknown", first)
        self._listed(structure, "EventIndicator", dict.fromkeys(self.ports.margins, known))

    def _in_role(self, *roles: int) -> tuple[int, ...]:
        return tuple(i for i, port in enumerate(self.ports.listed) if port.role in roles)

    def _listed(
        self, parent: Element, name: str, unknowns: Mapping[int, tuple[int, ...] | None], by: str = "valueReference", counted_from: int = 0
    ) -> None:
        """List unknowns with what they depend on; in FMI 2.0 places count from 1, and are no value references."""
        for unknown in sorted(unknowns):
            element = SubElement(parent, name, {by: str(unknown + counted_from)})
            depends = unknowns[unknown]
            if depends is not None:
                element.set("dependencies", " ".join(str(place + counted_from) for place in sorted(depends)))


def build_text(name: str) -> str:
    """Return buildDescription.xml of FMI 3.0, which tells how the source becomes a library."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=name)
    files = SubElement(configuration, "SourceFileSet", language="C99", compilerOptions=FLAGS)
    SubElement(files, "SourceFile", name=f"{name}.c")
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _number(value: float) -> str:
    return ("INF" if value > 0 else "-INF") if math.isinf(value) else repr(value)


def _base(quantity: str, kind: Kind) -> dict[str, int]:
    """Return the powers of base units that a quantity has; none where one is not whole."""
    total: dict[str, float] = {}
    for name, power in exponents_of(quantity).items():
        for symbol, inner in (BASE[kind] | EVERYWHERE)[name].items():
            total[symbol] = total.get(symbol, 0.0) + power * inner
    if any(power != int(power) for power in total.values()):
        return {}
    return {symbol: int(power) for symbol, power in total.items() if power}

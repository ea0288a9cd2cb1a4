"""modelDescription.xml of an FMU, as FMI 2.0 and FMI 3.0 have it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from bristle.core.dimensions import Kind, exponents_of
from bristle.exports.fmu_variables import CONSTANT, INPUT, OUTPUT, PARAMETER, START, TIME, Port, Ports
from bristle.exports.rendering import version

__all__ = ["Description", "build_text"]

# What the quantities that are short for no other are made of, in SI base units.
BASE: dict[Kind, dict[str, dict[str, int]]] = {
    "translational": {"force": {"kg": 1, "m": 1, "s": -2}, "length": {"m": 1}},
    "rotational": {"force": {"kg": 1, "m": 2, "s": -2}, "length": {"rad": 1}},
}
EVERYWHERE = {
    "force of travel": {"kg": 1, "m": 1, "s": -2}, "travel": {"m": 1}, "time": {"s": 1}, "temperature": {"K": 1},
}  # fmt: skip
CAUSALITY = {TIME: "independent", INPUT: "input", OUTPUT: "output", START: "output", PARAMETER: "parameter",
             CONSTANT: "local"}  # fmt: skip
VARIABILITY = {PARAMETER: "tunable", CONSTANT: "constant"}
INITIAL = {OUTPUT: "calculated", START: "exact", PARAMETER: "exact", CONSTANT: "exact"}
FLAGS = "-std=c99 -ffp-contract=off"


@dataclass(frozen=True)
class Description:
    """What an FMU says of itself.

    Parameters
    ----------
    name : str
        Its name, and that of its library.
    title : str
        What it is.
    kind : {"translational", "rotational"}
        Kind of axis.
    ports : Ports
        Its variables.
    step : float
        Internal step [s].
    token : str
        What tells it from others.
    """

    name: str
    title: str
    kind: Kind
    ports: Ports
    step: float
    token: str

    def text(self, fmi: int) -> str:
        """Return the file."""
        root = Element("fmiModelDescription", fmiVersion=f"{fmi}.0", modelName=self.name)
        root.set("guid" if fmi == 2 else "instantiationToken", self.token)
        root.set("description", self.title)
        root.set("generationTool", f"bristle {version()}")
        root.set("variableNamingConvention", "structured")
        self._co_simulation(root, fmi)
        self._units(root)
        category = SubElement(SubElement(root, "LogCategories"), "Category", name="logStatusError")
        category.set("description", "why something was refused")
        SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(self.step))
        variables = SubElement(root, "ModelVariables")
        for reference, port in enumerate(self.ports.listed):
            (self._scalar if fmi == 2 else self._float)(variables, reference, port)
        self._structure(root, fmi)
        ElementTree.indent(root)
        return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"

    def _co_simulation(self, root: Element, fmi: int) -> None:
        state = "state" if fmi == 2 else "State"
        element = SubElement(root, "CoSimulation", modelIdentifier=self.name)
        element.set("canHandleVariableCommunicationStepSize", "true")
        element.set(f"canGetAndSetFMU{state}", "true")
        element.set(f"canSerializeFMU{state}", "true")
        if fmi == 2:
            element.set("canNotUseMemoryManagementFunctions", "true")
            SubElement(SubElement(element, "SourceFiles"), "File", name=f"{self.name}.c")
        else:
            element.set("fixedInternalStepSize", repr(self.step))

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
        if port.role not in (TIME, OUTPUT):
            number["start"] = _number(port.value)
        return variable, number

    def _scalar(self, variables: Element, reference: int, port: Port) -> None:
        variable, number = self._common(port)
        if port.role in INITIAL:
            variable["initial"] = INITIAL[port.role]
        head = {"name": port.name, "valueReference": str(reference)}
        SubElement(SubElement(variables, "ScalarVariable", head | variable), "Real", number)

    def _float(self, variables: Element, reference: int, port: Port) -> None:
        variable, number = self._common(port)
        if port.role in INITIAL:
            variable["initial"] = INITIAL[port.role]
        head = {"name": port.name, "valueReference": str(reference)}
        SubElement(variables, "Float64", head | variable | number)

    def _structure(self, root: Element, fmi: int) -> None:
        structure = SubElement(root, "ModelStructure")
        listed = list(enumerate(self.ports.listed))
        outputs = [reference for reference, port in listed if port.role in (OUTPUT, START)]
        unknown = [reference for reference, port in listed if port.role == OUTPUT]
        if fmi == 2:  # places count from 1, and are no value references
            inside = SubElement(structure, "Outputs")
            for reference in outputs:
                SubElement(inside, "Unknown", index=str(reference + 1), dependencies="")
            inside = SubElement(structure, "InitialUnknowns")
            for reference in unknown:
                SubElement(inside, "Unknown", index=str(reference + 1), dependencies="")
            return
        for reference in outputs:
            SubElement(structure, "Output", valueReference=str(reference), dependencies="")
        for reference in unknown:
            SubElement(structure, "InitialUnknown", valueReference=str(reference), dependencies="")


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

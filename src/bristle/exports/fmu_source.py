"""The source of an FMU: one file with the functions of the tree, and around them what FMI calls.

What FMI has and an FMU here has not answers with an error; these functions are listed by the headers of the standard,
so that there is no list to keep.
"""

from __future__ import annotations

import hashlib
import re
import uuid
from collections.abc import Mapping
from importlib import resources

import numpy as np

from bristle.exports.c import FLAGS
from bristle.exports.c_code import Printer, number
from bristle.exports.c_parts import array_text, assembled, constant_text, declared, helpers_text
from bristle.exports.described import plain, rendered, version, with_rights
from bristle.exports.fmu_content import MARGIN, RATE, START, Content, Ports, Setting
from bristle.exports.fmu_exchange import Exchange
from bristle.exports.subject import digest_of
from bristle.exports.tree import Array, Function

HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
DECLARED = re.compile(r"typedef\s+(\w+)\s+(fmi[23]\w+)TYPE\s*\(([^;]*)\);")


def source_text(content: Content, setting: Setting) -> tuple[str, str]:
    """Return the source, and the token that tells it from every other one."""
    facts = _facts(content, setting)
    token = str(uuid.UUID(hashlib.sha256(rendered("fmu/source.c", facts | {"token": ""}).encode()).hexdigest()[:32]))
    token, file = f"{{{token}}}", f"{setting.name}.c"
    return with_rights({file: rendered("fmu/source.c", facts | {"token": token})}, setting.source)[file], token


def _facts(content: Content, setting: Setting) -> dict[str, object]:
    exchange, ports = content.exchange, content.ports
    printer = Printer(content.unit, "double", [kind for _, kind in content.values.values()])
    definitions = printer.definitions()
    data, handed = _data(content, printer)
    listed, size = ports.listed, content.memory.size
    layout = f"{setting.name} {content.layout} {[port.name for port in listed]}"
    starts = [i for i, port in enumerate(listed) if port.role == START]
    meanings = [plain(f"{port.name} [{port.variable.unit(content.kind)}]: {port.variable.description}") for port in listed]
    return {
        "title": plain(content.title),
        "version": version(),
        "facts": [*setting.source.lines, *content.tables],
        "flags": FLAGS,
        "fmi": setting.fmi,
        "helpers": helpers_text(printer.helpers, "double", printer.integer),
        "definitions": definitions,
        "data": data,
        "step": number(setting.step),
        "ports": [{"start": number(port.value), "told": text} for port, text in zip(listed, meanings, strict=True)],
        "roles": [port.role for port in listed],
        "lowest": [number(port.range[0]) for port in listed],
        "highest": [number(port.range[1]) for port in listed],
        "memory": size,
        "begin": [number(value) for value in content.begin] or ["0.0"],
        "remembered": "remembered[i]" if np.any(content.memory) else "0.0",
        "most": [number(float(most)) for most in content.most] or ["0.0"],
        "layout": f"0x{digest_of(layout.encode()):016X}",
        "plant": content.failures_at >= 0,
        "failures_at": content.failures_at,
        "first_start": starts[0] if starts else 0,
        "output": content.output,
        "output_at": ports.place(content.output),
        "shown": [(at, place) for place, at in enumerate(starts)],
        "stepping": _called(content.entry, ports, handed),
        "absent": _absent(setting.fmi, exchange is not None),
        "exchange": None if exchange is None else _exchanged(exchange, ports, handed),
    }


def _exchanged(exchange: Exchange, ports: Ports, handed: Mapping[str, str]) -> dict[str, object]:
    """Return what the source says of model exchange."""
    return {
        "states": ports.states,
        "rates": ports.in_role(RATE),
        "margins": ports.in_role(MARGIN),
        "held": exchange.held,
        "nominals": [number(variable.nominal) for variable in exchange.varying.values()],
        "most": [number(float(most)) for most in exchange.held or (0,)],
        **{name: _called(getattr(exchange, name), ports, handed) for name in ("flowing", "begun", "arrived")},
    }


def _data(content: Content, printer: Printer) -> tuple[str, dict[str, str]]:
    """Return the parameters in C, and how each argument for them is handed on."""
    texts, handed = [], {}
    exchange = content.exchange
    entries = [content.entry, *(() if exchange is None else exchange.functions)]
    needed = {parameter.name for entry in entries for parameter in entry.parameters}
    for argument, (values, kind) in content.values.items():
        if argument not in needed:
            continue
        if argument in content.ports.tuned:
            tuned, _ = content.ports.tuned[argument]
            fields = [f"    {line}" for line in declared(tuned, printer)]
            texts += ["typedef struct {", *fields, f"}} {argument}_parameters;", ""]
            texts.append(assembled(values, tuned, printer, kind, f"{argument}_parameters", f"made_{argument}"))
            handed[argument] = f"made_{argument}(&given_{argument})"
        else:
            handed[argument] = f"constant_{argument}"
            texts.append(constant_text(handed[argument], values, kind, printer, argument))
    if content.failures_at >= 0:
        texts.append("static inline double magnitude_of(double x)\n{\n    return x < 0.0 ? -x : x;\n}\n")
    if np.any(content.memory):
        texts.append(array_text("remembered", content.memory, printer) + "\n")
    return "\n".join(texts), handed


def _called(entry: Function, ports: Ports, handed: Mapping[str, str]) -> list[str]:
    """Return the lines that call a kernel; the last one is the call."""
    lines, arguments = [], []
    for argument, (_, first) in ports.tuned.items():
        if argument in [parameter.name for parameter in entry.parameters]:
            lines.append(f"{argument}_parameters given_{argument};")
            lines.append(f"memcpy(&given_{argument}, now->values + {first}, sizeof given_{argument});")
    for parameter in entry.parameters:
        name = parameter.name
        if name in ("lasting", "memory", "varying", "held"):
            arguments.append(f"now->{name}")
        elif name in ("slope", "dt"):
            arguments.append("STEP" if name == "dt" else name)
        elif name in handed:
            arguments.append(handed[name])
        elif isinstance(parameter.type, Array):  # where the first variable of several is
            arguments.append(f"now->values + {ports.place(f'{name}[1]')}")
        else:
            arguments.append(f"now->values[{ports.place(name)}]")
    return [*lines, f"{entry.name}({', '.join(arguments)});"]


def _absent(fmi: int, exchange: bool) -> str:
    """Return the functions of the standard that the templates have not, each with an error for an answer."""
    template = _text(f"fmi{fmi}.c") + (_text(f"exchange{fmi}.c") if exchange else "")
    texts = []
    for kind, name, arguments in DECLARED.findall(header_text(f"fmi{fmi}FunctionTypes.h")):
        if re.search(rf"\b{name}\(", template):
            continue
        words = [re.sub(r"\[.*?\]", "", argument).split()[-1].lstrip("*") for argument in arguments.split(",")]
        unused = "".join(f"    (void){word};\n" for word in words)
        result = f"fmi{fmi}Error" if kind.endswith("Status") else "NULL"
        texts.append(f"{kind} {name}({' '.join(arguments.split())})\n{{\n{unused}    return {result};\n}}\n")
    return "\n".join(texts)


def header_text(name: str) -> str:
    """Return a header of the standard, or the licence of them."""
    return _text(f"headers/{name}")


def _text(name: str) -> str:
    return (resources.files("bristle.exports") / "templates" / "fmu" / name).read_text(encoding="utf-8")

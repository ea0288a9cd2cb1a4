"""FMUs: native co-simulation with a fixed internal step, and model exchange, of friction alone and with its plant.

An FMU is an archive: a description, the source and its headers, and a library for each platform. The source is one
file: the functions of the tree, and around them what FMI calls. What FMI has and an FMU here has not answers with an
error; these functions are listed by the headers of the standard, so that there is no list to keep.
"""

from __future__ import annotations

import hashlib
import io
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib import resources

from bristle.core.contracts import Model
from bristle.core.dimensions import Kind
from bristle.exports.build import Builder
from bristle.exports.c_code import Printer, number, wrapped
from bristle.exports.c_helpers import helpers_text
from bristle.exports.c_parameters import assembled, declared, initial_value
from bristle.exports.described import Source, parameter_table, plain
from bristle.exports.fmu_build import Library, libraries
from bristle.exports.fmu_core import Core, core_of
from bristle.exports.fmu_description import FLAGS, Description, build_text
from bristle.exports.fmu_exchange import Exchange, exchange_of, why_not
from bristle.exports.fmu_variables import START, Ports, ports_of
from bristle.exports.prune import pruned
from bristle.exports.rendering import rendered, version
from bristle.exports.subject import Subject, subject_of
from bristle.exports.tree import Function
from bristle.exports.walk import digest_of
from bristle.friction.resting import rest_rule

__all__ = ["Setting", "fmu_files"]

HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
LICENCE = "LICENSE.txt"
DECLARED = re.compile(r"typedef\s+(\w+)\s+(fmi[23]\w+)TYPE\s*\(([^;]*)\);")
WRITTEN = (1980, 1, 1, 0, 0, 0)  # the same files give the same archive


@dataclass(frozen=True)
class Setting:
    """How an FMU is written.

    Parameters
    ----------
    name : str
        What the FMU is called; the one with a plant has ``_mass`` behind it.
    source : Source
        Where the values come from.
    step : float
        Internal step [s].
    fmi : {2, 3}
        Version of FMI.
    """

    name: str
    source: Source
    step: float
    fmi: int


def fmu_files(
    friction: Model, alone: Model, plant: Model | None, setting: Setting
) -> tuple[dict[str, str | bytes], tuple[str, ...]]:  # fmt: skip
    """Return the FMUs of a friction model, and what is to be said of them.

    Parameters
    ----------
    friction, alone : Model
        The friction model, and the same as it is evaluated along samples, for the FMU without a plant.
    plant : Model or None
        What it is on: another FMU is written of both.
    setting : Setting
        How they are written.
    """
    written: dict[str, str | bytes] = {}
    notes = [f"the internal step is {setting.step:g} s: the bits are those of bristle at this step"]
    if rest_rule(alone):
        notes.append(f"a mass outside {setting.name}.fmu creeps at rest: a model without memory cannot hold it there. "
                     f"Use {setting.name}_mass.fmu, or a model with memory")  # fmt: skip
    bodies: list[tuple[str, Model | None]] = [(setting.name, None)]
    if plant is None:
        notes.append("no mass is known: there is no FMU with a mass")
    elif plant.component.screw is not None:
        notes.append(f"{plant.name} has a screw: there is no FMU with a mass")
    else:
        bodies.append((f"{setting.name}_mass", plant))
    for name, body in bodies:
        subject = subject_of(alone if body is None else friction)
        archive, remarks = _archive(*_cores(subject, body), replace(setting, name=name))
        written[f"{name}.fmu"] = archive
        notes += [text for text in remarks if text not in notes]
    return written, tuple(notes)


def _cores(subject: Subject, plant: Model | None) -> tuple[Core, Exchange | None]:
    """Return what an FMU steps, and, where it has equations in continuous time, what an importer integrates."""
    if why_not(subject.model, plant):
        return core_of(subject, plant), None
    builder = Builder()
    core = core_of(subject, plant, builder)
    exchange = exchange_of(core, builder)
    unit = pruned(builder.unit, [core.entry, exchange.flowing, exchange.begun, exchange.arrived])
    return replace(core, unit=unit), exchange


def _archive(core: Core, exchange: Exchange | None, setting: Setting) -> tuple[bytes, tuple[str, ...]]:
    name, fmi = setting.name, setting.fmi
    ports = ports_of(core, setting.source, exchange)
    facts = _facts(core, exchange, ports, setting)
    token = hashlib.sha256(rendered("fmu/source.c", facts | {"token": ""}).encode()).hexdigest()[:32]
    token = f"{{{token[:8]}-{token[8:12]}-{token[12:16]}-{token[16:20]}-{token[20:]}}}"
    headers = {header: _header(header) for header in HEADERS[fmi]}
    sources = {f"{name}.c": rendered("fmu/source.c", facts | {"token": token})} | headers
    described = Description(name, _title(core), _axis(core.subject.model.kind), ports, setting.step, token)
    built = libraries(name, sources, fmi)
    inside: dict[str, str | bytes] = {"modelDescription.xml": described.text(fmi)}
    inside |= {f"sources/{file}": text for file, text in sources.items()}
    inside[f"sources/{LICENCE}"] = _header(LICENCE)
    if fmi == 3:
        inside["sources/buildDescription.xml"] = build_text(name)
    inside |= {library.place: library.content for library in built if not library.problem}
    reason = why_not(core.subject.model, core.plant)
    alone = (f"co-simulation alone: {reason}",) if reason else ()
    return _zipped(inside), (*alone, *ports.fixed, *_remarks(built))


def _axis(kind: str) -> Kind:
    return "rotational" if kind == "rotational" else "translational"


def _remarks(built: list[Library]) -> list[str]:
    """Return which platforms there are libraries for."""
    platforms = [library.place.split("/")[1] for library in built if not library.problem]
    notes = [f"no library for {library.place.split('/')[1]}: {library.problem}" for library in built if library.problem]
    if not platforms:
        return [*notes, f"no C compiler was found: the FMU holds its source only; build it with {FLAGS}"]
    return [*notes, f"libraries for {', '.join(platforms)}"]


def _title(core: Core) -> str:
    model = core.subject.model
    if core.plant is None:
        return f"Friction {model.name}: force [{_unit(model)}] of a velocity and a position"
    return f"{core.plant.name} with friction {model.name}: motion under an effort [{_unit(model)}]"


def _unit(model: Model) -> str:
    return "N*m" if model.kind == "rotational" else "N"


def _facts(core: Core, exchange: Exchange | None, ports: Ports, setting: Setting) -> dict[str, object]:
    printer = Printer(core.unit, "double", [kind for _, kind in core.parameters.values()])
    definitions = printer.definitions()
    data, handed = _data(core, exchange, ports, printer)
    helpers = helpers_text(printer.helpers, "double", printer.integer)
    listed, kind = ports.listed, core.subject.model.kind
    layout = f"{setting.name} {core.subject.state.fields} {[port.name for port in listed]} {core.subject.memory_size}"
    starts = [i for i, port in enumerate(listed) if port.role == START]
    meanings = [plain(f"{port.name} [{port.variable.unit(kind)}]: {port.variable.description}") for port in listed]
    table = parameter_table(core.subject.model, setting.source).splitlines()
    return {
        "title": plain(_title(core)), "version": version(), "facts": [*setting.source.lines, *table], "flags": FLAGS,
        "fmi": setting.fmi, "helpers": helpers, "definitions": definitions, "data": data, "step": number(setting.step),
        "ports": [{"start": number(port.value), "told": text} for port, text in zip(listed, meanings, strict=True)],
        "roles": [port.role for port in listed], "lowest": [number(port.range[0]) for port in listed],
        "highest": [number(port.range[1]) for port in listed], "memory": core.subject.memory_size,
        "begin": [number(value) for value in core.begin] or ["0.0"],
        "most": [number(float(most)) for most in core.most] or ["0.0"],
        "layout": f"0x{digest_of(layout.encode()):016X}", "plant": core.plant is not None,
        "failures_at": core.failures_at, "first_start": starts[0] if starts else 0,
        "force_at": ports.place("force"), "shown": [(at, place) for place, at in enumerate(starts)],
        "stepping": _called(core.entry, ports, handed), "absent": _absent(setting.fmi, exchange is not None),
        "exchange": None if exchange is None else _exchanged(exchange, ports, handed),
    }  # fmt: skip


def _exchanged(exchange: Exchange, ports: Ports, handed: Mapping[str, str]) -> dict[str, object]:
    """Return what the source says of model exchange."""
    return {
        "states": ports.states, "rates": ports.rates, "margins": ports.margins, "held": exchange.held,
        "nominals": [number(variable.nominal) for variable in exchange.varying.values()],
        "most": [number(float(most)) for most in exchange.held or (0,)],
        **{name: _called(getattr(exchange, name), ports, handed) for name in ("flowing", "begun", "arrived")},
    }  # fmt: skip


def _data(
    core: Core, exchange: Exchange | None, ports: Ports, printer: Printer
) -> tuple[str, dict[str, str]]:  # fmt: skip
    """Return the parameters in C, and how each argument for them is handed on."""
    texts, handed = [], {}
    entries = [core.entry] + ([] if exchange is None else [exchange.flowing, exchange.begun, exchange.arrived])
    needed = {parameter.name for entry in entries for parameter in entry.parameters}
    for argument, (model, kind) in core.parameters.items():
        if argument not in needed:
            continue
        if argument in ports.tuned:
            tuned, _ = ports.tuned[argument]
            fields = [f"    {line}" for line in declared(tuned, printer)]
            texts += ["typedef struct {", *fields, f"}} {argument}_parameters;", ""]
            texts.append(assembled(tuned, printer, kind, f"{argument}_parameters", f"made_{argument}"))
            handed[argument] = f"made_{argument}(&given_{argument})"
        else:
            arrays: list[str] = []
            text = initial_value(model.parameters, kind, printer, arrays, f"{argument}_")
            constant = f"static const {printer.named(kind, f'fixed_{argument}')} = {text};"
            texts += [*arrays, *wrapped(constant, ""), ""]
            handed[argument] = f"fixed_{argument}"
    if core.plant is not None:
        texts.append("static inline double magnitude_of(double x)\n{\n    return x < 0.0 ? -x : x;\n}\n")
    return "\n".join(texts), handed


# What kernels work on, as functions of the source have it.
ARRAYS = {
    "lasting": "now->lasting", "memory": "now->memory", "varying": "now->varying", "held": "now->held",
    "slope": "slope", "dt": "STEP",
}  # fmt: skip


def _called(entry: Function, ports: Ports, handed: Mapping[str, str]) -> list[str]:
    """Return the lines that call a kernel; the last one is the call."""
    names = [parameter.name for parameter in entry.parameters]
    lines = []
    for argument, (_, first) in ports.tuned.items():
        if argument in names:
            lines.append(f"{argument}_parameters given_{argument};")
            lines.append(f"memcpy(&given_{argument}, now->values + {first}, sizeof given_{argument});")
    known = ARRAYS | dict(handed)
    arguments = [known[name] if name in known else f"now->values[{ports.place(name)}]" for name in names]
    return [*lines, f"{entry.name}({', '.join(arguments)});"]


def _absent(fmi: int, exchange: bool) -> str:
    """Return the functions of the standard that the templates have not, each with an error for an answer."""
    template = _text(f"fmi{fmi}.c") + (_text(f"exchange{fmi}.c") if exchange else "")
    texts = []
    for kind, name, arguments in DECLARED.findall(_header(f"fmi{fmi}FunctionTypes.h")):
        if re.search(rf"\b{name}\(", template):
            continue
        words = [re.sub(r"\[.*?\]", "", argument).split()[-1].lstrip("*") for argument in arguments.split(",")]
        unused = "".join(f"    (void){word};\n" for word in words)
        result = f"fmi{fmi}Error" if kind.endswith("Status") else "NULL"
        texts.append(f"{kind} {name}({' '.join(arguments.split())})\n{{\n{unused}    return {result};\n}}\n")
    return "\n".join(texts)


def _header(name: str) -> str:
    return _text(f"headers/{name}")


def _text(name: str) -> str:
    return (resources.files("bristle.exports") / "templates" / "fmu" / name).read_text(encoding="utf-8")


def _zipped(inside: Mapping[str, str | bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, content in inside.items():
            entry = zipfile.ZipInfo(place, WRITTEN)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if place.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content)
    return stream.getvalue()

"""FMUs of friction, its plant, or a control law: native co-simulation with a fixed internal step, and model exchange."""

import hashlib
import importlib.util
import io
import platform
import re
import subprocess
import sys
import tempfile
import uuid
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from bristle.apps.targets.fmu_content import (
    MARGIN,
    RATE,
    START,
    Content,
    Setting,
    content_of,
    content_of_law,
)
from bristle.apps.targets.fmu_description import build_text, description_text
from bristle.core import InputError, Model
from bristle.engine.screwed import through_screw
from bristle.engine.translation.tree import Array, Function
from bristle.exports.c import FLAGS, compiler
from bristle.exports.c_code import Printer, number
from bristle.exports.c_parts import array_text, assembled, constant_text, declared, helpers_text
from bristle.exports.described import (
    PACKAGES,
    Request,
    Source,
    hash_of_model,
    hash_on_plant,
    plain,
    rendered,
    text_of,
    version,
    with_rights,
)
from bristle.exports.law import Law
from bristle.exports.subject import digest_of, subject_of
from bristle.exports.targets import Product
from bristle.models.friction.resting import rest_rule

PATIENCE = 600.0  # [s]; zig builds the library of a platform once


# By system and machine: folder in FMI 2.0 (empty if it does not exist) and in 3.0; name for zig; suffix of the library.
PLATFORMS = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux", "x86_64-linux-gnu.2.17", ".so"),
    ("linux", "aarch64"): ("", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
    ("win32", "amd64"): ("win64", "x86_64-windows", "x86_64-windows-gnu", ".dll"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin", "x86_64-macos", ".dylib"),
    ("darwin", "arm64"): ("", "aarch64-darwin", "aarch64-macos", ".dylib"),
}


def zig() -> list[str]:
    """Return the command of the compiler for other platforms; empty if it is not installed."""
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    return []


def libraries(name: str, sources: Mapping[str, str], fmi: int) -> dict[str, bytes | str]:
    """Return the libraries by their paths in an FMU, each as bytes or as the reason why it cannot be built here."""
    local = (sys.platform, platform.machine().lower())
    own = compiler()
    across = zig()
    built = {}
    for machine, (*folders, triple, suffix) in PLATFORMS.items():
        folder = folders[fmi - 2]
        if not folder or not (across or (machine == local and own)):
            continue
        command = [*across, "-g0", "-target", triple]
        if machine[0] != "win32":
            command.append("-fPIC")
        if machine == local and own:
            command = [own, "-fPIC", "-fvisibility=hidden"]
        built[f"binaries/{folder}/{name}{suffix}"] = _library(command, name, sources, suffix)
    return built


def _library(command: list[str], name: str, sources: Mapping[str, str], suffix: str) -> bytes | str:
    with tempfile.TemporaryDirectory(prefix="bristle-fmu-") as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        output = Path(folder) / f"{name}{suffix}"
        line = [*command, "-O2", *FLAGS.split(), "-shared", f"{name}.c", "-o", output.name]
        if suffix != ".dll":
            line.append("-lm")
        try:
            ran = subprocess.run(
                line, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return type(error).__name__
        if ran.returncode or not output.is_file():
            return (ran.stderr.strip().splitlines() or ["no message"])[0]
        return output.read_bytes()


def write(request: Request, *, fmi: int) -> Product:
    """Return an FMU of the friction, and another FMU of friction and plant."""
    name = request.name
    plant = request.plant
    source = request.source
    notes = [
        f"the internal step is {request.dt:g} s; at this step, results are identical to those of bristle"
    ]
    if rest_rule(request.sampled):
        notes.append(
            f"a mass connected to {name}.fmu creeps at rest, because the model has no memory: use {name}_mass.fmu, or a model with memory"
        )
    bodies: list[tuple[str, Model, Model | None]] = [(name, request.sampled, None)]
    if plant is None:
        notes.append("the mass is unknown: no FMU with a mass was written")
    elif plant.component.screw is not None:
        try:
            bodies.append(
                (
                    f"{name}_mass",
                    through_screw(plant, request.model, request.table, exported=True),
                    plant,
                )
            )
        except InputError as error:
            notes.append(f"{error}: no FMU with a mass was written")
    else:
        bodies.append((f"{name}_mass", request.model, plant))
    written: dict[str, str | bytes] = {}
    for file, friction, body in bodies:
        content = content_of(subject_of(friction), body, source)
        model_hash = source.model_hash
        if body is not None and body.component.screw:
            model_hash = hash_of_model(friction)
        if model_hash and body is not None:
            model_hash = hash_on_plant(model_hash, body, content.unit)
        setting = Setting(file, replace(source, model_hash=model_hash), request.dt, fmi)
        written[f"{file}.fmu"], remarks = _archive(content, setting)
        notes += [text for text in remarks if text not in notes]
    return Product(written, tuple(notes))


def write_law(law: Law, name: str, source: Source, *, fmi: int) -> Product:
    """Return the FMU of a control law, whose internal step is its sample time."""
    archive, remarks = _archive(
        content_of_law(law, name, source), Setting(name, source, law.dt, fmi)
    )
    note = f"the internal step is the sample time of the law, {law.dt:g} s; at this step, results are identical to those of bristle"
    return Product({f"{name}.fmu": archive}, (note, *remarks))


def _archive(content: Content, setting: Setting) -> tuple[bytes, tuple[str, ...]]:
    """Return an archive and its notes, including those on platforms."""
    name = setting.name
    fmi = setting.fmi
    text, token = source_text(content, setting)
    sources = {f"{name}.c": text} | {header: header_text(header) for header in HEADERS[fmi]}
    built = libraries(name, sources, fmi)
    inside: dict[str, str | bytes] = {
        "modelDescription.xml": description_text(content, setting, token),
        "documentation/licenses/license.txt": text_of("shared/LICENSE.txt"),
    }
    inside |= {
        f"sources/{file}": text
        for file, text in (sources | {"LICENSE.txt": header_text("LICENSE.txt")}).items()
    }
    if fmi == 3:
        inside |= {"sources/buildDescription.xml": build_text(name)}
    inside |= {place: library for place, library in built.items() if isinstance(library, bytes)}
    platforms = [
        place.split("/")[1] for place, library in built.items() if isinstance(library, bytes)
    ]
    lacking = [
        f"no library for {place.split('/')[1]}: {library}"
        for place, library in built.items()
        if isinstance(library, str)
    ]
    remark = f"no C compiler was found: the FMU contains its source only; build it with {FLAGS}"
    if platforms:
        remark = f"libraries for {', '.join(platforms)}"
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, part in inside.items():
            entry = zipfile.ZipInfo(place)  # of 1980: the same files give the same archive
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            if place.startswith("binaries/"):
                entry.external_attr = 0o755 << 16
            archive.writestr(entry, part)
    return stream.getvalue(), (*content.notes, *lacking, remark)


HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
DECLARED = re.compile(r"typedef\s+(\w+)\s+(fmi[23]\w+)TYPE\s*\(([^;]*)\);")


def source_text(content: Content, setting: Setting) -> tuple[str, str]:
    """Return the source and the token that identifies it."""
    facts = _facts(content, setting)
    facts["absent"] = _absent(
        rendered("fmu/source.c", facts | {"token": "", "absent": ""}), setting.fmi
    )
    token = str(
        uuid.UUID(
            hashlib.sha256(rendered("fmu/source.c", facts | {"token": ""}).encode()).hexdigest()[
                :32
            ]
        )
    )
    token = f"{{{token}}}"
    file = f"{setting.name}.c"
    return with_rights({file: rendered("fmu/source.c", facts | {"token": token})}, setting.source)[
        file
    ], token


def _facts(content: Content, setting: Setting) -> dict[str, object]:
    exchange = content.exchange
    ports = content.ports
    printer = Printer(content.unit, "double", [kind for _, kind in content.values.values()])
    definitions = printer.definitions()
    data, handed = _data(content, printer)
    listed = ports.listed
    size = content.memory.size
    layout = f"{setting.name} {content.layout} {[port.name for port in listed]}"
    starts = [i for i, port in enumerate(listed) if port.role == START]
    meanings = [
        plain(f"{port.name} [{port.variable.unit(content.kind)}]: {port.variable.description}")
        for port in listed
    ]
    remembered = "0.0"
    if np.any(content.memory):
        remembered = "remembered[i]"
    facts: dict[str, object] = (
        {
            "title": plain(content.title),
            "version": version(),
            "facts": [*setting.source.lines, *content.tables],
            "flags": FLAGS,
        }
        | {
            "fmi": setting.fmi,
            "definitions": definitions,
            "helpers": helpers_text(printer.helpers, "double", printer.integer),
        }
        | {
            "data": data,
            "step": number(setting.step),
            "memory": size,
            "layout": f"0x{digest_of(layout.encode()):016X}",
        }
        | {
            "ports": [
                {"start": number(port.value), "told": text}
                for port, text in zip(listed, meanings, strict=True)
            ]
        }
        | {"roles": [port.role for port in listed], "begin": _numbers(content.begin)}
        | {
            "lowest": [number(port.range[0]) for port in listed],
            "highest": [number(port.range[1]) for port in listed],
        }
        | {"remembered": remembered, "most": _numbers(content.most)}
        | {
            "plant": content.failures_at >= 0,
            "failures_at": content.failures_at,
            "first_start": next(iter(starts), 0),
        }
        | {
            "output": content.output,
            "output_at": ports.place(content.output),
            "shown": [(at, k) for k, at in enumerate(starts)],
        }
        | {"stepping": _called(content.entry, content, handed), "exchange": None}
    )
    if exchange is not None:
        kernels = {
            name: _called(getattr(exchange, name), content, handed)
            for name in ("flowing", "begun", "arrived", "changing")
        }
        facts["exchange"] = (
            {
                "states": ports.states,
                "rates": ports.in_role(RATE),
                "margins": ports.in_role(MARGIN),
                "held": exchange.held,
            }
            | {
                "nominals": [number(variable.nominal) for variable in exchange.varying.values()],
                "most": _numbers(exchange.held),
            }
            | {"result": printer.named(exchange.changing.result, "result")}
            | kernels
        )
    return facts


def _numbers(values: Iterable[float]) -> list[str]:
    """Return the numbers of an array in C, which cannot be empty."""
    return [number(float(value)) for value in values] or ["0.0"]


def _data(content: Content, printer: Printer) -> tuple[str, dict[str, str]]:
    """Return the parameters in C, and the text of each argument for them."""
    texts = []
    handed = {}
    entries = [content.entry]
    if content.exchange is not None:
        entries += content.exchange[:4]
    needed = {parameter.name for entry in entries for parameter in entry.parameters}
    for argument, (values, kind) in content.values.items():
        if argument not in needed:
            continue
        if argument in content.ports.tuned:
            tuned, _ = content.ports.tuned[argument]
            fields = [f"    {line}" for line in declared(tuned, printer)]
            texts += [
                "typedef struct {",
                *fields,
                f"}} {argument}_parameters;",
                "",
                assembled(
                    values, tuned, printer, kind, f"{argument}_parameters", f"made_{argument}"
                ),
            ]
            handed[argument] = f"made_{argument}(&given_{argument})"
        else:
            handed[argument] = f"constant_{argument}"
            texts.append(constant_text(handed[argument], values, kind, printer, argument))
    if content.failures_at >= 0:
        texts.append(
            "static inline double magnitude_of(double x)\n{\n    return x < 0.0 ? -x : x;\n}\n"
        )
    if np.any(content.memory):
        texts.append(array_text("remembered", content.memory, printer) + "\n")
    return "\n".join(texts), handed


# Arguments of a kernel that have the same text in each FMU.
CALLED = {
    "lasting": "now->lasting",
    "varying": "now->varying",
    "held": "now->held",
    "slope": "slope",
    "dt": "STEP",
    "tangent__varying": "d_varying",
    "tangent__slope": "d_slope",
}


def _called(entry: Function, content: Content, handed: Mapping[str, str]) -> list[str]:
    """Return the lines that call a kernel; the last line is the call."""
    lines = []
    arguments = []
    for argument, (_, first) in content.ports.tuned.items():
        if argument in [parameter.name for parameter in entry.parameters]:
            lines += [
                f"{argument}_parameters given_{argument};",
                f"memcpy(&given_{argument}, now->values + {first}, sizeof given_{argument});",
            ]
    for parameter in entry.parameters:
        name = parameter.name
        if name in content.memory_at:
            place = "now->memory"
            if content.memory_at[name]:
                place += f" + {content.memory_at[name]}"
            arguments.append(place)
        elif name in CALLED:
            arguments.append(CALLED[name])
        elif name.startswith("tangent__"):
            place = content.ports.place(name.removeprefix("tangent__"))
            arguments.append(f"seed[{place}]")
        elif name in handed:
            arguments.append(handed[name])
        elif isinstance(parameter.type, Array):  # the place of the first variable
            arguments.append(f"now->values + {content.ports.place(f'{name}[1]')}")
        else:
            arguments.append(f"now->values[{content.ports.place(name)}]")
    return [*lines, f"{entry.name}({', '.join(arguments)});"]


def _absent(source: str, fmi: int) -> str:
    """Return the functions of the standard that a source lacks; each returns an error."""
    texts = []
    for kind, name, arguments in DECLARED.findall(header_text(f"fmi{fmi}FunctionTypes.h")):
        if re.search(rf"\b{name}\(", source):
            continue
        words = [
            re.sub(r"\[.*?\]", "", argument).split()[-1].lstrip("*")
            for argument in arguments.split(",")
        ]
        unused = "".join(f"    (void){word};\n" for word in words)
        result = "NULL"
        if kind.endswith("Status"):
            result = f"fmi{fmi}Error"
        texts.append(
            f"{kind} {name}({' '.join(arguments.split())})\n{{\n{unused}    return {result};\n}}\n"
        )
    return "\n".join(texts)


def header_text(name: str) -> str:
    """Return a header of the standard, or their licence."""
    return text_of(f"fmu/headers/{name}", PACKAGES[1])

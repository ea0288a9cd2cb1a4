"""FMUs: native co-simulation with a fixed internal step, and model exchange, of friction, its plant, or a control law.

An FMU is an archive: a description, the source and its headers, a page on its use, licences, and a library for each
platform.
"""

from __future__ import annotations

import importlib.util
import io
import platform
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from bristle.core.contracts import Model
from bristle.exports.c import FLAGS
from bristle.exports.described import Source, hash_on_plant, licence_text
from bristle.exports.fmu_content import Content, Setting, content_of
from bristle.exports.fmu_description import build_text, description_text, page_text
from bristle.exports.fmu_law import content_of_law
from bristle.exports.fmu_source import HEADERS, header_text, source_text
from bristle.exports.law import Law
from bristle.exports.proof import compiler
from bristle.exports.subject import subject_of
from bristle.exports.targets import Product, Request
from bristle.friction.resting import rest_rule

PATIENCE = 600.0  # [s]; zig builds the library of a platform once


# By system and machine: its folder in FMI 2.0, empty where that has none, and in 3.0; its name for zig; its library.
PLATFORMS = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux", "x86_64-linux-gnu.2.17", ".so"),
    ("linux", "aarch64"): ("", "aarch64-linux", "aarch64-linux-gnu.2.17", ".so"),
    ("win32", "amd64"): ("win64", "x86_64-windows", "x86_64-windows-gnu", ".dll"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin", "x86_64-macos", ".dylib"),
    ("darwin", "arm64"): ("", "aarch64-darwin", "aarch64-macos", ".dylib"),
}


@dataclass(frozen=True)
class Library:
    """A library of an FMU: where it lies inside, and its bytes; or why there is none."""

    place: str
    content: bytes
    problem: str = ""


def zig() -> list[str]:
    """Return the command of the compiler for other platforms; empty where it is not installed."""
    return [sys.executable, "-m", "ziglang", "cc"] if importlib.util.find_spec("ziglang") else []


def libraries(name: str, sources: Mapping[str, str], fmi: int) -> list[Library]:
    """Return the libraries that can be built here."""
    local, own, across = (sys.platform, platform.machine().lower()), compiler(), zig()
    built = []
    for machine, (*folders, triple, suffix) in PLATFORMS.items():
        folder = folders[fmi - 2]
        if not folder or not (across or (machine == local and own)):
            continue
        command = [*across, "-g0", "-target", triple, *([] if machine[0] == "win32" else ["-fPIC"])]
        if machine == local and own:
            command = [own, "-fPIC", "-fvisibility=hidden"]
        built.append(_library(command, name, sources, f"binaries/{folder}/{name}{suffix}"))
    return built


def _library(command: list[str], name: str, sources: Mapping[str, str], place: str) -> Library:
    with tempfile.TemporaryDirectory(prefix="bristle-fmu-") as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        output = Path(folder) / Path(place).name
        line = [*command, "-O2", *FLAGS.split(), "-shared", f"{name}.c", "-o", output.name]
        line += [] if output.suffix == ".dll" else ["-lm"]
        try:
            ran = subprocess.run(line, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            return Library(place, b"", type(error).__name__)
        if ran.returncode or not output.is_file():
            return Library(place, b"", (ran.stderr.strip().splitlines() or ["no reason given"])[0])
        return Library(place, output.read_bytes())


def write(request: Request, *, fmi: int) -> Product:
    """Return one FMU of the friction, and another one of friction and plant."""
    name, plant, source = request.name, request.plant, request.source
    notes = [f"the internal step is {request.dt:g} s: the bits are those of bristle at this step"]
    if rest_rule(request.sampled):
        notes.append(
            f"a mass outside {name}.fmu creeps at rest: a model without memory cannot hold it there. "
            f"Use {name}_mass.fmu, or a model with memory"
        )
    bodies: list[tuple[str, Model, Model | None]] = [(name, request.sampled, None)]
    if plant is None:
        notes.append("no mass is known: there is no FMU with a mass")
    elif plant.component.screw is not None:
        notes.append(f"{plant.name} has a screw: there is no FMU with a mass")
    else:
        bodies.append((f"{name}_mass", request.model, plant))
    written: dict[str, str | bytes] = {}
    for file, friction, body in bodies:
        content = content_of(subject_of(friction), body, source)
        model_hash = source.model_hash
        model_hash = hash_on_plant(model_hash, body, content.unit) if model_hash and body is not None else model_hash
        setting = Setting(file, replace(source, model_hash=model_hash), request.dt, fmi)
        written[f"{file}.fmu"], remarks = _archive(content, setting)
        notes += [text for text in remarks if text not in notes]
    return Product(written, tuple(notes))


def write_law(law: Law, name: str, source: Source, *, fmi: int) -> Product:
    """Return the FMU of a control law, whose internal step is its sample time."""
    archive, remarks = _archive(content_of_law(law, name, source), Setting(name, source, law.dt, fmi))
    note = f"the internal step is the sample time, {law.dt:g} s: the bits are those of the law at this step"
    return Product({f"{name}.fmu": archive}, (note, *remarks))


def _archive(content: Content, setting: Setting) -> tuple[bytes, tuple[str, ...]]:
    """Return an archive, and what is to be said of it: of platforms, too."""
    name, fmi = setting.name, setting.fmi
    text, token = source_text(content, setting)
    sources = {f"{name}.c": text} | {header: header_text(header) for header in HEADERS[fmi]}
    built = libraries(name, sources, fmi)
    inside: dict[str, str | bytes] = {
        "modelDescription.xml": description_text(content, setting, token),
        "documentation/index.html": page_text(content, setting),
        "documentation/licenses/license.txt": licence_text(),
        **{f"sources/{file}": text for file, text in sources.items()},
        "sources/LICENSE.txt": header_text("LICENSE.txt"),
        **({"sources/buildDescription.xml": build_text(name)} if fmi == 3 else {}),
        **{library.place: library.content for library in built if not library.problem},
    }
    platforms = [library.place.split("/")[1] for library in built if not library.problem]
    lacking = [f"no library for {library.place.split('/')[1]}: {library.problem}" for library in built if library.problem]
    none = f"no C compiler was found: the FMU holds its source only; build it with {FLAGS}"
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, part in inside.items():
            entry = zipfile.ZipInfo(place)  # of 1980: the same files give the same archive
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if place.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, part)
    return stream.getvalue(), (*content.notes, *lacking, f"libraries for {', '.join(platforms)}" if platforms else none)

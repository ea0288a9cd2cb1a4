"""FMUs: native co-simulation with a fixed internal step, and model exchange, of friction, its plant, or a control law.

An FMU is an archive: a description, the source and its headers, a page on its use, licences, and a library for each
platform.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace

from bristle.core.contracts import Model
from bristle.exports.described import Source
from bristle.exports.fmu_build import Library, libraries
from bristle.exports.fmu_content import Content, content_of
from bristle.exports.fmu_description import FLAGS, Description, build_text
from bristle.exports.fmu_document import page_text
from bristle.exports.fmu_law import content_of_law
from bristle.exports.fmu_source import HEADERS, header_text, source_text
from bristle.exports.identity import hash_on_plant, licence_text
from bristle.exports.law import Law
from bristle.exports.subject import subject_of
from bristle.friction.resting import rest_rule

__all__ = ["Setting", "fmu_files", "law_fmu_files"]

LICENCE = "LICENSE.txt"
WRITTEN = (1980, 1, 1, 0, 0, 0)  # the same files give the same archive


@dataclass(frozen=True)
class Setting:
    """How an FMU is written."""

    name: str
    source: Source
    step: float
    fmi: int


def fmu_files(friction: Model, alone: Model, plant: Model | None, setting: Setting) -> tuple[dict[str, str | bytes], tuple[str, ...]]:
    """Return the FMUs of a friction model, and what is to be said of them."""
    written: dict[str, str | bytes] = {}
    notes = [f"the internal step is {setting.step:g} s: the bits are those of bristle at this step"]
    if rest_rule(alone):
        notes.append(
            f"a mass outside {setting.name}.fmu creeps at rest: a model without memory cannot hold it there. "
            f"Use {setting.name}_mass.fmu, or a model with memory"
        )
    bodies: list[tuple[str, Model | None]] = [(setting.name, None)]
    if plant is None:
        notes.append("no mass is known: there is no FMU with a mass")
    elif plant.component.screw is not None:
        notes.append(f"{plant.name} has a screw: there is no FMU with a mass")
    else:
        bodies.append((f"{setting.name}_mass", plant))
    for name, body in bodies:
        content = content_of(subject_of(alone if body is None else friction), body, setting.source)
        model_hash = setting.source.model_hash
        model_hash = hash_on_plant(model_hash, body, content.unit) if model_hash and body is not None else model_hash
        source = replace(setting.source, model_hash=model_hash)
        written[f"{name}.fmu"], remarks = _archive(content, replace(setting, name=name, source=source))
        notes += [text for text in remarks if text not in notes]
    return written, tuple(notes)


def law_fmu_files(law: Law, setting: Setting) -> tuple[dict[str, str | bytes], tuple[str, ...]]:
    """Return the FMU of a control law, whose internal step is its sample time, and what is to be said of it."""
    content = content_of_law(law, setting.name, setting.source)
    archive, remarks = _archive(content, setting)
    notes = f"the internal step is the sample time, {setting.step:g} s: the bits are those of the law at this step"
    return {f"{setting.name}.fmu": archive}, (notes, *remarks)


def _archive(content: Content, setting: Setting) -> tuple[bytes, tuple[str, ...]]:
    name, source, fmi = setting.name, setting.source, setting.fmi
    text, token = source_text(content, name, source, setting.step, fmi)
    sources = {f"{name}.c": text} | {header: header_text(header) for header in HEADERS[fmi]}
    described = Description(name, content.title, content.kind, content.ports, setting.step, token, source)
    built = libraries(name, sources, fmi)
    inside: dict[str, str | bytes] = {"modelDescription.xml": described.text(fmi)}
    inside["documentation/index.html"] = page_text(content, name, source, setting.step, fmi)
    inside["documentation/licenses/license.txt"] = licence_text()
    inside |= {f"sources/{file}": text for file, text in sources.items()}
    inside[f"sources/{LICENCE}"] = header_text(LICENCE)
    if fmi == 3:
        inside["sources/buildDescription.xml"] = build_text(name)
    inside |= {library.place: library.content for library in built if not library.problem}
    return _zipped(inside), (*content.notes, *_remarks(built))


def _remarks(built: list[Library]) -> list[str]:
    """Return which platforms there are libraries for."""
    platforms = [library.place.split("/")[1] for library in built if not library.problem]
    notes = [f"no library for {library.place.split('/')[1]}: {library.problem}" for library in built if library.problem]
    if not platforms:
        return [*notes, f"no C compiler was found: the FMU holds its source only; build it with {FLAGS}"]
    return [*notes, f"libraries for {', '.join(platforms)}"]


def _zipped(inside: Mapping[str, str | bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, content in inside.items():
            entry = zipfile.ZipInfo(place, WRITTEN)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if place.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, content)
    return stream.getvalue()

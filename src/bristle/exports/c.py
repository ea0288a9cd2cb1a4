"""C99 of a friction model: a header, a source without dependencies, a self-test, an example and build files.

The functions of the tree are static functions of one source; the state is a structure that the caller owns. This module
writes the code between them and the caller: the first position, inputs that are not numbers, saving and loading. To prove
an export, a C compiler of this machine builds and runs the self-test.
"""

import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, reduce
from pathlib import Path
from typing import Any, ClassVar, get_type_hints

import numpy as np

from bristle.core import InputError, Model, Variable, variables_of
from bristle.engine.translation.scope import free_name
from bristle.engine.translation.tree import Struct
from bristle.exports import subject as subjects
from bristle.exports.c_code import Printer, initializer, number
from bristle.exports.c_derivatives import DerivedStep, derived_step
from bristle.exports.c_parts import (
    CONSTANT,
    Fields,
    around_text,
    array_text,
    declared,
    helpers_text,
    literal,
    parameters_text,
    saved_facts,
    started,
)
from bristle.exports.described import (
    Request,
    Source,
    command_facts,
    meaning_of,
    model_facts,
    rendered,
    with_rights,
)
from bristle.exports.feed import fed, feed_facts, with_feed
from bristle.exports.law import PER_VELOCITY, Law, law_facts, law_walk, settled_law, tunable_law
from bristle.exports.printing import wrapped
from bristle.exports.subject import COUNT, Subject, Walk
from bristle.exports.targets import Product
from bristle.exports.tunable import CONSTANTS, Tunable, checkpoints, single_note, tunable_of
from bristle.prediction.drive_units import command_units

FLAGS = "-std=c99 -ffp-contract=off"
SCALAR = {False: "double", True: "float"}  # by whether numbers are of single precision
VELOCITY = {
    "double": "(x - axis->position) / dt",
    "float": "(float)(x - axis->position) / (float)dt",
}
STAND_IN = "name_of_the_export"  # in the templates, until the code has no variable with the name of the export
UNTOUCHED = r'"(?:\\.|[^"\\])*"|/\*.*?\*/|(?:struct|union)\b[^;{}()]*\{(?:[^{}]|\{[^{}]*\})*\}'
"""Strings, comments, and structures with one level inside."""
FILES = {
    "{}.h": "c/header.h",
    "{}.c": "c/source.c",
    "{}_selftest.c": "c/selftest.c",
    "CMakeLists.txt": "c/CMakeLists.txt",
    "example_main.c": "c/example_main.c",
    "README.md": "c/README.md",
}


@dataclass(frozen=True)
class CFiles:
    """Files of a friction model in C."""

    subject: Subject
    request: Request
    steps: int = subjects.COUNT
    printer: ClassVar[type[Printer]] = Printer
    fixed: ClassVar[tuple[str, ...]] = ()
    """Parameters that cannot change at run time."""
    derived: DerivedStep | None = None
    feeds: bool = False
    """Whether the files have a feed, with the rule of the request."""
    templates: ClassVar[Mapping[str, str]] = FILES

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        subject = self.subject
        request = self.request
        walk = subjects.walk_of(subject, request.dt)
        x = walk.positions(self.steps)
        if subject.is_operator:
            forces = subject.outputs(x)
        else:
            forces = subject.forces(x, request.dt)
        walked = selftest_facts(walk, forces, single=request.single)
        if self.derived:
            walked |= self.derived.selftest_facts(x, request.dt)
        if self.has_feed:
            walked["feed_hash"] = (
                f"0x{subjects.hash_of(fed(x, forces.tolist(), request.dt, request.share) + 0.0):016X}"
            )
        return written_files(self.templates, request.name, self.facts(), walked, request.source)

    @property
    def has_feed(self) -> bool:
        """Whether the files have a feed."""
        return self.feeds and not self.subject.is_operator

    def new_printer(self, subject: Subject | None = None) -> Printer:
        """Return a printer of the functions and types of the subject."""
        subject = subject or self.subject
        around = [subject.state, subject.move, subject.parameters]
        if not subject.is_operator:
            around.append(subject.motion)
        return self.printer(subject.unit, SCALAR[self.request.single], around)

    def facts(self) -> dict[str, Any]:
        """Return the facts of the templates of the header and the source."""
        subject = self.subject
        request = self.request
        name = request.name
        scalar = SCALAR[request.single]
        kind = subject.model.kind
        units = None
        if not subject.is_operator:
            units = command_units(request.axis, kind)
        cycles = max(2, round(1.0 / request.dt))  # of the example: one second
        tuned = None
        if request.tunable:
            tuned = tunable_of(subject.model, self.fixed)
        if self.has_feed:
            with_it, feed = with_feed(subject)
            printer = self.new_printer(with_it)
            of_feed = feed_facts(feed, request.share, printer, kind)
        else:
            printer = self.new_printer()
            of_feed = {"feed": False}
        of_state = zip(
            subject.state.fields,
            variables_of(subject.state.cls).values(),
            subject.virgin,
            strict=True,
        )
        fields = [
            (printer.names.variable(name), part, meaning_of(variable, kind), value)
            for (name, part), variable, value in of_state
        ]
        used = {
            argument.name for argument in (*subject.trial.parameters, *subject.commit.parameters)
        }
        data = ""
        if tuned is not None or "p" in used:
            data = parameters_text(
                subject.model.parameters, subject.parameters, printer, name, tuned
            )
        facts = (
            model_facts(
                subject,
                name,
                request.source,
                request.dt,
                single=request.single,
                tunable=request.tunable,
            )
            | block_facts(printer, name, fields, subject.memory_size, tuned)
            | saved_facts(
                printer,
                ("position", "force"),
                fields,
                subject.memory_size,
                subjects.layout_of(subject, scalar),
            )
            | of_feed
            | {
                "drive": command_facts(units, kind),
                "device": "",
                "velocity": VELOCITY[scalar],
                "result": "force",
            }
            | {
                "amplitude": "0.001",
                "cycles": cycles,
                "period": f"{cycles * request.dt:g}",
                "every": max(1, cycles // 10),
            }
            | {
                "nominal": ", ".join(repr(subject.usual[name]) for name in subject.signals),
                "zero": number(0.0, scalar),
            }
            | {
                "signals": [printer.names.variable(name) for name in subject.signals],
                "step": self._step(printer),
                "data": data,
            }
            | {
                "told_signals": [
                    meaning_of(variables_of(subject.motion.cls)[name], kind)
                    for name in subject.signals
                ],
                "steps": self.steps,
            }
            | {"derived": False}
        )
        if self.derived:
            facts |= self.derived.facts(printer, tunable=request.tunable)
        return facts

    def _step(self, printer: Printer) -> list[str]:
        subject = self.subject
        cast = CAST[self.request.single]
        around = around_text(subject, printer)
        values = f"{{{', '.join(['velocity', f'{cast}x', *(f'{cast}{text}' for text in around)])}}}"
        motion = ""
        if not subject.is_operator:
            motion = f"const {printer.named(subject.motion, 'motion')} = {values};"
        names = [printer.names.variable(name) for name, _ in subject.state.fields]
        state = initializer(f"axis->state.{name}" for name in names)
        assembling = (
            f"const {printer.named(subject.parameters, 'p')} = assembled(&axis->parameters);"
        )
        handed = {
            "state": ("state", f"const {printer.named(subject.state, 'state')} = {{{state}}};"),
            "motion": ("motion", motion),
            "p": (CONSTANT, ""),
            "memory": ("axis->memory", ""),
        }
        if self.request.tunable:
            handed["p"] = ("p", assembling)
        handed |= {"input": (f"{cast}x", ""), "dt": (f"{cast}dt", ""), "move": ("step.part_1", "")}
        of_trial = subjects.arguments_left(subject.trial, subjects.TRIAL[subject.is_operator])
        of_commit = subjects.arguments_left(subject.commit, subjects.COMMIT)
        trial, commit = (
            f"{function.name}({', '.join(handed[name][0] for name in left)})"
            for function, left in ((subject.trial, of_trial), (subject.commit, of_commit))
        )
        needed = {*of_trial}
        if subject.commits:
            needed.update(of_commit)
        assert isinstance(subject.trial.result, Struct)
        lines = [
            *(line for name, (_, line) in handed.items() if line and name in needed),
            f"const {printer.named(subject.trial.result, 'step')} = {trial};",
            "if (!is_finite(step.part_0)) {",
            f"    axis->flags |= {self.request.name.upper()}_OVERFLOW;",
            "    return axis->force;",
            "}",
            "axis->force = step.part_0;",
        ]
        if not names:
            if subject.commit.writes:
                return [*lines, f"(void){commit};"]
            return lines
        lines.append(f"const {printer.named(subject.state, 'after')} = {commit};")
        return lines + [f"axis->state.{name} = after.{name};" for name in names]


def written_files(
    templates: Mapping[str, str],
    name: str,
    facts: dict[str, Any],
    walked: dict[str, Any],
    source: Source,
) -> dict[str, str]:
    """Return the text of each file by its name, from its template; the self-test also gets facts on the walk."""
    facts = facts | {"name": STAND_IN}
    texts = {}
    for file, template in templates.items():
        of_file = facts
        if "selftest" in file:
            of_file = facts | walked
        text = rendered(template, of_file)
        if file.endswith((".c", ".h")):
            text = _apart(text, name)
        texts[file.format(name)] = text.replace(STAND_IN, name)
    return with_rights(texts, source)


def _apart(text: str, name: str) -> str:
    """Return code with another name for its own variables and functions of this name; fields keep it."""
    new = free_name(f"{name}_", re.findall(r"\w+", text))
    return re.sub(
        rf"({UNTOUCHED})|(?<![.\w])(?<!->){name}\b",
        lambda place: place[1] or new,
        text,
        flags=re.DOTALL,
    )


def block_facts(
    printer: Printer, name: str, fields: Fields, memory: int, tuned: Tunable | None
) -> dict[str, Any]:
    """Return template facts on the state of friction or a law, and on the functions around it."""
    start = [
        f"axis->state.{field} = {literal(value, part, printer.scalar)};"
        for field, part, _, value in fields
    ]
    parameters = []
    if tuned:
        start += started(tuned, printer)
        parameters = declared(tuned, printer)
    return (
        {
            "guard": name.upper(),
            "flags": FLAGS,
            "scalar": printer.scalar,
            "inline": printer.inline,
            "memory": memory,
        }
        | {"definitions": printer.definitions(), "start": start}
        | {
            "state": [
                f"{printer.named(part, field)}; /* {meaning} */"
                for field, part, meaning, _ in fields
            ]
        }
        | {
            "helpers": helpers_text(
                printer.helpers, printer.scalar, printer.integer, printer.inline
            )
        }
        | {"parameters": parameters}
    )


def selftest_facts(walk: Walk, outputs: np.ndarray, *, single: bool) -> dict[str, Any]:
    """Return the facts of a self-test: the construction of the walk, and the hash of the outputs."""
    digest = subjects.hash_of(outputs)
    return (
        {
            "count": outputs.size,
            "scales": [repr(scale) for scale in walk.scales],
            "last": repr(float(outputs[-1])),
        }
        | {
            "seed": subjects.SEED,
            "factor": subjects.FACTOR,
            "term": subjects.TERM,
            "rests": subjects.RESTS,
            "part": subjects.PART,
        }
        | {"hash": f"0x{digest:016X}", "hash_text": f"{digest:016x}"}
        | checkpoints(outputs, single=single)
    )


def write(request: Request) -> Product:
    """Return the source, in double or single precision."""
    fixed = None
    notes = ()
    if request.single:
        fixed = CONSTANTS
        notes = (single_note("force"),)
    subject = subjects.subject_of(request.sampled, fixed)
    if request.derivatives:
        if request.single:
            raise InputError(
                "does not support derivatives in single precision",
                path="c",
                mend="Omit --float32 or --derivatives",
            )
        derived = derived_step(subject, tunable=request.tunable)
        return Product(dict(CFiles(derived.subject, request, derived=derived, feeds=True).files()))
    places = ()
    if request.tunable:
        places = tunable_of(subject.model).places
    files = CFiles(
        subjects.settled_subject(subject, places, single=request.single), request, feeds=True
    ).files()
    return Product(dict(files), notes)


CAST = {False: "", True: "(float)"}  # of an input, by single precision
STEPS = 400
NAME = "model"
PATIENCE = 120.0  # [s]


def compiler() -> str | None:
    """Return the command of a C compiler that builds and runs a program here; None if there is no such compiler."""
    return next((name for name in ("cc", "gcc", "clang") if builds(name, *FLAGS.split())), None)


@cache
def builds(command: str, *flags: str) -> bool:
    """Return whether a compiler accepts these flags and its program runs (a sanitizer may be missing)."""
    if shutil.which(command) is None:
        return False
    with tempfile.TemporaryDirectory(prefix="bristle-proof-") as place:
        (Path(place) / "tried.c").write_text("int main(void) { return 0; }\n", encoding="ascii")
        for line in ([command, *flags, "tried.c", "-o", "tried", "-lm"], ["./tried"]):
            if subprocess.run(
                line, cwd=place, capture_output=True, timeout=PATIENCE, check=False
            ).returncode:
                return False
    return True


def proved(model: Model, command: str) -> tuple[int, str]:
    """Compile and run the self-test of a model; return the number of its steps, and its message on failure."""
    files = CFiles(
        subjects.settled_subject(subjects.subject_of(model)), Request(model, NAME, 1e-3), STEPS
    ).files()
    with tempfile.TemporaryDirectory(prefix="bristle-proof-") as place:
        for file, text in files.items():
            (Path(place) / file).write_text(text, encoding="ascii")
        line = [
            command,
            "-O1",
            *FLAGS.split(),
            f"{NAME}.c",
            f"{NAME}_selftest.c",
            "-o",
            "selftest",
            "-lm",
        ]
        built = subprocess.run(
            line, cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        if built.returncode:
            return STEPS, f"{command} reports: {built.stderr.strip().splitlines()[0]}"
        ran = subprocess.run(
            ["./selftest"], cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False
        )
        if ran.returncode:
            return STEPS, ran.stdout.strip().splitlines()[-1]
        return STEPS, ""


LAW_FILES = {
    "{}.h": "c/law.h",
    "{}.c": "c/law.c",
    "{}_selftest.c": "c/law_selftest.c",
    "CMakeLists.txt": "c/CMakeLists.txt",
    "example_main.c": "c/law_main.c",
    "README.md": "c/law_README.md",
}


def law_files(law: Law, name: str, source: Source) -> dict[str, str]:
    """Return the files of a control law in C, text by name."""
    law = settled_law(law)
    walk, positions, efforts = law_walk(law, COUNT)
    walked = selftest_facts(walk, efforts, single=law.single) | {
        "positions": positions,
        "per_velocity": repr(PER_VELOCITY),
    }
    return written_files(LAW_FILES, name, law_code_facts(law, name, source), walked, source)


def law_code_facts(law: Law, name: str, source: Source) -> dict[str, Any]:
    """Return the facts of the templates of the header and the source of a law."""
    variant = law.variant
    lasting, p = law.types
    tuned = None
    if law.tunable:
        tuned = tunable_law(law)
    printer = Printer(law.unit, SCALAR[law.single], [lasting, p])
    fields = []
    after = []
    for path, kind in law.leaves:
        hints = get_type_hints(type(reduce(getattr, path[:-1], law.lasting)), include_extras=True)
        variable = next(mark for mark in hints[path[-1]].__metadata__ if isinstance(mark, Variable))
        side = variant.controller.kind
        if path[0] == "table":
            side = "translational"
        fields.append(
            ("_".join(path), kind, meaning_of(variable, side), reduce(getattr, path, law.lasting))
        )
        after.append(
            f"axis->state.{fields[-1][0]} = now.part_1.{'.'.join(printer.names.variable(part) for part in path)};"
        )
    friction = variant.feedforward.friction
    law_name = f"{variant.controller.name} {friction and friction.name}"
    layout = f"{law_name} {law.dt!r} {[field[:2] for field in fields]} {law.memory_size}"
    if law.single:
        layout += " float"
    array = ""
    remembered = number(0.0, printer.scalar)
    if np.any(law.memory):
        array = array_text("remembered", law.memory, printer) + "\n"
        remembered = "remembered[i]"
    return (
        law_facts(law, name, source)
        | block_facts(printer, name, fields, law.memory_size, tuned)
        | saved_facts(printer, ("effort",), fields, law.memory_size, layout)
        | {
            "data": array + parameters_text(law.p, p, printer, name, tuned),
            "step": _law_step(law, printer),
            "after": after,
        }
        | {"remembered": remembered, "steps": COUNT}
    )


def _law_step(law: Law, printer: Printer) -> list[str]:
    lasting, p = law.types
    needed = [argument.name for argument in law.entry.parameters]
    arrays = []
    if law.single:
        arrays = [name for name in needed if name.endswith("_ahead")]
    handed = {name: f"{CAST[law.single]}inputs->{name}" for name in law.inputs}
    handed |= {name: name for name in arrays}
    handed |= {name: f"axis->memory + {at}" for name, at in law.memory_at.items()}
    handed |= {name: "axis->memory" for name, at in law.memory_at.items() if not at}
    handed |= {
        "lasting": "lasting",
        "begun": "axis->begun != 0",
        "dt": number(law.dt, printer.scalar),
        "p": CONSTANT,
    }
    assert isinstance(law.entry.result, Struct)
    lines = []
    if law.tunable:
        handed["p"] = "p"
        lines = [f"const {printer.named(p, 'p')} = assembled(&axis->parameters);"]
    if arrays:
        lines += [f"float {name}[{law.samples_ahead}];" for name in arrays]
        lines += [
            f"for (int32_t i = 0; i < {law.samples_ahead}; ++i) {{",
            *(f"    {name}[i] = (float)inputs->{name}[i];" for name in arrays),
            "}",
        ]
    if "lasting" in needed:
        lines.append(f"const {printer.named(lasting, 'lasting')} = {_gathered(lasting, ())};")
    call = f"{law.entry.name}({', '.join(handed[name] for name in needed)})"
    lines.append(f"const {printer.named(law.entry.result, 'now')} = {call};")
    return [part for line in lines for part in wrapped(line, "")]


def _gathered(kind: Struct, path: tuple[str, ...]) -> str:
    parts = []
    for name, part in kind.fields:
        if isinstance(part, Struct):
            parts.append(_gathered(part, (*path, name)))
        else:
            parts.append(f"axis->state.{'_'.join((*path, name))}")
    return f"{{{initializer(parts)}}}"

"""C99 of a friction model: a header, a source that compiles alone, a self-test, an example and what builds them.

The functions of the tree are static functions of one source; the state is a structure that the caller owns. What is
between them and the caller (the first position, inputs that are no numbers, saving and loading) is written here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bristle.core.variable import variables_of
from bristle.exports import subject as subjects
from bristle.exports.c_code import Printer, number
from bristle.exports.c_parts import CONSTANT, Fields, declared, helpers_text, literal, parameters_text, saved_facts, started
from bristle.exports.described import Source, command_facts, meaning_of, model_facts, rendered, with_rights
from bristle.exports.subject import Subject, Walk
from bristle.exports.targets import Product, Request
from bristle.exports.tree import Struct
from bristle.exports.tunable import CONSTANTS, Tunable, checkpoints, single_note, tunable_of
from bristle.prediction.drive_units import CommandUnits, command_units

FLAGS = "-std=c99 -ffp-contract=off"
VELOCITY = {"double": "(x - axis->position) / dt", "float": "(float)(x - axis->position) / (float)dt"}
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
    """How a friction model is written in C."""

    subject: Subject
    name: str
    source: Source
    dt: float
    tunable: bool = False
    scalar: str = "double"
    steps: int = subjects.COUNT
    units: CommandUnits | None = None
    printer: ClassVar[type[Printer]] = Printer
    fixed: ClassVar[tuple[str, ...]] = ()
    """Parameters that may not be changed at run time."""

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        walk, subject = subjects.walk_of(self.subject, self.dt), self.subject
        x = walk.positions(self.steps)
        forces = subject.outputs(x) if subject.is_operator else subject.forces(x, self.dt)
        walked = selftest_facts(walk, forces, single=self.scalar == "float")
        return written_files(FILES, self.name, self._facts(), walked, self.source)

    def _facts(self) -> dict[str, Any]:
        subject, model, single = self.subject, self.subject.model, self.scalar == "float"
        meanings, kind = variables_of(subject.motion.cls), model.kind
        cycles = max(2, round(1.0 / self.dt))  # of the example: a second
        tuned = tunable_of(model, self.fixed) if self.tunable else None
        around = [subject.state, subject.move, subject.parameters] + ([] if subject.is_operator else [subject.motion])
        printer = self.printer(subject.unit, self.scalar, around)
        of_state = zip(subject.state.fields, variables_of(subject.state.cls).values(), subject.virgin, strict=True)
        fields = [(printer.names.variable(name), part, meaning_of(variable, kind), value) for (name, part), variable, value in of_state]
        used = {argument.name for argument in (*subject.trial.parameters, *subject.commit.parameters)}
        data = "" if tuned is None and "p" not in used else parameters_text(model.parameters, subject.parameters, printer, self.name, tuned)
        return (
            model_facts(subject, self.name, self.source, self.dt, single=single, tunable=self.tunable)
            | block_facts(printer, self.name, fields, subject.memory_size, tuned)
            | saved_facts(printer, ("position", "force"), fields, subject.memory_size, subjects.layout_of(subject, self.scalar))
            | {"drive": command_facts(self.units, kind), "device": "", "velocity": VELOCITY[self.scalar], "result": "force"}
            | {"amplitude": "0.001", "cycles": cycles, "period": f"{cycles * self.dt:g}", "every": max(1, cycles // 10)}
            | {"nominal": ", ".join(repr(subject.usual[name]) for name in subject.signals), "zero": number(0.0, self.scalar)}
            | {"signals": [printer.names.variable(name) for name in subject.signals], "step": self._step(printer), "data": data}
            | {"told_signals": [meaning_of(meanings[name], kind) for name in subject.signals], "steps": self.steps}
        )

    def _step(self, printer: Printer) -> list[str]:
        subject, cast = self.subject, "" if self.scalar == "double" else "(float)"
        usual = subject.usual.items()
        around = [printer.names.variable(name) if name in subject.signals else repr(value) for name, value in usual]
        values = f"{{{', '.join(['velocity', f'{cast}x', *(f'{cast}{text}' for text in around)])}}}"
        motion = "" if subject.is_operator else f"const {printer.named(subject.motion, 'motion')} = {values};"
        names = [printer.names.variable(name) for name, _ in subject.state.fields]
        state = ", ".join(f"axis->state.{name}" for name in names) or "0"
        assembling = f"const {printer.named(subject.parameters, 'p')} = assembled(&axis->parameters);"
        handed = {"state": ("state", f"const {printer.named(subject.state, 'state')} = {{{state}}};"), "motion": ("motion", motion)}
        handed |= {"p": ("p", assembling) if self.tunable else (CONSTANT, ""), "memory": ("axis->memory", "")}
        handed |= {"input": (f"{cast}x", ""), "dt": (f"{cast}dt", ""), "move": ("step.part_1", "")}
        of_trial = subjects.arguments_left(subject.trial, subjects.TRIAL[subject.is_operator])
        of_commit = subjects.arguments_left(subject.commit, subjects.COMMIT)
        trial, commit = (
            f"{function.name}({', '.join(handed[name][0] for name in left)})"
            for function, left in ((subject.trial, of_trial), (subject.commit, of_commit))
        )
        needed = {*of_trial, *(of_commit if subject.commits else ())}
        assert isinstance(subject.trial.result, Struct)
        lines = [
            *(line for name, (_, line) in handed.items() if line and name in needed),
            f"const {printer.named(subject.trial.result, 'step')} = {trial};",
            "if (!is_finite(step.part_0)) {",
            f"    axis->flags |= {self.name.upper()}_OVERFLOW;",
            "    return axis->force;",
            "}",
            "axis->force = step.part_0;",
        ]
        if not names:
            return [*lines, f"(void){commit};"] if subject.commit.writes else lines
        lines.append(f"const {printer.named(subject.state, 'after')} = {commit};")
        return lines + [f"axis->state.{name} = after.{name};" for name in names]


def written_files(templates: Mapping[str, str], name: str, facts: dict[str, Any], walked: dict[str, Any], source: Source) -> dict[str, str]:
    """Return the text of each file by its name, from its template; that of the self-test is told of the walk, too."""
    texts = {file: rendered(template, facts | walked if "selftest" in file else facts) for file, template in templates.items()}
    return with_rights({file.format(name): text for file, text in texts.items()}, source)


def block_facts(printer: Printer, name: str, fields: Fields, memory: int, tuned: Tunable | None) -> dict[str, Any]:
    """Return what is told of a structure that lasts and of the functions around it, of friction or of a law."""
    start = [f"axis->state.{field} = {literal(value, part, printer.scalar)};" for field, part, _, value in fields]
    return (
        {"guard": name.upper(), "flags": FLAGS, "scalar": printer.scalar, "inline": printer.inline, "memory": memory}
        | {"definitions": printer.definitions(), "start": start + (started(tuned, printer) if tuned else [])}
        | {"state": [f"{printer.named(part, field)}; /* {meaning} */" for field, part, meaning, _ in fields]}
        | {"helpers": helpers_text(printer.helpers, printer.scalar, printer.integer, printer.inline)}
        | {"parameters": declared(tuned, printer) if tuned else []}
    )


def selftest_facts(walk: Walk, outputs: np.ndarray, *, single: bool) -> dict[str, Any]:
    """Return what a self-test is told: how the walk is made, and the hash of the outputs along it."""
    digest = subjects.hash_of(outputs)
    return (
        {"count": outputs.size, "scales": [repr(scale) for scale in walk.scales], "last": repr(float(outputs[-1]))}
        | {"seed": subjects.SEED, "factor": subjects.FACTOR, "term": subjects.TERM, "rests": subjects.RESTS, "part": subjects.PART}
        | {"hash": f"0x{digest:016X}", "hash_text": f"{digest:016x}"}
        | checkpoints(outputs, single=single)
    )


def write(request: Request) -> Product:
    """Return the source, in double precision or in single."""
    units = command_units(request.axis, request.model.kind) if request.model.component.family == "friction" else None
    subject = subjects.subject_of(request.sampled, CONSTANTS if request.single else None)
    places = tunable_of(subject.model).places if request.tunable else ()
    left, scalar = subjects.settled_subject(subject, places, single=request.single), "float" if request.single else "double"
    files = CFiles(left, request.name, request.source, request.dt, request.tunable, scalar, units=units).files()
    return Product(dict(files), (single_note("force"),) if request.single else ())

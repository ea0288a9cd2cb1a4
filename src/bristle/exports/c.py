"""C99 of a friction model: a header, a source that compiles alone, a self-test, an example and what builds them.

The functions of the tree are static functions of one source; the state is a structure that the caller owns. What is
between them and the caller (the first position, inputs that are no numbers, saving and loading) is written here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, ClassVar

from bristle.core.variable import Kind, unit_of, variables_of
from bristle.exports.c_code import Printer, number
from bristle.exports.c_helpers import helpers_text
from bristle.exports.c_parameters import CONSTANT, declared, literal, parameters_text, started
from bristle.exports.c_saved import layout_of, saved_facts
from bristle.exports.described import Source, parameter_table, plain, told
from bristle.exports.identity import with_rights
from bristle.exports.loops import loops_of
from bristle.exports.rendering import rendered, version
from bristle.exports.single import TOLERANCE, checkpoints
from bristle.exports.subject import COMMIT, TRIAL, Subject, arguments_left, settled_subject
from bristle.exports.tree import Function
from bristle.exports.tunable import Tunable, tunable_of
from bristle.exports.types import Struct
from bristle.exports.walk import COUNT, FACTOR, PART, RESTS, SEED, TERM, hash_of, walk_of
from bristle.friction.resting import rest_rule
from bristle.prediction.drive_units import CommandUnits

__all__ = ["FLAGS", "CFiles", "c_files", "command_facts"]

FLAGS = "-std=c99 -ffp-contract=off"
TITLES = {False: "Friction of an axis", True: "Hysteresis operator"}
VELOCITY = {"double": "(x - axis->position) / dt", "float": "(float)(x - axis->position) / (float)dt"}
EXAMPLE_PERIOD, EXAMPLE_LINES, EXAMPLE_STROKE = 1.0, 20, 1e-3


@dataclass(frozen=True)
class CFiles:
    """How a friction model is written in C."""

    subject: Subject
    name: str
    source: Source
    dt: float
    tunable: bool = False
    scalar: str = "double"
    steps: int = COUNT
    units: CommandUnits | None = None
    printer: ClassVar[type[Printer]] = Printer
    fixed: ClassVar[tuple[str, ...]] = ()
    """Parameters that may not be changed at run time."""

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        facts = self._facts()
        files = {
            f"{self.name}.h": rendered("c/header.h", facts),
            f"{self.name}.c": rendered("c/source.c", facts),
            f"{self.name}_selftest.c": rendered("c/selftest.c", facts | self._walked()),
            "CMakeLists.txt": rendered("c/CMakeLists.txt", facts),
            "example_main.c": rendered("c/example_main.c", facts),
            "README.md": rendered("c/README.md", facts),
        }
        return with_rights(files, self.source)

    def _facts(self) -> dict[str, Any]:
        subject, model = self.subject, self.subject.model
        tuned = tunable_of(model, self.fixed) if self.tunable else None
        around = [subject.state, subject.move, subject.parameters] + ([] if subject.is_operator else [subject.motion])
        printer = self.printer(subject.unit, self.scalar, around)
        definitions = printer.definitions()
        step = self._step(printer, tuned)
        helpers = helpers_text(printer.helpers, self.scalar, printer.integer, printer.inline)
        component = model.component
        return {
            "name": self.name,
            "guard": self.name.upper(),
            "version": version(),
            "flags": FLAGS,
            "title": plain(f"{TITLES[subject.is_operator]}: {model.name}"),
            "operator": subject.is_operator,
            "rest": rest_rule(model),
            "drive": command_facts(self.units, model.kind),
            "description": plain(component.description) + ".",
            "facts": self.source.lines,
            "table": parameter_table(model, self.source).rstrip(),
            "unit_x": self._unit("length", "input"),
            "unit_force": self._unit("force", "output"),
            "scalar": self.scalar,
            "state": self._state_lines(printer),
            "memory": subject.memory_size,
            "signals": [printer.names.variable(name) for name in subject.signals],
            "parameters": declared(tuned, printer) if tuned else [],
            "definitions": definitions,
            "helpers": helpers,
            "data": self._data(printer, tuned),
            "step": step,
            "start": self._start(printer, tuned),
            "zero": number(0.0, self.scalar),
            "nominal": ", ".join(repr(subject.usual[name]) for name in subject.signals),
            "told_signals": [self._told(name) for name in subject.signals],
            "dt": repr(self.dt),
            "rate": f"{1.0 / self.dt:g}",
            **self._saved(printer),
            **self._example(),
            "loops": loops_of(subject),
            "reference": component.reference,
            "velocity": VELOCITY[self.scalar],
            "single": self.scalar == "float",
            "allowed": f"{TOLERANCE:g}",
            "result": "force",
            "several_places": False,
            "tunable": self.tunable,
            "steps": self.steps,
            "model": model.name,
            "device": "",
            "inline": printer.inline,
        }

    def _unit(self, quantity: str, of_operator: str) -> str:
        model = self.subject.model
        quantity = getattr(model.component, of_operator) if self.subject.is_operator else quantity
        return unit_of(quantity, model.kind)

    def _told(self, signal: str) -> str:
        return told(variables_of(self.subject.motion.cls)[signal], self.subject.model.kind)

    # --- what the structure of the axis holds ---------------------------------------------------------------------

    def _state_lines(self, printer: Printer) -> list[str]:
        variables, kind = variables_of(self.subject.state.cls), self.subject.model.kind
        return [
            f"{printer.named(part, printer.names.variable(name))}; /* {told(variables[name], kind)} */"
            for name, part in self.subject.state.fields
        ]

    def _start(self, printer: Printer, tuned: Tunable | None) -> list[str]:
        lines = [
            f"axis->state.{printer.names.variable(name)} = {literal(value, part, self.scalar)};"
            for (name, part), value in zip(self.subject.state.fields, self.subject.virgin, strict=True)
        ]
        return lines + (started(tuned, printer) if tuned else [])

    # --- the step -------------------------------------------------------------------------------------------------

    def _step(self, printer: Printer, tuned: Tunable | None) -> list[str]:
        subject, cast = self.subject, "" if self.scalar == "double" else "(float)"
        usual = subject.usual.items()
        around = [printer.names.variable(name) if name in subject.signals else repr(value) for name, value in usual]
        values = f"{{{', '.join(['velocity', f'{cast}x', *(f'{cast}{text}' for text in around)])}}}"
        motion = "" if subject.is_operator else f"const {printer.named(subject.motion, 'motion')} = {values};"
        state = ", ".join(f"axis->state.{printer.names.variable(name)}" for name, _ in subject.state.fields) or "0"
        handed = {
            "state": ("state", f"const {printer.named(subject.state, 'state')} = {{{state}}};"),
            "motion": ("motion", motion),
            "p": ("p", f"const {printer.named(subject.parameters, 'p')} = assembled(&axis->parameters);") if tuned else (CONSTANT, ""),
            "memory": ("axis->memory", ""),
            "input": (f"{cast}x", ""),
            "dt": (f"{cast}dt", ""),
            "move": ("step.part_1", ""),
        }
        trial, arguments = _call(subject.trial, TRIAL[subject.is_operator], handed)
        commit, also = _call(subject.commit, COMMIT, handed)
        commits = bool(subject.state.fields) or subject.commit.writes
        needed = {*arguments, *also} if commits else set(arguments)
        structures = [line for name, (_, line) in handed.items() if line and name in needed]
        assert isinstance(subject.trial.result, Struct)
        lines = [
            *structures,
            f"const {printer.named(subject.trial.result, 'step')} = {trial};",
            "if (!is_finite(step.part_0)) {",
            f"    axis->flags |= {self.name.upper()}_OVERFLOW;",
            "    return axis->force;",
            "}",
            "axis->force = step.part_0;",
        ]
        if not subject.state.fields:
            return [*lines, f"(void){commit};"] if subject.commit.writes else lines
        lines.append(f"const {printer.named(subject.state, 'after')} = {commit};")
        names = [printer.names.variable(name) for name, _ in subject.state.fields]
        return lines + [f"axis->state.{name} = after.{name};" for name in names]

    def _data(self, printer: Printer, tuned: Tunable | None) -> str:
        subject = self.subject
        used = {argument.name for argument in (*subject.trial.parameters, *subject.commit.parameters)}
        if tuned is None and "p" not in used:
            return ""
        return parameters_text(subject.model.parameters, subject.parameters, printer, self.name, tuned)

    # --- saving ---------------------------------------------------------------------------------------------------

    def _saved(self, printer: Printer) -> dict[str, Any]:
        state, size = self.subject.state, self.subject.memory_size
        fields = [(printer.names.variable(name), part) for name, part in state.fields]
        return saved_facts(printer, ("position", "force"), fields, size, layout_of(self.subject, self.scalar))

    # --- self-test and example ------------------------------------------------------------------------------------

    def _walked(self) -> dict[str, Any]:
        walk = walk_of(self.subject, self.dt)
        x, subject = walk.positions(self.steps), self.subject
        forces = subject.outputs(x) if subject.is_operator else subject.forces(x, self.dt)
        digest = hash_of(forces)
        return {
            "count": self.steps,
            "scales": [repr(scale) for scale in walk.scales],
            "seed": SEED,
            "factor": FACTOR,
            "term": TERM,
            "rests": RESTS,
            "part": PART,
            "hash": f"0x{digest:016X}",
            "hash_text": f"{digest:016x}",
            "last": repr(float(forces[-1])),
            **checkpoints(forces, single=self.scalar == "float"),
        }

    def _example(self) -> dict[str, Any]:
        cycles = max(2, round(EXAMPLE_PERIOD / self.dt))
        return {
            "amplitude": repr(EXAMPLE_STROKE),
            "cycles": cycles,
            "period": f"{cycles * self.dt:g}",
            "every": max(1, 2 * cycles // EXAMPLE_LINES),
        }


def command_facts(units: CommandUnits | None, kind: Kind) -> dict[str, Any] | None:
    """Return what is said of the units of a drive; None where nothing is known of them."""
    if units is None:
        return None
    efforts = [units.effort, *units.others]
    return {
        "position": {"unit": plain(units.position.name), "si": repr(units.position.si)},
        "efforts": [{"unit": plain(unit.name), "si": repr(unit.si), "macro": macro_of(unit.name)} for unit in efforts],
        "unit_force": plain(unit_of("force", kind)),
        "unit_x": plain(unit_of("length", kind)),
    }


def macro_of(unit: str) -> str:
    """Return a unit as a name of C has it: ``% of rated`` is ``PERCENT_OF_RATED``."""
    words = unit.replace("%", "percent").replace("*", "").replace("/", " per ")
    return "_".join(re.findall(r"[A-Za-z0-9]+", plain(words))).upper()


def c_files(
    subject: Subject,
    name: str,
    source: Source,
    dt: float,
    *,
    tunable: bool = False,
    single: bool = False,
    units: CommandUnits | None = None,
) -> dict[str, str]:
    """Return the files of a friction model in C, text by name; in single precision, of a subject with its constants."""
    places = tunable_of(subject.model).places if tunable else ()
    left = settled_subject(subject, places, single=single)
    return CFiles(left, name, source, dt, tunable, "float" if single else "double", units=units).files()


def _call(function: Function, names: tuple[str, ...], handed: dict[str, tuple[str, str]]) -> tuple[str, list[str]]:
    """Return a call with the arguments that the function still takes, and which ones these are."""
    needed = arguments_left(function, names)
    return f"{function.name}({', '.join(handed[name][0] for name in needed)})", needed

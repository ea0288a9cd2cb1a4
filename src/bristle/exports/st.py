"""Structured Text of a friction model or an operator: a function block with the functions it needs, and a self-test.

A block holds its state and its parameters; its functions are handed both in place. It gives the bits of bristle but for
what the language cannot see: the sign of a zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bristle.core.variable import unit_of, variables_of
from bristle.exports.described import Source, meaning_of, parameter_table, plain, version
from bristle.exports.printing import loops_of
from bristle.exports.st_code import Printer
from bristle.exports.st_helpers import WITHIN
from bristle.exports.st_parts import LREAL, REAL, Names, Pou, Variable, checked, commented, real_literal
from bristle.exports.st_parts import Array as ArrayPart
from bristle.exports.st_project import (
    FARTHEST,
    FARTHEST_OF_OPERATOR,
    Judged,
    Project,
    Tuned,
    answers,
    body_lines,
    bounds,
    call_text,
    requests,
    set_lines,
    walk_facts,
)
from bristle.exports.subject import COMMIT, COUNT, TRIAL, Subject, Walk, arguments_left, settled_subject, subject_of, walk_of
from bristle.exports.targets import Product, Request
from bristle.exports.tree import Array, Struct
from bristle.exports.tunable import CONSTANTS, TOLERANCE, single_note, tunable_of
from bristle.friction.resting import rest_rule
from bristle.prediction.drive_units import CommandUnits, command_units

TITLES = {False: "Friction of an axis", True: "Hysteresis operator"}
IN, OUT = {False: "position", True: "excitation"}, {False: "force", True: "response"}
OWN = (
    "position",
    "period",
    "restart",
    "clear",
    "force",
    "refused",
    "overflow",
    "begun",
    "prepared",
    "usable",
    "done",
    "last_position",
    "command",
    "place",
    "state",
    "memory",
    "motion",
    "parameters",
    "tried",
    "after",
)


@dataclass(frozen=True)
class StFiles:
    """How a friction model or an operator is written in Structured Text."""

    subject: Subject
    name: str
    source: Source
    dt: float
    tunable: bool = False
    single: bool = False
    units: CommandUnits | None = None

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        subject = self.subject
        around = (subject.state, subject.move, subject.parameters, Array(subject.memory_size))
        around += () if subject.is_operator else (subject.motion,)
        printer = Printer(subject.unit, self.name, around, REAL if self.single else LREAL)
        walk = walk_of(subject, self.dt)
        x = walk.positions(COUNT)
        outputs = subject.outputs(x) if subject.is_operator else subject.forces(x, self.dt)
        judged = Judged(self.name, outputs, self.single)
        arrays = (ArrayPart(f"{self.name}_Scales", len(walk.scales), LREAL), *judged.arrays())
        block, test = self._block(printer), self._selftest(printer, walk, judged)
        return Project(self.name, printer, self._facts(), block, test, arrays).files("st/head.st", self.source)

    @property
    def _bounds(self) -> dict[str, str]:
        return bounds(single=self.single, farthest=FARTHEST_OF_OPERATOR if self.subject.is_operator else FARTHEST)

    def _facts(self) -> dict[str, Any]:
        model, operator = self.subject.model, self.subject.is_operator
        return {
            "name": self.name,
            "version": version(),
            "title": plain(f"{TITLES[operator]}: {model.name}"),
            "description": commented(plain(model.component.description)) + ".",
            "rest": rest_rule(model),
            "facts": [commented(line) for line in self.source.lines],
            "count": COUNT,
            "operator": operator,
            "table": commented(parameter_table(model, self.source).rstrip()),
            "loops": loops_of(self.subject.unit, self.subject.memory_size),
            "unit_in": self._units()[0],
            "unit_out": self._units()[1],
            "input": IN[operator],
            "output": OUT[operator],
            "single": self.single,
            "tunable": self.tunable,
            "allowed": f"{TOLERANCE:g}",
            "result": OUT[operator],
            "several_places": False,
            **self._bounds,
        }

    def _units(self) -> tuple[str, str]:
        model, operator = self.subject.model, self.subject.is_operator
        entering, leaving = (model.component.input, model.component.output) if operator else ("length", "force")
        return plain(unit_of(entering, model.kind)), plain(unit_of(leaving, model.kind))

    # --- the function block ---------------------------------------------------------------------------------------

    def _block(self, printer: Printer) -> Pou:
        subject, operator, names = self.subject, self.subject.is_operator, Names(OWN)
        signals = {signal: names.of(signal, signal) for signal in subject.signals}
        tuned = Tuned.of(tunable_of(subject.model), names) if self.tunable else None
        tried = subject.trial.result
        assert isinstance(tried, Struct)
        trial = arguments_left(subject.trial, TRIAL[operator])
        commit = arguments_left(subject.commit, COMMIT) if subject.commits else []
        needed = {*trial, *commit} | ({"state"} if subject.state.fields else set())
        handed = {
            "dt": printer.narrowed("period"),
            "p": "parameters",
            "move": f"tried.{printer.field(tried, '_1')}",
            "input": printer.narrowed(IN[True]),
        }
        facts = {
            "input": IN[operator],
            "output": OUT[operator],
            "operator": operator,
            "start": self._start(printer, needed, tuned),
            "zero": printer.real(0.0),
            "ranges": [*tuned.ranges(printer)] if tuned else [],
            "tuned": [*tuned.lines("parameters", subject.parameters, printer)] if tuned and "p" in needed else [],
            "memory": subject.memory_size if "memory" in needed else 0,
            "motion": self._motion(printer, signals) if "motion" in trial else [],
            "trial": call_text(printer, subject.trial, [handed.get(name, name) for name in trial], "tried"),
            "tried": printer.widened(f"tried.{printer.field(tried, '_0')}"),
            "within": printer.helper(WITHIN, LREAL),
            "commit": call_text(printer, subject.commit, [handed.get(name, name) for name in commit], "after") if subject.commits else "",
            "state": bool(subject.state.fields),
            "signals": list(signals.values()),
            **self._bounds,
            "drive": "" if self.units is None else real_literal(self.units.effort.si),
        }
        held = {
            "state": ("state", subject.state),
            "memory": ("memory", Array(subject.memory_size)),
            "motion": ("motion", subject.motion),
            "p": ("parameters", subject.parameters),
        }
        own = [Variable(name, printer.type_name(kind)) for key, (name, kind) in held.items() if key in needed]
        own += [Variable("tried", printer.type_name(tried))]
        own += [Variable("after", printer.type_name(subject.state))] if subject.commits else []
        further = tuned.inputs(printer) if tuned else []
        variables = (*self._interface(signals, further), *own, *self._flags(memory=bool(facts["memory"])))
        return Pou("FUNCTION_BLOCK", self.name, "", variables, body_lines("st/block.st", facts))

    def _interface(self, signals: dict[str, str], further: list[Variable]) -> list[Variable]:
        kind, motion, operator = (self.subject.model.kind, variables_of(self.subject.motion.cls), self.subject.is_operator)
        unit_in, unit_out = self._units()
        if operator:
            first = [Variable("excitation", "LREAL", f"what drives the operator [{unit_in}]", "VAR_INPUT")]
        else:
            first = [
                Variable("position", "LREAL", f"where the axis is [{unit_in}]", "VAR_INPUT"),
                Variable("period", "LREAL", "time since the last call [s]", "VAR_INPUT"),
            ]
        for signal, name in signals.items():
            usual = real_literal(self.subject.usual[signal])
            first.append(Variable(name, "LREAL", meaning_of(motion[signal], kind), "VAR_INPUT", usual))
        answer = f"its answer [{unit_out}]" if operator else f"mean friction force of the last step [{unit_out}]"
        return [*first, *further, *requests("a virgin contact, nothing came yet"), *answers(OUT[operator], answer, self.units)]

    def _flags(self, *, memory: bool) -> list[Variable]:
        flags = ["prepared", "usable", "done"] if self.subject.is_operator else ["prepared", "begun", "usable", "done"]
        place = [Variable("place", "DINT")] if memory else []
        last = [] if self.subject.is_operator else [Variable("last_position", "LREAL")]
        return [*(Variable(name, "BOOL") for name in flags), *last, *place]

    def _start(self, printer: Printer, needed: set[str], tuned: Tuned | None) -> list[str]:
        subject, lines = self.subject, []
        if "p" in needed:
            skipped = tuned.tunable.places if tuned else ()
            lines += set_lines("parameters", subject.model.parameters, subject.parameters, printer, skipped)
        return [*lines, *set_lines("state", subject.virgin, subject.state, printer)]

    def _motion(self, printer: Printer, signals: dict[str, str]) -> list[str]:
        # A sum with 0.0 makes 0.0 of -0.0: a step of length 0 is one without a sign.
        v = f"{printer.narrowed('position - last_position')} / {printer.narrowed('period')} + {printer.real(0.0)}"
        if not self.single:
            v = "(position - last_position) / period + 0.0"
        values = {"v": v, "x": printer.narrowed("position")}
        values |= {
            name: printer.narrowed(signals[name]) if name in signals else printer.real(usual) for name, usual in self.subject.usual.items()
        }
        motion = self.subject.motion
        return [f"motion.{printer.field(motion, name)} := {values[name]};" for name, _ in motion.fields]

    # --- the self-test --------------------------------------------------------------------------------------------

    def _selftest(self, printer: Printer, walk: Walk, judged: Judged) -> Pou:
        operator = self.subject.is_operator
        too_far = f"{IN[operator]} := {real_literal(10.0 * FARTHEST)}"
        facts = (
            walk_facts(walk, printer, "count")
            | judged.facts()
            | {
                "input": IN[operator],
                "output": OUT[operator],
                "operator": operator,
                "last_call": too_far if operator else f"{too_far}, period := {real_literal(self.dt)}",
            }
        )
        variables, body = tuple(judged.variables()), body_lines("st/selftest.st", facts)
        return Pou("PROGRAM", f"{self.name}_selftest", "", variables, body)


def write(request: Request) -> Product:
    """Return the function block, its self-test, both as XML, and as files of TwinCAT 3."""
    checked(request.name)
    subject = subject_of(request.sampled, CONSTANTS if request.single else None)
    places = tunable_of(subject.model).places if request.tunable else ()
    units = None if subject.is_operator else command_units(request.axis, request.model.kind)
    left = settled_subject(subject, places, single=request.single)
    files = StFiles(left, request.name, request.source, request.dt, request.tunable, request.single, units).files()
    notes = ["the sign of a velocity of -0.0 is lost: the language cannot tell it from 0.0"]
    notes += [single_note(OUT[subject.is_operator])] if request.single else []
    return Product(dict(files), tuple(notes))

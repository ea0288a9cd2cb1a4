"""Structured Text of a friction model: a function block with the functions that it needs, a self-test, and XML of both.

A block holds its state and its parameters; its functions are handed both in place. It gives the bits of bristle but for
what the language cannot see: the sign of a zero.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from bristle.core.motion import Motion
from bristle.core.variable import unit_of, variables_of
from bristle.exports.c_code import wrapped
from bristle.exports.described import Source, parameter_table, plain, told
from bristle.exports.loops import loops_of
from bristle.exports.plcopen import project_text
from bristle.exports.rendering import rendered, version
from bristle.exports.st_code import RESULT, Printer
from bristle.exports.st_helpers import WITHIN, helpers_of
from bristle.exports.st_names import Names, real_literal, whole_literal
from bristle.exports.st_parts import INDENT, Pou, Variable, commented, part_text, used_of
from bristle.exports.st_parts import Array as ArrayPart
from bristle.exports.subject import COMMIT, TRIAL, Subject, taken
from bristle.exports.tree import Function
from bristle.exports.types import REAL, TRUTH, Array, Struct, Type
from bristle.exports.walk import COUNT, FACTOR, PART, RESTS, SEED, TERM, walk_of

__all__ = ["st_files", "total_of"]

FARTHEST, SHORTEST, LONGEST = 1e30, 1e-12, 1e12
PER_CYCLE = 20  # steps of the self-test in one cycle of a task
OWN = (
    "position", "period", "restart", "clear", "force", "refused", "overflow", "begun", "prepared", "usable", "done",
    "last_position", "place", "state", "memory", "motion", "parameters", "tried", "after",
)  # fmt: skip


@dataclass(frozen=True)
class StFiles:
    """How a friction model is written in Structured Text.

    Parameters
    ----------
    subject : Subject
        The model.
    name : str
        What the block is called, and what every other name begins with.
    source : Source
        Where the values come from.
    dt : float
        Time step of the self-test [s].
    """

    subject: Subject
    name: str
    source: Source
    dt: float

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        subject = self.subject
        printer = Printer(subject.unit, self.name, (subject.state, subject.motion, subject.move, subject.parameters,
                                                    Array(subject.memory_size)))  # fmt: skip
        types, functions = printer.parts()
        block, test, scales = self._block(printer), self._selftest(printer), self._scales()
        functions = [*helpers_of(printer.helpers, printer.helper, printer.integer), *functions]
        types = used_of(types, [*functions, block])
        head = rendered("st/head.st", self._facts())
        model = "\n".join([head, *(part_text(part) for part in (*types, *functions, block))])
        title = rendered("st/selftest_head.st", self._facts() | {"count": COUNT, "per_cycle": PER_CYCLE})
        selftest = "\n".join([title, part_text(scales), part_text(test)])
        return {
            f"{self.name}.st": model,
            f"{self.name}_selftest.st": selftest,
            f"{self.name}_plcopen.xml": project_text(self.name, head, [*types, scales], [*functions, block, test]),
        }

    def _facts(self) -> dict[str, Any]:
        model = self.subject.model
        return {
            "name": self.name, "version": version(), "title": plain(f"Friction of an axis: {model.name}"),
            "description": commented(plain(model.component.description)) + ".",
            "facts": [commented(line) for line in self.source.lines],
            "table": commented(parameter_table(model, self.source).rstrip()), "loops": loops_of(self.subject),
            "unit_x": unit_of("length", model.kind), "unit_force": unit_of("force", model.kind),
        }  # fmt: skip

    # --- the function block ---------------------------------------------------------------------------------------

    def _block(self, printer: Printer) -> Pou:
        subject, names = self.subject, Names(taken=OWN)
        signals = {signal: names.of(signal, signal) for signal in subject.signals}
        trial = taken(subject.trial, TRIAL[False])
        move = subject.trial.result
        assert isinstance(move, Struct)
        commits = bool(subject.state.fields) or subject.commit.writes
        commit = taken(subject.commit, COMMIT) if commits else []
        needed = {*trial, *commit}
        handed = {name: name for name in ("state", "memory", "motion")}
        handed |= {"dt": "period", "p": "parameters", "move": f"tried.{printer.field(move, '_1')}"}
        facts = {
            "start": self._start(printer, needed), "memory": subject.memory_size if "memory" in needed else 0,
            "motion": self._motion(printer, signals) if "motion" in trial else [],
            "trial": self._call(printer, subject.trial, [handed[name] for name in trial], "tried"),
            "tried": f"tried.{printer.field(move, '_0')}", "within": printer.helper(WITHIN),
            "commit": self._commit(printer, [handed[name] for name in commit]) if commits else [],
            "signals": list(signals.values()), "farthest": real_literal(FARTHEST), "shortest": real_literal(SHORTEST),
            "longest": real_literal(LONGEST),
        }  # fmt: skip
        body = _lines("st/block.st", facts)
        inside = [
            ("state", subject.state), ("memory", Array(subject.memory_size)), ("motion", subject.motion),
            ("parameters", subject.parameters), ("tried", move), ("after", subject.state),
        ]  # fmt: skip
        declared = needed | {"tried"} | ({"state"} if subject.state.fields else set())
        declared |= {"after"} if commits else set()
        declared |= {"parameters"} if "p" in needed else set()
        own = [Variable(name, printer.type_name(kind)) for name, kind in inside if name in declared]
        return Pou("FUNCTION_BLOCK", self.name, "", (*self._interface(signals), *own, *self._flags()), body)

    def _interface(self, signals: dict[str, str]) -> list[Variable]:
        kind, motion = self.subject.model.kind, variables_of(Motion)
        outside = []
        for signal, name in signals.items():
            usual = real_literal(Motion._field_defaults[signal])
            outside.append(Variable(name, "LREAL", told(motion[signal], kind), "VAR_INPUT", usual))
        effort = f"mean friction force of the last step [{unit_of('force', kind)}]"
        return [
            Variable("position", "LREAL", f"where the axis is [{unit_of('length', kind)}]", "VAR_INPUT"),
            Variable("period", "LREAL", "time since the last call [s]", "VAR_INPUT"), *outside,
            Variable("restart", "BOOL", "begin anew: a virgin contact, nothing came yet", "VAR_INPUT"),
            Variable("clear", "BOOL", "forget what was refused", "VAR_INPUT"),
            Variable("force", "LREAL", effort, "VAR_OUTPUT"),
            Variable("refused", "BOOL", "what came in was no finite number: the last force was held", "VAR_OUTPUT"),
            Variable("overflow", "BOOL", "the force was no finite number: the last one was held", "VAR_OUTPUT"),
        ]  # fmt: skip

    def _flags(self) -> list[Variable]:
        flags = [Variable(name, "BOOL") for name in ("prepared", "begun", "usable", "done")]
        place = [Variable("place", "DINT")] if self.subject.memory_size else []
        return [*flags, Variable("last_position", "LREAL"), *place]

    def _start(self, printer: Printer, needed: set[str]) -> list[str]:
        subject = self.subject
        lines = list(_set("parameters", subject.model.parameters, subject.parameters, printer)) if "p" in needed else []
        return lines + list(_set("state", subject.virgin, subject.state, printer))

    def _motion(self, printer: Printer, signals: dict[str, str]) -> list[str]:
        # A sum with 0.0 makes 0.0 of -0.0: a step of length 0 is one without a sign.
        values = {"v": "(position - last_position) / period + 0.0", "x": "position"}
        values |= {name: signals.get(name) or real_literal(usual) for name, usual in Motion._field_defaults.items()}
        motion = self.subject.motion
        return [f"motion.{printer.field(motion, name)} := {values[name]};" for name, _ in motion.fields]

    def _commit(self, printer: Printer, handed: list[str]) -> list[str]:
        state = bool(self.subject.state.fields)
        call = self._call(printer, self.subject.commit, handed, "after")
        return [f"done := {call};", *(["state := after;"] if state else [])]

    def _call(self, printer: Printer, function: Function, handed: list[str], result: str) -> str:
        pairs = [f"{name} := {value}" for name, value in zip(printer.body(function).arguments, handed, strict=True)]
        return f"{printer.function(function)}({', '.join([*pairs, f'{RESULT} := {result}'])})"

    # --- the self-test --------------------------------------------------------------------------------------------

    def _selftest(self, printer: Printer) -> Pou:
        walk = walk_of(self.subject, self.dt)
        forces = self.subject.forces(walk.positions(COUNT), self.dt)
        total, lost = total_of(forces.tolist())
        facts = {
            "seed": real_literal(SEED), "factor": real_literal(FACTOR), "term": real_literal(TERM), "rests": RESTS,
            "part": PART, "scales": [real_literal(scale) for scale in walk.scales], "count": COUNT,
            "per_cycle": PER_CYCLE, "dt": real_literal(self.dt), "floor": printer.helper("floor"),
            "whole": printer.integer, "total": real_literal(total), "lost": real_literal(lost),
            "last": real_literal(float(forces[-1])),
        }  # fmt: skip
        numbers = [Variable(name, "LREAL") for name in ("bits", "walked", "total", "lost", "following", "added")]
        variables = [
            Variable("done", "BOOL", "whether the walk has come to its end", "VAR_OUTPUT"),
            Variable("passed", "BOOL", "whether it gave the forces of bristle, to the bit", "VAR_OUTPUT"),
            Variable("axis", self.name), Variable("prepared", "BOOL"), Variable("count", "DINT"),
            Variable("each", "DINT"), *numbers, Variable("scales", f"{self.name}_Scales"),
        ]  # fmt: skip
        return Pou("PROGRAM", f"{self.name}_selftest", "", tuple(variables), _lines("st/selftest.st", facts))

    def _scales(self) -> ArrayPart:
        return ArrayPart(f"{self.name}_Scales", len(walk_of(self.subject, self.dt).scales), "LREAL")


def st_files(subject: Subject, name: str, source: Source, dt: float) -> dict[str, str]:
    """Return the files of a friction model in Structured Text, text by name."""
    return StFiles(subject, name, source, dt).files()


def total_of(forces: Iterable[float]) -> tuple[float, float]:
    """Return the sum of some numbers and what rounding took from it: another last place anywhere changes one of them.

    References
    ----------
    .. [1] D. E. Knuth, "The art of computer programming", vol. 2, 3rd ed., Addison-Wesley, 1997, sec. 4.2.2, theorem B.
    """
    total, lost = 0.0, 0.0
    for force in forces:
        following = total + force
        added = following - total
        lost = lost + ((total - (following - added)) + (force - added))
        total = following
    return total, lost


def _set(place: str, value: Any, kind: Struct, printer: Printer) -> Iterable[str]:
    """Give the lines that set a structure."""
    for (name, part), field in zip(kind.fields, value, strict=True):
        at = f"{place}.{printer.field(kind, name)}"
        if isinstance(part, Struct):
            yield from _set(at, field, part, printer)
        elif isinstance(part, Array):
            yield from (f"{at}[{i}] := {real_literal(float(number))};" for i, number in enumerate(field))
        else:
            yield f"{at} := {_literal(field, part)};"


def _literal(value: Any, kind: Type) -> str:
    if kind == TRUTH:
        return "TRUE" if value else "FALSE"
    return real_literal(float(value)) if kind == REAL else whole_literal(int(value))


def _lines(template: str, facts: dict[str, Any]) -> tuple[str, ...]:
    lines = [f"{INDENT}{line}" for line in rendered(template, facts).rstrip("\n").split("\n")]
    return tuple(part for line in lines for part in wrapped(line, line[: len(line) - len(line.lstrip())]))

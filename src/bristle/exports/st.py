"""Structured Text of a friction model or an operator: a function block with the functions it needs, and a self-test.

A block holds its state and its parameters; its functions are handed both in place. It gives the bits of bristle but for
what the language cannot see: the sign of a zero.
"""

from dataclasses import dataclass
from typing import Any

from bristle.core.variable import variables_of
from bristle.exports import st_project
from bristle.exports.described import Source, meaning_of, model_facts, plain
from bristle.exports.st_code import Printer
from bristle.exports.st_helpers import WITHIN
from bristle.exports.st_parts import LREAL, REAL, Names, Pou, Variable, checked, real_literal
from bristle.exports.st_project import FARTHEST, body_lines, call_text, set_lines
from bristle.exports.subject import COMMIT, COUNT, TRIAL, Subject, arguments_left, settled_subject, subject_of, walk_of
from bristle.exports.targets import Product, Request
from bristle.exports.tree import Array, Struct, Type
from bristle.exports.tunable import CONSTANTS, single_note, tunable_of
from bristle.prediction.drive_units import CommandUnits, command_units

IN, OUT = {False: "position", True: "excitation"}, {False: "force", True: "response"}
OWN = """
position period restart clear force refused overflow begun prepared usable done last_position command place state memory motion
parameters tried after
"""


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
        subject, operator = self.subject, self.subject.is_operator
        around = (subject.state, subject.move, subject.parameters, Array(subject.memory_size))
        around += () if operator else (subject.motion,)
        printer = Printer(subject.unit, self.name, around, REAL if self.single else LREAL)
        walk = walk_of(subject, self.dt)
        x = walk.positions(COUNT)
        judged = st_project.Judged(self.name, subject.outputs(x) if operator else subject.forces(x, self.dt), self.single)
        too_far = f"{IN[operator]} := {real_literal(10.0 * FARTHEST)}"
        facts = st_project.commented_facts(model_facts(subject, self.name, self.source, self.dt, single=self.single, tunable=self.tunable))
        facts |= {"unit_in": plain(facts["unit_x"]), "unit_out": plain(facts["unit_force"]), "input": IN[operator]}
        facts |= {"count": COUNT, "output": OUT[operator], "result": OUT[operator]}
        facts |= st_project.bounds(single=self.single, farthest=st_project.FARTHEST_OF_OPERATOR if operator else FARTHEST)
        block = self._block(printer, facts)
        last_call = {"last_call": too_far if operator else f"{too_far}, period := {real_literal(self.dt)}"}
        body = body_lines("st/selftest.st", facts | st_project.walk_facts(walk, printer, "count") | judged.facts() | last_call)
        test = Pou("PROGRAM", f"{self.name}_selftest", "", tuple(judged.variables()), body)
        return st_project.Project(self.name, printer, facts, block, test, judged.arrays(walk)).files("st/head.st", self.source)

    def _block(self, printer: Printer, facts: dict[str, Any]) -> Pou:
        subject, operator, names = self.subject, self.subject.is_operator, Names(OWN.split())
        signals = {signal: names.of(signal, signal) for signal in subject.signals}
        tuned = st_project.Tuned.of(tunable_of(subject.model), names) if self.tunable else None
        tried = subject.trial.result
        assert isinstance(tried, Struct)
        trial = arguments_left(subject.trial, TRIAL[operator])
        commit = arguments_left(subject.commit, COMMIT) if subject.commits else []
        needed = {*trial, *commit} | ({"state"} if subject.state.fields else set())
        memory = subject.memory_size if "memory" in needed else 0
        handed = {"dt": printer.narrowed("period"), "p": "parameters", "input": printer.narrowed(IN[True])}
        handed["move"] = f"tried.{printer.field(tried, '_1')}"
        places = tuned.tunable.places if tuned else ()
        start = [*set_lines("parameters", subject.model.parameters, subject.parameters, printer, places)] if "p" in needed else []
        committed = call_text(printer, subject.commit, [handed.get(name, name) for name in commit], "after") if subject.commits else ""
        start += set_lines("state", subject.virgin, subject.state, printer)
        facts = (
            facts
            | {"start": start, "zero": printer.real(0.0), "memory": memory, "state": bool(subject.state.fields), "commit": committed}
            | {"ranges": [*tuned.ranges(printer)] if tuned else [], "signals": list(signals.values())}
            | {"tuned": [*tuned.lines("parameters", subject.parameters, printer)] if tuned and "p" in needed else []}
            | {"motion": self._motion(printer, signals) if "motion" in trial else [], "within": printer.helper(WITHIN, LREAL)}
            | {"trial": call_text(printer, subject.trial, [handed.get(name, name) for name in trial], "tried")}
            | {"tried": printer.widened(f"tried.{printer.field(tried, '_0')}")}
            | {"drive": "" if self.units is None else real_literal(self.units.effort.si)}
        )
        held: dict[str, tuple[str, Type]] = {"state": ("state", subject.state), "memory": ("memory", Array(subject.memory_size))}
        held |= {"motion": ("motion", subject.motion), "p": ("parameters", subject.parameters)}
        own = [*(pair for key, pair in held.items() if key in needed), ("tried", tried)]
        own += [("after", subject.state)] if subject.commits else []
        meanings, unit_in, unit_out = variables_of(subject.motion.cls), facts["unit_in"], facts["unit_out"]
        meanings_of = ("where the axis is", "mean friction force of the last step")
        meanings_of = ("what drives the operator", "its answer") if operator else meanings_of
        variables = [
            Variable(IN[operator], "LREAL", f"{meanings_of[0]} [{unit_in}]", "VAR_INPUT"),
            *([] if operator else [Variable("period", "LREAL", "time since the last call [s]", "VAR_INPUT")]),
            *(
                Variable(name, "LREAL", meaning_of(meanings[key], subject.model.kind), "VAR_INPUT", real_literal(subject.usual[key]))
                for key, name in signals.items()
            ),
            *(tuned.inputs(printer) if tuned else []),
            *st_project.interface("a virgin contact, nothing came yet", OUT[operator], f"{meanings_of[1]} [{unit_out}]", self.units),
            *(Variable(name, printer.type_name(kind)) for name, kind in own),
            *(Variable(name, "BOOL") for name in ("prepared", "begun", "usable", "done") if name != "begun" or not operator),
            *([] if operator else [Variable("last_position", "LREAL")]),
            *([Variable("place", "DINT")] if memory else []),
        ]
        return Pou("FUNCTION_BLOCK", self.name, "", tuple(variables), body_lines("st/block.st", facts))

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


def write(request: Request) -> Product:
    """Return the function block, its self-test, and both as XML."""
    checked(request.name)
    subject = subject_of(request.sampled, CONSTANTS if request.single else None)
    places = tunable_of(subject.model).places if request.tunable else ()
    units = None if subject.is_operator else command_units(request.axis, request.model.kind)
    left = settled_subject(subject, places, single=request.single)
    files = StFiles(left, request.name, request.source, request.dt, request.tunable, request.single, units).files()
    notes = ["the sign of a velocity of -0.0 is lost: the language cannot tell it from 0.0"]
    notes += [single_note(OUT[subject.is_operator])] if request.single else []
    return Product(dict(files), tuple(notes))

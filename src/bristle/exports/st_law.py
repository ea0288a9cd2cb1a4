"""Structured Text of a control law: a function block with the functions that it needs, and a self-test."""

from dataclasses import dataclass
from typing import Any

from bristle.exports import st_project
from bristle.exports.described import Source, plain
from bristle.exports.law import Law
from bristle.exports.law_described import INPUTS, PER_VELOCITY, law_facts, law_walk
from bristle.exports.st_code import Printer
from bristle.exports.st_helpers import WITHIN
from bristle.exports.st_parts import LREAL, REAL, Names, Pou, Variable, checked, real_literal
from bristle.exports.st_parts import Array as ArrayPart
from bristle.exports.st_project import FARTHEST, Tuned, body_lines, call_text, interface, set_lines
from bristle.exports.subject import COUNT
from bristle.exports.tree import Array, Struct
from bristle.exports.tunable import settled_law, tunable_law
from bristle.prediction.drive_units import command_units

OWN = """
restart clear effort command refused overflow parameters lasting now memory prepared begun usable done place
"""
ALONG_WALK = {"velocity": "speed", "acceleration": f"{PER_VELOCITY!r} * speed", "position": "places[count]"}


@dataclass(frozen=True)
class StLawFiles:
    """How a control law is written in Structured Text."""

    law: Law
    name: str
    source: Source

    def files(self) -> dict[str, str]:
        """Return the text of each file by its name."""
        law, facts = self.law, st_project.commented_facts(law_facts(self.law, self.name, self.source))
        around = (*law.types, Array(law.memory_size), Array(law.samples_ahead))
        facts |= {"output": "effort", "operator": False, "unit_in": facts["unit_x"], "count": COUNT}
        facts |= st_project.bounds(single=law.single, farthest=st_project.FARTHEST_OF_LAW)
        printer = Printer(law.unit, self.name, around, REAL if law.single else LREAL)
        block = self._block(printer, facts)
        test, arrays = self._selftest(printer, facts)
        return st_project.Project(self.name, printer, facts, block, test, arrays).files("st/law_head.st", self.source)

    def _block(self, printer: Printer, facts: dict[str, Any]) -> Pou:
        law, (lasting, p) = self.law, self.law.types
        units = command_units(law.variant.axis, law.variant.controller.kind)
        now = law.entry.result
        assert isinstance(now, Struct)
        needed = [parameter.name for parameter in law.entry.parameters]
        ahead_names = [fed["name"] for fed in facts["inputs"] if fed["several"]]
        arrays = ahead_names if law.single else []
        handed = {name: printer.narrowed(name) for name in law.inputs if name not in ahead_names}
        handed |= {"dt": printer.real(law.dt), "p": "parameters"} | {name: f"narrowed_{name}" for name in arrays}
        tuned = (
            Tuned.of(tunable_law(law), Names([*OWN.split(), *INPUTS, *(f"narrowed_{name}" for name in INPUTS)])) if law.tunable else None
        )
        memory = law.memory_size if "memory" in needed else 0
        skipped = tuned.tunable.places if tuned else ()
        remembered = enumerate(law.memory.tolist()) if memory else ()
        start = [*set_lines("parameters", law.p, p, printer, skipped), *set_lines("lasting", law.lasting, lasting, printer)]
        of_block = (
            {"divisor": "" if units is None else real_literal(units.effort.si), "start": start, "memory": memory}
            | {"within": printer.helper(WITHIN, LREAL), "zero": printer.real(0.0), "ranges": [*tuned.ranges(printer)] if tuned else []}
            | {"tuned": [*tuned.lines("parameters", p, printer)] if tuned else [], "after": f"now.{printer.field(now, '_1')}"}
            | {"narrowed": [f"narrowed_{name}[place] := {printer.narrowed(f'{name}[place]')};" for name in arrays]}
            | {"remembered": [f"memory[{at}] := {printer.real(number)};" for at, number in remembered if number]}
            | {"command": call_text(printer, law.entry, [handed.get(name, name) for name in needed], "now")}
            | {"commanded": printer.widened(f"now.{printer.field(now, '_0')}")}
        )
        own = [("parameters", p), ("lasting", lasting), ("now", now)]
        own += [("memory", Array(memory))] if memory else []
        own += [(f"narrowed_{name}", Array(law.samples_ahead)) for name in arrays]
        ahead = printer.array(law.samples_ahead, LREAL)
        variables = [
            *(
                Variable(fed["name"], ahead if fed["several"] else "LREAL", plain(f"{fed['told']} [{fed['unit']}]"), "VAR_INPUT")
                for fed in facts["inputs"]
            ),
            *(tuned.inputs(printer) if tuned else []),
            *interface("the law takes over the desired motion", "effort", f"what the drive is to give [{facts['unit_force']}]", units),
            *(Variable(name, printer.type_name(kind)) for name, kind in own),
            *(Variable(name, "BOOL") for name in ("prepared", "begun", "usable", "done")),
            *([Variable("place", "DINT")] if memory or ahead_names else []),
        ]
        return Pou("FUNCTION_BLOCK", self.name, "", tuple(variables), body_lines("st/law.st", facts | of_block))

    def _selftest(self, printer: Printer, facts: dict[str, Any]) -> tuple[Pou, tuple[ArrayPart, ...]]:
        walk, positions, efforts = law_walk(self.law, COUNT)
        judged = st_project.Judged(self.name, efforts, self.law.single)
        of_test = {"told": ", ".join(f"{name} := {ALONG_WALK.get(name, name)}" for name in self.law.inputs), "positions": positions}
        of_test |= {"per_velocity": real_literal(PER_VELOCITY), "last_call": f"measured := {real_literal(10.0 * FARTHEST)}"}
        body = body_lines("st/law_selftest.st", facts | st_project.walk_facts(walk, printer, "each") | judged.facts() | of_test)
        arrays_ahead = [fed["name"] for fed in facts["inputs"] if fed["several"]]
        variables = [
            *judged.variables(),
            *([Variable("ahead", "DINT")] if arrays_ahead else []),
            *(Variable(name, "LREAL") for name in ("speed", "measured")),
            *(Variable(name, printer.array(self.law.samples_ahead, LREAL)) for name in arrays_ahead),
            Variable("places", f"{self.name}_Places"),
        ]
        arrays = judged.arrays(walk, ArrayPart(f"{self.name}_Places", positions, LREAL))
        return Pou("PROGRAM", f"{self.name}_selftest", "", tuple(variables), body), arrays


def st_law_files(law: Law, name: str, source: Source) -> dict[str, str]:
    """Return the files of a control law in Structured Text, text by name."""
    checked(name)
    return StLawFiles(settled_law(law), name, source).files()

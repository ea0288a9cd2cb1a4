"""What the command line and the lab do alike: look at a log, design a motion, write a model for another world."""

from __future__ import annotations

import shlex
from collections.abc import Collection
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from bristle.core.axis import Axis
from bristle.core.content import SIZE_LIMIT, Content, Readable, content_of
from bristle.core.diagnostic import Diagnostic
from bristle.core.edge import among, amount
from bristle.core.errors import InputError
from bristle.core.experiment import RESTS
from bristle.core.variable import Variable
from bristle.files.proposal import Proposal, propose_axis
from bristle.files.results import SUMMARY
from bristle.files.summary import as_json, provenance
from bristle.files.toml import TOML_LIMIT
from bristle.files.user_model import origins_of_code
from bristle.logs.readers import read_table
from bristle.logs.summary import Summary, summary_of, summary_of_columns
from bristle.logs.tables import content_of_log

if TYPE_CHECKING:
    from bristle.core.contracts import Model
    from bristle.core.experiment import Variant
    from bristle.excitation import Excitation
    from bristle.exports.targets import Product, Target
    from bristle.files.results import Results
    from bristle.logs.log import Log
    from bristle.logs.passages import Passage
    from bristle.logs.table import Table


class Inspected(NamedTuple):
    """What is in a log."""

    summary: dict[str, Any]
    content: Content
    table: Table
    axis: Axis | None
    proposal: Proposal | None
    log: Log | None
    passages: tuple[Passage, ...]

    def write(self, folder: Results, command: str) -> None:
        """Write the numbers, and the report of a log that can be used, into a folder of results."""
        from bristle.report.log import log_report
        from bristle.report.results import write_report

        if self.log is None:
            folder.write(SUMMARY, as_json(self.summary))
            return
        page = log_report(
            self.log,
            self.passages,
            name=self.axis.name if self.axis else Path(self.summary["file"]).stem,
            command=command,
            provenance=self.summary["provenance"],
            diagnostics=self.summary["diagnostics"],
        )
        write_report(folder, page, self.summary)


def inspect_log(log: Readable, axis: Axis | None = None, *, size_limit: int = SIZE_LIMIT) -> Inspected:
    """Return what is in a log; without an axis, the axis file that its columns speak of."""
    from bristle.report.messages import as_data

    content, proposal = content_of_log(log, limit=size_limit), None
    if axis is None:
        with suppress(InputError):  # no column can be the position
            proposal = propose_axis(content, size_limit=size_limit)
    axis = proposal.axis if proposal else axis
    table = proposal.table if proposal else read_table(content, axis and axis.table, size_limit=size_limit)
    looked_at = _looked_at(table, axis, proposal.unknown if proposal else ())
    diagnostics = [Diagnostic(**entry, kind=looked_at.data["kind"]) for entry in looked_at.data["diagnostics"]]
    if proposal is not None and {"columns.position.unit", "columns.velocity.unit"} & set(proposal.missing):
        # Of a size that nobody knows nothing can be said.
        diagnostics = [
            diagnostic for diagnostic in diagnostics if not (diagnostic.code == "unit_suspect" and "speed" in diagnostic.numbers)
        ]
    summary = looked_at.data | {"diagnostics": as_data(diagnostics), "proposal": {"text": None, "missing": []}}
    if proposal is not None:
        summary["proposal"] = {"text": proposal.text, "missing": list(proposal.missing)}
        summary["notes"] = [*proposal.notes, *summary["notes"]]
    return Inspected(summary, content, table, axis, proposal, looked_at.log, looked_at.passages)


def _looked_at(table: Table, axis: Axis | None, unknown: Collection[str]) -> Summary:
    """Return what is in a table; of channels in a unit that is not known nothing is said in SI."""
    if axis is None or not unknown:
        return summary_of(table, axis)
    usable = {name: column for name, column in axis.columns.items() if name not in unknown}
    if "time" in unknown or "position" in unknown or not {"position", "velocity"} & set(usable):
        return summary_of_columns(table)
    return summary_of(table, replace(axis, columns=usable))


FILES = {"motion": "motion.csv", "moves": "moves.csv", "program": "motion.nc", "axis": "axis.toml"}
"""What the files of a motion are called, by what they are."""


class DesignedMotion(NamedTuple):
    """A motion to run on an axis, and what was read for it."""

    excitation: Excitation
    axis_file: Content
    model_file: Content | None
    command: str

    @property
    def provenance(self) -> dict[str, str]:
        """Versions, files, checksums."""
        code = origins_of_code([self.excitation.prior.friction.component])
        return provenance(self.command, axis=self.axis_file, model=self.model_file, code=code)

    def next_command(self, axis: str) -> str:
        """Return the command that identifies the log of the motion, with the axis file of this name."""
        rehearsal = self.excitation.rehearsal
        model = rehearsal.identification.best.name if rehearsal else self.excitation.prior.friction.name
        presliding = any(piece.purpose == "presliding" for piece in self.excitation.motion.pieces)
        if presliding and model != "maxwell_slip":
            # Loops inside loops tell whether the contact remembers more than one force.
            model += ",maxwell_slip"
        return shlex.join(["bristle", "identify", "LOG", "--axis", axis, "--model", model, "--out", "results"])

    def summary(self, files: dict[str, str], identify: str) -> dict[str, Any]:
        """Return the motion in numbers, with the names of its files and the command that comes next."""
        from bristle.report.excitation import excitation_summary

        return excitation_summary(self.excitation, files=files, identify=identify, provenance=self.provenance)

    def write(self, folder: Results, identify: str) -> None:
        """Write the motion, its moves and its report into a folder of results, with the command that comes next."""
        from bristle.excitation.motion import moves_of
        from bristle.files.motion import gcode_of, moves_table, write_motion
        from bristle.report.excitation import excitation_report
        from bristle.report.results import write_report

        motion, axis = self.excitation.motion, self.excitation.axis
        page = excitation_report(self.excitation, command=self.command, identify=identify, provenance=self.provenance)
        signals = {name: getattr(motion, name) for name in ("time", "position", "velocity", "acceleration")}
        write_motion(folder / FILES["motion"], axis, signals)
        moves, left_out = moves_of(motion)
        folder.write(FILES["moves"], moves_table(moves, axis))
        folder.write(FILES["program"], gcode_of(moves, axis, left_out))
        folder.write(FILES["axis"], self.axis_file.data)
        write_report(folder, page, self.summary(FILES, identify))


def designed_motion(axis_file: Content, *, command: str, model_file: Content | None = None, **options: Any) -> DesignedMotion:
    """Return the motion to run on an axis."""
    from bristle.excitation import excite

    return DesignedMotion(excite(axis_file, model=model_file, **options), axis_file, model_file, command)


class ExportedModel(NamedTuple):
    """Files of an export, what is in them, and where it comes from."""

    target: str
    product: Product
    name: str
    provenance: dict[str, str]
    beside: tuple[str, ...] = ()

    @property
    def summary(self) -> dict[str, Any]:
        """What was written, as ``summary.json`` holds it."""
        effect = None if self.product.effect is None else self.product.effect.as_data()
        notes = [*self.product.notes, *self.beside]
        about = {"target": self.target, "model": self.name, "files": list(self.product.files)}
        return about | {"notes": notes, "effect": effect, "provenance": self.provenance}

    def write(self, folder: Results) -> None:
        """Write the files and the summary into a folder of results."""
        for file_name, content in self.product.files.items():
            folder.write(file_name, content)
        folder.write(SUMMARY, as_json(self.summary))


def export_model_file(
    model: Path,
    to: str | Target,
    *,
    command: str,
    name: str | None = None,
    step: str | float | None = None,
    tunable: bool = False,
    float32: bool = False,
    axis: Any = None,
    speed: str | None = None,
    points: int = 20,
    log: Any = None,
    rest: str | None = None,
    accept_harm: bool = False,
    allow_code: bool = False,
) -> ExportedModel:
    """Return a friction model or an operator, from its file, as files for another world."""
    from bristle.exports.described import Source
    from bristle.exports.face import NAME, PERIOD, STEP
    from bristle.exports.targets import Request
    from bristle.exports.writing import files_for, name_for, target_named
    from bristle.files.axis import read_axis
    from bristle.logs import read_log

    target, file, beside = target_named(to), content_of(model, limit=TOML_LIMIT), model.parent / "axis.toml"
    plant, exported, facts = _read(file, allow_code=allow_code)
    code = origins_of_code([exported.component]) if exported.component.family == "friction" else ()
    described = read_axis(beside if axis is None else axis) if axis is not None or beside.is_file() else None
    recorded = None if log is None else read_log(log, described)
    source = provenance(command, model=file, log=recorded, code=code, target=origins_of_code([target]))
    fastest = facts["treatment"].get("velocity_max", 0.0)
    if speed is not None:
        fastest = amount(Variable("length/time", "largest speed", min=0.0), exclusive=True)(speed, "--speed", exported.kind)
    loop, remarks = _loop_beside(model.parent / "experiment.toml", exported, described)
    request = Request(
        exported,
        name_for(name or NAME),
        PERIOD(STEP if step is None else step, "--step", None),
        Source(source, facts["uncertainty"]),
        tunable,
        float32,
        described,
        float(fastest),
        points,
        1.0 if plant is None else float(plant.values.get("M", 1.0)),
        plant,
        recorded,
        facts,
        "" if rest is None else among(*RESTS)(rest, "--rest", None),
        loop,
    )
    return ExportedModel(target.name, files_for(target, request, accept_harm=accept_harm), exported.name, source, remarks)


def _read(file: Content, *, allow_code: bool) -> tuple[Model | None, Model, dict[str, Any]]:
    """Return plant, friction model or operator, and what a model file knows of them."""
    from bristle.files.model import read_model
    from bristle.files.operator import holds_operator, read_operator
    from bristle.hysteresis.beside_constant import with_constant
    from bristle.testing import admit

    if holds_operator(file):
        operator, offset, _ = read_operator(file)
        return None, with_constant(operator, offset), {"uncertainty": {}, "treatment": {}}
    plant, exported, facts = read_model(file, allow_code=allow_code)
    admit(exported)
    return plant, exported, facts


def _loop_beside(file: Path, model: Model, axis: Axis | None) -> tuple[Variant | None, tuple[str, ...]]:
    """Return the loop of the experiment that an identification left beside a model file, and why it cannot be read."""
    from bristle.files.experiment import read_experiment

    if axis is None or axis.controller is None or not file.is_file():
        return None, ()
    try:
        variants = read_experiment(file).variants
    except InputError as error:
        return None, (f"the loop of {file.name} is not simulated: {error}",)
    return next((variant for variant in variants if variant.feedforward.friction == model), None), ()

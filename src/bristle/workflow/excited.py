"""`designed_motion`: the motion to run on an axis, with its report, as a folder that a machine can be fed from."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bristle.core.content import Content
from bristle.core.lazy import cached_property
from bristle.excitation import Excitation, excite
from bristle.files.summary import provenance
from bristle.files.user_model import origins_of_code

if TYPE_CHECKING:
    from bristle.files.results import Results

__all__ = ["FILES", "DesignedMotion", "designed_motion"]

FILES = {"motion": "motion.csv", "moves": "moves.csv", "program": "motion.nc", "axis": "axis.toml"}
"""What the files of a motion are called, by what they are."""


@dataclass(frozen=True, eq=False)
class DesignedMotion:
    """A motion to run on an axis, and what was read for it."""

    excitation: Excitation
    axis_file: Content
    model_file: Content | None
    command: str

    @cached_property
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
        from bristle.report.excitation import excitation_report
        from bristle.report.results import write_motion_folder

        page = excitation_report(self.excitation, command=self.command, identify=identify, provenance=self.provenance)
        summary = self.summary(FILES, identify)
        write_motion_folder(folder, self.excitation, axis_file=self.axis_file, report=page, summary=summary)


def designed_motion(axis_file: Content, *, command: str, model_file: Content | None = None, **options: Any) -> DesignedMotion:
    """Return the motion to run on an axis."""
    return DesignedMotion(excite(axis_file, model=model_file, **options), axis_file, model_file, command)

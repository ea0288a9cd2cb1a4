"""The motion to run on an axis, designed before there is a log."""

from __future__ import annotations

from pathlib import Path

from bristle.core.content import Content
from bristle.core.dimensions import KINDS, kind_called, unit_of
from bristle.files.toml import read_toml
from bristle.server.tasks.axis_form import edited
from bristle.server.tasks.errand import Answer, Errand, command, zipped
from bristle.server.tasks.thinned import thinned

__all__ = ["ARCHIVE", "excite"]

ARCHIVE = "motion.zip"
COLUMNS = {"time": "time", "position": "length", "reference": "length", "effort": "force"}
"""What a log of the motion is taken to hold, where nobody has said it."""
EMPTY = 'schema = 1\nname = "axis"\n'


def excite(errand: Errand) -> Answer:
    """Leave a motion as an archive of files, and return what its log will tell."""
    from bristle.files.results import results_folder
    from bristle.report.excitation import outlook_table, piece_table
    from bristle.workflow.excited import designed_motion

    text = _with_columns(edited(errand.axis_text or EMPTY, errand.options.get("edits") or {}, errand.axis_label))
    axis_file = Content(Path(errand.axis_label), text.encode())
    duration, purposes = errand.text("duration", "60 s"), errand.text("purposes")
    words = ["excite", errand.axis_label, "--out", "motion", "--duration", duration]
    words += ["--for", purposes] if purposes else []
    travel = errand.text("travel") or None
    words += ["--travel", travel] if travel else []
    with errand.interruptible():
        motion = designed_motion(
            axis_file, command=command(*words), duration=duration, travel=travel, purposes=purposes or None, progress=errand.report
        )
    following = motion.next_command("motion/axis.toml")
    with results_folder(errand.folder / "motion") as folder:
        motion.write(folder, following)
    zipped(errand.folder / "motion", errand.folder / ARCHIVE)
    excitation = motion.excitation
    data = {
        "pieces": piece_table(excitation).without_empty_columns()._asdict(),
        "notes": excitation.notes,
        "next": following,
        "outlook": outlook_table(excitation)._asdict() if excitation.rehearsal is not None else None,
        "kind": excitation.axis.kind,
        "curve": thinned(excitation.motion.time, excitation.motion.position),
    }
    return {"duration": float(excitation.motion.time[-1])}, data


def _with_columns(text: str) -> str:
    """Return an axis file that says what the log of the motion holds: by usual names and in SI, if nobody did."""
    tables = read_toml(text.encode()).data
    if "columns" in tables:
        return text
    named = kind_called(tables.get("kind"))
    kind = named if named in KINDS else KINDS[0]  # what is none is refused where the file is read
    entries = {f"columns.{name}.column": name for name in COLUMNS}
    return edited(text, entries | {f"columns.{name}.unit": unit_of(of, kind) for name, of in COLUMNS.items()})

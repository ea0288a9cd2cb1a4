"""The motion to run on an axis, designed before there is a log."""

from __future__ import annotations

from pathlib import Path

from bristle.core.content import Content
from bristle.server.tasks.axis_form import edited
from bristle.server.tasks.errand import Answer, Errand, command, zipped
from bristle.server.tasks.thinned import thinned

__all__ = ["ARCHIVE", "excite"]

ARCHIVE = "motion.zip"
EMPTY = 'schema = 1\nname = "axis"\n'


def excite(errand: Errand) -> Answer:
    """Leave a motion as an archive of files, and return what its log will tell."""
    from bristle.files.results import results_folder
    from bristle.report.excitation import outlook_table, piece_table
    from bristle.workflow.excited import designed_motion

    text = edited(errand.axis_text or EMPTY, errand.options.get("edits") or {})
    axis_file = Content(Path(errand.axis_label), text.encode())
    duration, purposes = errand.text("duration", "60 s"), errand.text("purposes")
    words = ["excite", errand.axis_label, "--out", "motion", "--duration", duration]
    words += ["--for", purposes] if purposes else []
    with errand.interruptible():
        motion = designed_motion(
            axis_file, command=command(*words), duration=duration, purposes=purposes or None, progress=errand.report
        )
    following = motion.next_command("motion/axis.toml")
    with results_folder(errand.folder / "motion") as folder:
        motion.write(folder, following)
    zipped(errand.folder / "motion", errand.folder / ARCHIVE)
    excitation = motion.excitation
    data = {
        "pieces": piece_table(excitation).without_empty_columns()._asdict(), "notes": excitation.notes,
        "next": following,
        "outlook": outlook_table(excitation)._asdict() if excitation.rehearsal is not None else None,
        "kind": excitation.axis.kind, "curve": thinned(excitation.motion.time, excitation.motion.position),
    }  # fmt: skip
    return {"duration": float(excitation.motion.time[-1])}, data

"""The identified model as files for a drive, a controller or a simulation."""

from __future__ import annotations

from bristle.core.errors import InputError
from bristle.exports.face import NAME
from bristle.server.tasks.errand import Answer, Errand, command, zipped

__all__ = ["ARCHIVE", "export"]

ARCHIVE = "export.zip"
POINTS = 20


def export(errand: Errand) -> Answer:
    """Leave the model as an archive of files for a target, and return what the target loses."""
    from bristle.files.results import results_folder
    from bristle.workflow.exported import export_model_file

    if errand.results is None:
        raise InputError("is missing", path="model", mend="Identify first")
    target, name = errand.text("target", "table"), errand.text("name") or NAME
    points = errand.count("points", POINTS)
    errand.report(0.2, f"writing for {target}")
    axis = errand.axis_file if errand.axis_text else None
    words = ["export", "results", "--to", target, "--out", f"{name}_{target}", "--name", name]
    words += ["--axis", errand.axis_label] if axis else []
    words += ["--points", str(points)] if points != POINTS else []
    exported = export_model_file(errand.results / "model.toml", target, command=command(*words), name=name, axis=axis, points=points)
    with results_folder(errand.folder / "export") as folder:
        exported.write(folder)
    zipped(errand.folder / "export", errand.folder / ARCHIVE)
    texts = [(file, text) for file, text in exported.product.files.items() if isinstance(text, str)]
    facts = {"target": target, "file": f"{name}_{target}.zip"}
    data = {"notes": exported.summary["notes"], "files": exported.summary["files"], "shown": _preview(texts)}
    return facts, data


def _preview(texts: list[tuple[str, str]]) -> dict[str, str] | None:
    """Return the first short text, which a person may want to see before it is loaded."""
    short = [(file, text) for file, text in texts if len(text) < 6000]
    return {"file": short[0][0], "text": short[0][1]} if short else None

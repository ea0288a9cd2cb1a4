"""``bristle lab``: friction to be touched, as one page."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import AllowCode, AxisFile, Json, SizeLimit, bytes_asked
from bristle.cli.terminal import complain, progress

if TYPE_CHECKING:
    from bristle.core import Model
    from bristle.lab.replay import Replay

__all__ = ["EXAMPLE", "lab"]

EXAMPLE = """Example:
  bristle lab results --out lab.html
  bristle lab --serve"""


def lab(
    context: typer.Context,
    *,
    model: Annotated[
        Path | None, typer.Argument(metavar="[MODEL.toml|RESULTS]", help="A model file, or results of identify with one.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="LAB.html", help="Write the page into this new file.")] = None,
    serve: Annotated[bool, typer.Option("--serve", help="Open the main job in a browser instead: from a log to the drive.")] = False,
    port: Annotated[int, typer.Option("--port", metavar="PORT", help="Where to serve; 0 for any that is free.")] = 0,
    no_open: Annotated[bool, typer.Option("--no-open", help="Print the address, and open no browser.")] = False,
    log: Annotated[Path | None, typer.Option("--log", metavar="LOG", help="A log, whose motion the models are led along.")] = None,
    axis: AxisFile = None,
    size_limit: SizeLimit = None,
    allow_code: AllowCode = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a page of the lab that is there already.")] = False,
    as_json: Json = False,
) -> None:
    """Write a page on which friction can be touched.

    Parameters are moved, and loops, curves and stick-slip move with them. The page holds every friction model with its
    physics, and first of all the one that is given: with its slots, its values and how sure they are. With results of
    identify, or with --log, it holds the recorded motion too. One file that asks for nothing, for any browser, disk,
    mail or host. LAB.html#selftest tells whether a browser computes the bits of Python.

    With --serve, identification in the browser, on this machine and for it alone: drop logs, see columns, units and
    signs, check, identify, compensate, export, or design the motion to record. Ctrl-C ends it.
    """
    from bristle.core import InputError

    if serve:
        unfit = {"MODEL.toml": model, "--out": out, "--log": log, "--axis": axis, "--force": force, "--json": as_json}
        _serve(unfit, port=port, opens=not no_open, size_limit=size_limit)
        return
    out = _page_named(out, port=port, no_open=no_open)
    from bristle.core.content import content_of
    from bristle.files.single import sealed, write_whole
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.files.toml import TOML_LIMIT
    from bristle.files.user_model import origins_of_code
    from bristle.lab import lab_page

    file = model / "model.toml" if model is not None and model.is_dir() else model
    _refuse_taken(out, file, force=force)
    if (log or axis) and file is None:
        raise InputError("is read with a model", path="--log" if log else "--axis", mend="Name a model file, or results of identify")
    with progress("computing"):
        inputs: dict[str, Any] = {}
        content, code, recorded = None, (), {}
        if file is not None:
            content = content_of(file, limit=TOML_LIMIT)
            friction, inputs, plant, treatment = _read(content, allow_code=allow_code)
            inputs |= {"model": friction, "source": file.name}
            code = origins_of_code([friction.component])
            if log is not None:
                beside = file.parent / "axis.toml"
                described = axis or (beside if beside.is_file() else None)
                inputs["replay"], recorded = _replay(log, described, plant, friction, treatment, bytes_asked(size_limit))
            elif model is not None and model.is_dir():
                inputs["replay"] = _replay_of_results(model)
        source = provenance(context.obj, model=content, code=code, **recorded)
        page = sealed(lab_page(**inputs, provenance=source))
    write_whole(out, page, new=not force)
    if as_json:
        sys.stdout.write(json_text(_summary(out, page, inputs) | {"provenance": source}))
    complain(f"wrote {out}; open it in a browser")


def _summary(out: Path, page: str, inputs: dict[str, Any]) -> dict[str, Any]:
    """Return in numbers what stands on a page."""
    from bristle.friction import MODELS
    from bristle.lab.page import FIRST

    replay = inputs.get("replay")
    return {
        "file": out.name,
        "size": len(page.encode()),
        "model": inputs["model"].name if inputs else FIRST,
        "models": list(MODELS),
        "points_of_log": 0 if replay is None else replay.time.size,
    }


def _serve(unfit: dict[str, Any], *, port: int, opens: bool, size_limit: str | None) -> None:
    """Serve the lab until it is interrupted, which is how it ends."""
    from bristle.core import InputError
    from bristle.server import Limits, serve

    option = next((option for option, value in unfit.items() if value), None)
    if option is not None:
        raise InputError("does not go with --serve", path=option, mend="Leave it away: files are dropped on the page")
    largest = bytes_asked(size_limit)
    limits = Limits(file_size=largest, total_size=4 * largest)
    with suppress(KeyboardInterrupt):
        serve(port=port, opens=opens, limits=limits, announce=_announce)
    complain("the lab is closed")


def _page_named(out: Path | None, *, port: int, no_open: bool) -> Path:
    """Return the page to write; what serves is refused beside it."""
    from bristle.core import InputError

    if port or no_open:
        raise InputError("belongs to --serve", path="--port" if port else "--no-open", mend="Add --serve")
    if out is None:
        raise InputError("is missing", path="--out", mend="Name the page to write, or serve: bristle lab --serve")
    return out


def _announce(address: str) -> None:
    sys.stdout.write(f"{address}\n")
    sys.stdout.flush()
    complain("open this address in a browser of this machine; who has it can use the lab. Ctrl-C ends it")


def _replay(
    log: Path, axis_file: Path | None, plant: Model | None, friction: Model, treatment: dict[str, Any], limit: int
) -> tuple[Replay, dict[str, Any]]:
    """Return a log as a motion to be replayed, and what it was made from."""
    from bristle.core import InputError
    from bristle.core.content import content_of
    from bristle.files.axis import read_axis
    from bristle.files.toml import TOML_LIMIT
    from bristle.lab.replay import replay_of_log
    from bristle.logs import read_log

    content = content_of(axis_file, limit=TOML_LIMIT) if axis_file else None
    axis = read_axis(content) if content else None
    recorded = read_log(log, axis, size_limit=limit)
    if recorded.kind != friction.kind:
        raise InputError("model and log are of different kinds of axis", path=str(log), value=recorded.kind, allowed=friction.kind)
    return replay_of_log(recorded, axis, plant, treatment), {"log": recorded, "axis": content}


def _replay_of_results(folder: Path) -> Replay | None:
    """Return the rows that a model was fitted to, where its results hold them."""
    from bristle.files.arrays import read_arrays
    from bristle.identification.result import Traces
    from bristle.lab.replay import replay_of_traces

    arrays = read_arrays(folder, "traces")
    if not arrays:
        return None
    traces = Traces(**arrays)
    return replay_of_traces(traces.time, traces.velocity, traces.friction)


def _read(content: Any, *, allow_code: bool) -> tuple[Model, dict[str, Any], Model | None, dict[str, Any]]:
    """Return a friction model; how sure it is, what it moves, how fast it was seen; its plant, how it was treated."""
    from bristle.files.model import read_model
    from bristle.testing import admit

    plant, friction, facts = read_model(content, allow_code=allow_code)
    admit(friction)
    mass = plant.values.get("M") if plant is not None else None
    known = {"uncertainty": facts["uncertainty"], "mass": mass, "fastest": facts["treatment"].get("velocity_max", 0.0)}
    return friction, known, plant, facts["treatment"]


def _refuse_taken(out: Path, file: Path | None, *, force: bool) -> None:
    """Refuse to replace anything but a page of the lab, and that only where it is asked for."""
    from bristle.core import InputError
    from bristle.files.single import is_sealed

    if not os.path.lexists(out):
        return
    if file is not None and file.exists() and out.exists() and out.samefile(file):
        raise InputError("is the model that is read", path=str(out), mend="Name another file")
    if out.is_dir():
        raise InputError("is a folder", path=str(out), mend=f"Name a file, such as {out / 'lab.html'}")
    if not is_sealed(out):
        raise InputError("is no page of the lab, or was changed since", path=str(out), mend="Name another file")
    if not force:
        raise InputError("is there already", path=str(out), mend="Add --force to replace it, or name another file")

"""``bristle lab``: friction to be touched, as one page."""

from __future__ import annotations

import os
import secrets
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from bristle.cli.options import AllowCode, Json
from bristle.cli.terminal import complain, progress

if TYPE_CHECKING:
    from bristle.core import Model

__all__ = ["EXAMPLE", "lab"]

EXAMPLE = """Example:
  bristle lab results --out lab.html"""


def lab(
    context: typer.Context,
    *,
    model: Annotated[
        Path | None,
        typer.Argument(metavar="[MODEL.toml|RESULTS]", help="A model file, or results of identify with one."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="LAB.html", help="Write the page into this new file.")],
    allow_code: AllowCode = False,
    force: Annotated[bool, typer.Option("--force", help="Replace a page of the lab that is there already.")] = False,
    as_json: Json = False,
) -> None:
    """Write a page on which friction can be touched.

    Parameters are moved, and loops, curves and stick-slip move with them. The page holds every friction model with its
    physics, and first of all the one that is given: with its slots, its values and how sure they are. One file that
    asks for nothing, for any browser, disk, mail or host. LAB.html#selftest tells whether a browser computes the bits
    of Python.
    """
    from bristle.core.content import content_of
    from bristle.files.provenance import provenance
    from bristle.files.summary import as_json as json_text
    from bristle.files.toml import TOML_LIMIT
    from bristle.files.user_model import origins_of_code
    from bristle.friction import MODELS, base_of
    from bristle.lab import lab_page
    from bristle.lab.page import FIRST

    file = model / "model.toml" if model is not None and model.is_dir() else model
    _refuse_taken(out, file, force=force)
    with progress("computing"):
        inputs: dict[str, Any] = {}
        content, code = None, ()
        if file is not None:
            content = content_of(file, limit=TOML_LIMIT)
            friction, inputs = _read(content, allow_code=allow_code)
            inputs |= {"model": friction, "source": file.name}
            code = origins_of_code([base_of(friction.component)])
        source = provenance(context.obj, model=content, code=code)
        page = lab_page(**inputs, provenance=source)
    _write(out, page)
    if as_json:
        first = inputs["model"].name if inputs else FIRST
        summary = {"file": out.name, "size": len(page.encode()), "model": first, "models": list(MODELS)}
        sys.stdout.write(json_text(summary | {"provenance": source}))
    complain(f"wrote {out}; open it in a browser")


def _read(content: Any, *, allow_code: bool) -> tuple[Model, dict[str, Any]]:
    """Return a friction model, how sure it is, what it moves, and how fast it was seen."""
    from bristle.files.model import read_model
    from bristle.testing import admit

    plant, friction, facts = read_model(content, allow_code=allow_code)
    admit(friction)
    mass = plant.values.get("M") if plant is not None else None
    return friction, {
        "uncertainty": facts["uncertainty"],
        "mass": mass,
        "fastest": facts["treatment"].get("velocity_max", 0.0),
    }


def _refuse_taken(out: Path, file: Path | None, *, force: bool) -> None:
    """Refuse to replace anything but a page of the lab, and that only where it is asked for."""
    from bristle.core import InputError
    from bristle.lab.page import MARK

    if not os.path.lexists(out):
        return
    if file is not None and file.exists() and out.exists() and out.samefile(file):
        raise InputError("is the model that is read", path=str(out), mend="Name another file")
    if out.is_dir():
        raise InputError("is a folder", path=str(out), mend=f"Name a file, such as {out / 'lab.html'}")
    with suppress(OSError), out.open("rb") as present:
        if present.read(len(MARK)) == MARK.encode("ascii"):
            if force:
                return
            raise InputError("is there already", path=str(out), mend="Add --force to replace it, or name another file")
    raise InputError("holds something else than a page of the lab", path=str(out), mend="Name another file")


def _write(out: Path, page: str) -> None:
    """Write a page so that it appears whole or not at all."""
    from bristle.core import InputError

    unfinished = out.with_name(f".{out.name}.{secrets.token_hex(8)}")
    try:
        with unfinished.open("x", encoding="utf-8", newline="\n") as target:
            target.write(page)
            target.flush()
            os.fsync(target.fileno())
        unfinished.replace(out)
    except OSError as error:
        with suppress(OSError):
            unfinished.unlink()
        raise InputError(f"cannot be written: {error.strerror or error}", path=str(out),
                         mend="Name a file in a folder that can be written to") from None  # fmt: skip

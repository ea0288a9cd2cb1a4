"""``bristle lab``: an interactive page of friction models."""

import hashlib
import os
import stat
import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from bristle.cli.options import AllowCode, Json, print_json, refuse, size_limit, toml_content
from bristle.cli.terminal import complain, progress

EXAMPLE = """Example:
  bristle lab results --out lab.html
  bristle lab --serve"""


_SEAL = "<!-- sha256 of all above: {} -->\n"


def lab(
    context: typer.Context,
    *,
    model: Annotated[
        Path | None,
        typer.Argument(
            metavar="[MODEL.toml|RESULTS]", help="A model file, or a folder of results of identify."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="LAB.html", help="Write the page to this new file."),
    ] = None,
    serve: Annotated[
        bool,
        typer.Option(
            "--serve",
            help="Instead of writing a page, open the workflow from log to drive table in a browser.",
        ),
    ] = False,
    port: Annotated[
        int, typer.Option("--port", metavar="PORT", help="Port of the server; 0 for any free port.")
    ] = 0,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Print the address without opening a browser.")
    ] = False,
    allow_code: AllowCode = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an existing page of the lab.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Write an interactive page of friction models.

    The page simulates every friction model of bristle. If you move a parameter, the page recomputes loops, curves and
    stick-slip. The page starts with the slots, values and intervals of MODEL.toml. The page is one HTML file and works
    offline. Open LAB.html#selftest to test whether the browser computes bit by bit the same numbers as Python.

    With --serve, the workflow runs in the browser, on this machine only: drop logs, confirm columns, units and signs,
    check, identify, compensate and export, design the motion to record, or tune a machine whose file is in the present
    folder or below. Ctrl-C ends the server.
    """
    from bristle.core import InputError

    if serve:
        unfit = {"MODEL.toml": model, "--out": out, "--force": force, "--json": as_json}
        refuse(
            unfit,
            "cannot be combined with --serve",
            "Leave this option out and drop files on the page",
        )
        _serve(port, opens=not no_open)
        return
    refuse({"--port": port, "--no-open": no_open}, "applies to --serve only", "Add --serve")
    if out is None:
        raise InputError(
            "is missing", path="--out", mend="Name the page to write, or type: bristle lab --serve"
        )
    from bristle.apps.lab import lab_page
    from bristle.apps.lab.page import FIRST
    from bristle.contract import admit
    from bristle.files import origins_of_code, provenance, read_model, write_whole
    from bristle.models.friction import MODELS

    file = model / "model.toml" if model is not None and model.is_dir() else model
    _refuse_taken(out, file, force=force)
    with progress("computing"):
        content, code = toml_content(file), ()
        inputs: dict[str, Any] = {}
        if content is not None and file is not None:
            plant, friction, facts = read_model(content, allow_code=allow_code)
            admit(friction)
            code = origins_of_code([friction.component])
            inputs = {
                "model": friction,
                "source": file.name,
                "uncertainty": facts["uncertainty"],
                "mass": plant.values.get("M") if plant is not None else None,
                "fastest": facts["treatment"].get("velocity_max", 0.0),
            }
        source = provenance(context.obj, model=content, code=code)
        page = sealed(lab_page(**inputs, provenance=source))
    write_whole(out, page, new=not force)
    if as_json:
        print_json(
            {
                "file": out.name,
                "size": len(page.encode()),
                "model": inputs["model"].name if inputs else FIRST,
                "models": list(MODELS),
                "provenance": source,
            }
        )
    complain(f"wrote {out}; open it in a browser")


def _serve(port: int, *, opens: bool) -> None:
    """Serve the lab to browsers of this machine until Ctrl-C."""
    from bristle.apps.lab.server import Limits, serve

    def announce(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        complain(
            "open this address in a browser on this machine. Anybody who knows the address can use the lab. Ctrl-C ends the server"
        )

    limits = Limits(file_size=size_limit(), total_size=4 * size_limit())
    with suppress(KeyboardInterrupt):  # the usual end
        serve(port=port, opens=opens, limits=limits, announce=announce)
    complain("the lab is closed")


def _refuse_taken(out: Path, file: Path | None, *, force: bool) -> None:
    """Refuse to replace any file but a page of the lab, and that only on request."""
    from bristle.core import InputError

    if not os.path.lexists(out):
        return
    if file is not None and file.exists() and out.exists() and out.samefile(file):
        raise InputError("is the model file itself", path=str(out), mend="Name another file")
    if out.is_dir():
        raise InputError(
            "is a folder", path=str(out), mend=f"Name a file, such as {out / 'lab.html'}"
        )
    if not is_sealed(out):
        raise InputError(
            "was not written by bristle lab, or was changed later",
            path=str(out),
            mend="Name another file",
        )
    if not force:
        raise InputError(
            "already exists", path=str(out), mend="Add --force to replace it, or name another file"
        )


def sealed(text: str) -> str:
    """Return a page followed by its checksum."""
    return text + _SEAL.format(hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest())


def is_sealed(path: Path) -> bool:
    """Return whether a file (not a link) is an unchanged sealed page."""
    size = len(_SEAL.format(64 * "0"))
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            return False
        content = path.read_bytes()
    except OSError:
        return False
    return content[-size:] == _SEAL.format(hashlib.sha256(content[:-size]).hexdigest()).encode()

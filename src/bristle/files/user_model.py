"""A user's own friction model: one Python file, used without any change to the package."""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import types
from pathlib import Path

from bristle.core.contracts import FrictionModel
from bristle.core.errors import BristleError, InputError

__all__ = ["load_model_file"]


def load_model_file(path: str | os.PathLike[str]) -> FrictionModel:
    """Return the friction model that a Python file defines as ``MODEL``.

    The module is named by the hash of its source, so that an edited file is another module: nothing compiled from
    the old one is ever used again.

    Parameters
    ----------
    path : path-like
        A Python file with ``Parameters``, ``State``, ``trial``, ``commit`` and ``MODEL``. It is executed.

    Returns
    -------
    FrictionModel
        The descriptor.

    Raises
    ------
    InputError
        If the file cannot be read or run, defines no ``MODEL``, or gives it a name that cannot be asked for.
    """
    source = Path(path)
    try:
        text = source.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path=str(source)) from None
    name = f"bristle_user_{hashlib.sha256(text).hexdigest()[:16]}"
    module = sys.modules.get(name) or _executed(name, source, text)
    model = getattr(module, "MODEL", None)
    if not isinstance(model, FrictionModel):
        raise InputError(
            "defines no friction model" if model is None else "MODEL is not a FrictionModel",
            path=str(source),
            value=None if model is None else type(model).__name__,
            mend="End the file with MODEL = FrictionModel(name=..., description=..., Parameters=Parameters, "
            "State=State, trial=trial, commit=commit)",
        )
    if not model.name.strip() or set("+,") & set(model.name):
        raise InputError(
            "gives its model a name that cannot be asked for", path=str(source), value=model.name,
            allowed="a name without + and comma", mend='Write another name in FrictionModel(name="...")',
        )  # fmt: skip
    return model


def _executed(name: str, source: Path, text: bytes) -> types.ModuleType:
    if b"\0" in text:
        raise InputError(
            "is not Python but binary data", path=str(source), mend="Name a file with a model, my_model.py"
        )
    module = types.ModuleType(name)
    module.__file__ = str(source)
    sys.modules[name] = module
    try:
        # Compiled from the text at hand: a byte-code cache goes by the second and the size, and may be stale.
        # What it prints is no part of a result, and goes where messages go.
        with contextlib.redirect_stdout(sys.stderr):
            exec(compile(text, str(source), "exec"), module.__dict__)
    except SyntaxError as error:
        del sys.modules[name]
        raise InputError(f"is not valid Python ({error.msg})", path=f"{source}, line {error.lineno or 1}") from None
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        if isinstance(error, BristleError):
            raise
        raise InputError(
            f"stops with {type(error).__name__}: {error}".rstrip(": "), path=f"{source}, line {_line_of(error, source)}"
        ) from None
    return module


def _line_of(error: BaseException, source: Path) -> int:
    line, frame = 0, error.__traceback__
    while frame is not None:
        if frame.tb_frame.f_code.co_filename == str(source):
            line = frame.tb_lineno
        frame = frame.tb_next
    return line

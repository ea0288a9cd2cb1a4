"""A user's own friction model: one Python file, used without any change to the package."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import linecache
import sys
import types
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bristle.core.content import Content, Origin, Readable, content_of
from bristle.core.contracts import FrictionModel
from bristle.core.errors import BristleError, InputError, told_by
from bristle.core.locks import LOADING
from bristle.core.variable import variables_of
from bristle.files.permission import CODE_LIMIT

__all__ = ["SourceText", "code_of", "load_model_file", "origins_of_code"]


@dataclass(frozen=True)
class SourceText:
    """The text of a file of a user: what goes to another process, where the file may be gone or another one.

    Parameters
    ----------
    content : Content
        The text, and where it was read.
    """

    content: Content

    def module(self) -> types.ModuleType:
        """Return what the text defines, executed once in each process.

        Raises
        ------
        InputError
            If it cannot be run.
        """
        name = f"bristle_user_{self.content.checksum[:16]}"
        with LOADING:
            module = sys.modules.get(name) or _executed(name, self.content)
            _show_source(module, self.content.data)
            return module


def load_model_file(path: Readable) -> FrictionModel:
    """Return the friction model that a Python file defines as ``MODEL``.

    The module is named by the hash of its source, so that an edited file is another module: nothing compiled from
    the old one is ever used again.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
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
    content = content_of(path, limit=CODE_LIMIT, what="a file of Python")
    source = content.source
    model = getattr(SourceText(content).module(), "MODEL", None)
    if not isinstance(model, FrictionModel):
        raise InputError(
            "defines no friction model" if model is None else "MODEL is not a FrictionModel",
            path=str(source),
            value=None if model is None else type(model).__name__,
            mend="End the file with MODEL = FrictionModel(name=..., description=..., Parameters=Parameters, "
            "State=State, trial=trial, commit=commit)",
        )
    if not isinstance(model.name, str) or not model.name.strip() or set("+,") & set(model.name):
        raise InputError(
            "gives its model a name that cannot be asked for", path=str(source), value=model.name,
            allowed="a name without + and comma", mend='Write another name in FrictionModel(name="...")',
        )  # fmt: skip
    _refuse_odd_quantities(model, source)
    return model


def _refuse_odd_quantities(model: FrictionModel, source: Path) -> None:
    """Refuse a model with a quantity that is none; what else a description lacks, the contract says."""
    for fields in (model.Parameters, model.State):
        try:
            variables_of(fields)
        except InputError as error:
            raise error.at(_place(error, source)) from None
        except Exception:  # noqa: BLE001  (annotations may hold anything)
            return


def code_of(component: Any) -> Content | None:
    """Return the file that a model was loaded from; None for one that was loaded from none."""
    source = getattr(sys.modules.get(component.module), "__travels_as__", None)
    return source.content if isinstance(source, SourceText) else None


def origins_of_code(components: Iterable[Any]) -> tuple[Origin, ...]:
    """Return the files that models were loaded from, each once."""
    origins = [content.origin for component in components if (content := code_of(component)) is not None]
    return tuple(dict.fromkeys(origins))


class _Messages(io.TextIOBase):
    """The stream of messages as code of a person's own is given it: closing it closes nothing."""

    def __init__(self) -> None:
        self._stream = sys.stderr

    def write(self, text: str, /) -> int:
        return len(text) if self._stream is None else self._stream.write(text)

    def close(self) -> None:
        return


def _executed(name: str, content: Content) -> types.ModuleType:
    source = content.source
    if b"\0" in content.data:
        raise InputError(
            "is not Python but binary data", path=str(source), mend="Name a file with a model, my_model.py"
        )
    module = types.ModuleType(name)
    module.__file__ = str(source)
    sys.modules[name] = module
    deepest = sys.getrecursionlimit()
    try:
        # The compiler takes any byte in a comment, and those who look at the source do not.
        importlib.util.decode_source(content.data)
        # Compiled from the text at hand: a byte-code cache goes by the second and the size, and may be stale.
        # What it prints is no part of a result, and goes where messages go.
        messages = _Messages()
        with contextlib.redirect_stdout(messages), contextlib.redirect_stderr(messages):
            # Its annotations are what it says they are: without this, they would be read as this file reads its own.
            exec(compile(content.data, str(source), "exec", dont_inherit=True), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        if isinstance(error, InputError):
            raise error.at(_place(error, source)) from None
        if isinstance(error, (BristleError, KeyboardInterrupt)):
            raise
        raise _refusal(error, source) from None
    finally:
        sys.setrecursionlimit(deepest)
    _let_travel(module, SourceText(content))
    return module


def _show_source(module: types.ModuleType, text: bytes) -> None:
    """Let `inspect` find the text that was executed, whatever has become of the file that it was read from."""
    filename = str(module.__file__)
    lines = importlib.util.decode_source(text).splitlines(keepends=True)
    linecache.cache[filename] = (len(text), None, lines, filename)


def _refusal(error: BaseException, source: Path) -> InputError:
    if isinstance(error, SyntaxError) and error.filename == str(source):
        return InputError(f"is not valid Python ({error.msg})", path=f"{source}, line {error.lineno or 1}")
    if isinstance(error, (SyntaxError, ValueError, RecursionError, MemoryError)) and not _line_of(error, source):
        return InputError(f"is not valid Python ({error})", path=str(source))  # what the compiler gives up on
    message = f"stops with {type(error).__name__}: {told_by(error)}".rstrip(": ")
    return InputError(message, path=_place(error, source))


def _place(error: BaseException, source: Path) -> str:
    line = _line_of(error, source)
    return f"{source}, line {line}" if line else str(source)


def _let_travel(module: types.ModuleType, source: SourceText) -> None:
    """Let what a module defines travel as its text: by a name alone no other process could import it."""

    def reduced(value: Any) -> tuple[Any, ...]:
        return _tuple_of, (source, type(value).__name__, tuple(value))

    vars(module)["__travels_as__"] = source
    for member in list(vars(module).values()):
        if isinstance(member, type) and issubclass(member, tuple) and member.__module__ == module.__name__:
            member.__reduce__ = reduced  # type: ignore[method-assign]


def _tuple_of(source: SourceText, name: str, values: tuple[Any, ...]) -> Any:
    return getattr(source.module(), name)(*values)


def _line_of(error: BaseException, source: Path) -> int:
    line, frame = 0, error.__traceback__
    while frame is not None:
        if frame.tb_frame.f_code.co_filename == str(source):
            line = frame.tb_lineno
        frame = frame.tb_next
    return line

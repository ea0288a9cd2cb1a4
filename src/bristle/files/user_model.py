"""Load a Python file of the user: a model, slot, control law, sensor, plant, reference, reader or target."""

import contextlib
import importlib.util
import io
import linecache
import sys
import types
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from bristle.core import (
    LOADING,
    Component,
    Content,
    Controller,
    FrictionModel,
    Origin,
    Plant,
    Readable,
    Sensor,
    Trajectory,
    variables_of,
)
from bristle.core.documented import Documented
from bristle.core.errors import OWN_CODE, BristleError, InputError, error_text, located
from bristle.core.fingerprint import LETTERS
from bristle.core.slot import Slot, refuse_unfit
from bristle.files.permission import CodeRead, code_at
from bristle.logs.formats import LogFormat
from bristle.models.friction import (
    OPERATOR_SLOTS,
    SLOTS,
    base_of,
    channel_slots_of,
    find,
    with_slots,
)

WORDS: dict[type[Documented], str] = {
    FrictionModel: "friction model",
    Controller: "control law",
    Sensor: "sensor",
    Plant: "plant",
    Trajectory: "reference",
    Slot: "slot",
}
"""Words for components, by descriptor."""

Own = TypeVar("Own", bound=Component)
Declared = TypeVar("Declared")


@dataclass(frozen=True)
class SourceText:
    """Text of a user file, for other processes: the file itself may be missing or changed there."""

    content: Content

    def module(self) -> types.ModuleType:
        """Execute the text once in each process and return its module."""
        name = f"{OWN_CODE}{self.content.checksum[:LETTERS]}"
        with LOADING:
            module = sys.modules.get(name) or _executed(name, self.content)
            # Lets `inspect` find the executed text even if the file has changed.
            filename, lines = (
                str(module.__file__),
                importlib.util.decode_source(self.content.data).splitlines(keepends=True),
            )
            linecache.cache[filename] = (len(self.content.data), None, lines, filename)
            return module


def load_code(path: Readable) -> FrictionModel:
    """Run a Python file and return the friction model that it defines as ``MODEL``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file, ``my_model.py``, with ``Parameters``, ``State``, ``trial``, ``commit`` and ``MODEL``. A model
        file, ``model.toml``, must be read with `read_model`.

    Returns
    -------
    FrictionModel
        The model; call it with its parameters.

    Raises
    ------
    InputError
        If its name does not end with ``.py``, if it cannot be read or run, or if ``MODEL`` is missing or has an invalid
        name.
    """
    return load_component_file(path, FrictionModel)


def declared_in(
    path: Readable, name: str, *families: type[Declared], title: str, mend: str
) -> Declared:
    """Return the object that a Python file defines under a name."""
    content = code_at(path)
    declared = getattr(SourceText(content).module(), name, None)
    if isinstance(declared, families):
        return declared
    message = (
        f"defines no {title}" if declared is None else f"{name} is not a {families[0].__name__}"
    )
    raise InputError(
        message,
        path=str(content.source),
        mend=mend,
        value=None if declared is None else type(declared).__name__,
    )


def load_component_file(path: Readable, *families: type[Own]) -> Own:
    """Return the component that a Python file defines as ``MODEL``."""
    content, first = code_at(path), families[0]
    model = declared_in(
        content,
        "MODEL",
        *families,
        title=WORDS[first],
        mend=f"End the file with MODEL = {_as_written(first)}",
    )
    family, source = type(model), content.source
    if not isinstance(model.name, str) or not model.name.strip() or set("+,") & set(model.name):
        raise InputError(
            "has an invalid name for its model",
            path=str(source),
            value=model.name,
            allowed="text without a plus sign or comma",
            mend=f'Write another name in {family.__name__}(name="...")',
        )
    # The contract checks the rest of the description.
    for described in (model.Parameters, model.State):
        try:
            variables_of(described)
        except InputError as error:
            raise error.at(_place(error, source)) from None
        except Exception:  # noqa: BLE001  (annotations may be any objects)
            break
    return model


def _as_written(family: type[Documented]) -> str:
    """Return the call of a descriptor with its required arguments."""
    needed = [
        field.name
        for field in fields(family)
        if field.default is MISSING and field.default_factory is MISSING
    ]
    free = ("name", "description", "channel")
    return f"{family.__name__}({', '.join(f'{name}=...' if name in free else f'{name}={name}' for name in needed)})"


def component_in(
    table: Mapping[str, Any], family: type[Own], *, path: str, read_code: CodeRead
) -> Own:
    """Return the user component that a table names, ``file = "my_law.py"``."""
    file, word = table["file"], WORDS[family].split()[-1]
    if "model" in table:
        raise InputError("has both a model and a file", path=path, mend="Remove one of these keys")
    if not isinstance(file, str) or not file.endswith(".py"):
        raise InputError(
            f"is not a Python file with a {word}",
            path=f"{path}.file",
            value=file,
            allowed=f"a Python file, such as my_{word}.py",
        )
    return load_component_file(read_code(file, f"{path}.file"), family)


def load_slot_file(path: Readable) -> Slot:
    """Run a Python file and return the slot that it defines as ``SLOT``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file with ``Parameters``, the kernel ``factor(channel, p)`` and ``SLOT``.

    Returns
    -------
    Slot
        The descriptor.

    Raises
    ------
    InputError
        If the file cannot be read or run, or if ``SLOT`` is missing or not usable with a model.
    """
    content = code_at(path)
    source, mend = content.source, f"End the file with SLOT = {_as_written(Slot)}"
    if isinstance(getattr(SourceText(content).module(), "MODEL", None), FrictionModel):
        mend = f"It defines a friction model. Write {source.name} as the first name, such as {source.name}+asymmetry"
    slot = declared_in(content, "SLOT", Slot, title=WORDS[Slot], mend=mend)
    if (
        not isinstance(slot.name, str)
        or not slot.name.isidentifier()
        or slot.name in (*SLOTS, *OPERATOR_SLOTS)
    ):
        raise InputError(
            "has an invalid name for its slot",
            path=str(source),
            value=slot.name,
            allowed=f"a word other than {', '.join(SLOTS)}",
            mend='Write another name in Slot(name="...")',
        )
    with located(source):
        refuse_unfit(slot)
    return slot


def load_checked(path: Readable) -> FrictionModel | Slot | Controller | Sensor:
    """Return the ``SLOT``, or else the ``MODEL``, of a Python file, checked against its contract."""
    content = code_at(path)
    if hasattr(SourceText(content).module(), "SLOT"):
        return load_slot_file(content)
    return load_component_file(content, FrictionModel, Controller, Sensor)


def word_of(described: Documented) -> str:
    """Return the word for a component."""
    return next(word for family, word in WORDS.items() if isinstance(described, family))


def slots_in(names: Iterable[str], path: str, read_code: CodeRead) -> list[str | Slot]:
    """Return slots by name; load user slots if the name is a Python file."""
    return [
        load_slot_file(read_code(name, path)) if name.endswith(".py") else name for name in names
    ]


def friction_named(name: str, path: str, read_code: CodeRead) -> FrictionModel:
    """Return the friction model of a name with files: ``my_model.py+asymmetry``, ``lugre+my_slot.py``."""
    base, *slots = name.split("+")
    model = load_code(read_code(base, path)) if base.endswith(".py") else base_of(find(base, path))
    return with_slots(model, slots_in(slots, path, read_code), path)


def codes_of(component: Any) -> tuple[Content, ...]:
    """Return the source files of a model and its slots, each once."""
    parts = (
        (base_of(component), *channel_slots_of(component))
        if isinstance(component, FrictionModel)
        else (component,)
    )
    return tuple(dict.fromkeys(code for part in parts if (code := code_of(part)) is not None))


def code_of(component: Any) -> Content | None:
    """Return the source file of a user model; None for other models."""
    source = getattr(sys.modules.get(component.module), "__travels_as__", None)
    return source.content if isinstance(source, SourceText) else None


def origins_of_code(components: Iterable[Any]) -> tuple[Origin, ...]:
    """Return the source files of models and their slots, each once."""
    return tuple(
        dict.fromkeys(code.origin for component in components for code in codes_of(component))
    )


class _Messages(io.TextIOBase):
    """Stream of messages for user code; closing it has no effect."""

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
            "is binary data instead of Python code",
            path=str(source),
            mend="Name a file with a model, my_model.py",
        )
    module = types.ModuleType(name)
    module.__file__ = str(source)
    sys.modules[name] = module
    deepest = sys.getrecursionlimit()
    try:
        # The compiler accepts any byte in a comment, but readers of the source do not.
        importlib.util.decode_source(content.data)
        # Compiled from this text: a byte-code cache compares only time and size, and may be stale.
        # Printed text is not part of a result: it goes to the stream of messages.
        messages = _Messages()
        with contextlib.redirect_stdout(messages), contextlib.redirect_stderr(messages):
            # Without dont_inherit, the future statements of this file would change its annotations.
            exec(compile(content.data, str(source), "exec", dont_inherit=True), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        place = _place(error, source)
        if isinstance(error, InputError):
            raise error.at(place) from None
        if isinstance(error, (BristleError, KeyboardInterrupt)):
            raise
        if isinstance(error, SyntaxError) and error.filename == str(source):
            raise InputError(
                f"is not valid Python ({error.msg})", path=f"{source}, line {error.lineno or 1}"
            ) from None
        if isinstance(
            error, (SyntaxError, ValueError, RecursionError, MemoryError)
        ) and place == str(source):
            raise InputError(
                f"is not valid Python ({error_text(error) or type(error).__name__})", path=place
            ) from None  # beyond the limits of the compiler
        raise InputError(
            f"stops with {type(error).__name__}: {error_text(error)}".rstrip(": "), path=place
        ) from None
    finally:
        sys.setrecursionlimit(deepest)
    text = SourceText(content)

    def reduced(value: Any) -> tuple[Any, ...]:
        return _tuple_of, (text, type(value).__name__, tuple(value))

    # Objects of a module are pickled with its text, because another process could not import them by name.
    vars(module)["__travels_as__"] = text
    for member in list(vars(module).values()):
        if (
            isinstance(member, type)
            and issubclass(member, tuple)
            and member.__module__ == module.__name__
        ):
            member.__reduce__ = reduced  # type: ignore[method-assign]
    return module


def _tuple_of(source: SourceText, name: str, values: tuple[Any, ...]) -> Any:
    return getattr(source.module(), name)(*values)


def _place(error: BaseException, source: Path) -> str:
    """Return the file, and the line of an error if it was raised in the file."""
    line, frame = 0, error.__traceback__
    while frame is not None:
        if frame.tb_frame.f_code.co_filename == str(source):
            line = frame.tb_lineno
        frame = frame.tb_next
    return f"{source}, line {line}" if line else str(source)


MEND = "End the file with FORMAT = LogFormat(name=..., title=..., recognises=recognises, read=read)"


def load_reader_file(path: Readable) -> LogFormat:
    """Return the log format that a Python file defines as ``FORMAT``."""
    content = code_at(path)
    log_format = declared_in(content, "FORMAT", LogFormat, title="reader of logs", mend=MEND)
    if not callable(log_format.recognises) or not callable(log_format.read):
        raise InputError("defines no reader of logs", path=str(content.source), mend=MEND)
    return log_format

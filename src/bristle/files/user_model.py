"""What a user has of his own in one Python file: a model, slot, control law, sensor, plant, reference, reader or target."""

import contextlib
import importlib.util
import io
import linecache
import sys
import types
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

from bristle.core.content import Content, Origin, Readable
from bristle.core.contracts import Component, Controller, FrictionModel, Plant, Sensor, Trajectory
from bristle.core.documented import Documented
from bristle.core.errors import OWN_CODE, BristleError, InputError, located, told_by
from bristle.core.fingerprint import LETTERS
from bristle.core.locks import LOADING
from bristle.core.slot import Slot, refuse_unfit
from bristle.core.variable import variables_of
from bristle.files.permission import CodeRead, code_at
from bristle.friction import base_of, channel_slots_of, find, with_slots
from bristle.friction.operator_kernel import REACHES
from bristle.friction.slots import SLOTS
from bristle.logs.formats import LogFormat

WORDS: dict[type[Documented], str] = {
    FrictionModel: "friction model",
    Controller: "control law",
    Sensor: "sensor",
    Plant: "plant",
    Trajectory: "reference",
    Slot: "slot",
}
"""What a component is called, by its descriptor."""

Own = TypeVar("Own", bound=Component)
Declared = TypeVar("Declared")


@dataclass(frozen=True)
class SourceText:
    """The text of a file of a user: what goes to another process, where the file may be gone or another one."""

    content: Content

    def module(self) -> types.ModuleType:
        """Return what the text defines, executed once in each process."""
        name = f"{OWN_CODE}{self.content.checksum[:LETTERS]}"
        with LOADING:
            module = sys.modules.get(name) or _executed(name, self.content)
            # Lets `inspect` find the text that was executed, whatever has become of the file that it was read from.
            filename, lines = str(module.__file__), importlib.util.decode_source(self.content.data).splitlines(keepends=True)
            linecache.cache[filename] = (len(self.content.data), None, lines, filename)
            return module


def load_code(path: Readable) -> FrictionModel:
    """Return the friction model that a Python file defines as ``MODEL``; the file is run.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file, ``my_model.py``, with ``Parameters``, ``State``, ``trial``, ``commit`` and ``MODEL``. A model
        file, ``model.toml``, is read by `read_model`.

    Returns
    -------
    FrictionModel
        The model, to be called with its parameters.

    Raises
    ------
    InputError
        If its name does not end with ``.py``, it cannot be read or run, defines no ``MODEL``, or gives it a name that
        cannot be asked for.
    """
    return load_component_file(path, FrictionModel)


def load_model_file(path: Readable) -> FrictionModel:
    """Return what `load_code` returns; this is its former name, which is removed in the next release."""
    warnings.warn(
        "load_model_file was renamed: write load_code. The old name is removed in the next release", DeprecationWarning, stacklevel=2
    )
    return load_code(path)


def declared_in(path: Readable, name: str, *families: type[Declared], title: str, mend: str) -> Declared:
    """Return what a Python file defines under a name."""
    content = code_at(path)
    declared = getattr(SourceText(content).module(), name, None)
    if isinstance(declared, families):
        return declared
    message = f"defines no {title}" if declared is None else f"{name} is not a {families[0].__name__}"
    raise InputError(message, path=str(content.source), mend=mend, value=None if declared is None else type(declared).__name__)


def load_component_file(path: Readable, *families: type[Own]) -> Own:
    """Return what a Python file defines as ``MODEL``."""
    content, first = code_at(path), families[0]
    model = declared_in(content, "MODEL", *families, title=WORDS[first], mend=f"End the file with MODEL = {_as_written(first)}")
    family, source = type(model), content.source
    if not isinstance(model.name, str) or not model.name.strip() or set("+,") & set(model.name):
        allowed, mend = "a name without + and comma", f'Write another name in {family.__name__}(name="...")'
        raise InputError("gives its model a name that cannot be asked for", path=str(source), value=model.name, allowed=allowed, mend=mend)
    for described in (model.Parameters, model.State):  # what else a description lacks, the contract says
        try:
            variables_of(described)
        except InputError as error:
            raise error.at(_place(error, source)) from None
        except Exception:  # noqa: BLE001  (annotations may hold anything)
            break
    return model


def _as_written(family: type[Documented]) -> str:
    """Return the call of a descriptor with what it cannot do without."""
    needed = [field.name for field in fields(family) if field.default is MISSING and field.default_factory is MISSING]
    free = ("name", "description", "channel")
    return f"{family.__name__}({', '.join(f'{name}=...' if name in free else f'{name}={name}' for name in needed)})"


def component_in(table: Mapping[str, Any], family: type[Own], *, path: str, read_code: CodeRead) -> Own:
    """Return the component of a person's own that a table names, ``file = "my_law.py"``."""
    file, word = table["file"], WORDS[family].split()[-1]
    if "model" in table:
        raise InputError("has both a model and a file", path=path, mend="Keep one of them")
    if not isinstance(file, str) or not file.endswith(".py"):
        raise InputError(f"is no file with a {word}", path=f"{path}.file", value=file, allowed=f"a file of Python, my_{word}.py")
    return load_component_file(read_code(file, f"{path}.file"), family)


def load_slot_file(path: Readable) -> Slot:
    """Return the slot that a Python file defines as ``SLOT``; it is executed.

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
        If the file cannot be read or run, defines no ``SLOT``, or one that no model can be given.
    """
    content = code_at(path)
    source, mend = content.source, f"End the file with SLOT = {_as_written(Slot)}"
    if isinstance(getattr(SourceText(content).module(), "MODEL", None), FrictionModel):
        mend = f"It defines a friction model: write {source.name} in front, {source.name}+asymmetry"
    slot = declared_in(content, "SLOT", Slot, title=WORDS[Slot], mend=mend)
    if not isinstance(slot.name, str) or not slot.name.isidentifier() or slot.name in (*SLOTS, *REACHES):
        message, allowed = "gives its slot a name that cannot be asked for", f"a word that is none of {', '.join(SLOTS)}"
        raise InputError(message, path=str(source), value=slot.name, allowed=allowed, mend='Write another name in Slot(name="...")')
    with located(source):
        refuse_unfit(slot)
    return slot


def load_checked(path: Readable) -> FrictionModel | Slot | Controller | Sensor:
    """Return what of a person's own there is a contract for in a Python file: ``SLOT``, or else ``MODEL``."""
    content = code_at(path)
    if hasattr(SourceText(content).module(), "SLOT"):
        return load_slot_file(content)
    return load_component_file(content, FrictionModel, Controller, Sensor)


def word_of(described: Documented) -> str:
    """Return what something is called by its descriptor."""
    return next(word for family, word in WORDS.items() if isinstance(described, family))


def slots_in(names: Iterable[str], path: str, read_code: CodeRead) -> list[str | Slot]:
    """Return slots by name, and of a person's own where the name is that of a file of Python."""
    return [load_slot_file(read_code(name, path)) if name.endswith(".py") else name for name in names]


def friction_named(name: str, path: str, read_code: CodeRead) -> FrictionModel:
    """Return the friction model of a name that holds files: ``my_model.py+asymmetry``, ``lugre+my_slot.py``."""
    base, *slots = name.split("+")
    model = load_code(read_code(base, path)) if base.endswith(".py") else base_of(find(base, path))
    return with_slots(model, slots_in(slots, path, read_code), path)


def codes_of(component: Any) -> tuple[Content, ...]:
    """Return the files that a model was loaded from, and its slots, each once."""
    parts = (base_of(component), *channel_slots_of(component)) if isinstance(component, FrictionModel) else (component,)
    return tuple(dict.fromkeys(code for part in parts if (code := code_of(part)) is not None))


def code_of(component: Any) -> Content | None:
    """Return the file that a model was loaded from; None for one that was loaded from none."""
    source = getattr(sys.modules.get(component.module), "__travels_as__", None)
    return source.content if isinstance(source, SourceText) else None


def origins_of_code(components: Iterable[Any]) -> tuple[Origin, ...]:
    """Return the files that models and their slots were loaded from, each once."""
    return tuple(dict.fromkeys(code.origin for component in components for code in codes_of(component)))


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
        raise InputError("is not Python but binary data", path=str(source), mend="Name a file with a model, my_model.py")
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
        place = _place(error, source)
        if isinstance(error, InputError):
            raise error.at(place) from None
        if isinstance(error, (BristleError, KeyboardInterrupt)):
            raise
        if isinstance(error, SyntaxError) and error.filename == str(source):
            raise InputError(f"is not valid Python ({error.msg})", path=f"{source}, line {error.lineno or 1}") from None
        if isinstance(error, (SyntaxError, ValueError, RecursionError, MemoryError)) and place == str(source):
            raise InputError(f"is not valid Python ({error})", path=place) from None  # what the compiler gives up on
        raise InputError(f"stops with {type(error).__name__}: {told_by(error)}".rstrip(": "), path=place) from None
    finally:
        sys.setrecursionlimit(deepest)
    text = SourceText(content)

    def reduced(value: Any) -> tuple[Any, ...]:
        return _tuple_of, (text, type(value).__name__, tuple(value))

    # What a module defines travels as its text: by a name alone no other process could import it.
    vars(module)["__travels_as__"] = text
    for member in list(vars(module).values()):
        if isinstance(member, type) and issubclass(member, tuple) and member.__module__ == module.__name__:
            member.__reduce__ = reduced  # type: ignore[method-assign]
    return module


def _tuple_of(source: SourceText, name: str, values: tuple[Any, ...]) -> Any:
    return getattr(source.module(), name)(*values)


def _place(error: BaseException, source: Path) -> str:
    """Return the file, and the line in it where an error was raised, as far as it was there."""
    line, frame = 0, error.__traceback__
    while frame is not None:
        if frame.tb_frame.f_code.co_filename == str(source):
            line = frame.tb_lineno
        frame = frame.tb_next
    return f"{source}, line {line}" if line else str(source)


MEND = "End the file with FORMAT = LogFormat(name=..., title=..., recognises=recognises, read=read)"


def load_reader_file(path: Readable) -> LogFormat:
    """Return the format that a Python file defines as ``FORMAT``."""
    content = code_at(path)
    log_format = declared_in(content, "FORMAT", LogFormat, title="reader of logs", mend=MEND)
    if not callable(log_format.recognises) or not callable(log_format.read):
        raise InputError("defines no reader of logs", path=str(content.source), mend=MEND)
    return log_format

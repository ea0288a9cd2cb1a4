"""A friction model along walks of many axes, compiled, for frameworks of automatic differentiation.

Translating a model takes longer than loading a library. Therefore a record in the cache, under a key of the model and of
the code of bristle, names the library.
"""

import atexit
import ctypes
import hashlib
import importlib.resources
import json
import os
import platform
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import InputError, Model, variables_of
from bristle.core.fingerprint import fingerprint
from bristle.core.packing import pack
from bristle.engine.compilation import cache_folder

PATIENCE = 120.0  # of the compiler [s]


class CompiledWalk:
    """A friction model along walks, compiled by the C compiler of this machine.

    Attributes
    ----------
    library : Path
        The library, with the functions ``walk``, ``walk_forward`` and ``walk_reverse`` of C.
    parameters : dict of str to ndarray
        Numbers of each parameter, in the order of the library.
    signals : dict of str to float
        Inputs besides the motion, with their usual values.
    start : ndarray
        State before the first step: position, force, whether there was a sample, numbers of the state, and memory.

    Raises
    ------
    InputError
        If bristle does not export derivatives of the model, or finds no C compiler.
    """

    def __init__(self, model: Model) -> None:
        folder = cache_folder() or _folder_of_process()
        place = folder / f"walk-{_key(model)}.json"
        record = _record(place)
        if record is None:
            record = self._built(model)
            _write(place, json.dumps(record))
        self.library = folder / record["library"]
        self.parameters = {
            name: np.atleast_1d(np.asarray(model.values[name], dtype=float))
            for name in record["parameters"]
        }
        self.signals: dict[str, float] = record["signals"]
        self.start = np.array(record["start"])
        self._functions = ctypes.CDLL(str(self.library))

    @classmethod
    def _built(cls, model: Model) -> dict[str, Any]:
        """Translate and compile a model; return the name and checksum of its library, and its arguments."""
        from bristle.exports.c import FLAGS, compiler  # these modules load slowly
        from bristle.exports.c_derivatives import derived_step
        from bristle.exports.subject import subject_of
        from bristle.exports.walk_code import walk_files

        derived = derived_step(subject_of(model), tunable=True)
        subject = derived.subject
        library = cls.build(walk_files(derived), compiler(), ["-O2", *FLAGS.split()])
        return {
            "library": library.name,
            "sha256": hashlib.sha256(library.read_bytes()).hexdigest(),
            "parameters": list(derived.tuned.values),
            "signals": {name: subject.usual[name] for name in subject.signals},
            "start": [0.0, 0.0, 0.0, *map(float, subject.virgin), *[0.0] * subject.memory_size],
        }

    def run(
        self,
        function: str,
        lanes: int,
        steps: int,
        inputs: Sequence[np.ndarray],
        outputs: Sequence[np.ndarray],
    ) -> None:
        """Run a function of the library on contiguous arrays of doubles."""
        pointers = [
            (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
            for arrays in (inputs, outputs)
        ]
        result = getattr(self._functions, function)(
            ctypes.c_size_t(lanes), ctypes.c_size_t(steps), *pointers
        )
        if result == 1:
            raise MemoryError
        if result:
            raise InputError("is not a state of this model", path="state")

    @staticmethod
    def build(files: Mapping[str, str], command: str | None, flags: Sequence[str]) -> Path:
        """Return a shared library of some files, compiled at first use and stored in the cache of bristle.

        Parameters
        ----------
        files : mapping of str to str
            Text of each file by name; headers end with ``.h``.
        command : str or None
            The compiler.
        flags : sequence of str
            Its flags.

        Returns
        -------
        Path
            The library.

        Raises
        ------
        InputError
            If there is no compiler, or it fails.
        """
        if command is None:
            raise InputError(
                "needs a compiler, and bristle found none",
                path="compiler",
                mend="Install gcc or clang",
            )
        line = [
            command,
            *flags,
            "-shared",
            "-fPIC",
            *(name for name in files if not name.endswith(".h")),
            "-o",
            "built",
            "-lm",
        ]
        folder = cache_folder() or _folder_of_process()
        library = (
            folder
            / f"native-{hashlib.sha256(repr((line, sorted(files.items()))).encode()).hexdigest()[:32]}.so"
        )
        if not library.exists():
            with tempfile.TemporaryDirectory(dir=folder, prefix="native-") as place:
                for name, text in files.items():
                    (Path(place) / name).write_text(text, encoding="ascii")
                built = subprocess.run(
                    line, cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False
                )
                if built.returncode:
                    raise InputError(
                        f"failed: {built.stderr.strip() or built.returncode}", path=command
                    )
                os.replace(Path(place) / "built", library)
        return library


def _key(model: Model) -> str:
    """Return the key of a compiled model: of its values, its functions, and all code of bristle."""
    component = model.component
    p = model.parameters
    state = component.initial_state(p)
    described = (
        model.name,
        model.kind,
        component.variables,
        variables_of(type(state)),
        state,
        component.memory_size(p),
        pack(p).tobytes(),
    )
    around = [surrounding.field for surrounding in getattr(component, "surroundings", ())]
    functions = fingerprint(component.trial, component.commit, type(component).assemble, *_types(p))
    return hashlib.sha256(
        repr((platform.machine(), described, around, functions, _code_of_bristle())).encode()
    ).hexdigest()[:32]


def _types(p: Any) -> list[type]:
    """Return the types of a tuple and of the tuples inside, whose names stand for their functions."""
    return [type(p), *(kind for part in p if hasattr(part, "_fields") for kind in _types(part))]


@cache
def _code_of_bristle() -> str:
    """Return the checksum of all modules and templates of bristle."""
    digest = hashlib.sha256()
    folders = [importlib.resources.files("bristle")]
    for folder in folders:  # which grows
        for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
            if entry.is_dir():
                folders.append(entry)
            elif entry.name.endswith((".py", ".c", ".h")):
                digest.update(entry.name.encode() + entry.read_bytes())
    return digest.hexdigest()


def _record(place: Path) -> dict[str, Any] | None:
    """Return the record of a compiled model; None if record or library is missing or damaged, and a damaged library is removed."""
    try:
        record = json.loads(place.read_text(encoding="ascii"))
        library = place.parent / record["library"]
        if hashlib.sha256(library.read_bytes()).hexdigest() != record["sha256"]:
            library.unlink()
            return None
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return record


def _write(place: Path, text: str) -> None:
    """Write a record whole."""
    with tempfile.TemporaryDirectory(dir=place.parent, prefix="native-") as folder:
        written = Path(folder) / "record"
        written.write_text(text, encoding="ascii")
        os.replace(written, place)


@cache
def _folder_of_process() -> Path:
    """Return a folder that exists until the process ends."""
    folder = tempfile.mkdtemp(prefix="bristle-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)

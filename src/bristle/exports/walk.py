"""C of a friction model along walks of many axes, with forward and reverse derivatives, for frameworks of automatic differentiation.

The reverse mode evaluates the derived step of `bristle.exports.c_derivatives` with an index in place of each tangent. A
linear operation on tangents then records its slopes on a tape, and a pass backward over the tape adds up the adjoints (S.
Linnainmaa, BIT 16(2), 1976, doi:10.1007/BF01931367). The tape contains only those numbers of the memory that a step reads.
"""

import atexit
import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core.contracts import Model
from bristle.core.errors import InputError
from bristle.engine.compilation import cache_folder
from bristle.exports.c import FLAGS, PATIENCE, CFiles, compiler, written_files
from bristle.exports.c_code import Printer
from bristle.exports.c_derivatives import DerivedStep, derived_step
from bristle.exports.described import rendered
from bristle.exports.subject import subject_of
from bristle.exports.targets import Request
from bristle.translation.directional import tangent_combined, tangent_difference, tangent_scaled, tangent_sum
from bristle.translation.tree import Function

RECORDED = {
    tangent_sum: "tape_sum(a, b)",
    tangent_difference: "tape_recorded(1.0, a, -1.0, b)",
    tangent_scaled: "tape_scaled(a, b)",
    tangent_combined: "tape_recorded(a, b, c, d)",
}
D_VELOCITY = "tape_recorded(1.0, tape_recorded(1.0 / dt, d_x_k, -1.0 / dt, at->position), -velocity / dt, d_dt_k)"
TEMPLATES = {"{}.h": "c/header.h", "{}.c": "c/source.c"}


class TapePrinter(Printer):
    """Prints functions whose linear operations on tangents record on a tape."""

    def definitions(self) -> str:
        """Return the tape, structures and functions."""
        return f'#include "tape.h"\n\n{super().definitions()}'

    def _function(self, function: Function) -> str:
        recorded = RECORDED.get(function.source)
        if recorded is None:
            return super()._function(function)
        arguments = ", ".join(f"double {argument.name}" for argument in function.parameters)
        return f"{self.inline} double {function.name}({arguments})\n{{\n    return {recorded};\n}}\n"


class TapeFiles(CFiles):
    """Files of a friction model whose derived step records on a tape."""

    printer = TapePrinter

    def facts(self) -> dict[str, Any]:
        """Return the facts of the templates."""
        return super().facts() | {"d_velocity": D_VELOCITY}


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
        derived = derived_step(subject_of(model), tunable=True)
        subject = derived.subject
        self.library = self.build(_files(derived), compiler(), ["-O2", *FLAGS.split()])
        self.parameters = {name: np.atleast_1d(value) for name, value in derived.tuned.values.items()}
        self.signals = {name: subject.usual[name] for name in subject.signals}
        self.start = np.array([0.0, 0.0, 0.0, *map(float, subject.virgin), *np.zeros(subject.memory_size)])
        self._functions = ctypes.CDLL(str(self.library))

    def run(self, function: str, lanes: int, steps: int, inputs: Sequence[np.ndarray], outputs: Sequence[np.ndarray]) -> None:
        """Run a function of the library on contiguous arrays of doubles."""
        pointers = [(ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays)) for arrays in (inputs, outputs)]
        result = getattr(self._functions, function)(ctypes.c_size_t(lanes), ctypes.c_size_t(steps), *pointers)
        if result:
            raise MemoryError if result == 1 else InputError("is not a state of this model", path="state")

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
            raise InputError("needs a compiler, and bristle found none", path="compiler", mend="Install gcc or clang")
        line = [command, *flags, "-shared", "-fPIC", *(name for name in files if not name.endswith(".h")), "-o", "built", "-lm"]
        folder = cache_folder() or _folder_of_process()
        library = folder / f"native-{hashlib.sha256(repr((line, sorted(files.items()))).encode()).hexdigest()[:32]}.so"
        if not library.exists():
            with tempfile.TemporaryDirectory(dir=folder, prefix="native-") as place:
                for name, text in files.items():
                    (Path(place) / name).write_text(text, encoding="ascii")
                built = subprocess.run(line, cwd=place, capture_output=True, text=True, timeout=PATIENCE, check=False)
                if built.returncode:
                    raise InputError(f"failed: {built.stderr.strip() or built.returncode}", path=command)
                os.replace(Path(place) / "built", library)
        return library


def _files(derived: DerivedStep) -> dict[str, str]:
    """Return the text of the C files by name."""
    subject, files = derived.subject, dict[str, str]()
    for name, kind in (("friction", CFiles), ("taped", TapeFiles)):
        request = Request(subject.model, name, 1e-3, tunable=True)
        files |= written_files(TEMPLATES, name, kind(subject, request, derived=derived).facts(), {}, request.source)
    facts = {"fields": derived.fields(Printer(subject.unit)), "memory": subject.memory_size, "signals": list(subject.signals)}
    return files | {"tape.h": rendered("c/tape.h", {}), "walk.c": rendered("c/walk.c", facts)}


@cache
def _folder_of_process() -> Path:
    """Return a folder that exists until the process ends."""
    folder = tempfile.mkdtemp(prefix="bristle-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)

"""Compilation of the entry points, and a disk cache without stale results.

The cache of the compiler returns stale results when a called function in another file changes, and a user's model file
can break every later process. This cache stores a product under a fingerprint of the compiled code and everything that
it refers to, together with the versions of Python and the compiler, and the processor. Products contain vectors and
tuples of vectors, but no class of a component.
"""

import contextlib
import hashlib
import itertools
import os
import pickle
import re
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bristle.core import InputError, dispatch
from bristle.core.exponent import exponent_in_bits, mantissa_in_bits, power_in_bits
from bristle.core.fingerprint import fingerprint
from bristle.core.kernel import activate, compiler, kernel_options
from bristle.core.locks import COMPILING
from bristle.core.packing import without_holder
from bristle.engine.signature import (
    compiled_signature,
    flat,
    handed_over,
    linked_into,
    signature_of,
    type_of,
)

_interpreted = ContextVar("interpreted", default=False)
_entries: dict[tuple[str, tuple[Any, ...]], Callable[..., Any]] = {}
_compiled: list[str] = []


def is_interpreted() -> bool:
    """Return whether entries run as plain Python: inside `interpreted`, or with NUMBA_DISABLE_JIT set."""
    return _interpreted.get() or os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")


@contextlib.contextmanager
def interpreted() -> Iterator[None]:
    """Run every entry as plain Python inside this block: the same functions, for study and for comparisons.

    This affects only the thread or task in the block and its workers.
    """
    before = _interpreted.set(True)
    try:
        yield
    finally:
        _interpreted.reset(before)


@lru_cache(maxsize=1)
def cache_folder() -> Path | None:
    """Return the folder of the cache, None without one: ``BRISTLE_CACHE_DIR`` overrides it, and switches the cache off if empty."""
    import platformdirs

    folder_name = os.environ.get("BRISTLE_CACHE_DIR")
    if folder_name == "":
        return None
    root = (
        Path(folder_name)
        if folder_name
        else Path(platformdirs.user_cache_dir("bristle", appauthor=False))
    )
    # The version comes from the metadata, because loading numba takes longer.
    folder = root / f"{sys.implementation.cache_tag}-numba-{version('numba')}"
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_own(folder):
            return None
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        return None
    return folder


def _is_own(folder: Path) -> bool:
    """Return whether no other user can write to the folder, because cached code is executed."""
    if not hasattr(os, "getuid"):
        return True
    status = folder.lstat()
    if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.getuid():
        return False
    if status.st_mode & 0o022:
        folder.chmod(0o700)
    return True


def _forget_old(folder: Path) -> None:
    """Remove products of this cache that were unused for a month."""
    limit = time.time() - 86400.0 * 30.0
    for file in folder.iterdir():
        with contextlib.suppress(OSError):
            if (
                re.search(r"-[0-9a-f]{16}\.bin$|\.partial$", file.name)
                and file.stat().st_mtime < limit
            ):
                file.unlink()


def compiled(
    name: str,
    make: Callable[[], Callable[..., Any]],
    kind: Any,
    parts: tuple[Any, ...] = (),
    interleaved: int = 1,
) -> Any:
    """Return a callable entry: compiled, loaded from the cache, or plain Python in interpreted mode."""
    if is_interpreted():
        return make()
    key = (name, parts)
    if key not in _entries:
        # Compiling changes counters and options of the whole process: one entry at a time.
        with COMPILING:
            if key not in _entries:
                function = make()
                code = fingerprint(handed_over(function, kind), *parts, *_MACHINERY)
                _entries[key] = _compile(name, function, kind, code, parts, interleaved)
    return _entries[key]


def driver(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a callable driver, which runs entries and is the same for all components."""
    if is_interpreted():
        return function
    entry = compiled(function.__name__, lambda: function, function)
    return lambda *arguments: entry(*flat(arguments))


def _compile(
    name: str,
    function: Callable[..., Any],
    kind: Any,
    code: str,
    parts: tuple[Any, ...],
    interleaved: int,
) -> Callable[..., Any]:
    numba = compiler()
    activate()
    signature = compiled_signature(kind)
    # It has one caller, and is inlined before compilation.
    body: Any = numba.njit(inline="always", error_model="numpy")(function)
    dispatcher: Any = numba.njit(**kernel_options(inline=False))(handed_over(function, kind, body))
    dispatcher._cache = _EntryCache(name, str(signature), f"{code} {interleaved}")
    with (
        _numbered_from(code),
        _faults_of(parts),
        _interleaving(interleaved),
        linked_into(dispatcher.py_func),
    ):
        dispatcher.compile(signature)
    dispatcher.disable_compile()
    product = _Product(dispatcher.get_compile_result(signature))
    dispatcher.get_compile_result = lambda _: product
    return dispatcher


class _Product:
    """The product of an entry, with cached addresses: the lookup of the compiler takes longer than a short run."""

    def __init__(self, product: Any) -> None:
        self.fndesc, self.library = product.fndesc, self
        self._addresses = {
            name: product.library.get_pointer_to_function(name)
            for name in (product.fndesc.llvm_cfunc_wrapper_name, product.fndesc.llvm_func_name)
        }

    def get_pointer_to_function(self, name: str) -> int:
        return self._addresses[name]


@contextlib.contextmanager
def _interleaving(count: int) -> Iterator[None]:
    """Compile loops over lanes inside this block with `count` interleaved vectors."""
    # A trajectory is a chain of dependent operations: interleaved, the processor works on several chains. The option is that
    # of the process.
    from llvmlite import binding

    if count > 1:
        binding.set_option("bristle", f"-force-vector-interleave={count}")
    try:
        yield
    finally:
        if count > 1:
            binding.set_option("bristle", "-force-vector-interleave=0")


@contextlib.contextmanager
def _faults_of(parts: tuple[Any, ...]) -> Iterator[None]:
    """Raise a failed compilation of a user's part as an `InputError` with file and reason."""
    from numba.core.errors import NumbaError

    try:
        yield
    except NumbaError as error:
        own = [part for part in parts if (part.__module__ or "").partition(".")[0] != "bristle"]
        if not own:
            raise
        file, lines = (
            own[0].__code__.co_filename,
            [line.strip() for line in str(error).splitlines()],
        )
        # The innermost reason follows the last heading; each level of calls adds a heading.
        heads = [i for i, line in enumerate(lines[:-1]) if "Failed in nopython mode" in line]
        reason = lines[heads[-1] + 1] if heads else lines[0]
        place = re.search(rf'File "[^"]*{re.escape(os.path.basename(file))}", line \d+', str(error))
        line = f", {place[0].rpartition(', ')[2]}" if place else ""
        raise InputError(
            f"cannot be compiled: {reason}", path=f"{file}{line}", mend=f"Try: bristle check {file}"
        ) from None


@contextlib.contextmanager
def _numbered_from(code: str) -> Iterator[None]:
    """Give functions that are compiled inside this block numbers that are unique to this code."""
    # The compiler numbers functions of a process; products of two processes with one name would confuse the linker of a
    # third.
    from numba.core.bytecode import FunctionIdentity

    counting: Any = FunctionIdentity
    before = counting._unique_ids
    counting._unique_ids = itertools.count(int(code[:16], 16) << 16)
    try:
        yield
    finally:
        counting._unique_ids = before


# Modules that turn kernels into machine code; a change of these changes products, too.
_MACHINERY = (
    type_of,
    signature_of,
    handed_over,
    kernel_options,
    dispatch.overload_all,
    power_in_bits,
    mantissa_in_bits,
    exponent_in_bits,
    without_holder,
    _interleaving,
)


class _EntryCache:
    """The interface of a cache for the compiler: load and save one product, one file each."""

    def __init__(self, name: str, signature: str, code: str) -> None:
        digest = hashlib.sha256(f"{name} {signature} {code}".encode()).hexdigest()[:16]
        self._file = f"{name.replace('/', '-')}-{digest}.bin"
        self._name = name

    def load_overload(self, signature: Any, target: Any) -> Any:
        from numba.core.compiler import CompileResult

        folder = cache_folder()
        target.refresh()
        if folder is None:
            return None
        try:
            content = (folder / self._file).read_bytes()
            os.utime(folder / self._file)
        except OSError:
            return None
        checksum, payload = content[:32], content[32:]
        if hashlib.sha256(payload).digest() != checksum:
            return None
        try:
            machine, reduced = pickle.loads(payload)
            if machine != target.codegen().magic_tuple():
                return None
            return CompileResult._rebuild(target, *reduced)
        except (ImportError, AttributeError):
            return None  # the same code is in a module of another name now

    def save_overload(self, signature: Any, product: Any) -> None:
        from numba.core.serialize import dumps

        _compiled.append(self._name)
        folder = cache_folder()
        if folder is None:
            return
        payload = dumps((product.codegen.magic_tuple(), product._reduce()))
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(payload).digest() + payload)
            os.replace(temporary, folder / self._file)
            _forget_old(folder)
        except OSError:
            # A full disk only costs time in the next process.
            with contextlib.suppress(OSError):
                os.unlink(temporary)

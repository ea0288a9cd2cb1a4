"""Permission to run code that a file names, in the state folder of the user: for this content by its hash, or for one run."""

import os
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from bristle.core.content import Content, FixedLimit, Readable, content_of
from bristle.core.edge import FLAG
from bristle.core.errors import InputError, InputWarning


def state_folder(name: str, *, makes: bool = True) -> Path:
    """Return a private state folder; make it if it is missing and `makes`."""
    import platformdirs

    chosen = os.environ.get("BRISTLE_STATE_DIR")
    root = Path(chosen) if chosen else Path(platformdirs.user_state_dir("bristle", appauthor=False))
    folder = root / name
    if makes:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder


CODE_LIMIT = FixedLimit(2**20)  # largest file of code [byte]
NAMELESS = ("<bytes>", "<file>", "<stdin>")  # Names of inputs that were not read from a file
CodeRead = Callable[[str, str], Content]
"""Function that reads code, from the name of its file and the key that names the file."""


def code_at(path: Readable) -> Content:
    """Return a Python file to run; bytes and open files without a name count as Python files."""
    content = content_of(path, limit=CODE_LIMIT, what="a Python file")
    source = content.source
    if not source.name.endswith(".py") and str(source) not in NAMELESS:
        mend = f"If it contains Python code, rename it to {source.stem.removesuffix('.py')}.py"
        mend = (
            f'Read a model file with bristle.read_model("{source.name}")'
            if source.suffix == ".toml"
            else mend
        )
        value = source.suffix or source.name
        raise InputError(
            "is not a Python file, so bristle does not run it",
            path=str(source),
            value=value,
            allowed="a name that ends with .py",
            mend=mend,
        )
    return content


def code_named(file: str, path: str, *, folder: Path, allow_code: bool) -> Content:
    """Return the code in a file if it may run."""
    allowed = FLAG(allow_code, "allow_code", None)
    source = folder / file
    try:
        inside = folder.resolve() in source.resolve().parents
    except (OSError, ValueError, RuntimeError):
        inside = True  # reading it raises the right error
    if not inside:
        raise InputError(
            "names code in another folder, so bristle does not run it",
            path=path,
            value=file,
            allowed="a file in this folder or below",
            mend="Copy the code to the folder of the file that names it",
        )
    content = content_of(source, limit=CODE_LIMIT, path=path)
    description = f"{content.source.name} (SHA-256 {content.checksum})"
    if not allowed and not is_allowed(content.checksum):
        mend = "Read the code. Then add --allow-code (allow_code=True in Python) for this run, or allow this content permanently"
        raise InputError(
            f"names code that needs permission to run: {description}",
            path=path,
            mend=f"{mend}: bristle check {source}",
        )
    warnings.warn(f"{path}: the code in {description} is run", InputWarning, stacklevel=2)
    return content


def is_allowed(checksum: str) -> bool:
    """Return whether the code with this SHA-256 was allowed before."""
    try:
        return (state_folder("allowed-code") / checksum).is_file()
    except OSError:
        return False


def allow(content: Content) -> None:
    """Record that code with this SHA-256 may run; warn if the record cannot be written."""
    if is_allowed(content.checksum):
        return
    record = None
    try:
        record = state_folder("allowed-code") / content.checksum
        record.write_text(
            f"{content.source.name}\n{time.strftime('%Y-%m-%d')}\n",
            encoding="utf-8",
            errors="replace",
        )
    except OSError as error:
        if record is not None:  # an incomplete record on a full disk would also allow it
            with suppress(OSError):
                record.unlink()
        remark = (
            f"{content.source.name}: cannot save the permission to run its code ({error.strerror})"
        )
        warnings.warn(remark, InputWarning, stacklevel=2)

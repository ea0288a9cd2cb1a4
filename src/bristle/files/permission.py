"""Code that a file names runs only if this person allowed it: that very content by its hash, or everything this once.

What was allowed is kept in the state folder of the person, never in a file that travels.
"""

import os
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from bristle.core.content import Content, FixedLimit, Readable, content_of
from bristle.core.edge import FLAG
from bristle.core.errors import InputError, InputWarning


def state_folder(name: str) -> Path:
    """Return a folder to remember something in, made where there is none; nobody else can look into it."""
    import platformdirs

    chosen = os.environ.get("BRISTLE_STATE_DIR")
    root = Path(chosen) if chosen else Path(platformdirs.user_state_dir("bristle", appauthor=False))
    folder = root / name
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder


CODE_LIMIT = FixedLimit(2**20)  # largest file of code [byte]
NAMELESS = ("<bytes>", "<file>", "<stdin>")  # What stands for the name of what was read from no file
CodeRead = Callable[[str, str], Content]
"""What reads the code that a file names, by its name as it is written and the key that it stands under."""


def code_at(path: Readable) -> Content:
    """Return a Python file that is about to be run; bytes and open files without a name are taken for one."""
    content = content_of(path, limit=CODE_LIMIT, what="a Python file")
    source = content.source
    if not source.name.endswith(".py") and str(source) not in NAMELESS:
        mend = f"If it holds Python, rename it to {source.stem.removesuffix('.py')}.py"
        mend = f'A model file is read by bristle.read_model("{source.name}")' if source.suffix == ".toml" else mend
        message, value = "is not a Python file and is not run", source.suffix or source.name
        raise InputError(message, path=str(source), value=value, allowed="a name that ends with .py", mend=mend)
    return content


def code_named(file: str, path: str, *, folder: Path, allow_code: bool) -> Content:
    """Return the code that a file names, if it may run."""
    allowed = FLAG(allow_code, "allow_code", None)
    source = folder / file
    try:
        inside = folder.resolve() in source.resolve().parents
    except (OSError, ValueError, RuntimeError):
        inside = True  # reading it will tell what is wrong
    if not inside:
        message, beside = "names code elsewhere, which is not run", "a file beside or below the one that names it"
        raise InputError(message, path=path, value=file, allowed=beside, mend="Copy it there")
    content = content_of(source, limit=CODE_LIMIT, path=path)
    description = f"{content.source.name} (SHA-256 {content.checksum})"
    if not allowed and not is_allowed(content.checksum):
        mend = "Read it. Then add --allow-code (allow_code=True in Python) for this once, or allow this very content from now on"
        raise InputError(f"names code, which is not run unasked: {description}", path=path, mend=f"{mend}: bristle check {source}")
    warnings.warn(f"{path}: the code in {description} is run", InputWarning, stacklevel=2)
    return content


def is_allowed(checksum: str) -> bool:
    """Return whether the code with this SHA-256 was allowed before."""
    try:
        return (state_folder("allowed-code") / checksum).is_file()
    except OSError:
        return False


def allow(content: Content) -> None:
    """Record that code of this SHA-256 may run; warn where the record cannot be written."""
    if is_allowed(content.checksum):
        return
    record = None
    try:
        record = state_folder("allowed-code") / content.checksum
        record.write_text(f"{content.source.name}\n{time.strftime('%Y-%m-%d')}\n", encoding="utf-8", errors="replace")
    except OSError as error:
        if record is not None:  # half of it, on a full disk, would allow it as well
            with suppress(OSError):
                record.unlink()
        remark = f"{content.source.name}: that its code was allowed cannot be remembered ({error.strerror})"
        warnings.warn(remark, InputWarning, stacklevel=2)

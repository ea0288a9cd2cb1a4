"""A folder of results appears whole or not at all.

Everything is written to ``DIR.partial`` beside the folder wanted. Only when all of it is there and synced to
the disk is it renamed to ``DIR``; results that were there before are moved aside first and removed last. Whatever
ends the program in between (an error, a full disk, Ctrl-C, a kill) leaves either the old results or the new ones.
Files of a person's own in a folder of results are never removed: it is not replaced while there are any.
"""

from __future__ import annotations

import errno
import json
import os
import re
import secrets
import shutil
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path

from bristle.core.errors import InputError, InputWarning

__all__ = ["SUMMARY", "results_folder"]

SUMMARY = "summary.json"
"""The file that every folder of results holds, and by which it is known as one."""

WRITTEN = frozenset({SUMMARY, "report.html", "model.toml", "drive_table.csv"})
WRITTEN_BY_DEMO = frozenset({"axis.toml", "log.csv", "unseen.csv"})
WRITTEN_BY_EXCITE = frozenset({"axis.toml", "motion.csv"})
LOG = re.compile(r"log(_[\w.-]+)?\.csv")
NAMES_SHOWN = 5
ATTEMPTS = 100
_WRITING = {errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EROFS, errno.EIO}


@contextmanager
def results_folder(out: str | os.PathLike[str], *, force: bool = False) -> Iterator[Path]:
    """Give a folder to write results into; leaving the block without an error makes it appear as `out`.

    What would prevent that (`out` exists, no place to write) is refused on entry, before any work is done.

    Parameters
    ----------
    out : path
        The folder wanted. Its parent must exist.
    force : bool
        Whether results that are there already are replaced.

    Yields
    ------
    Path
        The folder to write into, empty.

    Raises
    ------
    InputError
        If `out` cannot be made, is in use by another process, or the disk does not take what is written.
    """
    wanted = Path(out).resolve()
    partial = wanted.with_name(f"{wanted.name}.partial")
    _check_parent(wanted)
    owner, is_claimed = None, False
    try:
        owner, is_claimed = _claim(partial, wanted), True
        _restore(partial, wanted)
        _check_free(wanted, force)
        _empty(partial)
        yield partial
        _publish(partial, wanted)
    except BaseException as error:
        if is_claimed:
            shutil.rmtree(partial, ignore_errors=True)
        elif isinstance(error, KeyboardInterrupt):
            # It came between making the folder and knowing it as ours; what another process has written into stays.
            with suppress(OSError):
                partial.rmdir()
        if isinstance(error, OSError) and (error.errno in _WRITING or str(error.filename).startswith(str(wanted))):
            raise _unwritable(wanted, error) from error
        raise
    finally:
        if owner is not None:
            os.close(owner)


def _check_parent(wanted: Path) -> None:
    parent = wanted.parent
    if not parent.is_dir():
        raise InputError("the folder that is to hold it does not exist", path=str(wanted), mend=f"Make {parent} first")
    if not os.access(parent, os.W_OK | os.X_OK):
        raise InputError("no permission to write there", path=str(wanted), mend="Name a folder of your own")


def _check_free(wanted: Path, force: bool) -> None:
    if not wanted.exists():
        return
    if not wanted.is_dir():
        raise InputError("is a file, not a folder", path=str(wanted), mend="Name another folder")
    if wanted.is_mount():
        raise InputError("is a mount point and cannot be renamed", path=str(wanted), mend="Name a folder inside it")
    if any(wanted.iterdir()) and not (wanted / SUMMARY).is_file():
        raise InputError(
            f"holds something else than results (no {SUMMARY})", path=str(wanted), mend="Name another folder"
        )
    if not force:
        raise InputError(
            "exists already",
            path=str(wanted),
            mend="Name another folder, or add --force to replace these results",
        )
    _keep_own_files(wanted)


def _keep_own_files(folder: Path) -> None:
    """Refuse to replace a folder that holds, besides results, files that a person put there."""
    ours = WRITTEN | _named_in(folder)
    own = sorted(one.name for one in folder.iterdir() if one.name not in ours or one.is_dir())
    if own:
        more = f" and {len(own) - NAMES_SHOWN} more" if len(own) > NAMES_SHOWN else ""
        raise InputError(
            f"holds files besides the results: {', '.join(own[:NAMES_SHOWN])}{more}", path=str(folder),
            mend="Move them elsewhere, for the whole folder is replaced, or name another folder",
        )  # fmt: skip


def _named_in(folder: Path) -> frozenset[str]:
    """Return further files that the results say are part of them: a user's model, logs, a motion."""
    names: frozenset[str] = frozenset()
    with suppress(OSError, ValueError, LookupError, TypeError):
        names |= {tomllib.loads((folder / "model.toml").read_text(encoding="utf-8"))["friction"]["file"]}
    with suppress(OSError, ValueError, LookupError, TypeError):
        if json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["simulated"]:
            names |= WRITTEN_BY_DEMO
    with suppress(OSError, ValueError, LookupError, TypeError, AttributeError):
        named = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["files"].values()
        names |= {name for name in named if name in WRITTEN_BY_EXCITE or LOG.fullmatch(name)}
    return names


def _claim(partial: Path, wanted: Path) -> int | None:
    """Make the folder to write into and lock it; the lock ends with the process, however that ends."""
    if find_spec("fcntl") is None:  # without such locks the folder itself is the lock, and a stale one is reported
        try:
            partial.mkdir()
        except FileExistsError:
            raise _in_use(wanted, f"If no bristle is running, delete {partial}") from None
        return None
    try:
        for _ in range(ATTEMPTS):
            owner = _locked(partial)
            if owner is not None:
                return owner
    except BlockingIOError:
        raise _in_use(wanted, "Wait for it to end, or name another folder") from None
    except OSError as error:
        raise _unwritable(wanted, error) from error
    raise _unwritable(wanted, FileExistsError(errno.EEXIST, f"{partial.name} is in the way"))


def _locked(partial: Path) -> int | None:
    """Return the folder, made and locked; None where its former owner renamed or removed it in between."""
    import fcntl

    try:
        partial.mkdir(exist_ok=True)
        owner = os.open(partial, os.O_RDONLY | os.O_DIRECTORY)
    except (FileNotFoundError, FileExistsError):
        return None
    kept = False
    try:
        fcntl.flock(owner, fcntl.LOCK_EX | fcntl.LOCK_NB)
        kept = partial.exists() and os.path.samestat(os.fstat(owner), partial.stat())
    except FileNotFoundError:
        return None
    finally:
        if not kept:
            os.close(owner)
    return owner if kept else None


def _restore(partial: Path, wanted: Path) -> None:
    """Set right what a process left that was killed while it replaced results.

    Killed between the two renames, it left the old results aside and the new ones unnamed: the old ones come back.
    Killed later, it left them to be removed.
    """
    aside = [one for one in wanted.parent.iterdir() if re.fullmatch(re.escape(wanted.name) + r"\.old-\w{8}", one.name)]
    if aside and not wanted.exists() and any(partial.iterdir()):
        os.rename(aside.pop(), wanted)
    if wanted.exists():
        for one in aside:
            shutil.rmtree(one, ignore_errors=True)


def _empty(folder: Path) -> None:
    for one in folder.iterdir():
        if one.is_dir() and not one.is_symlink():
            shutil.rmtree(one)
        else:
            one.unlink()


def _publish(partial: Path, wanted: Path) -> None:
    if not (partial / SUMMARY).is_file():
        raise RuntimeError(f"results without {SUMMARY}")
    _sync(partial)
    if wanted.exists():
        _keep_own_files(wanted)
    aside = wanted.with_name(f"{wanted.name}.old-{secrets.token_hex(4)}")
    try:
        if wanted.exists():
            os.rename(wanted, aside)
        os.rename(partial, wanted)
        _sync_folder(wanted.parent)
    finally:
        if aside.exists() and not wanted.exists():
            os.rename(aside, wanted)
        shutil.rmtree(aside, ignore_errors=True)
    if aside.exists():
        warnings.warn(f"{aside}: the results replaced could not be removed", InputWarning, stacklevel=2)


def _sync(folder: Path) -> None:
    for place, _, names in os.walk(folder, topdown=False):
        for name in names:
            with open(os.path.join(place, name), "rb+") as file:
                os.fsync(file.fileno())
        _sync_folder(Path(place))


def _sync_folder(folder: Path) -> None:
    if os.name != "posix":
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)


def _unwritable(wanted: Path, error: OSError) -> InputError:
    return InputError(
        f"the results cannot be written: {(error.strerror or str(error)).lower()}",
        path=str(wanted),
        mend="Nothing was changed there. Make room, or name a folder elsewhere",
    )


def _in_use(wanted: Path, mend: str) -> InputError:
    return InputError("another process is writing results there", path=str(wanted), mend=mend)

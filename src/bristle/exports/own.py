"""A target of a user's own: one Python file, the package unchanged."""

from __future__ import annotations

from bristle.core.content import Readable
from bristle.core.errors import InputError
from bristle.exports.target import Target
from bristle.exports.targets import TARGETS
from bristle.exports.writing import NAME
from bristle.files.permission import code_at
from bristle.files.user_model import declared_in

__all__ = ["load_target_file"]

MEND = 'End the file with TARGET = Target(name="my_drive", description="...", write=write)'


def load_target_file(path: Readable) -> Target:
    """Return the target that a Python file defines as ``TARGET``.

    Parameters
    ----------
    path : path-like, bytes, file object or Content
        A Python file with ``TARGET = Target(name=..., description=..., write=write)``, from `bristle.exports`. It is
        executed.

    Returns
    -------
    Target
        The target, for `bristle.export`.

    Raises
    ------
    InputError
        If the file cannot be read or run, defines no target, or gives it a name that it cannot have.
    """
    content = code_at(path)
    target = declared_in(content, "TARGET", Target, title="target of the export", mend=MEND)
    source = str(content.source)
    if not callable(target.write):
        raise InputError("its target writes nothing", path=source, value=target.write, mend=MEND)
    if not isinstance(target.name, str) or not NAME.fullmatch(target.name) or target.name in TARGETS:
        raise InputError(
            "gives its target a name that it cannot have",
            path=source,
            value=target.name,
            allowed="small letters, digits and _, a letter first, and no name of a target of bristle",
        )
    if not isinstance(target.description, str) or not target.description.strip():
        raise InputError("does not say what its target is", path=source, mend='Write description="..."')
    return target

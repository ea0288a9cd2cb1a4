"""Models and slots of a person's own, named on the command line: what is named there may run, and is remembered."""

from __future__ import annotations

from typing import Any

__all__ = ["holds_own", "own_model"]


def holds_own(name: str) -> bool:
    """Return whether a name holds a file of a model or a slot, ``my_model.py+asymmetry`` or ``lugre+my_slot.py``."""
    return any(part.endswith(".py") for part in name.split("+"))


def own_model(name: str, path: str) -> Any:
    """Return the friction model of a name that holds files; they are executed, tried, and allowed from now on."""
    from bristle.core.content import Content, content_of
    from bristle.files.permission import CODE_LIMIT, allow
    from bristle.files.user_model import load_code, slots_in
    from bristle.friction import base_of, find, with_slots
    from bristle.testing import admit

    contents: list[Content] = []

    def read(file: str, path: str) -> Content:
        contents.append(content_of(file, limit=CODE_LIMIT))
        return contents[-1]

    base, *slots = name.split("+")
    model = load_code(read(base, path)) if base.endswith(".py") else base_of(find(base, path))
    chosen = with_slots(model, slots_in(slots, path, read), path)
    admit(chosen)
    for content in contents:
        allow(content)
    return chosen

"""From kernels to the typed tree: names are resolved, types follow from those of the arguments, a function a type.

What cannot be built is what a kernel must not contain: there is no other description of the subset. A kernel is built
once for each combination of types that it is called with; a call of the dispatch goes to the kernel of the component
whose parameters are handed on last. Loops, tuples and choices stay what they are: each target lowers what it lacks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from bristle.core.dispatch import implementation_of, is_dispatch
from bristle.exports.names import ascii_name
from bristle.exports.scope import NotExportableError, definition_of
from bristle.exports.statements import Translation
from bristle.exports.tree import Function, Unit
from bristle.exports.types import Struct, Type

__all__ = ["Builder"]

FACE = frozenset(("effort", "example", "force", "force_at", "inputs", "load", "output", "parameters", "save", "selftest", "start"))
"""What the functions and types of an export are called, behind its name."""
DEEPEST = 100  # calls inside of calls


@dataclass
class Builder:
    """Builds the functions of a unit as they are asked for."""

    constants: dict[tuple[str, float], float] = field(default_factory=dict)
    unit: Unit = field(default_factory=Unit)

    def __post_init__(self) -> None:
        self._built: dict[tuple[Any, ...], Function] = {}
        self._open: list[tuple[Any, ...]] = []
        self._names: set[str] = set()

    def function(self, called: Callable[..., Any], types: Sequence[Type]) -> Function:
        """Return a kernel, or what the dispatch chooses, for arguments of these types."""
        kernel = self._chosen(called, types)
        key = (kernel, *types)
        if key not in self._built:
            self._built[key] = self._build(kernel, types)
        return self._built[key]

    def _chosen(self, called: Callable[..., Any], types: Sequence[Type]) -> Callable[..., Any]:
        if not is_dispatch(called):
            return called
        last = types[-1]
        kernel = implementation_of(called, last.cls) if isinstance(last, Struct) else None
        if kernel is None:
            name = last.cls.__qualname__ if isinstance(last, Struct) else "what it is given"
            raise NotExportableError(called, None, f"there is none for {name}")
        return kernel

    def _build(self, kernel: Callable[..., Any], types: Sequence[Type]) -> Function:
        # A model around a model around a model has one kernel for all of them, each time of other types.
        if (kernel, *types) in self._open or len(self._open) > DEEPEST:
            raise NotExportableError(kernel, None, "calls itself: a kernel takes as long as its loops are, no longer")
        definition = definition_of(kernel)
        if len(definition.args.args) != len(types):
            raise NotExportableError(kernel, definition, f"takes {len(definition.args.args)} arguments, not {len(types)}")
        self._open.append((kernel, *types))
        try:
            translated = Translation(self, kernel, types).function(self._name_for(kernel))
        finally:
            self._open.pop()
        self.unit.functions.append(translated)
        return translated

    def _name_for(self, kernel: Callable[..., Any]) -> str:
        """Return a name that no other function has: the kernel's own behind that of its module.

        What is exported may be called as a module is, and its own functions are called by these words behind that.
        """
        module = kernel.__module__.rpartition(".")[2]
        module = "own" if module.startswith("bristle_user_") else module
        own = ascii_name(kernel.__name__.lstrip("_"))
        first = f"{module}_{own}_kernel" if own in FACE else f"{module}_{own}"
        name, count = first, 1
        while name in self._names:
            count += 1
            name = f"{first}_{count}"
        self._names.add(name)
        return name

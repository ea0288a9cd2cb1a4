"""Lazy loading: each name of a package is imported from its module at first use, and former names are refused."""

import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import Any


def loaded_from(
    package: str, *, above: Mapping[str, str] = MappingProxyType({})
) -> Callable[[str], Any]:
    """Return a ``__getattr__`` for a package that imports its names at first use, from the ``if TYPE_CHECKING:`` block.

    `above` gives the modules of names that stand in a room above the package, which it does not import.
    """

    @cache
    def places() -> dict[str, tuple[str, str]]:
        """Return the module of each name and the name in it."""
        import ast  # only when needed

        loader: Any = sys.modules[package].__loader__
        tree = ast.parse(loader.get_source(package))  # works for folders and zip files
        blocks = [node for node in tree.body if isinstance(node, ast.If)]
        imports = [
            node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)
        ]
        own = {
            alias.asname or alias.name: (str(node.module), alias.name)
            for node in imports
            for alias in node.names
        }
        return own | {name: (module, name) for name, module in above.items()}

    def load(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        if name not in places():
            from bristle.core.former import refusal

            unknown = f"module {package!r} has no attribute {name!r}"
            raise AttributeError(refusal(package, name) or unknown)
        module, inner = places()[name]
        if module == package:
            return import_module(f"{package}.{inner}")
        return getattr(import_module(module), inner)

    names = vars(sys.modules[package])
    # For completion
    names["__dir__"] = lambda: sorted({*names, *names.get("__all__", ()), *places()})
    return load

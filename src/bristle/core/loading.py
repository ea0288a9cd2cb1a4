"""Lazy loading: each name of a package is imported from its module at first use, and former names are refused."""

import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType
from typing import Any

from bristle.core.former import refusal


@cache
def places(package: str) -> dict[str, tuple[str, str]]:
    """Return the module of each name below ``if TYPE_CHECKING:`` of a package, and the name in it."""
    import ast  # only when needed

    loader: Any = sys.modules[package].__loader__
    tree = ast.parse(loader.get_source(package))  # works for folders and zip files
    blocks = [node for node in tree.body if isinstance(node, ast.If)]
    imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
    return {
        alias.asname or alias.name: (str(node.module), alias.name)
        for node in imports
        for alias in node.names
    }


class Package(ModuleType):
    """A package in which an offered name stands for a function or a component, also if its module has the same name."""

    def __setattr__(self, name: str, value: object) -> None:
        # Python sets each imported module in its package.
        if isinstance(value, ModuleType) and name in vars(value) and name in places(self.__name__):
            value = getattr(value, name)
        super().__setattr__(name, value)


def loaded_from(
    package: str, *, above: Mapping[str, str] = MappingProxyType({})
) -> Callable[[str], Any]:
    """Return a ``__getattr__`` for a package that imports its names at first use, from the ``if TYPE_CHECKING:`` block.

    `above` gives the modules of names that stand in a room above the package, which it does not import.
    """

    def load(name: str) -> Any:
        if name in above:
            return getattr(import_module(above[name]), name)
        if name.startswith("__") or name not in places(package):
            unknown = f"module {package!r} has no attribute {name!r}"
            raise AttributeError(refusal(package, name) or unknown)
        place, inner = places(package)[name]
        if place == package:
            return import_module(f"{package}.{inner}")
        return getattr(import_module(place), inner)

    module = sys.modules[package]
    module.__class__ = Package
    names = vars(module)
    for name, value in dict(names).items():  # modules that the package imported so far
        setattr(module, name, value)
    # For completion
    names["__dir__"] = lambda: sorted({*names, *names.get("__all__", ()), *places(package), *above})
    return load

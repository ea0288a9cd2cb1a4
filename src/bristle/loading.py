"""Names that packages offer, each loaded from its module when it is first asked for. It loads nothing itself."""

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any


def loaded_from(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of a package that loads names when they are first asked for, as its ``if TYPE_CHECKING:`` imports them."""

    @cache
    def places() -> dict[str, tuple[str, str]]:
        """Return the module of each name, and its name there."""
        import ast  # which nobody waits for who asks for no name

        loader: Any = sys.modules[package].__loader__
        tree = ast.parse(loader.get_source(package))  # which a loader has of a folder, and of a zip file
        blocks = [node for node in tree.body if isinstance(node, ast.If)]
        imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
        return {alias.asname or alias.name: (str(node.module), alias.name) for node in imports for alias in node.names}

    def load(name: str) -> Any:
        if name.startswith("__") or name not in places():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, inner = places()[name]
        return import_module(f"{package}.{inner}") if module == package else getattr(import_module(module), inner)

    names = vars(sys.modules[package])
    names["__dir__"] = lambda: sorted({*names, *names.get("__all__", ()), *places()})  # for completion
    return load

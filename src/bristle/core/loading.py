"""Lazy loading: each name of a package is imported from its module at first use, and former names are refused."""

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from types import MappingProxyType, ModuleType
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
            raise AttributeError(
                refusal(package, name, f"module {package!r} has no attribute {name!r}")
            )
        module, inner = places()[name]
        if module != package:
            home = import_module(module)
            if hasattr(home, inner):
                return getattr(home, inner)
        return import_module(f"{module}.{inner}")

    names = vars(sys.modules[package])
    names["__dir__"] = lambda: sorted(
        {*names, *names.get("__all__", ()), *places()}
    )  # for completion
    return load


def successor(*names: str) -> str:
    """Return what replaces the first former name among `names`; empty if there is none."""
    from bristle.core.former import FORMER

    return next((FORMER[name] for name in names if name in FORMER), "")


def refusal(package: str, name: str, otherwise: str) -> str:
    """Return the sentences that refuse a former name of a package, or others if there was no such name."""
    advice = successor(f"{package}.{name}", f"{package}.*")
    if advice:
        return f"{package}.{name} does not exist. {advice}"
    return otherwise


class FormerNames:
    """The last finder of Python: it finds nothing, and refuses former modules and names with their successor."""

    @staticmethod
    def find_spec(
        fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> None:
        """Refuse a former name; leave other names to the error of Python."""
        package, _, name = fullname.rpartition(".")
        if package.partition(".")[0] != "bristle":
            return
        refused = refusal(package, name, "")
        if refused:
            raise ModuleNotFoundError(refused)


sys.meta_path.append(FormerNames())

"""Which tests concern a module: those that reach it by the fewest imports, those that name it first."""

from __future__ import annotations

import ast
import re
from collections import deque
from pathlib import Path

from bristle.core.lazy import cached_property

__all__ = ["Imports"]


class Imports:
    """Who imports what, in the package and its tests, without running any of it.

    Parameters
    ----------
    root : Path
        Of the repository.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self.files = {
            self.name_of(item): item
            for folder in ("src", "tests")
            for item in (root / folder).rglob("*.py")
        }
        self.texts = {name: item.read_text(encoding="utf-8") for name, item in self.files.items()}
        self.trees = {name: ast.parse(text) for name, text in self.texts.items()}
        self.handed_on = {name: self._handed_on(name) for name in self.files}

    def name_of(self, file: Path) -> str:
        """Return the name that a file is imported by."""
        parts = file.relative_to(self.root).with_suffix("").parts
        parts = parts[1:] if parts[0] == "src" else parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    @cached_property
    def importers(self) -> dict[str, set[str]]:
        """The modules that import a module."""
        result: dict[str, set[str]] = {name: set() for name in self.files}
        for name in self.files:
            for other in self._imported_by(name):
                if other in result and other != name:
                    result[other].add(name)
        return result

    def tests_of(self, path: str) -> list[str]:
        """Return the test files that reach a file of the package, the nearest first."""
        module = self.name_of(self.root / path)
        far = self._distances(module)
        folder, stem = path.split("/")[-2], module.rpartition(".")[2]
        names = [
            test.name
            for test in self.trees[module].body
            if isinstance(test, ast.FunctionDef | ast.ClassDef)
        ]
        words = re.compile(rf"\b({'|'.join(map(re.escape, (stem, *names)))})\b")

        def place(name: str) -> tuple[bool, int, bool, int, str]:
            other_folder = f".{folder}." not in name
            other_name = other_folder or not name.endswith(f".test_{stem}")
            return other_name, far[name], other_folder, -len(words.findall(self.texts[name])), name

        tests = [test for test in far if re.fullmatch(r"tests\..*\btest_\w+", test)]
        return [
            self.files[test].relative_to(self.root).as_posix() for test in sorted(tests, key=place)
        ]

    def _distances(self, module: str) -> dict[str, int]:
        far, waiting = {module: 0}, deque([module])
        while waiting:
            name = waiting.popleft()
            for other in self.importers[name]:
                if other not in far:
                    far[other] = far[name] + 1
                    waiting.append(other)
        return far

    def _handed_on(self, name: str) -> dict[str, str]:
        """Return where the names come from that a module has from others."""
        result = {}
        for node in ast.walk(self.trees[name]):
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                result |= {
                    item.asname or item.name: f"{node.module}.{item.name}" for item in node.names
                }
        return result

    def _imported_by(self, name: str) -> set[str]:
        requested = set() if name == "bristle" else set(self.handed_on[name].values())
        packages = {"bristle"}
        for node in ast.walk(self.trees[name]):
            if isinstance(node, ast.Import):
                requested |= {item.name for item in node.names}
                packages |= {item.asname or item.name for item in node.names}
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                # A name of a package that is itself imported: `engine.force_along`, `br.response`.
                whole = self.handed_on[name].get(node.value.id, node.value.id)
                whole = "bristle" if whole == "br" else whole
                if f"{whole}.__init__" in self._packages:
                    requested.add(f"{whole}.{node.attr}")
        return {module for item in requested if (module := self._module_of(item)) is not None}

    @cached_property
    def _packages(self) -> set[str]:
        return {
            f"{name}.__init__" for name, file in self.files.items() if file.name == "__init__.py"
        }

    def _module_of(self, dotted: str, depth: int = 0) -> str | None:
        """Return the module that a dotted name leads to: itself, or where its package has the name from."""
        if dotted in self.files:
            return dotted
        package, _, last = dotted.rpartition(".")
        if package not in self.files:
            return None
        further = self.handed_on[package].get(last)
        return self._module_of(further, depth + 1) or package if further and depth < 5 else package

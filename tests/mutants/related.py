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
        self.files = {self.name_of(one): one for folder in ("src", "tests") for one in (root / folder).rglob("*.py")}
        self.texts = {name: one.read_text(encoding="utf-8") for name, one in self.files.items()}
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
        found: dict[str, set[str]] = {name: set() for name in self.files}
        for name in self.files:
            for other in self._imported_by(name):
                if other in found and other != name:
                    found[other].add(name)
        return found

    def tests_of(self, path: str) -> list[str]:
        """Return the test files that reach a file of the package, the nearest first."""
        module = self.name_of(self.root / path)
        far = self._distances(module)
        folder, stem = path.split("/")[2], module.rpartition(".")[2]
        names = [one.name for one in self.trees[module].body if isinstance(one, ast.FunctionDef | ast.ClassDef)]
        words = re.compile(rf"\b({'|'.join(map(re.escape, (stem, *names)))})\b")

        def place(name: str) -> tuple[bool, int, bool, int, str]:
            other_name, other_folder = not name.endswith(f".test_{stem}"), f".{folder}." not in name
            return other_name, far[name], other_folder, -len(words.findall(self.texts[name])), name

        tests = [one for one in far if re.fullmatch(r"tests\..*\btest_\w+", one)]
        return [self.files[one].relative_to(self.root).as_posix() for one in sorted(tests, key=place)]

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
        found = {}
        for node in ast.walk(self.trees[name]):
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found |= {one.asname or one.name: f"{node.module}.{one.name}" for one in node.names}
        return found

    def _imported_by(self, name: str) -> set[str]:
        asked = set() if name == "bristle" else set(self.handed_on[name].values())
        packages = {"bristle"}
        for node in ast.walk(self.trees[name]):
            if isinstance(node, ast.Import):
                asked |= {one.name for one in node.names}
                packages |= {one.asname or one.name for one in node.names}
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                # A name of a package that is itself imported: `engine.force_along`, `br.response`.
                whole = self.handed_on[name].get(node.value.id, node.value.id)
                whole = "bristle" if whole == "br" else whole
                if f"{whole}.__init__" in self._packages:
                    asked.add(f"{whole}.{node.attr}")
        return {module for one in asked if (module := self._module_of(one)) is not None}

    @cached_property
    def _packages(self) -> set[str]:
        return {f"{name}.__init__" for name, file in self.files.items() if file.name == "__init__.py"}

    def _module_of(self, dotted: str, depth: int = 0) -> str | None:
        """Return the module that a dotted name leads to: itself, or where its package has the name from."""
        if dotted in self.files:
            return dotted
        package, _, last = dotted.rpartition(".")
        if package not in self.files:
            return None
        further = self.handed_on[package].get(last)
        return self._module_of(further, depth + 1) or package if further and depth < 5 else package

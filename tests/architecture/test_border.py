"""Applications know the library by the names that its packages offer, and by no others; there are few of them."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

import bristle

ROOT = Path(bristle.__file__).parent
PROJECT = Path(__file__).parents[2]
MOST_NAMES = 295
# Lazy loading, colours and families, former names, for every package.
OPEN = ("bristle.core.loading", "bristle.core.palette", "bristle.core.former", "bristle.models")


def storeys():
    """Return the rooms of the library, and what stands above them: report, command line and apps."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = (
        single
        for single in project["tool"]["importlinter"]["contracts"]
        if single["name"].startswith("Rooms:")
    )
    rooms = [name for layer in contract["layers"] for name in layer.split(" | ")]
    above = rooms.index("bristle.report") + 1
    return rooms[above:], rooms[:above]


def taken(tree):
    """Yield what a file imports from the package, module and name; None where a module is imported whole."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "bristle":
            yield from ((node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (
                (alias.name, None)
                for alias in node.names
                if alias.name.partition(".")[0] == "bristle"
            )


def offered(package, root=ROOT.parent):
    """Return what the `__init__.py` of a package names."""
    names = set()
    for node in ast.walk(
        ast.parse(root.joinpath(*package.split("."), "__init__.py").read_text(encoding="utf-8"))
    ):
        if isinstance(node, ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    return names


@pytest.fixture(scope="module")
def border():
    """What applications import of the library, by file."""
    library, applications = storeys()
    result = {}
    for room in applications:
        for path in sorted(ROOT.joinpath(room.removeprefix("bristle.")).rglob("*.py")):
            # It continues the exports, and knows how they are made.
            if ROOT / "apps" / "targets" in path.parents:
                continue
            imports = [
                pair
                for pair in taken(ast.parse(path.read_text(encoding="utf-8")))
                if pair[0] not in OPEN
            ]
            result[path.relative_to(ROOT).as_posix()] = [
                pair for pair in imports if _room(pair[0]) in library
            ]
    return result


def _room(module):
    return ".".join(module.split(".")[:2])


def test_applications_import_names_that_packages_of_the_library_offer(border):
    folders = {
        module
        for result in border.values()
        for module, _ in result
        if ROOT.parent.joinpath(*module.split("."), "__init__.py").is_file()
    }
    names = {package: offered(package) for package in folders}
    modules = {
        file: [(module, name) for module, name in result if name not in names.get(module, ())]
        for file, result in border.items()
    }
    assert {file: result for file, result in modules.items() if result} == {}


def test_there_are_few_names(border):
    assert len({pair for result in border.values() for pair in result}) <= MOST_NAMES


def test_the_reference_lists_exactly_these_names(border):
    text = (
        (PROJECT / "docs" / "reference" / "python.md")
        .read_text(encoding="utf-8")
        .partition("## What applications use")[2]
    )
    listed = {
        (heading, name)
        for heading, table in re.findall(
            r"### (bristle\.[\w.]+)\n(.*?)(?=\n### |\Z)", text, re.DOTALL
        )
        for name in re.findall(r"^\| `(\w+)` \| \S.* \|$", table, re.MULTILINE)
    }
    assert listed == {pair for result in border.values() for pair in result}


def test_a_late_name_stands_above_the_module_of_its_name():
    # Python puts a module that is loaded into its package, under this name.
    for path in ROOT.rglob("__init__.py"):
        package = ".".join(path.parent.relative_to(ROOT.parent).parts)
        places = {
            alias.asname or alias.name: part.module
            for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.If)
            for part in ast.walk(node)
            if isinstance(part, ast.ImportFrom) and part.module != package  # that is the module
            for alias in part.names
        }
        for name in places.keys() & {file.stem for file in path.parent.iterdir()}:
            module = importlib.import_module(f"{package}.{name}")
            offered = getattr(importlib.import_module(package), name)
            assert (places[name], offered) == (module.__name__, getattr(module, name)), path

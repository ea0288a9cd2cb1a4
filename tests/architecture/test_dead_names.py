"""No public name that nobody uses: each is reached from a command, an example, a page, or code that runs at import.

What only tests use is dead. ``python tests/architecture/test_dead_names.py`` prints the dead names.
"""

import ast
import importlib
import re
import sys
from collections import defaultdict
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

import bristle
from bristle.cli.commands import COMMANDS
from bristle.report.figures.on_reports import names_on_reports
from bristle.report.figures.report_figure import FIGURES

ROOT = Path(bristle.__file__).parent
PROJECT = Path(__file__).parents[2]
PROGRAMS = ("examples", "benchmarks", "packaging", "docs")
assert names_on_reports()  # imports the files of all figures
DRAWN = {getattr(figure.draw, "args", (figure.draw,))[0] for figure in FIGURES.values()}
ENTRIES = {  # called by a name that is put together at run time, or by hand
    "bristle.cli.main.main": "the command",
    "bristle.files.results.remove_unfinished": "taken from `sys.modules`: what ends the program imports nothing",
    "bristle.cli.*.EXAMPLE": "the end of the help of each command",
    "bristle.cli.*.COMMAND": "the class of a command with a help of its own",
    "bristle.contract.check_figure": "handed on from a room above",
    "bristle.apps.*.command.EXAMPLE": "the end of the help of each command",
    "bristle.logs.*.read_*": "the reader of a format, by the name of the format",
    "bristle.logs.apart.serve": "begun in a process of its own",
    "bristle.apps.paper.surface.reaching_time": "named in the line of an equation of the paper, in `equations.toml`",
    "bristle.apps.study.workers.simulated": "asked for by name of a worker of a cluster",
    "bristle.apps.study.holder.hold_cluster": "begun in a process of its own",
    "bristle.apps.lab.server.worker.main": "begun in a process of its own",
    "bristle.exports.*.write": "a target of the export, in the file that has its name",
    "bristle.apps.targets.fmu.write_law": "of a target that holds a control law",
    "bristle.exports.*.*law_files": "of a target that holds a control law",
    "bristle.exports.*.reads": "of a target whose files a drive computes from",
    "bristle.models.friction.channels.*.SLOT": "a slot over a channel of a log, in the file that has its name",
    **{
        f"{draw.__module__}.{draw.__name__}": "a figure, by its name in `on_reports`"
        for draw in DRAWN
    },
    "bristle.*.*.MODEL": "a component, bound in its family by name",
    "bristle.apps.paper.rig.write_models": "makes the models beside the experiments of the paper again",
    "bristle.apps.paper.surface.sampled_bound": "the erratum of (21) in sampled time, held against simulation by its test",
    "bristle.apps.targets.page.switches.all_walks": "makes the walks of models with slots that lab keeps again",
    "bristle.apps.targets.page.described.walks_of": "makes the walks that lab keeps again",
}
ACCESS = {
    "property",
    "cached_property",
    "staticmethod",
    "classmethod",
    "abstractmethod",
    "contextmanager",
    "guarded",
}
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


class Module:
    """What a file defines and imports, and what of it runs when it is imported."""

    def __init__(self, name, path):
        self.name, self.tree = name, ast.parse(path.read_text(encoding="utf-8"))
        self.folder = name if path.name == "__init__.py" else name.rpartition(".")[0]
        self.definitions, self.imports, self.run = defaultdict(list), {}, []
        self.read(self.tree.body)

    def read(self, body):
        for node in body:
            if isinstance(node, DEFINITIONS):
                self.definitions[node.name].append(node)
                # A decorator that belongs to an object of this file keeps what it decorates: a command, a callback.
                kept = [
                    item
                    for item in node.decorator_list
                    if ast.unparse(item).partition(".")[0] in self.definitions
                ]
                self.run += [ast.Name(node.name, ast.Load())] if kept else []
            elif isinstance(node, (ast.Import, ast.ImportFrom)):
                self.imports |= imported(node, self.folder)
                # By convention `import NAME as NAME` hands a name on.
                self.run += [
                    ast.Name(alias.name, ast.Load())
                    for alias in node.names
                    if alias.asname == alias.name
                ]
            elif isinstance(node, (ast.Assign, ast.AnnAssign)):
                names = [
                    item.id
                    for item in ast.walk(node)
                    if isinstance(item, ast.Name) and isinstance(item.ctx, ast.Store)
                ]
                for name in names:
                    self.definitions[name].append(node)
                self.run += [] if names else [node]
            elif isinstance(node, (ast.If, ast.Try, ast.With)):
                self.read(
                    [*node.body, *getattr(node, "orelse", []), *getattr(node, "finalbody", [])]
                )
                self.read(
                    [child for handler in getattr(node, "handlers", []) for child in handler.body]
                )
                self.run += [node.test] if isinstance(node, ast.If) else []
            else:
                self.run.append(node)


def imported(node, folder):
    """Return what an import binds: by alias the module and, of it, the name."""
    if isinstance(node, ast.Import):
        first = {alias.name: alias.name.partition(".")[0] for alias in node.names}
        return {
            alias.asname or first[alias.name]: (
                alias.name if alias.asname else first[alias.name],
                None,
            )
            for alias in node.names
        }
    above = folder.split(".")
    start = ".".join(above[: len(above) + 1 - node.level]) if node.level else ""
    base = ".".join(filter(None, (start, node.module)))
    return {alias.asname or alias.name: (base, alias.name) for alias in node.names}


class Package:
    """A package, and who mentions what in it."""

    def __init__(self, root):
        self.modules = {}
        for path in sorted(root.rglob("*.py")):
            parts = (root.name, *path.relative_to(root).with_suffix("").parts)
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            self.modules[name] = Module(name, path)
        # Python calls it at an import.
        self.live, self.waiting, self.as_values, self.attributes = (
            set(),
            [],
            set(),
            {"exec_module"},
        )

    def home(self, module, name):
        """Return where a name of a module is defined: module and name; name is None for a module."""
        if module not in self.modules:
            return None
        if name in self.modules[module].definitions:
            return module, name
        base, inner = self.modules[module].imports.get(name, (None, None))
        if base is not None and (base, inner) != (module, name):
            return (base, None) if inner is None else self.home(base, inner)
        return (f"{module}.{name}", None) if f"{module}.{name}" in self.modules else None

    def denoted(self, node, names, module):
        """Return what an expression denotes, as `home` does."""
        if isinstance(node, ast.Name):
            if node.id in names:
                base, inner = names[node.id]
                return (base, None) if inner is None else self.home(base, inner)
            return self.home(module, node.id) if module else None
        if isinstance(node, ast.Attribute):
            place, name = self.denoted(node.value, names, module) or (None, "")
            return self.home(place, node.attr) if name is None else None
        return None

    def take(self, tree, module=None):
        """Mark what a piece of code mentions."""
        names, bases, prose = {}, set(), set()
        folder = self.modules[module].folder if module else ""
        for node in ast.walk(tree):
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                names |= imported(node, folder)
            bases |= {id(node.value)} if isinstance(node, ast.Attribute) else set()
            prose |= {id(node.value)} if isinstance(node, ast.Expr) else set()
        for base, inner in names.values():
            if inner is not None:
                self.mark(self.home(base, inner), is_value=False)
        for node in ast.walk(tree):
            if isinstance(node, (ast.Name, ast.Attribute)) and isinstance(node.ctx, ast.Load):
                self.mark(self.denoted(node, names, module), is_value=id(node) not in bases)
                self.attributes |= {node.attr} if isinstance(node, ast.Attribute) else set()
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                self.take_text(node.value, is_code=id(node) not in prose)

    def take_text(self, text, *, is_code=True):
        """Mark what a text names: by its whole path, and in code as an attribute or as a call of a module."""
        for path in re.findall(r"\bbr(?:istle)?((?:\.\w+)+(?::\w+)?)", text):
            place = "bristle"
            for name in re.split(r"[.:]", path[1:]):
                result = self.home(place, name)
                self.mark(result, is_value=False)
                place = result[0] if result and result[1] is None else None
        if is_code:
            self.attributes |= (
                set(re.findall(r"\w+", text)) if re.fullmatch(r"[\w.:]+", text) else set()
            )
            for stem, name in re.findall(r"\b(\w+)'?\)?\.(\w+)\(", text):
                for module in self.modules:
                    if module.endswith(f".{stem}"):
                        self.mark(self.home(module, name), is_value=False)

    def mark(self, key, *, is_value):
        if key is None:
            return
        if key[1] is None:
            self.as_values |= {key[0]} if is_value else set()
        elif key not in self.live:
            self.live.add(key)
            self.waiting.append(key)

    def follow(self):
        """Mark what is mentioned by what is mentioned."""
        size = -1
        while size != len(self.live):
            size = len(self.live)
            while self.waiting:
                module, name = self.waiting.pop()
                for node in self.modules[module].definitions[name]:
                    self.take(node, module)
            # Handed on: any attribute may be one of its names.
            for module in self.as_values & self.modules.keys():
                for name in self.modules[module].definitions.keys() & self.attributes:
                    self.mark((module, name), is_value=False)


def pages():
    """Yield the code of pages that people wrote, and what else they name in it."""
    for path in (
        *PROJECT.glob("*.md"),
        *(PROJECT / "docs").rglob("*.md"),
        *(PROJECT / "examples").rglob("*.md"),
    ):
        text = path.read_text(encoding="utf-8")
        if "<!-- Written by docs/generate.py" not in text:
            yield from re.findall(r"```\w* ?\w*\n(.*?)```", text, re.DOTALL)
            yield from re.findall(r"`([^`\n]+)`", text)
    for path in (PROJECT / "docs").rglob("*.ipynb"):
        yield path.read_text(encoding="utf-8").replace('\\"', '"').replace("\\n", "\n")


@cache
def walked(root=ROOT, entries=tuple(ENTRIES), pages=pages):
    """Return a package of which everything is marked that is reached."""
    package = Package(root)
    for module in package.modules.values():
        for node in module.run:
            package.take(node, module.name)
        for name in module.definitions:
            is_entry = any(fnmatch(f"{module.name}.{name}", entry) for entry in entries)
            is_command = COMMANDS.get(name) == module.name or (
                module.folder == f"{root.name}.cli" and module.name.endswith(f".{name}")
            )
            if is_entry or is_command or (name.startswith("__") and name != "__all__"):
                package.mark((module.name, name), is_value=False)
    for name in getattr(bristle, "__all__", ()):
        package.mark(package.home("bristle", name), is_value=False)
    if root == ROOT:
        for path in (path for folder in PROGRAMS for path in (PROJECT / folder).rglob("*.py")):
            package.take(ast.parse(path.read_text(encoding="utf-8")))
        for path in (path for path in root.rglob("*") if path.suffix in (".html", ".js")):
            package.attributes |= set(re.findall(r"\.(\w+)", path.read_text(encoding="utf-8")))
    shown = [package.home("bristle", name) for name in getattr(bristle, "__all__", ())]
    for text in pages():
        for word in re.findall(r"\w+", text):
            for place, _ in (key for key in shown if key and key[1] is None):
                package.mark(package.home(place, word), is_value=False)
        package.take_text(text)
        package.attributes |= set(re.findall(r"\.(\w+)", text))
        for base, names in re.findall(r"from ([\w.]+) import ([\w, ]+)", text):
            for name in names.split(","):
                package.mark(package.home(base, name.strip()), is_value=False)
    package.follow()
    return package


def dead_names(package):
    """Return the public names of files that nothing reaches, and the public members of classes that nothing spells."""
    result = []
    for module in package.modules.values():
        reached = {
            id(node)
            for name in module.definitions
            if (module.name, name) in package.live
            for node in module.definitions[name]
        }
        for name, nodes in module.definitions.items():
            # Names that are numbered together stand or fall together.
            if not name.startswith("_") and not reached & set(map(id, nodes)):
                result.append(f"{module.name}.{name}")
            for member in (
                item for node in nodes if isinstance(node, ast.ClassDef) for item in node.body
            ):
                if isinstance(member, DEFINITIONS) and is_dead_member(
                    member, package, module.name, name
                ):
                    result.append(f"{module.name}.{name}.{member.name}")
    return sorted(result)


def is_dead_member(member, package, module, name):
    """Whether nothing spells a public member, and no class outside the package, that its own inherits, calls it."""
    kept = {ast.unparse(item).partition("(")[0] for item in member.decorator_list} - ACCESS
    if (
        name.startswith("_")
        or member.name.startswith("_")
        or member.name in package.attributes
        or kept
    ):
        return False
    classes = getattr(importlib.import_module(module), name).__mro__
    root = module.partition(".")[0]
    return not any(
        member.name in vars(item) for item in classes if item.__module__.partition(".")[0] != root
    )


@pytest.mark.slow
def test_every_public_name_is_used():
    assert dead_names(walked()) == []


@pytest.mark.slow
def test_every_entry_is_needed():
    names = {
        f"{module.name}.{name}"
        for module in walked().modules.values()
        for name in module.definitions
    }
    assert [entry for entry in ENTRIES if not any(fnmatch(name, entry) for name in names)] == []


@pytest.mark.parametrize(
    ("files", "dead"),
    [
        ({"a": "def f(): pass"}, ["p.a.f"]),
        ({"a": "def f(): f()"}, ["p.a.f"]),
        ({"a": "def f(): g()\ndef g(): f()"}, ["p.a.f", "p.a.g"]),
        ({"a": "__all__ = ['f']\ndef f(): pass"}, ["p.a.f"]),
        ({"a": "def f(): pass", "b": "from p.a import f"}, ["p.a.f"]),
        ({"a": "def f(): pass\nf()"}, []),
        ({"a": "def f(): pass", "b": "from p.a import f\nf()"}, []),
        ({"a": "def f(): pass", "__init__": "from p.a import f", "b": "import p\np.f()"}, []),
        ({"a": "def f(): pass", "b": "def g():\n    from p import a\n    a.f()\ng()"}, []),
        ({"a": "def f(): pass", "b": "from p import a\nfor module in [a]:\n    module.f()"}, []),
        ({"a": "X, Y = range(2)\nprint(Y)"}, []),
        ({"a": "def f(): pass", "b": "def f(): pass\nf()"}, ["p.a.f"]),
        ({"a": "class C:\n    def f(self): pass\nC()"}, ["p.a.C.f"]),
        ({"a": "class C:\n    def f(self): pass\nC().f()"}, []),
    ],
)
def test_the_search_finds_dead_names(files, dead, tmp_path, monkeypatch):
    (tmp_path / "p").mkdir()
    for name, text in ({"__init__": ""} | files).items():
        (tmp_path / "p" / f"{name}.py").write_text(text + "\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in [name for name in sys.modules if name.partition(".")[0] == "p"]:
        monkeypatch.delitem(sys.modules, name)
    assert dead_names(walked(tmp_path / "p", pages=list)) == dead


if __name__ == "__main__":
    print(*dead_names(walked()), sep="\n")

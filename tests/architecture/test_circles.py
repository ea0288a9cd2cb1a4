"""No file of the package needs itself by way of others: imports inside functions count, and those for types alone.

``python tests/architecture/test_circles.py`` prints the circles that there are, and what makes each.
"""

import ast
from pathlib import Path

import pytest

import bristle

pytestmark = pytest.mark.slow
ROOT = Path(bristle.__file__).parent


def is_for_types(node):
    """Whether a statement is ``if TYPE_CHECKING:``, which nothing runs."""
    return isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")


def imports(node, *, of_package=False):
    """Yield the imports under a node, at any depth, and what `import_module` is called with where that is text.

    What a package imports for types alone are the names that it offers, which it loads when they are asked for.
    """
    for child in node.orelse if of_package and is_for_types(node) else ast.iter_child_nodes(node):
        if isinstance(child, (ast.Import, ast.ImportFrom)):
            yield child
        elif isinstance(child, ast.Call) and ast.unparse(child.func).endswith("import_module"):
            yield from (
                ast.Import([ast.alias(text.value)])
                for text in child.args
                if isinstance(text, ast.Constant)
            )
        yield from imports(child, of_package=of_package)


def late_names(name, tree):
    """Return the modules of the names that a package loads when they are asked for, which it imports for types alone."""
    imported = [
        node
        for block in tree.body
        if is_for_types(block)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
    ]
    return {
        (name, alias.asname or alias.name): node.module for node in imported for alias in node.names
    }


def targets(node, folder, modules, late=()):
    """Yield the names of the modules that an import in a file of `folder` may load."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
        return
    above = folder.split(".")
    start = ".".join(above[: len(above) + 1 - node.level]) if node.level else ""
    base = ".".join(filter(None, (start, node.module)))
    for alias in node.names:
        yield full if (full := f"{base}.{alias.name}") in modules else base
        if (base, alias.name) in late:
            yield late[base, alias.name]


def tree_of(path):
    """Return the tree of a file. The trees of all files would take 0.2 GB."""
    return ast.parse(path.read_text(encoding="utf-8"))


def graph(root=ROOT):
    """Return, of each module of a package, those of it that it imports."""
    files = {}
    for path in sorted(root.rglob("*.py")):
        parts = (root.name, *path.relative_to(root).with_suffix("").parts)
        files[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    late = {}
    for name in (name for name, path in files.items() if path.name == "__init__.py"):
        late |= late_names(name, tree_of(files[name]))
    arrows = {}
    for name, path in files.items():
        of_package = path.name == "__init__.py"
        folder = name if of_package else name.rpartition(".")[0]
        loaded = {
            target
            for node in imports(tree_of(path), of_package=of_package)
            for target in targets(node, folder, files, late)
        }
        arrows[name] = sorted(loaded & files.keys() - {name})
    return arrows


def circles(arrows):
    """Return the sets of more than one module each of which comes to every other one of it (Tarjan's algorithm)."""
    order, lowest, path, closed, sets = {}, {}, [], set(), []

    def visit(name):
        order[name] = lowest[name] = len(order)
        path.append(name)
        for target in arrows[name]:
            if target not in order:
                visit(target)
            if target not in closed:
                lowest[name] = min(lowest[name], lowest[target])
        if lowest[name] == order[name]:
            members = path[path.index(name) :]
            del path[path.index(name) :]
            closed.update(members)
            sets.extend([frozenset(members)] if len(members) > 1 else [])

    for name in arrows:
        if name not in order:
            visit(name)
    return sets


@pytest.fixture(scope="module")
def arrows():
    return graph()


def test_no_files_import_each_other_in_a_circle(arrows):
    assert [sorted(circle) for circle in circles(arrows)] == []


def test_all_files_are_looked_at(arrows):
    assert len(arrows) == len(list(ROOT.rglob("*.py")))
    assert "bristle.logs.assembly" in arrows["bristle.logs.log"]
    assert "bristle.files.user_model" in arrows["bristle.files.model"]  # inside a function
    # By the package that offers the name.
    assert "bristle.files.axis" in arrows["bristle.report.model_in_hand"]


@pytest.mark.parametrize(
    ("files", "members"),
    [
        ({"a": "import p.b", "b": "import p.a"}, {"p.a", "p.b"}),
        ({"a": "from p.b import f", "b": "def g():\n    from p.a import h"}, {"p.a", "p.b"}),
        (
            {"a": "from p import b", "b": "from p import c", "c": "from p.a import f"},
            {"p.a", "p.b", "p.c"},
        ),
        (
            {"a": "from . import b", "b": "class C:\n    def f(self):\n        from .a import g"},
            {"p.a", "p.b"},
        ),
        ({"a": "import p.b", "b": "import_module('p.a')"}, {"p.a", "p.b"}),
        (
            {"a": "if b:\n    import p.b", "b": "try:\n    import p.a\nfinally:\n    pass"},
            {"p.a", "p.b"},
        ),
        ({"__init__": "from p.a import f", "a": "from p import f"}, {"p", "p.a"}),
        (
            {"a": "if TYPE_CHECKING:\n    import p.b\nelse:\n    import p.b", "b": "import p.a"},
            {"p.a", "p.b"},
        ),
        ({"a": "if TYPE_CHECKING:\n    import p.b", "b": "import p.a"}, {"p.a", "p.b"}),
        (
            {
                "a": "if typing.TYPE_CHECKING:\n    from p import b",
                "b": "if TYPE_CHECKING:\n    from p.a import f",
            },
            {"p.a", "p.b"},
        ),
        ({"__init__": "if TYPE_CHECKING:\n    from p.a import f", "a": "import p"}, None),
        (
            {
                "__init__": "if TYPE_CHECKING:\n    from p.a import f",
                "a": "import p.b",
                "b": "from p import f",
            },
            {"p.a", "p.b"},
        ),
        ({"a": "import p.b, p.c", "b": "import p.c", "c": "import os"}, None),
    ],
)
def test_the_search_finds_circles(files, members, tmp_path):
    (tmp_path / "p").mkdir()
    for name, text in files.items():
        (tmp_path / "p" / f"{name}.py").write_text(text + "\n")
    assert circles(graph(tmp_path / "p")) == ([frozenset(members)] if members else [])


if __name__ == "__main__":
    every = graph()
    for circle in circles(every):
        print(f"{len(circle)} files:")
        for name in sorted(circle):
            print(f"  {name} -> {', '.join(target for target in every[name] if target in circle)}")

"""The walls of the house: what loads what, what is public, what a kernel may hold, how long things are."""

import ast
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from tests.architecture.kernel_subset import violations_of
from tests.optional import MISSING

import bristle
from bristle.core.contracts import Component
from bristle.core.errors import MissingExtraError
from bristle.core.kernel import kernels
from bristle.core.variable import variables_of

ROOT = Path(bristle.__file__).parent
MODULES = sorted(
    {
        name
        for _, name, _ in pkgutil.walk_packages([str(ROOT)], "bristle.")
        if not name.endswith("__main__")
    }
    - {*MISSING}
)
HEAVY = ("numba", "scipy", "pint", "pydantic", "rich", "matplotlib")
MOST_ARGUMENTS = 12
FAMILIES = ("hysteresis", "friction", "plants", "controllers", "sensors", "references")


def read(path):
    """Return the text of a file, and its tree."""
    text = path.read_text()
    return text, ast.parse(text)


def loaded_after(code):
    out = subprocess.run(
        [
            sys.executable,
            "-c",
            f"import sys\n{code}\nprint(*{{name.partition('.')[0] for name in sys.modules}})",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(out.stdout.split()[-400:]) & {*HEAVY, "numpy"}


@pytest.mark.parametrize("code", ["import bristle", "from bristle.exports import TARGETS"])
def test_the_package_and_its_list_of_targets_load_no_heavy_module(code):
    assert loaded_after(code) == set()


def test_the_help_loads_no_heavy_module():
    code = "from bristle.cli.main import main\nsys.argv = ['bristle', '--help']\ntry:\n    main()\nexcept SystemExit:\n    pass"
    assert loaded_after(code) & set(HEAVY) == set()


def test_defining_models_loads_no_compiler():
    assert (
        loaded_after(
            "import bristle.models.friction, bristle.models.plants, bristle.models.controllers"
        )
        & set(HEAVY)
        == set()
    )


@pytest.mark.slow
def test_every_public_name_is_there_after_every_module_was_imported():
    # A folder named like a function would replace it: import all, then ask.
    for name in MODULES:
        importlib.import_module(name)
    for name in bristle.__all__:
        value = getattr(bristle, name)
        assert callable(value) or inspect.ismodule(value) or name == "__version__", name
    assert callable(bristle.friction.lugre)


def test_public_face_is_small_and_known():
    assert len(bristle.__all__) <= 35
    assert set(bristle.__all__) <= set(dir(bristle))


@pytest.mark.parametrize(
    "package",
    ["bristle.core", "bristle.engine", "bristle.exports", "bristle.simulation", "bristle.contract"],
)
def test_names_that_are_loaded_when_asked_for_are_completed(package):
    module = importlib.import_module(package)
    assert set(module.__all__) <= set(dir(module))


@pytest.mark.slow
def test_every_kernel_stays_in_the_exportable_subset():
    for name in MODULES:
        importlib.import_module(name)
    ours = [kernel for kernel in kernels() if (kernel.__module__ or "").startswith("bristle.")]
    assert len(ours) > 40
    assert [text for kernel in ours for text in violations_of(kernel)] == []


@pytest.mark.parametrize(
    "body",
    [
        "    return v ** 2.5",
        "    return [v][0]",
        "    import math",
        "    return len({v})",
        "    raise ValueError",
        "    return math.exp(v)",
        "    for x in p:\n        v += x\n    return v",
        "    return sorted(p)",
        "    return f'{v}'",
        "    return p.sum()",
        "    return (lambda x: x)(v)",
        "    return max(v, key=p)",
        "    with p:\n        return v",
        "    while v:\n        v -= 1\n    else:\n        v = 2\n    return v",
        "    try:\n        return v\n    finally:\n        v = 1",
        "    return v @ p",
        "    global g\n    return v",
        "    return g",
    ],
)
def test_code_outside_the_subset_is_found(body, tmp_path, monkeypatch):
    path = tmp_path / "outside.py"
    path.write_text(f"import math\ng = []\ndef f(v, p):\n{body}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    sys.modules.pop("outside", None)
    assert violations_of(importlib.import_module("outside").f) != []


def public_imports(package):
    """Return the names that a package imports from modules of its own under the same name, in order."""
    imports = [
        node
        for node in ast.walk(ast.parse(inspect.getsource(package)))
        if isinstance(node, ast.ImportFrom) and node.module.startswith(f"{package.__name__}.")
    ]
    return [alias.name for node in imports for alias in node.names if alias.name == alias.asname]


def components():
    for family in FAMILIES:
        package = importlib.import_module(f"bristle.models.{family}")
        for _, name, _ in pkgutil.iter_modules(package.__path__):
            module = importlib.import_module(f"bristle.models.{family}.{name}")
            if isinstance(getattr(module, "MODEL", None), Component):
                yield family, name, module.MODEL, package


def test_every_component_is_bound_in_its_family_and_complete():
    result = list(components())
    assert len(result) >= 12
    files = {}
    for family, name, model, package in result:
        first = files.setdefault((family, model.name), model.module)
        assert first == model.module, (
            f"{model.module} has the name of {first}, {model.name!r}: write another name"
        )
        line = f"from bristle.models.{family}.{model.name} import {model.name} as {model.name}"  # type checkers take it for public
        assert model.name in public_imports(package), (
            f"bristle/models/{family}/__init__.py lacks `{line}`"
        )
        assert getattr(package, model.name) is model
        assert model.description
        variables_of(model.Parameters)
        variables_of(model.State)
        doc = importlib.import_module(model.module).__doc__ or ""
        assert len(doc) > 40, f"{family}/{name} does not say what it is"
        if family == "friction":
            assert model.reference.startswith("doi:"), (
                f'MODEL of {family}/{name}.py has no reference="doi:..."'
            )
            assert model.reference.removeprefix("doi:") in doc, (
                f"the docstring of {family}/{name}.py lacks the DOI of MODEL"
            )


TABLES = dict(
    zip(
        FAMILIES,
        ("OPERATORS", "MODELS", "PLANTS", "CONTROLLERS", "SENSORS", "REFERENCES"),
        strict=True,
    )
)


@pytest.mark.parametrize("family", FAMILIES)
def test_components_are_listed_in_the_order_of_their_imports(family):
    # A file that an earlier one imports would come first: its line belongs above.
    package = importlib.import_module(f"bristle.models.{family}")
    table = getattr(package, TABLES[family])
    assert list(table) == [name for name in public_imports(package) if name in table]


def functions(tree):
    return [
        node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    ]


@pytest.fixture(scope="module")
def modules():
    """Path, text and tree of each module of the package."""
    return [(path, *read(path)) for path in ROOT.rglob("*.py")]


@pytest.mark.slow
def test_modules_and_functions_are_short(modules):
    lengths = {}
    for path, text, module in modules:
        lengths[path] = text.count("\n")
        for function in functions(module):
            body = (
                function.body[1:]
                if ast.get_docstring(function) and len(function.body) > 1
                else function.body
            )
            length = function.end_lineno - body[0].lineno + 1
            assert length <= 101, (
                f"{path.relative_to(ROOT)}:{function.lineno} {function.name} has {length} lines"
            )
    assert max(lengths.values()) <= 800, max(lengths, key=lengths.get)


@pytest.mark.slow
def test_no_function_takes_more_than_a_few_arguments_by_their_place(modules):
    for path, _, module in modules:
        for function in functions(module):
            taken = len(function.args.posonlyargs) + len(function.args.args)
            assert taken <= MOST_ARGUMENTS, (
                f"{path.relative_to(ROOT)}:{function.lineno} {function.name} takes {taken}"
            )


@pytest.mark.slow
def test_exceptions_are_not_swallowed_and_no_todo_remains(modules):
    for path, text, module in modules:
        for node in ast.walk(module):
            if isinstance(node, ast.ExceptHandler):
                assert not (len(node.body) == 1 and isinstance(node.body[0], ast.Pass)), (
                    f"{path}:{node.lineno}"
                )
        assert not re.search(r"TODO|FIXME|XXX|NotImplementedError", text), path


def test_public_functions_document_every_argument():
    missing = []
    for name in MODULES:
        module = importlib.import_module(name)
        for key in getattr(
            module, "__all__", [key for key in vars(module) if not key.startswith("_")]
        ):
            try:
                value = getattr(module, key)
            except MissingExtraError:  # a class of a module that is MISSING
                continue
            if not inspect.isfunction(value) or value.__module__ != name:
                continue
            doc = inspect.getdoc(value) or ""
            if "Parameters\n----------" not in doc:
                continue
            for argument in inspect.signature(value).parameters:
                if argument not in ("self", "args", "kwargs", "values") and not re.search(
                    rf"\b{argument}\b", doc
                ):
                    missing.append(f"{name}.{key}: {argument}")
    assert missing == []


def test_the_package_knows_no_machine_and_no_working_paper():
    for path in ROOT.rglob("*"):
        if path.suffix in (".py", ".toml", ".html", ".css", ".md") and path.is_file():
            text = path.read_text()
            assert not re.search(
                r"/(root|work|farm)/|\.\./shared|theory\.md|design\.md|[Ii]ssue \d", text
            ), path


def test_each_room_and_each_app_has_its_layer():
    project = tomllib.loads(
        (Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    )
    contracts = {
        contract["name"].partition(":")[0]: contract
        for contract in project["tool"]["importlinter"]["contracts"]
    }
    rooms = [name for layer in contracts["Rooms"]["layers"] for name in layer.split(" | ")]
    assert sorted(rooms) == sorted(
        f"bristle.{file.parent.name}" for file in ROOT.glob("*/__init__.py")
    )
    assert len(rooms) == 13
    apps = contracts["Apps"]["modules"]
    assert sorted(apps) == sorted(
        f"bristle.apps.{file.parent.name}" for file in ROOT.glob("apps/*/__init__.py")
    )

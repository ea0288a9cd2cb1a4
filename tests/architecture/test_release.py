"""One version everywhere it is written, and a recipe that asks for what the package asks for."""

import contextlib
import importlib.util
import json
import re
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import bristle

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = (ROOT / "packaging" / "conda-forge" / "meta.yaml").read_text(encoding="utf-8")
NAMES = {"matplotlib-base": "matplotlib"}


def first(pattern, file):
    return re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)[1]


def test_the_version_is_the_same_everywhere():
    assert PROJECT["version"] == bristle.__version__
    assert first(r"^version: (\S+)$", "CITATION.cff") == bristle.__version__
    assert re.search(r'set version = "([^"]+)"', RECIPE)[1] == bristle.__version__
    assert first(r"^## (\d\S+)", "CHANGELOG.md") == bristle.__version__


def test_the_recipe_has_the_dependencies_of_the_package():
    run = RECIPE.partition("  run:\n")[2].partition("\n\n")[0].splitlines()
    requested = {
        tuple(line.strip("- ").split(" ", 1))
        for line in run
        if not line.strip().startswith("- python ")
    }
    assert {NAMES.get(name, name) + limits for name, limits in requested} == set(
        PROJECT["dependencies"]
    )
    assert f"- python {PROJECT['requires-python']}" in RECIPE


@pytest.fixture
def check():
    """The check of what is released."""
    spec = importlib.util.spec_from_file_location(
        "packaging_check", ROOT / "packaging" / "check.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("licence", "refused"),
    [
        ("MIT", False),
        ("GNU LGPL v3", False),
        ("GPL-3.0-only", True),
        ("LGPL-2.1 AND GPL-2.0", True),
        ("unknown", True),
    ],
)
def test_a_licence_that_does_not_fit_ends_the_check(check, monkeypatch, licence, refused):
    monkeypatch.setattr(check, "run", lambda *_: json.dumps({"some-library": ["1.0", licence]}))
    with pytest.raises(SystemExit, match="some-library") if refused else contextlib.nullcontext():
        check.licences(Path("bin"))


def test_a_wheel_that_lacks_a_template_or_holds_a_binary_is_refused(check, tmp_path):
    files = [
        file
        for file in (ROOT / "src" / "bristle").rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    ]
    names = [file.relative_to(ROOT / "src").as_posix() for file in files]

    def looked(inside, hidden=()):
        wheel, sdist = tmp_path / "a.whl", tmp_path / "a.tar.gz"
        with zipfile.ZipFile(wheel, "w") as archive:
            for name in inside:
                archive.writestr(name, "")
        with tarfile.open(sdist, "w:gz") as archive:
            for name in (
                "LICENSE",
                "README.md",
                "CHANGELOG.md",
                "CITATION.cff",
                "pyproject.toml",
                *hidden,
            ):
                archive.addfile(tarfile.TarInfo(f"bristle-1/{name}"))
        check.looked_inside(wheel, sdist)

    looked(names)
    template = next(name for name in names if name.endswith("lab.html"))
    for wrong in ([name for name in names if name != template], [*names, "bristle/left.so"]):
        with pytest.raises(SystemExit, match=r"lab\.html|left\.so"):
            looked(wrong)
    with pytest.raises(SystemExit, match="hidden"):
        looked(names, [".secret"])

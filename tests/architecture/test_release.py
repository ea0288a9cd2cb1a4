"""One version everywhere it is written, and a recipe that asks for what the package asks for."""

import re
import tomllib
from pathlib import Path

import bristle

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RECIPE = (ROOT / "packaging" / "conda-forge" / "meta.yaml").read_text(encoding="utf-8")
NAMES = {"matplotlib-base": "matplotlib"}


def first(pattern, file):
    return re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)[1]


def test_one_version_stands_everywhere():
    assert PROJECT["version"] == bristle.__version__
    assert first(r"^version: (\S+)$", "CITATION.cff") == bristle.__version__
    assert re.search(r'set version = "([^"]+)"', RECIPE)[1] == bristle.__version__
    assert first(r"^## (\d\S+)", "CHANGELOG.md") == bristle.__version__


def test_the_recipe_asks_for_what_the_package_asks_for():
    run = RECIPE.partition("  run:\n")[2].partition("\n\n")[0].splitlines()
    asked = {tuple(line.strip("- ").split(" ", 1)) for line in run if not line.strip().startswith("- python ")}
    assert {NAMES.get(name, name) + limits for name, limits in asked} == set(PROJECT["dependencies"])
    assert f"- python {PROJECT['requires-python']}" in RECIPE

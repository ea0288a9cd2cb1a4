"""The reference says what the program says: pages made from the code, options, statuses."""

import importlib.util
import json
import re

import pytest
from tests.docs.conftest import ROOT

import bristle
from bristle.cli.main import main
from bristle.core.status import SENTENCES

REFERENCE = ROOT / "docs" / "reference"

SLOW = {"python.md": pytest.mark.slow}
_spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
generate = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(generate)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=SLOW[name]) if name in SLOW else name
        for name in sorted(generate.PAGES)
    ],
)
def test_pages_made_from_the_code_are_up_to_date(name):
    assert (REFERENCE / name).read_text() == generate.PAGES[name](), "run: python docs/generate.py"


def test_the_page_of_python_lists_every_name():
    page = (REFERENCE / "python.md").read_text()
    assert [
        name
        for name in bristle.__all__
        if name != "__version__" and not re.search(rf"\b{name}\b", page)
    ] == []


def printed(arguments, capsys):
    main([*arguments, "--json"])
    return json.loads(capsys.readouterr().out)


def test_the_page_of_models_matches_the_command(capsys):
    page = (REFERENCE / "models.md").read_text()
    for item in printed(["models"], capsys)["models"]:
        section = page.split(f"\n### {item['name']}\n")[1].split("\n#")[0]
        for name, parameter in item["parameters"].items():
            assert f"| `{name}` | {parameter['description']}" in section
            assert parameter["unit_rotational"] in section
        for relation in item["relations"]:
            assert f"`{relation}`" in section


def test_the_page_of_commands_lists_every_option_of_the_help(capsys):
    page = (REFERENCE / "command-line.md").read_text()
    main(["--help"])
    commands = re.findall(
        r"^  (\w+)  ", capsys.readouterr().out.split("Commands:")[1], flags=re.MULTILINE
    )
    assert "identify" in commands
    for command in commands:
        section = page.split(f"\n## bristle {command}\n")[1].split("\n## ")[0]
        main([command, "--help"])
        options = set(
            re.findall(r"^\s+(?:-\w, )?(--[a-z-]+)", capsys.readouterr().out, flags=re.MULTILINE)
        ) - {"--help"}
        assert options == set(re.findall(r"^\| `(--[a-z-]+)", section, flags=re.MULTILINE))


def test_every_status_is_listed():
    page = (REFERENCE / "errors.md").read_text()
    for status, sentence in SENTENCES.items():
        assert f"| `{status.name}` | {sentence} |" in page

"""The reference says what the program says: pages made from the code, JSON keys, statuses."""

import importlib.util
import json
import re

import pytest
from tests.docs.conftest import ROOT

from bristle import friction
from bristle.cli.main import main
from bristle.core.status import SENTENCES

REFERENCE = ROOT / "docs" / "reference"

_spec = importlib.util.spec_from_file_location("generate", ROOT / "docs" / "generate.py")
generate = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(generate)


@pytest.mark.parametrize("name", sorted(generate.PAGES))
def test_pages_made_from_the_code_are_up_to_date(name):
    assert (REFERENCE / name).read_text() == generate.PAGES[name](), "run: python docs/generate.py"


def printed(arguments, capsys):
    main([*arguments, "--json"])
    return json.loads(capsys.readouterr().out)


def test_the_page_of_models_tells_what_the_command_tells(capsys):
    page = (REFERENCE / "models.md").read_text()
    for one in printed(["models"], capsys)["models"]:
        section = page.split(f"\n### {one['name']}\n")[1].split("\n#")[0]
        for name, parameter in one["parameters"].items():
            assert f"| `{name}` | {parameter['description']}" in section
            assert parameter["unit_rotational"] in section
        for relation in one["relations"]:
            assert f"`{relation}`" in section


def test_the_page_of_commands_tells_every_option_of_the_help(capsys):
    page = (REFERENCE / "command-line.md").read_text()
    main(["--help"])
    commands = re.findall(r"^  (\w+)  ", capsys.readouterr().out.split("Commands:")[1], flags=re.MULTILINE)
    assert "identify" in commands
    for command in commands:
        section = page.split(f"\n## bristle {command}\n")[1].split("\n## ")[0]
        main([command, "--help"])
        options = set(re.findall(r"^\s+(--[a-z-]+)", capsys.readouterr().out, flags=re.MULTILINE)) - {"--help"}
        assert options == set(re.findall(r"^\| `(--[a-z-]+)", section, flags=re.MULTILINE))


def test_every_status_is_listed():
    page = (REFERENCE / "errors.md").read_text()
    for status, sentence in SENTENCES.items():
        assert f"| `{status.name}` | {sentence} |" in page


# --- JSON -------------------------------------------------------------------------------------------------------

EXPERIMENT = """
schema = 1
friction = { file = "results/model.toml" }
controller = { model = "cascade", k_p = 60.0, k_v = 6000.0 }
reference = { model = "sine", amplitude = "1 mm", frequency = "1 Hz" }
run = { duration = "1 s", sample_time = "1 ms", seeds = 2 }
"""

RUNS = {
    "identify": "identify log.csv --axis axis.toml --model coulomb_viscous+asymmetry",
    "predict": "predict results/model.toml log.csv --axis axis.toml --mode closed-loop",
    "compare": "compare log.csv followed.csv --axis axis.toml",
    "run": "run experiment.toml",
    "paper": "paper --figure 4",
    "design": "design experiment.toml",
    "lab": "lab results/model.toml --out lab.html",
    "check": "check quadratic_drag.py",
    "models": "models lugre",
    "log": "log log.csv --axis axis.toml",
    "excite": "excite axis.toml --duration 10s --for break-away",
}


def documented(command):
    """The keys in the section of a command, abbreviated ones in full: a.b, .c is a.b, a.c."""
    section = (REFERENCE / "json.md").read_text().split(f"\n## bristle {command}\n")[1].split("\n## ")[0]
    keys = []
    for line in re.findall(r"^\| (`.*?) \|", section, flags=re.MULTILINE):
        for key in re.findall(r"`([^`]+)`", line):
            keys.append(key if not key.startswith(".") else keys[-1].rpartition(".")[0] + key)
    return keys


def found_at(value, key):
    """Whether a key leads to something; an ellipsis takes any name, [] any item."""
    for part in key.split("."):
        name, items = part.removesuffix("[]"), part.endswith("[]")
        if isinstance(value, list):
            value = value[0]
        if name == "…":
            value = next(iter(value.values()))
        elif isinstance(value, dict) and name in value:
            value = value[name]
        else:
            return False
        if items and not isinstance(value, list):
            return False
    return True


@pytest.mark.parametrize("command", [
    pytest.param(command, marks=pytest.mark.slow if command == "lab" else ()) for command in sorted(RUNS)
])  # fmt: skip
def test_json_has_the_keys_that_are_documented_and_no_others(command, at_the_reader, capsys):
    (at_the_reader / "experiment.toml").write_text(EXPERIMENT)
    result = printed(RUNS[command].split(), capsys)
    keys = documented(command)
    assert [key for key in keys if not found_at(result, key)] == []
    top = {re.split(r"[.\[]", key)[0] for key in keys}
    assert set(result) == top
    entry = next(iter(result.get("variants", result.get("certificates", {})).values()), {})
    assert set(entry) <= {part for key in keys for part in key.split(".")}


def test_the_page_on_choosing_names_every_model():
    page = (ROOT / "docs" / "how-to" / "choose-a-model.md").read_text(encoding="utf-8")
    assert [name for name in friction.MODELS if f"`{name}`" not in page] == []

"""What commands print as JSON keeps its keys, names, units and statuses, and the reference has each of its keys."""

import json
import re
from functools import cache

import jsonschema
import pytest
from tests.docs.conftest import ROOT
from tests.docs.json_reference import documented, is_found
from tests.exports.native import COMPILER
from tests.golden.case import CASES
from tests.golden.commands import COMMANDS
from tests.golden.comparison import differences
from tests.golden.skeleton import skeleton

from bristle.cli.application import app
from bristle.lab.page import MARK

FAST = [item for item in (CASES[f"json_{name}"] for name in COMMANDS) if item.fast]


# Commands in the reference, and the command line that shows all of their keys.
DOCUMENTED = {name: name for name in ("identify", "predict", "compare", "paper", "design", "lab", "log", "excite", "explain", "tune")} | {
    "identify": "identify identify_second_pass",
    "log": "log log_nameless",
    "run": "run_seeds",
    "check": "check_own",
    "models": "models_lugre",
}


@pytest.fixture(autouse=True)
def pages_in_short(monkeypatch, undrawn):
    """Reports without figures, and what every page of the lab begins with: the pages themselves have their tests."""
    monkeypatch.setattr("bristle.lab.lab_page", lambda *_, **__: MARK)


@cache
def printed(case):
    return case.found()


LONG = {"json_excite", "json_predict_with_band", "json_design_diverging"} | {
    f"json_identify_{name}" for name in ("open_loop", "elements", "own", "each", "in_loop", "pulls", "several")
}


@pytest.mark.parametrize(
    "case", [pytest.param(item, id=item.name.removeprefix("json_"), marks=[pytest.mark.slow] if item.name in LONG else []) for item in FAST]
)
def test_no_key_is_missing_and_no_name_has_changed(case):
    frozen = json.loads(case.file.read_text(encoding="utf-8"))
    result = [str(difference) for difference in differences(frozen, printed(case))]
    if COMPILER is None:  # then `check` cannot compare the bits of C, and says so
        result = [difference for difference in result if not difference.startswith("json.certificates.same bits exported.")]
    assert result[:20] == []


@pytest.mark.parametrize("command", DOCUMENTED)
def test_json_has_exactly_the_documented_keys(command):
    result, *further = (printed(CASES[f"json_{name}"])["json"] for name in DOCUMENTED[command].split())
    keys = documented(command)
    assert [key for key in keys if not any(is_found(item, key) for item in (result, *further))] == []
    assert set(result) == {re.split(r"[.\[]", key)[0] for key in keys}
    entry = next(iter(result.get("variants", result.get("certificates", {})).values()), {})
    assert set(entry) <= {part for key in keys for part in key.split(".")}


def test_every_command_has_documented_json():
    assert {registered_command.name for registered_command in app.registered_commands} == {line.split()[0] for line in COMMANDS.values()}


RESULT = {
    "model": "lugre",
    "metrics": {"rms": 1.0, "lost": None},
    "passed": True,
    "warnings": ["two words"],
    "status": "ran to the end",
    "models": [{"name": "dahl", "rank": 1}, {"name": "lugre", "rank": 2, "more": {"unit": "N"}}],
    "pieces": [{"begin": 0.0}, {"begin": 1.0, "end": "late"}, {"begin": 2.0, "end": "early"}],
    "choices": ["one", "two"],
    "provenance": {"command": "bristle"},
}


def test_the_skeleton_of_a_result():
    assert skeleton(RESULT) == {
        "model": "= lugre",
        "metrics": {"rms": "number", "lost": "nothing"},
        "passed": "= true",
        "warnings": {"[]": "text"},
        "status": "= ran to the end",
        "models": {
            "[dahl]": {"name": "= dahl", "rank": "number"},
            "[lugre]": {"name": "= lugre", "rank": "number", "more": {"unit": "= N"}},
        },
        "pieces": {"[]": {"begin": "number", "end": {"seen: = early": "", "seen: = late": "", "seen: absent": ""}}},
        "choices": {"[one]": "= one", "[two]": "= two"},
        "provenance": {"command": "text"},
    }


@pytest.mark.parametrize(
    ("changed", "places"),
    [
        ({"more": 1.0}, []),
        ({"models": [*RESULT["models"], {"name": "gms"}]}, []),
        ({"models": RESULT["models"][:1]}, ["models.[lugre]"]),
        ({"metrics": {"rmse": 1.0, "lost": None}}, ["metrics.rms"]),
        ({"metrics": {"rms": 1.0, "lost": 2.0}}, ["metrics.lost"]),
        ({"metrics": 1.0}, ["metrics"]),
        ({"passed": False}, ["passed"]),
        ({"status": "ended early"}, ["status"]),
        ({"warnings": []}, ["warnings.[]"]),
        ({"status": "ran to the end 2"}, ["status"]),
        ({"choices": ["two", "one", "three"]}, []),
        ({"choices": ["two"]}, ["choices.[one]"]),
        ({"pieces": [{"begin": 0.0}]}, ["pieces.[].end"]),
        ({"pieces": [*RESULT["pieces"], {"end": "never"}]}, ["pieces.[].begin"]),
        ({"pieces": [*RESULT["pieces"], {"begin": 0.0, "end": "never"}]}, []),
        ({"provenance": {"command": "other"}}, []),
        ({"provenance": {}}, ["provenance.command"]),
    ],
)
def test_missing_keys_are_reported_and_added_keys_are_not(changed, places):
    assert [difference.path for difference in differences(skeleton(RESULT), skeleton(RESULT | changed))] == places


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("log", ("log", "log.csv", "--axis", "axis.toml")),
        ("predict", ("predict", "model.toml", "log.csv", "--axis", "axis.toml")),
        ("explain", ("explain", "few_speeds")),
        ("models", ("models", "gms")),
        ("check", ("check", "model.toml")),
        ("identify", ("identify", "log.csv", "--axis", "axis.toml", "--model", "viscous", "--draws", 0)),
    ],
)
def test_a_result_has_the_published_schema(bristle, place, command, words):
    published = json.loads((ROOT / "docs/reference/schema.json").read_text(encoding="utf-8"))
    schema = {"$ref": f"#/$defs/{command}", "$defs": published["$defs"]}
    data = bristle(*words, "--json").data
    assert [error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(data)] == []
    jsonschema.Draft202012Validator.check_schema(published)
    key = schema["$defs"][command]["required"][0]
    assert list(jsonschema.Draft202012Validator(schema).iter_errors({name: value for name, value in data.items() if name != key}))

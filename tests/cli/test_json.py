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
from tests.golden.yard import yard

from bristle.apps.lab.page import MARK
from bristle.cli.application import application

FAST = [item for item in (CASES[f"json_{name}"] for name in COMMANDS) if item.fast]


# Commands in the reference, and the command line that shows all of their keys.
DOCUMENTED = {
    name: name
    for name in (
        "identify",
        "predict",
        "compare",
        "paper",
        "design",
        "lab",
        "log",
        "excite",
        "explain",
        "tune",
    )
} | {
    "identify": "identify identify_second_pass",
    "log": "log log_nameless log_explained",
    "run": "run_seeds",
    "check": "check_own",
    "models": "models_lugre",
}


@pytest.fixture(autouse=True)
def pages_in_short(monkeypatch, undrawn):
    """Reports without figures, and what every page of the lab begins with: the pages themselves have their tests."""
    monkeypatch.setattr("bristle.apps.lab.lab_page", lambda *_, **__: MARK)


@pytest.fixture(scope="module", autouse=True)
def files_of_commands():
    """The folder in which the command lines run, made once."""
    return yard()


@cache
def printed(name):
    return CASES[f"json_{name}"].found()


LONG = {"excite", "predict_with_band", "design", "design_diverging", "paper", "lab"} | {
    f"identify{name}"
    for name in (
        "",
        "_without_loop",
        "_late",
        "_second_pass",
        "_open_loop",
        "_elements",
        "_own",
        "_each",
        "_in_loop",
        "_pulls",
        "_several",
    )
}


def cases(names):
    """Return each command line as a case; those that take long are slow."""
    return [
        pytest.param(
            name,
            marks=pytest.mark.slow if LONG & {name, *DOCUMENTED.get(name, name).split()} else (),
        )
        for name in names
    ]


def frozen(name):
    return json.loads(CASES[f"json_{name}"].file.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", cases(item.name.removeprefix("json_") for item in FAST))
def test_no_key_is_missing_and_no_name_has_changed(name):
    result = [str(difference) for difference in differences(frozen(name), printed(name))]
    if COMPILER is None:  # then `check` cannot compare the bits of C, and says so
        result = [
            difference
            for difference in result
            if not difference.startswith("json.certificates.same bits exported.")
        ]
    assert result[:20] == []


def has_documented_keys(command, shown):
    result, *further = (shown(name)["json"] for name in DOCUMENTED[command].split())
    keys = documented(command)
    assert [
        key for key in keys if not any(is_found(item, key) for item in (result, *further))
    ] == []
    assert set(result) == {re.split(r"[.\[]", key)[0] for key in keys}
    entry = next(iter(result.get("variants", result.get("certificates", {})).values()), {})
    assert set(entry) <= {part for key in keys for part in key.split(".")}


@pytest.mark.parametrize("command", cases(DOCUMENTED))
def test_json_has_exactly_the_documented_keys(command):
    has_documented_keys(command, printed)


@pytest.mark.parametrize("command", DOCUMENTED)
def test_frozen_json_has_exactly_the_documented_keys(command):
    has_documented_keys(command, frozen)


def test_every_command_has_documented_json():
    assert {line.split()[0] for line in COMMANDS.values()} == {
        "board",
        *(registered.name for registered in application().registered_commands),
    }


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
        "pieces": {
            "[]": {
                "begin": "number",
                "end": {"seen: = early": "", "seen: = late": "", "seen: absent": ""},
            }
        },
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
    assert [
        difference.path for difference in differences(skeleton(RESULT), skeleton(RESULT | changed))
    ] == places


@pytest.fixture(scope="module")
def published():
    """The schema of all results, which is one itself."""
    schema = json.loads((ROOT / "docs/reference/schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return schema


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("log", ("log", "log.csv", "--axis", "axis.toml")),
        ("predict", ("predict", "model.toml", "log.csv", "--axis", "axis.toml")),
        ("explain", ("explain", "few_speeds")),
        ("models", ("models", "gms")),
        ("check", ("check", "model.toml")),
        pytest.param(
            *(
                "identify",
                (
                    "identify",
                    "log.csv",
                    "--axis",
                    "axis.toml",
                    "--model",
                    "viscous,coulomb_viscous",
                    "--draws",
                    0,
                ),
            ),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_result_has_the_published_schema(bristle, place, remembered, published, command, words):
    schema = {"$ref": f"#/$defs/{command}", "$defs": published["$defs"]}
    data = bristle(*words, "--json").data
    assert set(data) == {re.split(r"[.\[]", key)[0] for key in documented(command)}
    assert [
        error.message for error in jsonschema.Draft202012Validator(schema).iter_errors(data)
    ] == []
    key = schema["$defs"][command]["required"][0]
    assert list(
        jsonschema.Draft202012Validator(schema).iter_errors(
            {name: value for name, value in data.items() if name != key}
        )
    )

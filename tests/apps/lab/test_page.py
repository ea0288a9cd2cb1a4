"""The page is whole: it asks for nothing, its scripts are named by their hashes, and it is small."""

import base64
import hashlib
import re
from dataclasses import replace

import pytest
from tests.apps.lab.scripts import SLOTS, data_of

import bristle as br
from bristle.apps.lab import lab_page
from bristle.apps.targets.page import described, sliders
from bristle.cli.demonstration import axis_simulated
from bristle.contract import example_of
from bristle.core.documented import Relation
from bristle.models.friction import MODELS, with_slots

pytestmark = pytest.mark.slow

LARGEST = 400_000


@pytest.fixture(scope="module")
def page():
    return lab_page()


@pytest.fixture(scope="module")
def heaviest():
    model = example_of(with_slots(MODELS["preisach_lugre"], SLOTS))
    uncertainty = {"F_C_pos": {"interval": [15.0, 25.0], "status": "identified"}}
    return lab_page(
        model, uncertainty=uncertainty, source="</script><script>alert(1)</script>.toml"
    )


def test_the_policy_allows_exactly_the_scripts_of_the_page(page):
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1].replace("&#39;", "'")
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    assert rules["default-src"] == "'none'"
    for element, rule, count in (("script", "script-src", 2), ("style", "style-src", 1)):
        texts = re.findall(rf'<{element}(?: id="\w+")?>(.*?)</{element}>', page, re.DOTALL)
        hashes = [
            base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts
        ]
        assert len(texts) == count
        parts = [part for part in rules[rule].split() if part != "'wasm-unsafe-eval'"]
        assert parts == [f"'sha256-{each}'" for each in hashes]
    # A worker runs what the page itself hands it; nothing may be loaded.
    assert rules["worker-src"] == "blob:"
    assert "unsafe-inline" not in policy


def test_the_page_is_self_contained(page):
    assert not re.search(r"https?:|//[a-z]+\.|@import|\bfetch\(|XMLHttp|importScripts", page)
    assert set(re.findall(r'(?:src|href)="([^"]*)"', page)) == {"data:,", "#machine", "#selftest"}
    assert not re.search(r"\son[a-z]+=\"|style=\"", page)


def test_it_is_small(page, heaviest):
    assert max(len(text.encode()) for text in (page, heaviest)) < LARGEST


def test_every_model_is_there_and_the_given_one_first(page, heaviest):
    assert [model["name"] for model in data_of(page)["models"]] == list(MODELS)
    first, *rest = data_of(heaviest)["models"]
    assert [model["name"] for model in rest] == list(MODELS)
    assert (first["model"], first["own"]["slots"], data_of(heaviest)["first"]) == (
        "preisach_lugre",
        list(SLOTS),
        0,
    )


def test_no_file_name_closes_its_element(heaviest):
    assert len(re.findall(r"<script", heaviest)) == 3
    assert data_of(heaviest)["models"][0]["name"].endswith(
        "</script><script>alert(1)</script>.toml"
    )


def test_an_identified_interval_lies_on_its_slider(heaviest):
    rows = {row["name"]: row for row in data_of(heaviest)["models"][0]["own"]["rows"]}
    assert [rows[name]["interval"] for name in ("F_C_pos", "F_C_neg")] == [[15.0, 25.0], None]
    slider = rows["F_C_pos"]["sliders"][0]
    assert slider["low"] < 15.0 < 25.0 < slider["high"]


def test_it_is_the_same_page_each_time(page):
    assert lab_page() == page


def test_units_are_those_of_the_axis():
    model = br.friction.lugre(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_0="100 N*m/rad")
    first = data_of(lab_page(model))["models"][0]
    assert first["units"] == {"position": "rad", "velocity": "rad/s", "force": "N·m"}
    assert {row["name"]: row["unit"] for row in first["pull"]} == {
        "M": "kg·m²",
        "k": "N·m/rad",
        "v_e": "rad/s",
    }


def test_texts_of_a_user_model_are_escaped():
    model = example_of(with_slots(MODELS["stribeck"], ()))
    relation = Relation("F_S > F_C", lambda p: p.F_S > p.F_C, "<img src=x> raise F_S; or not")
    (condition,) = sliders.conditions_of(replace(model.component, relations=(relation,)))
    assert condition["mend"] == "&lt;img src=x&gt; raise <i>F</i><sub>S</sub>"


def test_a_user_parameter_may_have_the_name_of_a_layer():
    model = axis_simulated.friction()
    assert {"forward", "backward"} <= set(model.values)
    assert {
        row["name"] for row in described.model_described(model, proven=False)["variables"]
    } == set(model.values)
    assert sliders.inner_of(model.parameters) == model.parameters

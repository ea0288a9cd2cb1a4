"""``bristle models``: what there is."""

import pytest

from bristle import friction
from bristle.cli import models
from bristle.friction import MODELS
from bristle.hysteresis import OPERATORS


@pytest.mark.parametrize("name", [*MODELS, "lugre+asymmetry", "cascade", "inertia", "encoder", "sine", "recorded", *OPERATORS])
def test_a_model_is_shown_by_name(bristle, name):
    shown = bristle("models", name)
    assert shown.code == 0
    (item,) = bristle("models", name, "--json").data["models"]
    assert item["name"] == name
    assert all(parameter in shown.out for parameter in item["parameters"])


def test_without_a_name_all_are_shown(bristle):
    shown = bristle("models").out
    assert all(name in shown for name in (*MODELS, "cascade", "+asymmetry"))


def test_a_share_has_both_ends_of_its_range(bristle):
    row = next(line for line in bristle("models", "preisach").out.splitlines() if line.split()[:1] == ["tolerance"])
    assert "0 to 1" in row


# --- one and all of them, as they are printed ------------------------------------------------------------------------


@pytest.fixture
def printed(monkeypatch):
    """Paragraphs and tables in their order."""
    parts = []
    for name in ("say", "show_table"):
        monkeypatch.setattr(models, name, parts.append)
    monkeypatch.setattr(models, "say_laid_out", lambda lay_out: parts.append(lay_out(80)))
    return parts


def test_equations_come_first_and_then_parameters_conditions_and_source(printed):
    component = friction.find("stribeck")
    models._show_one(component)
    equations, table, *rest = printed
    assert equations == component.laid_out(80)
    assert table.caption == f"{component.name}: {component.description}"
    assert list(table.heads) == ["Parameter", "Meaning", "Unit", "Unit, rotational", "Allowed", "Default"]
    rows = {row[0]: row for row in table.rows}
    assert list(rows) == list(component.variables)
    assert list(rows["F_C"][2:4]) == ["N", "N·m"]
    assert list(rows["v_S"][1:4]) == [component.variables["v_S"].description, "m/s", "rad/s"]
    assert (rows["F_C"][5], rows["delta_S"][5]) == ("", "2")
    assert rest == [
        *(f"{'Should have' if relation.advisory else 'Needs'} {relation.condition}." for relation in component.relations),
        *([f"Source: {component.reference}"] if component.reference else []),
    ]
    assert any(part.startswith("Needs ") for part in rest)

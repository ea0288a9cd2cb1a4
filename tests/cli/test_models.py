"""``bristle models``: what there is."""

import pytest

from bristle.friction import MODELS
from bristle.hysteresis import OPERATORS


def test_every_friction_model_is_listed_with_units_and_ranges(bristle):
    result = bristle("models", "--json")
    assert result.code == 0
    listed = {item["name"]: item for item in result.data["models"] if item["family"] == "friction"}
    assert set(listed) == set(MODELS)
    parameter = listed["coulomb"]["parameters"]["F_C"]
    assert (parameter["unit"], parameter["unit_rotational"], parameter["max"]) == ("N", "N*m", None)
    families = {"friction", "hysteresis", "plant", "controller", "sensor", "reference", "slot"}
    assert {item["family"] for item in result.data["models"]} == families


@pytest.mark.parametrize("name", [*MODELS, "lugre+asymmetry", "cascade", "inertia", "encoder", "sine", "recorded", *OPERATORS])
def test_one_by_name(bristle, name):
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

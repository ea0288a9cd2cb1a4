"""Slots that are put on a model: what their numbers begin with, over the scales of the model."""

import numpy as np
import pytest

from bristle.core.motion import Motion
from bristle.exports.page import switches
from bristle.exports.page.described import stored
from bristle.exports.page.sliders import Scales
from bristle.exports.page.switches import (
    NEUTRAL,
    STARTS,
    begun,
    combinations,
    offered,
    plain_of,
    slots_described,
    slots_of,
    start_of,
    surrounded,
)
from bristle.friction import coulomb, lugre, stribeck, viscous, with_slots
from bristle.testing import example_of

SCALES = Scales(reach=2e-5, speed=0.1, force=30.0)


def test_numbers_of_slots_begin_over_the_scales_of_a_model():
    assert start_of("x_L", SCALES) == pytest.approx(1e-4)  # half of ten distances of pre-sliding
    assert start_of("pitch", SCALES) == pytest.approx(8e-5)
    assert start_of("c_1", SCALES) == pytest.approx(3.0)
    assert start_of("h_c1", SCALES) == pytest.approx(6.0)
    assert [start_of(name, SCALES) for name in ("p_1", "k_L", "k_T", "c_T", "around_load")] == [0.2, 0.5, -0.01, 0.2, 1.5]
    for name in ("x_0", "a_1", "a_2", "s_1", "c_2", "s_2", "h_s1", "h_c2", "h_s2", "p_2"):
        assert start_of(name, SCALES) == 0.0  # one wave, and the way along the axis, are enough to begin with


def test_sliders_of_slots_reach_both_sides_of_zero():
    for name in ("a_1", "a_2", "c_1", "s_1", "c_2", "s_2", "h_c1", "h_s1", "h_c2", "h_s2"):
        assert STARTS[name].ends == (-1.0, 1.0)
        assert STARTS[name].scale == "force"
    assert STARTS["x_0"].ends == (-20.0, 20.0)
    assert STARTS["p_2"].ends == (-0.8, 0.8)
    low, high = STARTS["around_temperature"].ends
    assert (low - 273.15, high - 273.15) == pytest.approx((-40.0, 120.0))
    assert STARTS["around_temperature"].value == Motion(0.0, 0.0).temperature + 10.0
    assert STARTS["around_load"].ends == (0.0, 5.0)
    assert STARTS["around_transmitted"].ends == (-4.0, 4.0)
    for name, start in STARTS.items():
        if start.ends is not None:
            assert start.ends[0] <= start.value <= start.ends[1], name


def test_the_two_directions_start_a_tenth_above_and_below():
    plain = plain_of(stribeck(F_C=10.0, F_S=20.0, v_S=0.1, F_v=1.0))
    model = begun(plain, ["asymmetry"], SCALES)
    assert (model.values["F_C_pos"], model.values["F_C_neg"]) == (11.0, 9.0)
    assert (model.values["F_S_pos"], model.values["F_S_neg"]) == (22.0, 18.0)
    assert slots_of(model) == ("asymmetry",)
    back = plain_of(model)
    assert (back.values["F_C"], back.values["F_S"], slots_of(back)) == (10.0, 20.0, ())


def test_slots_have_the_order_of_a_name_and_are_offered_if_effective():
    model = with_slots(lugre, ["load", "asymmetry"])
    assert slots_of(begun(plain_of(example_of(lugre)), ["asymmetry", "load"], SCALES)) == slots_of(example_of(model))
    assert "asymmetry" in offered(coulomb(F_C=1.0))
    assert set(offered(viscous(F_v=1.0))) < set(offered(coulomb(F_C=1.0)))
    assert "load" in offered(coulomb(F_C=1.0))


def test_sets_of_slots_are_all_of_them_or_each_alone_and_all_together():
    assert combinations(("a", "b", "c"), complete=False) == [("a",), ("b",), ("c",), ("a", "b", "c")]
    whole = combinations(("a", "b"), complete=True)
    assert whole == [(), ("b",), ("a",), ("a", "b")]


def test_the_mean_of_a_plain_model_keeps_its_offset_and_its_arrays():
    model = with_slots(coulomb, ["asymmetry"])(F_C_pos=3.0, F_C_neg=1.0, offset=0.25)
    assert plain_of(model).values["F_C"] == 2.0
    assert plain_of(model).values["offset"] == 0.25
    assert plain_of(coulomb(F_C=3.0)).values["offset"] == 0.0


def test_the_surroundings_of_a_model_are_parameters():
    component = surrounded(with_slots(coulomb, ["load"]))
    assert component.surroundings == ()
    names = [name for name in component.variables if name.startswith("around_")]
    assert names == ["around_load", "around_temperature", "around_transmitted"]
    assert {name: NEUTRAL[name] for name in names} == {
        "around_load": 1.0,
        "around_temperature": Motion(0.0, 0.0).temperature,
        "around_transmitted": 0.0,
    }


@pytest.mark.parametrize("kind", ["translational", "rotational"])
def test_a_page_has_the_neutral_values_of_a_slot(kind):
    slots = slots_described(kind)
    rows = {row["name"]: row for slot in slots.values() for row in slot.get("rows", ())}
    assert rows["p_1"]["nothing"] == 0.0
    assert rows["x_L"]["scale"] == "reach"
    assert rows["c_1"]["sliders"] == [{"low": -1.0, "high": 1.0, "logarithmic": False, "to_zero": False, "endless": False}]
    assert all(row["slot"] for row in rows.values())
    assert slots["load"]["around"]["name"] == "around_load"
    assert slots["position"]["condition"]["advisory"] is False
    assert np.isfinite(slots["position"]["condition"]["least"])


def test_walks_of_the_package_are_those_of_every_set_of_slots(monkeypatch):
    monkeypatch.setattr(switches, "walks_of", lambda model: {"contact": {}})
    monkeypatch.setattr(switches, "slot_walks", lambda *_, complete: {"complete": complete})
    assert switches.all_walks(viscous(F_v=1.0)) == {"contact": {}, "slots": {"complete": True}}
    assert all(walks["slots"]["complete"] for walks in stored().values())

"""Slots that are put on a model: what their numbers begin with, over the scales of the model."""

import math

import numpy as np
import pytest

from bristle.apps.targets.page import switches
from bristle.apps.targets.page.described import (
    BLOCK,
    LONG,
    PUSHED,
    example_named,
    stored,
    variables_of,
    walks_of,
)
from bristle.apps.targets.page.sliders import (
    Scales,
    conditions_of,
    elements_of,
    pulled_by,
    scales_of,
    shares_of,
    slider_for,
)
from bristle.contract import example_of
from bristle.core.motion import Motion
from bristle.core.variable import Variable
from bristle.exports.subject import subject_of
from bristle.models.friction import (
    MODELS,
    coulomb,
    coulomb_viscous,
    dahl,
    find,
    lugre,
    maxwell_slip,
    stribeck,
    viscous,
    with_slots,
)

SCALES = Scales(reach=2e-5, speed=0.1, force=30.0)


# One wave, and the way along the axis, are enough to begin with: the others begin at zero.
BEGINS = {
    "x_L": 1e-4,
    "pitch": 8e-5,
    "c_1": 3.0,
    "h_c1": 6.0,
    "p_1": 0.2,
    "k_L": 0.5,
    "k_T": -0.01,
    "c_T": 0.2,
    "around_load": 1.5,
}
BEGINS |= dict.fromkeys(
    ("x_0", "a_1", "a_2", "s_1", "c_2", "s_2", "h_s1", "h_c2", "h_s2", "p_2"), 0.0
)
FORCES = ("a_1", "a_2", "c_1", "s_1", "c_2", "s_2", "h_c1", "h_s1", "h_c2", "h_s2")
ENDS = dict.fromkeys(FORCES, (-1.0, 1.0)) | {
    "x_0": (-20.0, 20.0),
    "p_2": (-0.8, 0.8),
    "around_load": (0.0, 5.0),
}
ENDS |= {"around_transmitted": (-4.0, 4.0), "around_temperature": (273.15 - 40.0, 273.15 + 120.0)}


@pytest.mark.parametrize("name", BEGINS)
def test_numbers_of_slots_begin_over_the_scales_of_a_model(name):
    assert switches.start_of(name, SCALES) == pytest.approx(BEGINS[name])


def test_sliders_of_slots_reach_both_sides_of_zero():
    assert {name: switches.STARTS[name].ends for name in ENDS} == {
        name: pytest.approx(ends) for name, ends in ENDS.items()
    }
    assert {switches.STARTS[name].scale for name in FORCES} == {"force"}
    assert switches.STARTS["around_temperature"].value == Motion(0.0, 0.0).temperature + 10.0
    outside = [
        name
        for name, start in switches.STARTS.items()
        if start.ends and not start.ends[0] <= start.value <= start.ends[1]
    ]
    assert outside == []


def test_the_two_directions_start_a_tenth_above_and_below():
    plain = switches.plain_of(stribeck(F_C=10.0, F_S=20.0, v_S=0.1, F_v=1.0))
    model = switches.begun(plain, ["asymmetry"], SCALES)
    values = {name: model.values[name] for name in ("F_C_pos", "F_C_neg", "F_S_pos", "F_S_neg")}
    assert values == {"F_C_pos": 11.0, "F_C_neg": 9.0, "F_S_pos": 22.0, "F_S_neg": 18.0}
    back = switches.plain_of(model)
    assert (
        back.values["F_C"],
        back.values["F_S"],
        switches.slots_of(model),
        switches.slots_of(back),
    ) == (10.0, 20.0, ("asymmetry",), ())


def test_slots_have_the_order_of_a_name_and_are_offered_if_effective():
    model = with_slots(lugre, ["load", "asymmetry"])
    assert switches.slots_of(
        switches.begun(switches.plain_of(example_of(lugre)), ["asymmetry", "load"], SCALES)
    ) == switches.slots_of(example_of(model))
    assert {"asymmetry", "load", *switches.offered(viscous(F_v=1.0))} < set(
        switches.offered(coulomb(F_C=1.0))
    )


def test_sets_of_slots_are_all_of_them_or_each_alone_and_all_together():
    assert switches.combinations(("a", "b", "c"), complete=False) == [
        ("a",),
        ("b",),
        ("c",),
        ("a", "b", "c"),
    ]
    assert switches.combinations(("a", "b"), complete=True) == [(), ("b",), ("a",), ("a", "b")]


def test_the_mean_of_a_plain_model_keeps_its_offset_and_its_arrays():
    model = with_slots(coulomb, ["asymmetry"])(F_C_pos=3.0, F_C_neg=1.0, offset=0.25)
    assert dict(switches.plain_of(model).values) == {"F_C": 2.0, "offset": 0.25}
    assert switches.plain_of(coulomb(F_C=3.0)).values["offset"] == 0.0


def test_the_surroundings_of_a_model_are_parameters():
    component = switches.surrounded(with_slots(coulomb, ["load"]))
    assert component.surroundings == ()
    assert {
        name: switches.NEUTRAL[name] for name in component.variables if name.startswith("around_")
    } == {
        "around_load": 1.0,
        "around_temperature": Motion(0.0, 0.0).temperature,
        "around_transmitted": 0.0,
    }


@pytest.mark.parametrize("kind", ["translational", "rotational"])
def test_a_page_has_the_neutral_values_of_a_slot(kind):
    slots = switches.slots_described(kind)
    rows = {row["name"]: row for slot in slots.values() for row in slot.get("rows", ())}
    assert (rows["p_1"]["nothing"], rows["x_L"]["scale"]) == (0.0, "reach")
    assert rows["c_1"]["sliders"] == [
        {"low": -1.0, "high": 1.0, "logarithmic": False, "to_zero": False, "endless": False}
    ]
    assert all(row["slot"] for row in rows.values())
    assert slots["load"]["around"]["name"] == "around_load"
    condition = slots["position"]["condition"]
    assert (condition["advisory"], np.isfinite(condition["least"])) == (False, True)


def test_a_walk_has_the_surroundings_of_its_slots_only():
    scales = switches.scales_of(switches.subject_of(example_named("coulomb")))
    neutral = list(switches.Surroundings())
    assert switches._around(("position", "asymmetry"), scales) == neutral
    for place, slot in enumerate(("load", "temperature", "transmitted")):
        differs = [
            value != usual
            for value, usual in zip(switches._around((slot,), scales), neutral, strict=True)
        ]
        assert differs == [index == place for index in range(3)]


def test_walks_of_the_package_are_those_of_every_set_of_slots(monkeypatch):
    monkeypatch.setattr(switches, "walks_of", lambda model: {"contact": {}})
    monkeypatch.setattr(switches, "slot_walks", lambda *_, complete: {"complete": complete})
    assert switches.all_walks(viscous(F_v=1.0)) == {"contact": {}, "slots": {"complete": True}}
    assert all(walks["slots"]["complete"] for walks in stored().values())


# --- A slider reaches what its variable may be, what it is, and what it was identified to be


FORCE = Variable("force", "some force", min=0.0)


OFFSET = Variable("force", "offset")
SIGNED, LOGARITHMIC = (False, False, False), (True, False, False)
TO_ZERO = (True, True, False)


@pytest.mark.parametrize(
    ("variable", "value", "options", "slider"),
    [
        # A hundredfold to either side of a positive number, within what is allowed, with its interval.
        (FORCE, 20.0, {}, (0.2, 2000.0, *TO_ZERO)),
        (FORCE, 20.0, {"around": 10.0}, (2.0, 200.0, *TO_ZERO)),
        (FORCE, 20.0, {"interval": (0.0, 21.0)}, (0.2, 2000.0, *TO_ZERO)),
        (FORCE, 20.0, {"interval": (1e-4, 21.0)}, (1e-4, 2000.0, *TO_ZERO)),
        (FORCE, 20.0, {"interval": (19.0, 1e6)}, (0.2, 1e6, *TO_ZERO)),
        (Variable("force", "some force", min=0.0, nominal=3.0), 0.0, {}, (0.03, 300.0, *TO_ZERO)),
        (Variable("1", "a factor", min=10.0), 20.0, {}, (10.0, 2000.0, *LOGARITHMIC)),
        (Variable("1", "factor", min=0.5, max=math.inf), 2.0, {}, (0.5, 200.0, *LOGARITHMIC)),
        # Infinity is at the end.
        (
            Variable("length/time", "some velocity", min=1e-12, nominal=0.05),
            math.inf,
            {},
            (5e-4, 5.0, True, False, True),
        ),
        # By factors from two decades on.
        (Variable("1", "exponent", min=0.1, max=10.0), 2.0, {}, (0.1, 10.0, *LOGARITHMIC)),
        (Variable("1", "exponent", min=0.11, max=10.0), 2.0, {}, (0.11, 10.0, *SIGNED)),
        (Variable("1", "share", min=0.0, max=1.0), 0.3, {}, (0.0, 1.0, *SIGNED)),
        (Variable("1", "share", min=-1.0, max=1.0), 0.3, {}, (-1.0, 1.0, *SIGNED)),
        # A number of either sign lies in the middle.
        (OFFSET, 3.0, {}, (-12.0, 12.0, *SIGNED)),
        (OFFSET, 0.0, {"span": 28.0}, (-28.0, 28.0, *SIGNED)),
        (OFFSET, 3.0, {"interval": (-10.0, 4.0)}, (-40.0, 40.0, *SIGNED)),
        (Variable("force", "offset", min=-5.0), 3.0, {}, (-5.0, 12.0, *SIGNED)),
        (Variable("force", "offset", max=5.0), 3.0, {}, (-12.0, 5.0, *SIGNED)),
        (Variable("force", "offset", nominal=2.0), 0.0, {}, (-2.0, 2.0, *SIGNED)),
    ],
)
def test_a_slider_reaches_what_its_variable_may_be(variable, value, options, slider):
    assert slider_for(variable, value, **options) == pytest.approx(slider)


def test_a_mass_that_sticks_and_slips_waits_for_thirty_of_its_periods():
    scales = Scales(reach=1e-5, speed=0.04, force=20.0)
    pulled = pulled_by(scales, coulomb(F_C=20.0), mass=4.0)
    values = pulled.values
    assert (values["M"], values["v_e"]) == (4.0, 0.01)
    # From one side of friction to the other, 0.3 of it each.
    waits = 2.0 * 0.3 * 20.0 / (values["k"] * values["v_e"])
    assert waits == pytest.approx(30.0 * 2.0 * math.pi * math.sqrt(4.0 / values["k"]), rel=0.05)
    assert pulled_by(scales, coulomb(F_C=20.0)).values["M"] == 1.0


def test_scales_are_the_largest_force_the_speed_of_the_fall_and_the_distance_before_sliding():
    models = (
        stribeck(F_C=8.0, F_S=11.0, v_S=4e-3, F_v=30.0),
        coulomb_viscous(F_C=1.0, F_v=3000.0),
        dahl(F_C=8.0, sigma_0=4e5),
    )
    falling, film, bristles = (scales_of(subject_of(model)) for model in models)
    assert (falling.speed, falling.force, bristles.force) == (4e-3, 11.0, 8.0)
    assert (film.speed, film.force) == pytest.approx(
        (1000.0 * film.reach, 3000.0 * 10.0 * film.speed)
    )
    assert 0.3 < bristles.reach / (8.0 / 4e5) < 10.0


def test_shares_and_conditions_are_listed_for_models_with_them():
    assert [shares_of(maxwell_slip), shares_of(dahl)] == [["nu_i"], []]
    entries = [*conditions_of(stribeck), *conditions_of(with_slots(stribeck, ["asymmetry"]))]
    levels = [
        (entry["left"], entry["sign"], entry["right"])
        for entry in entries
        if entry["left"][0].startswith("F_S")
    ]
    assert levels == [([f"F_S{side}"], ">=", [f"F_C{side}"]) for side in ("", "_pos", "_neg")]


def test_elements_are_drawn_of_models_that_have_some():
    model = maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])
    drawn = elements_of(model, 2)
    assert (drawn["numbers"], drawn["word"], drawn["unit"]) == (2, "deflection", "m")
    assert drawn["limits"] == [{"times": ["nu_i", "F_C"], "over": ["k_i"]}] * 2
    assert elements_of(model, 0) is elements_of(dahl(F_C=8.0, sigma_0=4e5), 2) is None


def test_a_row_of_a_parameter_has_a_slider_for_each_number_and_the_known_interval():
    placed = find("coulomb+position")(F_C=1.0, x_0=0.0, x_L=1.0, p_1=0.0, p_2=0.0, a_1=0.0, a_2=0.0)
    known = {"F_C": {"interval": (0.9, 1.2), "status": "identified"}}
    rows = {row["name"]: row for row in variables_of(placed, {"F_C"}, 28.0, known)}
    # A force that is 0 goes as far as forces do, a length as far as such lengths do.
    ends = {
        name: (row["sliders"][0]["low"], row["sliders"][0]["high"]) for name, row in rows.items()
    }
    assert (ends["offset"], ends["a_1"], ends["x_0"], ends["F_C"]) == (
        (-28.0, 28.0),
        (-28.0, 28.0),
        (-1.0, 1.0),
        (0.01, 100.0),
    )
    assert {name: row["fixed"] for name, row in rows.items() if not row["fixed"]} == {"F_C": False}
    told = [
        [rows[name][key] for key in ("interval", "status", "symbol")] for name in ("F_C", "offset")
    ]
    assert told == [[[0.9, 1.2], "identified", "<i>F</i><sub>C</sub>"], [None, "", "offset"]]
    assert ("directional" in rows["F_C"], "directional" in rows["x_0"]) == (True, False)
    shares = maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])
    rows = {
        row["name"]: row
        for row in variables_of(shares, (), 28.0, {"k_i": {"interval": (1.0, 2.0)}}, 10.0)
    }
    assert (rows["k_i"]["array"], rows["k_i"]["interval"], rows["F_C"]["array"]) == (
        True,
        None,
        False,
    )
    assert [slider["high"] for slider in rows["k_i"]["sliders"]] == [1e6, 2e6]


# --- The walks that every page repeats are those of the models as they are; write_walks writes them anew


def test_every_model_has_its_walks():
    lacking = " ".join(MODELS.keys() - stored().keys())
    assert list(stored()) == list(MODELS), f"run: python -m tests.apps.lab.write_walks {lacking}"
    for walks in stored().values():
        assert (walks["contact"]["count"], walks["mass"]["count"]) == (LONG, PUSHED)
        assert len(walks["contact"]["hashes"]) == LONG // BLOCK


@pytest.mark.fast_cases(8)
@pytest.mark.parametrize("name", MODELS)
def test_the_walks_are_up_to_date(name):
    fresh, kept = walks_of(example_named(name), BLOCK), stored()[name]
    assert fresh["mass"] == kept["mass"]
    assert fresh["contact"]["hashes"] == kept["contact"]["hashes"][:1]
    assert fresh["contact"]["scales"] == kept["contact"]["scales"]


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_all_of_the_walks_is_up_to_date(name):
    assert switches.all_walks(example_named(name)) == stored()[name]

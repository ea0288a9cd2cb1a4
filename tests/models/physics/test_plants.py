"""Plants by hand: what a step makes of an effort and a friction force, and what is beside friction on an axis."""

import math

import numpy as np
import pytest

from bristle.core import InputError
from bristle.models.plants import ball_screw, find, inertia, oscillator, pulled_inertia, with_terms
from bristle.models.plants.terms import (
    NOWHERE,
    effort_at,
    effort_of_columns,
    effort_of_place,
    gravity_at,
    place_of,
    terms_in,
    terms_of,
)

MASS = inertia(M=2.0)
SPRUNG = oscillator(M=2.0, c=3.0, k=10.0)
PULLED = pulled_inertia(M=2.0, k=10.0, v_e=0.5)
ARM = find("inertia+gravity+cogging", ["motor_3_cos", "screw_1_sin"])(
    kind="rotational",
    M=2.0,
    g_sin=4.0,
    g_cos=-1.0,
    motor_turn=0.5,
    screw_turn=2.0,
    motor_3_cos=0.7,
    screw_1_sin=0.2,
)
PLACES = {"inertia": MASS, "oscillator": SPRUNG, "pulled_inertia": PULLED, "arm": ARM}


STARTS = {
    name: plant.component.State(0.1, 0.4, *([0.3] if plant is PULLED else []))
    for name, plant in PLACES.items()
}


@pytest.mark.parametrize("name", PLACES)
def test_a_step_and_its_port_are_those_of_the_rate(name):
    plant, state, p = PLACES[name].component, STARTS[name], PLACES[name].parameters
    a, b = plant.port(state, 7.0, 0.05, p)
    assert b < 0.0
    for force in (0.0, 3.0, -20.0):
        x, moved = plant.step(state, 7.0, force, 0.05, p)
        assert x == moved.x == pytest.approx(0.1 + 0.05 * (a + b * force))
        assert 0.5 * (0.4 + moved.v) == pytest.approx(a + b * force)
    _, moved = plant.step(state, 7.0, 2.0, 1e-7, p)
    rate = [(after - before) / 1e-7 for after, before in zip(moved, state, strict=True)]
    assert rate == pytest.approx(list(plant.rate(state, 7.0, 2.0, p)), rel=1e-4)
    # At rest a body stays where it is while the far end of its spring moves.
    assert plant.rest(state, 7.0, 0.2, p) == (0.1, 0.0, *(x + 0.1 for x in state[2:]))


@pytest.mark.parametrize(
    ("name", "acceleration"),
    [
        ("inertia", (7.0 - 2.0) / 2.0),
        ("oscillator", (7.0 - 2.0 - 3.0 * 0.4 - 10.0 * 0.1) / 2.0),
        ("pulled_inertia", (7.0 - 2.0 + 10.0 * 0.2) / 2.0),
        (
            "arm",
            (
                5.0
                - 4.0 * math.sin(0.1)
                + math.cos(0.1)
                - 0.7 * math.cos(1.2 * math.pi)
                - 0.2 * math.sin(0.1 * math.pi)
            )
            / 2.0,
        ),
    ],
)
def test_acceleration_is_the_remaining_effort_over_the_mass(name, acceleration):
    rate = PLACES[name].component.rate(STARTS[name], 7.0, 2.0, PLACES[name].parameters)
    assert rate == pytest.approx((0.4, acceleration, *([0.5] if name == "pulled_inertia" else [])))


@pytest.mark.parametrize("plant", [MASS, SPRUNG, ARM])
def test_the_effort_of_a_motion_gives_that_motion(plant):
    x, v, a = np.array([0.1, -0.2]), np.array([0.4, 0.3]), np.array([1.5, -2.0])
    effort = plant.component.inverse(x, v, a, plant.parameters)
    for k in range(2):
        assert plant.component.rate(
            plant.component.State(x[k], v[k]), effort[k], 0.0, plant.parameters
        ).v == pytest.approx(a[k])


@pytest.mark.parametrize(
    "values",
    [
        {"spring_1": 40.0},
        {"spring_2": 7.0, "spring": "cubic"},
        {"spring_3": -3.0, "spring": "cubic"},
    ],
)
def test_a_spring_is_a_force_of_the_position_besides_gravity(values):
    terms = {"gravity": True, "spring": values.pop("spring", "linear")}
    place = place_of(with_terms(inertia, **terms)(M=1.0, g_sin=2.0, **values))
    assert not place.is_link
    assert place_of(with_terms(inertia, gravity=True)(M=1.0, g_sin=2.0)).is_link
    (name, value), x = next(iter(values.items())), 0.3
    assert effort_at(x, place) - gravity_at(x, place) == pytest.approx(value * x ** int(name[-1]))


def test_a_free_oscillator_keeps_its_energy():
    free, state = oscillator(M=2.0, c=0.0, k=10.0), oscillator.State(0.1, 0.0)
    for _ in range(50):
        _, state = free.component.step(state, 0.0, 0.0, 0.1, free.parameters)
    assert 0.5 * 2.0 * state.v**2 + 0.5 * 10.0 * state.x**2 == pytest.approx(0.05)


def test_a_screw_is_half_its_backlash_and_its_lead_over_a_turn():
    made = ball_screw(J=1e-4, M=20.0, lead="5 mm", k=1e8, d=2e3, backlash="20 um")
    assert made.component.screw(made.parameters) == pytest.approx(
        (20.0, 1e8, 2e3, 1e-5, 5e-3 / (2.0 * math.pi))
    )
    assert ball_screw.port(ball_screw.State(0.0, 1.0), 3.0, 0.1, made.parameters) == pytest.approx(
        (1.0 + 0.05 / 1e-4 * 3.0, -0.05 / 1e-4)
    )


def test_gravity_and_cogging_take_an_effort_at_each_place():
    x, place = np.array([0.0, 0.1, -0.3]), place_of(ARM)
    expected = (
        4.0 * np.sin(x) - np.cos(x) + 0.7 * np.cos(12.0 * np.pi * x) + 0.2 * np.sin(np.pi * x)
    )
    assert effort_of_place(x, terms_of(ARM)) == pytest.approx(expected)
    assert effort_at(0.1, place) == pytest.approx(expected[1])
    assert (place.g_sin, place.g_cos) == (4.0, -1.0)
    assert place.waves == pytest.approx([12.0 * math.pi, math.pi])
    values = {"motor_3_cos": 0.7, "motor_3_sin": 0.0, "screw_1_cos": 0.0, "screw_turn": 2.0}
    assert {name: ARM.values[name] for name in values} == values


@pytest.mark.parametrize("x", [0.0, 0.3, -2.0])
def test_a_plant_without_terms_takes_no_effort_anywhere(x):
    assert (terms_of(MASS), place_of(MASS), place_of(None)) == (None, NOWHERE, NOWHERE)
    assert effort_at(x, NOWHERE) == gravity_at(x, NOWHERE) == 0.0


@pytest.mark.parametrize(
    ("name", "effort"), [("g_sin", 4.0 * math.sin(0.1)), ("g_cos", 4.0 * math.cos(0.1))]
)
def test_gravity_of_one_part_alone_counts(name, effort):
    arm = find("inertia+gravity")(kind="rotational", M=2.0, **{name: 4.0})
    assert arm.component.rate(inertia.State(0.1, 0.0), 0.0, 0.0, arm.parameters).v == pytest.approx(
        -0.5 * effort
    )


def test_terms_act_half_way_ahead_of_a_step():
    a, b = ARM.component.port(inertia.State(0.1, 0.4), 7.0, 0.05, ARM.parameters)
    at = effort_of_place(np.array([0.1 + 0.5 * 0.05 * 0.4]), terms_of(ARM))[0]
    assert (a, b) == pytest.approx((0.4 + 0.0125 * (7.0 - at), -0.0125))


def test_known_columns_contribute_to_the_effort():
    made = find("inertia+known", ["known_wind", "known_belt"])(
        M=2.0, known_wind=3.0, known_belt=-1.0
    )
    effort = effort_of_columns(made, [np.array([1.0, 2.0]), np.array([10.0, 0.0])])
    assert effort.tolist() == [3.0 - 10.0, 6.0]
    assert effort_of_columns(MASS, [np.ones(2)]) is None
    with pytest.raises(
        InputError,
        match=r"log: has too few or too many known columns for the plant; found '?1 columns.*allowed '?wind, belt",
    ):
        effort_of_columns(made, [np.ones(2)])
    assert made.values["known_wind"] == 3.0


NONE = {
    "gravity": False,
    "cogging": {"motor": set(), "screw": set()},
    "columns": [],
    "spring": None,
}


@pytest.mark.parametrize(
    ("names", "terms"),
    [
        (
            [
                "M",
                "g_cos",
                "motor_6_cos",
                "motor_6_sin",
                "screw_1_sin",
                "known_a",
                "known_a",
                "motor_0_cos",
            ],
            {"gravity": True, "cogging": {"motor": {6}, "screw": {1}}, "columns": ["a"]},
        ),
        (["M", "g_sin"], {"gravity": True}),
        (["M"], {}),
    ],
)
def test_the_names_of_parameters_determine_the_terms(names, terms):
    assert terms_in(names) == NONE | terms


def test_the_description_of_a_plant_names_its_terms():
    made = with_terms(inertia, gravity=True, cogging={"screw": [2, 1, 2]}, columns=["a"])
    assert made.name == "inertia+gravity+cogging+known"
    assert made.description.endswith(
        ", with gravity of a link and cogging and known columns of a log"
    )
    assert {
        name: made.variables[name].description for name in ("screw_1_cos", "screw_2_sin", "known_a")
    } == {
        "screw_1_cos": "cogging once a turn of the screw, cosine",
        "screw_2_sin": "cogging 2 times a turn of the screw, sine",
        "known_a": "effort for a 1 in the known column a",
    }
    assert (made.turners, "screw_turn" in made.defaults) == (("screw",), False)
    assert {made.defaults[name] for name in ("g_sin", "screw_2_sin", "known_a")} == {0.0}


def test_terms_leave_out_what_a_plant_has_not():
    assert with_terms(inertia) is inertia
    assert with_terms(pulled_inertia, gravity=True).inverse is None
    assert with_terms(ball_screw, gravity=True).rate is None


@pytest.mark.parametrize(
    ("name", "keys", "words"),
    [
        ("inertja", (), "there is no such model.*Did you mean 'inertia'"),
        (3, (), "there is no such model"),
        (
            "inertia+gravitty",
            (),
            r"there is no such term; found '\+gravitty', allowed \+gravity, \+cogging, \+spring, \+known. Did you mean 'gravity'",
        ),
        (
            "inertia+cogging",
            ("g_sin",),
            r"has \+cogging, but no coefficient.*such as motor_6_cos = 0.1",
        ),
        (
            "inertia+known",
            ("motor_6_cos",),
            r"has \+known, but no coefficient.*such as known_NAME = 0.1",
        ),
    ],
)
def test_an_unknown_plant_is_refused_with_the_known_plants(name, keys, words):
    with pytest.raises(InputError, match=words):
        find(name, keys)

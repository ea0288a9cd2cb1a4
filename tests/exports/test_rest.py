"""A memoryless model at rest follows one rule in every language; hysteresis operators in C and Structured Text: the bits of bristle."""

import numpy as np
import pytest
from tests.exports.native import (
    COMPILER,
    Native,
    differing,
    example_with,
    in_structured_text,
    selected_cases,
    texts_of,
)
from tests.models.hysteresis.paths import OPERATORS, sized, walk

import bristle as br
from bristle.core.experiment import RESTS, Feedforward
from bristle.exports.described import Request
from bristle.exports.drive import direction_by, last_direction
from bristle.exports.targets import TARGETS
from bristle.exports.writing import files_for
from bristle.models.friction.resting import rest_rule, with_rest

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 1e-3
MEMORYLESS = ("coulomb", "coulomb_viscous", "stribeck", "stribeck_free")
# At rest before any motion, forward, at rest, backward, at rest, at rest.
PLACES = np.array([0.0, 0.0, 1e-3, 1e-3, -1e-3, -1e-3, -1e-3])
MOVING, RESTING = (2, 4), (3, 5, 6)


def model_of(name):
    """Return a model with other forces forward than backward, and without a viscous part that rest would change."""
    sided = example_with(name, ("asymmetry",))
    changed = {each: 0.0 for each in sided.values if each.startswith("F_v")}
    return sided.with_values(
        **changed, **{each: 0.0 for each in ("offset",) if each in sided.values}
    )


def jumps(model):
    """Return the limits at zero from either side, by a step too short for any other speed to be told from them."""
    x = np.array([0.0, 1.1e-10, 0.0])
    return br.response(model, x, 1.0)[1:]


def expected(model, rule):
    forward, backward = jumps(model)
    middle = 0.5 * (forward + backward)
    fixed = {"held": (middle, forward, backward, backward), "middle": (middle,) * 4}[rule]
    return dict(zip((1, *RESTING), fixed, strict=True))


@pytest.mark.parametrize("rule", RESTS)
@pytest.mark.parametrize("name", MEMORYLESS)
def test_python_follows_the_rule_at_rest(name, rule):
    model = model_of(name)
    force = br.response(model, PLACES, DT, rest=rule)
    for k, value in expected(model, rule).items():
        assert force[k] == pytest.approx(value, rel=1e-6), k
    assert force[MOVING[0]] > 0.0 > force[MOVING[1]]


@pytest.mark.parametrize("name", MEMORYLESS)
def test_a_step_within_rounding_counts_as_rest(name):
    """A generator of moves ends a leg a rounding too far: the force of the move is kept all the same."""
    x = np.array([0.0, 0.5e-3, np.nextafter(1e-3, 2.0), 1e-3, 1e-3, 1e-3])
    force = br.response(model_of(name), x, DT, rest="held")
    assert force[2] > 0.0
    assert force[3:] == pytest.approx(jumps(model_of(name))[0], rel=1e-6)


def test_a_drive_treats_a_step_within_rounding_as_rest():
    x = np.array([0.0, 0.5e-3, np.nextafter(1e-3, 2.0), 1e-3, 1e-3])
    assert last_direction(np.diff(x, prepend=0.0) / DT).tolist() == [0.0, 1.0, 1.0, 1.0, 1.0]
    assert direction_by("middle", np.diff(x, prepend=0.0) / DT).tolist() == [
        0.0,
        1.0,
        1.0,
        0.0,
        0.0,
    ]


@pytest.mark.parametrize("rule", RESTS)
def test_the_feedforward_of_a_loop_follows_the_rule_at_rest(rule):
    model = model_of("coulomb")
    fed = br.simulation.feedforward_effort(
        Feedforward(friction=model, rest=rule), PLACES, np.zeros(PLACES.size), DT
    )
    for k, value in expected(model, rule).items():
        # The effort of a sample acts over the step behind it.
        assert fed[k - 1] == pytest.approx(value, rel=1e-6)


def test_models_with_a_unique_force_at_rest_have_no_rule():
    assert [
        name for name in br.friction.MODELS if rest_rule(with_rest(example_with(name), "held"))
    ] == sorted(MEMORYLESS, key=list(br.friction.MODELS).index)


@pytest.mark.fast_cases(1)
@needs_compiler
@pytest.mark.parametrize("rule", RESTS)
def test_other_languages_follow_the_rule_at_rest_without_minus_zero(tmp_path, rule):
    models = {name: model_of(name) for name in ("coulomb", "stribeck_free")}
    native = Native(models, tmp_path / "c", rest=rule)
    blocks = in_structured_text(
        {name: texts_of(model, tmp_path, name, rest=rule) for name, model in models.items()},
        tmp_path / "st",
    )
    for name, model in models.items():
        force = br.response(model, PLACES, DT, rest=rule).tolist()
        assert (
            native.forces(name, PLACES, DT).tolist()
            == blocks.run(name, PLACES, DT)[0].tolist()
            == force
        )
        assert blocks.selftest(name) == (True, True)


@pytest.mark.fast_cases(7)
@pytest.mark.parametrize("name", [name for name, target in TARGETS.items() if target.rest])
def test_each_file_states_its_rule(name):
    plant = br.plants.inertia(M=12.0)
    requested = Request(model_of("coulomb"), "axis_x", DT, speed=0.1, plant=plant)
    for rule in RESTS:
        product = files_for(name, Request(**{**vars(requested), "rest": rule}))
        words = {"held": ("last direction",), "middle": ("the mean of both",)}[rule]
        assert any(
            "at rest" in note and any(word in note for word in words) for note in product.notes
        ), rule


@pytest.mark.slow
def test_a_note_warns_of_a_mass_outside_the_fmu():
    plant = br.plants.inertia(M=12.0)
    notes = files_for("fmu2", Request(model_of("coulomb"), "axis_x", DT, plant=plant)).notes
    assert any("creeps at rest" in note and "axis_x_mass.fmu" in note for note in notes)
    lugre = example_with("lugre")
    assert not any(
        "rests" in note
        for note in files_for("fmu2", Request(lugre, "axis_x", DT, plant=plant)).notes
    )


# --- hysteresis operators --------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def native(request, tmp_path_factory):
    names = {operator for (operator,) in selected_cases(request, "operator")} | {"inverse_preisach"}
    models = {operator.replace(" ", "_"): OPERATORS[operator] for operator in names}
    return Native(models, tmp_path_factory.mktemp("operators"))


@needs_compiler
@pytest.mark.fast_cases(5)
@pytest.mark.parametrize("operator", OPERATORS)
def test_outputs_are_identical_to_bristle(native, operator):
    u = sized(OPERATORS[operator], walk(7, count=4000))
    outputs = br.response(OPERATORS[operator], u)
    assert np.ptp(outputs) > 0.0
    assert differing(native.forces(operator.replace(" ", "_"), u, 0.0), outputs) == 0


INVERSE = OPERATORS["inverse_preisach"]
# The second force has no output.
BEYOND = [share * INVERSE.values["f_p"] for share in (0.5, 2.0, 0.25)]


def repeated():
    """Return the outputs beside it, of which the first is repeated."""
    first, last = br.response(INVERSE, [BEYOND[0], BEYOND[2]])
    return [first, first, last]


@needs_compiler
def test_an_inverse_without_an_output_repeats_the_last_output(native):
    assert native.forces("inverse_preisach", BEYOND, 0.0).tolist() == repeated()


@pytest.fixture(scope="module")
def blocks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blocks")
    names = {values: f"op_{values}".replace(" ", "_") for values in OPERATORS}
    return in_structured_text(
        {
            operator: texts_of(OPERATORS[values], folder, operator)
            for values, operator in names.items()
        },
        folder,
    )


@needs_compiler
@pytest.mark.slow
@pytest.mark.parametrize("operator", OPERATORS)
def test_structured_text_is_identical(blocks, operator):
    u, block = sized(OPERATORS[operator], walk(7, count=4000)), f"op_{operator}".replace(" ", "_")
    assert differing(blocks.run(block, excitation=u)[0], br.response(OPERATORS[operator], u)) == 0
    assert blocks.selftest(block) == (True, True)


@needs_compiler
@pytest.mark.slow
def test_structured_text_repeats_the_last_output_of_an_inverse(blocks):
    fixed, flags = blocks.run("op_inverse_preisach", excitation=BEYOND)
    assert fixed.tolist() == repeated()
    assert flags.tolist() == [0, 2, 2]

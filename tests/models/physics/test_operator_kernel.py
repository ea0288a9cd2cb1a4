"""A hysteresis operator as the kernel of a friction model: its bits, its memory, and what cannot be one."""

import pickle

import numpy as np
import pytest

import bristle as br
from bristle import friction, hysteresis
from bristle.contract import example_of
from bristle.core import InputError
from bristle.core.contracts import make_model
from bristle.engine import Contact, interpreted
from bristle.models.friction.next_model import model_with
from bristle.models.hysteresis import sliders

MODELS = ("preisach_contact", "preisach_lugre")
TABLES = ("everett_table", "reversal_table", "preisach_grid", "prandtl_ishlinskii")
# What compiles in a second; the others of the table take a minute and more.
QUICK = {("preisach_contact", "prandtl_ishlinskii")}
SLIDING = {"F_C": 3.0, "F_S": 4.0, "v_S": 2e-3}
# So far that the gate of preisach_lugre stays closed: what deflects is all of the motion.
REACH = {
    "everett_table": 1e-6,
    "reversal_table": 1e-6,
    "preisach_grid": 3e-6,
    "prandtl_ishlinskii": 2.5e-7,
}


def operator_named(name):
    component = hysteresis.OPERATORS[name]
    return component(**component.example)


def over(model, operator, **values):
    custom = SLIDING if model == "preisach_lugre" else {}
    return getattr(friction, model)(kernel=operator, **(custom | values))


def moved(model, steps, speed=1e-4):
    """The deflection and the force of the operator inside, after each step."""
    contact, states = Contact(model), []
    for step in steps:
        contact.move(step, speed)
        states.append(contact.state[:2])
    return np.array(states).T


def walk(reach, count=200):
    generator = np.random.default_rng(3)
    turns = reach * generator.uniform(-1.0, 1.0, 12)
    return np.diff(
        np.interp(np.linspace(0.0, 12.0, count), np.arange(13), np.concatenate([[0.0], turns]))
    )


def along(model, name):
    """The force of the operator inside along a walk, and that of the operator alone."""
    operator, steps = operator_named(name), walk(REACH[name])
    deflection, force = moved(over(model, operator), steps)
    np.testing.assert_allclose(deflection, np.cumsum(steps), rtol=1e-9, atol=1e-18)
    assert 2.0 < np.ptp(force) < 7.2
    return force, br.response(operator, deflection)


@pytest.mark.parametrize(
    ("model", "name"),
    [
        pytest.param(model, name, marks=() if (model, name) in QUICK else pytest.mark.slow)
        for model in MODELS
        for name in TABLES
    ],
)
def test_compiled_kernels_equal_the_operator_to_the_bit(model, name):
    force, alone = along(model, name)
    assert np.array_equal(force, alone)


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("model", MODELS)
def test_plain_kernels_equal_the_operator_to_the_bit(model, name):
    with interpreted():
        force, alone = along(model, name)
    assert np.array_equal(force, alone)


@pytest.mark.parametrize("name", TABLES)
def test_sliding_follows_the_operator_to_solver_accuracy(name):
    model = over("preisach_lugre", operator_named(name))
    with interpreted():
        deflection, force = moved(model, walk(8e-6, 200))
        alone = br.response(operator_named(name), deflection)
    assert np.max(np.abs(deflection)) < 7e-6  # part of the way is slip
    assert np.max(np.abs(force)) == pytest.approx(4.0, abs=0.1)  # F_S, where it is slow
    np.testing.assert_allclose(force, alone, atol=1e-6)


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("way", [5e-6, -8e-6])
def test_a_long_step_has_the_mean_force_of_many_short_ones(name, way):
    with interpreted():
        long, short = (
            Contact(over("preisach_contact", operator_named(name))),
            Contact(over("preisach_contact", operator_named(name))),
        )
        for contact in (long, short):
            contact.move(3e-6, 1e-4)
        assert long.move(way, 1e-4, 1)[0] == pytest.approx(
            np.mean(short.move(way, 1e-4, 400)), abs=0.1
        )


@pytest.mark.parametrize("model", MODELS)
def test_a_closed_form_is_the_kernel_of_that_name(model):
    operator = hysteresis.preisach(kernel="reformed_dahl_exact", s=1e7, f_p=33.0, capacity=64)
    spelled = {"kernel": "reformed_dahl_exact", "s": 1e7, "f_p": 33.0, "capacity": 64}
    custom = SLIDING if model == "preisach_lugre" else {}
    assert over(model, operator) == getattr(friction, model)(**spelled, **custom)


def test_a_model_over_an_operator_is_found_by_name_and_survives_pickling():
    operator = operator_named("reversal_table")
    model = friction.find("preisach_contact+asymmetry")(
        kernel=operator, sigma_2_pos=2.0, sigma_2_neg=3.0, offset=1.0
    )
    assert model.name == "preisach_contact+reversal_table+asymmetry"
    assert friction.find(model.name) is model.component
    assert (
        pickle.loads(pickle.dumps(model))
        == make_model(model.component, model.values, kind=model.kind, validate=True)
        == model
    )
    assert np.array_equal(model.kernel_E, operator.E)
    assert (model.sigma_2_neg, model.offset) == (3.0, 1.0)


def test_a_model_over_an_operator_takes_slots():
    component = friction.find("preisach_lugre+prandtl_ishlinskii+position+asymmetry")
    example = example_of(component)
    with interpreted():
        force = br.response(example, walk(5e-6).cumsum(), 1e-3)
    assert np.all(np.isfinite(force))
    assert np.ptp(force) > 4.0


def test_the_force_at_rest_is_that_of_the_virgin_operator():
    table = operator_named("preisach_grid").with_values(offset=0.5)
    with interpreted():
        assert Contact(over("preisach_contact", table)).force(0.0) == 0.5
        assert Contact(friction.find("preisach_contact+asymmetry")(kernel=table)).force(0.0) == 0.5


@pytest.mark.parametrize("name", MODELS)
def test_a_return_below_the_tolerance_of_the_operator_is_not_stored(name):
    smallest = 1e-3 * 2e-5
    with interpreted():
        contact = Contact(over(name, operator_named("preisach_grid").with_values(tolerance=1e-3)))
        contact.move(5e-7, 1e-4)
        before = contact.state
        contact.move(-0.9 * smallest, 1e-4)
        assert contact.state[1] == before[1]
        contact.move(-1.1 * smallest, 1e-4)
        assert contact.state[1] < before[1]


ON_CONTACT = friction.preisach_contact
TURNING = hysteresis.prandtl_ishlinskii(kind="rotational", thresholds=[1.0], weights=[1.0])
STOPS = operator_named("prandtl_ishlinskii")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: ON_CONTACT(kernel=hysteresis.relay_grid(**hysteresis.relay_grid.example)),
            "has a staircase output",
        ),
        (lambda: ON_CONTACT(kernel=hysteresis.play(r=1e-6)), "gives no force from a displacement"),
        (
            lambda: ON_CONTACT(kernel=hysteresis.inverse_of(STOPS)),
            "gives no force from a displacement",
        ),
        (
            lambda: ON_CONTACT(
                kernel=hysteresis.prandtl_ishlinskii(
                    kind="magnetic", thresholds=[1.0], weights=[1.0]
                )
            ),
            "is magnetic",
        ),
        (
            lambda: ON_CONTACT(kernel=hysteresis.preisach(s=1e7, f_p=30.0, tolerance=1e-3)),
            "has a tolerance",
        ),
        (lambda: ON_CONTACT(kernel=friction.coulomb(F_C=1.0)), "is not a hysteresis operator"),
        # Parameters of the operator are not given twice.
        (
            lambda: ON_CONTACT(kernel=hysteresis.preisach(s=1e7, f_p=30.0), s=1e7),
            "s: is already set by the operator",
        ),
        (
            lambda: ON_CONTACT(kernel=operator_named("reversal_table"), s=1e7),
            "has no such parameter",
        ),
        (
            lambda: ON_CONTACT(kernel=TURNING, kind="translational"),
            "is a rotational operator, but this friction is translational",
        ),
        # The saturation of an operator exceeds break-away.
        (
            lambda: over("preisach_lugre", operator_named("reversal_table"), F_S=8.1),
            "saturation of the operator > F_S",
        ),
        (
            lambda: over("preisach_lugre", STOPS.with_values(spring=0.0), F_S=17.1),
            "saturation of the operator > F_S",
        ),
        # A model without a kernel takes no operator, and none takes two.
        (lambda: friction.find("lugre")(kernel=STOPS), None),
        (lambda: friction.find("coulomb+asymmetry")(kernel=STOPS), None),
        (lambda: friction.find("lugre+reversal_table"), "has too many operators"),
        (
            lambda: friction.find("preisach_contact+reversal_table+preisach_grid"),
            "has too many operators",
        ),
    ],
)
def test_operators_that_are_no_kernels_are_refused_by_name(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_a_turning_operator_turns_and_a_spring_has_no_saturation():
    assert ON_CONTACT(kernel=TURNING).kind == "rotational"
    assert over("preisach_lugre", STOPS, F_S=50.0).F_S == 50.0


STRAINED = sliders.Sliders(
    STOPS.parameters.thresholds,
    STOPS.parameters.weights,
    STOPS.parameters.spring,
    np.array([0.0, 4e-7, -3e-6]),
)


@pytest.mark.parametrize("u", [1e-8, 9e-7, 1.1e-6, 1.9e-6, 2.6e-6, -1.2e-6, -4e-6, 6e-6])
def test_the_stiffness_of_stops_is_that_of_their_output_onward(u):
    steep = (
        sliders.onward_output(u + 1e-9, STRAINED) - sliders.onward_output(u - 1e-9, STRAINED)
    ) / 2e-9
    assert sliders.onward_slope(u, STRAINED) == pytest.approx(steep, rel=1e-6)


@pytest.mark.parametrize("d", [1e-7, 1.9e-6, 2.1e-6, 5e-6, 1.2e-5])
def test_stops_follow_masings_rule_from_one_end(d):
    steep = (sliders.value(d + 1e-9, 0.0, STRAINED) - sliders.value(d - 1e-9, 0.0, STRAINED)) / 2e-9
    assert sliders.slope(d, 0.0, 1.0, STRAINED) == pytest.approx(steep, rel=1e-6)
    with interpreted():
        ends = br.response(STOPS, [2e-5, 2e-5 - d])
    assert 2.0 * sliders.value(d, 0.0, STRAINED) == pytest.approx(ends[0] - ends[1])


def test_the_length_over_which_an_operator_turns_is_that_of_half_a_stroke():
    # One stop goes from one end to the other over twice its threshold, at an even rate; without a force it is the shortest length.
    stiff, limp = (
        over(
            "preisach_contact", hysteresis.prandtl_ishlinskii(thresholds=[4e-6], weights=[weight])
        ).parameters.lengths.turn
        for weight in (1e6, 0.0)
    )
    assert stiff == pytest.approx(2e-6)
    assert 0.0 < limp < 1e-4 * stiff


def test_the_model_to_try_next_keeps_its_operator():
    contact = friction.find("preisach_contact+asymmetry")(kernel=operator_named("reversal_table"))
    assert model_with("position", contact) == "preisach_contact+reversal_table+position+asymmetry"

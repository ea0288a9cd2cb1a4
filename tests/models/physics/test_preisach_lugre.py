"""The composite: sliding, bound of the deflection, memory in the position, and what its constructor refuses."""

import numpy as np
import pytest
from tests.simulation.certificates.ballscrew import F_S, SLIDING, STIFFNESS, UM, composite, lugre

from bristle import friction, response
from bristle.core import InputError, InputWarning
from bristle.engine import force_along, interpreted
from bristle.engine.contact import Contact
from bristle.models.friction.preisach_lugre import KERNELS, TRANSITIONS

VARIANTS = [(kernel, transition) for kernel in KERNELS for transition in TRANSITIONS]


@pytest.mark.parametrize(("kernel", "transition"), VARIANTS)
@pytest.mark.parametrize("v", [1e-3, 0.3, -0.5, 40.0, -40.0])
def test_steady_sliding_is_that_of_lugre_in_both_directions(kernel, transition, v):
    contact, reference = (
        Contact(composite(transition, kernel=kernel, sigma_1=0.01)),
        Contact(lugre(sigma_1=0.01)),
    )
    for item in (contact, reference):
        item.move(np.copysign(5.0, v), abs(v), 2000)
    assert contact.force(v) == pytest.approx(reference.force(v), rel=1e-11)


@pytest.mark.parametrize(
    ("kernel", "bound"), [("dahl_masing", 6.207), ("reformed_dahl_exact", 11.380)]
)
@pytest.mark.parametrize("transition", TRANSITIONS)
def test_the_deflection_stays_within_its_bound(kernel, bound, transition):
    model = composite(transition, kernel=kernel)
    slow = Contact(model)
    slow.move(10_000.0 * UM, 1.0 * UM, 4000)
    assert abs(slow.state[0]) / UM == pytest.approx(bound, abs=2e-3)
    generator = np.random.default_rng(8)
    contact, farthest = Contact(model), 0.0
    for _ in range(400):
        speed = 10 ** generator.uniform(-4, 1)
        contact.move(generator.normal() * 10 * UM, speed, 20)
        farthest = max(farthest, abs(contact.state[0]))
        assert abs(contact.state[1]) <= F_S * (1.0 + 1e-12)
    assert farthest / UM <= bound + 1e-3


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: composite(f_p=F_S), r"f_p > F_S.*Raise f_p"),
        (lambda: composite("dahl"), r"transition.*allowed paper, leuven, elastoplastic"),
    ],
)
def test_impossible_parameters_are_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()


def test_poor_parameters_are_warned_of():
    with pytest.warns(InputWarning, match=r"f_p >= 1.05 \* F_S"):
        composite(f_p=1.02 * F_S)
    composite(f_p=1.06 * F_S)
    composite(f_p=0.5 * F_S, validate=False)


def test_units_may_be_text_and_names_may_be_written_by_hand():
    model = friction.preisach_lugre(
        kernel="dahl_masing",
        s="100 N*m/rad",
        f_p="156 mN*m",
        F_C="100 mN*m",
        F_S="130 mN*m",
        v_S="0.3 rad/s",
        sigma_1="0.1 N*m*s/rad",
        sigma_2="2 mN*m*s/rad",
        transition="paper",
    )
    assert (model.kind, model.values["transition"]) == ("rotational", "paper")
    assert model.parameters == composite("paper").parameters


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_return_within_rounding_is_no_turn_but_creep_in_such_steps_accumulates(side):
    # Of the length f_p/s = 1.56e-3 rad a step of 1e-16 rad is less than 1e-13.
    contact = Contact(composite())
    contact.move(side * 1e-3, 1e-3, 10)
    z, _, _, depth, _ = contact.state
    contact.move(-side * 1e-16, 1e-3)
    assert contact.state[3] == depth
    contact.move(side * 1e-12, 1e-3, 10_000)
    assert contact.state[0] - z == pytest.approx(side * 1e-12, rel=1e-2, abs=0.0)
    contact.move(-side * 1e-13, 1e-3)
    assert contact.state[3] == depth + 1


def test_the_leuven_model_is_the_composite_with_its_transition():
    values = SLIDING | {"s": STIFFNESS, "f_p": 1.2 * F_S, "sigma_1": 0.01, "n": 4.0}
    v = np.random.default_rng(9).normal(size=500)
    expected = force_along(friction.preisach_lugre(**values, transition="leuven"), v, 1e-4)
    np.testing.assert_array_equal(force_along(friction.leuven(**values), v, 1e-4), expected)


def test_directions_differ_in_sliding_and_the_force_stays_continuous():
    model = friction.find("preisach_lugre+asymmetry")(
        s=1e5, f_p=2.0, F_C_pos=1.2, F_C_neg=0.8, F_S_pos=1.4, F_S_neg=0.9, v_S=1e-3, offset=0.1
    )
    x = 600e-6 * np.sin(np.linspace(0.0, 4.0 * np.pi, 3000))
    with interpreted():
        force = response(model, x, 0.4 / 3)  # as slow as the level needs
    assert np.max(np.abs(np.diff(force[2:]))) <= 1.001 * 1e5 * np.max(np.abs(np.diff(x)))
    assert force.max() == pytest.approx(1.5, abs=1e-3)
    assert force.min() == pytest.approx(-0.8, abs=1e-3)


def test_a_full_memory_is_reported():
    model = friction.leuven(**SLIDING, s=STIFFNESS, f_p=1.2 * F_S, n=8.0, capacity=4)
    turns = 6.0 * UM * (-0.8) ** np.arange(20)
    path = np.concatenate([[0.0], turns])
    with pytest.warns(InputWarning, match="lost its innermost pair"):
        response(model, path, 1.0)

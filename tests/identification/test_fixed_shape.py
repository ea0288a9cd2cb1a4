"""Elements of fixed shape: one stiffness for all, levels, and reflections of a fit."""

import numpy as np
import pytest

from bristle.core.contracts import make_model
from bristle.friction import maxwell_slip
from bristle.identification.fixed_shape import DIFFERENCE, ElementSpace, in_lists, shaped

STIFFNESS, LEVELS = np.array([3e5, 1e5]), np.array([6.0, 4.0])
COMPONENT = shaped(maxwell_slip, STIFFNESS, LEVELS)
THRESHOLDS = np.array([1e-5, 4e-5])


def test_one_stiffness_replaces_those_of_all_elements():
    lists = {"F_C": 20.0, "k_i": pytest.approx([6e5, 2e5]), "nu_i": pytest.approx([0.6, 0.4])}
    assert COMPONENT.lists({"F_C": 20.0, "s": 8e5, "sigma_2": 0.0}) == lists | {"sigma_2": 0.0}
    assert COMPONENT.finished({"F_C": 20.0, "s": 8e5, "other": 1.0}) == lists | {"other": 1.0}
    assert (COMPONENT.further, shaped(maxwell_slip, np.ones(5), np.ones(5)).further) == (0, 3)


def test_kernel_parameters_convert_back_to_the_stiffness():
    model = make_model(COMPONENT, {"F_C": 20.0, "s": 8e5}, kind=None, validate=True)
    assert (model.values["s"], model.values["F_C"]) == (pytest.approx(8e5), 20.0)
    assert not COMPONENT.is_array("s")
    assert not COMPONENT.is_integer("s")
    lists = in_lists(model)
    assert lists.component is maxwell_slip
    assert lists.values["k_i"] == pytest.approx([6e5, 2e5])


@pytest.mark.parametrize(
    ("distance", "level", "share"), [(1.9e-5, 10.0, 0.0), (2.1e-5, 10.0, 0.75), (4.1e-5, 10.0, 1.0), (2.1e-5, 20.0, 0.0)]
)
def test_elements_that_slip_within_a_distance_have_their_share_of_the_stiffness(distance, level, share):
    # At a level of 10 N and a stiffness of 4e5 N/m the elements slip at 6 N / 3e5 N/m and at 4 N / 1e5 N/m.
    assert COMPONENT.share_within(distance, 4e5, level) == pytest.approx(share)


def space_of(*levels, single=None):
    names = {"M": 0.0, "offset": -np.inf} if single is None else single
    return ElementSpace.around(THRESHOLDS, names, dict(levels), ["M", "offset", *dict(levels)])


def test_a_level_is_the_force_at_which_all_elements_slip():
    space, lists = space_of(("F_C", 0.0)), {"k_i": pytest.approx([2e5, 1e5]), "nu_i": pytest.approx([2.0 / 6.0, 4.0 / 6.0])}
    theta = np.array([2e5, 1e5, 12.0, -1.5])
    assert space.values(theta) == {"F_C": pytest.approx(2e5 * 1e-5 + 1e5 * 4e-5), "M": 12.0, "offset": -1.5} | lists
    assert space.reported == ("F_C", "s", "M", "offset")
    assert space.derivative(theta) @ theta == pytest.approx([6.0, 3e5, 12.0, -1.5])


def test_two_levels_differ_by_twice_their_difference():
    space = space_of(("F_C_pos", 1.0), ("F_C_neg", -1.0), single={"M": 0.0, "offset": -np.inf, DIFFERENCE: -np.inf})
    theta = np.array([2e5, 1e5, 12.0, -1.5, 0.5])
    values = space.values(theta)
    assert (values["F_C_pos"], values["F_C_neg"]) == (pytest.approx(6.5), pytest.approx(5.5))
    assert DIFFERENCE not in values
    assert space.derivative(theta) @ theta == pytest.approx([6.5, 5.5, 3e5, 12.0, -1.5])


def test_an_element_without_force_keeps_its_threshold():
    values = space_of(("F_C", 0.0)).values(np.array([2e5, 0.0, 1.0, 0.0]))
    k, level = values["k_i"], values["F_C"]
    assert k[1] > 0.0
    assert values["nu_i"] * level / k == pytest.approx(THRESHOLDS)


def test_the_virgin_curve_bends_at_the_thresholds():
    space = space_of(("F_C", 0.0))
    curve = space.numbers(np.array([2e5, 1e5, 12.0, -1.5]))[4:]
    assert len(space.curve) == 12
    assert (space.curve[0], space.curve[-1]) == (pytest.approx(1e-5), pytest.approx(4e-5))
    assert curve[0] == pytest.approx(3e5 * 1e-5)
    assert curve[-1] == pytest.approx(6.0)
    assert np.diff(curve) / np.diff(space.curve) == pytest.approx(1e5)


def test_the_reflection_of_a_fit_is_at_the_same_distance():
    space = space_of(("F_C", 0.0))
    best, theta = np.array([2e5, 1e5, 12.0, -1.5]), np.array([2.2e5, 1.1e5, 13.0, -1.0])
    bent = np.array([2.6e5, 0.9e5, 13.0, -1.0])
    assert space.turned(bent, best).values["nu_i"] == pytest.approx(space.values(bent)["nu_i"])  # the shape is that of the fit
    turned = space.turned(theta, best)
    assert turned.numbers[:4] == pytest.approx(2.0 * space.numbers(best)[:4] - space.numbers(theta)[:4])
    assert (turned.values["F_C"], np.sum(turned.values["k_i"])) == (pytest.approx(5.4), pytest.approx(2.7e5))
    assert "s" not in turned.values
    far = space.turned(np.array([9e5, 9e5, 40.0, 0.0]), best)
    assert far.values["F_C"] == pytest.approx(0.05 * 6.0)
    assert np.sum(far.values["k_i"]) == pytest.approx(0.05 * 3e5)
    assert far.values["M"] == 0.0  # no mass is below nothing

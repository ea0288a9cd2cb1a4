"""A search: derivatives that the steps of a simulation do not disturb."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.core.variable import Variable
from bristle.friction import find
from bristle.identification.estimation import context_of
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import FAR, OF_SLOTS, Linearised, Search, Sliding
from bristle.identification.parameter_space import Ceiling, Transform
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat

STEP = 1e-8  # N


class Stepped(InverseDynamics):
    """What is left over jumps, as where the stops of a body move from one step of an integration to the next."""

    def residual(self, free):
        return STEP * np.round(super().residual(free) / STEP)

    def linearised(self, free):
        return self.residual(free), None


def test_small_jumps_of_a_simulation_do_not_disturb_a_derivative():
    dataset = treat(log_of(sines(2.0), sliding_effort(sines(2.0))), Axis())
    context, parameters = (context_of(dataset, PriorKnowledge()), parameters_of(find("coulomb_viscous"), PriorKnowledge(), dataset))
    exact, stepped = (context.search(problem(dataset, parameters), 1.0, simulates=True) for problem in (InverseDynamics, Stepped))
    theta = exact.space.theta(TRUTH)
    result, wanted = (item.descend(theta, limit=1).jacobian for item in (stepped, exact))
    np.testing.assert_allclose(result, wanted, atol=2e-3 * np.max(np.abs(wanted)))
    # As finely as a computed residual allows, the jumps would be a good part of it.
    fine = replace(stepped, simulates=False).descend(theta, limit=1).jacobian
    assert np.max(np.abs(fine - wanted)) > 0.02 * np.max(np.abs(wanted))


SLIDING = Sliding({"M": 12.0, "sigma_0": 100.0}, 8.0, 30.0)


def drawn(name, form="", low=0.0, high=1.0, quantity="1", excitation="stribeck"):
    """Two thousand values that a search would begin with, of a typical magnitude of 4."""
    parameters = SimpleNamespace(component=SimpleNamespace(defaults={"asymmetry": 0.25}))
    search = Search(SimpleNamespace(parameters=parameters), SimpleNamespace(magnitude=lambda variable: 4.0), SLIDING, 1.0)
    transform, variable = SimpleNamespace(name=name, form=form, low=low, high=high), Variable(quantity, "number", excitation=excitation)
    rng = np.random.default_rng(1)
    return np.array([search._draw(transform, variable, rng) for _ in range(2000)])


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ({"name": "M", "quantity": "mass"}, 12.0),  # as the linear fit has it
        ({"name": "F_C", "quantity": "force"}, 8.0),
        ({"name": "F_v", "quantity": "force*time/length", "excitation": "speed"}, 30.0),
        ({"name": "asymmetry", "excitation": next(iter(OF_SLOTS))}, 0.25),
    ],
)
def test_a_search_starts_from_the_sliding_fit(variable, value):
    assert np.all(drawn(**variable) == value)


@pytest.mark.parametrize(
    ("variable", "low", "high", "mean"),
    [
        ({"name": "sigma_0", "quantity": "force/length"}, 20.0, 100.0, 60.0),  # stiffness shared with what is in front of it
        ({"name": "x", "form": "log", "low": np.log(2.0), "high": np.log(8.0)}, 2.0, 8.0, 6.0 / np.log(4.0)),
        ({"name": "x"}, 0.04, 40.0, 4.0 * (10.0 - 0.01) / (3.0 * np.log(10.0))),  # from a hundredth of its magnitude to ten times
    ],
)
def test_a_parameter_outside_sliding_is_drawn_from_its_range(variable, low, high, mean):
    values = drawn(**variable)
    assert low <= values.min() < low * 1.1
    assert high / 1.1 < values.max() <= high
    assert np.mean(values) == pytest.approx(mean, rel=0.06)


def test_an_excess_is_drawn_around_three_tenths_of_the_level():
    values = drawn("F_S", "excess", quantity="force")
    assert values.min() > 0.0
    assert np.mean(values) == pytest.approx(0.3 * 8.0, rel=0.06)
    assert np.std(values) == pytest.approx(0.3 * 8.0, rel=0.1)  # as of an exponential distribution


def test_a_cost_is_converted_to_a_share_of_the_signal():
    search = Search(SimpleNamespace(measured=np.array([3.0, 4.0])), None, SLIDING, 2.0)
    residual = np.array([0.3, 0.4])  # in units of 2
    assert search.percent(0.5 * float(residual @ residual)) == pytest.approx(20.0)
    assert Search(SimpleNamespace(measured=np.zeros(2)), None, SLIDING, 2.0).percent(0.0) == 0.0


def test_a_start_is_computed_in_order_and_inside_its_range():
    variables = {name: Variable("force", name, excitation="sliding") for name in ("F_C", "F_S")} | {"share": Variable("length", "share")}
    parameters = SimpleNamespace(component=SimpleNamespace(defaults={}), variables=variables, complete=lambda values: {"a": 2.0})
    transforms = (
        Transform("F_C", "plain", 4.0, 0.0, 9.0, 0.0, np.inf),
        Transform("F_S", "excess", 4.0, 0.0, 9.0, 0.0, np.inf, above=("F_C",)),
        Transform("share", "below", 1.0, 0.2, 0.6, 0.0, np.inf, ceiling=Ceiling("a", ("F_C",))),
    )
    search = Search(SimpleNamespace(parameters=parameters), None, SLIDING, 1.0)
    object.__setattr__(search, "space", SimpleNamespace(transforms=transforms, theta=dict))
    starts = [search._start(np.random.default_rng(seed)) for seed in range(500)]
    assert {start["F_C"] for start in starts} == {8.0}
    assert np.mean([start["F_S"] - 8.0 for start in starts]) == pytest.approx(0.3 * 8.0, rel=0.15)
    shares = [start["share"] / 4.0 for start in starts]  # of the level over a factor of 2
    assert (min(shares), max(shares)) == pytest.approx((0.2, 0.6), abs=0.01)


@pytest.mark.parametrize(("left", "slope"), [(3.0, 1e60), (3.0, np.inf), (3.0, np.nan), (2.0 * FAR, 5.0)])
def test_a_row_that_diverges_shows_no_direction(left, slope):
    """An observer that diverges has rows whose derivative, or whose residual, is beyond any use."""
    space = SimpleNamespace(names=("a", "b"), values=dict, derivative=lambda x: np.eye(2))
    rows = np.array([1.0, left, -2.0]), np.array([[4.0, 5.0], [1.0, slope], [6.0, 7.0]])
    problem = SimpleNamespace(parameters=SimpleNamespace(free=["a", "b"]), linearised=lambda values: rows)
    search = SimpleNamespace(problem=problem, space=space, unit=1.0, finite=lambda residual: np.clip(residual, -FAR, FAR))
    jacobian = Linearised(search, slice(None)).jacobian(np.zeros((0, 2)))
    np.testing.assert_array_equal(jacobian, [[-4.0, -5.0], [0.0, 0.0], [-6.0, -7.0]])

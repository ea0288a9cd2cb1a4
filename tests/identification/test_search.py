"""A search: coordinates, starts, derivatives, refits, and models that contain another one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, slow_log
from tests.identification.own_models import own_model
from tests.identification.rigid import identify

from bristle.core import Axis, Relation, Variable
from bristle.engine import force_along
from bristle.identification import estimation as estimating
from bristle.identification.estimation import along_the_motion, context_of, richer
from bristle.identification.inverse_dynamics import InverseDynamics
from bristle.identification.least_squares import FAR, OF_SLOTS, Linearised, Search, Sliding, silent
from bristle.identification.parameter_space import (
    Ceiling,
    ParameterSpace,
    Solution,
    Transform,
    TransformedSpace,
)
from bristle.identification.parameters import PriorKnowledge, parameters_of
from bristle.identification.preprocessing import treat
from bristle.identification.refit import Refit
from bristle.models.friction import find, slotted
from bristle.models.friction.next_model import nested_in

STEP = 1e-8  # N
DATASET = treat(log_of(sines(2.0), sliding_effort(sines(2.0))), Axis())


class Stepped(InverseDynamics):
    """What is left over jumps, as where the stops of a body move from one step of an integration to the next."""

    def residual(self, free):
        return STEP * np.round(super().residual(free) / STEP)

    def linearised(self, free):
        return self.residual(free), None


def test_small_jumps_of_a_simulation_do_not_disturb_a_derivative():
    context, parameters = (
        context_of(DATASET, PriorKnowledge()),
        parameters_of(find("coulomb_viscous"), PriorKnowledge(), DATASET),
    )
    exact, stepped = (
        context.search(problem(DATASET, parameters), 1.0, simulates=True)
        for problem in (InverseDynamics, Stepped)
    )
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
    search = Search(
        SimpleNamespace(parameters=parameters),
        SimpleNamespace(magnitude=lambda variable: 4.0),
        SLIDING,
        1.0,
    )
    transform, variable = (
        SimpleNamespace(name=name, form=form, low=low, high=high),
        Variable(quantity, "number", excitation=excitation),
    )
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
        # Stiffness shared with what is in front of it.
        ({"name": "sigma_0", "quantity": "force/length"}, 20.0, 100.0, 60.0),
        (
            {"name": "x", "form": "log", "low": np.log(2.0), "high": np.log(8.0)},
            2.0,
            8.0,
            6.0 / np.log(4.0),
        ),
        # From a hundredth of its magnitude to ten times.
        ({"name": "x"}, 0.04, 40.0, 4.0 * (10.0 - 0.01) / (3.0 * np.log(10.0))),
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
    variables = {name: Variable("force", name, excitation="sliding") for name in ("F_C", "F_S")} | {
        "share": Variable("length", "share")
    }
    parameters = SimpleNamespace(
        component=SimpleNamespace(defaults={}),
        variables=variables,
        complete=lambda values: {"a": 2.0},
    )
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


@pytest.mark.parametrize(
    ("left", "slope"), [(3.0, 1e60), (3.0, np.inf), (3.0, np.nan), (2.0 * FAR, 5.0)]
)
def test_a_row_that_diverges_shows_no_direction(left, slope):
    """An observer that diverges has rows whose derivative, or whose residual, is beyond any use."""
    space = SimpleNamespace(names=("a", "b"), values=dict, derivative=lambda x: np.eye(2))
    rows = np.array([1.0, left, -2.0]), np.array([[4.0, 5.0], [1.0, slope], [6.0, 7.0]])
    problem = SimpleNamespace(
        parameters=SimpleNamespace(free=["a", "b"]), linearised=lambda values: rows
    )
    search = SimpleNamespace(
        problem=problem, space=space, unit=1.0, finite=lambda residual: np.clip(residual, -FAR, FAR)
    )
    jacobian = Linearised(search, slice(None)).jacobian(np.zeros((0, 2)))
    np.testing.assert_array_equal(jacobian, [[-4.0, -5.0], [0.0, 0.0], [-6.0, -7.0]])


CASES = {
    "as it is": ("elastoplastic", False, {}),
    "the factor is known": ("elastoplastic", False, {"sigma_0": 1e6}),
    "what it must stay below is known": ("elastoplastic", False, {"F_C": 12.0}),
    "each direction has its own": ("elastoplastic", True, {}),
    "excess over another": ("lugre", False, {}),
    "excess over both directions": ("preisach_lugre", True, {}),
}


def space_of(case):
    name, by_direction, fixed = CASES[case]
    model = find(name)
    model = slotted(model, asymmetry=True) if by_direction else model
    return space_for(model, fixed)


def space_for(model, fixed=None):
    parameters = parameters_of(model, PriorKnowledge(values=fixed or {}), DATASET)
    return TransformedSpace.within(parameters, context_of(DATASET, PriorKnowledge()).scales)


def anywhere(space, rng):
    """Return coordinates within their bounds; where there is none, up to 3 typical magnitudes."""
    return rng.uniform(
        np.maximum(space.low, -3.0), np.where(np.isfinite(space.high), space.high, 3.0)
    )


@pytest.mark.parametrize("case", CASES)
def test_relations_are_satisfied_everywhere_in_a_search(case):
    space, rng = space_of(case), np.random.default_rng(3)
    for _ in range(200):
        values = space.parameters.complete(space.values(anywhere(space, rng)))
        coulomb, static = (
            [value for name, value in values.items() if name.startswith(of)]
            for of in ("F_C", "F_S")
        )
        assert all(above >= below for above, below in zip(static, coulomb, strict=True))
        assert values.get("f_p", np.inf) > max(static)
        if "z_ba" in values:
            assert 0.0 <= values["sigma_0"] * values["z_ba"] < min(coulomb)


@pytest.mark.parametrize("case", CASES)
def test_coordinates_convert_both_ways_and_have_a_derivative_that_is_the_limit_of_differences(case):
    space, rng = space_of(case), np.random.default_rng(5)
    for _ in range(20):
        theta = anywhere(space, rng)
        values = space.parameters.complete(space.values(theta))
        np.testing.assert_allclose(space.theta(values), theta, rtol=1e-9, atol=1e-9)
        steps = 1e-6 * np.eye(theta.size)
        differences = np.stack(
            [space.numbers(theta + step) - space.numbers(theta - step) for step in steps], axis=1
        )
        size = np.abs(space.numbers(theta))[:, None] + 1e-12
        np.testing.assert_allclose(
            space.derivative(theta) / size, 0.5e6 * differences / size, rtol=1e-5, atol=1e-6
        )


def test_a_reflection_has_the_same_distance_within_the_bounds():
    space, rng = space_of("excess over another"), np.random.default_rng(6)
    best, names = 0.5 * (anywhere(space, rng) + anywhere(space, rng)), space.names
    near = best + 0.01 * rng.standard_normal(best.size)
    present, middle, here = (
        dict(zip(names, item, strict=True))
        for item in (space.turned(near, best).numbers, space.numbers(best), space.numbers(near))
    )
    for name in set(names) - {"F_S"}:
        side = (
            middle[name] ** 2 / here[name]
            if name in space.logarithmic
            else 2.0 * middle[name] - here[name]
        )
        assert present[name] == pytest.approx(side)
    # Farther than the excess reaches down, F_S is F_C.
    excess = list(names).index("F_S")
    far = space.turned(np.where(np.arange(best.size) == excess, 3.0 * best, best), best)
    assert far.values["F_S"] == far.values["F_C"]
    assert far.numbers.tolist() == list(far.values.values())


def trial(state, memory, motion, dt, p):
    return p.F_C * np.sign(motion.v), state


def related(relations, **ranges):
    """A user's model with these relations between its parameters, and their smallest values."""
    least = {"a": 1e-3, "b": 0.0, "F_C": 1e-3, "F_S": 0.0} | ranges
    quantities = {"a": "force/length", "b": "length", "F_C": "force", "F_S": "force"}
    variables = {
        name: Variable(quantity, name, min=least[name], excitation="sliding")
        for name, quantity in quantities.items()
    }
    return own_model(
        trial,
        variables,
        relations=tuple(Relation(relation, lambda p: True, "Lower b") for relation in relations),
    )


@pytest.mark.parametrize(
    ("relations", "ranges"),
    [
        (["a * b < F_C"], {"b": -np.inf}),  # b may be negative: a share would never be
        (["a * b < F_C"], {"a": 0.0}),  # with a of zero there is no largest b
        (["a * b < F_C"], {"F_C": 0.0}),  # nothing is below zero
        (["2 * b < a"], {}),  # a number is no parameter
        (["F_S >= F_C", "a * F_C < F_S"], {"F_S": 1e-3}),  # F_S hangs on F_C already
        (["F_S >= F_C", "a * F_S < F_C"], {}),  # F_S has a floor
    ],
)
def test_a_relation_without_share_is_left_to_the_validation_of_the_model(relations, ranges):
    space = space_for(related(relations, **ranges))
    assert not any(transform.ceiling for transform in space.transforms)
    theta = space.theta(dict.fromkeys(space.names, 1.0))
    assert np.all(np.isfinite(space.numbers(theta)))


def test_a_share_of_a_share_is_computed_after_it():
    space = space_for(related(["a * b < F_C", "b * a < F_S"], b=1e-3, F_S=1e-3))
    (ceiling,) = [transform.name for transform in space.transforms if transform.ceiling]
    assert ceiling == "b"  # a in turn would hang on itself
    assert space.names.index("b") > max(space.names.index(name) for name in ("a", "F_C"))


def test_of_two_mutual_relations_the_first_makes_an_excess():
    space = space_for(related(["F_S >= F_C", "F_C >= F_S"]))
    assert [
        (transform.name, transform.above) for transform in space.transforms if transform.above
    ] == [("F_S", ("F_C",))]


ANYWHERE = ParameterSpace(("x",), np.array([-np.inf]), np.array([np.inf]), linear=False)


class Steep:
    """One row, x + x^3 in some unit of force: far from its zero it is much steeper than there."""

    def __init__(self, unit=1.0):
        self.unit = unit

    def residual(self, free):
        return self.unit * np.array([-(free["x"] + free["x"] ** 3)])


@pytest.mark.parametrize("start", [-12.0, -1.8, 1.2, 2.0, 5.0])
def test_a_step_that_leads_uphill_is_shortened(start):
    solution = Solution(ANYWHERE, np.zeros(1), np.ones((1, 1)))
    x, residual = Refit(solution).solve(Steep(), np.array([start]))
    # The slope at the solution is 1: the whole first step ends beyond the other side of it, further up than the start.
    overshot = start - (start + start**3)
    assert abs(overshot + overshot**3) > abs(start + start**3)
    assert abs(x[0]) < 0.5 * abs(start)
    assert residual[0] == pytest.approx(-(x[0] + x[0] ** 3))


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_solution_does_not_depend_on_units(unit):
    plain, other = (
        Refit(Solution(ANYWHERE, np.zeros(1), np.full((1, 1), size))).solve(
            Steep(size), np.array([0.6])
        )[0]
        for size in (1.0, unit)
    )
    assert other == pytest.approx(plain, rel=1e-9)
    # Not after the first step, which leaves more than a third.
    assert abs(plain[0]) < 0.05


def step_of(low, high, residual, theta=(1.0, 1.0)):
    """The step of two coordinates whose columns are 1 and 2 long, at a right angle."""
    space = ParameterSpace(("x", "y"), np.array(low), np.array(high))
    solution = Solution(space, np.zeros(2), np.array([[1.0, 0.0], [0.0, 2.0], [0.0, 0.0]]))
    return Refit(solution).step(np.array(theta), np.array(residual)).tolist()


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        ((-np.inf, -np.inf), (np.inf, np.inf), (-3.0, 2.0)),
        ((0.0, -np.inf), (np.inf, np.inf), (-1.0, 2.0)),
        ((0.0, 0.0), (np.inf, np.inf), (-1.0, 2.0)),
        ((-np.inf, -np.inf), (np.inf, 2.5), (-3.0, 1.5)),
        ((0.0, 0.0), (9.0, 1.5), (-1.0, 0.5)),
        ((1.0, 0.0), (9.0, 1.0), (0.0, 0.0)),
    ],
)
def test_a_step_ends_at_the_bounds(low, high, expected):
    assert step_of(low, high, (-3.0, 4.0, 5.0)) == pytest.approx(expected, abs=1e-9)


def test_a_linear_signal_is_solved_by_one_step_on_the_fitted_rows():
    space = ParameterSpace(("x", "y"), np.full(2, -np.inf), np.full(2, np.inf))
    jacobian = np.array([[1.0, 0.0], [0.0, 2.0], [1.0, 1.0]])
    solution, signal = Solution(space, np.zeros(2), jacobian), np.array([3.0, 8.0, 7.0])

    class Plane:
        def residual(self, free):
            return signal - jacobian @ [free["x"], free["y"]]

    theta, residual = Refit(solution).solve(Plane(), np.array([9.0, -5.0]))
    assert theta.tolist() == pytest.approx([3.0, 4.0])
    assert residual == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    signal[1] = 80.0
    theta, residual = Refit(solution, rows=np.array([True, False, True])).solve(
        Plane(), np.array([0.0, 2.0])
    )
    assert theta.tolist() == pytest.approx([3.0, 4.0])
    assert residual == pytest.approx([0.0, 72.0, 0.0], abs=1e-12)


PITCH = 5e-3
SHAPE = {"v_S": 2e-3, "sigma_0": 3e5, "sigma_1": 600.0}
LUGRE = {"F_C": 6.0, "F_S": 9.0, "sigma_2": 30.0, **SHAPE}


def context(duration=4.0, **changes):
    motion = sines(duration)
    force = force_along(find("lugre")(offset=1.0, **(LUGRE | changes)), motion.velocity, dt=1e-3)
    log = log_of(motion, force + 12.0 * motion.acceleration)
    return context_of(treat(log, Axis(cutoff=100.0)), PriorKnowledge(pitch=PITCH))


@pytest.mark.parametrize(
    ("name", "nested"),
    [
        ("lugre", set()),
        ("lugre+ripple", {"lugre"}),
        ("dahl+position+asymmetry", {"dahl+asymmetry", "dahl+position"}),
        ("preisach_lugre+everett_table+position", {"preisach_lugre+everett_table"}),
        ("stribeck_free+ripple", {"stribeck_free", "stribeck+ripple"}),
    ],
)
def test_nested_models_have_one_slot_less(name, nested):
    assert {model.name for model in nested_in(find(name))} == nested


def test_a_model_without_slots_has_no_nested_model():
    inner = find("lugre").inner
    assert nested_in(inner) == nested_in(replace(slotted(inner, asymmetry=True), name="own")) == ()


SLOTS = ("ripple", "periodic", "position", "transmitted", "asymmetry")


@pytest.mark.parametrize(
    ("base", "rich"),
    [
        ("stribeck", "stribeck_free"),
        *((base, f"{base}+{slot}") for base in ("stribeck", "lugre") for slot in SLOTS),
    ],
)
def test_a_richer_model_starts_equal_to_the_nested_model(base, rich):
    shared = context(2.0)
    nested, component = shared.problem(find(base)), shared.problem(find(rich))
    optimum = nested.parameters.complete(
        {**LUGRE, "M": 12.0, "F_v": 30.0, "offset": 0.0 if base == "lugre" else 1.5}
    )
    optimum = {
        name: value for name, value in optimum.items() if name in nested.parameters.variables
    }
    start = richer(component.parameters, find(base), optimum)
    np.testing.assert_allclose(component.predicted(start), nested.predicted(optimum), atol=1e-9)


@pytest.mark.parametrize("of_a_long_log", [False, True])
def test_a_search_also_starts_from_the_nested_optimum(monkeypatch, of_a_long_log):
    """All starts that are drawn lie in a corner from which a descent of few steps does not come away."""
    shared = context()
    best = along_the_motion(shared, find("lugre"), silent)
    monkeypatch.setattr(Search, "_start", lambda self, rng: self.space.high.clip(-5.0, 5.0))
    descend = Search.descend

    def short(self, theta, rows=slice(None), limit=0, best=None, tolerance=0.0, *, again=True):
        return descend(self, theta, rows, 2, best, tolerance, again=again)

    monkeypatch.setattr(Search, "descend", short)
    if of_a_long_log:
        problem = shared.problem(find("lugre+ripple"))
        search = shared.search(problem)
        begun = replace(
            best.solution, space=search.space, theta=search.space.high.clip(-5.0, 5.0), cost=0.0
        )
        monkeypatch.setattr(type(problem), "excerpt", lambda self: problem)
        monkeypatch.setattr(
            Search, "_from_several", lambda self, nested, report, best: best.take(begun)
        )
        solution = search.solve(silent, shared.nested_starts(problem.parameters))
    else:
        solution = along_the_motion(shared, find("lugre+ripple"), silent).solution
    assert solution.cost <= best.solution.cost


def test_a_stribeck_velocity_is_not_fixed_if_the_nested_model_fits_better(monkeypatch):
    shared = context(v_S=2e-2)
    best = along_the_motion(shared, find("lugre"), silent).solution
    monkeypatch.setattr(estimating, "FLAT", 1e6)
    richer_one = along_the_motion(shared, find("lugre+ripple"), silent).solution
    assert "v_S" in richer_one.values
    assert richer_one.cost <= best.cost


def test_an_interruption_of_a_nested_fit_ends_the_richer_one(monkeypatch):
    def interrupted(self, report, nested=()):
        return replace(solution, unfinished=True)

    shared = context(2.0)
    solution = along_the_motion(shared, find("lugre"), silent).solution
    shared.optima.clear()
    monkeypatch.setattr(Search, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        along_the_motion(shared, find("lugre+ripple"), silent)


def test_offset_and_directional_levels_are_identified_if_a_weight_is_visible():
    levels = {
        "F_C_pos": 7.0,
        "F_C_neg": 6.0,
        "F_S_pos": 9.0,
        "F_S_neg": 8.0,
        "sigma_2_pos": 30.0,
        "sigma_2_neg": 30.0,
    }
    log = slow_log(find("lugre+asymmetry")(offset=4.0, **levels, **SHAPE), duration=4.0)
    fit = identify(log, "lugre+asymmetry", axis=STATED, blocks=0, draws=0).best
    for name, value in {"offset": 4.0, "F_C_pos": 7.0, "F_C_neg": 6.0}.items():
        assert fit.parameters[name].status == "identified"
        assert fit.parameters[name].value == pytest.approx(value, abs=0.3)


def test_the_offset_is_fixed_if_directional_levels_explain_as_much():
    levels = {
        "F_C_pos": 9.0,
        "F_C_neg": 6.0,
        "F_S_pos": 12.0,
        "F_S_neg": 8.0,
        "sigma_2_pos": 30.0,
        "sigma_2_neg": 30.0,
    }
    log = slow_log(find("lugre+asymmetry")(**levels, **SHAPE), duration=4.0)
    fit = identify(log, "lugre+asymmetry", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["offset"].reason.code == "held_levels"


@pytest.mark.slow
def test_a_static_model_fixes_a_constant_that_keeps_levels_positive():
    truth = find("stribeck_free")(F_C=8.0, F_0=1.0, v_S=5e-3, F_v=30.0, offset=3.0)
    fits = identify(
        slow_log(truth, duration=3.0),
        "stribeck_free,stribeck_free+asymmetry",
        axis=STATED,
        blocks=0,
        draws=0,
    ).fits
    left = {fit.name: float(np.linalg.norm(fit.traces.residual)) for fit in fits}
    assert left["stribeck_free+asymmetry"] <= left["stribeck_free"] * (1.0 + 1e-6)
    held = next(fit for fit in fits if fit.name == "stribeck_free+asymmetry").parameters["offset"]
    assert held.value == pytest.approx(3.0, abs=0.3)
    assert held.reason.code == "held_constant"

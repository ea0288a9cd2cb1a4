"""A model with one more slot starts from the best model without it, and is never worse."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, slow_log

from bristle.core import Axis
from bristle.engine import force_along
from bristle.friction import find
from bristle.friction.next_model import nested_in
from bristle.friction.slots import slotted
from bristle.identification import estimation as estimating
from bristle.identification import identify
from bristle.identification.estimation import along_the_motion, context_of, richer
from bristle.identification.least_squares import Search, silent
from bristle.identification.parameters import PriorKnowledge
from bristle.identification.preprocessing import treat

pytestmark = pytest.mark.usefixtures("of_one_mass")

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
    ("base", "rich"), [("stribeck", "stribeck_free"), *((base, f"{base}+{slot}") for base in ("stribeck", "lugre") for slot in SLOTS)]
)
def test_a_richer_model_starts_equal_to_the_nested_model(base, rich):
    shared = context(2.0)
    nested, component = shared.problem(find(base)), shared.problem(find(rich))
    optimum = nested.parameters.complete({**LUGRE, "M": 12.0, "F_v": 30.0, "offset": 0.0 if base == "lugre" else 1.5})
    optimum = {name: value for name, value in optimum.items() if name in nested.parameters.variables}
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
        begun = replace(best.solution, space=search.space, theta=search.space.high.clip(-5.0, 5.0), cost=0.0)
        monkeypatch.setattr(type(problem), "excerpt", lambda self: problem)
        monkeypatch.setattr(Search, "_from_several", lambda self, nested, report, best: best.take(begun))
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
    levels = {"F_C_pos": 7.0, "F_C_neg": 6.0, "F_S_pos": 9.0, "F_S_neg": 8.0, "sigma_2_pos": 30.0, "sigma_2_neg": 30.0}
    log = slow_log(find("lugre+asymmetry")(offset=4.0, **levels, **SHAPE), duration=4.0)
    fit = identify(log, "lugre+asymmetry", axis=STATED, blocks=0, draws=0).best
    for name, value in {"offset": 4.0, "F_C_pos": 7.0, "F_C_neg": 6.0}.items():
        assert fit.parameters[name].status == "identified"
        assert fit.parameters[name].value == pytest.approx(value, abs=0.3)


def test_the_offset_is_fixed_if_directional_levels_explain_as_much():
    levels = {"F_C_pos": 9.0, "F_C_neg": 6.0, "F_S_pos": 12.0, "F_S_neg": 8.0, "sigma_2_pos": 30.0, "sigma_2_neg": 30.0}
    log = slow_log(find("lugre+asymmetry")(**levels, **SHAPE), duration=4.0)
    fit = identify(log, "lugre+asymmetry", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["offset"].reason.code == "held_levels"


def test_a_static_model_fixes_a_constant_that_keeps_levels_positive():
    truth = find("stribeck_free")(F_C=8.0, F_0=1.0, v_S=5e-3, F_v=30.0, offset=3.0)
    fits = identify(slow_log(truth, duration=3.0), "stribeck_free,stribeck_free+asymmetry", axis=STATED, blocks=0, draws=0).fits
    left = {fit.name: float(np.linalg.norm(fit.traces.residual)) for fit in fits}
    assert left["stribeck_free+asymmetry"] <= left["stribeck_free"] * (1.0 + 1e-6)
    held = next(fit for fit in fits if fit.name == "stribeck_free+asymmetry").parameters["offset"]
    assert held.value == pytest.approx(3.0, abs=0.3)
    assert held.reason.code == "held_constant"

"""One step of every model: the mean of its parts however long it is, and moved by no more than its velocity is."""

import itertools
import sys
from contextlib import nullcontext

import numpy as np
import pytest

from bristle.core.mathematics import NEWTON_ROUNDS, newton_from, newton_next
from bristle.engine import force_along, interpreted
from bristle.models.friction import MODELS, bouc_wen, dahl, deflection, preisach_lugre
from bristle.models.friction.slip_law import SlipLaw
from bristle.models.hysteresis.everett import ClosedForm
from bristle.models.hysteresis.turning_points import Stack, stack_commit, stack_size, stack_trial

DT = 1e-3
KERNELS = (
    ("dahl_masing", 0.7),
    ("dahl_masing", 1.1),
    ("dahl_masing", 1.3),
    ("dahl_masing", 2.0),
    ("dahl_masing", 5.0),
    ("tip_masing", 2.0),
    ("reformed_dahl_exact", 2.0),
    ("exp_masing", 2.0),
)
TRANSITIONS = (("paper", 2.0), ("leuven", 2.0), ("leuven", 8.0), ("elastoplastic", 2.0))


def examples():
    for name, model in MODELS.items():
        yield pytest.param(model(**model.example), id=name)
    for i in (0.5, 1.0, 2.0, 4.0):
        yield pytest.param(dahl(**dahl.example | {"exponent": i}), id=f"dahl {i}")
    yield pytest.param(bouc_wen(**bouc_wen.example | {"exponent": 8.0}), id="bouc_wen 8")
    for (transition, n), (kernel, exponent) in itertools.product(TRANSITIONS, KERNELS):
        sizes = preisach_lugre.example | {
            "transition": transition,
            "n": n,
            "kernel": kernel,
            "exponent": exponent,
        }
        yield pytest.param(preisach_lugre(**sizes), id=f"{transition} {n} {kernel} {exponent}")


def walk(seed, count=1200):
    """Return velocities: at random, a slow wander, or strokes that come back to where they turned."""
    generator = np.random.default_rng(seed)
    if seed % 3 == 0:
        return generator.standard_normal(count) * 10.0 ** generator.uniform(-6.0, -2.0)
    if seed % 3 == 1:
        v = np.cumsum(generator.standard_normal(count)) * 1e-5
        return v - np.linspace(0.0, v[-1], count)
    result = []
    while len(result) < count:
        speed, steps = 10.0 ** generator.uniform(-6.0, -2.0), int(generator.integers(3, 40))
        result += [speed] * steps + [-speed] * int(steps * generator.choice([0.5, 1.0, 2.0]))
    return np.array(result[:count])


@pytest.mark.parametrize(
    "model",
    [
        case
        if case.id in ("lugre", "elastoplastic 2.0 exp_masing 2.0")
        else pytest.param(*case.values, id=case.id, marks=pytest.mark.slow)
        for case in examples()
    ],
)
def test_the_force_changes_only_in_the_last_place_with_the_velocity(model):
    for seed in range(40):
        v = walk(seed, 600)
        up = np.random.default_rng(seed).random(v.size) < 0.5
        twin = np.where(v == 0.0, v, np.nextafter(v, np.where(up, np.inf, -np.inf)))
        force, other = force_along(model, v, DT), force_along(model, twin, DT)
        assert np.max(np.abs(force - other)) < 1e-9 * np.max(np.abs(force)), seed


def forces(model, v, dt):
    """Composites are compiled, for other tests need that too; the kernels of any other model run as they stand."""
    with nullcontext() if hasattr(model.parameters, "transition") else interpreted():
        return force_along(model, v, dt)


@pytest.mark.parametrize("model", [*examples()])
def test_a_long_step_is_the_mean_of_its_parts(model):
    if "scatter" in model.values:
        # A reversal draws another limit for the steps after it.
        model = model.with_values(scatter=0.0)
    parts, fast = 100, np.full(10, 2e-3)
    for distance in (2e-6, 2e-5, 2e-4):
        fine = np.mean(forces(model, np.full(parts, distance / DT), DT / parts))
        assert forces(model, np.array([distance / DT]), DT)[0] == pytest.approx(fine, rel=0.012), (
            distance
        )
    # Back from sliding. A gate that opens where an operator of exponent 5 hardly rises any more is the worst case by far.
    share = 0.05 if model.values.get("exponent") == 5.0 else 0.02
    for distance in (-5e-6, -1e-4):
        v = np.append(fast, distance / DT)
        fine = np.mean(forces(model, np.repeat(v, parts), DT / parts)[-parts:])
        assert forces(model, v, DT)[-1] == pytest.approx(fine, abs=share * 28.0), distance


def test_a_gate_that_opens_within_a_step_bends_the_force_smoothly():
    model, v = preisach_lugre(**preisach_lugre.example), np.full(125, 1.2e-4)
    fine = forces(model, np.repeat(v, 20), DT / 20).reshape(-1, 20).mean(axis=1)
    assert forces(model, v, DT) == pytest.approx(fine, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("transition", "n"), TRANSITIONS)
def test_a_solve_of_the_composite_takes_few_rounds(transition, n, monkeypatch):
    rounds = []

    def counted(search, residual, slope):
        rounds.append(search.rounds + 1)
        return newton_next(search, residual, slope)

    monkeypatch.setattr(deflection, "newton_next", counted)
    whole = []
    composite = sys.modules["bristle.models.friction.preisach_lugre"]
    plain = composite.deflect

    def stepped(*arguments):
        before = len(rounds)
        done = plain(*arguments)
        whole.append(len(rounds) - before)
        return done

    monkeypatch.setattr(composite, "deflect", stepped)
    for kernel, exponent in KERNELS:
        model = preisach_lugre(
            **preisach_lugre.example
            | {"transition": transition, "n": n, "kernel": kernel, "exponent": exponent}
        )
        with interpreted():
            for seed in range(3):
                force_along(model, walk(seed, 300), DT)
            for distance in (1e-6, 1e-5, 1e-4, 5e-4):
                force_along(model, np.array([distance, -distance]) / DT, DT)
    assert len(rounds) > 1000
    assert max(rounds) <= 8
    assert max(whole) <= 60


@pytest.mark.parametrize(("transition", "n"), TRANSITIONS)
def test_a_step_of_hardly_any_length_keeps_the_force(transition, n):
    model = preisach_lugre(**preisach_lugre.example | {"transition": transition, "n": n})
    for v in (1e-200, 1e-306, 1e-312, 5e-321):
        force = force_along(model, np.array([1e-3] * 20 + [v, v]), DT)
        still = force_along(model, np.array([1e-3] * 20 + [0.0, 0.0]), DT)
        assert force == pytest.approx(still, rel=1e-12), v


@pytest.mark.parametrize("kernel", range(4))
def test_no_step_passes_sliding_when_a_loop_is_wiped_out_just_below(kernel):
    q = ClosedForm(kernel, 1e7, 33.6)
    for missing, dx in itertools.product(np.geomspace(1e-11, 1e-8, 25).tolist(), (1e-5, 1e-3)):
        stack, memory, forces = Stack(), np.zeros(stack_size(8)), []
        for u in (5e-6, 2.9e-6):
            f, move = stack_trial(stack, memory, u, 0.0, q)
            stack = stack_commit(stack, memory, move)
            forces.append(f)
        G = forces[0] * (1.0 + missing)
        done = deflection.deflect(
            stack, memory, dx, 1.0, G, SlipLaw(0.99, 1.0, 1.0), q, q.f_p / q.s, 1e-18
        )
        assert done.move.f == pytest.approx(G, rel=1e-9)


def steep_at_the_end(x):
    return 1e-9 * x - 1e-7 + (1e3 * (x - 0.9) if x > 0.9 else 0.0)


def root_with_a_cycle(x):
    return np.sign(x - 0.4) * abs(x - 0.4) ** 0.5


NASTY = {
    "flat, then steep": (steep_at_the_end, lambda x: 1e3 if x > 0.9 else 1e-9),
    "a step": (lambda x: 1.0 if x > 1.0 / 3.0 else -1.0, lambda x: 0.0),
    "a cycle of Newton's method": (
        root_with_a_cycle,
        lambda x: 0.5 / max(abs(x - 0.4), 1e-9) ** 0.5,
    ),
    "a slope that lies": (lambda x: (x - 0.7) ** 3, lambda x: 1e-3),
}


@pytest.mark.parametrize("name", sorted(NASTY))
def test_the_search_interval_is_halved_each_round_for_any_function(name):
    function, slope = NASTY[name]
    search = newton_from(1.0, 1.0)
    for k in range(NEWTON_ROUNDS + 40):
        search = newton_next(search, function(search.x), slope(search.x))
        assert search.high - search.low <= 2.0 ** -max(k - NEWTON_ROUNDS, 0)
        assert search.low <= search.x <= search.high
    assert function(search.low) <= 0.0 <= function(search.high)

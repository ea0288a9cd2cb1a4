"""Each demand of the contract by itself: what meets it, what just misses it, and what is told."""

import math
from dataclasses import astuple
from itertools import count
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from bristle import friction
from bristle.contract import contract, slot, slot as module
from bristle.contract.check import Check, Fact, UnmetError, compiled_as_plain, judged, outcomes
from bristle.contract.slot import range_of
from bristle.core.status import Status
from bristle.models.friction import CHANNEL_SLOTS


class State(NamedTuple):
    """The state of a model in plain Python."""

    z: float = 0.0


class Move(NamedTuple):
    """Where its state goes."""

    z: float = 0.0


def model(trial=lambda state, memory, motion, dt, p: (0.0, Move()), **changed):
    """A model in plain Python whose trial is given."""
    parts = {
        "trial": trial,
        "commit": lambda state, memory, move, p: State(move.z),
        "initial_state": lambda p: State(),
        "new_memory": lambda p: np.zeros(2),
    }
    component = SimpleNamespace(
        **parts | dict.fromkeys(("rate", "piece", "flow", "arrival")) | changed
    )
    return SimpleNamespace(component=component, parameters=None, kind="translational", values={})


def unmet(demand, *requested):
    """What is told of a demand that is not met."""
    with pytest.raises(UnmetError) as missed:
        demand(*requested)
    return missed.value


# --- outcomes -------------------------------------------------------------------------------------------------------


def fits(subject):
    return Fact("seen", 2.0, "N", 3.0)


def misses(subject):
    raise UnmetError(Fact("too much", 4.0, "N", 3.0), "less")


def stops(subject):
    raise ZeroDivisionError("by nought")


def test_results_are_in_order_with_their_observations():
    first, second, third = outcomes([fits, misses, stops], None, ())
    assert first == Check("fits", True, "seen", "", True, 2.0, "N", 3.0)
    assert second == Check("misses", False, "too much", "less", True, 4.0, "N", 3.0)
    assert (third.passed, third.detail, third.advice) == (
        False,
        "stops with ZeroDivisionError: by nought",
        "Kernels never raise",
    )


def test_a_failed_demand_of_the_form_skips_the_others():
    assert [check.name for check in outcomes([misses, fits], None, (misses,))] == ["misses"]
    assert [check.name for check in outcomes([fits, misses], None, (fits,))] == ["fits", "misses"]
    assert len(outcomes([stops, fits], None, (stops,), "why")) == 1

    def interrupted(subject):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        outcomes([interrupted], None, ())


def test_a_fact_is_returned_if_its_demand_is_met():
    fact = Fact("x")
    assert judged(fact, "y", unmet=False) is fact
    missed = unmet(lambda: judged(fact, "y", unmet=True))
    assert (missed.fact, missed.advice, str(missed)) == (fact, "y", "x")


def test_differing_bits_are_reported_with_their_size():
    runs = iter([np.array([1.0, 2.0]), np.array([1.0, 2.5])])
    missed = unmet(lambda: compiled_as_plain(lambda: next(runs), "rotational"))
    assert (missed.fact.value, missed.fact.unit, missed.fact.threshold) == (0.5, "N*m", 0.0)
    assert missed.fact.detail == "largest difference 0.5 in 2 steps"
    assert compiled_as_plain(lambda: np.array([1.0, 2.0]), "translational").value == 0.0
    zeros = iter([np.array([0.0]), np.array([-0.0])])
    # The same number, of other bits.
    unmet(lambda: compiled_as_plain(lambda: next(zeros), "translational"))


# --- trials ---------------------------------------------------------------------------------------------------------


def recorded(demand, **changed):
    """Each motion and step that a demand tries on a model without a force."""
    tried = []
    demand(
        model(
            lambda state, memory, motion, dt, p: tried.append((motion, dt)) or (0.0, Move()),
            **changed,
        )
    )
    return tried


def test_speeds_at_which_a_force_is_finite_are_of_both_signs_and_every_size():
    # After the motions that a contact begins with.
    tried = recorded(contract.finite_everywhere)[50:]
    speeds = [motion.v for motion, dt in tried if dt == 1.0]
    assert speeds == [0.0, -0.0, 1e-300, -1e-300, 1e-12, 1e-3, -1e-3, 1.0, -1e3, 1e6]
    assert [math.copysign(1.0, v) for v in speeds[:4]] == [1.0, -1.0, 1.0, -1.0]
    assert [dt for _, dt in tried[:4]] == [0.0, 1e-9, 1e-3, 1.0]
    assert {motion.x for motion, _ in tried} == {0.0}
    assert [
        (motion.v, motion.x, dt) for motion, dt in recorded(contract.one_sided_limits)[50:]
    ] == [(0.0, 0.0, 1e-3), (-0.0, 0.0, 1e-3)]
    ((motion, dt),) = recorded(contract.scalar_results)
    assert (motion.v, motion.x, dt) == (1e-3, 1e-6, 1e-3)


def test_rates_are_followed_in_steps_of_100_nanoseconds_at_speeds_of_both_signs():
    followed = recorded(contract.rate_agrees, rate=lambda state, motion, p: (0.0, (0.0,)))
    steps = [(motion.v, dt) for motion, dt in followed if dt == 1e-7]
    assert steps == [(v, 1e-7) for v in (1e-3, -2e-3, 5e-3) for _ in range(20)]
    parts = {
        "piece": lambda *contact: (State(), None),
        "flow": lambda *contact: (0.0, (0.0,), 0.0),
        "arrival": lambda *contact: None,
    }
    flown = [motion.v for motion, dt in recorded(contract.flow_agrees, **parts) if dt == 1e-7]
    assert flown == [v for v in (1e-3, -2e-3, 5e-3, -1e-4) for _ in range(20)]


@pytest.mark.parametrize(
    ("forward", "backward", "is_met", "advice"),
    [
        (1.0, -1.0, True, ""),
        (1.0, 1.0, True, ""),
        (-1.0, 1.0, False, "Check signs"),
        (0.5, 1.0, False, "Use direction(v)"),
    ],
)
def test_limits_at_rest_lie_in_order(forward, backward, is_met, advice):
    sided = model(
        lambda state, memory, motion, dt, p: (
            forward if math.copysign(1.0, motion.v) > 0.0 else backward,
            Move(),
        )
    )
    if is_met:
        fact = contract.one_sided_limits(sided)
        assert (fact.value, fact.unit) == (forward - backward, "N")
        assert fact.detail == f"F(+0) = {forward:g}, F(-0) = {backward:g}"
    else:
        assert unmet(contract.one_sided_limits, sided).advice.startswith(advice)


def test_a_force_opposes_sliding_apart_from_its_mean(monkeypatch):
    monkeypatch.setattr(contract, "_steady", lambda model, v: 5.0 + 2.0 * np.sign(v) + 10.0 * v)
    fact = contract.opposes_sliding(model())
    assert fact.value == pytest.approx(4.0 + 20.0 * 1e-4)
    assert fact.detail.startswith("smallest force at 0.0001 m/s: 7.001 forward, 2.999 backward")
    monkeypatch.setattr(contract, "_steady", lambda model, v: -v if abs(v) > 0.05 else v)
    assert unmet(contract.opposes_sliding, model()).fact.value == pytest.approx(-0.2)


@pytest.mark.parametrize(
    ("force", "value"),
    [
        (lambda v, x: np.sign(v), 1.0),
        (lambda v, x: x, 0.0),
        (lambda v, x: 0.0 * v, 0.0),
        (lambda v, x: -np.sign(v), -1.0),
    ],
)
def test_friction_takes_energy_out_of_cycles(monkeypatch, force, value):
    monkeypatch.setattr(contract, "force_along", lambda model, v, dt, x: force(v, x - 0.5 * dt * v))
    if value < -0.5:
        missed = unmet(contract.dissipates, model())
        assert (missed.fact.value, missed.fact.threshold) == (pytest.approx(-1.0), -1e-9)
        assert missed.fact.detail == "a closed cycle returned 100 % of the work"
    else:
        assert contract.dissipates(model()).value == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    ("order", "is_met"), [(1.0, True), (0.2, True), (0.0, False), (-1.0, False)]
)
def test_halving_the_step_changes_a_force_less_and_less(monkeypatch, order, is_met):
    # What differs from the limit by the step to a power; the sign of that changes from refinement to refinement.
    def along(model, v, dt, x):
        return 1.0 + (-1.0) ** round(math.log2(1.0 / (200.0 * dt))) * (
            200.0 * dt
        ) ** order * np.ones(v.size)

    monkeypatch.setattr(contract, "force_along", along)
    if is_met:
        fact = contract.refines(model())
        assert fact.value < fact.threshold
        assert fact.detail.startswith("relative changes ")
    else:
        assert unmet(contract.refines, model()).advice == "Return the mean force over the step"


def charged(slope=lambda v: v, force=lambda z, v: 2.0 * z):
    """A spring whose state follows the velocity, with its rate as it may be wrong."""

    def trial(state, memory, motion, dt, p):
        z = state.z + motion.v * dt
        return 2.0 * 0.5 * (state.z + z), Move(z)

    return model(
        trial, rate=lambda state, motion, p: (force(state.z, motion.v), State(slope(motion.v)))
    )


def test_a_rate_is_that_of_small_steps():
    assert contract.rate_agrees(charged()).value < 1e-3
    assert unmet(contract.rate_agrees, charged(force=lambda z, v: 2.1 * z)).fact.value > 1e-3
    assert unmet(contract.rate_agrees, charged(slope=lambda v: 1e6 * v)).fact.value > 1e-3


def test_a_mass_is_driven_by_twice_the_sliding_force(monkeypatch):
    driven = []

    def run(plant, model, effort, dt, steps):
        driven.append((plant.values["M"], np.max(np.abs(effort)), dt, steps, effort.size))
        return SimpleNamespace(status=Status.OK, position=np.array([-1.0, 2.0]))

    monkeypatch.setattr(contract, "_steady", lambda model, v: 3.0 if v > 0.0 else -4.0)
    monkeypatch.setattr(contract, "run_open_loop", run)
    fact = contract.drives_a_mass(model())
    assert driven == [(1.0, pytest.approx(8.0, rel=1e-4), 1e-3, 4, 2000)]
    assert (fact.value, fact.unit, fact.detail) == (3.0, "m", "travel 3 m")
    monkeypatch.setattr(
        contract,
        "run_open_loop",
        lambda *requested, **more: SimpleNamespace(status=Status.NOT_FINITE),
    )
    assert str(unmet(contract.drives_a_mass, model())) == Status.NOT_FINITE.sentence


def test_motions_are_the_same_each_time_and_go_both_ways():
    first, again = (list(contract._motions(200)) for _ in range(2))
    assert first == again
    speeds = np.array([motion.v for motion, _ in first])
    assert 0.3 < np.mean(speeds > 0.0) < 0.7
    assert 1e-6 <= np.min(np.abs(speeds)) < 1e-5
    assert 1e-2 < np.max(np.abs(speeds)) <= 1e-1
    steps = np.array([dt for _, dt in first])
    assert 1e-6 <= steps.min() < 1e-5
    assert 1e-3 < steps.max() <= 1e-2


# --- slots ----------------------------------------------------------------------------------------------------------


def channel(low=-math.inf, high=math.inf, usual=10.0, nominal=1.0):
    """A slot whose channel has a range."""
    variable = SimpleNamespace(min=low, max=high, nominal=nominal, unit=lambda: "K")
    return SimpleNamespace(
        channel=SimpleNamespace(name="oil", variable=variable, usual=usual, field="x", is_own=False)
    )


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        (channel(), (8.0, 12.0)),
        (channel(usual=0.0, nominal=5.0), (-1.0, 1.0)),
        (channel(low=0.0), (0.0, 12.0)),
        (channel(high=11.0), (8.0, 11.0)),
        (channel(usual=-10.0), (-12.0, -8.0)),
    ],
)
def test_a_channel_is_tried_over_its_range_or_around_its_usual_value(item, expected):
    assert slot.range_of(item) == pytest.approx(expected)


def factor(values, **changed):
    """A slot whose factor goes through some values."""
    item = channel(0.0, 1.0)
    known = np.interp(np.linspace(0.0, 1.0, 41), np.linspace(0.0, 1.0, len(values)), values)
    item.factor = lambda value, parameters: float(known[round(40.0 * value)])
    item.neutral, item.defaults, item.example, item.assemble = None, {}, {}, lambda values: None
    return item


def test_a_factor_stays_above_zero_and_varies():
    fact = slot.factor_above_zero(factor([0.5, 2.0]))
    assert (fact.value, fact.detail) == (0.5, "0.5 to 2 for oil from 0 to 1 K")
    assert fact.threshold == slot.SMALLEST_FACTOR
    for values in ([0.0, 1.0], [-0.5, 1.0], [slot.SMALLEST_FACTOR, 1.0], [1.0, math.inf]):
        assert unmet(slot.factor_above_zero, factor(values)).advice.startswith(
            "Friction must not change its sign"
        )
    assert unmet(slot.factor_above_zero, factor([2.0, 2.0])).advice.startswith(
        "Give the slot example"
    )


def test_a_walk_takes_a_millisecond_at_each_speed_in_any_units():
    from bristle.contract import dimensions

    tried = []

    def trial(state, memory, motion, dt, p):
        tried.append((motion.v, motion.x, dt))
        return 8.0 * motion.v, Move()

    class Component(SimpleNamespace):
        """A component without parameters."""

        def __call__(self, **values):
            return SimpleNamespace(parameters=None)

    stateless = friction.find("coulomb_viscous").State
    walker = model(trial, State=stateless, variables={})
    walker.component = Component(
        **vars(walker.component)
        | {"commit": lambda state, *_: state, "initial_state": lambda p: stateless()}
    )
    force, *_ = dimensions._walked(walker, {})
    speeds = [1e-4, 1e-3, 5e-3, -1e-4, -1e-3, 0.0, -0.0, 2e-3, -5e-3, 1e-4, -2e-3]
    assert [v for v, _, _ in tried] == speeds
    assert math.copysign(1.0, tried[6][0]) == -1.0
    assert [x for _, x, _ in tried] == pytest.approx(np.cumsum(1e-3 * np.array(speeds)))
    assert {dt for *_, dt in tried} == {1e-3}
    assert force == pytest.approx(8.0 * np.array(speeds))
    del tried[:]
    scaled, *_ = dimensions._walked(walker, {"length": 16.0, "time": 4.0})
    assert [v for v, _, _ in tried] == pytest.approx(4.0 * np.array(speeds))
    assert [x for _, x, _ in tried] == pytest.approx(16e-3 * np.cumsum(speeds))
    assert {dt for *_, dt in tried} == {4e-3}
    assert scaled == pytest.approx(32.0 * np.array(speeds))
    halved, *_ = dimensions._walked(walker, {"force": 2.0})
    assert halved == pytest.approx(4.0 * np.array(speeds))


def test_a_model_has_one_dimension_where_its_units_may_change():
    from bristle.contract.dimensions import WALK, one_dimension

    example = friction.coulomb_viscous(F_C=3.0, F_v=50.0)
    assert (
        one_dimension(example).detail
        == f"{len(WALK)} steps, in other units of length, time and force"
    )
    assert {math.copysign(1.0, v) for v in WALK if v == 0.0} == {1.0, -1.0}


# --- what a slot is tried with ----------------------------------------------------------------------------------------


SLOT = CHANNEL_SLOTS["pressure"]


def compared(monkeypatch, slot):
    """The motion and the channel along which plain Python and compiled code are compared."""
    seen = []
    monkeypatch.setattr(
        module,
        "force_along",
        lambda model, v, dt, x, **signals: seen.append((v, dt, x, signals)) or np.zeros(v.size),
    )
    monkeypatch.setattr(module, "compiled_as_plain", lambda run, kind: run())
    module.same_bits_along_its_channel(slot)
    return seen[0]


def test_bits_are_compared_along_a_walk_while_the_channel_goes_from_end_to_end(monkeypatch):
    v, dt, x, signals = compared(monkeypatch, SLOT)
    assert dt == 1e-3
    assert v.size == x.size == 399
    assert np.diff(x) == pytest.approx(dt * v[1:], abs=1e-18)
    assert {np.sign(speed) for speed in v} == {1.0, -1.0}
    assert 1e-7 < np.std(np.diff(x)) < 1e-5
    pressure = signals["pressure"]
    assert (pressure[0], pressure[-1]) == tuple(range_of(SLOT))
    assert np.all(np.diff(pressure) > 0.0)
    again = compared(monkeypatch, SLOT)
    assert again[0].tolist() == v.tolist()  # the same walk each time


def exported(monkeypatch, messages, command="cc"):
    """The fact of an export whose self-tests of 100 steps end with messages, and the usual values that it was tried with."""
    left, usual = iter(messages), []
    monkeypatch.setattr(module, "compiler", lambda: command)
    monkeypatch.setattr(module, "proved", lambda model, command: (100, next(left)))

    def with_slot(slot, inner):
        usual.append(slot.channel.usual)
        return SimpleNamespace(inner=inner)

    monkeypatch.setattr(module, "model_with", with_slot)
    return module.same_bits_exported(SLOT), usual


def test_an_export_is_proved_at_both_ends_of_the_channel(monkeypatch):
    fact, usual = exported(monkeypatch, ["", ""])
    assert fact.detail == "200 steps compiled by cc"
    assert usual == [SLOT.channel.usual] * 2 if not SLOT.channel.is_own else list(range_of(SLOT))


def test_an_export_with_an_error_at_one_end_is_reported(monkeypatch):
    with pytest.raises(UnmetError, match="the last bit differs"):
        exported(monkeypatch, ["", "the last bit differs"])


def test_without_a_compiler_no_export_is_judged(monkeypatch):
    fact, usual = exported(monkeypatch, [], command=None)
    assert (fact.applies, usual) == (False, [])


def test_a_demand_on_a_model_is_met_by_a_model_of_bristle_with_the_slot():
    assert SLOT.name in module.on_a_model(lambda model: model)(SLOT).name.split("+")


# --- demands that are missed and met ---------------------------------------------------------------------------------


CALLS = count()
LAW = SimpleNamespace(component=SimpleNamespace(State=State), kind="rotational")


def sampled(result):
    return slot._sampled(LAW, "effort", result, "force")


def pushing(force):
    """A model whose force depends on motion and step."""
    return model(lambda state, memory, motion, dt, p: (force(motion, dt), Move()))


def rushing(motion, dt):
    return math.inf if motion.v == 1e6 else 0.0


def writing(state, memory, motion, dt, p):
    memory[0] += 1.0
    return 0.0, Move()


@pytest.mark.parametrize(
    ("demand", "subject", "said"),
    [
        (contract.pure_trial, model(writing), "wrote into the memory"),
        (
            contract.pure_trial,
            model(lambda *_: (float(next(CALLS)), Move())),
            "later gave a different result",
        ),
        (contract.scalar_results, pushing(lambda motion, dt: np.zeros(2)), "the force is"),
        (contract.scalar_results, pushing(lambda motion, dt: math.nan), "the force is"),
        (contract.scalar_results, pushing(lambda motion, dt: "1"), "the force is"),
        (contract.scalar_results, model(lambda *_: (0.0, (1.0,))), "the move is a tuple"),
        (
            contract.scalar_results,
            model(commit=lambda state, memory, move, p: move),
            "commit returned a Move",
        ),
        (contract.finite_everywhere, pushing(rushing), "the force is inf at v = 1e+06, dt = 0"),
        (contract.flow_agrees, model(flow=len), "not all given"),
        (sampled, lambda: (math.inf, State()), "the effort is float inf"),
        (sampled, lambda: ([], State()), "the effort is list"),
        (sampled, lambda: (1.0, 2.0), "as its state"),
        (sampled, lambda: (float(next(CALLS)), State()), "later gave a different result"),
    ],
)
def test_a_demand_that_is_missed_says_why(demand, subject, said):
    assert said in str(unmet(demand, subject))


@pytest.mark.parametrize(
    ("read", "expected"),
    [
        (lambda: contract.pure_trial(model()).detail, "1000 trials"),
        (lambda: contract.scalar_results(model()).value, 0.0),
        (lambda: contract.finite_everywhere(model()).detail, "40 pairs of velocity and step"),
        (lambda: unmet(contract.finite_everywhere, pushing(rushing)).fact.value, 4),
        (
            lambda: (
                unmet(
                    contract.finite_everywhere,
                    pushing(lambda motion, dt: math.nan if dt == 0.0 else 0.0),
                ).fact.value
            ),
            10,
        ),
        (lambda: contract.flow_agrees(model()).applies, False),
        (lambda: contract.rate_agrees(model()).applies, False),
        (lambda: astuple(sampled(lambda: (3.0, State(1.0))))[1:3], (3.0, "N*m")),
        (lambda: slot.neutral_defaults(factor([1.0, 1.0])).value, 0.0),
        (
            lambda: astuple(unmet(slot.neutral_defaults, factor([1.0, 1.25])).fact)[1:4:2],
            (0.25, 1e-12),
        ),
        (
            lambda: math.isnan(unmet(slot.neutral_defaults, factor([1.0, math.nan])).fact.value),
            True,
        ),
    ],
)
def test_a_demand_has_its_numbers(read, expected):
    assert read() == expected

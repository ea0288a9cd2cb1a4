"""The public contract suite over all models, over a faulty one for each demand, and over a user's file."""

from itertools import product
from typing import Annotated, NamedTuple

import pytest
from tests.contract.models import KNOWN, with_fast

from bristle import friction
from bristle.contract import CHECKS, check_model
from bristle.contract.contract import (
    derivatives_agree,
    drives_a_mass,
    one_sided_limits,
    pure_trial,
    same_bits_compiled,
    same_bits_exported,
)
from bristle.core import FrictionModel, InputError, Variable, kernel
from bristle.core.mathematics import direction
from bristle.engine.derivatives import force_with_derivatives
from bristle.exports import c as proof
from bristle.exports.c import compiler
from bristle.files.user_model import load_code
from bristle.models.friction.operator_kernel import REACHES
from bristle.models.friction.preisach_lugre import KERNELS, TRANSITIONS

NAMES = [
    *with_fast("lugre"),
    *with_fast(form="{}+asymmetry", unfit=("coulomb", "viscous", "stribeck", "dahl")),
]

# What nothing is compiled for.
AS_IT_STANDS = [
    check
    for check in CHECKS
    if check not in (same_bits_compiled, same_bits_exported, drives_a_mass)
]


@pytest.mark.parametrize("name", NAMES)
def test_every_model_meets_the_contract(name):
    checks = check_model(friction.MODELS.get(name) or friction.find(name))
    assert [check for check in checks if not check.passed] == []
    assert len(checks) == len(CHECKS)


def test_a_new_model_is_part_of_the_fast_tests(monkeypatch):
    assert friction.MODELS.keys() >= KNOWN
    monkeypatch.setattr(friction, "MODELS", {**friction.MODELS, "new_model": friction.coulomb})
    assert [case.values[0] for case in with_fast("lugre") if not case.marks][-1] == "new_model"


@pytest.mark.slow
@pytest.mark.parametrize(("kernel", "transition"), list(product(KERNELS, TRANSITIONS)))
def test_the_composite_meets_it_with_every_operator_and_slip_law(kernel, transition):
    model = friction.preisach_lugre(
        **{**friction.preisach_lugre.example, "kernel": kernel, "transition": transition}
    )
    assert [check for check in check_model(model) if not check.passed] == []


@pytest.mark.parametrize(
    ("factor", "words"), [(1.01, "differ by"), (float("nan"), "differ by"), (1.0, None)]
)
def test_wrong_derivatives_of_the_force_are_reported(monkeypatch, factor, words):
    def wrong(*arguments):
        force, derivatives = force_with_derivatives(*arguments)
        return force, factor * derivatives

    monkeypatch.setattr("bristle.contract.contract.force_with_derivatives", wrong)
    (check,) = check_model(friction.find("lugre"), checks=(derivatives_agree,))
    assert check.passed == (words is None)
    assert words is None or words in check.detail


OVER_OPERATORS = [
    f"{name}+{operator}" for name in ("preisach_contact", "preisach_lugre") for operator in REACHES
]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*OVER_OPERATORS, "preisach_contact+everett_table+asymmetry"])
def test_a_model_over_an_operator_meets_it(name):
    checks = check_model(friction.find(name))
    assert [check for check in checks if not check.passed] == []
    assert len(checks) == len(CHECKS)


@pytest.mark.slow
@pytest.mark.parametrize("name", OVER_OPERATORS)
def test_a_model_over_an_operator_leaves_memory_alone_and_has_the_bits_in_c(name):
    checks = check_model(friction.find(name), checks=(pure_trial, same_bits_exported))
    assert [check for check in checks if not check.passed] == []
    assert [check.applies for check in checks] == [True, compiler() is not None]


class State(NamedTuple):
    z: Annotated[float, Variable("length", "deflection")] = 0.0


class Nothing(NamedTuple):
    pass


@kernel
def sound_trial(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v), Nothing()


@kernel
def sound_commit(state, memory, move, p):
    return state


@kernel
def writes_in_trial(state, memory, motion, dt, p):
    memory[0] = motion.v
    return p.F_C * direction(motion.v), Nothing()


@kernel
def divides_by_the_step(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) * (dt / dt), Nothing()


@kernel
def compares_with_zero(state, memory, motion, dt, p):
    return (p.F_C if motion.v < 0.0 else 0.0) + (-p.F_C if motion.v > 0.0 else 0.0), Nothing()


@kernel
def produces_energy(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) - 1e4 * motion.v, Nothing()


@kernel
def forgets_the_mean(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) + 1e-3 * motion.v / (dt * dt + 1e-12), Nothing()


@kernel
def uses_a_list(state, memory, motion, dt, p):
    return sum([p.F_C * direction(motion.v)]), Nothing()


@kernel
def pulls(state, memory, motion, dt, p):
    return -p.F_C * direction(motion.v) * min(abs(motion.v), 1.0), Nothing()


def reversed_sign(state, memory, motion, dt, p):
    return -p.F_C * direction(motion.v), Nothing()


@kernel
def wrong_rate(state, motion, p):
    return 2.0 * p.F_C * direction(motion.v), State(0.0)


class Side(NamedTuple):
    side: float


@kernel
def begins(state, memory, motion, p):
    return state, Side(direction(motion.v))


@kernel
def arrives(state, memory, contact, p):
    return Nothing()


@kernel
def wrong_flow(contact, piece, motion, p):
    return 2.0 * p.F_C * piece.side, State(0.0), piece.side * motion.v


@kernel
def flows_past_its_end(contact, piece, motion, p):
    return p.F_C * piece.side, State(0.0), -piece.side * motion.v


def faulty(trial, **changes):
    class Parameters(NamedTuple):
        F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 1.0

    return FrictionModel(
        name="faulty",
        description="made to fail",
        Parameters=changes.pop("Parameters", Parameters),
        State=changes.pop("State", State),
        trial=trial,
        commit=changes.pop("commit", sound_commit),
        memory_size=lambda p: 1,
        **changes,
    )


class Undescribed(NamedTuple):
    F_C: float = 1.0


class Arrays(NamedTuple):
    z: Annotated[tuple, Variable("length", "deflection")] = (0.0,)


@pytest.mark.parametrize(
    ("model", "demand"),
    [
        (lambda: faulty(sound_trial, Parameters=Undescribed), "example"),
        (lambda: faulty(sound_trial, State=Arrays), "described variables"),
        (lambda: faulty(uses_a_list), "exportable kernels"),
        (
            lambda: faulty(lambda state, memory, motion, dt, p: (0.0, Nothing())),
            "exportable kernels",
        ),
        (
            lambda: faulty(sound_trial, commit=kernel(lambda state, memory, move, p: 0.0)),
            "exportable kernels",
        ),
        (lambda: faulty(writes_in_trial), "exportable kernels"),
        (lambda: faulty(divides_by_the_step), "finite everywhere"),
        (lambda: faulty(compares_with_zero), "opposes sliding"),
        (lambda: faulty(produces_energy), "opposes sliding"),
        (lambda: faulty(pulls), "dissipates"),
        (lambda: faulty(forgets_the_mean), "refines"),
        (lambda: faulty(sound_trial, rate=wrong_rate), "rate agrees"),
        (lambda: faulty(sound_trial, flow=wrong_flow), "flow agrees"),
        pytest.param(
            lambda: faulty(sound_trial, piece=begins, flow=wrong_flow, arrival=arrives),
            "flow agrees",
            marks=pytest.mark.slow,
        ),
        (
            lambda: faulty(sound_trial, piece=begins, flow=flows_past_its_end, arrival=arrives),
            "flow agrees",
        ),
    ],
)
def test_each_fault_is_found_by_name(model, demand):
    failed = [check.name for check in check_model(model(), checks=AS_IT_STANDS) if not check.passed]
    assert demand in failed


def test_a_reversed_sign_is_reported():
    (check,) = check_model(faulty(kernel(reversed_sign)), checks=[one_sided_limits])
    assert check.advice == "Check signs"


def test_a_trial_that_writes_is_found_by_running_it_too():
    (check,) = check_model(faulty(writes_in_trial), checks=[pure_trial])
    assert not check.passed
    assert "wrote into the memory" in check.detail


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_exported_code_is_compared(monkeypatch):
    (check,) = check_model(faulty(sound_trial), checks=[same_bits_exported])
    assert check.applies
    assert check.passed, check.detail
    monkeypatch.setattr(proof, "FLAGS", "-std=c99 -Dtrial=nothing -DF_C=wrong;")
    (check,) = check_model(faulty(sound_trial), checks=[same_bits_exported])
    assert not check.passed


def test_the_comparison_needs_a_compiler(monkeypatch):
    monkeypatch.setattr(proof, "builds", lambda command, *flags: False)
    (check,) = check_model(faulty(sound_trial), checks=[same_bits_exported])
    assert check.passed
    assert not check.applies


def test_the_sound_skeleton_of_the_faulty_models_passes():
    assert [check for check in check_model(faulty(sound_trial)) if not check.passed] == []


SOURCE = '''
"""A user's model: Coulomb friction with a speed-dependent level."""
from itertools import product
from typing import Annotated, NamedTuple
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp

class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 2.0
    v_0: Annotated[float, Variable("length/time", "speed of the fall", min=1e-6)] = 0.1

class State(NamedTuple):
    pass

class Move(NamedTuple):
    pass

@kernel
def trial(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) * (1.0 + LEVEL * exp(-abs(motion.v) / p.v_0)), Move()

@kernel
def commit(state, memory, move, p):
    return state

LEVEL = 0.5
MODEL = FrictionModel(name="mine", description="mine", Parameters=Parameters, State=State, trial=trial, commit=commit)
'''


def test_two_models_cannot_share_their_parameters():
    model = faulty(sound_trial)
    with pytest.raises(TypeError, match="separate Parameters class"):
        faulty(pulls, Parameters=model.Parameters)


def test_a_users_file_is_checked_like_ours(tmp_path):
    path = tmp_path / "my_model.py"
    path.write_text(SOURCE)
    assert [
        check for check in check_model(load_code(path), checks=AS_IT_STANDS) if not check.passed
    ] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1\n", "defines no friction model"),
        ("MODEL = 3\n", "not a FrictionModel"),
        ("def broken(:\n", "line 1"),
        ("import math\n\n1 / 0\n", "line 3"),
        ("import not_a_module_at_all\n", "ModuleNotFoundError"),
    ],
)
def test_a_bad_file_is_refused_with_its_place(tmp_path, text, words):
    path = tmp_path / "bad.py"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        load_code(path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        load_code(tmp_path / "nowhere.py")

"""One component of a run: its vectors, its name, its functions and its memory."""

import numpy as np
import pytest

from bristle import friction
from bristle.core.errors import InputError, InputWarning
from bristle.engine.instance import Instance, memory_of, warn_of_lost

LUGRE = friction.lugre(F_C=20.0, F_S=28.0, v_S=2e-3, sigma_0=1e6)
RISEN = friction.find("lugre+load")(**LUGRE.values, k_L=0.5)
PREISACH = friction.preisach_lugre(**friction.preisach_lugre.example, capacity=4)


def test_a_component_has_its_functions_and_those_of_inner_components():
    component = LUGRE.component
    functions = Instance(LUGRE).functions
    assert {component.trial, component.commit, component.rate} <= set(functions)
    assert {component.trial, component.commit} <= set(Instance(RISEN).functions)
    assert Instance(RISEN).component.trial in Instance(RISEN).functions


def test_the_name_of_a_component_contains_its_inner_components():
    plain, risen = Instance(LUGRE).key, Instance(RISEN).key
    assert plain.endswith(".lugre.Parameters")
    assert (risen.count("Parameters") >= 2, risen != plain) == (True, True)


def test_a_component_begins_virgin_or_in_a_given_state_of_its_type():
    part = Instance(LUGRE)
    assert (part.state.tolist(), part.parameters.tolist()[:4]) == ([0.0], [20.0, 28.0, 2e-3, 1e6])
    part.begin(None)
    part.begin(LUGRE.component.State(3e-6))
    assert part.state_now == (3e-6,)


def test_a_memory_is_copied_and_has_the_size_of_its_model():
    fresh = memory_of(PREISACH, None)
    passed = np.arange(fresh.size, dtype=float)
    copied = memory_of(PREISACH, passed)
    copied[0] = 9.0
    assert passed[0] == 0.0


SLOTTED = friction.find("preisach_lugre+asymmetry")


@pytest.mark.parametrize("model", [PREISACH, SLOTTED(**SLOTTED.example)])
def test_a_fresh_memory_has_lost_nothing(model):
    assert Instance(model).lost == 0
    warn_of_lost(Instance(model))


def test_lost_pairs_of_turning_points_are_counted_and_reported():
    part = Instance(PREISACH)
    part.begin(PREISACH.component.State(0.0, 0.0, 1.0, 2, 3))
    assert part.lost == 3
    with pytest.warns(
        InputWarning, match="lost its innermost pair 3 times.*Raise the parameter capacity above 4"
    ):
        warn_of_lost(part)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda: Instance(LUGRE).begin(PREISACH.component.initial_state(PREISACH.parameters)),
            r"state: belongs to a different model.*a state of lugre",
        ),
        (lambda: Instance(friction.lugre), "model: must be a model with parameters"),
        (
            lambda: memory_of(PREISACH, np.zeros(3)),
            r"memory: has the wrong size; found '?\(3,\).*allowed shape \(10,\)",
        ),
    ],
)
def test_what_is_not_of_a_model_is_refused(call, words):
    with pytest.raises(InputError, match=words):
        call()

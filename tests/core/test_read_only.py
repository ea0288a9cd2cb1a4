"""What a model tells of itself cannot be changed by mistake, and is a dictionary to all who read it."""

import copy
import json
import pickle

import numpy as np
import pytest

from bristle import friction, hysteresis, plants
from bristle.core.read_only import ReadOnly
from bristle.friction import SLOTS, with_presliding, with_slots
from bristle.testing import example_of

ELEMENTS = example_of(friction.find("maxwell_slip+asymmetry"))
CHANGES = {
    "set": lambda told: told.__setitem__("F_C", 1.0),
    "delete": lambda told: told.__delitem__(next(iter(told))),
    "update": lambda told: told.update(F_C=1.0),
    "in place": lambda told: told.__ior__({"F_C": 1.0}),
    "default": lambda told: told.setdefault("F_C", 1.0),
    "pop": lambda told: told.pop(next(iter(told))),
    "pop one": lambda told: told.popitem(),
    "clear": lambda told: told.clear(),
}
TOLD = {
    "values": ELEMENTS.values,
    "variables": friction.lugre.variables,
    "variables of slots": with_slots(friction.lugre, list(SLOTS)).variables,
    "variables of leuven": friction.leuven.variables,
    "variables with presliding": with_presliding(friction.coulomb(F_C=1.0), 1e-6).component.variables,
    "example": friction.gms.example,
    "example of slots": with_slots(friction.lugre, ["periodic"]).example,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
@pytest.mark.parametrize("told", TOLD.values(), ids=TOLD)
def test_a_change_is_refused_and_says_what_to_do(told, change):
    before = list(told)
    with pytest.raises(TypeError, match=r"read-only.*dict\(\.\.\.\).*with_values"):
        change(told)
    assert list(told) == before


def test_numbers_inside_are_copies_that_nobody_writes_to():
    for held in (ELEMENTS.values["k_i"], ReadOnly({"k_i": ELEMENTS.parameters.forward.k_i})["k_i"]):
        assert not np.shares_memory(held, ELEMENTS.parameters.forward.k_i)
        with pytest.raises(ValueError, match="read-only"):
            held[0] = 1.0
    assert isinstance(hysteresis.everett_table.example["E"], tuple)


def test_with_values_is_the_way():
    model = plants.inertia(M=2.0)
    assert model.with_values(M=3.0).values == {"M": 3.0}
    assert model.values == {"M": 2.0}


def test_it_stays_a_dictionary():
    told = friction.lugre.example
    mine = told | {"F_C": 1.0}
    mine["F_S"] = 2.0
    assert type(mine) is type({"F_C": 1.0} | told) is type(told.copy()) is dict
    assert json.loads(json.dumps(told)) == told == dict(told)
    for other in (pickle.loads(pickle.dumps(told)), copy.deepcopy(told), copy.copy(told)):
        assert type(other) is ReadOnly
        assert other == told

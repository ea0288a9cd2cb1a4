"""What a model tells of itself cannot be changed by mistake, and is a dictionary to all who read it."""

import copy
import json
import pickle

import numpy as np
import pytest

from bristle import friction, hysteresis, plants
from bristle.contract import example_of
from bristle.core.read_only import ReadOnly
from bristle.models.friction import SLOTS, with_presliding, with_slots

ELEMENTS = example_of(friction.find("maxwell_slip+asymmetry"))
CHANGES = {
    "set": lambda reported: reported.__setitem__("F_C", 1.0),
    "delete": lambda reported: reported.__delitem__(next(iter(reported))),
    "update": lambda reported: reported.update(F_C=1.0),
    "in place": lambda reported: reported.__ior__({"F_C": 1.0}),
    "default": lambda reported: reported.setdefault("F_C", 1.0),
    "pop": lambda reported: reported.pop(next(iter(reported))),
    "pop one": lambda reported: reported.popitem(),
    "clear": lambda reported: reported.clear(),
}
TOLD = {
    "values": ELEMENTS.values,
    "variables": friction.lugre.variables,
    "variables of slots": with_slots(friction.lugre, list(SLOTS)).variables,
    "variables of leuven": friction.leuven.variables,
    "variables with presliding": with_presliding(
        friction.coulomb(F_C=1.0), 1e-6
    ).component.variables,
    "example": friction.gms.example,
    "example of slots": with_slots(friction.lugre, ["periodic"]).example,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
@pytest.mark.parametrize("message", TOLD.values(), ids=TOLD)
def test_a_change_is_refused_with_a_remedy(message, change):
    before = list(message)
    with pytest.raises(TypeError, match=r"read-only.*dict\(\.\.\.\).*with_values"):
        change(message)
    assert list(message) == before


def test_arrays_inside_are_read_only_copies():
    for fixed in (
        ELEMENTS.values["k_i"],
        ReadOnly({"k_i": ELEMENTS.parameters.forward.k_i})["k_i"],
    ):
        assert not np.shares_memory(fixed, ELEMENTS.parameters.forward.k_i)
        with pytest.raises(ValueError, match="read-only"):
            fixed[0] = 1.0
    assert isinstance(hysteresis.everett_table.example["E"], tuple)


def test_with_values_is_the_way():
    model = plants.inertia(M=2.0)
    assert model.with_values(M=3.0).values == {"M": 3.0}
    assert model.values == {"M": 2.0}


def test_it_stays_a_dictionary():
    message = friction.lugre.example
    mine = message | {"F_C": 1.0}
    mine["F_S"] = 2.0
    assert type(mine) is type({"F_C": 1.0} | message) is type(message.copy()) is dict
    assert json.loads(json.dumps(message)) == message == dict(message)
    for other in (pickle.loads(pickle.dumps(message)), copy.deepcopy(message), copy.copy(message)):
        assert type(other) is ReadOnly
        assert other == message

"""Models travel: whole, to the bit, and to the one component that there is in the other process."""

import copy
import json
import math
import pickle
import sys
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import pytest
from tests.core.elsewhere import in_a_new_process, there_and_back
from tests.core.same_bits import bits_of

import bristle as br
from bristle import controllers, friction, hysteresis, plants, references, sensors
from bristle.contract import example_of
from bristle.core import FrictionModel, InputError, Model, Variable
from bristle.core.cores import Abreast
from bristle.core.documented import whereabouts
from bristle.core.lazy import once
from bristle.engine import Contact, run_open_loop
from bristle.engine.screwed import through_screw
from bristle.files.user_model import load_code
from bristle.identification.fixed_shape import shaped
from bristle.models.friction import SLOTS, is_static, with_presliding, with_slots

PROTOCOLS = range(2, pickle.HIGHEST_PROTOCOL + 1)
COMPONENTS = [
    *friction.MODELS.values(),
    *hysteresis.OPERATORS.values(),
    *plants.PLANTS.values(),
    *controllers.CONTROLLERS.values(),
    *sensors.SENSORS.values(),
    *references.REFERENCES.values(),
]
# Every slot around every model, and each slot alone.
SLOTTED = [
    *(with_slots(model, list(SLOTS)) for model in friction.MODELS.values()),
    *(with_slots(friction.lugre, [slot]) for slot in SLOTS),
]
ELEMENTS = example_of(friction.maxwell_slip)


def copies_of(thing):
    """The thing by each way that it can go."""
    return [
        *(pickle.loads(pickle.dumps(thing, protocol)) for protocol in PROTOCOLS),
        copy.deepcopy(thing),
    ]


def model_of(component):
    """A model with the example parameters of a component, and some number for each that it gives none for."""
    present = {**component.defaults, **component.example}
    rest = [name for name in component.variables if name not in present]
    sample = {name: [0.1, 0.2, 0.3] if component.is_array(name) else 0.1 for name in rest}
    return component(validate=False, **component.example, **sample)


def name_of(component):
    return f"{component.family} {component.name}"


@pytest.mark.parametrize("component", [*COMPONENTS, *SLOTTED], ids=name_of)
def test_a_component_and_its_model_arrive_to_the_bit(component):
    assert [
        item for item in (*copies_of(component), copy.copy(component)) if item is not component
    ] == []
    model = model_of(component)
    for other in copies_of(model):
        assert other == model
        assert bits_of(other) == bits_of(model)


@pytest.mark.parametrize(
    "component",
    [
        item
        for item in (*COMPONENTS, *SLOTTED)
        if item.family == "friction" and is_static(model_of(item))
    ],
    ids=lambda component: component.name,
)
def test_unpickling_a_component_with_presliding_gives_the_same_object(component):
    model = with_presliding(model_of(component), 2e-6)
    assert model.component is not component
    for other in copies_of(model):
        assert bits_of(other) == bits_of(model)


def test_unpickling_derived_components_gives_the_same_object():
    screw, motor = plants.ball_screw, friction.coulomb(kind="rotational", F_C=0.02)
    behind = through_screw(
        screw(kind="rotational", **screw.example), motor, friction.viscous(F_v=3.0)
    )
    elements = example_of(friction.find("maxwell_slip+asymmetry"))
    fixed = shaped(elements.component, np.array([3.0, 1.0]), np.array([1.0, 1.0]))
    strange = {"F_C": -0.0, "F_S": -3.0, "v_S": -math.inf, "sigma_0": 5e-324, "offset": -0.0}
    unvalidated = friction.find("lugre")(kind="rotational", validate=False, **strange)
    for model in (behind, unvalidated, friction.unvaried(model_of(SLOTTED[-1]))):
        for other in copies_of(model):
            assert bits_of(other) == bits_of(model)
    # Shapes are made as the search goes, and none is ever looked for by identity.
    for other in copies_of(Model(fixed, elements.parameters)):
        assert bits_of(other.parameters) == bits_of(elements.parameters)
        assert bits_of(other.values) == bits_of(Model(fixed, elements.parameters).values)
        assert other.component == fixed


def test_a_changed_copy_of_a_component_is_not_replaced_by_its_source():
    other = replace(SLOTTED[0], description="changed")
    with pytest.raises(pickle.PicklingError, match="is not defined in a module"):
        pickle.dumps(other)


def test_a_pickled_contact_keeps_its_state():
    contact = Contact(ELEMENTS)
    contact.move(3e-6, 1e-6, 10)
    contact.move(-1e-6, 1e-6, 10)
    assert b"numba" not in pickle.dumps(contact)
    rest = copies_of(contact)
    expected = contact.move(5e-6, 1e-6, 50)
    for other in rest:
        assert np.array_equal(other.move(5e-6, 1e-6, 50), expected)
        assert other.x == contact.x


# --- another process --------------------------------------------------------------------------------------------

ARRIVALS = """
import json, pickle, sys
found = pickle.load(sys.stdin.buffer)
from bristle import controllers, friction, hysteresis, plants, references, sensors
known = [
    *friction.MODELS.values(), *hysteresis.OPERATORS.values(), *plants.PLANTS.values(),
    *controllers.CONTROLLERS.values(), *sensors.SENSORS.values(), *references.REFERENCES.values(),
]
known += [friction.with_slots(model, list(friction.SLOTS)) for model in friction.MODELS.values()]
known += [friction.with_slots(friction.lugre, [slot]) for slot in friction.SLOTS]
print(json.dumps([one is other for one, other in zip(found, known, strict=True)]))
"""


def test_each_component_unpickles_in_a_fresh_process():
    assert all(json.loads(in_a_new_process(ARRIVALS, pickle.dumps([*COMPONENTS, *SLOTTED]))))


def test_models_return_from_another_process_unchanged():
    models = [model_of(item) for item in (*COMPONENTS, *SLOTTED)]
    assert bits_of(there_and_back(models)) == bits_of(models)


# --- models of a user's own -------------------------------------------------------------------------------------

USER = """
from typing import Annotated, NamedTuple
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction

class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0, directional=True)] = 2.0

class State(NamedTuple):
    way: Annotated[float, Variable("length", "way that it has gone")] = 0.0

class Move(NamedTuple):
    way: float

@kernel
def trial(state, memory, motion, dt, p):
    return {factor} * p.F_C * direction(motion.v) * (1.0 + 1e3 * state.way), Move(state.way + abs(motion.v) * dt)

@kernel
def commit(state, memory, move, p):
    return State(move.way)

MODEL = FrictionModel(name="mine", description="mine", Parameters=Parameters, State=State, trial=trial, commit=commit)
"""

RUN = """
import json, pickle, sys
model, trace, x = pickle.load(sys.stdin.buffer)
import bristle as br
from bristle.models.friction import base_of
own = base_of(model.component)
again = pickle.loads(pickle.dumps(model)).component is model.component
force = br.response(model, x, 1e-3)
print(json.dumps([own.module, sys.modules[own.module].MODEL is own, again, trace.state.way, force.tolist()]))
"""


@pytest.fixture
def file(tmp_path):
    result = tmp_path / "mine.py"
    result.write_text(USER.format(factor=3.0))
    return result


@pytest.mark.slow
def test_a_user_model_is_pickled_with_its_source(file):
    component = load_code(file)
    model = with_slots(component, ["position", "asymmetry"])
    model = model(**(example_of(model).values | {"F_C_pos": 2.5, "F_C_neg": 1.5}))
    trace = run_open_loop(plants.inertia(M=1.0), component(), np.full(20, 1e4), 1e-3)
    x = 1e-3 * np.sin(np.linspace(0.0, 6.0, 50))
    for other in copies_of(model):
        assert bits_of(other) == bits_of(model)
    file.unlink()
    module, is_its_model, is_one, way, force = json.loads(
        in_a_new_process(RUN, pickle.dumps((model, trace, x)))
    )
    assert module == component.module
    assert is_its_model
    assert is_one
    assert way == trace.state.way > 0.0
    assert force == br.response(model, x, 1e-3).tolist()


def test_a_user_model_and_its_state_travel_without_its_file(file):
    component = load_code(file)
    model, state = component(F_C=2.5), sys.modules[component.module].State(0.25)
    file.write_text("edited since")
    assert bits_of(there_and_back([model, state])) == bits_of([model, state])
    for other in copies_of(model):
        assert bits_of(other) == bits_of(model)


def test_a_file_that_two_threads_load_is_run_once(file):
    file.write_text("import time\ntime.sleep(0.05)\n" + USER.format(factor=2.0))
    with Abreast(4) as pool:
        assert len({id(item) for item in pool.map(load_code, [file] * 4)}) == 1


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 1.0


def of_nobody(Parameters=Parameters):
    return FrictionModel(
        name="nobodys",
        description="made inside a function",
        Parameters=Parameters,
        State=friction.coulomb.State,
        trial=friction.coulomb.trial,
        commit=friction.coulomb.commit,
    )


HERE = of_nobody()
LIKE_LEUVEN = replace(friction.leuven, description="kept in another module than its parameters")


@pytest.mark.parametrize("component", [HERE, LIKE_LEUVEN], ids=name_of)
def test_a_component_in_a_module_is_found_by_import(component, monkeypatch):
    # A script or a session that has it under a name of its own is none that another process can import.
    monkeypatch.setattr(sys.modules["__main__"], "mine", component, raising=False)
    assert whereabouts(component)[0] == __name__
    assert [item for item in copies_of(component) if item is not component] == []


def test_each_of_bristles_own_is_found_where_it_is_defined():
    assert {whereabouts(component)[1] for component in COMPONENTS} == {"MODEL"}


def test_a_component_inside_a_function_is_refused_with_a_remedy():
    class Parameters(NamedTuple):
        F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 1.0

    component = of_nobody(Parameters)
    for thing in (component, component(), with_slots(component, [])(F_C=2.0)):
        with pytest.raises(
            pickle.PicklingError,
            match=r"friction nobodys: is not defined.* Define this model in a separate file",
        ):
            pickle.dumps(thing)
    assert copy.deepcopy(component) is copy.copy(component) is component
    assert copy.deepcopy(component()) == component()


def test_a_component_missing_in_the_other_process_is_refused_with_a_remedy():
    typed = (
        USER.format(factor=3.0)
        + "import pickle, sys; sys.stdout.buffer.write(pickle.dumps(MODEL()))"
    )
    sent = in_a_new_process(typed)
    with pytest.raises(
        pickle.UnpicklingError,
        match=r"__main__\.MODEL: does not exist .* Define this model in a separate file",
    ):
        pickle.loads(sent)


# --- what is told of models -------------------------------------------------------------------------------------


def test_a_factory_makes_the_same_component_for_all_threads():
    calls = []

    @once
    def slow(*arguments):
        calls.append(arguments)
        with Abreast(1) as pool:
            pool.submit(int).result()
        return object()

    with Abreast(8) as pool:
        made = list(pool.map(slow, [1, 2] * 8))
    assert sorted(calls) == [(1,), (2,)]
    assert len({id(item) for item in made}) == 2


def test_errors_keep_all_their_parts_when_pickled():
    error = InputError(
        "out of range", path="friction.F_C", value=-1.0, allowed=">= 0 N", mend="Raise it"
    )
    for other in copies_of(error):
        assert (str(other), vars(other)) == (str(error), vars(error))

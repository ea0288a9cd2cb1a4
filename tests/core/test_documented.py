"""What is shown at the prompt: docstring and signature of a component, its parameters, short lists of names."""

import inspect
import pydoc
import sys

import pytest

import bristle as br
from bristle import controllers, friction, hysteresis, plants, references, sensors
from bristle.core import FrictionModel, Model
from bristle.files.user_model import load_code

FAMILIES = {
    friction: friction.MODELS,
    hysteresis: hysteresis.OPERATORS,
    plants: plants.PLANTS,
    controllers: controllers.CONTROLLERS,
    sensors: sensors.SENSORS,
    references: references.REFERENCES,
}
COMPONENTS = [member for members in FAMILIES.values() for member in members.values()]
SLOTTED = [
    friction.find("lugre+asymmetry+position"),
    friction.find("gms+load"),
    friction.find("stribeck+asymmetry"),
]
EVERY = pytest.mark.parametrize(
    "component", [*COMPONENTS, *SLOTTED], ids=lambda member: f"{member.family} {member.name}"
)
LUGRE = {"F_C": 20.0, "F_S": 28.0, "v_S": 2e-3, "sigma_0": 1e7}


def section_of(text, head):
    return text.split(f"\n{head}\n{'-' * len(head)}\n")[1].split("\n\n")[0]


@EVERY
def test_the_help_has_equations_and_parameters_with_unit_and_range(component):
    shown = pydoc.render_doc(component, renderer=pydoc.plaintext)
    assert all(line.split()[0] in shown for line in component.equations)
    message = section_of(component.__doc__, "Parameters")
    for name, variable in component.variables.items():
        line, text = message.split(f"\n{name} : ")[-1].removeprefix(f"{name} : ").splitlines()[:2]
        assert variable.description in text
        assert all(
            f"{variable.unit(kind)}" in line
            for kind in br.core.variable.KINDS
            if variable.unit(kind) != "1"
        )
        assert ("default" in line) == (name in component.defaults)
        if variable.min == 0.0 and variable.max == float("inf"):
            assert ">= 0" in text
    for relation in component.relations:
        assert relation.condition in section_of(component.__doc__, "Notes")


@pytest.mark.parametrize(
    "component", COMPONENTS, ids=lambda member: f"{member.family} {member.name}"
)
def test_the_help_begins_like_the_docstring_of_the_file(component):
    file = f"bristle.models.friction.{component.name}"  # a model may have the parameters of another
    home = sys.modules.get(file) or inspect.getmodule(component.Parameters)
    first = home.__doc__.splitlines()[0]
    assert (
        " ".join(component.__doc__.split())
        .replace("`", "")
        .startswith(first.split(":")[0].replace("`", ""))
    )


@EVERY
def test_the_signature_matches_the_call(component):
    parameters = inspect.signature(component).parameters
    assert list(parameters) == [*component.variables, "kind", "validate"]
    assert {
        name for name, parameter in parameters.items() if parameter.default is parameter.empty
    } == {name for name in component.variables if name not in component.defaults}
    assert all(parameter.kind is parameter.KEYWORD_ONLY for parameter in parameters.values())


@pytest.mark.parametrize(
    ("component", "text"),
    [
        (friction.lugre, "F_C: 'N or N*m', "),
        (friction.lugre, "sigma_1: 'N*s/m or N*m*s/rad' = 0.0"),
        (friction.gms, "k_i: 'a list, N/m or N*m/rad'"),
    ],
)
def test_the_signature_has_units_and_defaults(component, text):
    assert text in str(inspect.signature(component))


@pytest.mark.parametrize(
    "component", [member for member in COMPONENTS if member.example], ids=lambda member: member.name
)
def test_the_example_can_be_typed(component):
    line = section_of(component.__doc__, "Examples").removeprefix(">>> model = ")
    assert isinstance(eval(line, {component.name: component}), Model)


def test_a_class_keeps_its_own_docstring_and_signature():
    assert FrictionModel.__doc__.startswith("A friction model.")
    assert list(inspect.signature(FrictionModel).parameters)[:2] == ["name", "description"]
    assert "trial(state, memory, motion, dt, p)" in pydoc.render_doc(FrictionModel)


def test_a_component_is_shown_in_a_line():
    assert repr(plants.inertia) == "<plant inertia(M)>"
    assert (
        repr(friction.lugre)
        == "<friction lugre(F_C, F_S, v_S, sigma_0, sigma_1=0, sigma_2=0, v_d=inf)>"
    )
    assert max(len(repr(component)) for component in COMPONENTS) < 300


OWN = r'''r"""Mine: a drag.

.. math:: F = q\,v^2
"""
from typing import Annotated, NamedTuple
from bristle.core import FrictionModel, Variable, kernel

class Parameters(NamedTuple):
    q: Annotated[float, Variable("force", "drag", min=0.0)]

class State(NamedTuple):
    pass

class Move(NamedTuple):
    pass

@kernel
def trial(state, memory, motion, dt, p):
    return p.q * motion.v * abs(motion.v), Move()

@kernel
def commit(state, memory, move, p):
    return State()

MODEL = FrictionModel(name="drag", description="mine", Parameters=Parameters, State=State, trial=trial, commit=commit)
'''


def test_a_user_model_is_explained_by_its_file(tmp_path):
    (tmp_path / "drag.py").write_text(OWN)
    component = load_code(tmp_path / "drag.py")
    assert component.equations == ("F = q v²",)
    assert component.__doc__.startswith("Mine: a drag.\n\n    F = q v²\n\nParameters\n")
    (tmp_path / "bare.py").write_text(OWN.split('"""\n')[1])
    assert load_code(tmp_path / "bare.py").__doc__.startswith("mine\n\nParameters\n")


# --- parameters as attributes -----------------------------------------------------------------------------------


def test_a_parameter_is_an_attribute():
    model = friction.find("lugre+asymmetry")(
        F_C_pos=20.0, F_C_neg=18.0, F_S_pos=28.0, F_S_neg=27.0, v_S=2e-3, sigma_0="10 N/um"
    )
    assert (model.F_C_neg, model.sigma_0, model.offset) == (18.0, 1e7, 0.0)
    assert plants.inertia(M=3.0).M == 3.0
    assert list(friction.maxwell_slip(F_C=1.0, k_i=[3.0, 4.0], nu_i=[0.5, 0.5]).k_i) == [3.0, 4.0]


def test_completion_lists_the_parameters():
    assert {"F_C", "sigma_0", "v_d", "values", "with_values"} <= set(dir(friction.lugre(**LUGRE)))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("F_c", r"lugre has no parameter 'F_c'\. Did you mean 'F_C'\?"),
        ("quite_another", "It has F_C, F_S, v_S"),
        # What a notebook looks for is no parameter that was misspelt.
        ("_repr_png_", "'Model' object has no attribute '_repr_png_'"),
        ("__array__", "'Model' object has no attribute '__array__'"),
    ],
)
def test_an_unknown_attribute_suggests_a_parameter(name, words):
    with pytest.raises(AttributeError, match=words):
        getattr(friction.lugre(**LUGRE), name)


def test_a_parameter_cannot_be_set():
    model = friction.lugre(**LUGRE)
    with pytest.raises(AttributeError):
        model.F_C = 3.0


def test_parameters_do_not_collide_with_attributes_of_models():
    custom = {name for name in dir(Model) if not name.startswith("_")} | {
        "component",
        "parameters",
        "kind",
    }
    assert [item.name for item in [*COMPONENTS, *SLOTTED] if custom & set(item.variables)] == []


@pytest.mark.parametrize("family", FAMILIES, ids=lambda member: member.__name__)
def test_completion_shows_only_public_attributes(family):
    shown = set(dir(family))
    assert set(FAMILIES[family]) <= shown
    assert all(callable(getattr(family, name)) for name in shown)
    assert not any(name.isupper() for name in shown)
    made = shown - set(FAMILIES[friction])
    if family is friction:
        assert made == {"find", "with_slots", "with_presliding"}


def test_channels_that_a_model_needs_are_those_that_a_log_records():
    assert [channel.name for channel in friction.find("lugre+load").channels_needed] == ["load"]
    # Found from effort and motion.
    assert friction.find("coulomb_viscous+transmitted").channels_needed == []
    assert friction.lugre.channels_needed == []


def test_enclosed_parameters_keep_their_type():
    varied = friction.find("leuven+position")
    assert [name for name in varied.variables if varied.is_integer(name)] == ["kernel", "capacity"]
    assert not varied.is_integer("no such name")
    listed = friction.find("maxwell_slip+load")
    assert [name for name in listed.variables if listed.is_array(name)] == ["k_i", "nu_i"]
    assert not listed.is_array("no such name")

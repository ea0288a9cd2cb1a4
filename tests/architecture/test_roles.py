"""Identification knows parameters by what they are, not by their names: a model that is added needs no line there."""

import ast
from pathlib import Path

import bristle
from bristle.core.variable import EXCITATIONS
from bristle.models.friction import MODELS, find
from bristle.models.friction.slots import SLOTS
from bristle.models.plants import PLANTS

ROOT = Path(bristle.__file__).parent / "identification"
# Where names are meant: the models of elements and their lists, and the one model that is fitted to every log first.
ALLOWED = {
    "identify.py": {"lugre"},  # tells a filtered position from a command that acts late
    "request.py": {"offset"},  # an argument of identify
    "axis_lines.py": {"offset", "lead"},  # keys of an axis file
    "missing_force.py": {"share"},  # field of a force
    "estimation.py": {"coulomb_viscous", "F_C", "F_v"},
    "fixed_shape.py": {"k_i", "nu_i", "s"},
    "element_models.py": {"F_C"},
    "stribeck_element_models.py": {"F_C", "F_S", "C", "v_S"},
    # Groups of the dictionary, and the numbers of its result.
    "dictionary.py": {"offset", "viscous", "dahl", "inertia"},
    "term_search.py": {"offset", "inertia", "viscous"},
    "friction_law.py": {"offset", "viscous", "inertia"},
    "explain.py": {"offset", "coulomb", "viscous", "dahl"},
    "explanation.py": {"offset", "coulomb", "viscous", "inertia", "share", "M", "F_C", "F_v"},
}


OTHER = {"s", "seed"}  # a second, the seed of a search


def names_of_models_and_parameters():
    slots = "".join(f"+{slot}" for slot in SLOTS)
    result = set(MODELS)
    for model in MODELS:
        result |= {*find(model).variables, *find(model + slots).variables}
    for name, plant in PLANTS.items():
        result |= {name, *plant.variables}
    return result - set(EXCITATIONS)  # these are words for what a log contains


def literals_of(path):
    return {
        node.value
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


def test_identification_names_no_model_and_no_parameter():
    names = names_of_models_and_parameters()
    assert {"F_C", "sigma_0", "M", "k", "offset", "x_0", "c_1_pos", "lugre"} <= names
    result = {
        path.relative_to(ROOT).as_posix(): spelled
        for path in sorted(ROOT.rglob("*.py"))
        if "hysteresis" not in path.parts  # an operator is identified by its own parameters
        if (spelled := (literals_of(path) & names) - OTHER - ALLOWED.get(path.name, set()))
    }
    assert result == {}


def test_allowed_roles_are_needed():
    for name, allowed in ALLOWED.items():
        assert allowed <= literals_of(ROOT / name), name

"""Names of a person's own model that are words, macros or twins elsewhere: valid text there, with the same bits."""

import re
import subprocess
import zipfile

import pytest
from tests.exports.importing import needs_compiler
from tests.exports.native import COMPILER, FLAGS, WARNINGS, compiled

import bristle as br
from bristle.exports import fmu
from bristle.exports.c import builds
from bristle.exports.c_code import Names
from bristle.exports.st import write
from bristle.exports.targets import Request
from bristle.files.user_model import load_code
from bristle.testing import example_of

HEADERS = ("stddef", "stdint", "float", "math", "stdbool", "stdlib", "string")
TEXT = """
from typing import Annotated, NamedTuple
import numpy as np
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp


class Parameters(NamedTuple):
    int: Annotated[float, Variable("force", "Coulomb friction force", min=1e-9, excitation="sliding")]
    Int: Annotated[float, Variable("force", "what is added", min=0.0)]
    INT: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    int_: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    NULL: Annotated[float, Variable("length", "distance", min=1e-9)]
    double: Annotated[np.ndarray, Variable("force/length", "stiffness", min=1e-9)]
    parameters: Annotated[np.ndarray, Variable("force/length", "stiffness", min=1e-9)]
    memory: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    For: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    NAN: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    DBL_MAX: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    linux: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    constructor: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]
    μ: Annotated[float, Variable("1", "share", min=0.0, max=1.0)]


class State(NamedTuple):
    struct: Annotated[float, Variable("length", "a state")] = 0.0
    STRUCT: Annotated[float, Variable("length", "another one")] = 0.0
    union: Annotated[int, Variable("1", "turns")] = 0


class Bits(NamedTuple):
    auto: float
    AUTO: float


@kernel
def typedef(double, Double, p):
    goto = double + Double
    GOTO = goto * p.NAN + p.double[0] * p.NULL * 1e-3 + p.parameters[1] * p.NULL * 1e-4
    own_typedef = p.memory * p.For * p.DBL_MAX * p.linux
    return GOTO * p.INT + p.int_ * own_typedef * p.constructor * p.μ


@kernel
def trial(state, memory, motion, dt, p):
    dx = motion.v * dt
    register = direction(motion.v)
    own_typedef = typedef(state.struct, state.STRUCT, p) + memory[0]
    return register * (p.int + p.Int + own_typedef) * (1.0 - exp(-abs(dx) / p.NULL)), Bits(dx, register)


@kernel
def commit(state, memory, move, p):
    memory[0] = 0.5 * memory[0] + 1e-3 * move.AUTO
    return State(0.9 * state.struct + move.auto, 0.5 * state.STRUCT - move.auto, state.union + int(move.AUTO > 0.0))


MODEL = FrictionModel(
    name="odd", description="words of languages as names", Parameters=Parameters, State=State, trial=trial,
    commit=commit, memory_size=lambda p: 1,
    example={
        "int": 5.0, "Int": 0.5, "INT": 0.25, "int_": 0.75, "NULL": 1e-6, "double": [1e5, 2e5],
        "parameters": [3e5, 4e5], "memory": 0.5, "For": 0.375, "NAN": 0.25, "DBL_MAX": 0.125, "linux": 0.625,
        "constructor": 0.875, "μ": 0.9,
    },
)
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    file = tmp_path_factory.mktemp("own") / "odd.py"
    file.write_text(TEXT, encoding="utf-8")
    return example_of(load_code(file))


@needs_compiler
@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_tunable_c_compiles_as_c_and_as_cpp(model, tmp_path, standard):
    br.export(model, "c", tmp_path / "out", tunable=True, float32=True)
    main = ("axis_x.c", "axis_x_selftest.c")
    compiled(tmp_path / "out", f"-std={standard}", "-ffp-contract=off", *WARNINGS, *main, "-o", "program", "-lm")
    assert subprocess.run(["./program"], cwd=tmp_path / "out", check=False).returncode == 0
    if builds("c++"):
        (tmp_path / "out" / "use.cpp").write_text('#include "axis_x.h"\n')
        compiled(tmp_path / "out", "-fsyntax-only", "-Wall", "-Wextra", "-Werror", "use.cpp", compiler="c++")


@needs_compiler
def test_the_fmu_compiles_without_a_warning(model, tmp_path, monkeypatch):
    monkeypatch.setattr(fmu, "zig", list)
    monkeypatch.setattr(fmu, "compiler", lambda: None)
    br.export(model, "fmu3", tmp_path / "out", plant=br.plants.inertia(M=2.0))
    with zipfile.ZipFile(tmp_path / "out" / "axis_x_mass.fmu") as archive:
        archive.extractall(tmp_path / "fmu")
    compiled(tmp_path / "fmu" / "sources", "-fsyntax-only", *FLAGS, *WARNINGS, "axis_x_mass.c")


def test_each_parameter_is_an_input_of_structured_text(model):
    text = write(Request(model, "axis_x", 1e-3, tunable=True)).files["axis_x.st"]
    inputs = re.search(r"FUNCTION_BLOCK axis_x\nVAR_INPUT\n(.*?)END_VAR", text, flags=re.DOTALL)[1]
    names = [line.split(" : ")[0].strip().lower() for line in inputs.splitlines()]
    assert len(set(names)) == len(names) == 2 + 12 + 4 + 2  # motion, numbers, two pairs, restart and clear


@needs_compiler
@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_no_variable_has_the_name_of_a_macro_of_the_headers(tmp_path, standard):
    includes = "".join(f"#include <{header}.h>\n" for header in HEADERS)
    ran = subprocess.run(
        [COMPILER, f"-std={standard}", "-dM", "-E", "-xc", "-"], input=includes, capture_output=True, text=True, check=True
    )
    macros = re.findall(r"^#define ([A-Za-z]\w*) ", ran.stdout, flags=re.MULTILINE)
    assert {"NULL", "INT32_MAX", "NAN"} <= set(macros)
    names = Names([])
    assert [name for name in macros if names.variable(name) == name] == []


def test_names_of_friction_are_unchanged_and_different_names_stay_different():
    names = Names([], ["own_spread"])
    for name in ("F_C", "K_1", "M_1", "INTERCEPT", "v_S", "sigma_0", "dt", "M_pos"):
        assert names.variable(name) == name
    odd = ("int", "int_", "int__", "Int", "INT", "NULL", "NULL_", "own_spread")
    assert len({names.variable(name) for name in odd}) == len(odd)


LOCALS = ["axis", "x", "dt", "i", "state", "velocity", "position", "force", "hashed", "lugre_trial"]


@needs_compiler
@pytest.mark.parametrize("name", LOCALS)
def test_the_name_of_an_export_may_be_that_of_a_variable(tmp_path, name):
    lugre = br.friction.lugre(F_C=5.0, F_S=6.0, v_S=1e-2, sigma_0=1e5)
    br.export(lugre, "c", tmp_path / "out", name=name, tunable=True)
    compiled(tmp_path / "out", "-fsyntax-only", *FLAGS, *WARNINGS, f"{name}.c", f"{name}_selftest.c", "example_main.c")
    header = (tmp_path / "out" / f"{name}.h").read_text()
    assert "    double position; /*" in header
    assert f"}} {name};" in header

"""Models of a person's own: every construct and any name gives the same bits in every language, or is refused."""

import json
import re
import shutil
import subprocess
import zipfile

import numpy as np
import pytest
from tests.exports.importing import needs_compiler
from tests.exports.native import (
    COMPILER,
    FLAGS,
    WARNINGS,
    Native,
    compiled,
    differing,
    in_structured_text,
    texts_of,
    walk,
)

import bristle as br
from bristle.apps.targets import fmu
from bristle.apps.targets.st import write
from bristle.contract import example_of
from bristle.engine.translation.scope import NotExportableError
from bristle.exports.c import builds
from bristle.exports.c_code import Names
from bristle.exports.described import Request
from bristle.exports.subject import subject_of

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
    return example_of(br.load_code(file))


@needs_compiler
@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_tunable_c_compiles_as_c_and_as_cpp(model, tmp_path, standard):
    br.export(model, "c", tmp_path / "out", tunable=True, float32=True)
    main = ("axis_x.c", "axis_x_selftest.c")
    compiled(
        tmp_path / "out",
        f"-std={standard}",
        "-ffp-contract=off",
        *WARNINGS,
        *main,
        "-o",
        "program",
        "-lm",
    )
    assert subprocess.run(["./program"], cwd=tmp_path / "out", check=False).returncode == 0
    if builds("c++"):
        (tmp_path / "out" / "use.cpp").write_text('#include "axis_x.h"\n')
        compiled(
            tmp_path / "out",
            "-fsyntax-only",
            "-Wall",
            "-Wextra",
            "-Werror",
            "use.cpp",
            compiler="c++",
        )


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
    # Motion, numbers, two pairs, restart and clear, and the share of the feed.
    assert len(set(names)) == len(names) == 2 + 12 + 4 + 2 + 3


@needs_compiler
@pytest.mark.parametrize("standard", ["c99", "gnu17"])
def test_no_variable_has_the_name_of_a_macro_of_the_headers(tmp_path, standard):
    includes = "".join(f"#include <{header}.h>\n" for header in HEADERS)
    ran = subprocess.run(
        [COMPILER, f"-std={standard}", "-dM", "-E", "-xc", "-"],
        input=includes,
        capture_output=True,
        text=True,
        check=True,
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
    compiled(
        tmp_path / "out",
        "-fsyntax-only",
        *FLAGS,
        *WARNINGS,
        f"{name}.c",
        f"{name}_selftest.c",
        "example_main.c",
    )
    header = (tmp_path / "out" / f"{name}.h").read_text()
    assert "    double position; /*" in header
    assert f"}} {name};" in header


DT = 1e-3
HEAD = """
import math
from typing import Annotated, NamedTuple
import numpy as np
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction, exp

LAYERS = 3


class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=1e-9, excitation="sliding")]
    k_i: Annotated[np.ndarray, Variable("force/length", "stiffness of each layer", min=1e-9)]
    times: Annotated[int, Variable("1", "rounds", min=1, max=9)] = 2


class State(NamedTuple):
    wear: Annotated[float, Variable("1", "what is worn")] = 0.0
    turns: Annotated[int, Variable("1", "reversals so far", min=0)] = 0


class Move(NamedTuple):
    dx: float
    side: float


@kernel
def spread(memory, dx, p):
    low, high = 0.0, p.F_C
    if dx < 0.0:
        low, high = -high, low
    for i in range(LAYERS):
        low, high = min(low, memory[i] + dx), max(high, memory[i])
        if i > 4:
            break
    return low, high
"""
TRIAL = """

@kernel
def trial(state, memory, motion, dt, p):
    dx = motion.v * dt
    low, high = spread(memory, dx, p)
    total = 0
    k = 0
    while k < p.times:
        total += abs(high - low) * (1.0 - exp(-k)) + p.k_i[k % LAYERS] * 1e-6
        k += 1
    rough = -1 if state.turns % 2 == 1 and not state.wear > 3.0 else 1
    side = direction(motion.v)
    return side * (p.F_C + 0.01 * total) + 0.1 * rough * side, Move(dx, side)


@kernel
def commit(state, memory, move, p):
    memory[0], memory[1] = memory[1], move.dx + 0.5 * memory[0]
    for i in range(LAYERS - 1):
        memory[i + 1] -= 0.25 * memory[i]
    turned = int(memory[3] * move.side < 0.0)
    memory[3] = move.side
    return State(min(state.wear + abs(move.dx), 10.0), state.turns + turned)


MODEL = FrictionModel(
    name="layers", description="made to use all that a kernel may", Parameters=Parameters, State=State, trial=trial,
    commit=commit, memory_size=lambda p: 4, example={"F_C": 5.0, "k_i": [1e5, 2e5, 3e5], "times": 4},
)
"""


def model_of(text, folder):
    (folder / "layers.py").write_text(text)
    return example_of(br.load_code(folder / "layers.py"))


# All that a kernel may, without a remainder of whole numbers, which WebAssembly lacks, and with names that are words elsewhere.
OWN = {
    "all": HEAD + TRIAL,
    "most": HEAD
    + TRIAL.replace("k % LAYERS", "min(k, 2)").replace("state.turns % 2 == 1", "state.turns > 3"),
    "twins": (HEAD + TRIAL).replace("spread", "force"),
    "odd": TEXT,
}


@pytest.fixture
def own(request, tmp_path):
    """Return a model of a person's own, positions, and the forces of plain Python there."""
    model, x = model_of(OWN[request.param], tmp_path), walk(2000, seed=5)
    with br.engine.interpreted():
        forces = br.response(model, x, DT)
    assert len(np.unique(forces)) > 500
    return model, x, forces


@needs_compiler
@pytest.mark.parametrize(
    ("own", "tunable"),
    [("all", False), ("twins", False), ("odd", False), ("odd", True)],
    indirect=["own"],
)
def test_an_own_model_is_identical_in_c(own, tunable, tmp_path):
    model, x, forces = own
    watching = ("-fsanitize=undefined", "-fno-sanitize-recover")
    native = Native(
        {"own": model},
        tmp_path / "c",
        more=watching if builds(COMPILER, *watching) else (),
        tunable=tunable,
    )
    assert differing(native.forces("own", x, DT), forces) == 0


PARAMETERS = """
import { load } from "./own/axis_x.mjs";
const axis = await load();
axis.set(process.argv[2], 0.125);
console.log(JSON.stringify(Object.fromEntries(axis.parameters.map((name) => [name, axis.get(name)]))));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
@pytest.mark.parametrize(("own", "changed"), [("most", "F_C"), ("odd", "Int")], indirect=["own"])
def test_an_own_model_is_identical_in_webassembly_with_each_parameter(own, changed, tmp_path):
    from tests.apps.targets.test_wasm import RUN, node

    model, x, forces = own
    x.tofile(tmp_path / "x.bin")
    br.export(model, "wasm", tmp_path / "own")
    node(tmp_path, RUN.replace("5e-4", repr(DT)), "own")
    assert differing(np.fromfile(tmp_path / "own.bin"), forces) == 0
    values = json.loads(node(tmp_path, PARAMETERS, changed))
    numbers = {
        name: value.tolist() if hasattr(value, "tolist") else value
        for name, value in model.values.items()
        if name in values
    }
    assert values == numbers | {changed: 0.125}


@needs_compiler
@pytest.mark.parametrize("own", ["all", "odd"], indirect=True)
def test_an_own_model_is_identical_in_structured_text(own, tmp_path):
    model, x, forces = own
    block = in_structured_text({"own": texts_of(model, tmp_path, "own")}, tmp_path / "block")
    assert differing(block.run("own", x, DT)[0], forces) == 0
    assert block.selftest("own") == (True, True)


@pytest.mark.parametrize(
    ("seen", "instead", "reason"),
    [
        ("exp(-k)", "math.exp(-k)", "math.exp may raise"),
        ("exp(-k)", "k ** 0.5", r"\*\* differs between targets"),
        ("total = 0\n", "memory[0] = 1.0\n    total = 0\n", "only commit may write to memory"),
        ("k = 0\n", "k = [0][0]\n", "List is outside the exportable subset"),
        ("LAYERS = 3", "LAYERS = [3]", "LAYERS is a mutable global"),
        ("not state.wear > 3.0", "state.wear", "the operands of and, or must be true or false"),
        (
            "if i > 4:",
            "if i > 4:\n            continue\n    if i > 4:\n        for i in range(2):",
            "is read outside its loop",
        ),
        ("return low, high", "if low < high:\n        return low, high", "on every path"),
        ("state.turns + turned", "state.wear", "a value is a number, but must be a whole number"),
        ("p.times:", "p.wrong:", "a Parameters has no field 'wrong'"),
        (
            "spread(memory, dx, p)\n    total",
            "spread(memory, dx=dx, p=p)\n    total",
            "passed by position",
        ),
        (
            "low, high = min(low",
            "low, high = spread(memory, dx, p)\n        low, high = min(low",
            "calls itself",
        ),
    ],
)
def test_unexportable_kernels_are_refused(seen, instead, reason, tmp_path):
    changed = (HEAD + TRIAL).replace(seen, instead)
    assert changed != HEAD + TRIAL
    model = model_of(changed, tmp_path)
    with pytest.raises(NotExportableError, match=reason) as refusal:
        subject_of(model)
    file, place = refusal.value.path.split(", ")
    assert file == "layers.py"
    if seen == "exp(-k)":
        assert instead in changed.splitlines()[int(place.removeprefix("line ")) - 1]

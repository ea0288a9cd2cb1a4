"""A model of a person's own leaves as ours do; what cannot leave is refused by file, line and reason."""

import json
import shutil

import numpy as np
import pytest
from tests.exports.importing import needs_compiler
from tests.exports.native import COMPILER, Native, differing, walk
from tests.exports.test_names import TEXT

import bristle as br
from bristle.engine import interpreted
from bristle.exports.c import builds
from bristle.exports.subject import subject_of
from bristle.files.user_model import load_code
from bristle.testing import example_of
from bristle.translation.scope import NotExportableError

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
    return example_of(load_code(folder / "layers.py"))


# All that a kernel may, without a remainder of whole numbers, which WebAssembly lacks, and with names that are words elsewhere.
OWN = {
    "all": HEAD + TRIAL,
    "most": HEAD + TRIAL.replace("k % LAYERS", "min(k, 2)").replace("state.turns % 2 == 1", "state.turns > 3"),
    "twins": (HEAD + TRIAL).replace("spread", "force"),
    "odd": TEXT,
}


@pytest.fixture
def own(request, tmp_path):
    """Return a model of a person's own, positions, and the forces of plain Python there."""
    model, x = model_of(OWN[request.param], tmp_path), walk(2000, seed=5)
    with interpreted():
        forces = br.response(model, x, DT)
    assert len(np.unique(forces)) > 500
    return model, x, forces


@needs_compiler
@pytest.mark.parametrize(("own", "tunable"), [("all", False), ("twins", False), ("odd", False), ("odd", True)], indirect=["own"])
def test_an_own_model_is_identical_in_c(own, tunable, tmp_path):
    model, x, forces = own
    watching = ("-fsanitize=undefined", "-fno-sanitize-recover")
    native = Native({"own": model}, tmp_path / "c", more=watching if builds(COMPILER, *watching) else (), tunable=tunable)
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
    from tests.exports.test_wasm import RUN, node

    model, x, forces = own
    x.tofile(tmp_path / "x.bin")
    br.export(model, "wasm", tmp_path / "own")
    node(tmp_path, RUN.replace("5e-4", repr(DT)), "own")
    assert differing(np.fromfile(tmp_path / "own.bin"), forces) == 0
    values = json.loads(node(tmp_path, PARAMETERS, changed))
    numbers = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in model.values.items() if name in values}
    assert values == numbers | {changed: 0.125}


@needs_compiler
@pytest.mark.parametrize("own", ["all", "odd"], indirect=True)
def test_an_own_model_is_identical_in_structured_text(own, tmp_path):
    pytest.importorskip("tree_sitter_iec61131_3_st", reason="needs the grammar of Structured Text for tree-sitter")
    from tests.exports.structured_text import StructuredText

    model, x, forces = own
    br.export(model, "st", tmp_path / "own", name="own")
    texts = [(tmp_path / "own" / f"own{end}.st").read_text(encoding="ascii") for end in ("", "_selftest")]
    block = StructuredText({"own": texts}, tmp_path / "block")
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
        ("if i > 4:", "if i > 4:\n            continue\n    if i > 4:\n        for i in range(2):", "is read outside its loop"),
        ("return low, high", "if low < high:\n        return low, high", "on every path"),
        ("state.turns + turned", "state.wear", "a value is a number, but must be a whole number"),
        ("p.times:", "p.wrong:", "a Parameters has no field 'wrong'"),
        ("spread(memory, dx, p)", "spread(memory, dx=dx, p=p)", "passed by position"),
        ("low, high = min(low", "low, high = spread(memory, dx, p)\n        low, high = min(low", "calls itself"),
    ],
)
def test_unexportable_kernels_are_refused(seen, instead, reason, tmp_path):
    text = HEAD + TRIAL
    assert seen in text
    if seen == "spread(memory, dx, p)":
        head, tail = text.split("def trial", 1)
        changed = head + "def trial" + tail.replace(seen, instead)
    else:
        changed = text.replace(seen, instead)
    model = model_of(changed, tmp_path)
    with pytest.raises(NotExportableError, match=reason) as refusal:
        subject_of(model)
    file, place = refusal.value.path.split(", ")
    assert file == "layers.py"
    if seen == "exp(-k)":
        assert instead in changed.splitlines()[int(place.removeprefix("line ")) - 1]

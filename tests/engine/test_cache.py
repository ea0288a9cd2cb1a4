"""The cache: fast in a second process, never stale, and nobody's model harms another process."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bristle
from bristle.core.fingerprint import fingerprint
from bristle.engine.signature import compiled_signature, handed_over

PACKAGE = Path(bristle.__file__).parent

PROBE = """
import json, sys
import numpy as np
from bristle import friction
from bristle.engine import compilation, force_along
if len(sys.argv) > 1:
    from bristle.files.user_model import load_code
    from bristle.contract import example_of
    model = example_of(load_code(sys.argv[1]))
else:
    model = friction.lugre(F_C=1.0, F_S=1.5, v_S=1e-3, sigma_0=1e5)
force = force_along(model, np.full(50, 2e-3), 1e-2)
print(json.dumps([float(force[-1]), len(compilation._compiled)]))
"""

USER = """
from typing import Annotated, NamedTuple
from bristle.core import FrictionModel, Variable, kernel
from bristle.core.mathematics import direction
from {helper} import LEVEL

class Parameters(NamedTuple):
    F_C: Annotated[float, Variable("force", "Coulomb friction force", min=0.0)] = 2.0

class State(NamedTuple):
    pass

class Move(NamedTuple):
    pass

@kernel
def trial(state, memory, motion, dt, p):
    return p.F_C * direction(motion.v) * {factor}, Move()

@kernel
def commit(state, memory, move, p):
    return state

MODEL = FrictionModel(name="mine", description="mine", Parameters=Parameters, State=State, trial=trial, commit=commit)
"""


@pytest.fixture
def probe(tmp_path):
    def run(*arguments, **environment):
        settings = os.environ | {
            "BRISTLE_CACHE_DIR": str(tmp_path / "cache"),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        settings.pop("NUMBA_DISABLE_JIT", None)
        done = subprocess.run(
            [sys.executable, "-c", PROBE, *map(str, arguments)],
            env=settings | environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        force, compiled = json.loads(done.stdout)
        return force, compiled

    return run


@pytest.mark.slow
def test_a_second_process_does_not_compile(probe):
    first, compiled = probe()
    again, compiled_again = probe()
    assert compiled == 1
    assert compiled_again == 0
    assert first == again


@pytest.mark.slow
def test_invalid_settings_of_the_compiler_are_reported(tmp_path):
    ended = subprocess.run(
        [
            sys.executable,
            "-c",
            "from bristle.cli.main import main; raise SystemExit(main(['paper', '--figure', '3']))",
        ],
        env=os.environ | {"NUMBA_NUM_THREADS": "0", "BRISTLE_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert ended.returncode == 2, ended.stderr
    assert "numba: cannot be loaded (" in ended.stderr
    assert "NUMBA_" in ended.stderr


@pytest.mark.slow
def test_an_edited_source_of_bristle_never_returns_an_old_number(probe, tmp_path):
    before, _ = probe()
    copy = tmp_path / "copy" / "bristle"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    # A function two calls away from the entry, and a number in it.
    source = copy / "models" / "friction" / "lugre.py"
    text = source.read_text()
    edited = text.replace(
        "return p.F_C + (p.F_S - p.F_C) *", "return p.F_C + 2.0 * (p.F_S - p.F_C) *"
    )
    assert edited != text
    source.write_text(edited)
    after, compiled = probe(PYTHONPATH=str(copy.parent))
    assert compiled == 1
    G = 1.0 + 0.5 * np.exp(-4.0)
    assert before == pytest.approx(G, rel=1e-9)
    assert after == pytest.approx(G + 0.5 * np.exp(-4.0), rel=1e-9)
    assert probe()[0] == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "name", "old", "new", "forces"),
    [
        ("3.0", "my_model.py", "3.0", "5.0", (6.0, 10.0)),
        ("LEVEL", "levels.py", "10.0", "11.0", (20.0, 22.0)),
    ],
)
def test_an_edited_file_of_a_user_never_returns_an_old_number(
    probe, tmp_path, factor, name, old, new, forces
):
    (tmp_path / "levels.py").write_text("LEVEL = 10.0\n")
    model, edited, place = tmp_path / "my_model.py", tmp_path / name, {"PYTHONPATH": str(tmp_path)}
    model.write_text(USER.format(helper="levels", factor=factor))
    assert probe(model, **place) == (forces[0], 1)
    assert probe(model, **place) == (forces[0], 0)
    stamp = edited.stat()
    edited.write_text(edited.read_text().replace(old, new))
    # Same size, same time: only the text differs.
    os.utime(edited, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert probe(model, **place) == (forces[1], 1)


@pytest.mark.slow
def test_a_deleted_user_model_does_not_affect_later_processes(probe, tmp_path):
    (tmp_path / "levels.py").write_text("LEVEL = 1.0\n")
    model = tmp_path / "my_model.py"
    model.write_text(USER.format(helper="levels", factor="3.0"))
    probe(model, PYTHONPATH=str(tmp_path))
    model.unlink()
    (tmp_path / "levels.py").unlink()
    assert probe()[1] == 1
    assert probe()[1] == 0


@pytest.mark.slow
def test_a_damaged_or_unwritable_cache_only_costs_time(probe, tmp_path):
    good, _ = probe()
    for file in (tmp_path / "cache").rglob("*.bin"):
        file.write_bytes(file.read_bytes()[:1000])
    assert probe() == (good, 1)
    assert probe() == (good, 0)
    assert probe(BRISTLE_CACHE_DIR="/dev/null/nowhere") == (good, 1)
    assert probe(BRISTLE_CACHE_DIR="") == (good, 1)


BASE = """
import enum
from typing import NamedTuple
import numpy as np

class Kind(enum.IntEnum):
    ONE = 1

class Pair(NamedTuple):
    a: float = 1.0

TABLE = np.array([1.0, 2.0])
LEVEL = 1.0
NAMES = ("a", "b")

def inner(x, gain=2.0, *, bias=0.5):
    return gain * x + bias

def outer(x):
    return inner(x) + LEVEL + 1.0 * x + 12.0 + TABLE[0] + Pair().a + Kind.ONE + len(NAMES)
"""


def fingerprint_of(text):
    scope = {"__name__": "probe"}
    exec(text, scope)
    return fingerprint(scope["outer"])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("LEVEL = 1.0", "LEVEL = 1.5"),
        ("return gain * x", "return 2.0 * gain * x"),
        ("gain=2.0", "gain=30.0"),
        ("bias=0.5", "bias=0.6"),
        ("a: float = 1.0", "a: float = 2.0"),
        ("ONE = 1", "ONE = 2"),
        ("[1.0, 2.0]", "[1.0, 2.5]"),
        ("[1.0, 2.0]", "[[1.0], [2.0]]"),
        ("[1.0, 2.0])", "[1.0, 2.0], dtype=np.float32)"),
        ('("a", "b")', '("ab",)'),
        ("1.0 * x + 12.0", "1.01 * x + 2.0"),
        ("inner(x) + LEVEL", "inner(LEVEL) + x"),
    ],
)
def test_every_value_frozen_by_the_compiler_changes_the_fingerprint(old, new):
    assert old in BASE
    assert fingerprint_of(BASE) == fingerprint_of(BASE) != fingerprint_of(BASE.replace(old, new))


SIGNATURES = """
from collections.abc import Callable
from typing import NamedTuple
import numpy as np

class Pair(NamedTuple):
    first: np.ndarray
    second: np.ndarray

class Run(NamedTuple):
    entry: Callable[[Pair, float], float]
    pair: Pair

def driver(run: Run, gain: float) -> float:
    return run.entry(run.pair, gain)
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("first: np.ndarray\n    second", "second: np.ndarray\n    first"),
        ("gain: float", "gain: int"),
        ("entry: Callable[[Pair, float]", "entry: Callable[[Pair, int]"),
    ],
)
def test_arguments_of_a_driver_are_part_of_its_key(old, new):
    keys = []
    for text in (SIGNATURES, SIGNATURES.replace(old, new)):
        scope = {"__name__": "probe"}
        exec(text, scope)
        driver = scope["driver"]
        keys.append((fingerprint(handed_over(driver, driver)), str(compiled_signature(driver))))
    assert keys[0] != keys[1]


NUMBERS = """
import sys
import numpy as np
from bristle import engine, friction
from bristle.engine import compilation
from bristle.contract import example_of

engine.force_along(example_of(friction.MODELS[sys.argv[1]]), np.zeros(2), 1e-3)
(entry,) = compilation._entries.values()
(product,) = entry.overloads.values()
print(product.fndesc.uid)
"""


@pytest.mark.slow
def test_all_products_have_different_symbol_numbers(tmp_path):
    # The compiler counts functions from 1 in each process. Products of several processes, loaded into one, then have
    # symbols of the same name, types and number, and the linker takes one for the other: wrong forces, silently.
    environment = os.environ | {"BRISTLE_CACHE_DIR": str(tmp_path)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    numbers = []
    for name in ("coulomb", "viscous", "coulomb", "dahl"):
        done = subprocess.run(
            [sys.executable, "-c", NUMBERS, name],
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        numbers.append(int(done.stdout))
    assert numbers[0] == numbers[2]
    assert len({numbers[0], numbers[1], numbers[3]}) == 3

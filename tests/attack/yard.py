"""What attacks have in common: a yard full of good files, what is done to them, and what must be true afterwards."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import stat
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import tomlkit
from tests.cli.conftest import AXIS, EXPERIMENT, MODEL, USER_MODEL
from tests.plugins.budget import slowness

from bristle.apps.paper import EXPERIMENTS
from bristle.cli.main import main
from bristle.engine import compilation
from bristle.files.owned import NOTE

__all__ = ["FILES", "HOSTILE", "assault", "build", "places_in", "replaced", "state_of"]

# Of the processor, so that a machine that does other work besides fails no test; a wait is bounded on its own.
MOST_SECONDS, MOST_WAIT, MOST_BYTES = 10.0, 60.0, 2e9

FULL_AXIS = (
    AXIS.replace('limit = "300 N"', 'limit = "300 N"\nheld = true\nlag = "0 ms"')
    + """
[log]
start = "rest"
span = ["0 s", "5 s"]
[timing]
delay = "0 ms"
[plant]
mass = "20 kg"
presliding = "2 um"
offset = "identify"
[limits]
velocity = "300 mm/s"
acceleration = "3 m/s^2"
jerk = "200 m/s^3"
stroke = ["-100 mm", "100 mm"]
[transmission]
gear_ratio = 1.0
lead = "5 mm"
"""
)
CURVES = """
schema = 1
kind = "magnetic"
[columns]
input = { column = "q", unit = "T" }
output = { column = "u", unit = "A*m^2" }
[curves]
start = "virgin"
shortest = 5
"""
OPERATOR = """
schema = 1
kind = "magnetic"
[operator]
model = "prandtl_ishlinskii"
thresholds = [0.1, 0.2]
weights = [1.0, 0.5]
[output]
offset = 0.0
"""
CONTACT = (EXPERIMENTS / "fig_01.toml").read_text(encoding="utf-8")
FILES = {
    "axis.toml": FULL_AXIS,
    "experiment.toml": EXPERIMENT,
    "model.toml": MODEL,
    "own.py": USER_MODEL,
    "curves.toml": CURVES,
    "operator.toml": OPERATOR,
    "fig_01.toml": CONTACT,
}

HOSTILE: tuple[Any, ...] = (
    float("nan"),
    float("inf"),
    -float("inf"),
    1e308,
    -1e308,
    1e300,
    1e-300,
    0,
    0.0,
    -1,
    1,
    2**62,
    -(2**62),
    True,
    "",
    "x",
    "nan",
    "1e308 N",
    "m*9**9**9",
    "1 m**9**9**9",
    "%",
    "-5 %",
    "7 parsec",
    "0 N",
    [],
    [[]],
    {},
    {"a": 1},
    "\u202eabc",
    "a" * 5000,
    "../../etc/passwd",
    "/dev/zero",
    "0x10",
    "1_000 N",
    "١٢ N",
    "1e-320 m",
    "3 mm/s",
    "1e99 m",
    "1e-99 m/s",
    [1, 2],
    ["1 m", "x"],
    "log.csv",
    "axis.toml",
    ".",
    "own.py",
    "none",
    "$(id)",
    "<b>&amp;",
    "{{7*7}}",
    "a\tb",
    "\\x00",
)


def log_of(count: int = 1200) -> dict[str, np.ndarray]:
    """A short log of an axis with Coulomb friction, to and fro at several speeds."""
    t = 1e-3 * np.arange(count)
    r = 0.02 * np.sin(9.0 * t) + 0.01 * np.sin(23.0 * t)
    v, a = np.gradient(r, 1e-3), np.gradient(np.gradient(r, 1e-3), 1e-3)
    noise = np.random.default_rng(4).standard_normal(count)
    return {
        "t": t,
        "q": np.round(r, 7),
        "r": r,
        "u": 20.0 * a + 8.0 * np.tanh(1e3 * v) + 40.0 * v + 0.05 * noise,
    }


def build(folder: Path) -> None:
    """Fill a folder with good files, and with a person's own."""
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "set_a_rig.toml").write_bytes((EXPERIMENTS / "set_a_rig.toml").read_bytes())
    log = log_of()
    rows = np.column_stack(list(log.values()))
    np.savetxt(
        folder / "log.csv", rows, delimiter=",", header=",".join(log), comments="", fmt="%.9g"
    )
    (folder / "thesis").mkdir()
    (folder / "thesis" / "years.tex").write_text("years of work")
    (folder / "results.old-20261120").mkdir()
    (folder / "results.old-20261120" / "mine.txt").write_text("mine")


def places_in(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of each value of a file."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        yield (*path, key)
        if isinstance(value, (dict, list)):
            yield from places_in(value, (*path, key))


def replaced(text: str, path: tuple[Any, ...], value: Any) -> str:
    """Return a file with another value in one place."""
    data = tomllib.loads(text)
    place: Any = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return tomlkit.dumps(data)


def state_of(folder: Path) -> dict[str, tuple[int, str]]:
    """Return all that lies in a folder, but for results that carry the note of bristle's own."""
    result = {}
    for place, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not Path(place, name, NOTE).is_file()]
        for name in (*folders, *names):
            path = Path(place, name)
            info = path.lstat()
            fixed = (
                hashlib.sha256(path.read_bytes()).hexdigest() if stat.S_ISREG(info.st_mode) else ""
            )
            if path.is_symlink():
                fixed = os.readlink(path)
            result[str(path.relative_to(folder))] = (stat.S_IFMT(info.st_mode), fixed)
    return result


def assault(arguments: list[str], folder: Path, chatter: str = "") -> tuple[int, str, str]:
    """Run a command on what was prepared; assert all that must be true of any command on any input.

    Parameters
    ----------
    arguments : list of str
        The command line.
    folder : Path
        Where it is run.
    chatter : str
        What a model of a person's own prints.

    Returns
    -------
    tuple of int and str
        Exit code, standard output, standard error.
    """
    before, out, errors = state_of(folder), io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(errors),
        contextlib.chdir(folder),
        compiling() as of_compiler,
    ):
        began = clocks()
        code = main(arguments)
        took, spent = clocks() - began - of_compiler
    text, message = errors.getvalue().replace(chatter, ""), out.getvalue()
    assert code in (0, 1, 2), (code, text)
    assert spent < MOST_SECONDS or spent < MOST_SECONDS * slowness(), spent
    assert took < MOST_WAIT, took
    assert most_memory() < MOST_BYTES
    assert "fault of bristle" not in text
    assert "Traceback" not in text + message
    lines = text.splitlines()
    assert all(
        line.startswith("bristle: ") and line.isprintable() and len(line) < 2500 for line in lines
    ), text
    if code == 2:
        assert message == ""
        assert lines
    if "--json" in arguments and code in (0, 1):
        assert isinstance(json.loads(message, parse_constant=refused), dict)
    elif code in (0, 1):
        assert all(item.isprintable() or item == "\n" for item in message)
    assert state_of(folder) == before
    return code, message, text


def clocks() -> np.ndarray:
    """Return the time, and the time of the processor [s]."""
    return np.array([time.monotonic(), time.process_time()])


@contextlib.contextmanager
def compiling() -> Iterator[np.ndarray]:
    """Yield how long it takes to compile what has not been compiled before, by both clocks [s]."""
    spent, make = np.zeros(2), compilation._compile

    def timed(*arguments: Any) -> Any:
        began = clocks()
        try:
            return make(*arguments)
        finally:
            spent[:] += clocks() - began

    with patch.object(compilation, "_compile", timed):
        yield spent


def refused(constant: str) -> None:
    raise AssertionError(f"{constant} is no JSON")


def most_memory() -> float:
    """Return the most memory that this process has had [byte]."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0

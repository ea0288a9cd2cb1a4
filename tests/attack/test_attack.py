"""Attacks: whatever a file, a name or a command line holds, a command ends soon, says why, and touches nothing.

The cases are drawn with fixed seeds or written by hand; `tests.attack.yard.assault` asserts the same of all of them.
"""

from __future__ import annotations

import random
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from tests.attack.yard import FILES, HOSTILE, assault, build, log_of, places_in, replaced
from tests.logs.conftest import WRITERS

pytest.importorskip("resource", reason="limits of POSIX")
IDENTIFY = ["identify", "log.csv", "--axis", "axis.toml", "--draws", "0", "--json"]
LOG = ["log", "log.csv", "--axis", "axis.toml", "--json"]
COMMANDS = {
    "axis.toml": [
        IDENTIFY,
        LOG,
        ["excite", "axis.toml", "--duration", "15 s", "--json"],
        ["predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json"],
    ],
    "experiment.toml": [
        ["run", "experiment.toml", "--json"],
        ["design", "experiment.toml", "--json"],
    ],
    "model.toml": [
        ["predict", "model.toml", "log.csv", "--axis", "axis.toml", "--json"],
        ["check", "model.toml", "--json"],
        ["excite", "axis.toml", "--model", "model.toml", "--duration", "15 s", "--json"],
    ],
    "curves.toml": [
        ["identify", "log.csv", "--axis", "curves.toml", "--json"],
        ["predict", "operator.toml", "log.csv", "--axis", "curves.toml", "--json"],
    ],
    "operator.toml": [
        ["check", "operator.toml", "--json"],
        ["predict", "operator.toml", "log.csv", "--axis", "curves.toml", "--json"],
    ],
    "fig_01.toml": [["paper", "--figure", "1", "--from", ".", "--out", "paper", "--json"]],
}


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("built")
    build(folder)
    return folder


@pytest.fixture
def yard(tmp_path, built) -> Path:
    folder = tmp_path / "yard"
    shutil.copytree(built, folder)
    return folder


LONG = ("identify", "excite", "design", "paper")  # seconds each


@pytest.mark.parametrize(
    "arguments",
    [
        pytest.param(each, id=" ".join(each), marks=[pytest.mark.slow] if each[0] in LONG else [])
        for each in sorted({tuple(line) for several in COMMANDS.values() for line in several})
    ],
)
def test_good_files_are_no_attack(yard, arguments):
    assert assault(list(arguments), yard)[0] in (0, 1)


# Values of files.


def drawn(count: int, seed: int) -> list[tuple[str, tuple, object, list[str]]]:
    chance = random.Random(seed)
    places = {
        name: list(places_in(tomllib.loads(text)))
        for name, text in FILES.items()
        if name.endswith(".toml")
    }
    result = []
    for name in (chance.choice(list(places)) for _ in range(count)):
        result.append(
            (
                name,
                chance.choice(places[name]),
                chance.choice(HOSTILE),
                chance.choice(COMMANDS[name]),
            )
        )
    return result


@pytest.mark.fast_cases(29)
@pytest.mark.parametrize(
    "case", drawn(90, 2026), ids=lambda case: f"{case[0]}:{'.'.join(map(str, case[1]))}"
)
def test_any_value_in_any_place_of_a_file(yard, case):
    name, path, value, arguments = case
    (yard / name).write_text(replaced(FILES[name], path, value), encoding="utf-8")
    assault(arguments, yard)


TEXTS = {
    "a table where a number belongs": ("axis.toml", "kind = 1\nschema = 1\n"),
    "everything twice": ("axis.toml", FILES["axis.toml"] * 2),
    "another file": ("axis.toml", FILES["experiment.toml"]),
    "a log": ("axis.toml", "t,q,r,u\n1,2,3,4\n"),
    "nothing": ("axis.toml", ""),
    "blanks": ("axis.toml", " \n\t\n" * 1000),
    "a BOM and CRLF": ("axis.toml", "\ufeff" + FILES["axis.toml"].replace("\n", "\r\n")),
    "UTF-16": ("axis.toml", FILES["axis.toml"].encode("utf-16")),
    "a file that names itself": (
        "experiment.toml",
        FILES["experiment.toml"] + '[axis]\nfile = "experiment.toml"\n',
    ),
    "a model that names itself": (
        "experiment.toml",
        FILES["experiment.toml"].replace(
            'model = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"',
            'file = "experiment.toml"',
            1,
        ),
    ),
    "a model in a folder": (
        "experiment.toml",
        FILES["experiment.toml"].replace(
            'model = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"', 'file = "thesis"', 1
        ),
    ),
    "a thousand variants": (
        "experiment.toml",
        FILES["experiment.toml"]
        .replace('"6 s"', '"6 ms"')
        .replace('settle = "2 s"', 'settle = "0 s"')
        + "".join(f"[compare.v{i}.run]\ndelay = {i % 3}\n" for i in range(60)),
    ),
    "variants of odd names": (
        "experiment.toml",
        FILES["experiment.toml"]
        + '[compare."../x".run]\ndelay = 1\n[compare."\u202e".run]\ndelay = 1\n',
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", TEXTS)
def test_odd_files_of_settings(yard, name):
    file, text = TEXTS[name]
    (yard / file).write_bytes(text if isinstance(text, bytes) else text.encode())
    arguments = (
        IDENTIFY if file == "axis.toml" else ["run", file, "--out", "results", "--log", "--json"]
    )
    assault(arguments, yard)


# Logs as text.


def rows(change):
    """Return what changes the lines of the log."""

    def make(folder: Path) -> None:
        lines = (folder / "log.csv").read_text().splitlines()
        (folder / "log.csv").write_text("\n".join(change(lines)) + "\n", encoding="utf-8")

    return make


def body(change):
    def make(folder: Path) -> None:
        (folder / "log.csv").write_bytes(change((folder / "log.csv").read_bytes()))

    return make


def cell(text: str, row: int = 500, column: int = 1):
    def change(lines: list[str]) -> list[str]:
        cells = lines[row].split(",")
        cells[column] = text
        return [*lines[:row], ",".join(cells), *lines[row + 1 :]]

    return rows(change)


def timed(lines: list[str], step: float) -> list[str]:
    return [lines[0], *[f"{i * step},{line.partition(',')[2]}" for i, line in enumerate(lines[1:])]]


CELLS = (
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e300",
    "-1e300",
    "1e-400",
    "0x1p3",
    "1_000",
    "١٢",
    "1,5",
    '"',
    '""',
    "'1'",
    "#1",
    "=1+1",
    "\x1b[31m1",
    "1\x00",
    "",
    " ",
    "TRUE",
    "1e",
    "--1",
    "1.2.3",
    "12:30:00",
    "2026-11-20",
    "9" * 400,
    "x" * 200_000,
    "½",
    "−1",
)
LINES = {
    "no header": lambda lines: lines[1:],
    "two headers": lambda lines: [lines[0], *lines],
    "a header in the middle": lambda lines: [*lines[:500], lines[0], *lines[500:]],
    "only a header": lambda lines: lines[:1],
    "one row": lambda lines: lines[:2],
    "no rows but blank ones": lambda lines: [lines[0], *[""] * 500],
    "one name for all": lambda lines: ["q,q,q,q", *lines[1:]],
    "names of control characters": lambda lines: ["t\x1b[2J,q\x07,\u202er,u\x7f", *lines[1:]],
    "names of brackets": lambda lines: [
        "t [" + " " * 4000 + "],q ((((,r ]]],u [m*9**9**9**9]",
        *lines[1:],
    ],
    "a name without end": lambda lines: ["t," + "q" * 60_000 + ",r,u", *lines[1:]],
    "names of formulas": lambda lines: ["t,=cmd|' /C calc'!A0,$a$b$^_{,\\frac{1}{0}", *lines[1:]],
    "names of markup": lambda lines: ["t,<script>alert(1)</script>,{{7*7}},]]>", *lines[1:]],
    "two thousand columns": lambda lines: [",".join([line] * 500) for line in lines[:40]],
    "sixty thousand columns": lambda lines: [",".join(["1"] * 60_000) for _ in range(3)],
    "one column": lambda lines: [line.split(",")[0] for line in lines],
    "ragged": lambda lines: [line + "," * (i % 7) for i, line in enumerate(lines)],
    "reversed": lambda lines: [lines[0], *lines[:0:-1]],
    "all the same": lambda lines: [lines[0], *[lines[1]] * 800],
    "each row twice": lambda lines: [lines[0], *[line for line in lines[1:] for _ in (0, 1)]],
    "comments between all": lambda lines: [
        lines[0],
        *[text for line in lines[1:] for text in ("# note, note", line)],
    ],
    "a preamble of hundreds of lines": lambda lines: [*["key;value;x"] * 395, *lines],
    "a preamble without end": lambda lines: [*["key;value"] * 5000, *lines],
    "separators of all kinds": lambda lines: [
        line.replace(",", ";\t,|"[i % 4]) for i, line in enumerate(lines)
    ],
    "a quote that never ends": lambda lines: [*lines[:300], '"' + lines[300], *lines[301:]],
    "quotes in quotes": lambda lines: [
        ",".join(f'"{cell}"' for cell in line.split(",")) for line in lines
    ],
    "huge numbers": lambda lines: [lines[0], *[",".join(["1e300"] * 4)] * 300],
    "tiny numbers": lambda lines: [lines[0], *[f"{i},1e-310,1e-310,1e-310" for i in range(300)]],
    "numbers of both ends": lambda lines: [
        lines[0],
        *[f"{i},{10.0 ** (i % 600 - 300)},1,1" for i in range(1200)],
    ],
    "time in years": lambda lines: timed(lines, 3e7),
    "steps of nothing": lambda lines: timed(lines, 1e-300),
}
BODIES = {
    "NUL in it": lambda data: data[:5000] + b"\0" + data[5000:],
    "of NUL": lambda data: bytes(5000),
    "half a character": lambda data: data.replace(b"t,q", "t,\u00e9".encode()[:-1] + b"q", 1),
    "UTF-16 cut": lambda data: data.decode().encode("utf-16")[:-1],
    "UTF-32": lambda data: data.decode().encode("utf-32"),
    "line ends of old": lambda data: data.replace(b"\n", b"\r"),
    "line ends of all kinds": lambda data: data.replace(b"\n", b"\r\n", 300).replace(
        b"\r\n", b"\r", 100
    ),
    "one line": lambda data: data.replace(b"\n", b","),
    "no line end": lambda data: data[:-1],
    "cut in a row": lambda data: data[: len(data) // 2],
    "a gzip": lambda data: b"\x1f\x8b\x08" + data,
    "a zip": lambda data: b"PK\x03\x04" + data,
    "a PDF": lambda data: b"%PDF-1.7" + data,
    "HTML": lambda data: b"<html><table>" + data,
    "a picture": lambda data: b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 40,
    "blanks before all": lambda data: b" " * 100_000 + data,
    "noise": lambda data: np.random.default_rng(3).bytes(20_000),
    "letters": lambda data: b"the quick brown fox\n" * 500,
}
TEXT_LOGS = {f"a cell {text[:12]!r}": cell(text) for text in CELLS}
TEXT_LOGS |= {name: rows(change) for name, change in LINES.items()} | {
    n: body(change) for n, change in BODIES.items()
}


@pytest.mark.fast_cases(6)
@pytest.mark.parametrize("name", TEXT_LOGS)
def test_odd_logs_of_text(yard, name):
    TEXT_LOGS[name](yard)
    choice = random.Random(name)
    arguments = choice.choice(
        [IDENTIFY, LOG, ["log", "log.csv"], ["log", "log.csv", "--out", "results", "--json"]]
    )
    assault(arguments, yard)


# Logs of other kinds.

BINARY = ("h5", "mat", "npz", "parquet", "tdms")
SPOILED = {
    "cut": lambda data, chance: data[: chance.randrange(9, len(data))],
    "flipped": lambda data, chance: flipped(data, chance, 1),
    "flipped often": lambda data, chance: flipped(data, chance, 40),
    "twice": lambda data, chance: data * 2,
    "first half zero": lambda data, chance: (
        data[:16] + bytes(len(data) // 2) + data[len(data) // 2 + 16 :]
    ),
    "as it is, called a table": lambda data, chance: data,
}


def flipped(data: bytes, chance: random.Random, count: int) -> bytes:
    spoiled = bytearray(data)
    for _ in range(count):
        spoiled[chance.randrange(8, len(data))] ^= 1 << chance.randrange(8)
    return bytes(spoiled)


@pytest.mark.fast_cases(3)
@pytest.mark.parametrize("how", SPOILED)
@pytest.mark.parametrize("kind", BINARY)
def test_spoiled_logs_of_other_kinds(yard, kind, how):
    path = WRITERS[kind](yard / f"log.{kind}", log_of())
    path.write_bytes(SPOILED[how](path.read_bytes(), random.Random(f"{kind} {how}")))
    if how.endswith("a table"):
        path = path.rename(path.with_suffix(".csv"))
    assault(["log", path.name, "--axis", "axis.toml", "--json"], yard)


# Command lines.

ARGUMENTS = [
    ["identify", ""],
    ["identify", "log.csv", "--axis", ""],
    ["identify", "\ud800.csv"],
    ["identify", "a" * 5000],
    ["identify", "log.csv::x"],
    ["identify", "::"],
    ["identify", "log.csv::"],
    ["identify", "/"],
    ["identify", "."],
    ["identify", "/dev/zero"],
    ["identify", "/dev/stdin/x"],
    ["identify", "/proc/self/mem"],
    ["identify", "/proc/kmsg"],
    ["log", "/proc/self/environ"],
    ["log", "/sys/kernel/notes"],
    ["log", "thesis/years.tex"],
    ["log", "axis.toml"],
    [*IDENTIFY, "--cutoff", "nan Hz"],
    [*IDENTIFY, "--cutoff", "1e308 Hz"],
    [*IDENTIFY, "--cutoff", "Hz**9**9"],
    [*IDENTIFY, "--cutoff", "9" * 30 + " Hz"],
    [*IDENTIFY, "--draws", "-5"],
    [*IDENTIFY, "--model", ","],
    [*IDENTIFY, "--model", "+"],
    [*IDENTIFY, "--model", "lugre" + "+asymmetry" * 100],
    [*IDENTIFY, "--model", "coulomb,"],
    [*IDENTIFY, "--model", "a" * 10_000],
    [*IDENTIFY, "--model", "/dev/zero.py"],
    [*IDENTIFY, "--free", "__class__"],
    [*IDENTIFY, "--method", "\x1b[2J"],
    ["predict", "model.toml", "log.csv", "--mode", ""],
    ["predict", "log.csv", "model.toml"],
    ["predict", "model.toml", "gone"],
    ["run", "axis.toml"],
    ["run", "own.py"],
    ["run", "thesis"],
    ["design", "experiment.toml", "--bandwidth", "1e300 Hz"],
    ["design", "experiment.toml", "--bandwidth", "-1 Hz"],
    ["design", "experiment.toml", "--variant", "\u202e"],
    ["design", "experiment.toml", "--bandwidth", "1e-300 Hz"],
    ["excite", "axis.toml", "--duration", "1e9 s"],
    ["excite", "axis.toml", "--duration", "nan s"],
    ["excite", "axis.toml", "--duration", "2 s"],
    ["excite", "axis.toml", "--travel", "1e-300 m"],
    ["excite", "axis.toml", "--travel", "0 m"],
    ["excite", "axis.toml", "--for", ",,,"],
    ["excite", "axis.toml", "--duration", "10 s", "--for", "stribeck," * 100],
    ["check", "model.toml", "--force-ripple", "1e300 N,nan N"],
    ["check", "model.toml", "--force-ripple", ","],
    ["check", "model.toml", "--loop", "1 um,1 um"],
    ["check", "model.toml", "--loop", "1e9 m,-1e9 m"],
    ["check", "."],
    ["models", "\x1b[31m"],
    ["models", "lugre+" * 50],
    ["models", ""],
    ["paper", "--figure", "9" * 30],
    ["paper", "--figure", "-1"],
    ["paper", "--from", "/dev"],
    ["paper", "--from", "thesis", "--figure", "3"],
    ["paper", "--write", "thesis"],
    ["paper", "--write", "log.csv"],
    ["paper", "--write", "/"],
    ["paper", "--write", ""],
    ["--version", "x" * 1000],
    ["", ""],
    ["\x00"],
    ["identify", "log.csv", "--out", "x\x00y"],
    ["--help", "--json"],
]


@pytest.mark.fast_cases(31)
@pytest.mark.parametrize(
    "arguments", ARGUMENTS, ids=lambda arguments: ascii(" ".join(arguments))[:60]
)
def test_odd_command_lines(yard, arguments):
    assault(arguments, yard)


# Where results go.

PLACES = {
    "a folder of a person's own": "thesis",
    "a backup": "results.old-20261120",
    "a file": "log.csv",
    "the folder itself": ".",
    "the folder above": "..",
    "the root": "/",
    "a device": "/dev/null",
    "a folder of the system": "/proc",
    "nowhere": "no/where",
    "in a file": "log.csv/results",
    "a name too long": "x" * 300,
    "a path too long": "x/" * 3000,
    "a link to a folder": "link",
    "a link to itself": "loop",
    "a name like ours": f"bristle-{'0' * 32}.partial",
    "a name of blanks": "   ",
    "a name of dots": "...",
    "a name that is an option": "--force",
}


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", PLACES)
def test_odd_places_for_results(yard, name):
    for link, target in (("link", "thesis"), ("gone", "nowhere"), ("loop", "loop")):
        (yard / link).symlink_to(target)
    (yard / f"bristle-{'0' * 32}.partial").mkdir()
    (yard / f"bristle-{'0' * 32}.partial" / "mine.txt").write_text("mine")
    for force in ((), ("--force",)):
        assault(
            ["log", "log.csv", "--axis", "axis.toml", "--out", PLACES[name], *force, "--json"], yard
        )


# Models of a person's own.

OWN = {
    "stops": ("    return p.F_0", "    raise ZeroDivisionError\n    return p.F_0"),
    "ends": ("    return p.F_0", "    raise SystemExit(0)\n    return p.F_0"),
    "raises what nobody catches": (
        "    return p.F_0",
        "    raise BaseException('odd')\n    return p.F_0",
    ),
    "calls itself": (
        "    return p.F_0",
        "    return trial(state, memory, motion, dt, p)\n    return p.F_0",
    ),
    "returns nothing": ("    return p.F_0 * direction(motion.v), Move()", "    return None"),
    "returns no number": (
        "    return p.F_0 * direction(motion.v)",
        "    return float('nan') * p.F_0 * direction(motion.v)",
    ),
    "returns infinity": (
        "    return p.F_0 * direction(motion.v)",
        "    return 1e308 * 10.0 * direction(motion.v)",
    ),
    "returns text": ("    return p.F_0 * direction(motion.v)", "    return 'force'"),
    "returns an array": ("    return p.F_0 * direction(motion.v)", "    return [p.F_0]"),
    "takes other arguments": ("def trial(state, memory, motion, dt, p)", "def trial(state)"),
    "has odd names": ('name="own"', 'name="\\x1b[31m"'),
    "has no name": ('name="own"', 'name=""'),
    "has a quantity that is none": ('"force", "force', '"furlong", "force'),
    "has bounds that are none": ("min=0.0", "min=float('nan')"),
    "has an example that is none": (
        "commit=commit\n)",
        "commit=commit, example={'F_0': 'x', 'y': 1}\n)",
    ),
    "takes away what is built in": ("MODEL =", "import builtins\nheld = builtins.print\nMODEL ="),
    "writes much": ("MODEL =", "print('x' * 100_000)\nMODEL ="),
    "closes the output": (
        "MODEL =",
        "import io, sys\nsys.stdout = io.StringIO()\nsys.stdout.close()\nMODEL =",
    ),
}


@pytest.mark.parametrize("how", OWN)
def test_models_of_a_persons_own(yard, how):
    old, new = OWN[how]
    text = (yard / "own.py").read_text()
    assert old in text
    (yard / "own.py").write_text(text.replace(old, new, 1))
    chatter = "x" * 100_000 + "\n"
    if assault(["check", "own.py", "--json"], yard, chatter)[0]:
        # One that meets the contract is compiled elsewhere.
        assault([*IDENTIFY, "--model", "own.py"], yard, chatter)

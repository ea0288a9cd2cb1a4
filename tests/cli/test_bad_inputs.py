"""What a person can get wrong: always exit code 2, and one line that names the place and the mend."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

IDENTIFY = ("identify", "log.csv", "--axis", "axis.toml")
PREDICT = ("predict", "model.toml", "log.csv", "--axis", "axis.toml")
RUN = ("run", "experiment.toml")
DESIGN = ("design", "experiment.toml")
EXPORT = ("export", "model.toml", "--out", "out", "--to")
STUDY = """
schema = 1
experiment = "experiment.toml"
runs = 2
seed = 1
[vary]
"friction.F_C" = { uniform = ["6 N", "10 N"] }
"""
LAW = ("export", "--law", "experiment.toml", "--to", "c", "--out", "out")


class Bad(NamedTuple):
    """One mistake: how it is made, on which command line, and what the message must name."""

    name: str
    words: tuple[str, ...]
    arguments: tuple[str, ...]
    make: Callable[[], object] = lambda: None


def swap(file: str, old: str, new: str) -> Callable[[], object]:
    """Return what replaces a text in a file, once."""

    def make() -> None:
        text = Path(file).read_text()
        assert old in text
        Path(file).write_text(text.replace(old, new, 1))

    return make


def append(file: str, text: str) -> Callable[[], object]:
    return lambda: Path(file).write_text(Path(file).read_text() + text)


def write(file: str, content: str | bytes) -> Callable[[], object]:
    return lambda: Path(file).write_bytes(
        content if isinstance(content, bytes) else content.encode()
    )


def without_order(table):
    """Give the rows each other's stamps."""
    stamps = [row[0] for row in table[1:]]
    for index, row in enumerate(table[1:]):
        row[0] = stamps[index * 389 % len(stamps)]


def rows(change: Callable[[list[list[str]]], object]) -> Callable[[], object]:
    """Return what changes the rows of the log, header first."""

    def make() -> None:
        table = [line.split(",") for line in Path("log.csv").read_text().splitlines()]
        change(table)
        Path("log.csv").write_text("\n".join(",".join(row) for row in table) + "\n")

    return make


def cell(row: int, column: int, text: str) -> Callable[[], object]:
    def change(table: list[list[str]]) -> None:
        table[row][column] = text

    return rows(change)


def column(number: int, text: str) -> Callable[[], object]:
    def change(table: list[list[str]]) -> None:
        for row in table[1:]:
            row[number] = text

    return rows(change)


def with_own_model() -> None:
    """Let the model file and the experiment name the model of a person's own."""
    for name in ("model.toml", "experiment.toml"):
        text = Path(name).read_text()
        custom = '[friction]\nfile = "own.py"\nF_0 = 8.0\n'
        Path(name).write_text(re.sub(r"\[friction\]\n([^\[\n].*\n)*", custom, text, count=1))


COMMAND_LINES = [
    Bad(
        "no command of this name",
        ("idenfity", "Did you mean 'identify'", "Try: bristle --help"),
        ("idenfity", "log.csv"),
    ),
    Bad(
        "no option of this name",
        ("--axes", "--axis", "Try: bristle"),
        ("identify", "log.csv", "--axes", "axis.toml"),
    ),
    Bad("argument left out", ("MODEL.toml", "Try: bristle"), ("predict",)),
    Bad("argument too many", ("b.toml", "Try: bristle"), ("run", "a.toml", "b.toml")),
    Bad("text for a count", ("--draws", "integer", "Try: bristle"), (*IDENTIFY, "--draws", "ten")),
    Bad(
        "angular velocity for a frequency",
        ("--cutoff", "2 pi"),
        (*IDENTIFY, "--cutoff", "60 rad/s"),
    ),
    Bad("negative cut-off", ("cutoff", "-5"), (*IDENTIFY, "--cutoff=-5 Hz")),
    Bad("cut-off beyond the samples", ("cutoff", "500"), (*IDENTIFY, "--cutoff", "2 kHz")),
    Bad("no number", ("--cutoff", "fast", "7 um"), (*IDENTIFY, "--cutoff", "fast")),
    Bad(
        "no such model",
        ("strybeck", "Did you mean 'stribeck'"),
        (*IDENTIFY, "--model", "coulomb,strybeck"),
    ),
    Bad("no such slot", ("+hot", "+asymmetry"), (*IDENTIFY, "--model", "coulomb+hot")),
    Bad("no model at all", ("coulomb_viscous",), (*IDENTIFY, "--model", "")),
    Bad(
        "model that this method cannot fit",
        ("maxwell_stribeck", "gms"),
        (*IDENTIFY, "--model", "maxwell_stribeck"),
    ),
    Bad("no such mode", ("sideways", "closed-loop"), (*PREDICT, "--mode", "sideways")),
    Bad(
        "results into a file",
        ("kept.txt", "Name another"),
        (*IDENTIFY, "--out", "kept.txt"),
        write("kept.txt", "mine"),
    ),
    Bad("results nowhere", ("no/run", "Make"), (*IDENTIFY, "--out", "no/run")),
    Bad("results in a folder without a name", ("--out", "empty"), (*IDENTIFY, "--out", "")),
    Bad(
        "results over a folder of something else",
        ("another folder",),
        (*IDENTIFY, "--out", ".", "--force"),
    ),
    Bad("check of what is no model", ("log.csv", ".py"), ("check", "log.csv")),
    Bad(
        "slot for a controller", ("cascade+asymmetry", "no slots"), ("models", "cascade+asymmetry")
    ),
    Bad("no such name", ("lugree", "Did you mean 'lugre'"), ("models", "lugree")),
    Bad("no such code", ("Did you mean 'structure'?",), ("explain", "structre")),
    Bad(
        "no such variant",
        ("Did you mean 'none'?",),
        ("design", "experiment.toml", "--variant", "nome"),
    ),
    Bad("log of a run nowhere", ("--log: needs a folder",), (*RUN, "--log")),
    Bad(
        "figure files nowhere",
        ("--format: needs a folder to write into. Add --out DIR",),
        (*DESIGN, "--format", "svg"),
    ),
    Bad(
        "numbers of figures nowhere",
        ("--format: needs a folder to write into. Add --out DIR",),
        (*DESIGN, "--format", "csv"),
    ),
    Bad(
        "no format of figures",
        ("gif", "svg", "pdf", "png", "csv"),
        ("log", "log.csv", "--out", "run", "--format", "gif"),
    ),
    Bad(
        "no format of numbers",
        ("xlsx", "svg", "pdf", "png", "csv"),
        ("log", "log.csv", "--out", "run", "--format", "xlsx"),
    ),
    Bad(
        "study nowhere",
        ("needs a folder to write into. Add --out DIR",),
        ("study", "study.toml"),
        write("study.toml", STUDY),
    ),
    Bad(
        "two ends of a run on a machine",
        ("--undo and --save: exclude each other",),
        ("tune", "--save", ".", "--undo", "."),
    ),
    Bad("figure beyond the paper", ("15",), ("paper", "--figure", "15")),
    Bad("figure of no number", ("--figure", "integer"), ("paper", "--figure", "x")),
    Bad("figures before the paper", ("0",), ("paper", "--figure", "0")),
    Bad("experiments from nowhere", ("nowhere",), ("paper", "--from", "nowhere")),
    Bad(
        "frictions in no list",
        ("found 'bouc-wen'",),
        ("paper", "--robust", "gms", "bouc-wen", "--seeds", "1"),
    ),
    Bad(
        "friction without its option",
        ("FRICTION: has no effect without --robust",),
        ("paper", "gms"),
    ),
    Bad(
        "motion without limits", ("Write", "[limits]"), ("excite", "axis.toml", "--for", "stribeck")
    ),
    Bad(
        "limit of another unit",
        ("limits.acceleration",),
        ("excite", "axis.toml"),
        append("axis.toml", '[limits]\nacceleration = "2 m/s"\n'),
    ),
    Bad(
        "log beside a model",
        ("--log: cannot be combined with model",),
        ("excite", "axis.toml", "--log", "log.csv", "--model", "model.toml"),
    ),
    Bad(
        "log of two columns",
        ("log.csv",),
        ("excite", "axis.toml", "--log", "log.csv"),
        write("log.csv", "t,q\n0,1\n"),
    ),
    Bad("ripple of code", ('file = "own.py"',), ("check", "own.py", "--force-ripple", "1 N,2 N")),
    Bad("ripple of one end", ("two values",), ("check", "model.toml", "--force-ripple", "40 mN")),
    Bad(
        "ripple of another unit",
        ("force_ripple",),
        ("check", "model.toml", "--force-ripple", "40 um,80 um"),
    ),
    Bad("loop of another unit", ("loop[0]",), ("check", "model.toml", "--loop", "3 mrad,1 mrad")),
    Bad(
        "ripple beyond break-away",
        ("rests",),
        ("check", "model.toml", "--force-ripple", "4 N,20 N"),
    ),
    Bad("check of nothing", ("nowhere.toml",), ("check", "nowhere.toml")),
    Bad(
        "check of an empty file",
        ("MODEL", "SLOT", "FORMAT", "TARGET", "FIGURE"),
        ("check", "k.py"),
        write("k.py", "def write(request): ...\n"),
    ),
    Bad("export of no such kind", ("cogging",), (*EXPORT, "cogging")),
    Bad(
        "log of an export to C",
        ("is not a table",),
        (*EXPORT, "c", "--log", "log.csv", "--axis", "axis.toml"),
    ),
    Bad(
        "table of two entries", ("points",), (*EXPORT, "table", "--points", "2", "--speed", "1 m/s")
    ),
    Bad("export to no language", ("no such target",), (*EXPORT, "cobol")),
    Bad(
        "export of draws",
        ("--to draws: was removed. The results of identify contain draws.parquet",),
        (*EXPORT, "draws"),
    ),
    Bad("name of no function", ("cannot name a function",), (*EXPORT, "c", "--name", "2nd")),
    Bad("step of an export in metres", ("--step",), (*EXPORT, "c", "--step", "3 mm")),
    Bad("table without a speed", ("the largest speed of the axis",), (*EXPORT, "table")),
    Bad("single precision of a scene", ("single precision",), (*EXPORT, "mjcf", "--float32")),
    Bad("law of no variant", ("the experiment has several variants",), LAW),
    Bad("law of no such variant", ("none",), (*LAW, "--variant", "nome")),
    Bad(
        "step of a law", ("applies to a model only",), (*LAW, "--variant", "none", "--step", "1 ms")
    ),
    Bad("law beside a model", ("either a model or a law",), (*LAW, "model.toml")),
    Bad(
        "step of a scene",
        ("--step: has no effect on --to mjcf",),
        (*EXPORT, "mjcf", "--step", "1 ms"),
    ),
    Bad("entries of C", ("--points: has no effect on --to c",), (*EXPORT, "c", "--points", "3")),
    Bad("variant of a model", ("applies to --law only",), (*EXPORT, "c", "--variant", "none")),
    Bad(
        "neither model nor law",
        ("either a model or a law",),
        ("export", "--to", "c", "--out", "out"),
    ),
]
LOGS = [
    Bad("no such file", ("nowhere.csv",), ("identify", "nowhere.csv", "--axis", "axis.toml")),
    Bad("a folder", ("folder",), ("log", "folder"), lambda: Path("folder").mkdir()),
    Bad("an empty file", ("log.csv",), IDENTIFY, write("log.csv", "")),
    Bad("not a number", ("'q'", "sample 99", "Correct"), IDENTIFY, cell(100, 1, "nan")),
    Bad("infinity", ("'u'", "sample 99"), IDENTIFY, cell(100, 3, "inf")),
    Bad("text in a cell", ("line 101", "oops"), IDENTIFY, cell(100, 1, "oops")),
    Bad(
        "time in no order", ("'t'", "is not in order", "sample_time"), IDENTIFY, rows(without_order)
    ),
    Bad("a row cut short", ("line 101",), IDENTIFY, rows(lambda table: table[100].pop())),
    Bad(
        "a column that is missing",
        ("position", "'q'", "pos", "Did you mean"),
        IDENTIFY,
        rows(lambda t: t[0].__setitem__(1, "qq")),
    ),
    Bad("too short", ("100",), IDENTIFY, rows(lambda table: table.__delitem__(slice(60, None)))),
    Bad("an axis that never moved", ("'q'", "constant"), IDENTIFY, column(1, "0.01")),
    Bad("an effort that is constant", ("'u'", "constant"), IDENTIFY, column(3, "2.5")),
    Bad(
        "half a file of MATLAB",
        ("half.mat",),
        ("log", "half.mat"),
        write("half.mat", b"MATLAB 5.0 MAT-file" + b" " * 150),
    ),
    Bad(
        "half a file of LabVIEW",
        ("half.tdms",),
        ("log", "half.tdms"),
        write("half.tdms", b"TDSm\x0e\0\0\0\x69\x12"),
    ),
    Bad(
        "no log at all",
        ("photo.jpg",),
        ("log", "photo.jpg"),
        write("photo.jpg", bytes(range(256)) * 8),
    ),
]
AXES = [
    Bad(
        "no such axis file",
        ("no.toml", "Check the path"),
        ("identify", "log.csv", "--axis", "no.toml"),
    ),
    Bad(
        "no TOML",
        ("axis.toml", "line 7", "time ="),
        IDENTIFY,
        swap("axis.toml", '"t", unit', "t, unit"),
    ),
    Bad(
        "value without quotation marks",
        ("axis.toml", "quotation"),
        IDENTIFY,
        swap("axis.toml", '"300 N"', "300 N"),
    ),
    Bad("no text", ("axis.toml", "UTF-8"), IDENTIFY, write("axis.toml", b"\xff\xfe\x00")),
    Bad(
        "nested beyond reason", ("axis.toml",), IDENTIFY, write("axis.toml", "a = " + "[" * 20_000)
    ),
    Bad("no schema", ("schema = 1",), IDENTIFY, swap("axis.toml", "schema = 1", "")),
    Bad(
        "schema of the future",
        ("schema", "2"),
        IDENTIFY,
        swap("axis.toml", "schema = 1", "schema = 2"),
    ),
    Bad(
        "unknown key",
        ("columns.positon", "Did you mean 'position'"),
        IDENTIFY,
        swap("axis.toml", "position =", "positon ="),
    ),
    Bad(
        "unknown kind",
        ("kind", "round", "translational"),
        IDENTIFY,
        swap("axis.toml", "translational", "round"),
    ),
    Bad(
        "unit of another axis",
        ("columns.position", "angle", "lead"),
        IDENTIFY,
        swap("axis.toml", '"q", unit = "m"', '"q", unit = "rad"'),
    ),
    Bad(
        "no unit",
        ("smoots", "columns.position"),
        IDENTIFY,
        swap("axis.toml", '"q", unit = "m"', '"q", unit = "smoots"'),
    ),
    Bad(
        "current without a constant",
        ("columns.effort", 'constant = "0.12 N*m/A"'),
        IDENTIFY,
        swap("axis.toml", '"u", unit = "N"', '"u", unit = "A"'),
    ),
    Bad(
        "counts without a resolution",
        ("columns.position", "counts_per_rev"),
        IDENTIFY,
        lambda: (
            swap("axis.toml", '"q", unit = "m"', '"q", unit = "count"')(),
            swap("axis.toml", 'resolution = "0.1 um"', "")(),
        ),
    ),
    Bad(
        "negative resolution",
        ("encoder.resolution", "> 0"),
        IDENTIFY,
        swap("axis.toml", '"0.1 um"', '"-0.1 um"'),
    ),
    Bad(
        "energy for a force",
        ("effort.limit", "energy"),
        IDENTIFY,
        swap("axis.toml", "300 N", "300 J"),
    ),
    Bad(
        "decimal comma",
        ("encoder.resolution", "0.1 um"),
        IDENTIFY,
        swap("axis.toml", "0.1 um", "0,1 um"),
    ),
    Bad("gain in hertz", ("controller.k_p", "1/s"), IDENTIFY, swap("axis.toml", "80 1/s", "80 Hz")),
    Bad(
        "negative gain",
        ("controller.k_v", ">= 0"),
        IDENTIFY,
        swap("axis.toml", '"4 N*s/mm"', "-4.0"),
    ),
    Bad(
        "gain that is no such", ("controller.k_q", "k_p"), IDENTIFY, swap("axis.toml", "k_p", "k_q")
    ),
    Bad(
        "controller that is no such",
        ("controller.model", "Did you mean 'cascade'"),
        IDENTIFY,
        swap("axis.toml", '"cascade"', '"cascades"'),
    ),
    Bad(
        "number beyond all bounds",
        ("controller.k_v",),
        IDENTIFY,
        swap("axis.toml", '"4 N*s/mm"', "1" + "0" * 400),
    ),
    Bad(
        "exponent beyond all bounds",
        ("encoder.resolution",),
        IDENTIFY,
        swap("axis.toml", "0.1 um", "1e999999 um"),
    ),
]
EXPERIMENTS = [
    Bad(
        "unknown section",
        ("frictoin", "Did you mean 'friction'"),
        RUN,
        swap("experiment.toml", "[friction]", "[frictoin]"),
    ),
    Bad(
        "no friction",
        ("friction", "[friction]"),
        RUN,
        swap(
            "experiment.toml",
            '[friction]\nmodel = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"',
            "",
        ),
    ),
    Bad("no plant", ("plant", "inertia"), RUN, swap("experiment.toml", '[plant]\nM = "20 kg"', "")),
    Bad(
        "model unknown",
        ("friction.model", "coulomb_viscos"),
        RUN,
        swap("experiment.toml", '"coulomb_viscous"', '"coulomb_viscos"'),
    ),
    Bad(
        "parameter unknown",
        ("friction.F_c", "Did you mean 'F_C'"),
        RUN,
        swap("experiment.toml", "F_C", "F_c"),
    ),
    Bad(
        "parameter missing",
        ("friction", "F_v"),
        RUN,
        swap("experiment.toml", 'F_v = "40 N*s/m"\n', ""),
    ),
    Bad(
        "parameter out of range",
        ("friction.F_C", "-8", ">= 0"),
        RUN,
        swap("experiment.toml", '"8 N"', '"-8 N"'),
    ),
    Bad(
        "parameter not finite",
        ("friction.F_C", "finite"),
        RUN,
        swap("experiment.toml", '"8 N"', "nan"),
    ),
    Bad(
        "truth for a number",
        ("friction.F_C", "True"),
        RUN,
        swap("experiment.toml", '"8 N"', "true"),
    ),
    Bad(
        "list for a number",
        ("friction.F_C", "[8.0]"),
        RUN,
        swap("experiment.toml", '"8 N"', "[8.0]"),
    ),
    Bad(
        "relation broken",
        ("friction", "F_S >= F_C", "Raise F_S"),
        RUN,
        swap(
            "experiment.toml",
            'model = "coulomb_viscous"',
            'model = "stribeck"\nF_S = 4.0\nv_S = 1e-3',
        ),
    ),
    Bad("mass in newtons", ("plant.M", "kg"), RUN, swap("experiment.toml", "20 kg", "20 N")),
    Bad(
        "units of two kinds",
        ("friction.F_C", "rotational"),
        RUN,
        swap("experiment.toml", '"8 N"', '"8 N*m"'),
    ),
    Bad(
        "rotation as frequency",
        ("reference.frequency", "2 pi"),
        RUN,
        swap("experiment.toml", "0.5 Hz", "3 rad/s"),
    ),
    Bad("no duration", ("run", "duration"), RUN, swap("experiment.toml", 'duration = "6 s"', "")),
    Bad(
        "sample time of nothing",
        ("run.sample_time", ">= 1e-09"),
        RUN,
        swap("experiment.toml", '"1 ms"', "0"),
    ),
    Bad(
        "more samples than memory",
        ("run.duration", "samples"),
        RUN,
        swap("experiment.toml", '"6 s"', '"6000 h"'),
    ),
    Bad(
        "nothing left to judge",
        ("run.settle", "6 s"),
        RUN,
        swap("experiment.toml", '"2 s"', '"9 s"'),
    ),
    Bad(
        "half a step",
        ("run.substeps", "1.5", "whole"),
        RUN,
        swap("experiment.toml", "[run]", "[run]\nsubsteps = 1.5"),
    ),
    Bad(
        "word for a model",
        ("controller.feedforward.friction", "none"),
        RUN,
        swap(
            "experiment.toml",
            'friction = { model = "coulomb_viscous", F_C = "8 N", F_v = "40 N*s/m" }',
            'friction = "all"',
        ),
    ),
    Bad(
        "mistake in a variant",
        ("compare.none.controller.feedforward.gains", "Did you mean 'gain'"),
        RUN,
        append("experiment.toml", "gains = 2.0\n"),
    ),
    Bad(
        "variant that is no table",
        ("compare.none", "[compare.none]"),
        RUN,
        swap(
            "experiment.toml",
            '[compare.none.controller.feedforward]\nfriction = "none"',
            "[compare]\nnone = 3",
        ),
    ),
    Bad(
        "file that is not there",
        ("friction.file", "lost.toml"),
        RUN,
        swap(
            "experiment.toml",
            'model = "coulomb_viscous"\nF_C = "8 N"\nF_v = "40 N*s/m"',
            'file = "lost.toml"',
        ),
    ),
    Bad(
        "reference of a log without one",
        ("reference.file", "[columns]"),
        RUN,
        lambda: (
            swap(
                "experiment.toml",
                'model = "sine"\namplitude = "50 mm"\nfrequency = "0.5 Hz"\nramp = "1 s"',
                'model = "recorded"\nfile = "log.csv"\naxis = "axis.toml"',
            )(),
            swap("axis.toml", 'reference = { column = "r", unit = "m" }', "")(),
        ),
    ),
]
MODELS = [
    Bad(
        "model file without friction",
        ("frictions", "Did you mean 'friction'"),
        PREDICT,
        swap("model.toml", "[friction]", "[frictions]"),
    ),
    Bad(
        "model file without a plant",
        ("model.toml", "plant"),
        PREDICT,
        swap("model.toml", '[plant]\nmodel = "inertia"\nM = 20.0', ""),
    ),
    Bad(
        "value out of range in a model file",
        ("plant.M", "-20"),
        PREDICT,
        swap("model.toml", "M = 20.0", "M = -20.0"),
    ),
    Bad(
        "model of another kind of axis",
        ("rotational",),
        PREDICT,
        swap("model.toml", "translational", "rotational"),
    ),
    Bad(
        "controller unknown for the closed loop",
        ("controller", "--mode inverse"),
        (*PREDICT, "--mode", "closed-loop"),
        lambda: Path("axis.toml").write_text(
            Path("axis.toml").read_text().partition("[controller]")[0]
        ),
    ),
    Bad(
        "own model with a slip of the pen",
        ("own.py, line 1", "valid Python"),
        ("check", "own.py"),
        write("own.py", "def trial(:\n"),
    ),
    Bad(
        "own model that stops",
        ("own.py, line 2", "ZeroDivisionError"),
        ("check", "own.py"),
        write("own.py", "a = 0\nb = 1 / a\n"),
    ),
    Bad(
        "own model without a model",
        ("own.py", "MODEL = FrictionModel"),
        ("check", "own.py"),
        write("own.py", "a = 0\n"),
    ),
    Bad(
        "own model that ends the program",
        ("own.py, line 1", "SystemExit: 7"),
        ("check", "own.py"),
        write("own.py", "raise SystemExit(7)\n"),
    ),
    Bad(
        "own model that is no text",
        ("own.py", "binary"),
        ("check", "own.py"),
        write("own.py", "a\0b"),
    ),
    *(
        Bad(
            f"own model with an unknown name, {arguments[0]}",
            ("own.py", "no_such_name", "is not defined", "bristle check"),
            arguments,
            lambda: (swap("own.py", "return p.F_0 *", "return no_such_name *")(), with_own_model()),
        )
        for arguments in (
            (*IDENTIFY, "--model", "own.py"),
            (*PREDICT, "--allow-code"),
            ("run", "experiment.toml", "--allow-code"),
        )
    ),
    Bad(
        "own model with the name of another",
        ("coulomb", "is the name of a model of bristle", 'FrictionModel(name="...")'),
        (*IDENTIFY, "--model", "own.py"),
        swap("own.py", 'name="own"', 'name="coulomb"'),
    ),
    Bad("model asked for twice", ("coulomb", "twice"), (*IDENTIFY, "--model", "coulomb,coulomb")),
    Bad(
        "slot given twice",
        ("+asymmetry", "twice"),
        (*IDENTIFY, "--model", "coulomb+asymmetry+asymmetry"),
    ),
    Bad("own model that is not there", ("gone.py",), ("check", "gone.py")),
]
ALL = [*COMMAND_LINES, *LOGS, *AXES, *EXPERIMENTS, *MODELS]


def is_readable(errors: str, words: tuple[str, ...]) -> None:
    lines = [
        line
        for line in errors.splitlines()
        if "warning: friction.file: the code in own.py" not in line
    ]
    assert len(lines) == 1, errors
    assert lines[0].startswith("bristle: ")
    assert 20 <= len(lines[0]) <= 600
    assert "Traceback" not in errors
    assert "fault of bristle" not in errors
    for word in words:
        assert word in lines[0], (word, lines[0])


@pytest.mark.fast_cases(74)
@pytest.mark.parametrize("bad", ALL, ids=[bad.name for bad in ALL])
def test_bad_input_is_refused_with_one_readable_line(bristle, place, bad):
    bad.make()
    before = {item: item.stat().st_mtime_ns for item in place.rglob("*")}
    out = (
        ("--out", "results")
        if bad.arguments[0] in ("identify", "predict", "run")
        and not {"--out", "--log"} & {*bad.arguments}
        else ()
    )
    ended = bristle(
        *bad.arguments, *out, *(() if bad.arguments[0] == "idenfity" else ("--json",)), code=2
    )
    assert ended.out == ""
    is_readable(ended.err, bad.words)
    assert {
        item: item.stat().st_mtime_ns
        for item in place.rglob("*")
        if "__pycache__" not in item.parts
    } == before


PLAIN = """
schema = 1
kind = "translational"
columns.time = { column = "t", unit = "s" }
columns.position = { column = "q", unit = "m" }
columns.effort = { column = "u", unit = "N" }
"""
FAST = '[limits]\nvelocity = "0.1 m/s"\nacceleration = "1 m/s^2"\n'
CONTACT = '[plant]\nmass = "28 kg"\npresliding = "7 um"\n[encoder]\nresolution = "1 um"\n[effort]\nlimit = "700 N"\n[limits]\njerk = '


@pytest.mark.parametrize(
    ("command", "advice", "before", "after"),
    [
        ("excite axis.toml", "Write velocity under [limits]", "", '[limits]\nvelocity = "0.1 m/s"'),
        (
            "excite axis.toml --for stribeck",
            "Write acceleration under [limits]",
            '[limits]\nvelocity = "0.1 m/s"',
            FAST,
        ),
        (
            "excite axis.toml --for stribeck --duration 2s",
            "Write stroke under [limits]",
            FAST,
            f'{FAST}stroke = ["-1 m", "1 m"]',
        ),
        (
            "excite axis.toml --for presliding,stribeck",
            "Write presliding under",
            "",
            '[plant]\npresliding = "7 um"',
        ),
        (
            "excite axis.toml --for damping,stribeck",
            "Raise jerk to 4900",
            f'{CONTACT}"1 m/s^3"',
            f'{CONTACT}"4900 m/s^3"',
        ),
        (
            "identify brief.csv --axis axis.toml",
            "lower the decimation",
            "",
            "identification.decimation = 1",
        ),
        (
            "log brief.csv --axis axis.toml",
            "and write sample_time under [timing]",
            "",
            'timing.sample_time = "1 ms"',
        ),
        (
            "predict model.toml brief.csv --axis axis.toml --mode closed-loop",
            "Describe the controller",
            "",
            "[controller]\nk_p = 80.0",
        ),
    ],
)
def test_advice_that_is_followed_is_not_given_again(bristle, place, command, advice, before, after):
    t = 1e-3 * np.arange(140.0) + 3e-4 * np.random.default_rng(1).uniform(-1.0, 1.0, 140)
    np.savetxt(
        "brief.csv",
        np.column_stack([t, np.sin(20.0 * t), np.cos(20.0 * t)]),
        delimiter=",",
        header="t,q,u",
        comments="",
    )
    for lines in (before, after):
        Path("axis.toml").write_text(PLAIN + lines, encoding="utf-8")
        ended = bristle(*command.split())
        assert (advice in " ".join((ended.out + ended.err).split())) == (lines == before)

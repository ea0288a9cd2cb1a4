"""Formats of logs: a line each, and one of a person's own without a line in the package."""

import re
from pathlib import Path

import numpy as np
import pytest

from bristle.cli.main import main
from bristle.core import InputError
from bristle.files.model import write_model
from bristle.files.user_model import load_reader_file
from bristle.logs.catalogue import FORMATS, format_of
from bristle.logs.formats import reading
from bristle.logs.readers import read_table
from bristle.models.friction import coulomb
from bristle.models.plants import inertia

pytestmark = pytest.mark.usefixtures("undrawn")

ROOT = Path(__file__).parents[2]
READER = ROOT / "examples" / "key_value_log.py"


def written(folder: Path, count: int) -> Path:
    """A log of so many rows that the reader of the pages reads."""
    t = np.arange(count) * 1e-3
    x, v = 20.0 * np.sin(np.pi * t), 20e-3 * np.pi * np.cos(np.pi * t)
    i = (30.0 * np.sign(v) + 200.0 * v - 95.0 * np.pi**2 * 1e-3 * x) / 50.0
    lines = [f"t_ms={k} pos={x[k]:.6f} iq={i[k]:.6f}" for k in range(count)]
    (folder / "drive.log").write_text("\n".join([*lines, ""]))
    (folder / "axis.toml").write_text(AXIS)
    return folder / "drive.log"


@pytest.fixture
def log(tmp_path) -> Path:
    return written(tmp_path, 400)


AXIS = """
schema = 1
kind = "translational"
[columns]
time = "t"
position = "position"
effort = "current"
[effort]
constant = "50 N/A"
"""


def custom(folder: Path) -> list[str]:
    return ["--axis", str(folder / "axis.toml"), "--reader", str(READER)]


def test_a_user_reader_serves_a_command_and_ends_with_it(log, tmp_path):
    assert main(["log", str(log), "--axis", str(tmp_path / "axis.toml")]) == 2
    assert main(["log", str(log), *custom(tmp_path)]) == 0
    assert format_of(log.read_bytes(), ".log").name == "csv"


@pytest.mark.parametrize(
    "command",
    [
        ["identify", "LOG", "--model", "coulomb"],
        ["predict", "MODEL", "LOG"],
        ["compare", "LOG", "LOG"],
    ],
)
def test_a_user_reader_serves_every_command(tmp_path, capsys, command):
    write_model(tmp_path / "model.toml", inertia(M=95.0), coulomb(F_C=30.0))
    places = {"LOG": str(written(tmp_path, 60)), "MODEL": str(tmp_path / "model.toml")}
    assert main([*(places.get(word, word) for word in command), *custom(tmp_path)]) == 2
    assert "is too short" in capsys.readouterr().err  # and no text without numbers, as to bristle


@pytest.mark.slow
def test_a_log_of_a_user_reader_is_identified_predicted_and_compared(tmp_path):
    log, results = written(tmp_path, 4000), tmp_path / "results"
    options = [
        *custom(tmp_path),
        "--model",
        "coulomb_viscous",
        "--draws",
        "0",
        "--out",
        str(results),
    ]
    assert main(["identify", str(log), *options]) == 0
    assert main(["predict", str(results / "model.toml"), str(log), *custom(tmp_path)]) == 0
    later = log.with_name("later.log")
    later.write_text(
        log.read_text() + log.read_text().splitlines()[-1].replace("t_ms=3999", "t_ms=4000") + "\n"
    )
    assert main(["compare", str(log), str(later), *custom(tmp_path)]) in (0, 1)


def test_its_columns_have_the_units_of_their_names(log):
    with reading(load_reader_file(READER)):
        table = read_table(log)
    assert (table.format, table.columns["t"][-1]) == ("lines of name=value", 399.0)
    assert dict(table.units) == {"t": "ms", "position": "mm", "current": "A"}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "    return {units",
            "    return 3, {units",
            "is read by key_value_log, which returned a tuple",
        ),
        (
            'split("=")',
            'split(":")',
            r"the reader of this file stopped with ValueError: dictionary update .* \(own\.py, line \d+\)\. Correct the reader",
        ),
        (
            "row[name])",
            "row['iq_promille'])",
            r"the reader of this file stopped with KeyError: 'iq_promille' \(own\.py, line 2\d\)",
        ),
    ],
)
def test_faults_of_a_user_reader_are_reported(log, tmp_path, old, new, said):
    text = READER.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "own.py").write_text(text.replace(old, new), encoding="utf-8")
    with reading(load_reader_file(tmp_path / "own.py")), pytest.raises(InputError, match=said):
        read_table(log)


def test_a_file_without_a_reader_is_refused():
    with pytest.raises(
        InputError,
        match=r"quadratic_drag\.py: defines no reader of logs\. End the file with FORMAT",
    ):
        load_reader_file(ROOT / "examples" / "quadratic_drag.py")


def test_help_lists_every_format_with_the_extra_that_its_reader_needs(capsys):
    main(["log", "--help"])
    listed = capsys.readouterr().out.partition("Formats:")[2].partition("Example:")[0]
    rows = dict(re.split(r" {2,}", row.strip(), maxsplit=1) for row in listed.strip().splitlines())
    assert list(rows) == [known.title for known in reversed(FORMATS)]
    assert {known.title: known.extra for known in FORMATS} == {
        title: (re.findall(r"\[(\w+)\]", needs) or [""])[0] for title, needs in rows.items()
    }


@pytest.mark.parametrize("command", ["identify", "predict"])
def test_help_names_the_command_that_lists_the_formats(command, capsys):
    main([command, "--help"])
    assert "bristle log --help lists" in " ".join(capsys.readouterr().out.split())

"""Formats of logs: a line each, and one of a person's own without a line in the package."""

from pathlib import Path

import numpy as np
import pytest

from bristle.cli.main import main
from bristle.cli.options import LOG_FILE
from bristle.core import InputError
from bristle.files.user_model import load_reader_file
from bristle.logs.catalogue import FORMATS, format_of
from bristle.logs.formats import reading
from bristle.logs.readers import read_table

pytestmark = pytest.mark.usefixtures("undrawn")

ROOT = Path(__file__).parents[2]
READER = ROOT / "examples" / "key_value_log.py"


@pytest.fixture
def log(tmp_path) -> Path:
    t = np.arange(4000) * 1e-3
    x, v = 20.0 * np.sin(np.pi * t), 20e-3 * np.pi * np.cos(np.pi * t)
    i = (30.0 * np.sign(v) + 200.0 * v - 95.0 * np.pi**2 * 1e-3 * x) / 50.0
    lines = [f"t_ms={k} pos={x[k]:.6f} iq={i[k]:.6f}" for k in range(t.size)]
    (tmp_path / "drive.log").write_text("\n".join([*lines, ""]))
    return tmp_path / "drive.log"


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


def test_a_reader_of_ones_own_serves_every_command_and_no_longer(log, tmp_path, capsys):
    axis = tmp_path / "axis.toml"
    axis.write_text(AXIS)
    assert main(["log", str(log), "--axis", str(axis)]) == 2
    capsys.readouterr()
    custom = ["--axis", str(axis), "--reader", str(READER)]
    assert main(["log", str(log), *custom]) == 0
    results = tmp_path / "results"
    assert main(["identify", str(log), *custom, "--model", "coulomb_viscous", "--draws", "0", "--out", str(results)]) == 0
    assert main(["predict", str(results / "model.toml"), str(log), *custom]) == 0
    later = log.with_name("later.log")
    later.write_text(log.read_text() + log.read_text().splitlines()[-1].replace("t_ms=3999", "t_ms=4000") + "\n")
    assert main(["compare", str(log), str(later), *custom]) in (0, 1)
    assert format_of(log.read_bytes(), ".log").name == "csv"


def test_its_columns_have_the_units_of_their_names(log):
    with reading(load_reader_file(READER)):
        table = read_table(log)
    assert table.format == "lines of name=value"
    assert dict(table.units) == {"t": "ms", "position": "mm", "current": "A"}
    assert table.columns["t"][-1] == 3999.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("    return {units", "    return 3, {units", "is read by key_value_log, which gives a tuple"),
        ('split("=")', 'split(":")', r"stops its reader with ValueError: dictionary update .* \(own\.py, line \d+\)\. Correct the reader"),
        ("row[name])", "row['iq_promille'])", r"stops its reader with KeyError: 'iq_promille' \(own\.py, line 2\d\)"),
    ],
)
def test_what_it_does_wrong_is_told(log, tmp_path, old, new, said):
    text = READER.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "own.py").write_text(text.replace(old, new), encoding="utf-8")
    with reading(load_reader_file(tmp_path / "own.py")), pytest.raises(InputError, match=said):
        read_table(log)


def test_a_file_without_a_reader_is_refused():
    with pytest.raises(InputError, match=r"quadratic_drag\.py: defines no reader of logs\. End the file with FORMAT"):
        load_reader_file(ROOT / "examples" / "quadratic_drag.py")


@pytest.mark.parametrize("known", FORMATS, ids=lambda known: known.name)
def test_help_and_docs_name_every_format(known):
    page = (ROOT / "docs/how-to/your-own-log.md").read_text(encoding="utf-8")
    for word in known.title.replace("traces of ", "").split():
        assert word in LOG_FILE, f"LOG_FILE of cli/options.py lacks {word!r}"
        assert word in page, f"the table under 'What is read' of docs/how-to/your-own-log.md lacks a row with {word!r}"

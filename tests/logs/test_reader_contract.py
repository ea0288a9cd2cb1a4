"""The contract of a reader of logs: those of bristle meet it, and each demand is missed by one that is wrong there."""

import json
import re
from pathlib import Path

import pytest
from tests.logs.binary_exports import BINARY
from tests.logs.conftest import WRITERS
from tests.logs.exports import EXPORTS, motion

from bristle.cli.main import main
from bristle.contract import check_reader
from bristle.contract.readers import READER_CHECKS, other_files
from bristle.files.user_model import load_reader_file
from bristle.logs import json_records
from bristle.logs.catalogue import FORMATS, format_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "key_value_log.py"
WRITTEN = {
    "hdf5": "h5",
    "parquet": "parquet",
    "npz": "npz",
    "tdms": "tdms",
    "mat": "mat",
    "csv": "csv",
}
EXPORTED = {
    "mf4": "MF4, one group",
    "mcap": "MCAP, JSON",
    "sinumerik": "SINUMERIK",
    "json_records": "records",
}


def bytes_of(name, folder, recording):
    """A small file of a format of bristle, written by another program or library."""
    if name in EXPORTED:
        return (EXPORTS | BINARY)[EXPORTED[name]].write(folder, motion(0.3)).read_bytes()
    if name not in WRITTEN:
        return b""  # check_reader takes the example of the format
    few = (
        {column: values[:300] for column, values in recording.items()}
        if name != "tdms"
        else recording
    )
    return WRITERS[WRITTEN[name]](folder / f"log.{WRITTEN[name]}", few).read_bytes()


@pytest.mark.parametrize(
    "log_format",
    [
        pytest.param(item, marks=[pytest.mark.slow] * bool(item.package), id=item.name)
        for item in FORMATS
    ],
)
def test_every_reader_of_bristle_meets_the_contract(log_format, tmp_path, recording):
    checks = check_reader(log_format, bytes_of(log_format.name, tmp_path, recording))
    assert [check for check in checks if not check.passed] == []
    assert len(checks) == len(READER_CHECKS)


@pytest.mark.parametrize(
    ("title", "name"),
    [
        ("NPZ", "npz"),
        ("HDF5", "hdf5"),
        ("Parquet", "parquet"),
        ("MF4", "mf4"),
        ("MCAP", "mcap"),
        ("TDMS", "tdms"),
        ("MAT", "mat"),
    ],
)
def test_a_file_in_a_user_format_has_its_title(title, name):
    assert format_of(other_files()[title], "").name == name


def test_a_reader_of_the_package_is_written_as_ones_own(tmp_path, recording):
    log_format = load_reader_file(json_records.__file__)
    checks = check_reader(log_format, bytes_of("new_format", tmp_path, recording))
    # JSON is read by the package already.
    assert [check.name for check in checks if not check.passed] == ["leaves other files"]


def test_the_reader_of_the_pages_meets_it():
    checks = check_reader(load_reader_file(EXAMPLE))
    assert [check for check in checks if not check.passed] == []
    assert len(checks) == len(READER_CHECKS)


def custom(folder, *changes):
    """The reader of the pages, with something in it written otherwise."""
    text = EXAMPLE.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "own.py").write_text(text, encoding="utf-8")
    return folder / "own.py"


ROWS = "    lines = data.decode()"
CUT = 'data.decode().split("\\n")[:-1]'
WHOLE = "data.decode().splitlines()"


@pytest.mark.parametrize(
    ("changes", "demand", "said", "mend"),
    [
        (
            [('"lines of name=value"', '" "')],
            "described reader",
            "the title is ' '",
            "Give the usual name",
        ),
        (
            [(", example=EXAMPLE.encode()", "")],
            "described reader",
            "there is no example",
            r"example=b",
        ),
        (
            [("example=EXAMPLE.encode()", "example=EXAMPLE")],
            "described reader",
            "there is no example",
            r"example=b",
        ),
        (
            [("    return len(first)", '    return suffix == ".kv" and len(first)')],
            "recognises its example",
            "in a file named log",
            "first 4096 bytes",
        ),
        (
            [("float(row[name])", "row[name]")],
            "columns of numbers",
            "it gives 0 columns",
            "arrays of numbers",
        ),
        (
            [("in rows]) for name", "in rows[len(name) % 2:]]) for name")],
            "columns of numbers",
            "'position' has 7 rows, and 't' has 8",
            "equal length",
        ),
        (
            [("t [ms]", "t [moments]")],
            "units that exist",
            "'moments', which does not exist",
            "omit the unit|Write",
        ),
        (
            [("for row in rows]", "for row in rows[4:] + rows[:4]]")],
            "time in order",
            "'t' decreases after row 4",
            "order",
        ),
        (
            [("float(row[name])", 'float("nan" if name == "t_ms" else row[name])')],
            "time in order",
            "not numbers",
            "without a time",
        ),
        (
            [
                (ROWS, "    recognises.calls = getattr(recognises, 'calls', 0) + 1\n" + ROWS),
                ("float(row[name])", "recognises.calls + float(row[name])"),
            ],
            "same log twice",
            "the second reading differs",
            "no counter",
        ),
        (
            [("    return len(first)", "    return True or len(first)")],
            "leaves other files",
            "a file of another format",
            "more of the first bytes",
        ),
        (
            [("    first = head", "    head.decode()\n    first = head")],
            "leaves other files",
            "recognises stops with UnicodeDecodeError",
            "Return False",
        ),
        (
            [(CUT, WHOLE)],
            "tells where a file ends early",
            r"row \d of .* instead of .* in the whole file",
            "incomplete last row",
        ),
        (
            [
                (
                    "    units =",
                    "    rows = [row for row in rows if 'iq' in row] or [{'t_ms': 0, 'pos': 0}]\n    units =",
                )
            ],
            "tells where a file ends early",
            "has 0 rows, without a note",
            "Raise InputError",
        ),
        (
            [
                ("import numpy as np", "import numpy as np\n\nfrom bristle.core import InputError"),
                (
                    ROWS,
                    "    if len(data) < len(EXAMPLE):\n        raise InputError('is cut off', path='log')\n"
                    + ROWS,
                ),
            ],
            "tells where a file ends early",
            "refused without its name: log: is cut off",
            r"path=str\(request\.source\)",
        ),
    ],
)
def test_faults_of_a_reader_are_reported_with_advice(tmp_path, changes, demand, said, mend):
    failed, *_ = [
        check
        for check in check_reader(load_reader_file(custom(tmp_path, *changes)))
        if not check.passed
    ]
    assert failed.name == demand
    assert re.search(f"{said}.*\n.*({mend})", f"{failed.detail}\n{failed.advice}")


def test_a_reader_that_exits_is_reported_with_its_line(tmp_path):
    file = custom(tmp_path, (ROWS, "    raise SystemExit\n" + ROWS))
    (failed,) = [check for check in check_reader(load_reader_file(file)) if not check.passed]
    assert (failed.name, failed.detail) == (
        "columns of numbers",
        "stops with SystemExit:  (own.py, line 18)",
    )


def test_check_runs_the_contract_of_a_reader(capsys):
    assert main(["check", str(EXAMPLE), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["model"], data["passed"], len(data["certificates"])) == (
        "key_value_log",
        True,
        len(READER_CHECKS),
    )


def test_check_names_the_demand_that_a_reader_misses(tmp_path, capsys):
    assert main(["check", str(custom(tmp_path, (CUT, WHOLE)))]) == 1
    shown = capsys.readouterr()
    assert "Contract of the log reader key_value_log" in shown.out
    assert "tells where a file ends early: truncated to" in shown.err

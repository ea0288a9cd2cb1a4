"""What an axis file says of the columns is shown on the data, or refused in the words of the command line."""

import json
from contextlib import nullcontext
from pathlib import Path

import pytest

from bristle.core.content import Content
from bristle.core.errors import InputError
from bristle.files import read_axis
from bristle.files.summary import plain
from bristle.server.errand import Errand, LabelledLog
from bristle.server.tasks import look

LOG = "time,x,force\n" + "".join(f"{0.001 * row:.3f},{0.1 * (row % 40)},{row % 7}\n" for row in range(400))


@pytest.fixture
def looked(tmp_path):
    (tmp_path / "file-1").write_text(LOG)
    log = LabelledLog(tmp_path / "file-1", "log.csv", "fit")

    def looked(text, **edits):
        errand = Errand(tmp_path, (log,), text, "axis.toml", {"edits": edits}, 2**20, None, lambda *_: None, nullcontext)
        facts, data = look(errand)
        return facts, json.loads(json.dumps(plain(data), allow_nan=False))

    return looked


def test_a_column_may_be_named_in_short(looked):
    text = 'schema = 1\nkind = "translational"\n[columns]\ntime = "time"\nposition = "x"\neffort = "force"\n'
    facts, data = looked(text)
    assert facts["axis_text"] == text
    assert facts["ready"]
    assert [(plot["word"], plot["unit"], plot["column"]) for plot in data["plots"]] == [("position", "m", "x"), ("effort", "N", "force")]
    facts, data = looked(text, **{"columns.position.unit": "mm"})
    assert read_axis(facts["axis_text"].encode()).columns["position"].unit == "mm"


@pytest.mark.parametrize(
    "columns",
    [
        "columns = 3",
        'columns = ["x"]',
        '[[columns]]\nposition = "x"',
        "[columns]\nposition = true",
        '[columns]\nposition = ["x"]',
        '[columns]\nposition = { column = ["x"] }',
        "[columns]\nposition = 2020-01-01",
        "[columns]\nposition = -2",
        '[columns]\ntime = 1.5\nposition = "x"',
        '[columns]\nposition = { column = "x", unit = ["m"] }',
        '[effort]\nlag = 10:00:00\n[columns]\nposition = "x"',
    ],
)
def test_an_unknown_column_is_refused_as_in_the_terminal(looked, columns):
    text = f"schema = 1\n{columns}\n"
    with pytest.raises(InputError) as refused:
        read_axis(Content(Path("axis.toml"), text.encode()))
    facts, data = looked(text)
    assert not facts["ready"]
    assert data["refusal"] == str(refused.value)


def test_invalid_toml_is_reported_for_the_dropped_file(looked):
    with pytest.raises(InputError, match=r"^axis\.toml: .*line 2"):
        looked("schema = 1\n=\n")

"""``bristle export --to my_target.py``: a target of a person's own is used, told and refused as those of bristle."""

import shutil
from pathlib import Path

import pytest
from tests.cli.conftest import written_in
from tests.exports.test_targets import EXAMPLE, target_file

pytestmark = pytest.mark.usefixtures("undrawn")


def test_a_user_target_is_used_like_a_built_in_target(bristle, place):
    shutil.copy(EXAMPLE, "own_exporter.py")
    line = ("export", "model.toml", "--to", "own_exporter.py", "--speed", "200 mm/s", "--axis", "axis.toml")
    result = bristle(*line, "--name", "knee", "--out", "out", "--json")
    assert (result.code, result.data["target"], result.data["files"]) == (0, "acme", ["knee.toml"])
    assert result.data["provenance"]["target"] == "own_exporter.py"
    assert len(result.data["provenance"]["target_sha256"]) == 64
    assert written_in("out") == {"knee.toml", "summary.json"}
    message = bristle(*line, "--out", "other")
    assert message.code == 0
    assert "Note: the drive takes 16 entries" in message.out
    assert bristle(*line, "--out", "out").code == 2  # it is there already
    assert bristle(*line, "--tunable", "--out", "third").err.count("acme: does not support parameters that change") == 1
    assert not Path("third").exists()


def test_a_failing_target_leaves_no_files_and_reports_its_line(bristle, place):
    target_file(place, "1 // 0")
    ended = bristle("export", "model.toml", "--to", "mine.py", "--out", "out")
    assert ended.code == 2
    assert "mine.py, line 3: stops with ZeroDivisionError" in ended.err
    assert "bristle check mine.py" in ended.err
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("TARGET =", "TARGETS =", "defines no target of the export"),
        ("name='mine'", "name='c'", "an invalid name; found 'c'"),
        ("name='mine'", "name='My drive'", "an invalid name"),
        ("description='something'", "description=' '", "TARGET has no description"),
        ("write=write", "write=None", "TARGET has no function write"),
    ],
)
def test_a_file_that_is_no_target_is_refused_before_anything_is_read(bristle, place, old, new, said):
    file = target_file(place)
    file.write_text(file.read_text().replace(old, new))
    ended = bristle("export", "nowhere.toml", "--to", "mine.py", "--out", "out")
    assert ended.code == 2
    assert said in ended.err
    assert "mine.py" in ended.err


def test_check_runs_the_contract_of_a_target(bristle, place):
    target_file(place)
    result = bristle("check", "mine.py", "--json")
    assert (result.code, result.data["model"], result.data["passed"]) == (0, "mine", True)
    target_file(place, "Product({'a.txt': 'a'}, ('note',))")
    failed = bristle("check", "mine.py")
    assert failed.code == 1
    assert "Contract of the export target mine" in failed.out
    assert "notes in words: a note is 'note'" in failed.err

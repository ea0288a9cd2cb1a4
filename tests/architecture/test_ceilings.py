"""No folder is larger or denser than its ceiling, and a ceiling is raised by a commit of its own."""

import shutil
import subprocess
import sys
import tomllib

import pytest
from tests.architecture import ceilings

PLAIN = '''
"""Words."""

def longer(a, b):
    """Return the longer."""
    if len(a) > len(b):
        return a
    return b
'''
CASES = {
    "plain": (PLAIN, {"weight": 4, "conditions": 0.0, "further_names": 0.0}),
    "a conditional expression": (
        "x = 1 if y else 3",
        {"weight": 3, "conditions": 1000.0, "literals": 1},
    ),
    "further names": ("a, b, c = 5, y, z", {"weight": 3, "further_names": 2000.0}),
    "a swap of a call is none": ("a, b = f()", {"weight": 1, "further_names": 0.0}),
    "or whose value is used": ("x = y or 'default'", {"conditions": 1000.0}),
    "or of truths": ("x = is_empty(y) or y > 3", {"conditions": 0.0}),
    "or of a branch": ("if x or y:\n    z = 1", {"conditions": 0.0}),
    "a product by a condition": ("x = 's' * (n != 1)", {"conditions": 1000.0}),
    "an index by a condition": ("x = ('a', 'b')[n > 1]", {"conditions": 1000.0}),
    "an assignment inside": ("f(y := 1)", {"conditions": 1000.0}),
    "a compiled function": (
        "@kernel\ndef f(a):\n    return 1.0 if a else 0.0\nx = 1",
        {"weight": 5, "conditions": 0.0},
    ),
    "any": ("x: Any = f(y)  # type: ignore[misc]", {"any": 1, "ignores": 1}),
    "code in a string": ("x = '''\nfor (;;) {\n  y = 1;\n}\n'''", {"text_lines": 3}),
}


@pytest.mark.parametrize("name", CASES)
def test_a_row_counts(name):
    text, expected = CASES[name]
    sums = ceilings.Sums()
    sums.add(text)
    row = sums.row()
    assert {column: row[column] for column in expected} == expected


@pytest.mark.slow
@pytest.mark.parametrize(("table", "row"), ceilings.rows(), ids=map(".".join, ceilings.rows()))
def test_no_value_is_above_its_ceiling(table, row):
    values = {table: {row: ceilings.rows()[table, row]()}}
    lines = ceilings.above(values, ceilings.ceilings())
    assert not lines, "\n".join(
        [*lines, "Make it smaller; python -m tests.architecture.ceilings shows all rows."]
    )


def test_a_value_above_its_ceiling_is_found():
    limits = {"package": {"core": {"weight": 100}}}
    assert ceilings.above({"package": {"core": {"weight": 101}}}, limits) == [
        "package.core.weight: 101, ceiling 100"
    ]
    assert not ceilings.above({"package": {"core": {"weight": 100}}}, limits)
    assert ceilings.above({"package": {"rooms": {"weight": 1}}}, limits) == [
        "package.rooms.weight: 1 has no ceiling"
    ]


def test_lowering_leaves_one_percent_and_never_raises():
    values = {"package": {"core": {"weight": 1000, "conditions": 10.0}, "logs": {"weight": 3000}}}
    limits = {"package": {"core": {"weight": 2000, "conditions": 10.1}, "logs": {"weight": 2000}}}
    assert (ceilings.lowered(values, limits), ceilings.ceilings(ceilings.written(limits))) == (
        {"package": {"core": {"weight": 1010, "conditions": 10.1}, "logs": {"weight": 2000}}},
        limits,
    )


@pytest.mark.skipif(not shutil.which("git"), reason="needs bash and git")
def test_a_raised_ceiling_is_found_in_the_history(tmp_path, monkeypatch):
    folder = tmp_path / "tests" / "architecture"
    folder.mkdir(parents=True)
    file = folder / "ceilings.toml"
    monkeypatch.setattr(ceilings, "ROOT", tmp_path)
    monkeypatch.setattr(ceilings, "FILE", file)

    def commit(weight, other=""):
        file.write_text(f"[package]\ncore = {{ weight = {weight} }}\n", encoding="utf-8")
        if other:
            (tmp_path / other).write_text(str(weight), encoding="utf-8")
        git("add", "-A")
        git("commit", "-q", "-m", "x")

    def git(*words):
        who = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True)

    git("init", "-q")
    commit(100)
    commit(90, "lowered.py")
    commit(95)
    assert not ceilings.raised_beside("HEAD~2")
    commit(99, "raised.py")
    assert not ceilings.raised_beside("HEAD~3")
    commit(101, "raised.py")
    lines = ceilings.raised_beside("HEAD~4")
    assert len(lines) == 2  # the one from 95 to 99 counts now
    assert all("raises package.core.weight beside other changes" in line for line in lines)


def test_the_file_is_readable_and_covers_each_folder():
    limits = tomllib.loads(ceilings.FILE.read_text(encoding="utf-8"))
    folders = ceilings.folders(ceilings.PACKAGE)
    assert set(limits["package"]) == {
        ".",
        *(folder.relative_to(ceilings.PACKAGE).as_posix() for folder in folders),
    }
    assert len(limits["tests"]) > 25


@pytest.mark.slow
def test_the_command_shows_all_rows():
    ended = subprocess.run(
        [sys.executable, "-m", "tests.architecture.ceilings"],
        cwd=ceilings.ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "package.identification.weight" in ended.stdout

"""Mutation testing: what counts as a fault, which tests are asked, and that the working tree stays as it is."""

import ast
import json
import subprocess
from pathlib import Path

import pytest
from tests.mutants import __main__ as mutants
from tests.mutants.mutations import applied, chosen, mutants_of
from tests.mutants.related import Imports

ROOT = Path(__file__).parents[2]
SOURCE = '''
"""A text, 1 + 1."""
__all__ = ["first"]
STEP: float = 0.5  # µ, two bytes
FLAGS = frozenset({"a" "b"})


@kernel(inline=False)
def first(x: "1 < 2", y=3) -> "4":
    """Return 5."""
    if x < y and x > 0:
        raise ValueError(f"{x + 1} is not {y - 1}", 6)
    µ = max(x, y) / 2
    µ += x
    told = f"{x * y}"
    for µ in zip(range(1), x, strict=True):
        if TYPE_CHECKING:
            µ += x
    return µ


class Shape(NamedTuple):
    """A shape."""

    size: Annotated[float, Variable("length", min=7.0)] = 8.0
'''.encode()


def faults(line):
    result = mutants_of("src/bristle/room/module.py", SOURCE)
    return {(item.kind, item.old, item.new) for item in result if item.line == line}


def test_each_kind_of_fault_is_put_where_it_fits():
    assert faults(4) == {("constant", "0.5", item) for item in ("0.0", "1.0", "1.5", "-0.5")}
    assert faults(9) == {("constant", "3", item) for item in ("0", "2", "4", "6")}
    assert faults(11) == {
        ("comparison", "<", ">"),
        ("comparison", ">", "<"),
        ("and/or", "and", "or"),
        ("constant", "0", "1"),
        ("constant", "0", "-1"),
        ("condition", "x < y and x > 0", "(not (x < y and x > 0))"),
    }
    assert faults(13) > {("min/max", "max", "min"), ("arithmetic", "/", "*")}
    assert faults(14) == {("arithmetic", "+", "-"), ("statement", "µ += x", "pass")}
    assert faults(16) == {("constant", "1", item) for item in ("0", "2")}, "nothing of strict=True"
    assert faults(19) == {("return", "µ", "None")}
    assert faults(25) == {("constant", "8.0", item) for item in ("0.0", "7.0", "9.0", "16.0")}


def test_texts_declarations_and_raises_are_not_mutated():
    assert {item.line for item in mutants_of("src/bristle/room/module.py", SOURCE)} == {
        4,
        9,
        11,
        13,
        14,
        16,
        19,
        25,
    }


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name",
    ["models/controllers/cascade.py", "engine/efim.py", "simulation/certificates/certify.py"],
)
def test_every_mutant_is_a_valid_and_different_program(name):
    path = f"src/bristle/{name}"
    source = (ROOT / path).read_bytes()
    whole = ast.dump(ast.parse(source))
    for mutant in mutants_of(path, source)[::5]:
        assert ast.dump(ast.parse(applied(mutant, source))) != whole, mutant


def test_a_larger_sample_includes_a_smaller_sample_and_moved_lines():
    sources = dict.fromkeys(("src/bristle/a/a.py", "src/bristle/b/b.py"), SOURCE)
    few, many = (chosen(sources, count, 1, set()) for count in (4, 9))
    assert len({(item.path, item.line) for item in many}) == len(many) == 9
    assert many[:4] == few != chosen(sources, 4, 2, set())[:4]
    moved = sources | {few[0].path: b"import this\n\n" + sources[few[0].path]}
    keys = [
        [item.key(source[item.path]) for item in chosen(source, 4, 1, set())]
        for source in (sources, moved)
    ]
    assert keys[0] == keys[1]
    assert few[0] not in chosen(sources, 9, 1, {few[0].key(sources[few[0].path])})


def test_shares_are_equal_and_cover_each_fault_once():
    sample = chosen({"src/bristle/a/a.py": SOURCE}, 8, 1, set())
    shares = [mutants.shared(sample, share, 3) for share in (1, 2, 3)]
    assert [len(share) for share in shares] == [3, 3, 2]
    assert sorted(item for share in shares for item in share) == sorted(sample)
    assert mutants.shared(sample, 1, 1) == sample


@pytest.mark.parametrize("text", ["0/3", "4/3", "2", "1/0", "a/3", "-1/3"])
def test_a_share_is_a_whole_number_of_a_whole_number(text, capsys):
    with pytest.raises(SystemExit):
        mutants.main([f"--share={text}"])
    assert f"'{text}' is not K/N with K from 1 to N, such as 2/8" in capsys.readouterr().err


@pytest.mark.slow
def test_the_nearest_tests_come_first():
    imports = Imports(ROOT)
    assert imports.tests_of("src/bristle/engine/efim.py")[0] == "tests/engine/test_efim.py"
    assert (
        imports.tests_of("src/bristle/models/controllers/velocity.py")[0]
        == "tests/models/controllers/test_by_hand.py"
    )
    assert (
        imports.tests_of("src/bristle/engine/step_doubling.py")[0]
        == "tests/engine/test_step_doubling.py"
    )
    assert "tests/simulation/certificates/test_passive.py" in imports.tests_of(
        "src/bristle/models/friction/elastoplastic.py"
    )


@pytest.fixture
def house(tmp_path):
    """A repository with a package of two rooms: one is tested, the other is not."""
    files = {
        "src/bristle/__init__.py": "",
        "src/bristle/kept/__init__.py": "",
        "src/bristle/left/__init__.py": "",
        "src/bristle/kept/double.py": "def double(x):\n    return x + x\n",
        "src/bristle/left/half.py": "def half(x):\n    return x / 2\n",
        "tests/test_double.py": "from bristle.kept.double import double\n"
        "from bristle.left.half import half\n\n\n"
        "def test_double():\n    assert double(3) == 6 and half(0) == 0\n",
        "tests/test_broken.py": "from bristle.kept.double import double\n\n\ndef test_it():\n    assert False\n",
        "pyproject.toml": '[tool.pytest.ini_options]\nmarkers = ["slow: long"]\n',
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    return tmp_path


@pytest.mark.slow
def test_surviving_mutants_are_reported_and_the_tree_is_unchanged(
    house, tmp_path_factory, monkeypatch, capsys
):
    monkeypatch.setattr(mutants, "ROOT", house)
    monkeypatch.setattr(mutants, "GROUPS", {"tested": ("kept",), "untested": ("left",)})
    out = tmp_path_factory.mktemp("out") / "found.json"
    before = {load: load.read_bytes() for load in house.rglob("*.py")}
    requested = ["--processes", "2", "--out", str(out)]
    assert mutants.main([*requested, "--least", "0.5"]) == 1, "one group has no test that notices"
    text = capsys.readouterr().out
    assert "left out: tests/test_broken.py fails by itself" in text
    result = {load["path"]: load for load in json.loads(out.read_text())["results"].values()}
    assert result["src/bristle/kept/double.py"]["outcome"] == "killed"
    assert result["src/bristle/kept/double.py"]["by"] == "tests/test_double.py::test_double"
    assert result["src/bristle/left/half.py"]["outcome"] == "survived"
    assert "src/bristle/left/half.py:2  " in text
    assert "  - return x / 2\n  + return " in text
    assert {load: load.read_bytes() for load in house.rglob("*.py")} == before
    assert mutants.main([*requested, "--least-group", "0.0"]) == 1, "half of all is less than most"
    assert mutants.main([*requested, "--least", "0.5", "--least-group", "0.0"]) == 0
    assert "0 of them to be tried" in capsys.readouterr().out
    assert mutants.main([*requested, "--share", "1/2"]) == 0, (
        "the share of the group that is tested"
    )
    assert "1 faults in 1 files, 0 of them to be tried" in capsys.readouterr().out
    assert mutants.main([*requested, "--share", "3/3"]) == 0
    assert "no faults to be tried" in capsys.readouterr().out


def test_each_part_of_the_package_is_in_a_single_group():
    rooms = [room for group in mutants.GROUPS.values() for room in group]
    package = ROOT / "src" / "bristle"
    files = [*package.glob("*/__init__.py"), *package.glob("apps/*/__init__.py")]
    folders = {file.parent.relative_to(package).as_posix() for file in files} - {"apps"}
    assert sorted(rooms) == sorted(folders)


def test_a_long_test_file_does_not_block_the_others():
    seconds = {"long": 90.0, "near": 20.0, "failed": None, "further": 30.0, "last": 30.0}
    assert mutants.within(list(seconds), seconds, 60.0) == ["near", "further"]
    assert mutants.within(["long", "failed"], seconds, 60.0) == ["long"]
    assert mutants.within(["failed"], seconds, 60.0) == []


def test_files_for_all_parts_follow_the_nearest_files_once():
    seconds = {"near": 20.0, "both": 9.0, "wide": 50.0, "failed": None}
    assert mutants.near_and_wide(["near", "both"], ["failed", "both", "wide"], seconds, 60.0) == [
        "near",
        "both",
        "wide",
    ]
    assert all((ROOT / name).is_file() for name in mutants.WIDE)


@pytest.fixture(scope="module")
def told():
    """What is told to be no fault, and the files that it is in."""
    told = mutants.told_equivalent()
    return told, {path: (ROOT / path).read_bytes() for path in {item["path"] for item in told}}


def test_listed_equivalents_stand_in_their_files_and_have_a_reason(told):
    items, sources = told
    assert [item for item in items if item["line"] not in sources[item["path"]].decode()] == []
    assert all(len(item["because"]) > 20 for item in items)
    few = {path: sources[path] for path in sorted(sources, key=lambda path: len(sources[path]))[:3]}
    assert len(mutants.equivalents(few)) >= sum(item["path"] in few for item in items)


@pytest.mark.slow
def test_each_listed_equivalent_is_a_fault_that_would_be_tried(told):
    items, sources = told
    assert len(mutants.equivalents(sources)) >= len(items)

"""Names say what a thing is: pronouns and vague participles are none. Their rate is held, and can only fall.

``python tests/architecture/test_names.py`` prints the rate of every folder and the names that make it.
"""

import ast
from collections import Counter
from pathlib import Path

import pytest

import bristle

pytestmark = pytest.mark.slow
ROOT = Path(bristle.__file__).parent
WORDS = """
one ones other others another it its itself they them their theirs this that these those what which who whom whose
some several each every all_of both either same such everything everyone something anything nothing
here there where when why how
asked given told found said wanted meant known kept made done seen heard thought taken shown got gone put
sight workbench twin room thing things whole
"""  # in prose they point at what was named before; a name has nothing before it
VAGUE = frozenset(WORDS.split())
RATE = 3.0  # per 1000 identifiers
CEILINGS: dict[
    str, int
] = {}  # of folders that still wait for better names: these numbers only fall


def is_vague(name):
    """Whether a name is one of the words, be it private, a constant or numbered (`_found`, `FOUND`, `found_2`)."""
    return name.strip("_").rstrip("0123456789").strip("_").lower() in VAGUE


def identifiers(tree):
    """Yield each name wherever the code gives it to something; its uses do not count."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            yield node.name
        elif isinstance(node, ast.alias) and node.asname:
            yield node.asname
        elif isinstance(node, (ast.ExceptHandler, ast.MatchAs, ast.MatchStar)) and node.name:
            yield node.name


def counted(root=ROOT):
    """Return, by folder, how many identifiers there are and how often each vague one is bound."""
    totals, vague = Counter(), {}
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root).parts
        folder = parts[0] if len(parts) > 1 else ""
        names = [path.stem, *identifiers(ast.parse(path.read_text(encoding="utf-8")))]
        totals[folder] += len(names)
        vague.setdefault(folder, Counter()).update(name for name in names if is_vague(name))
    return totals, vague


@pytest.fixture(scope="module")
def package():
    return counted()


def test_a_folder_names_no_more_things_by_a_pronoun_than_it_may(package):
    totals, vague = package
    for folder, names in vague.items():
        allowed = CEILINGS.get(folder, RATE * totals[folder] / 1000.0)
        assert names.total() <= allowed, (
            f"{folder}: {names.total()} of {totals[folder]}: {names.most_common(8)}"
        )


def test_the_package_without_the_folders_that_wait_holds_the_rate(package):
    totals, vague = package
    done = [folder for folder in totals if folder not in CEILINGS]
    assert sum(vague[folder].total() for folder in done) < RATE / 1000.0 * sum(
        totals[folder] for folder in done
    )


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("one = 1", ["one"]),
        ("a = [one for one in b]", ["one"]),
        ("def f(a, *told, given=1, **its): return one", ["told", "given", "its"]),
        ("self.found = 1", ["found"]),
        ("def _found(): pass", ["_found"]),
        ("class Workbench: whole: int = 0", ["Workbench", "whole"]),
        ("lambda which: other", ["which"]),
        ("import a as known", ["known"]),
        ("try:\n    a\nexcept E as this:\n    pass", ["this"]),
        ("FOUND_2, room = 1, 2", ["FOUND_2", "room"]),
        ("found_peaks = one.other(told=those)", []),
    ],
)
def test_the_count_finds_vague_names(code, names):
    assert sorted(name for name in identifiers(ast.parse(code)) if is_vague(name)) == sorted(names)


def test_a_module_named_so_counts(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "given.py").write_text("a = 1\n")
    totals, vague = counted(tmp_path)
    assert totals == {"folder": 2}
    assert vague["folder"] == {"given": 1}


if __name__ == "__main__":
    totals, vague = counted()
    for folder, total in sorted(totals.items()):
        count = vague[folder].total()
        most = vague[folder].most_common(6)
        print(
            f"{folder or '.':16s} {count:5d} of {total:6d}  {1000.0 * count / total:6.1f}  {most}"
        )
    count = sum(names.total() for names in vague.values())
    print(f"{'all':16s} {count:5d} of {totals.total():6d}  {1000.0 * count / totals.total():6.1f}")

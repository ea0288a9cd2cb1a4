"""Hand-written prose keeps to plain English: its rate of private idioms is at most three times that of two known projects.

``python tests/architecture/test_idioms.py [FOLDER]`` prints the rates, and with ``--lines`` each line that has an idiom.
With the folder of an unpacked source distribution it measures that project: so the rate of the anchors was found.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
GENERATED = "<!-- Written by docs/generate.py"
PREPOSITIONS = (
    "in",
    "on",
    "at",
    "of",
    "by",
    "to",
    "for",
    "from",
    "with",
    "over",
    "after",
    "under",
    "into",
    "upon",
    "along",
    "during",
)
IDIOMS = {
    "what as a noun": r"\bwhat(?:ever)?\b",
    "which as a noun": "".join(rf"(?<!\b{word})" for word in PREPOSITIONS)
    + r"(?<![,;(])\s\bwhich\b",
    "none, nothing": r"\b(?:(?-i:none)|(?-i:None) (?:of|is|are|that)|nothing|nobody|nowhere)\b",
    "a pronoun for a thing": r"\b(?:one's|(?:that|this|such a|is|are|as) one|the ones?|one of both|of (?:its|one's|their) own)\b",
    "is told, is said": r"\b(?:told|tells?|telling|said|says?)\b",
    "alike, beside": r"\b(?:alike|beside|likewise|otherwise than)\b",
    "errs": r"\b(?:errs?|erring)\b",
    "takes back, goes with": r"\b(?:tak(?:es?|ing|en) back|go(?:es)? (?:with|on)|gone on)\b",
    "comes out, lies open": r"\b(?:comes? back|com(?:es?|ing) out|came out|leaves? over|(?:lies?|left) open)\b",
    "stands": r"\bst(?:ands?|ood|anding)\b(?! still)",
    "held": r"\bheld\b(?! (?:constant|fixed))(?!-out)(?! out)",
    "lets pass": r"\blets? (?:pass|go|through)\b",
    "hands in, takes off": r"\b(?:hand(?:s|ed|ing)? (?:in|out|over)|t(?:ak(?:es?|ing|en)|ook) off|led along)\b",
    "by itself": r"\b(?:by (?:it|them)sel(?:f|ves)|as it is|as they are|as it was)\b",
}
PATTERNS = {name: re.compile(pattern, re.IGNORECASE) for name, pattern in IDIOMS.items()}
# Idioms in 1000 words of the README and docstrings in the source distributions of diffrax 0.7.2 and pyhf 0.7.6.
ANCHOR = 2.0
CODE = re.compile(r"^(```|~~~).*?^\1", flags=re.MULTILINE | re.DOTALL)
WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")


def prose_of_markdown(text: str) -> str:
    """The words of a page, without code, addresses and formulas."""
    text = re.sub(r"<!--.*?-->", " ", CODE.sub(" ", text), flags=re.DOTALL)
    text = re.sub(r"`[^`\n]*`", " ", text)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"\$[^$\n]+\$|<[^>\n]+>|[|*_#]", " ", text)


def prose_of_python(text: str) -> Iterator[str]:
    """Docstrings, and every text of four words or more."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            plain = re.sub(r"^\s*>>>.*$", " ", node.value, flags=re.MULTILINE)
            plain = re.sub(r"``?[^`]*``?|\{[^}]*\}", " ", plain)
            if len(WORD.findall(plain)) >= 4:
                yield plain


def names_of_tests(text: str) -> Iterator[str]:
    """The names of test functions, as words."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and node.name.startswith(
            "test_"
        ):
            yield node.name.removeprefix("test_").replace("_", " ")


def idioms_in(text: str) -> Counter[str]:
    """How often each idiom stands in a text."""
    return Counter({name: len(pattern.findall(text)) for name, pattern in PATTERNS.items()})


def files(root: Path, ending: str) -> Iterator[Path]:
    """The files of a project, without those of an environment in a hidden folder."""
    return (
        path
        for path in root.rglob(ending)
        if not any(part.startswith(".") for part in path.relative_to(root).parts)
    )


def pages(root: Path) -> dict[str, list[str]]:
    """The hand-written pages of a project."""
    paths = [
        path
        for ending in ("*.md", "*.rst")
        for path in files(root, ending)
        if "build" not in path.parts
    ]
    texts = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths}
    return {
        path: [prose_of_markdown(text)] for path, text in texts.items() if GENERATED not in text
    }


def strings(root: Path) -> dict[str, list[str]]:
    """Docstrings and texts of the code of a project, without its tests."""
    paths = (
        path
        for path in files(root, "*.py")
        if not {"tests", "test", "benchmarks", "build"} & set(path.relative_to(root).parts)
    )
    return {
        str(path.relative_to(root)): list(prose_of_python(path.read_text(encoding="utf-8")))
        for path in paths
    }


def names(root: Path) -> dict[str, list[str]]:
    """The names of the tests of a project."""
    paths = files(root, "test_*.py")
    return {
        str(path.relative_to(root)): list(names_of_tests(path.read_text(encoding="utf-8")))
        for path in paths
    }


def rate(texts: Iterable[str]) -> tuple[float, Counter[str], int]:
    """Idioms in 1000 words, the count of each, and the words."""
    joined = list(texts)
    words = sum(len(WORD.findall(text)) for text in joined)
    counts = sum((idioms_in(text) for text in joined), Counter())
    return 1000.0 * counts.total() / max(words, 1), counts, words


@pytest.mark.parametrize(
    "kind",
    [
        pages,
        pytest.param(strings, marks=pytest.mark.slow),
        pytest.param(names, marks=pytest.mark.slow),
    ],
)
def test_prose_has_at_most_three_times_the_idioms_of_the_anchors(kind):
    value, counts, words = rate(text for page in kind(ROOT).values() for text in page)
    assert words > 20_000
    assert value <= 3.0 * ANCHOR, counts


@pytest.mark.parametrize(
    ("text", "idiom"),
    [
        ("Return what the model lacks.", "what as a noun"),
        ("the bits tell which model is better", "which as a noun"),
        ("there is none for it", "none, nothing"),
        ("a knob of its own", "a pronoun for a thing"),
        ("the axis is told by a file", "is told, is said"),
        ("both are alike", "alike, beside"),
        ("the loop errs", "errs"),
        ("the search goes on", "takes back, goes with"),
        ("it comes back on each cycle", "comes out, lies open"),
        ("the unit stands behind it", "stands"),
        ("the value is held", "held"),
        ("which the filter lets pass", "lets pass"),
        ("a file that is handed in", "hands in, takes off"),
        ("it computes by itself", "by itself"),
    ],
)
def test_each_idiom_is_counted(text, idiom):
    assert idioms_in(text)[idiom] == 1


@pytest.mark.parametrize(
    "text",
    [
        "None if the log has no reference.",
        "the file, which bristle reads",
        "the time at which it stops",
        "held constant",
        "a held-out block",
        "a standard error",
    ],
)
def test_plain_english_is_not_counted(text):
    assert idioms_in(text).total() == 0


def test_code_addresses_and_formulas_are_not_prose():
    assert (
        idioms_in(prose_of_markdown("`what` [a](what.md) $what$\n```sh\nwhat\n```\n")).total() == 0
    )
    assert list(prose_of_python('x = "what is told"\ny = "what is told by none of it"\n')) == [
        "what is told by none of it"
    ]
    assert list(names_of_tests("def test_what_is_told(): pass\ndef other(): pass\n")) == [
        "what is told"
    ]


def main(*arguments: str) -> None:
    options = [argument for argument in arguments if argument.startswith("--")]
    folder = next((argument for argument in arguments if not argument.startswith("--")), str(ROOT))
    for label, kind in (("pages", pages), ("strings", strings), ("tests", names)):
        texts = kind(Path(folder))
        value, counts, words = rate(text for page in texts.values() for text in page)
        print(
            f"{label:8s} {words:7d} words, {value:5.2f} idioms in 1000", dict(counts.most_common())
        )
        for path, page in sorted(texts.items()) if "--lines" in options else ():
            for text in page:
                for line in text.splitlines():
                    if found := +idioms_in(line):
                        print(f"  {path}: {line.strip()[:160]} {list(found)}")


if __name__ == "__main__":
    main(*sys.argv[1:])

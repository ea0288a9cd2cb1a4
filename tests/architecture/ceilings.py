"""Size and density of the project, and their ceilings in ``ceilings.toml``.

    python -m tests.architecture.ceilings               measured values beside the ceilings
    python -m tests.architecture.ceilings lower         lower each ceiling to the measured value plus 1 %
    python -m tests.architecture.ceilings raised BASE   rows that a commit after BASE raised beside other changes

A row of a folder of the package counts:

- weight: statements without docstrings, 2 more for each conditional expression, 1 more for each further name of an assignment
  of several names. A dense line weighs as much as the plain lines that it replaces;
- conditions and further_names: the same expressions per 1000 statements, outside of compiled functions. There a conditional
  expression is a selection without a branch. `and` and `or` whose value is used, an index or a product by a condition, and
  `:=` count as conditional expressions;
- templates: lines of files that are no Python, without the headers of FMI;
- text_lines: lines of strings that hold code of another language;
- literals: numbers other than -1, 0, 1 and 2; any: names `Any`; ignores: comments that silence a checker.
"""

import ast
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "bristle"
FILE = Path(__file__).with_suffix(".toml")
COMPILED = {
    "kernel",
    "njit",
    "jit",
    "register_jitable",
    "vectorize",
    "guvectorize",
    "intrinsic",
    "overload",
}
BODIES = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
TEMPLATES = {
    *(".html", ".js", ".mjs", ".css", ".c", ".cc", ".cpp", ".cu", ".h", ".comp", ".hal", ".st"),
    *(".jinja", ".json", ".xml", ".yaml", ".txt"),
}
PREDICATE = re.compile(
    r"_?(?:is|has|are|any|all|isinstance|issubclass|hasattr|callable|bool)(?:_|$)"
)
SMALL_NUMBERS = {-1, 0, 1, 2}
SILENCED = re.compile(r"#\s*(?:type:\s*ignore|pyright:\s*ignore)")
# Lines of a string that look like code of another language.
FOREIGN = re.compile(r"[;{}]\s*$|^\s*</?\w|:=|^\s*(?:END_|#include|function |const |let )")
SPARE = 1.01
HEADER = """# Ceilings of size and density, one row a folder: python -m tests.architecture.ceilings explains and lowers them.
# A raised ceiling is a commit of its own that states the reason.
"""


def described(node: ast.AST) -> str:
    """Return the name of a decorator."""
    target = node.func if isinstance(node, ast.Call) else node
    return target.attr if isinstance(target, ast.Attribute) else getattr(target, "id", "")


def is_docstring(body: ast.AST) -> bool:
    """Return whether a module, class or function begins with a docstring."""
    statements = getattr(body, "body", [])
    first = statements[0] if statements else None
    return (
        isinstance(first, ast.Expr)
        and isinstance(first.value, ast.Constant)
        and isinstance(first.value.value, str)
    )


def statements(nodes: Sequence[ast.AST]) -> int:
    """Return the number of statements, without docstrings."""
    docstrings = [node for node in nodes if isinstance(node, BODIES) and is_docstring(node)]
    return sum(isinstance(node, ast.stmt) for node in nodes) - len(docstrings)


def further_names(node: ast.AST) -> int:
    """Return how many names an assignment of several values has beyond the first."""
    if not isinstance(node, ast.Assign) or not isinstance(node.value, ast.Tuple):
        return 0
    return sum(len(target.elts) - 1 for target in node.targets if isinstance(target, ast.Tuple))


def is_condition(node: ast.AST) -> bool:
    """Return whether a value is a comparison or its negation."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return True
    return isinstance(node, ast.Compare)


def tested(nodes: Iterable[ast.AST]) -> set[int]:
    """Return `and` and `or` in conditions of branches, loops, comprehensions and assertions: they select no value."""
    found: set[int] = set()
    for node in nodes:
        tests = (
            [node.test]
            if isinstance(node, (ast.If, ast.While, ast.IfExp, ast.Assert))
            else getattr(node, "ifs", [])
        )
        for test in tests:
            found.update(id(part) for part in ast.walk(test) if isinstance(part, ast.BoolOp))
    return found


def is_dense(node: ast.AST, in_tests: set[int]) -> bool:
    """Return whether an expression selects a value by a condition."""
    if isinstance(node, (ast.IfExp, ast.NamedExpr)):
        return True
    if isinstance(node, ast.BoolOp):
        return id(node) not in in_tests and not all(map(is_truth, node.values))
    if isinstance(node, ast.Subscript):
        return isinstance(node.value, (ast.Tuple, ast.List)) and is_condition(node.slice)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult):
        return is_condition(node.left) or is_condition(node.right)
    return False


def is_truth(node: ast.AST) -> bool:
    """Return whether a value is a truth by its form: a comparison, a negation, or a call of a predicate."""
    if isinstance(node, ast.BoolOp):
        return all(map(is_truth, node.values))
    if isinstance(node, ast.Call):
        return bool(PREDICATE.match(described(node)))
    return is_condition(node)


def compiled_nodes(nodes: Iterable[ast.AST]) -> set[int]:
    """Return the nodes within compiled functions."""
    functions = [
        node for node in nodes if isinstance(node, ast.FunctionDef) and node.decorator_list
    ]
    compiled = [
        function
        for function in functions
        if COMPILED & {described(entry) for entry in function.decorator_list}
    ]
    return {id(node) for function in compiled for node in ast.walk(function)}


def code_in_strings(nodes: Sequence[ast.AST]) -> int:
    """Return the lines of strings that hold code of another language."""
    docstrings = {
        id(node.body[0].value) for node in nodes if isinstance(node, BODIES) and is_docstring(node)
    }
    texts = [
        node for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    lines = [
        line for node in texts if id(node) not in docstrings for line in node.value.splitlines()
    ]
    return sum(bool(FOREIGN.search(line)) for line in lines)


def is_literal(node: ast.AST) -> bool:
    """Return whether a node is a number that states a choice."""
    if not isinstance(node, ast.Constant) or isinstance(node.value, bool):
        return False
    return isinstance(node.value, (int, float, complex)) and node.value not in SMALL_NUMBERS


def silenced(text: str) -> int:
    """Return the number of comments that silence a checker."""
    return len(SILENCED.findall(text))


class Sums:
    """Counts of the modules of a folder."""

    def __init__(self) -> None:
        self.statements = self.weight = self.plain = self.conditions = self.further = 0
        self.literals = self.any = self.ignores = self.text_lines = 0

    def add(self, text: str) -> None:
        """Count a module."""
        nodes = list(ast.walk(ast.parse(text)))
        in_tests = tested(nodes)
        compiled = compiled_nodes(nodes)
        outside = [node for node in nodes if id(node) not in compiled]
        further = sum(map(further_names, nodes))
        count = statements(nodes)
        self.statements += count
        self.weight += count + 2 * sum(isinstance(node, ast.IfExp) for node in nodes) + further
        self.plain += sum(isinstance(node, ast.stmt) for node in outside)
        self.conditions += sum(is_dense(node, in_tests) for node in outside)
        self.further += sum(map(further_names, outside))
        self.literals += sum(map(is_literal, nodes))
        self.any += sum(isinstance(node, ast.Name) and node.id == "Any" for node in nodes)
        self.ignores += silenced(text)
        self.text_lines += code_in_strings(nodes)

    def row(self) -> dict[str, float]:
        """Return the row of the folder."""
        plain = max(self.plain, 1)
        return {
            "weight": self.weight,
            "conditions": round(1000.0 * self.conditions / plain, 1),
            "further_names": round(1000.0 * self.further / plain, 1),
            "text_lines": self.text_lines,
            "literals": self.literals,
            "any": self.any,
            "ignores": self.ignores,
        }


def modules(folder: Path) -> list[Path]:
    """Return the modules of a folder, of itself only if it is the package."""
    if folder == PACKAGE:
        return sorted([*folder.glob("*.py"), *folder.glob("apps/*.py")])
    return sorted(folder.rglob("*.py"))


def summed(paths: Iterable[Path]) -> Sums:
    """Return the counts of these modules."""
    sums = Sums()
    for path in paths:
        sums.add(path.read_text(encoding="utf-8"))
    return sums


def template_lines(folder: Path) -> int:
    """Return the lines of the templates of a folder."""
    files = [
        path
        for path in folder.rglob("*")
        if path.suffix in TEMPLATES and "headers" not in path.parts
    ]
    return sum(path.read_text(encoding="utf-8").count("\n") for path in files)


def folders(root: Path) -> list[Path]:
    """Return the folders that hold modules, and each app in place of the folder of apps."""
    found = [
        path
        for path in [*root.iterdir(), *root.glob("apps/*")]
        if path.is_dir() and any(path.rglob("*.py"))
    ]
    return sorted(path for path in found if path != root / "apps")


def row_of(folder: Path) -> dict[str, float]:
    """Return the row of a folder of the package."""
    row = summed(modules(folder)).row()
    return row if folder == PACKAGE else row | {"templates": template_lines(folder)}


def statements_of(paths: Iterable[Path]) -> dict[str, float]:
    """Return the row of a folder of tests."""
    return {
        "statements": sum(
            statements(list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))))
            for path in paths
        )
    }


def options() -> list[list[str]]:
    """Return the spellings of each option of each command."""
    import typer

    from bristle.cli.application import application

    command = typer.main.get_command(application())
    found = []
    for sub in [command, *command.commands.values()]:
        found += [
            [*entry.opts, *entry.secondary_opts]
            for entry in sub.params
            if entry.param_type_name == "option"
        ]
    return found


def interface() -> dict[str, float]:
    """Return what a user meets: options, options with a short letter, codes of diagnostics, thresholds."""
    from bristle.identification.settings import Settings
    from bristle.report.sentences import SENTENCES

    spelled = options()
    short = [names for names in spelled if any(len(name) == 2 for name in names)]
    thresholds = len(Settings.described())
    return {
        "options": len(spelled),
        "short_options": len(short),
        "codes": len(SENTENCES),
        "thresholds": thresholds,
    }


def beside() -> dict[str, float]:
    """Return the sizes of what stands beside the package."""
    pages = [
        path
        for path in (ROOT / "docs").rglob("*.md")
        if "<!-- Written by" not in path.read_text(encoding="utf-8")[:200]
    ]
    return {
        "benchmarks": summed((ROOT / "benchmarks").rglob("*.py")).weight,
        "examples": summed((ROOT / "examples").rglob("*.py")).weight,
        "docs": sum(len(path.read_text(encoding="utf-8").split()) for path in pages),
    }


def slow_minutes() -> dict[str, float]:
    """Return the minutes of the slow parts, and those of the mutants among them."""
    parts = tomllib.loads((ROOT / ".ci" / "parts.toml").read_text(encoding="utf-8"))
    mutants = sum(
        part["minutes"] * part.get("shares", 1)
        for name, part in parts.items()
        if name.startswith("mutants")
    )
    total = sum(part["minutes"] * part.get("shares", 1) for part in parts.values())
    return {"slow": total - mutants, "mutants": mutants}


def rows() -> dict[tuple[str, str], Callable[[], dict[str, float]]]:
    """Return how each row is measured, by table and row."""
    found: dict[tuple[str, str], Callable[[], dict[str, float]]] = {
        ("project", "interface"): interface,
        ("project", "beside"): beside,
        ("project", "minutes"): slow_minutes,
        ("package", "."): partial(row_of, PACKAGE),
        ("tests", "."): partial(statements_of, sorted((ROOT / "tests").glob("*.py"))),
    }
    for folder in folders(PACKAGE):
        found["package", folder.relative_to(PACKAGE).as_posix()] = partial(row_of, folder)
    for folder in folders(ROOT / "tests"):
        found["tests", folder.relative_to(ROOT / "tests").as_posix()] = partial(
            statements_of, sorted(folder.rglob("*.py"))
        )
    return found


def measured() -> dict[str, dict[str, dict[str, float]]]:
    """Return all rows as they are now."""
    values: dict[str, dict[str, dict[str, float]]] = {"package": {}, "project": {}, "tests": {}}
    for (table, row), measure in rows().items():
        values[table][row] = measure()
    return values


def ceilings(text: str | None = None) -> dict[str, dict[str, dict[str, float]]]:
    """Return the ceilings."""
    return tomllib.loads(FILE.read_text(encoding="utf-8") if text is None else text)


def flat(tables: dict[str, dict[str, dict[str, float]]]) -> dict[tuple[str, str, str], float]:
    """Return the values by table, row and column."""
    values = {}
    for table, named in tables.items():
        for row, columns in named.items():
            values |= {(table, row, column): value for column, value in columns.items()}
    return values


def above(values: dict, limits: dict) -> list[str]:
    """Return a line for each value above its ceiling, and for each row without one."""
    lines = []
    allowed = flat(limits)
    for place, value in flat(values).items():
        name = ".".join(place)
        if place not in allowed:
            lines.append(f"{name}: {value} has no ceiling")
        elif value > allowed[place]:
            lines.append(f"{name}: {value}, ceiling {allowed[place]}")
    return lines


def with_spare(value: float) -> float:
    """Return the ceiling for a measured value: 1 % above it."""
    if isinstance(value, int):
        return math.floor(value * SPARE)
    return math.ceil(value * SPARE * 10.0) / 10.0


def lowered(values: dict, limits: dict | None) -> dict[str, dict[str, dict[str, float]]]:
    """Return ceilings for measured values, never above those there are."""
    former = flat(limits or {})
    limited: dict[str, dict[str, dict[str, float]]] = {}
    for place, value in flat(values).items():
        table, row, column = place
        limited.setdefault(table, {}).setdefault(row, {})[column] = min(
            with_spare(value), former.get(place, math.inf)
        )
    return limited


def written(tables: dict[str, dict[str, dict[str, float]]]) -> str:
    """Return the text of the file."""
    lines = [HEADER]
    for table, named in tables.items():
        lines.append(f"[{table}]")
        for row, columns in sorted(named.items()):
            entries = ", ".join(f"{column} = {value}" for column, value in columns.items())
            key = row if re.fullmatch(r"\w+", row) else f'"{row}"'
            lines.append(f"{key} = {{ {entries} }}")
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def git(*arguments: str) -> str:
    """Return the output of git."""
    return subprocess.run(
        ["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout


def raised(former: str, text: str) -> list[str]:
    """Return the rows of a former file that a text raises. A row that is new is none of them."""
    before, after = flat(ceilings(former)), flat(ceilings(text))
    return [
        ".".join(place)
        for place, value in after.items()
        if place in before and value > before[place]
    ]


def raised_beside(base: str) -> list[str]:
    """Return a line for each commit after a base that raises a ceiling above that of the base, and changes another file."""
    path = FILE.relative_to(ROOT).as_posix()
    if not git("ls-tree", base, path):
        return []
    in_all = raised(git("show", f"{base}:{path}"), git("show", f"HEAD:{path}"))
    lines = []
    for commit in git("rev-list", "--no-merges", f"{base}..HEAD", "--", path).split():
        changed = git("show", "--format=", "--name-only", commit).split()
        rows = [
            row
            for row in raised(git("show", f"{commit}~1:{path}"), git("show", f"{commit}:{path}"))
            if row in in_all
        ]
        if rows and changed != [path]:
            lines.append(f"{commit[:9]} raises {', '.join(rows)} beside other changes")
    return lines


def main(words: list[str]) -> int:
    """Print, lower or compare the ceilings, and return the exit code."""
    if words[:1] == ["raised"]:
        lines = raised_beside(words[1])
        print("\n".join(lines))
        return 1 if lines else 0
    values = measured()
    if words == ["lower"]:
        FILE.write_text(
            written(lowered(values, ceilings() if FILE.exists() else None)), encoding="utf-8"
        )
        return 0
    limits = flat(ceilings())
    for place, value in flat(values).items():
        print(f"{'.'.join(place):50} {value:10} {limits.get(place, '-'):>10}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

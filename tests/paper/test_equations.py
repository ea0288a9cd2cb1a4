"""The equations of the paper: none is missing, each is computed where it is said, tested, and can be run."""

import re
import shlex
from pathlib import Path

import pytest
import typer
from matplotlib.mathtext import MathTextParser

from bristle.cli.application import app
from bristle.cli.main import main
from bristle.engine import interpreted
from bristle.paper import FIGURES, equations

ROOT = Path(__file__).parents[2]
GROUP = typer.main.get_command(app)
CHEAP = "bristle models"  # the others take seconds to minutes, and have their own tests
each = pytest.mark.parametrize("one", equations.EQUATIONS, ids=lambda equation: str(equation.number))


def numbers_in(text):
    """The equations that a text names, (5) to (7) in full."""
    result = {int(item) for item in re.findall(r"\((\d+)\)", text)}
    for first, last in re.findall(r"\((\d+)\) to \((\d+)\)", text):
        result |= set(range(int(first), int(last) + 1))
    return result


def test_all_23_are_there_in_order():
    assert [equation.number for equation in equations.EQUATIONS] == list(range(1, 24))


@each
def test_the_computing_file_names_the_equation(one):
    text = (ROOT / "src" / "bristle" / one.file).read_text(encoding="utf-8")
    assert one.number in numbers_in(text.partition('"""')[2].partition('"""')[0])


@each
def test_the_test_of_each_equation_exists(one):
    file, _, name = one.test.partition("::")
    assert re.search(rf"^def {name}\(", (ROOT / "tests" / file).read_text(encoding="utf-8"), re.MULTILINE)


@each
def test_only_equations_marked_as_corrected_differ(one):
    assert (one.stands == "as printed") == (not one.formula)
    assert one.formula != one.printed
    assert "|" not in one.printed + one.formula  # it would end the cell


@each
def test_formulas_can_be_typeset(one):
    # Of the usual TeX this parser knows all but a few words that do not change the sense.
    for formula in filter(None, (one.printed, one.formula)):
        plain = formula.replace(r"\tfrac12", r"\frac{1}{2}").replace(r"\frac1J", r"\frac{1}{J}")
        plain = re.sub(r"\\lvert|\\rvert", "|", plain).replace(r"\text{", r"\mathrm{")
        MathTextParser("path").parse(f"${plain}$")


@pytest.fixture(scope="module")
def session():
    names = {}
    for line in equations.SETUP:
        exec(line, names)
    return names


@pytest.mark.parametrize(
    "equation", [equation for equation in equations.EQUATIONS if equation.gives], ids=lambda equation: str(equation.number)
)
@interpreted()
def test_the_python_line_gives_the_stated_result(equation, session):
    assert str(eval(equation.run, session)) == equation.gives


@pytest.mark.parametrize("command", sorted({equation.run for equation in equations.EQUATIONS if not equation.gives}))
def test_the_command_can_be_run(command, tmp_path, monkeypatch, capsys):
    words = shlex.split(command)
    assert words.pop(0) == "bristle"
    context = GROUP.make_context("bristle", [], resilient_parsing=True)
    name, result, arguments = GROUP.resolve_command(context, words)
    parsed = result.make_context(name, list(arguments), parent=context)
    assert set(parsed.params.get("figure") or ()) <= set(FIGURES)
    if command.startswith(CHEAP):
        monkeypatch.chdir(tmp_path)
        assert main(words) == 0, capsys.readouterr().err

"""Formulas as a terminal shows them: nothing of LaTeX is left, and nothing changes its meaning."""

import re

import pytest
from hypothesis import given, strategies as st

from bristle import controllers, friction, hysteresis, plants, references, sensors
from bristle.core.formula import EQUATION, as_text, laid_out, lines_of, paragraphs_of, spelt_out

COMPONENTS = [
    *friction.MODELS.values(),
    *hysteresis.OPERATORS.values(),
    *plants.PLANTS.values(),
    *controllers.CONTROLLERS.values(),
    *sensors.SENSORS.values(),
    *references.REFERENCES.values(),
]
SLOTTED = [friction.find(f"{name}+asymmetry+position+periodic") for name in friction.MODELS]


@pytest.mark.parametrize(
    ("latex", "text"),
    [
        (r"\frac{a + b}{2M}(u - F)", "((a + b)/(2M)) (u − F)"),
        (r"1 - \frac{x}{y}\operatorname{sgn} v", "1 − (x/y) sgn v"),
        (r"\frac{f \operatorname{sgn} v}{G(v)}", "(f sgn v)/G(v)"),
        (r"\frac{\frac{a}{b}}{c}", "a/b/c"),
        (r"a/\frac{b}{c}", "a/(b/c)"),
        (r"a^{\frac{b}{c}}", "a^(b/c)"),
        (r"e^{-x} + e^2", "exp(−x) + e²"),
        (r"x^{n-1}_{ij}", "xⁿ⁻¹_ij"),
        (r"\dot{\hat v}, \ddot x", "v̂̇, ẍ"),
        (r"\left.\frac{dF}{dx}\right|_0", "dF/dx|₀"),
        (r"|a - |b||", "|a − |b||"),
        (r"|-x| - \beta |y|z", "|−x| − β |y|z"),
        (r"\sqrt{a^2 + b}", "√(a² + b)"),
        (r"-a \le -b < +c", "−a ≤ −b < +c"),
        (r"F \in [-F_C, F_C] \text{ at } v = 0", "F ∈ [−F_C, F_C] at v = 0"),
        (r"\unknown{x} y", "unknownx y"),
        (r"\sum_{j \le l} \mu_{jl}", "∑_(j≤l) μ_jl"),
        (r"\operatorname{sgn}\!\left(v\right)", "sgn(v)"),
        (r"2\pi f t", "2π f t"),
    ],
)
def test_plain_text_matches_the_typeset_formula(latex, text):
    assert as_text(latex) == text


def test_each_equation_and_each_case_has_a_line():
    assert lines_of(r"a &= b, \qquad c = d \\ e &= f") == ("a = b", "c = d", "e = f")
    cases = r"F = \begin{cases} k x & \text{sticking} \\ G(v) & \text{slipping}\end{cases}"
    assert lines_of(cases) == ("F = { k x   sticking", "    { G(v)   slipping")


@pytest.mark.parametrize("component", [*COMPONENTS, *SLOTTED], ids=lambda item: item.name)
def test_explanations_contain_no_latex_source(component):
    text = laid_out(component.explanation)
    assert not re.search(
        r"\\[A-Za-z]|[{}]\w|:math:|``|\bqquad\b|\bfrac\b", text.replace("{ ", "")
    ), text
    assert max(map(len, text.splitlines())) <= 100
    assert "?" not in "".join(map(spelt_out, text)), "a sign that a plain terminal cannot show"


def test_an_equation_breaks_between_its_terms_only():
    (equation,) = [
        item for item in paragraphs_of(friction.variation.__doc__) if item.kind == EQUATION
    ]
    lines = laid_out([equation], 75).splitlines()
    assert len(lines) > 1
    assert all(line.lstrip()[0] in "+−=" for line in lines[1:])
    wide = laid_out(paragraphs_of(".. math:: y = a x + (b + c + d + e) z"), 30).splitlines()
    assert wide == ["    y = a x", "        + (b + c + d + e) z"]
    assert "∑_(i=1, 2)" in "\n".join(lines)


TOKENS = [
    *r"\{}_^&|()[] ab1+-=,'/~",
    r"\frac",
    r"\left",
    r"\dot",
    r"\sqrt",
    r"\begin{cases}",
    r"\end{cases}",
    r"\\",
]


@given(st.lists(st.sampled_from(TOKENS)).map("".join))
def test_any_input_becomes_text(latex):
    assert "\n" not in as_text(latex.replace("\n", " "))
    lines_of(latex)
    laid_out(paragraphs_of(f"Mine.\n\n.. math:: {latex}\n\nWith :math:`{latex}`."), 30)


def test_an_equation_may_follow_an_empty_line():
    _, only = paragraphs_of("Mine.\n\n.. math::\n\n    a = b \\\\\n    c = d")
    assert only.kind == EQUATION
    assert lines_of(only.text) == ("a = b", "c = d")


def test_very_deep_nesting_is_cut_off():
    assert as_text("{" * 3000 + "x" + "}" * 3000)
    assert as_text(r"\sqrt" * 3000)


@pytest.mark.parametrize(
    ("text", "length"),
    [
        ("ab " * 100, 86),  # the next word would end behind the 88th
        (f"{'a' * 43} {'b' * 44} c", 88),
        (f"{'a' * 43} {'b' * 45} c", 43),
        (f"{'a' * 80} bbb-cccc", 80),  # a word stays whole
    ],
)
def test_help_is_wrapped_at_88_characters(text, length):
    assert len(laid_out(paragraphs_of(text)).splitlines()[0]) == length

"""Docstrings of modules taken apart into text, equations and references, and laid out for a terminal or a page.

A model is explained once, in the docstring of its file: `help`, the command line and the reference say it from there.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Iterable
from typing import NamedTuple

from bristle.core.formula import as_text, lines_of

TEXT, EQUATION, REFERENCE = "text", "equation", "reference"
DIRECTIVE = ".. math::"
WIDTH = 88
NO_BREAK = "\u00a0"
LONGEST_WHOLE = 30
_MATH = re.compile(r":math:`([^`]*)`")
_ROLE = re.compile(r"(?::\w+:)?`~?([^`]*)`")


class Paragraph(NamedTuple):
    """A paragraph, a displayed equation in LaTeX, or an entry of the references, as it stands in the source."""

    kind: str
    text: str


def paragraphs_of(docstring: str) -> tuple[Paragraph, ...]:
    r"""Return the paragraphs of a docstring, in order; of its sections only that of the references is known.

    Examples
    --------
    >>> [kind for kind, _ in paragraphs_of(".. math:: F = F_v v\n\nOpposes :math:`v`.")]
    ['equation', 'text']
    """
    paragraphs: list[Paragraph] = []
    kind = TEXT
    for block in re.split(r"\n(?:[ \t]*\n)+", inspect.cleandoc(docstring)):
        lines = block.splitlines()
        if len(lines) > 1 and set(lines[1].strip()) == {"-"}:
            kind = REFERENCE if lines[0].strip() == "References" else TEXT
            lines = lines[2:] if kind == REFERENCE else lines
        if kind == REFERENCE:
            paragraphs += [Paragraph(kind, entry) for entry in _entries(lines, r"\.\. (?=\[)")]
        elif block.startswith(DIRECTIVE):
            paragraphs.append(Paragraph(EQUATION, block.removeprefix(DIRECTIVE).strip()))
        elif paragraphs and paragraphs[-1].kind == EQUATION and block.startswith("    "):
            paragraphs[-1] = Paragraph(EQUATION, f"{paragraphs[-1].text}\n{block}")
        else:
            paragraphs += [Paragraph(TEXT, entry) for entry in _entries(lines, r"(?=\* )")]
    return tuple(entry for entry in paragraphs if entry.text)


def _entries(lines: Iterable[str], begin: str) -> list[str]:
    """Return lines joined to paragraphs, of which each line that begins so starts a new entry."""
    entries = [""]
    for line in lines:
        if re.match(begin, line):
            entries.append("")
        entries[-1] = f"{entries[-1]} {re.sub(rf'^{begin}', '', line).strip()}".strip()
    return [entry for entry in entries if entry]


def laid_out(paragraphs: Iterable[Paragraph], width: int = WIDTH) -> str:
    """Return paragraphs as text, formulas in Unicode, with an empty line between them."""
    return "\n\n".join(_laid_out(paragraph, max(width, 20)) for paragraph in paragraphs)


def _laid_out(paragraph: Paragraph, width: int) -> str:
    if paragraph.kind == EQUATION:
        return "\n".join(_filled(_whole_terms(line), width, "    ", "        ") for line in lines_of(paragraph.text))
    plain = _ROLE.sub(r"\1", _MATH.sub(_kept_whole, paragraph.text).replace("``", "`"))
    plain = re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"\1", plain)
    return _filled(re.sub(r"(?<=\])_", "", plain), width, "", "  " if plain.startswith(("* ", "[")) else "")


def _filled(text: str, width: int, first: str, further: str) -> str:
    """Return text in lines, which end at a blank."""
    filled = textwrap.fill(text, width, initial_indent=first, subsequent_indent=further, break_long_words=False, break_on_hyphens=False)
    return filled.replace(NO_BREAK, " ")


def _kept_whole(formula: re.Match[str]) -> str:
    """Return a formula within a sentence; a short one is not broken."""
    text = as_text(formula[1])
    return text.replace(" ", NO_BREAK) if len(text) <= LONGEST_WHOLE else text


def _whole_terms(line: str) -> str:
    """Return an equation that can be broken before the signs between its terms only."""
    depth, marked = 0, ""
    for i, sign in enumerate(line):
        depth += (sign in "([{") - (sign in ")]}")
        breaks = sign == " " and depth <= 0 and line[i + 1 : i + 2] in ("+", "−", "=", "≤", "<")
        marked += NO_BREAK if sign == " " and not breaks else sign
    return marked


def as_markdown(paragraph: Paragraph) -> str:
    r"""Return a paragraph as Markdown, with its formulas in LaTeX, and without numbers of references.

    Examples
    --------
    >>> as_markdown(Paragraph("text", r"The slope is :math:`\sigma_0`, as in ``dahl`` [1]_."))
    'The slope is $\\sigma_0$, as in `dahl`.'
    """
    if paragraph.kind == EQUATION:
        aligned = "&" in paragraph.text and "cases" not in paragraph.text
        formula = " ".join(paragraph.text.split())
        return f"$$\\begin{{aligned}}{formula}\\end{{aligned}}$$" if aligned else f"$${formula}$$"
    return re.sub(r" ?\[\d+\]_", "", _MATH.sub(r"$\1$", paragraph.text).replace("``", "`"))

r"""Render docstrings of modules as plain text, with equations in Unicode and references.

Supported is the LaTeX of the docstrings of bristle, and frequent commands for user models. An unknown command is
replaced by its name.

>>> as_text(r"\dot z = v\left(1 - \frac{\sigma_0 z}{G(v)}\operatorname{sgn} v\right)")
'ż = v (1 − (σ₀ z/G(v)) sgn v)'
"""

import inspect
import re
import textwrap
import unicodedata
from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple

TEXT, EQUATION, REFERENCE = "text", "equation", "reference"
DIRECTIVE = ".. math::"
WIDTH = 88
NO_BREAK = "\u00a0"
_MATH = re.compile(r":math:`([^`]*)`")


def _pairs(text: str) -> dict[str, str]:
    """Parse a table from one line, in which each name precedes its replacement."""
    words = text.split()
    return dict(zip(words[::2], words[1::2], strict=True))


LETTERS = _pairs(
    "alpha α beta β gamma γ delta δ varepsilon ε zeta ζ eta η theta θ iota ι kappa κ lambda λ mu μ nu ν xi ξ pi π rho ρ varsigma ς "
    "sigma σ tau τ upsilon υ varphi φ chi χ psi ψ omega ω Gamma Γ Delta Δ Theta Θ Lambda Λ Xi Ξ Pi Π Sigma Σ Upsilon Υ Phi Φ Psi Ψ "
    "Omega Ω phi ϕ vartheta ϑ epsilon ϵ ell ℓ infty ∞ dots … ldots … cdots … sum ∑ prod ∏ int ∫ iint ∬ partial ∂ nabla ∇ prime ′"
)
RELATIONS = _pairs(
    "le ≤ leq ≤ ge ≥ geq ≥ ne ≠ neq ≠ in ∈ to → leftarrow ← rightarrow → sim ~ approx ≈ equiv ≡ propto ∝ ll ≪ gg ≫ Rightarrow ⇒ lt < gt >"
)
FRAMES = _pairs("lfloor ⌊ rfloor ⌋ lceil ⌈ rceil ⌉ langle ⟨ rangle ⟩ { { } } | ‖ lvert | rvert |")
FUNCTIONS = [
    "sin",
    "cos",
    "tan",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "ln",
    "log",
    "min",
    "max",
    "sup",
    "inf",
    "arctan",
    "arg",
]
ACCENTS = {
    "dot": "\u0307",
    "ddot": "\u0308",
    "hat": "\u0302",
    "bar": "\u0304",
    "tilde": "\u0303",
    "vec": "\u20d7",
}
ACCENTS |= {"overline": ACCENTS["bar"], "widehat": ACCENTS["hat"], "widetilde": ACCENTS["tilde"]}
HALVES = {("1", "2"): "½", ("1", "4"): "¼", ("3", "4"): "¾"}
RAISED = dict(zip("0123456789+−()ni", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿⁱ", strict=True))
LOWERED = dict(zip("0123456789+−", "₀₁₂₃₄₅₆₇₈₉₊₋", strict=True))
PLAIN = _pairs(
    "≤ <= ≥ >= ≠ != ≈ ~ ∈ in → -> ← <- √ sqrt ½ 1/2 ¼ 1/4 ¾ 3/4 ∬ integral ∫ integral ⌊ floor( ⌋ ) ℓ l ′ ' ∂ d µ u · * × * ± +- "
    "− - – - ∞ inf … ... ° deg"
)
SPELT = (
    {letter: command for command, letter in LETTERS.items()}
    | {"φ": "phi"}
    | {accent: f"_{name}" for name, accent in reversed(ACCENTS.items())}
    | {low: f"_{sign}".replace("−", "-") for sign, low in LOWERED.items()}
    | {high: f"^{sign}".replace("−", "-") for sign, high in RAISED.items()}
    | PLAIN
)


class Piece(NamedTuple):
    """Text with a role, a letter that determines its spacing."""

    text: str
    role: str


# Atom, function, quotient, opening, opening of a bracket as a factor, closing, sign, relation, blank, tight.
ATOM, FUNCTION, QUOTIENT, OPENS, FACTOR, CLOSES, SIGN, RELATION, BLANK, TIGHT = "afqoFcsrbt"
COMMANDS = {
    name: Piece(text, role)
    for role, table in (
        (ATOM, LETTERS),
        (RELATION, RELATIONS),
        (SIGN, _pairs("pm ± mp ∓ times × cdot · circ ∘ cup ∪ cap ∩")),
        (FUNCTION, dict(zip(FUNCTIONS, FUNCTIONS, strict=True))),
        (BLANK, dict.fromkeys((",", ";", ":", " ", "quad", "qquad", "~", "\\"), " ")),
        (TIGHT, {"!": ""}),
    )
    for name, text in table.items()
}
PRINTED = {"-": "−", "*": "·", "'": "′", "~": " "}
ROLES = {
    sign: role
    for role, signs in (
        (SIGN, "+-*"),
        (",", ",;"),
        ("/", "/"),
        (RELATION, "=<>"),
        (OPENS, "([{⌊⌈⟨"),
        (CLOSES, ")]}⌋⌉⟩'"),
        (BLANK, "~"),
    )
    for sign in signs
}

_TOKEN = re.compile(r"\\(?:[A-Za-z]+|.)|\s+|.", re.DOTALL)
_UNSEEN = re.compile(
    r"\\(?:displaystyle|limits|nolimits|mathcal|mathbb|boldsymbol|mathbf|big|Big|bigl|bigr)(?![A-Za-z])\s*|(?<!\\)\s+(?=[_^])"
)
_ENVIRONMENT = re.compile(r"\\(?:begin|end)\{(?:aligned|align\*?|split|gathered)\}")


def as_text(latex: str) -> str:
    """Return a formula in one line of text."""
    flat = _ENVIRONMENT.sub(" ", latex).replace("&", " ")
    return unicodedata.normalize("NFC", _Reader(_UNSEEN.sub("", flat)).line())


def lines_of(latex: str) -> tuple[str, ...]:
    """Return a displayed formula as lines of text: one for each equation in it, and for each case."""
    return tuple(line for equation in equations_in(latex) for line in _with_cases(equation) if line)


def spelt_out(sign: str) -> str:
    """Spell a sign in ASCII: by its name in formulas, else ``?``."""
    if sign in SPELT or sign.isascii():
        return SPELT.get(sign, sign)
    apart = unicodedata.normalize("NFD", sign)
    if apart == sign:
        return "" if unicodedata.combining(sign) else "?"
    return "".join(map(spelt_out, apart))


def equations_in(display: str) -> Iterator[str]:
    """Yield the equations of a display in LaTeX, separated by new lines or wide blanks outside braces and cases."""
    latex, depth, start = _ENVIRONMENT.sub(" ", display), 0, 0
    for match in _TOKEN.finditer(latex):
        token = match[0]
        depth += (token in ("{", "\\begin")) - (token in ("}", "\\end"))
        if depth <= 0 and token in ("\\\\", "\\qquad", "\\quad"):
            yield latex[start : match.start()]
            start = match.end()
    yield latex[start:]


def _with_cases(latex: str) -> list[str]:
    cases = re.search(r"\\begin\{cases\}(.*?)\\end\{cases\}", latex, re.DOTALL)
    if cases is None:
        return [as_text(latex).removesuffix(",")]
    before, after = as_text(latex[: cases.start()]), as_text(latex[cases.end() :])
    rows = ["   ".join(as_text(cell) for cell in row.split("&")) for row in cases[1].split("\\\\")]
    lines = [f"{before if not i else ' ' * len(before)} {{ {row}" for i, row in enumerate(rows)]
    return [*lines[:-1], lines[-1] + after]


class _Reader:
    """Reads the tokens of a formula, one after the other."""

    def __init__(self, latex: str, depth: int = 0) -> None:
        self.tokens, self.depth, self.bars = deque(_TOKEN.findall(latex)), depth, 0

    def line(self) -> str:
        """Return the remaining tokens as a line, with indices and exponents attached."""
        pieces: list[Piece] = []
        while token := self._next():
            if token in "_^":
                base = pieces.pop() if pieces else Piece("", ATOM)
                pieces.append(_with_index(base, token, self._argument()))
            else:
                pieces.append(self._piece(token))
        line, left, before = "", TIGHT, ""
        visible = [piece for piece in pieces if piece.text or piece.role == TIGHT]
        for place, (text, role) in enumerate(visible):
            if role == BLANK:
                continue
            after = next(
                (later.role for later in visible[place + 1 :] if later.role != BLANK), TIGHT
            )
            bracketed = (
                f"({text})" if role == QUOTIENT and (after in "afqoF" or left == "/") else text
            )
            # Spacing by the roles of two pieces.
            together = re.fullmatch(r"t.|[oF/][^r]|[afqc][c,t/]|f[oF]", left + role) or (
                before == "Δ" and left + role == ATOM + ATOM
            )
            blank = re.fullmatch(r".[rsfFq]|[rsfq,].", left + role) or (
                place and visible[place - 1].role == BLANK
            )
            line += f" {bracketed}" if blank and not together else bracketed
            # A leading sign belongs to the next piece.
            left, before = TIGHT if role == SIGN and left in "oFsr,/t" else role, text
        return re.sub(r" +", " ", line).strip()

    def _next(self) -> str:
        return self.tokens.popleft() if self.tokens else ""

    def _source(self) -> str:
        """Return the source of the next group, or else the next token."""
        while (token := self._next()).isspace():
            continue
        depth, group = int(token == "{"), [token]
        while depth and self.tokens:
            group.append(self._next())
            depth += (group[-1] == "{") - (group[-1] == "}")
        return "".join(group[1 : None if depth else -1] if token == "{" else group)

    def _argument(self) -> str:
        """Return the argument of a command as text: a group, or a token with its own arguments."""
        while self.tokens and self.tokens[0].isspace():
            self._next()
        # Nested groups; deeper nesting is not a realistic formula.
        if self.depth > 40 or not self.tokens:
            return self._source()
        if self.tokens[0] == "{":
            return _Reader(self._source(), self.depth + 1).line()
        self.depth += 1
        text = self._piece(self._next()).text
        self.depth -= 1
        return text

    def _piece(self, token: str) -> Piece:
        if token.startswith("\\") and len(token) > 1:
            return self._command(token[1:])
        if token == "{":
            self.tokens.appendleft(token)
            return Piece(self._argument(), ATOM)
        return self._sign(token)

    def _sign(self, sign: str) -> Piece:
        if sign == "|":
            self.bars += 1
            return Piece("|", OPENS if self.bars % 2 else CLOSES)
        if sign.isspace():
            return Piece(" ", BLANK)
        return Piece(PRINTED.get(sign, sign), ROLES.get(sign, ATOM))

    def _command(self, name: str) -> Piece:
        if name in COMMANDS:
            return COMMANDS[name]
        if name in FRAMES:
            return self._sign(FRAMES[name])
        if name in ("left", "right"):
            # A growing bracket is a separate factor: a blank before it shows that it is not an argument.
            token = self._source()
            sign = (
                FRAMES.get(token[1:], token[1:])
                if token.startswith("\\")
                else token.removeprefix(".")
            )
            return Piece(sign, FACTOR if name == "left" else CLOSES)
        if name in ("frac", "tfrac", "dfrac"):
            above = self._argument()
            below = self._argument()
            if (above, below) in HALVES:
                return Piece(HALVES[above, below], ATOM)
            # A sum needs brackets, and so does a function whose argument would otherwise include the fraction bar.
            product = not re.search(
                r"[^\s(\[][ ]?[+−±=<>≤≥∈][ ]", _without_brackets(above)
            ) and not re.search(r"[a-z]{3} \S", above)
            simple = not re.search(r"[\s/+−±·]|^\d+[^\d\s]", _without_brackets(below))
            return Piece(
                f"{above if product else f'({above})'}/{below if simple else f'({below})'}",
                QUOTIENT,
            )
        if name in ("operatorname", "mathrm", "text", "textrm"):
            return Piece(self._source(), ATOM if name.startswith("text") else FUNCTION)
        if name == "sqrt":
            inner = self._argument()
            return Piece(
                f"√{inner}" if re.fullmatch(r"\w+|\|[^|]*\|", inner) else f"√({inner})", ATOM
            )
        if name in ACCENTS:
            return Piece(
                re.sub(r".[\u0300-\u036f]*", rf"\g<0>{ACCENTS[name]}", self._argument(), count=1),
                ATOM,
            )
        return Piece(name, ATOM)


def _without_brackets(text: str) -> str:
    """Return text without brackets and their content."""
    count = 1
    while count:
        text, count = re.subn(r"\([^()]*\)|\[[^\[\]]*\]|\|[^|]*\|", "", text)
    return text


def _with_index(base: Piece, side: str, index: str) -> Piece:
    """Return a piece with an index or an exponent."""
    if side == "^" and base == ("e", ATOM) and not index.isdigit():
        return Piece(f"exp({index})", ATOM)
    tight = re.sub(r"(?<!,) ", "", index)
    table = RAISED if side == "^" else LOWERED | {"±": "±", "∓": "∓"}
    if tight and all(sign in table for sign in tight):
        return Piece(base.text + "".join(table[sign] for sign in tight), base.role)
    plain = re.fullmatch(r"[\w′]+", unicodedata.normalize("NFC", tight)) and (
        side == "^" or "_" not in tight
    )
    return Piece(f"{base.text}{side}{tight if plain else f'({tight})'}", base.role)


class Paragraph(NamedTuple):
    """A paragraph, a displayed equation in LaTeX, or a reference, as in the source."""

    kind: str
    text: str


def paragraphs_of(docstring: str) -> tuple[Paragraph, ...]:
    """Return the paragraphs of a docstring, in order; the only supported section is the references."""
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
    """Join lines to paragraphs; a line that matches `begin` starts a new entry."""
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
        return "\n".join(
            _filled(_whole_terms(line), width, "    ", "        ")
            for line in lines_of(paragraph.text)
        )
    plain = re.sub(
        r"(?::\w+:)?`~?([^`]*)`", r"\1", _MATH.sub(_kept_whole, paragraph.text).replace("``", "`")
    )
    plain = re.sub(r"(?<!\w)\*(\w[^*]*)\*", r"\1", plain)
    return _filled(
        re.sub(r"(?<=\])_", "", plain), width, "", "  " if plain.startswith(("* ", "[")) else ""
    )


def _filled(text: str, width: int, first: str, further: str) -> str:
    """Wrap text at blanks."""
    filled = textwrap.fill(
        text,
        width,
        initial_indent=first,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return filled.replace(NO_BREAK, " ")


def _kept_whole(formula: re.Match[str]) -> str:
    """Return an inline formula; a short formula is kept in one line."""
    text = as_text(formula[1])
    return text.replace(" ", NO_BREAK) if len(text) <= 30 else text  # characters of a short formula


def _whole_terms(line: str) -> str:
    """Return an equation with line breaks allowed only before the signs between its terms."""
    depth, marked = 0, ""
    for i, sign in enumerate(line):
        depth += (sign in "([{") - (sign in ")]}")
        breaks = sign == " " and depth <= 0 and line[i + 1 : i + 2] in ("+", "−", "=", "≤", "<")
        marked += NO_BREAK if sign == " " and not breaks else sign
    return marked


def as_markdown(paragraph: Paragraph) -> str:
    """Return a paragraph as Markdown, with formulas in LaTeX and without reference numbers."""
    if paragraph.kind == EQUATION:
        aligned = "&" in paragraph.text and "cases" not in paragraph.text
        formula = " ".join(paragraph.text.split())
        return f"$$\\begin{{aligned}}{formula}\\end{{aligned}}$$" if aligned else f"$${formula}$$"
    return re.sub(r" ?\[\d+\]_", "", _MATH.sub(r"$\1$", paragraph.text).replace("``", "`"))

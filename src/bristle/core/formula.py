r"""Formulas of docstrings as text: LaTeX becomes what a terminal shows, in Unicode and line by line.

Known is what the docstrings of bristle use, and what a person's own model is likely to: fractions, roots, indices,
accents, Greek letters, functions, cases. Of a command that is not known the name stays.

Examples
--------
>>> as_text(r"\dot z = v\left(1 - \frac{\sigma_0 z}{G(v)}\operatorname{sgn} v\right)")
'ż = v (1 − (σ₀ z/G(v)) sgn v)'
>>> lines_of(r"F = F_v\,v, \qquad F \ge 0")
('F = F_v v', 'F ≥ 0')
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple


def _words(text: str) -> tuple[str, ...]:
    """Words of a list that is written with blanks between."""
    return tuple(text.split())


GREEK = {
    **dict(
        zip(
            "αβγδεζηθικλμνξπρςστυφχψω",
            _words(
                "alpha beta gamma delta varepsilon zeta eta theta iota kappa lambda mu nu xi pi rho varsigma sigma tau upsilon varphi "
                "chi psi omega"
            ),
            strict=True,
        )
    ),
    **dict(
        zip(
            "ΓΔΘΛΞΠΣΥΦΨΩϕϑϵ",
            ("Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega", "phi", "vartheta", "epsilon"),
            strict=True,
        )
    ),
}
LETTERS = {command: letter for letter, command in GREEK.items()} | {
    "ell": "ℓ",
    "infty": "∞",
    "dots": "…",
    "ldots": "…",
    "cdots": "…",
    "sum": "∑",
    "prod": "∏",
    "int": "∫",
    "iint": "∬",
    "partial": "∂",
    "nabla": "∇",
    "prime": "′",
}
RELATIONS = {
    "le": "≤",
    "leq": "≤",
    "ge": "≥",
    "geq": "≥",
    "ne": "≠",
    "neq": "≠",
    "in": "∈",
    "to": "→",
    "leftarrow": "←",
    "rightarrow": "→",
    "sim": "~",
    "approx": "≈",
    "equiv": "≡",
    "propto": "∝",
    "ll": "≪",
    "gg": "≫",
    "Rightarrow": "⇒",
    "lt": "<",
    "gt": ">",
}
SIGNS = {"pm": "±", "mp": "∓", "times": "×", "cdot": "·", "circ": "∘", "cup": "∪", "cap": "∩"}
ACCENTS = {
    "dot": "\u0307",
    "ddot": "\u0308",
    "hat": "\u0302",
    "bar": "\u0304",
    "tilde": "\u0303",
    "vec": "\u20d7",
    "overline": "\u0304",
    "widehat": "\u0302",
    "widetilde": "\u0303",
}
FUNCTIONS = {"sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "ln", "log", "min", "max", "sup", "inf", "arctan", "arg"}
FRAMES = {
    "lfloor": "⌊",
    "rfloor": "⌋",
    "lceil": "⌈",
    "rceil": "⌉",
    "langle": "⟨",
    "rangle": "⟩",
    "{": "{",
    "}": "}",
    "|": "‖",
    "lvert": "|",
    "rvert": "|",
}
OPENING, CLOSING = "([{⌊⌈⟨", ")]}⌋⌉⟩"
BLANKS = {",", ";", ":", " ", "quad", "qquad", "~"}
STYLES = {"displaystyle", "limits", "nolimits", "mathcal", "mathbb", "boldsymbol", "mathbf", "big", "Big", "bigl", "bigr"}
HALVES = {("1", "2"): "½", ("1", "4"): "¼", ("3", "4"): "¾"}
RAISED = dict(zip("0123456789+−()ni", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻⁽⁾ⁿⁱ", strict=True))
LOWERED = dict(zip("0123456789+−", "₀₁₂₃₄₅₆₇₈₉₊₋", strict=True))
PLAIN = {
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
    "≈": "~",
    "∈": "in",
    "→": "->",
    "←": "<-",
    "√": "sqrt",
    "½": "1/2",
    "¼": "1/4",
    "¾": "3/4",
    "∬": "integral",
    "∫": "integral",
    "⌊": "floor(",
    "⌋": ")",
    "ℓ": "l",
    "′": "'",
    "∂": "d",
    "µ": "u",
    "·": "*",
    "×": "*",
    "±": "+-",
    "−": "-",
    "–": "-",
    "∞": "inf",
    "…": "...",
    "°": "deg",
}
DEEPEST = 40  # groups within groups; what nests deeper is none that a person wrote

_TOKEN = re.compile(r"\\(?:[A-Za-z]+|.)|\s+|.", re.DOTALL)
_CASES = re.compile(r"\\begin\{cases\}(.*?)\\end\{cases\}", re.DOTALL)
_ENVIRONMENT = re.compile(r"\\(?:begin|end)\{(?:aligned|align\*?|split|gathered)\}")
_FIRST = re.compile(r".[\u0300-\u036f]*")
_SUM = re.compile(r"[^\s(\[][ ]?[+−±=<>≤≥∈][ ]")


class Piece(NamedTuple):
    """Some text, and what it is to its neighbours."""

    text: str
    role: str


ATOM, FUNCTION, FRACTION, OPEN, CLOSE, SIGN, RELATION, COMMA, SLASH, BLANK, TIGHT = _words(
    "atom function fraction open close sign relation comma slash blank tight"
)


def as_text(latex: str) -> str:
    r"""Return a formula in one line of text.

    Examples
    --------
    >>> as_text(r"e^{-(v/v_S)^2}"), as_text(r"\tfrac12 h + \sqrt{|\varsigma|}"), as_text(r"|z|^{\nu-1}")
    ('exp(−(v/v_S)²)', '½ h + √|ς|', '|z|^(ν−1)')
    """
    flat = _ENVIRONMENT.sub(" ", latex).replace("&", " ")
    return unicodedata.normalize("NFC", _joined(list(_Reader(flat).pieces())))


def lines_of(latex: str) -> tuple[str, ...]:
    """Return a displayed formula as lines of text: one for each equation in it, and for each case."""
    bare = _ENVIRONMENT.sub(" ", latex)
    return tuple(line for equation in _split(bare) for line in _with_cases(equation) if line)


def spelt_out(sign: str) -> str:
    """Return a sign as it is spelt where only plain letters can be written: of a formula by its name, else ``?``.

    Examples
    --------
    >>> "".join(map(spelt_out, "σ₀ ż ≤ v²"))
    'sigma_0 z_dot <= v^2'
    """
    if sign.isascii() or sign in PLAIN:
        return PLAIN.get(sign, sign)
    for table, before in ((RAISED, "^"), (LOWERED, "_")):
        for plain, set_ in table.items():
            if sign == set_:
                return before + plain.replace("−", "-")
    for name, accent in ACCENTS.items():
        if sign == accent:
            return f"_{name}"
    command = next((command for command, letter in LETTERS.items() if letter == sign), "")
    apart = unicodedata.normalize("NFD", sign)
    if command or apart == sign:
        mark = unicodedata.combining(sign) != 0
        return command.removeprefix("var" if sign == "φ" else "") or "?" * (not mark)
    return "".join(map(spelt_out, apart))


def _split(latex: str) -> Iterator[str]:
    """Yield the equations of a display, which end at a new line or a wide blank outside of braces and cases."""
    depth, start, cases = 0, 0, 0
    for match in _TOKEN.finditer(latex):
        token = match[0]
        depth += (token == "{") - (token == "}")
        cases += (token == "\\begin") - (token == "\\end")
        if depth <= 0 and not cases and token in ("\\\\", "\\qquad", "\\quad"):
            yield latex[start : match.start()]
            start = match.end()
    yield latex[start:]


def _with_cases(latex: str) -> list[str]:
    cases = _CASES.search(latex)
    if cases is None:
        return [as_text(latex).removesuffix(",")]
    before, after = as_text(latex[: cases.start()]), as_text(latex[cases.end() :])
    rows = ["   ".join(as_text(cell) for cell in row.split("&")) for row in cases[1].split("\\\\")]
    lines = [f"{before if not i else ' ' * len(before)} {{ {row}" for i, row in enumerate(rows)]
    return [*lines[:-1], lines[-1] + after]


class _Reader:
    """Reads the tokens of a formula, one after the other."""

    def __init__(self, latex: str, depth: int = 0) -> None:
        self.tokens = _TOKEN.findall(latex)
        self.place, self.depth, self.bars = 0, depth, 0

    def pieces(self) -> Iterator[Piece]:
        """Yield what there is, with indices and exponents at what they belong to."""
        waiting: Piece | None = None
        while self.place < len(self.tokens):
            token = self._next()
            if token in "_^":
                waiting = _with_index(waiting, token, self._argument())
                continue
            if token.isspace() and self._peek() in ("_", "^"):
                continue
            if token[:1] == "\\" and token[1:] in STYLES:
                self._skip_blanks()
                continue
            if waiting is not None:
                yield waiting
            waiting = self._piece(token)
        if waiting is not None:
            yield waiting

    def _next(self) -> str:
        self.place += 1
        return self.tokens[self.place - 1]

    def _peek(self) -> str:
        return self.tokens[self.place] if self.place < len(self.tokens) else ""

    def _skip_blanks(self) -> None:
        while self._peek().isspace():
            self.place += 1

    def _argument(self, depth: int = 0) -> str:
        """Return the source of what a command takes: a group, or one token, with what that takes in turn."""
        self._skip_blanks()
        if self._peek() != "{":
            token = self._next() if self._peek() else ""
            name = token[1:]
            takes = 2 if name in ("frac", "tfrac", "dfrac") else name in ACCENTS or name in ("text", "mathrm", "sqrt")
            return token + "".join(f"{{{self._argument(depth + 1)}}}" for _ in range(int(takes)) if depth < DEEPEST)
        start, depth = self.place + 1, 0
        while self.place < len(self.tokens):
            token = self._next()
            depth += (token == "{") - (token == "}")
            if not depth:
                return "".join(self.tokens[start : self.place - 1])
        return "".join(self.tokens[start:])

    def _text(self) -> str:
        """Return the next argument as text."""
        return self._read(self._argument())

    def _read(self, latex: str) -> str:
        return latex if self.depth > DEEPEST else _joined(list(_Reader(latex, self.depth + 1).pieces()))

    def _piece(self, token: str) -> Piece:
        if token.startswith("\\") and len(token) > 1:
            return self._command(token[1:])
        if token == "{":
            self.place -= 1
            return Piece(self._text(), ATOM)
        return self._sign(token)

    def _sign(self, sign: str) -> Piece:
        if sign.isspace() or sign == "~":
            return Piece(" ", BLANK)
        if sign == "|":
            self.bars += 1
            return Piece("|", OPEN if self.bars % 2 else CLOSE)
        if sign in "+-*":
            return Piece({"-": "−", "*": "·"}.get(sign, sign), SIGN)
        role = {",": COMMA, ";": COMMA, "/": SLASH, "'": CLOSE, "=": RELATION, "<": RELATION, ">": RELATION}.get(sign)
        if role is None:
            role = OPEN if sign in OPENING else CLOSE if sign in CLOSING else ATOM
        return Piece("′" if sign == "'" else sign, role)

    def _command(self, name: str) -> Piece:
        for table, role in ((LETTERS, ATOM), (RELATIONS, RELATION), (SIGNS, SIGN)):
            if name in table:
                return Piece(table[name], role)
        if name in FUNCTIONS:
            return Piece(name, FUNCTION)
        if name in FRAMES:
            return self._sign(FRAMES[name])
        if name in BLANKS or name == "\\":
            return Piece(" ", BLANK)
        special: dict[str, Callable[[], Piece]] = {
            **dict.fromkeys(("left", "right"), lambda: self._frame(name == "left")),
            **dict.fromkeys(("frac", "tfrac", "dfrac"), self._fraction),
            **dict.fromkeys(("operatorname", "mathrm"), lambda: Piece(self._argument(), FUNCTION)),
            **dict.fromkeys(("text", "textrm"), lambda: Piece(self._argument(), ATOM)),
            "sqrt": self._root,
            "!": lambda: Piece("", TIGHT),
        }
        if name in special:
            return special[name]()
        if name in ACCENTS:
            return Piece(_FIRST.sub(rf"\g<0>{ACCENTS[name]}", self._text(), count=1), ATOM)
        return Piece(name, ATOM)

    def _frame(self, opens: bool) -> Piece:
        self._skip_blanks()
        token = self._next() if self._peek() else ""
        sign = "" if token == "." else FRAMES.get(token[1:], token[1:]) if token.startswith("\\") else token
        # What is in a bracket that grows is a factor of its own: a blank before it shows that it is no argument.
        return Piece(sign, f"{OPEN} factor" if opens else CLOSE)

    def _fraction(self) -> Piece:
        above, below = self._text(), self._text()
        if (above, below) in HALVES:
            return Piece(HALVES[above, below], ATOM)
        # A sum in brackets, and what a function without them would take the fraction bar into.
        product = not _SUM.search(_without_brackets(above)) and not re.search(r"[a-z]{3} \S", above)
        above = above if product else f"({above})"
        simple = not re.search(r"[\s/+−±·]|^\d+[^\d\s]", _without_brackets(below))
        return Piece(f"{above}/{below if simple else f'({below})'}", FRACTION)

    def _root(self) -> Piece:
        inner = self._text()
        bare = re.fullmatch(r"\w+|\|[^|]*\|", inner)
        return Piece(f"√{inner}" if bare else f"√({inner})", ATOM)


def _without_brackets(text: str) -> str:
    """Return text without what stands in brackets, brackets included; an argument leaves nothing behind."""
    before = None
    while before != text:
        before, text = text, re.sub(r"\([^()]*\)|\[[^\[\]]*\]|\|[^|]*\|", "", text)
    return text


def _with_index(base: Piece | None, side: str, latex: str) -> Piece:
    """Return a piece with an index or an exponent."""
    index = _joined(list(_Reader(latex).pieces()))
    piece = base or Piece("", ATOM)
    if side == "^" and piece == ("e", ATOM) and not index.isdigit():
        return Piece(f"exp({index})", ATOM)
    tight = re.sub(r"(?<!,) ", "", index)
    table = RAISED if side == "^" else LOWERED
    if tight and all(sign in table for sign in tight):
        return piece._replace(text=piece.text + "".join(table[sign] for sign in tight))
    if side == "_" and tight in ("±", "∓"):
        return piece._replace(text=piece.text + tight)
    plain = re.fullmatch(r"[\w′]+", unicodedata.normalize("NFC", tight)) and (side == "^" or "_" not in tight)
    return piece._replace(text=f"{piece.text}{side}{tight if plain else f'({tight})'}")


def _joined(pieces: Sequence[Piece]) -> str:
    """Return pieces as a line: blanks around signs between two things, around relations, and behind commas."""
    line = ""
    before: Piece | None = None
    blank = False
    visible = [piece for piece in pieces if piece.text or piece.role == TIGHT]
    for i, piece in enumerate(visible):
        if piece.role == BLANK:
            blank = True
            continue
        after = next((later for later in visible[i + 1 :] if later.role != BLANK), None)
        text = piece.text
        goes_on = after is not None and after.role.split()[0] in (ATOM, FUNCTION, FRACTION, OPEN)
        if piece.role == FRACTION and (goes_on or (before is not None and before.role == SLASH)):
            text = f"({text})"
        line += (" " if _apart(before, piece, blank) else "") + text
        before, blank = _unless_first(piece, before), False
    return re.sub(r" +", " ", line).strip()


def _unless_first(piece: Piece, before: Piece | None) -> Piece:
    """Return a piece as the next piece sees it: a sign with nothing before it belongs to what follows."""
    return Piece(piece.text, TIGHT) if piece.role == SIGN and _begins(before) else piece


def _begins(before: Piece | None) -> bool:
    return before is None or before.role.split()[0] in (OPEN, SIGN, RELATION, COMMA, SLASH, TIGHT)


def _apart(before: Piece | None, piece: Piece, blank: bool) -> bool:
    """Return whether a blank stands between two pieces; `blank` tells whether the source has one there."""
    if before is None or before.role == TIGHT:
        return False
    left, right = before.role.split()[0], piece.role.split()[0]
    if RELATION in (left, right) or left in (COMMA, SIGN):
        return True
    if right == SIGN:
        return not _begins(before)
    if left == OPEN or SLASH in (left, right) or right in (CLOSE, COMMA, TIGHT):
        return False
    if right == FUNCTION or "factor" in piece.role:
        return left != FUNCTION or right == FUNCTION
    if left == FUNCTION:
        return right != OPEN
    if left == ATOM and before.text == "Δ" and right == ATOM:
        return False
    return blank or FRACTION in (left, right)

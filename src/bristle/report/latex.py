r"""Text for LaTeX: what has a meaning there is escaped, and letters, signs and indices of formulas are set as such.

What comes out is plain ASCII, and needs no package: ``σ₀`` is ``$\sigma_{0}$``, ``F_s`` is ``$F_{s}$``.
"""

from __future__ import annotations

import re
import unicodedata
from itertools import groupby

__all__ = ["as_latex", "roman"]


def _table(pairs: str) -> dict[str, str]:
    """Return what stands for each character: both by turns."""
    words = pairs.split()
    return dict(zip(words[::2], words[1::2], strict=True))


ESCAPED = _table(r"""
\ \textbackslash{}  { \{  } \}  $ \$  & \&  # \#  _ \_  % \%  ~ \textasciitilde{}  ^ \textasciicircum{}  < \textless{}
> \textgreater{}  | \textbar{}  ` \`{}  ‘ `  ’ '  “ ``  ” ''  – --  — ---  … \ldots{}  ß \ss{}  ø \o{}  Ø \O{}  æ \ae{}  Æ \AE{}
œ \oe{}  ł \l{}  Ł \L{}  ı \i{}  § \S{}  © \copyright{}
""") | {'"': "''", "\u00a0": "~", "\u2009": r"\,", "\u202f": r"\,"}
SIGNS = _table(r"""
− -  ± \pm  × \times  · \cdot  ÷ \div  → \to  ← \leftarrow  ≤ \leq  ≥ \geq  ≠ \neq  ≈ \approx  ∝ \propto  ∞ \infty  √ \surd
∫ \int  ∬ \int\!\!\int  ∂ \partial  ∇ \nabla  ∈ \in  ∑ \sum  ∏ \prod  ′ ^{\prime}  ″ ^{\prime\prime}  ° ^{\circ}  ℓ \ell  ‖ \|
µ \mu  ½ \frac{1}{2}  ¼ \frac{1}{4}  ∘ \circ  ≡ \equiv  ∆ \Delta  Ω \Omega  ∓ \mp  ∼ \sim  ⇒ \Rightarrow  ∀ \forall  ∃ \exists
∩ \cap  ∪ \cup  ⊂ \subset  ≪ \ll  ≫ \gg
""")
IN_TEXT = {
    "\u0300": "`",
    "\u0301": "'",
    "\u0302": "^",
    "\u0303": "~",
    "\u0304": "=",
    "\u0306": "u",
    "\u0307": ".",
    "\u0308": '"',
    "\u030a": "r",
    "\u030b": "H",
    "\u030c": "v",
    "\u0327": "c",
    "\u0328": "k",
}
IN_FORMULAS = {
    "\u0300": "grave",
    "\u0301": "acute",
    "\u0302": "hat",
    "\u0303": "tilde",
    "\u0304": "bar",
    "\u0306": "breve",
    "\u0307": "dot",
    "\u0308": "ddot",
    "\u030c": "check",
}
GREEK = _table(r"""
α \alpha  β \beta  γ \gamma  δ \delta  ε \varepsilon  ζ \zeta  η \eta  θ \theta  ι \iota  κ \kappa  λ \lambda  μ \mu  ν \nu  ξ \xi
ο o  π \pi  ρ \rho  ς \varsigma  σ \sigma  τ \tau  υ \upsilon  φ \varphi  χ \chi  ψ \psi  ω \omega  Α A  Β B  Γ \Gamma  Δ \Delta
Ε E  Ζ Z  Η H  Θ \Theta  Ι I  Κ K  Λ \Lambda  Μ M  Ν N  Ξ \Xi  Ο O  Π \Pi  Ρ P  Σ \Sigma  Τ T  Υ \Upsilon  Φ \Phi  Χ X  Ψ \Psi
Ω \Omega  ϑ \vartheta  ϕ \phi  ϖ \varpi  ϵ \epsilon
""")
NUMERALS = ((10, "X"), (9, "IX"), (5, "V"), (4, "IV"), (1, "I"))
_MARKS = "\u0300-\u036f"
_INDICES = "₀-₎ₐ-ₜᵢ-ᵪⱼ⁺⁻"
_SYMBOL = re.compile(
    # A letter by itself with an index, F_s or K₁, or with a mark, as of a derivative; any letter; all else.
    rf"(?<![A-Za-z0-9_])(?P<base>[A-Za-z\u0370-\u03ff])(?P<above>[{_MARKS}]*)_(?P<index>[A-Za-z0-9]+|[α-ω])(?![A-Za-z0-9_])"
    rf"|(?<![A-Za-z{_MARKS}])(?P<alone>[A-Za-z])(?:(?P<marks>[{_MARKS}]+)(?![A-Za-z])|(?=[{_INDICES}]))"
    rf"|(?P<letter>[A-Za-z\u0370-\u03ff])(?P<accents>[{_MARKS}]*)"
    r"|(?P<hyphen>(?<=-)-)"
    r"|(?P<other>.)",
    re.DOTALL,
)


def as_latex(text: str) -> str:
    r"""Return a text as LaTeX sets it, in one line.

    Examples
    --------
    >>> as_latex("5 % of F_s, ż = v (1 − σ₀ z/G)")
    '5 \\% of $F_{s}$, $\\dot{z}$ = v (1 $-$ $\\sigma_{0}$ z/G)'
    """
    line = unicodedata.normalize("NFD", " ".join(text.split()))
    parts = [_set(match) for match in _SYMBOL.finditer(line)]
    return "".join(
        f"${_formula([part for _, part in group])}$" if is_formula else "".join(part for _, part in group)
        for is_formula, group in groupby(parts, key=lambda part: part[0])
    )


def roman(number: int) -> str:
    """Return a number in Roman numerals, as names of commands take no others.

    Examples
    --------
    >>> roman(14), roman(9)
    ('XIV', 'IX')
    """
    text = ""
    for value, letters in NUMERALS:
        text, number = text + letters * (number // value), number % value
    return text


def _set(match: re.Match[str]) -> tuple[bool, str]:
    """Return whether a piece belongs into a formula, and how it is set."""
    if (base := match["base"]) is not None:
        index = match["index"]
        subscript = GREEK.get(index, index if len(index) == 1 or index.isdigit() else rf"\mathrm{{{index}}}")
        return True, f"{_marked(GREEK.get(base, base), match['above'])}_{{{subscript}}}"
    if (alone := match["alone"]) is not None:
        return True, _marked(alone, match["marks"] or "")
    if (letter := match["letter"]) in GREEK:
        return True, _marked(GREEK[letter], match["accents"])
    if letter is not None:
        for mark in match["accents"]:
            letter = rf"\{IN_TEXT[mark]}{{{letter}}}" if mark in IN_TEXT else letter
        return False, letter if letter.isascii() else _unknown(letter)
    # Two hyphens side by side would become a dash.
    return (False, "{}-") if match["hyphen"] else _sign(match["other"])


def _sign(sign: str) -> tuple[bool, str]:
    if sign in ESCAPED:
        return False, ESCAPED[sign]
    if sign in SIGNS:
        return True, SIGNS[sign]
    if sign.isascii():
        return False, sign if sign.isprintable() else ""
    kind, _, code = unicodedata.decomposition(sign).partition(" ")
    if kind in ("<sub>", "<super>"):
        inner = "".join(
            GREEK.get(character, SIGNS.get(character, character)) for character in (chr(int(number, 16)) for number in code.split())
        )
        return True, f"{'_' if kind == '<sub>' else '^'}{{{inner}}}"
    return False, "" if unicodedata.category(sign) in ("Cf", "Cc", "Mn", "Me") else _unknown(sign)


def _unknown(sign: str) -> str:
    """Return the name of a character that the fonts of LaTeX lack, so that nothing goes without notice."""
    return rf"\texttt{{U+{ord(sign[0]):04X}}}"


def _marked(letter: str, marks: str) -> str:
    for mark in marks:
        letter = rf"\{IN_FORMULAS[mark]}{{{letter}}}" if mark in IN_FORMULAS else letter
    return letter


def _formula(parts: list[str]) -> str:
    """Return the pieces of a formula joined: a command ends before a letter, and a letter has one index a side."""
    text = ""
    for part in parts:
        text += " " + part if re.search(r"\\[A-Za-z]+$", text) and part[:1].isalpha() else part
    for side in "_^":
        adjacent = re.compile(rf"(\{side}\{{(?:[^{{}}]|\{{[^{{}}]*\}})*)\}}\{side}\{{")
        while adjacent.search(text):
            text = adjacent.sub(r"\1", text)
    return text

r"""Text as LaTeX sets it: nothing in it is taken for a command, and formulas are formulas."""

import re
import shutil
import subprocess

import pytest
from tests.figures.hostile_names import NAMES

from bristle.paper.errata import ERRATA, errata_tex
from bristle.paper.reproduced import _all_words
from bristle.report.figure_files import captions
from bristle.report.latex import as_latex, roman
from bristle.report.page import Plate

SPECIAL = "\\ { } $ & # _ % ~ ^ < > | \" ` ' [ ] -- --- ?` !`"
WORDS = [text for one in _all_words().values() for text in one.values()]
TEXTS = [*WORDS, *(text for one in ERRATA for text in one), *NAMES, SPECIAL]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("ς̇ = θ̈_d − (u − F_p)/J", r"$\dot{\varsigma}$ = $\ddot{\theta}_{d}$ $-$ (u $-$ $F_{p}$)/J"),
        ("K₁₂ x₊₁² S⁺ σ₀", r"$K_{12}$ $x_{+1}^{2}$ $S^{+}$ $\sigma_{0}$"),
        ("f_β F_max", r"$f_{\beta}$ $F_{\mathrm{max}}$"),
        ("0.69 µm, 5 kg·m²", r"0.69 $\mu$m, 5 kg$\cdot$m$^{2}$"),
        ("Δx_s λė", r"$\Delta x_{s}$ $\lambda\dot{e}$"),
        ("F̂ of Müller, Łódź", r"$\hat{F}$ of M\"{u}ller, \L{}\'{o}d\'{z}"),
        ("coulomb_viscous --figure", r"coulomb\_viscous -{}-figure"),
        ("“a” ‘b’ – … 5 %", r"``a'' `b' -- \ldots{} 5 \%"),
        ("a\nb\t c", "a b c"),
        ("轴", r"\texttt{U+8F74}"),
        ("Ηϑ", r"$H\vartheta$"),
    ],
)
def test_signs_and_letters(text, told):
    assert as_latex(text) == told


@pytest.mark.parametrize("text", TEXTS)
def test_no_character_is_taken_for_a_command(text):
    told = as_latex(text)
    assert told.isascii()
    assert "\n" not in told
    outside = "".join(told.replace(r"\$", "").split("$")[::2])
    # What is left of it once commands and escaped signs are taken away has no meaning.
    plain = re.sub(r"\\[A-Za-z]+(?:\{[^{}]*\})?|\\.(?:\{[^{}]*\})?|~|\{\}", "", outside)
    assert not set(plain) & set("\\{}$&#_%^<>|")
    assert told.replace(r"\$", "").count("$") % 2 == 0


def test_a_letter_has_one_index_on_each_side():
    for text in TEXTS:
        assert not re.search(r"([_^])\{[^{}]*\}\1\{", as_latex(text))


def test_numerals():
    assert [roman(one) for one in (1, 4, 9, 14)] == ["I", "IV", "IX", "XIV"]


def test_each_erratum_is_a_row_with_all_that_it_tells():
    text = errata_tex()
    rows = [line for line in text.splitlines() if line.startswith("  {}")]
    assert len(rows) == len(ERRATA)
    for one, row in zip(ERRATA, rows, strict=True):
        for said in (one.location, one.printed, one.correct):
            assert as_latex(said) in row
    assert "test_" not in text
    assert r"\endhead" in text


def test_kinds_of_errata_have_a_column_where_there_are_kinds():
    class Told:
        place, printed, correct, kind = "(1)", "a", "b", "misprint"

    class Untold(Told):
        kind = ""

    assert r"\textbf{Kind}" in errata_tex([Told, Untold])
    assert "misprint" in errata_tex([Told, Untold])
    assert r"\textbf{Kind}" not in errata_tex([Untold])


def test_columns_share_the_width():
    shares = [float(one) for one in re.findall(r"dimexpr ([\d.]+)", errata_tex())]
    assert sum(shares) == pytest.approx(1.0, abs=0.01)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs pdflatex")
def test_latex_sets_every_text(tmp_path):
    plates = [Plate(f"figure-{number:02d}-a", None, text, text) for number, text in enumerate(TEXTS, 1)]
    text = re.sub(r"\\includegraphics\[[^]]*\]\{[^}]*\}", "", captions(plates))
    (tmp_path / "captions.tex").write_text(text)
    (tmp_path / "errata.tex").write_text(errata_tex())
    used = "\n".join(rf"\bristlefigure{roman(number)}a \clearpage" for number in range(1, len(plates) + 1))
    (tmp_path / "main.tex").write_text(
        "\\documentclass{article}\\usepackage{graphicx,array,longtable}\\input{captions}\\begin{document}\\listoffigures\n"
        + used
        + "\n\\input{errata}\\end{document}"
    )
    for _ in range(2):
        ended = subprocess.run(
            ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "main.tex"],
            cwd=tmp_path,
            capture_output=True,
            check=False,
            timeout=60,
        )
        assert ended.returncode == 0, ended.stdout.decode("latin-1")[-2000:]

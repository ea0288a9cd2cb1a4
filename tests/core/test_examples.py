"""What small functions return, by examples."""

import numpy as np
import pytest

from bristle.core.content import size_in_words, size_of
from bristle.core.dimensions import canonical, exponents_of, unit_elsewhere
from bristle.core.errors import close_names, did_you_mean, in_one_line, said_by_library
from bristle.core.experiment import substeps_for
from bristle.core.formula import Paragraph, as_markdown, as_text, paragraphs_of, spelt_out
from bristle.core.tabular import ranged
from bristle.core.typography import escaped, number, printable, typed, typeset, with_unit
from bristle.core.units import compatible, convert, factor, is_unit, quantity, si_of, split
from bristle.core.variable import Variable
from bristle.files.variant import merged
from bristle.report.page import typeset_sentence
from bristle.report.table import interval_text, stiffness_text


@pytest.mark.parametrize(
    ("call", "value"),
    [
        pytest.param(
            lambda: (size_of("1.5 GB"), size_of("64 MiB")), (1500000000, 67108864), id="size_of"
        ),
        pytest.param(
            lambda: (size_in_words(1500000000.0), size_in_words(700)),
            ("1.5 GB", "700 B"),
            id="size_in_words",
        ),
        pytest.param(
            lambda: (canonical("time * force/length/length"), canonical("length/length")),
            ("force*time/length^2", "1"),
            id="canonical",
        ),
        pytest.param(
            lambda: (dict(exponents_of("mass*length/time^2")), dict(exponents_of("frequency"))),
            ({"force": 1.0}, {"time": -1.0}),
            id="exponents_of",
        ),
        pytest.param(
            lambda: (
                unit_elsewhere("N*s/m", "translational", "rotational"),
                unit_elsewhere("N", "rotational", "translational"),
            ),
            ("N*m*s/rad", None),
            id="unit_elsewhere",
        ),
        pytest.param(
            lambda: did_you_mean("F_c", ["F_v", "F_C"]), "Did you mean 'F_C'?", id="did_you_mean"
        ),
        pytest.param(
            lambda: close_names("Positon", ["time", "position"]), ["position"], id="close_names"
        ),
        pytest.param(
            lambda: (
                said_by_library(ValueError("unexpected end")),
                said_by_library(ValueError("<Call object at 0x7f> is odd")),
            ),
            (" (unexpected end)", ""),
            id="said_by_library",
        ),
        pytest.param(
            lambda: in_one_line("two\nlines, and \x1b[31m"),
            "two lines, and \\x1b[31m",
            id="in_one_line",
        ),
        pytest.param(
            lambda: (substeps_for(0.0001), substeps_for(0.001), substeps_for(0.004)),
            (4, 4, 16),
            id="substeps_for",
        ),
        pytest.param(
            lambda: (
                as_text("e^{-(v/v_S)^2}"),
                as_text("\\tfrac12 h + \\sqrt{|\\varsigma|}"),
                as_text("|z|^{\\nu-1}"),
            ),
            ("exp(−(v/v_S)²)", "½ h + √|ς|", "|z|^(ν−1)"),
            id="as_text",
        ),
        pytest.param(
            lambda: "".join(map(spelt_out, "σ₀ ż ≤ v²")), "sigma_0 z_dot <= v^2", id="spelt_out"
        ),
        pytest.param(
            lambda: [
                kind for kind, _ in paragraphs_of(".. math:: F = F_v v\n\nOpposes :math:`v`.")
            ],
            ["equation", "text"],
            id="paragraphs_of",
        ),
        pytest.param(
            lambda: as_markdown(
                Paragraph("text", "The slope is :math:`\\sigma_0`, as in ``dahl`` [1]_.")
            ),
            "The slope is $\\sigma_0$, as in `dahl`.",
            id="as_markdown",
        ),
        pytest.param(
            lambda: ranged(np.array([-0.001, 0.0025]), "m"), "−1.000 to 2.500 mm", id="ranged"
        ),
        pytest.param(lambda: escaped("a\udcff\nb"), "a\\xff\nb", id="escaped"),
        pytest.param(lambda: printable("a\udcff\nb"), "a\\xff b", id="printable"),
        pytest.param(
            lambda: (typeset("kg*m^2"), typeset("N*s/m"), typeset("1")),
            ("kg·m²", "N·s/m", ""),
            id="typeset",
        ),
        pytest.param(
            lambda: typeset_sentence("using 0.5 N*m over 7 um, at 2 rad/s^2"),
            "using 0.5 N·m over 7 µm, at 2 rad/s²",
            id="typeset_sentence",
        ),
        pytest.param(
            lambda: (interval_text("1.2", "1.4"), interval_text("1.5674", "1.5674")),
            ("1.2 to 1.4", "1.5674, to the last digit"),
            id="interval_text",
        ),
        pytest.param(
            lambda: (number(95.10893, 0.108), number(-3.16481), number(123456.0)),
            ("95.11", "−3.165", "123456"),
            id="number",
        ),
        pytest.param(
            lambda: (number(3088.0, 30029.0), number(-0.0001, 0.1), number(-8.2499e59)),
            ("3000", "0.00", "−8.250e+59"),
            id="number",
        ),
        pytest.param(
            lambda: (typed(2e-06), typed([1.0, 0.5]), typed("central")),
            ("2e-06", "[1, 0.5]", "central"),
            id="typed",
        ),
        pytest.param(
            lambda: (with_unit(7.12e-06, "m"), with_unit(0.5, "1")),
            ("7.12 µm", "0.5"),
            id="with_unit",
        ),
        pytest.param(
            lambda: (
                stiffness_text(23080000.0, "translational"),
                stiffness_text(36.0, "rotational"),
            ),
            ("23.1 N/µm", "36.0 N·m/rad"),
            id="stiffness_text",
        ),
        pytest.param(
            lambda: quantity("7 um", Variable("length", "break-away distance")),
            7e-06,
            id="quantity",
        ),
        pytest.param(
            lambda: (convert("40 mNm", "N*m"), convert("30 %", "rated")), (0.04, 0.3), id="convert"
        ),
        pytest.param(lambda: factor("mm/s", "m/s"), 0.001, id="factor"),
        pytest.param(
            lambda: (compatible("um", "m"), compatible("rad", "1")), (True, False), id="compatible"
        ),
        pytest.param(lambda: (si_of("mm/s"), si_of("%")), ("m/s", "1"), id="si_of"),
        pytest.param(
            lambda: (is_unit("mm/s"), is_unit("vir"), is_unit("mil")),
            (True, False, False),
            id="is_unit",
        ),
        pytest.param(lambda: split("0.12 Nm / A"), ("0.12", "N*m/A"), id="split"),
        pytest.param(
            lambda: merged({"run": {"delay": 1, "settle": 0.5}}, {"run": {"delay": 2}}),
            {"run": {"delay": 2, "settle": 0.5}},
            id="merged",
        ),
        pytest.param(
            lambda: merged({"model": "coulomb", "F_C": 3.0}, {"model": "viscous", "F_v": 1.0}),
            {"model": "viscous", "F_v": 1.0},
            id="merged",
        ),
    ],
)
def test_examples_return_the_documented_result(call, value):
    assert repr(call()) == repr(value)

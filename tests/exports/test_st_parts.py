"""Parts of Structured Text: names, literals, inputs that are parameters, and the sum of a self-test."""

import math
from fractions import Fraction

import numpy as np
import pytest

import bristle as br
from bristle.core.errors import InputError
from bristle.exports.st_code import Printer
from bristle.exports.st_parts import LREAL, Names, Pou, Record, Variable, checked, part_text, real_literal, used_of, whole_literal
from bristle.exports.st_parts import Array as ArrayPart
from bristle.exports.st_project import Judged, Tuned, bounds, set_lines, total_of
from bristle.exports.subject import Walk
from bristle.exports.tunable import tunable_of
from bristle.translation.tree import Unit, struct_type


@pytest.mark.parametrize("value", [1e300, -1.7976e308, 2.2250738585072014e-308, 5e-324, 1.5, -0.1, 0.0, 1e37, 1e-37, 3e40])
def test_a_literal_of_any_magnitude_is_exact_with_small_factors(value):
    text = real_literal(value)
    factors = [float(part) for part in text.strip("()").split(" * ")]
    assert math.prod(factors) == value
    assert all(factor == 0.0 or 1e-37 <= abs(factor) <= 1e37 for factor in factors)
    assert ("*" in text) == (value != 0.0 and not 1e-37 <= abs(value) <= 1e37)


def test_the_largest_number_has_finite_factors_in_single_precision():
    factors = [float(np.float32(part)) for part in real_literal(1.7976931348623157e308).strip("()").split(" * ")]
    assert math.prod(factors) == pytest.approx(1.7976931348623157e308, rel=1e-7)


def test_infinity_and_nan_have_substitute_numbers():
    assert float(real_literal(math.inf)) == 1e37
    assert float(real_literal(-math.inf)) == -1e37
    assert 1e37 < float(real_literal(math.nan)) < 1e38


@pytest.mark.parametrize(
    ("literal", "arguments", "text"),
    [
        (real_literal, (2.0,), "2.0"),
        (real_literal, (1e20,), "1.0E20"),
        (real_literal, (1.5e-7,), "1.5E-7"),
        (real_literal, (0.1, "REAL"), "REAL#0.1"),
        (real_literal, (-0.5, "REAL"), "-REAL#0.5"),
        (real_literal, (1.0 / 3.0, "REAL"), "REAL#0.33333334"),
        (whole_literal, (2**31 - 1,), "2147483647"),
        (whole_literal, (2**31,), "LINT#2147483648"),
        (whole_literal, (-(2**31),), "LINT#-2147483648"),
    ],
)
def test_a_literal_has_a_decimal_point_and_in_single_precision_its_type(literal, arguments, text):
    assert literal(*arguments) == text


def test_names_are_unique_regardless_of_case():
    names = Names(["Used"], prefix="axis_")
    assert names.of("key", "force") == names.of("key", "other") == "axis_force"
    assert names.new("FORCE").lower() != "axis_force"
    assert Names(["used"]).new("Used").lower() != "used"


@pytest.mark.parametrize(("name", "new"), [("x", "v_x"), ("limit", "v_limit"), ("a__b_", "a_b"), ("1st", "part_1st")])
def test_a_name_becomes_one_that_every_compiler_accepts(name, new):
    assert Names([]).new(name) == new


@pytest.mark.parametrize("name", ["if", "ab", "axis_", "a__b", "limit", "integral", "ramp", "hysteresis", "pid", "rtc", "sema", "lag1"])
def test_a_block_has_a_name_that_every_compiler_accepts(name):
    with pytest.raises(InputError, match="cannot name a function block"):
        checked(name)
    checked("axis_x")
    checked("abc")


SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])


def printer(scalar=LREAL):
    return Printer(Unit([]), "axis", (struct_type(SLIP.parameters),), scalar)


def test_each_number_of_an_array_is_an_input_that_counts_from_one():
    tuned = Tuned.of(tunable_of(SLIP), Names(["nu_i_2"]))
    inputs = {variable.name: variable.initial for variable in tuned.inputs(printer())}
    assert inputs == {"F_C": "4.0", "k_i_1": "100000.0", "k_i_2": "200000.0", "nu_i_1": "0.25", "nu_i_2_2": "0.75", "sigma_2": "0.0"}
    lines = list(tuned.lines("parameters", struct_type(SLIP.parameters), printer()))
    assert "parameters.nu_i[1] := nu_i_2_2;" in lines
    assert "parameters.F_C := F_C;" in lines


@pytest.mark.parametrize(("scalar", "farthest"), [("LREAL", "1.0E30"), ("REAL", "REAL#1.0E15")])
def test_an_unbounded_input_is_limited_to_finite_numbers(scalar, farthest):
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=0.5)
    of_force, of_offset = Tuned.of(tunable_of(offset), Names()).ranges(Printer(Unit([]), "axis", scalar=scalar))
    assert of_force.startswith("(F_C >= ")
    assert of_offset == f"(offset >= -{farthest}) AND (offset <= {farthest})"


def test_a_structure_is_set_number_by_number_except_skipped_paths():
    lines = list(set_lines("p", SLIP.parameters, struct_type(SLIP.parameters), printer(), skipped=[("F_C",)]))
    assert not any("F_C" in line for line in lines)
    assert [line for line in lines if "nu_i" in line] == ["p.nu_i[0] := 0.25;", "p.nu_i[1] := 0.75;"]
    truths = br.friction.with_slots(br.friction.lugre, ["asymmetry"])(
        F_C_pos=1.0, F_C_neg=2.0, F_S_pos=1.0, F_S_neg=2.0, v_S=1.0, sigma_0=1e5
    ).parameters
    nested = list(set_lines("p", truths, struct_type(truths), Printer(Unit([]), "axis", (struct_type(truths),))))
    assert any(line.count(".") > 1 and line.startswith("p.") and ":= 2.0;" in line for line in nested)


def test_inputs_are_limited_so_that_squares_stay_in_range():
    double, single = ({name: float(text or 0.0) for name, text in bounds(single=narrow, farthest=1e5).items()} for narrow in (False, True))
    assert double["farthest"] == double["beyond"] == single["beyond"] == 1e30
    assert (single["farthest"], double["fastest"]) == (1e5, 0.0)
    assert np.isfinite(np.float32(single["fastest"] / 1e-10) ** 2)  # a velocity over the smallest of Stribeck
    assert [bound["shortest"] * bound["longest"] for bound in (double, single)] == pytest.approx([1.0, 1.0])
    assert double["shortest"] < single["shortest"] <= 1e-6
    assert bounds(single=False)["fastest"] == ""


def test_sum_and_rounding_error_add_up_to_the_exact_sum():
    numbers = [1e16, 1.0, -1e16, 3e-5, 0.1, -7.25e9]
    total, lost = total_of(numbers)
    assert total == sum(numbers)
    assert float(sum(map(Fraction, numbers))) == pytest.approx(total + lost, rel=1e-15)
    assert lost != 0.0


def test_a_self_test_compares_the_sum_or_in_single_precision_some_numbers():
    outputs = np.linspace(-4.0, 2.0, 51)
    facts = Judged("axis", outputs, single=True).facts()
    assert (facts["tolerance"], facts["count"], facts["last"], facts["every"]) == ("0.004", 51, "2.0", 25)
    assert [float(text) for text in facts["expected"]] == pytest.approx([-4.0, -1.0, 2.0])


WALK = Walk((1.0, 2.0, 3.0), 1e-3)


@pytest.mark.parametrize(
    ("single", "arrays", "names", "gave"),
    [
        (True, [("axis_Scales", 3), ("more", 7), ("axis_Expected", 3)], {"worst", "expected"}, "within the error of single precision"),
        (False, [("axis_Scales", 3), ("more", 7)], {"total", "lost", "added"}, "bit by bit"),
    ],
)
def test_a_self_test_has_the_variables_of_its_precision(single, arrays, names, gave):
    judged, other = (Judged("axis", np.linspace(-4.0, 2.0, 51), way) for way in (single, not single))
    assert [(part.name, part.size) for part in judged.arrays(WALK, ArrayPart("more", 7, LREAL))] == arrays
    meanings, others = ({variable.name: variable.meaning for variable in each.variables()} for each in (judged, other))
    assert meanings.keys() - others.keys() == names
    assert meanings["passed"].endswith(gave)


def test_used_types_include_their_inner_types():
    array, inner = ArrayPart("numbers", 3, LREAL), Record("inner", (Variable("a", "numbers"),))
    outer, idle = Record("outer", (Variable("b", "inner"),)), Record("idle", (Variable("c", "numbers"),))
    pou = Pou("FUNCTION", "f", "BOOL", (Variable("x", "outer"),), ("f := TRUE;",), "what (* it does")
    assert used_of([array, inner, outer, idle], [pou]) == [array, inner, outer]
    assert used_of([array, inner, outer, idle], []) == []
    assert part_text(array) == "TYPE\n    numbers : ARRAY[0..2] OF LREAL;\nEND_TYPE\n"
    assert part_text(pou) == "(* what ( * it does *)\nFUNCTION f : BOOL\nVAR\n    x : outer;\nEND_VAR\n\nf := TRUE;\nEND_FUNCTION\n"

"""Parts of a source in C: helpers that are called, parameters with their ranges, and where each number is saved."""

import re

import numpy as np
import pytest

import bristle as br
from bristle.exports.c import CFiles
from bristle.exports.c_code import Printer
from bristle.exports.c_parts import array_text, constant_text, declared, helpers_text, literal, parameters_text, saved_facts, started
from bristle.exports.subject import subject_of
from bristle.exports.targets import Request
from bristle.exports.tunable import tunable_of
from bristle.translation.tree import INTEGER, REAL, Unit, struct_type

SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])
KIND = struct_type(SLIP.parameters)


def printer(scalar="double"):
    return Printer(Unit([]), scalar, [KIND])


def test_only_used_helpers_and_bit_unions_are_written():
    assert helpers_text(["min"], "double", "int32_t") == (
        "static inline double least(double a, double b)\n{\n    return b < a ? b : a;\n}\n"
    )
    for name in ("copysign", "abs", "power_of_two", "mantissa", "exponent"):
        assert helpers_text([name], "float", "int32_t").startswith("typedef union {\n    float number;\n    uint32_t bits;\n} Bits;\n")
    assert "uint64_t bits" in helpers_text(["abs"], "double", "int32_t")
    assert "int64_t next_below(float x)" in helpers_text(["floor"], "float", "int64_t")
    assert helpers_text([], "double", "int32_t") == ""


def test_masks_and_shifts_follow_from_the_format():
    for scalar, kind, bits in (("double", np.float64, np.uint64), ("float", np.float32, np.uint32)):
        text, info = helpers_text(["power_of_two", "mantissa", "exponent", "copysign"], scalar, "int32_t"), np.finfo(kind)
        masks = {int(mask, 16) for mask in re.findall(r"_C\((0x[0-9A-F]+)\)", text)}
        (place,) = re.findall(r"\{k \+ ([0-9.]+)", text)
        # The sign, the fraction, the bits of 1, and those of the number whose last place is 1; k and the bias beside it.
        rounder = kind(1.5 * 2.0**info.nmant)
        assert masks == {1 << (info.bits - 1), (1 << info.nmant) - 1, int(kind(1.0).view(bits)), int(rounder.view(bits))}
        assert float(place) == float(rounder) + 2.0 ** (info.bits - info.nmant - 2) - 1.0
        assert set(re.findall(r"(?:<<=|>>) (\d+)U", text)) == {str(info.nmant)}


def test_fixed_parameters_are_a_constant_with_separate_arrays():
    text = constant_text("parameters", SLIP.parameters, KIND, printer())
    assert "static const double fixed_nu_i[2] = {\n    0.25, 0.75\n};" in text
    assert re.search(r"static const Parameters parameters = \{4\.0, .*fixed_nu_i, .*\};\n$", text)
    assert parameters_text(SLIP.parameters, KIND, printer(), "axis_x", None) == text


def test_seven_numbers_take_two_lines_and_an_empty_array_one_element():
    assert array_text("table", np.arange(7.0), printer("float")) == (
        "static const float table[7] = {\n    0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f,\n    6.0f\n};"
    )
    assert array_text("table", np.zeros(0), printer()) == "static const double table[1] = {\n    0\n};"
    assert (literal(2.0, INTEGER, "double"), literal(2, REAL, "float"), literal(True, INTEGER, "float")) == ("2", "2.0f", "1")


def test_variable_parameters_are_checked_against_their_ranges():
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=-0.5)
    tuned = tunable_of(offset)
    text = parameters_text(
        offset.parameters, struct_type(offset.parameters), Printer(Unit([]), "float", [struct_type(offset.parameters)]), "axis", tuned
    )
    assert "bool within_ranges(const axis_parameters *given)" in text
    assert "given->offset >= -FLT_MAX && given->offset <= FLT_MAX" in text
    low = offset.component.variables["F_C"].min
    assert f"given->F_C >= {low!r}f" in text
    assert "given->F_C <=" not in text
    assert [line.partition(";")[0] for line in declared(tunable_of(SLIP), printer())][:2] == ["double F_C", "double k_i[2]"]
    assert started(tunable_of(SLIP), printer())[1:3] == ["axis->parameters.k_i[0] = 100000.0;", "axis->parameters.k_i[1] = 200000.0;"]


@pytest.mark.parametrize(("scalar", "widened", "narrowed"), [("double", "", ""), ("float", "(double)", "(float)")])
def test_saved_numbers_have_eight_bytes_after_layout_and_marks(scalar, widened, narrowed):
    fields = [("z", REAL, "", 0.0), ("depth", INTEGER, "", 0)]
    facts = saved_facts(printer(scalar), ("position", "force"), fields, 20, "layout")
    # The layout, position, force, marks, z, depth, twenty numbers and the checksum.
    assert facts["heads"] == [{"name": "position", "at": 8}, {"name": "force", "at": 16}]
    assert (facts["marks_at"], facts["memory_at"], facts["saved"]) == (24, 48, 8 * (4 + 2 + 20 + 1))
    z, depth = facts["saved_state"]
    assert z["put"] == f"put_real(at, {widened}axis->state.z)"
    assert (z["got"], z["refused"]) == (f"axis->state.z = {narrowed}got_real(bytes + 32)", "!is_finite(got_real(bytes + 32))")
    assert depth["put"] == "put(at, (uint64_t)axis->state.depth)"
    assert (depth["got"], depth["refused"]) == ("axis->state.depth = (int32_t)got(bytes + 40)", "got(bytes + 40) >= 10U")
    assert saved_facts(printer(), ("effort",), [], 0, "layout")["saved"] == 8 * (3 + 1)
    assert facts["layout"] != saved_facts(printer(scalar), ("position", "force"), fields, 20, "other")["layout"]


@pytest.mark.parametrize(("dt", "cycles", "period", "every"), [(1e-3, 1000, "1", 100), (0.4, 2, "0.8", 1), (3.0, 2, "6", 1)])
def test_an_example_runs_a_second_and_prints_ten_numbers(dt, cycles, period, every):
    coulomb = br.friction.coulomb(F_C=1.0)
    facts = CFiles(subject_of(coulomb), Request(coulomb, "axis_x", dt)).facts()
    assert (facts["cycles"], facts["period"], facts["every"], facts["drive"]) == (cycles, period, every, None)
    assert facts["zero"] == "0.0"

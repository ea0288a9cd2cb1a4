"""Structured Text: the bits of bristle in an interpreter of it, and each of its parts."""

import math
import re
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from tests.apps.targets.structured_text import StandardError, StructuredText, Translator, parsed
from tests.exports.native import (
    ALL,
    COMPILER,
    Native,
    differing,
    example_with,
    selected_cases,
    texts_of,
    walk,
)

import bristle as br
from bristle.apps.targets.st_code import Printer
from bristle.apps.targets.st_parts import (
    LREAL,
    RESERVED,
    Array as ArrayPart,
    Names,
    Pou,
    Record,
    Variable,
    checked,
    helpers_of,
    part_text,
    real_literal,
    used_of,
    whole_literal,
)
from bristle.apps.targets.st_project import NAMESPACE, Judged, Tuned, bounds, set_lines, total_of
from bristle.core.exponent import exponent, mantissa
from bristle.engine.translation.tree import Unit, struct_type
from bristle.exports.described import Source
from bristle.exports.subject import Walk
from bristle.exports.tunable import tunable_of

pytestmark = pytest.mark.skipif(
    COMPILER is None, reason="needs a C compiler, which translated text goes through"
)
DT = 5e-4
SIGNALS = {"load": 1.0, "temperature": 293.15, "transmitted": 0.0}
CHOSEN = {
    "sided_lugre": ("lugre", ("asymmetry",)),
    "plain_coulomb": ("coulomb", ()),
    "plain_maxwell_slip": ("maxwell_slip", ()),
    "sided_maxwell_stribeck": ("maxwell_stribeck", ("asymmetry",)),
    "varied_gms": ("gms", ALL),
    "varied_preisach_lugre": ("preisach_lugre", ALL),
}


def example(name):
    base, slots = CHOSEN[name]
    return example_with(base, slots)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written")
    return {name: texts_of(example(name), folder, name) for name in CHOSEN}


@pytest.fixture(scope="module")
def blocks(written, tmp_path_factory):
    return StructuredText(written, tmp_path_factory.mktemp("blocks"))


@pytest.mark.fast_cases(5)
@pytest.mark.parametrize("name", CHOSEN)
def test_forces_are_identical_to_bristle_without_traps(blocks, name):
    force, flags = blocks.run(name, walk(20_000), DT, **SIGNALS)
    expected = br.response(example(name), walk(20_000), DT, rest="held")
    assert np.ptp(expected) > 0.0
    assert differing(force, expected) == 0
    assert not flags.any()


@pytest.mark.parametrize("name", CHOSEN)
def test_the_self_test_completes_and_passes(blocks, name):
    assert blocks.selftest(name) == (True, True)


@pytest.mark.slow
def test_a_controller_that_truncates_on_conversion_gives_identical_forces(written, tmp_path):
    names = ("sided_lugre", "sided_maxwell_stribeck")
    cutting = StructuredText({name: written[name] for name in names}, tmp_path, rounded="trunc")
    for name in names:
        assert cutting.selftest(name) == (True, True)


@pytest.mark.parametrize(
    ("seen", "instead"),
    [
        ("sigma_1 := 1000.0;", "sigma_1 := 1000.0000000000001;"),
        ("F_C := 22.0;", "F_C := 22.000000000000004;"),
        (" + 0.0;", " + 1.0E-30;"),
    ],
)
def test_the_self_test_detects_an_error_in_the_last_digit(written, tmp_path, seen, instead):
    block, test = written["sided_lugre"]
    assert seen in block
    changed = StructuredText({"sided_lugre": [block.replace(seen, instead), test]}, tmp_path)
    assert changed.selftest("sided_lugre") == (True, False)


CONTRACTING = Path("/proc/cpuinfo")


@pytest.mark.skipif(
    not CONTRACTING.exists() or " fma " not in CONTRACTING.read_text(),
    reason="needs a processor with x86 FMA",
)
def test_the_self_test_detects_fused_multiply_add(written, tmp_path):
    contracted = StructuredText(
        {"sided_lugre": written["sided_lugre"]},
        tmp_path,
        flags=("-O2", "-ffp-contract=fast", "-mfma"),
    )
    assert contracted.selftest("sided_lugre") == (True, False)


def test_a_position_that_is_not_a_number_repeats_the_force_and_sets_a_flag(blocks):
    x = [0.0, 1e-5, np.nan, np.inf, -1e31, 2e-5, 3e-5, 3e-5, 3e-5, 0.0]
    dt = [1.0, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 0.0, np.nan, 1e-3, 1e-3]
    force, flags = blocks.run("sided_lugre", x, dt, commands=[0, 0, 0, 0, 2, 2, 0, 0, 2, 1])
    expected = br.response(example("sided_lugre"), [0.0, 1e-5, 2e-5, 3e-5], 1e-3)
    assert flags.tolist() == [0, 0, 1, 1, 1, 0, 1, 1, 0, 0]
    assert force.tolist() == [0.0, *[expected[1]] * 4, *[expected[2]] * 3, expected[3], 0.0]


def test_a_position_of_minus_zero_counts_as_zero(blocks):
    force, _ = blocks.run("plain_coulomb", [0.0, -0.0, 1e-6, 1e-6], DT)
    assert (
        force.tolist()
        == br.response(example("plain_coulomb"), [0.0, 0.0, 1e-6, 1e-6], DT, rest="held").tolist()
    )
    assert force[1] == 0.0 < force[2] == force[3]


def test_load_and_temperature_are_inputs(blocks, written):
    x, load = walk(500), np.linspace(0.5, 2.0, 500)
    force, _ = blocks.run("varied_gms", x, DT, load=load, temperature=293.15)
    usual, _ = blocks.run("varied_gms", x, DT, load=1.0, temperature=293.15)
    assert differing(force, usual) > 400
    assert "load : LREAL := 1.0;" in written["varied_gms"][0]
    assert "temperature : LREAL := 293.15;" in written["varied_gms"][0]


def declared(node):
    """Return every name that a text declares."""
    kinds = ("variable_declaration", "structure_field", "type_definition", "function_declaration")
    names = [
        n.text.decode().lower()
        for field in ("name", "names")
        for n in node.children_by_field_name(field)
    ]
    custom = names if node.type in kinds or node.type.endswith("_declaration") else []
    return {*custom, *(name for child in node.named_children for name in declared(child))}


@pytest.mark.parametrize("name", CHOSEN)
def test_no_name_is_a_keyword(written, name):
    for text in written[name]:
        names = declared(parsed(text))
        assert len(names) > 10
        assert not names & RESERVED
        assert all("__" not in n and not n.endswith("_") and len(n) > 2 for n in names)


def loops(text):
    """Return the first and the last number of each loop that counts."""
    return re.findall(r"\bFOR \w+ := (.+) TO (.+) DO", text)


@pytest.mark.parametrize("name", CHOSEN)
def test_no_counting_loop_can_have_a_single_pass(written, name):
    for text in written[name]:
        assert all(int(first) < int(last) for first, last in loops(text))


def test_a_model_of_one_element_has_no_counting_loop(tmp_path):
    model = br.friction.maxwell_slip(F_C=20.0, k_i=[6e6], nu_i=[1.0])
    assert loops(texts_of(model, tmp_path)[0]) == []


@pytest.mark.parametrize("name", ["stribeck", "stribeck_free"])
def test_each_function_has_at_least_one_input(tmp_path, name):
    # Where the exponent of the fall is 2, nothing is left of the power but a number.
    model = example_with(name)
    text, _ = texts_of(model, tmp_path, "axis_x")
    heads = re.findall(r"(?m)^FUNCTION \w+ : \w+\n(\w+)", text)
    assert len(heads) > 4
    assert set(heads) <= {"VAR_INPUT", "VAR_IN_OUT"}


HELPED = """
FUNCTION_BLOCK {block}
VAR_INPUT position : LREAL; period : LREAL; restart : BOOL; clear : BOOL; END_VAR
VAR_OUTPUT force : LREAL; refused : BOOL; overflow : BOOL; END_VAR
    {body}
END_FUNCTION_BLOCK
PROGRAM {block}_selftest
VAR_OUTPUT done : BOOL; passed : BOOL; END_VAR
    done := TRUE;
END_PROGRAM
"""
REALS = (
    1.0,
    1.9999999999999998,
    2.0,
    3.7,
    0.5,
    0.3,
    2.0**-63,
    2.0**-65,
    1e-66,
    2.0**64,
    2.0**64 * 0.999,
    7e200,
    2.2250738585072014e-308,
    4e-308,
    1.7976931348623157e308,
    2.0**1023,
)
SINGLE_REALS = (
    1.0,
    1.9999999,
    2.0,
    3.7,
    0.3,
    1.2e-38,
    3.4e38,
    2.0**-63,
    2.0**64,
    2.0**64 * 0.999,
    2.0**-126,
    2.0**127,
)
SINGLE_CALL = "REAL_TO_LREAL({{0}}({} := LREAL_TO_REAL(position)))"
HELPERS = {
    "power_of_two": (
        lambda k: math.ldexp(1.0, int(k)),
        (*range(-1022, 1024, 5), 1023, 512, -512),
        "{0}(power := position)",
    ),
    "mantissa": (mantissa, REALS, "{0}(number := position)"),
    "exponent": (exponent, REALS, "{0}(number := position)"),
    "floor": (
        math.floor,
        (-2.5, -2.0, -0.1, 0.0, 0.5, 2.0, 2.7, 1e9),
        "DINT_TO_LREAL({0}(number := position))",
    ),
    "truncated": (
        math.trunc,
        (-2.5, -2.0, -0.1, 0.0, 2.7, -1e9),
        "DINT_TO_LREAL({0}(number := position))",
    ),
    "floor_divided": (
        lambda x: x // 3,
        (-7, -6, -1, 0, 2, 7),
        "DINT_TO_LREAL({0}(first := LREAL_TO_DINT(position), second := 3))",
    ),
    "floor_rest": (
        lambda x: x % -3,
        (-7, -6, -1, 0, 2, 7),
        "DINT_TO_LREAL({0}(first := LREAL_TO_DINT(position), second := -3))",
    ),
    "abs": (abs, (-2.5, 0.0, 3.0), "1.0 * {0}(number := position)"),
    "copysign": (
        lambda x: math.copysign(-2.0, x),
        (-1e-300, 0.0, 3.0),
        "{0}(number := -2.0, sign_of := position)",
    ),
    "single_power_of_two": (
        lambda k: math.ldexp(1.0, int(k)),
        range(-126, 128),
        SINGLE_CALL.format("power"),
    ),
    "single_mantissa": (
        lambda x: math.frexp(np.float32(x))[0] * 2.0,
        SINGLE_REALS,
        SINGLE_CALL.format("number"),
    ),
    "single_exponent": (
        lambda x: math.frexp(np.float32(x))[1] - 1.0,
        SINGLE_REALS,
        SINGLE_CALL.format("number"),
    ),
}


@pytest.fixture(scope="module", params=["nearbyint", pytest.param("trunc", marks=pytest.mark.slow)])
def helpers(request, tmp_path_factory):
    """Each helper, with its call, in a block of its own: compiled at once."""
    texts = {}
    for name, (_, _, call) in HELPERS.items():
        block, helper = f"of_{name}", name.removeprefix("single_")
        pous = helpers_of(
            [helper], f"{block}_{{}}".format, "DINT", "LREAL" if helper == name else "REAL"
        )
        body = f"force := {call.format(f'{block}_{helper}')};"
        texts[block] = [
            "".join(part_text(pou) for pou in pous) + HELPED.format(block=block, body=body)
        ]
    return StructuredText(texts, tmp_path_factory.mktemp("helpers"), rounded=request.param)


@pytest.mark.parametrize("name", HELPERS)
def test_bit_helpers_are_exact_over_the_whole_range(name, helpers):
    expected, arguments, _ = HELPERS[name]
    result, _ = helpers.run(f"of_{name}", [float(argument) for argument in arguments])
    assert differing(result, np.array([float(expected(argument)) for argument in arguments])) == 0


# --- single precision, and parameters that may be changed at run time -------------------------------------------------

ARITHMETIC = {
    "tuned": {"tunable": True},
    "single": {"float32": True},
    "both": {"tunable": True, "float32": True},
}
OTHERWISE = [
    ("sided_lugre", "tuned"),
    ("varied_gms", "tuned"),
    ("varied_preisach_lugre", "tuned"),
    ("sided_lugre", "both"),
    ("sided_lugre", "single"),
    ("plain_coulomb", "single"),
    ("sided_maxwell_stribeck", "single"),
    ("varied_gms", "single"),
    ("varied_preisach_lugre", "single"),
]
SINGLE = [name for name, kind in OTHERWISE if kind == "single"]


@pytest.fixture(scope="module")
def otherwise(request, tmp_path_factory):
    """Blocks by model and arithmetic, with their texts, and the C of those in single precision: of what tests ask for."""
    folder = tmp_path_factory.mktemp("otherwise")
    singles = {name for (name,) in selected_cases(request, "single")} | {"sided_lugre"}
    cases = (
        selected_cases(request, "name", "kind")
        | {("sided_lugre", kind) for kind in ARITHMETIC}
        | {(name, "single") for name in singles}
    )
    written = {
        f"{kind}_{name}": texts_of(example(name), folder, f"{kind}_{name}", **ARITHMETIC[kind])
        for name, kind in cases
    }
    native = Native({name: example(name) for name in singles}, folder / "native", float32=True)
    return written, StructuredText(written, folder / "blocks"), native


def usual(text):
    """Return the parameters of a block by their names, with the values that they have where nobody gives others."""
    block = text[text.index("FUNCTION_BLOCK") :]
    result = re.findall(r"(\w+) : L?REAL := (-?)(?:REAL#)?([\d.E+-]+);", block)
    return {name.lower(): float(sign + number) for name, sign, number in result}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), OTHERWISE)
def test_the_self_test_passes_with_the_exported_parameters(otherwise, name, kind):
    assert otherwise[1].selftest(f"{kind}_{name}") == (True, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind", "inputs", "values"),
    [
        (
            "sided_lugre",
            "tuned",
            {"f_s_pos": 33.5, "sigma_1": 700.0},
            {"F_S_pos": 33.5, "sigma_1": 700.0},
        ),
        (
            "varied_gms",
            "tuned",
            {"k_i_2": 2e6, "v_c": 1500.0},
            {"k_i": [6e6, 2e6, 1e6], "C": 1500.0},
        ),
        ("varied_preisach_lugre", "tuned", {"f_p": 36.0}, {"f_p": 36.0}),
    ],
)
def test_a_parameter_input_acts_as_in_bristle(otherwise, name, kind, inputs, values):
    written, blocks, _ = otherwise
    x, defaults = walk(4000), usual(written[f"{kind}_{name}"][0])
    assert set(inputs) <= set(defaults)
    force, flags = blocks.run(f"{kind}_{name}", x, DT, **defaults)
    assert differing(force, br.response(example(name), x, DT)) == 0
    force, flags = blocks.run(f"{kind}_{name}", x, DT, **defaults | inputs)
    assert differing(force, br.response(example(name).with_values(**values), x, DT)) == 0
    assert not flags.any()


@pytest.mark.parametrize(
    ("arithmetic", "beyond"),
    [("tuned", {"f_s_pos": 0.0}), ("both", {"f_c_neg": -1.0}), ("tuned", {"offset": 2e30})],
)
def test_a_parameter_outside_its_range_is_refused_and_the_force_repeated(
    otherwise, arithmetic, beyond
):
    written, blocks, _ = otherwise
    name = f"{arithmetic}_sided_lugre"
    force, flags = blocks.run(name, walk(50), DT, **usual(written[name][0]) | beyond)
    assert not force.any()
    assert flags[1:].all()


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("single", SINGLE)
def test_single_precision_is_identical_to_c(otherwise, single):
    _, blocks, native = otherwise
    x = walk(20_000)
    force, flags = blocks.run(f"single_{single}", x, DT, **SIGNALS)
    assert differing(force, native.forces(single, x, DT)) == 0
    assert not flags.any()
    exact = br.response(example(single), x, DT, rest="held")
    off = np.max(np.abs(force - exact)) / np.max(np.abs(exact))
    assert off < 1e-6
    assert off > 0.0 or single == "plain_coulomb"  # whose numbers have few digits


def test_the_single_precision_self_test_detects_a_wrong_parameter(otherwise, tmp_path):
    block, test = otherwise[0]["single_sided_lugre"]
    assert "F_C := REAL#22.0;" in block
    changed = StructuredText(
        {"single_sided_lugre": [block.replace("F_C := REAL#22.0;", "F_C := REAL#22.1;"), test]},
        tmp_path,
    )
    assert changed.selftest("single_sided_lugre") == (True, False)


def test_inputs_beyond_the_range_of_single_precision_are_refused(otherwise):
    x, dt = [0.0, 1e-5, 1e8, 2e-5, 2e-5], [1.0, 1e-3, 1e-2, 1e-7, 1e-3]
    force, flags = otherwise[1].run("single_sided_lugre", x, dt)
    assert flags.tolist() == [0, 0, 1, 1, 1]
    assert force.tolist() == [0.0, force[1], force[1], force[1], force[4]]
    assert force[4] != force[1]


# --- XML --------------------------------------------------------------------------------------------------------------

# What may be inside each element, in this order, as the schema of TC6 2.01 has it.
ORDER = {
    "project": ["fileHeader", "contentHeader", "types", "instances"],
    "contentHeader": ["Comment", "coordinateInfo"],
    "coordinateInfo": ["fbd", "ld", "sfc"],
    "types": ["dataTypes", "pous"],
    "dataType": ["baseType"],
    "pou": ["interface", "body", "documentation"],
    "variable": ["type", "initialValue", "documentation"],
    "interface": ["returnType", "inputVars", "outputVars", "inOutVars", "localVars"],
    "body": ["ST"],
    "array": ["dimension", "baseType"],
}
NEEDED = {
    "fileHeader": {"companyName", "productName", "productVersion", "creationDateTime"},
    "contentHeader": {"name"},
    "pou": {"name", "pouType"},
    "variable": {"name"},
    "dataType": {"name"},
    "dimension": {"lower", "upper"},
}


def local(element):
    return element.tag.rpartition("}")[2]


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    return texts_of(example("varied_gms"), folder), ElementTree.parse(
        folder / "out_axis_x" / "axis_x_plcopen.xml"
    ).getroot()


def test_the_xml_has_the_structure_of_its_schema(project):
    for element in project[1].iter():
        name, inside = local(element), [local(child) for child in element]
        assert (
            element.tag.startswith(f"{{{NAMESPACE}}}")
            or element.tag == "{http://www.w3.org/1999/xhtml}p"
        )
        assert NEEDED.get(name, set()) <= set(element.attrib)
        if name in ORDER:
            assert inside == sorted(inside, key=ORDER[name].index)


def type_text(element):
    inside = element[0]
    return inside.get("name") if local(inside) == "derived" else local(inside)


def plainly(text):
    """Return a text without comments, in one line."""
    return " ".join(re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL).split())


def in_text(part):
    """Return how Structured Text says what an element of XML stands for."""
    parts = {local(inside): inside for inside in part}
    if local(part) == "variable":
        initial = f" := {parts['initialValue'][0].get('value')}" if "initialValue" in parts else ""
        return f"{part.get('name')} : {type_text(parts['type'])}{initial};"
    if local(part) == "array":
        return f"ARRAY[{part[0].get('lower')}..{part[0].get('upper')}] OF {type_text(part[1])};"
    if local(part) == "pou":
        kind = {"function": "FUNCTION", "functionBlock": "FUNCTION_BLOCK", "program": "PROGRAM"}[
            part.get("pouType")
        ]
        return f"{kind} {part.get('name')}"
    return part.text.strip()


def test_the_xml_contains_the_same_program(project):
    st, root = project
    text = plainly("\n".join(st))
    kinds = ("variable", "array", "pou", "ST/{http://www.w3.org/1999/xhtml}p")
    said = {
        kind: [plainly(in_text(part)) for part in root.iterfind(f".//{{{NAMESPACE}}}{kind}")]
        for kind in kinds
    }
    for kind, parts in said.items():
        assert [part for part in parts if part not in text] == [], kind
    assert len(said["pou"]) == len(re.findall(r"\bEND_(?:FUNCTION|FUNCTION_BLOCK|PROGRAM)\b", text))
    assert len(said["variable"]) == len(
        re.findall(r"\b\w+ : (?!ARRAY|STRUCT|BOOL VAR)[^;]*;", text)
    )


# --- what else it says and refuses ------------------------------------------------------------------------------------


def test_the_head_describes_the_model_and_ends_correctly(tmp_path):
    model = br.friction.lugre(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_0="100 N*m/rad")
    source = Source({"log": "knee (*) run *) 3"}, {"F_S": {"interval": (0.039, 0.041)}})
    st = texts_of(model, tmp_path, "knee", source=source)
    head = next(
        comment for comment in st[0].split("*)") if "SPDX" not in comment and "\n\n" in comment
    )
    assert "F_S" in head
    assert "0.039 to 0.041" in head
    assert "N*m" in head
    assert "x [rad]" in head
    assert "without a division" in head
    assert Translator(*st).units["knee"].kind == "block"
    assert all(len(line) <= 130 for line in st[0].splitlines())


# --- the reader bites -------------------------------------------------------------------------------------------------

FUNCTION = """
TYPE
    Four : ARRAY[0..3] OF LREAL;
    Pair : STRUCT first : LREAL; second : LREAL; END_STRUCT;
END_TYPE
FUNCTION swapped : BOOL
VAR_INPUT factor : LREAL; END_VAR
VAR_IN_OUT given : Pair; given_back : Pair; END_VAR
    given_back.first := given.second * factor;
    given_back.second := given.first;
    swapped := TRUE;
END_FUNCTION
FUNCTION_BLOCK axis_x
VAR_INPUT position : LREAL; period : LREAL; restart : BOOL; clear : BOOL; END_VAR
VAR_OUTPUT force : LREAL; refused : BOOL; overflow : BOOL; END_VAR
VAR here : Pair; there : Pair; four : Four; count : DINT; done : BOOL; END_VAR
    {body}
END_FUNCTION_BLOCK
PROGRAM axis_x_selftest
VAR_OUTPUT done : BOOL; passed : BOOL; END_VAR
    done := TRUE;
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("force := 1;", "a dint for a lreal"),
        ("force := position + 1;", "of a lreal and a dint"),
        ("force := position + REAL#1.0;", "of a lreal and a real"),
        ("force := REAL#1.0;", "a real for a lreal"),
        ("refused := position > 0.0 AND 1;", "of a bool and a dint"),
        ("force := forse;", "is not declared"),
        ("position := 1.0;", "an input is written"),
        ("force := SEL(TRUE, 1.0, 2.0);", "was defined before"),
        (
            "done := swapped(factor := 1.0, given := here, given_back := here);",
            "given back lies in",
        ),
        ("done := swapped(factor := 1.0, given := here);", "swapped takes"),
        ("IF count THEN force := 1.0; END_IF;", "a dint is no condition"),
        ("force := 1.0 +;", "grammar refuses"),
    ],
)
def test_the_reader_refuses_invalid_programs(body, reason):
    with pytest.raises(StandardError, match=reason):
        Translator(FUNCTION.format(body=body))


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("force := 1.0 / (position - position);", "division by zero"),
        ("force := SQRT(-1.0 - position);", "invalid"),
        ("count := 4; refused := (count < 4) AND (four[count] > 0.0);", "outside of an array"),
        ("count := LREAL_TO_DINT(position + 3.0E9);", "out of range"),
        ("WHILE position < 1.0E9 DO force := 1.0; END_WHILE;", "without end"),
        ("count := count / count;", "divided by zero"),
    ],
)
def test_the_reader_stops_at_traps_of_a_controller(body, reason, tmp_path):
    stopping = StructuredText({"axis_x": [FUNCTION.format(body=body)]}, tmp_path)
    with pytest.raises(StandardError, match=reason):
        stopping.run("axis_x", np.zeros(3))


def test_the_reader_follows_the_standard(tmp_path):
    body = """
    count := 7 - 2 - 1;
    here.first := 10.0 - 4.0 - 3.0;
    here.second := 12.0 / 3.0 * 2.0;
    done := swapped(factor := 2.0, given := here, given_back := there);
    force := there.first * 100.0 + there.second * 10.0 + DINT_TO_LREAL(count MOD 3);
    IF NOT done OR (count > 3) AND (count < 3) THEN force := -1.0; END_IF;
    """
    block = StructuredText({"axis_x": [FUNCTION.format(body=body)]}, tmp_path)
    assert block.run("axis_x", np.zeros(1))[0].tolist() == [1631.0]


# --- parts -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [1e300, -1.7976e308, 2.2250738585072014e-308, 5e-324, 1.5, -0.1, 0.0, 1e37, 1e-37, 3e40],
)
def test_a_literal_of_any_magnitude_is_exact_with_small_factors(value):
    text = real_literal(value)
    factors = [float(part) for part in text.strip("()").split(" * ")]
    assert math.prod(factors) == value
    assert all(factor == 0.0 or 1e-37 <= abs(factor) <= 1e37 for factor in factors)
    assert ("*" in text) == (value != 0.0 and not 1e-37 <= abs(value) <= 1e37)


def test_the_largest_number_has_finite_factors_in_single_precision():
    factors = [
        float(np.float32(part))
        for part in real_literal(1.7976931348623157e308).strip("()").split(" * ")
    ]
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


@pytest.mark.parametrize(
    ("name", "new"), [("x", "v_x"), ("limit", "v_limit"), ("a__b_", "a_b"), ("1st", "part_1st")]
)
def test_a_name_becomes_one_that_every_compiler_accepts(name, new):
    assert Names([]).new(name) == new


@pytest.mark.parametrize(
    "name",
    [
        "if",
        "ab",
        "axis_",
        "a__b",
        "limit",
        "integral",
        "ramp",
        "hysteresis",
        "pid",
        "rtc",
        "sema",
        "lag1",
    ],
)
def test_a_block_has_a_name_that_every_compiler_accepts(name):
    with pytest.raises(br.core.InputError, match="cannot name a function block"):
        checked(name)
    checked("axis_x")
    checked("abc")


SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])


def printer(scalar=LREAL):
    return Printer(Unit([]), "axis", (struct_type(SLIP.parameters),), scalar)


def test_each_number_of_an_array_is_an_input_that_counts_from_one():
    tuned = Tuned.of(tunable_of(SLIP), Names(["nu_i_2"]))
    inputs = {variable.name: variable.initial for variable in tuned.inputs(printer())}
    assert inputs == {
        "F_C": "4.0",
        "k_i_1": "100000.0",
        "k_i_2": "200000.0",
        "nu_i_1": "0.25",
        "nu_i_2_2": "0.75",
        "sigma_2": "0.0",
    }
    lines = list(tuned.lines("parameters", struct_type(SLIP.parameters), printer()))
    assert "parameters.nu_i[1] := nu_i_2_2;" in lines
    assert "parameters.F_C := F_C;" in lines


@pytest.mark.parametrize(("scalar", "farthest"), [("LREAL", "1.0E30"), ("REAL", "REAL#1.0E15")])
def test_an_unbounded_input_is_limited_to_finite_numbers(scalar, farthest):
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=0.5)
    of_force, of_offset = Tuned.of(tunable_of(offset), Names()).ranges(
        Printer(Unit([]), "axis", scalar=scalar)
    )
    assert of_force.startswith("(F_C >= ")
    assert of_offset == f"(offset >= -{farthest}) AND (offset <= {farthest})"


def test_a_structure_is_set_number_by_number_except_skipped_paths():
    lines = list(
        set_lines("p", SLIP.parameters, struct_type(SLIP.parameters), printer(), skipped=[("F_C",)])
    )
    assert not any("F_C" in line for line in lines)
    assert [line for line in lines if "nu_i" in line] == [
        "p.nu_i[0] := 0.25;",
        "p.nu_i[1] := 0.75;",
    ]
    truths = br.friction.with_slots(br.friction.lugre, ["asymmetry"])(
        F_C_pos=1.0, F_C_neg=2.0, F_S_pos=1.0, F_S_neg=2.0, v_S=1.0, sigma_0=1e5
    ).parameters
    nested = list(
        set_lines(
            "p", truths, struct_type(truths), Printer(Unit([]), "axis", (struct_type(truths),))
        )
    )
    assert any(
        line.count(".") > 1 and line.startswith("p.") and ":= 2.0;" in line for line in nested
    )


def test_inputs_are_limited_so_that_squares_stay_in_range():
    double, single = (
        {name: float(text or 0.0) for name, text in bounds(single=narrow, farthest=1e5).items()}
        for narrow in (False, True)
    )
    assert double["farthest"] == double["beyond"] == single["beyond"] == 1e30
    assert (single["farthest"], double["fastest"]) == (1e5, 0.0)
    # A velocity over the smallest of Stribeck.
    assert np.isfinite(np.float32(single["fastest"] / 1e-10) ** 2)
    assert [bound["shortest"] * bound["longest"] for bound in (double, single)] == pytest.approx(
        [1.0, 1.0]
    )
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
    assert (facts["tolerance"], facts["count"], facts["last"], facts["every"]) == (
        "0.004",
        51,
        "2.0",
        25,
    )
    assert [float(text) for text in facts["expected"]] == pytest.approx([-4.0, -1.0, 2.0])


WALK = Walk((1.0, 2.0, 3.0), 1e-3)


@pytest.mark.parametrize(
    ("narrow", "arrays", "names", "gave"),
    [
        (
            True,
            [("axis_Scales", 3), ("more", 7), ("axis_Expected", 3)],
            {"worst", "expected"},
            "within the error of single precision",
        ),
        (False, [("axis_Scales", 3), ("more", 7)], {"total", "lost", "added"}, "bit by bit"),
    ],
)
def test_a_self_test_has_the_variables_of_its_precision(narrow, arrays, names, gave):
    judged, other = (
        Judged("axis", np.linspace(-4.0, 2.0, 51), way) for way in (narrow, not narrow)
    )
    assert [
        (part.name, part.size) for part in judged.arrays(WALK, ArrayPart("more", 7, LREAL))
    ] == arrays
    meanings, others = (
        {variable.name: variable.meaning for variable in each.variables()}
        for each in (judged, other)
    )
    assert meanings.keys() - others.keys() == names
    assert meanings["passed"].endswith(gave)


def test_used_types_include_their_inner_types():
    array, inner = ArrayPart("numbers", 3, LREAL), Record("inner", (Variable("a", "numbers"),))
    outer, idle = (
        Record("outer", (Variable("b", "inner"),)),
        Record("idle", (Variable("c", "numbers"),)),
    )
    pou = Pou(
        "FUNCTION", "f", "BOOL", (Variable("x", "outer"),), ("f := TRUE;",), "what (* it does"
    )
    assert used_of([array, inner, outer, idle], [pou]) == [array, inner, outer]
    assert used_of([array, inner, outer, idle], []) == []
    assert part_text(array) == "TYPE\n    numbers : ARRAY[0..2] OF LREAL;\nEND_TYPE\n"
    assert (
        part_text(pou)
        == "(* what ( * it does *)\nFUNCTION f : BOOL\nVAR\n    x : outer;\nEND_VAR\n\nf := TRUE;\nEND_FUNCTION\n"
    )

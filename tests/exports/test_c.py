"""C of friction models: the bits of bristle, whatever the model and its slots, what a drive needs around it, and how it is written."""

import math
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.apps.targets.other_targets import TARGETS, answer, examples
from tests.contract.models import with_fast
from tests.exports.instructions import WORST, counted
from tests.exports.native import (
    ALL,
    COMPILER,
    FLAGS,
    Native,
    built,
    compiled,
    differing,
    example_with,
    selected_cases,
    walk,
)

import bristle as br
from bristle.apps.targets import st_code
from bristle.apps.targets.st_code import is_safe
from bristle.apps.targets.st_parts import Record
from bristle.engine import compilation, force_along, interpreted
from bristle.engine.translation import tree as t
from bristle.engine.translation.scope import NotExportableError, free_name
from bristle.engine.translation.tree import INTEGER, REAL, TRUTH, VOID, Unit, struct_type
from bristle.exports import c_code, subject
from bristle.exports.c import CFiles, builds, write
from bristle.exports.c_code import Names, Printer, number
from bristle.exports.c_parts import (
    array_text,
    constant_text,
    declared,
    helpers_text,
    literal,
    parameters_text,
    saved_facts,
    started,
)
from bristle.exports.described import Request
from bristle.exports.printing import (
    element,
    loops_of,
    needs_wide_integers,
    structures_of,
    types_in,
    wrapped,
)
from bristle.exports.subject import subject_of
from bristle.exports.tunable import tunable_of

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 5e-4
WATCHED = "-fsanitize=address,undefined"


def example(name, slots=()):
    return example_with(name, slots)


@pytest.fixture(scope="module")
def models(request):
    plain = {f"plain_{name}": example(name) for name in ("lugre", "coulomb", "maxwell_slip")}
    varied = {f"varied_{name}": example(name, ALL) for name in ("lugre", "gms", "preisach_lugre")}
    every = (
        {f"sided_{name}": example(name, ("asymmetry",)) for name in br.friction.MODELS}
        | plain
        | varied
    )
    return {name: every[name] for (name,) in selected_cases(request, "model")}


@pytest.fixture(scope="module")
def native(models, tmp_path_factory):
    return Native(models, tmp_path_factory.mktemp("native"), optimise="-O1")


COMPARED = (
    *with_fast("preisach_lugre", form="sided_{}"),
    pytest.param("plain_lugre", marks=pytest.mark.slow),
    "plain_coulomb",
    "plain_maxwell_slip",
    "varied_lugre",
    "varied_gms",
    pytest.param("varied_preisach_lugre", marks=pytest.mark.slow),
)


# The contract of each model compares its C too.
@pytest.mark.parametrize("model", COMPARED)
def test_forces_are_identical_to_bristle(native, models, model):
    x = walk(20_000)
    forces = br.response(models[model], x, DT, rest="held")
    assert np.ptp(forces) > 0.0
    assert differing(native.forces(model, x, DT), forces) == 0


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A model with memory and one without, exported with and without parameters that may be changed."""
    folder = tmp_path_factory.mktemp("written")
    for name, tunable in (("preisach_contact", False), ("gms", True)):
        br.export(example(name, ("asymmetry",)), "c", folder / name, tunable=tunable)
    return folder


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("compiler", [COMPILER, "clang"])
@pytest.mark.parametrize("name", ["preisach_contact", "gms"])
def test_the_self_test_passes_and_the_example_runs(written, name, compiler):
    watched = "-fsanitize=undefined"
    if compiler is None or not builds(compiler):
        pytest.skip(f"needs {compiler or 'a C compiler'}")
    # Some compilers come without the library of it.
    watching = (watched,) if builds(compiler, watched) else ()
    done = built(written / name, "axis_x_selftest.c", *watching, compiler=compiler)
    assert done.returncode == 0, done.stdout
    assert "identical to bristle" in done.stdout
    assert done.stderr == ""
    done = built(written / name, "example_main.c")
    assert done.returncode == 0
    assert len(done.stdout.splitlines()) == 20  # two seconds, ten lines each


BEYOND = """
#include "axis_x.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    axis_x axis;
    axis_x_start(&axis);
    axis_x_force(&axis, 0.0, 1e-3);
    const double before = axis_x_force(&axis, 1e-5, 1e-3);
    const double wrong[3] = {-1.0, 0.0, NAN};
    int held = 0;
    for (int i = 0; i < 3; ++i) {
        axis.parameters.F_S_pos = wrong[i];
        axis.flags = 0;
        held += axis_x_force(&axis, 2e-5 + i * 1e-5, 1e-3) == before && axis.flags == AXIS_X_REFUSED;
    }
    axis.parameters.F_S_pos = 30.0;
    axis.parameters.offset = INFINITY;
    held += axis_x_force(&axis, 2e-5, 1e-3) == before;
    axis.parameters.offset = 0.0;
    axis.flags = 0;
    printf("%d %d\\n", held, axis_x_force(&axis, 2e-5, 1e-3) != before && axis.flags == 0);
    return 0;
}
"""


def ran(folder, text):
    """Return what a program that uses an export says."""
    (folder / "main.c").write_text(text)
    return built(folder, "main.c").stdout


def test_a_parameter_outside_its_range_is_refused_and_the_force_repeated(written):
    assert ran(written / "gms", BEYOND) == "4 1\n"


@pytest.mark.parametrize(
    ("seen", "instead", "said"),
    [
        (r"220\.00000000000003, ", "220.0, ", "results differ"),
        (
            r"axis->state\.lost = after\.lost;",
            "axis->state.lost = after.lost + 1;",
            "continues differently",
        ),
        (r"\|\| got\(bytes \+ last\) != digest\(bytes, last\)", "|| last == 0U", "damaged bytes"),
        (r"!\(velocity - velocity == 0.0\) \|\| ", "", "not a number is accepted"),
    ],
)
def test_the_self_test_detects_faults(written, tmp_path, seen, instead, said):
    folder = tmp_path / "wrong"
    shutil.copytree(written / "preisach_contact", folder)
    text = (folder / "axis_x.c").read_text()
    wrong = re.sub(seen, instead, text)
    if said == "continues differently":
        wrong = wrong.replace("axis->begun = (int32_t)(marks & 1U);", "axis->begun = 0;")
    assert wrong != text
    (folder / "axis_x.c").write_text(wrong)
    done = built(folder, "axis_x_selftest.c")
    assert done.returncode == 1
    assert said in done.stdout


CHANGED = """
#include "axis_x.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    static axis_x axis;
    axis_x_start(&axis);
    axis.parameters.k_i[1] = 2e6;
    axis.parameters.F_S_neg = 26.5;
    for (int i = 0; i < 400; ++i) {
        printf("%.17g\\n", axis_x_force(&axis, 1e-5 * ((i * 37) % 91), 5e-4));
    }
    return 0;
}
"""


def test_parameters_change_at_run_time(written):
    model = example("gms", ("asymmetry",)).with_values(k_i=[6e6, 2e6, 1e6], F_S_neg=26.5)
    x = 1e-5 * ((np.arange(400) * 37) % 91).astype(float)
    assert (
        differing(
            np.array(ran(written / "gms", CHANGED).split(), dtype=float), br.response(model, x, DT)
        )
        == 0
    )


HELD = """
#include "axis_x.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    static axis_x axis;
    const double x[] = {0.0, 1e-5, NAN, INFINITY, 2e-5, 3e-5}, dt[] = {1.0, 1e-3, 1e-3, 1e-3, 1e-3, 0.0};
    axis_x_start(&axis);
    for (int i = 0; i < 6; ++i) {
        const double force = axis_x_force(&axis, x[i], dt[i]);
        printf("%.17g %d\\n", force, (int)axis.flags);
        axis.flags = 0;
    }
    return 0;
}
"""


def test_a_position_that_is_not_a_number_repeats_the_force_and_sets_a_flag(written):
    rows = [line.split() for line in ran(written / "preisach_contact", HELD).splitlines()]
    forces, flags = [float(row[0]) for row in rows], [int(row[1]) for row in rows]
    with interpreted():
        expected = br.response(example("preisach_contact", ("asymmetry",)), [0.0, 1e-5, 2e-5], 1e-3)
    assert flags == [0, 0, 1, 1, 0, 1]
    assert forces == [0.0, expected[1], expected[1], expected[1], expected[2], expected[2]]


def test_the_square_root_is_the_only_library_function(written):
    compiled(written / "gms", "-O1", *FLAGS, "-c", "axis_x.c", "-o", "axis_x.o")
    listed = subprocess.run(
        ["nm", "-u", "axis_x.o"], cwd=written / "gms", capture_output=True, text=True, check=True
    ).stdout
    assert set(listed.split()) - {"U"} <= {"sqrt", "memcpy", "memset", "__stack_chk_fail"}


def test_kernels_are_inlined_as_in_python():
    text = write(Request(example("preisach_lugre"), "axis_x", DT)).files["axis_x.c"]
    assert "\nABSORBED double mathematics_decay(" in text
    assert "\nstatic inline Stroke deflection_in_parts(" in text


def test_the_header_describes_each_parameter(tmp_path):
    model = br.friction.lugre(F_C="34 mN*m", F_S="40 mN*m", v_S="0.5 rad/s", sigma_0="100 N*m/rad")
    result = br.export(model, "c", tmp_path / "axis", name="knee", step="1 ms")
    assert result.files[:3] == ("knee.h", "knee.c", "knee_selftest.c")
    header = (tmp_path / "axis" / "knee.h").read_text()
    assert re.search(r"F_S +0\.04 +N\*m +>= 1e-12 +static", header)
    # Apart, for the time of a step.
    assert re.search(r"double position;.*\n.*begun;.*\n.*double force;", header)
    assert "[rad]" in header
    assert "[N*m]" in header
    assert all(len(line) <= 130 for line in header.splitlines())


FORGED = """
#include "axis_x.h"
#include <stdio.h>
int main(void)
{
    static axis_x axis;
    static unsigned char bytes[AXIS_X_SAVED];
    uint32_t seed = 1U;
    int taken = 0;
    axis_x_start(&axis);
    axis_x_save(&axis, bytes);
    for (int round = 0; round < 2000; ++round) {
        for (int i = 0; i < 3; ++i) {
            seed = seed * 1664525U + 1013904223U;
            const unsigned at = 8U + (seed >> 8U) % (i == 0 ? 64U : AXIS_X_SAVED - 16U);
            bytes[at] = (unsigned char)(seed >> 24U);
        }
        if (round % 3 == 0) { /* a small whole number, as of turning points that the memory has no room for */
            const unsigned at = 24U + 8U * ((seed >> 8U) % 8U);
            bytes[at] = (unsigned char)(seed >> 24U);
            bytes[at + 1U] = (unsigned char)((seed >> 16U) % 4U);
            for (unsigned i = 2; i < 8U; ++i) {
                bytes[at + i] = 0U;
            }
        }
        uint64_t digest = 0xCBF29CE484222325U;
        for (size_t i = 0; i + 8U < sizeof bytes; ++i) {
            digest = (digest ^ bytes[i]) * 0x100000001B3U;
        }
        for (unsigned i = 0; i < 8U; ++i) {
            bytes[sizeof bytes - 8U + i] = (unsigned char)(digest >> (8U * i));
        }
        if (axis_x_load(&axis, bytes, sizeof bytes)) {
            ++taken;
            for (int k = 0; k < 20; ++k) {
                (void)axis_x_force(&axis, 1e-5 * ((k * 37) % 91), 5e-4);
            }
        } else {
            axis_x_start(&axis);
            axis_x_save(&axis, bytes);
        }
    }
    printf("%d\\n", taken);
    return 0;
}
"""


@pytest.mark.slow
@pytest.mark.skipif(
    not builds(str(COMPILER), WATCHED), reason="needs a compiler with its sanitizers"
)
def test_no_saved_bytes_cause_access_outside_the_memory(written):
    (written / "preisach_contact" / "forged.c").write_text(FORGED)
    done = built(written / "preisach_contact", "forged.c", WATCHED, "-fno-sanitize-recover")
    assert done.returncode == 0, done.stderr[:2000]
    assert 100 < int(done.stdout) < 1900


def test_an_export_neither_compiles_nor_loads_a_compiler(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(compilation, "_compile", lambda *_: pytest.fail("compiles"))
    br.export(br.friction.coulomb(F_C=2.0), "c", tmp_path / "out")


SINGLE = {
    "lugre": ALL,
    "maxwell_stribeck": ("asymmetry",),
    "preisach_contact": ("asymmetry",),
    "elastoplastic": (),
}


@pytest.fixture(scope="module")
def singles(tmp_path_factory):
    return Native(
        {name: example(name, slots) for name, slots in SINGLE.items()},
        tmp_path_factory.mktemp("single"),
        float32=True,
    )


@pytest.mark.parametrize("name", SINGLE)
def test_single_precision_error_is_near_its_rounding(singles, name):
    x = np.cumsum(
        np.repeat([1e-7, -2e-6, 3e-5, -3e-5], 100) * np.tile([1.0, 0.5, -1.25, 0.75], 100)
    )
    with interpreted():
        expected = br.response(example(name, SINGLE[name]), x, DT)
    off = np.max(np.abs(singles.forces(name, x, DT) - expected)) / np.max(np.abs(expected))
    assert 0.0 < off < 2e-5


def test_the_single_precision_self_test_prints_its_deviation(tmp_path):
    result = br.export(example("gms", ("asymmetry",)), "c", tmp_path / "gms", float32=True)
    assert any("single precision" in note for note in result.notes)
    done = built(tmp_path / "gms", "axis_x_selftest.c")
    assert done.returncode == 0, done.stdout
    text = (tmp_path / "gms" / "axis_x.c").read_text()
    assert (
        "double"
        not in text[text.index("typedef struct") : text.index("static inline bool is_finite")]
    )
    (tmp_path / "gms" / "axis_x.c").write_text(text.replace("6000000.0f", "6600000.0f"))
    assert built(tmp_path / "gms", "axis_x_selftest.c").returncode == 1


AT = """
#include "axis_x.h"
#include <stdio.h>
int main(void)
{
    static axis_x axis;
    axis_x_start(&axis);
    for (int i = 0; i < 40; ++i) {
        printf("%.17g\\n", axis_x_force_at(&axis, 1e-5 * ((i * 37) % 91), 5e-4, 1.0 + 0.01 * i, 300.0 + i));
    }
    return 0;
}
"""


def test_load_and_temperature_are_inputs_if_friction_depends_on_them(tmp_path):
    model = example("lugre", ("load", "temperature"))
    br.export(model, "c", tmp_path / "out")
    forces = np.array(ran(tmp_path / "out", AT).split(), dtype=float)
    i = np.arange(40)
    x = 1e-5 * ((i * 37) % 91)
    with interpreted():
        expected = force_along(
            model,
            np.diff(x) / DT,
            DT,
            x[1:],
            load=1.0 + 0.01 * i[1:],
            temperature=300.0 + i[1:].astype(float),
        )
    assert differing(forces[1:], expected) == 0


# --- other targets, in emulators of them; `tests.apps.targets.other_targets` tries every model ----------------------------


@pytest.mark.parametrize(
    ("core", "name", "mean", "code"),
    [
        ("Cortex-M7", "lugre", 250, 2500),
        ("Cortex-M7", "preisach_lugre", 1300, 18000),
        ("Cortex-M7", "preisach_contact", 1100, 4500),
        ("Cortex-M4F", "preisach_lugre", 1600, 16000),
        ("Cortex-M4F", "elastoplastic", 2200, 6000),
    ],
)
def test_a_step_fits_the_instruction_budget_of_a_drive(core, name, mean, code, tmp_path):
    if TARGETS[core].lacking:
        pytest.skip(f"needs {TARGETS[core].lacking}")
    result = counted(example_with(name), core, tmp_path / "out", steps=20_000)
    assert result.mean < mean
    stated = re.search(
        r"took (\d+) instructions in the median and at most (\d+)",
        (tmp_path / "out" / "axis_x.h").read_text(),
    )
    assert result.worst <= 1.05 * int(stated[2]) <= 1.05 * WORST * int(stated[1])
    assert result.code < code
    assert result.stack <= 1024


def test_different_bits_are_reported(monkeypatch, tmp_path):
    target = TARGETS["clang"]._replace(build=("cc",))
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler")
    monkeypatch.setattr(subject, "FNV_PRIME", subject.FNV_PRIME + 2)
    text = answer(target, examples()["plain lugre"], Path(tmp_path) / "out")
    assert "expected" in text


# --- how it is written -----------------------------------------------------------------------------------------------


class Pair(NamedTuple):
    first: float
    second: float


class Inner(NamedTuple):
    a: float


PAIR, NOTHING = t.Struct(Pair, (("first", REAL), ("second", REAL))), t.Struct(Inner, ())
A, B, C = (t.Variable(REAL, name) for name in ("alpha", "beta", "gamma"))
N, K = (t.Variable(INTEGER, name) for name in ("place", "count"))
P, Q = (t.Variable(TRUTH, name) for name in ("open", "closed"))
PARTS, MEMORY = t.Variable(PAIR, "parts"), t.Variable(t.Array(4, writable=True), "memory")
ONE, THREE = t.Constant(REAL, 1.0), t.Constant(INTEGER, 3)


def binary(operator, left, right):
    return t.Binary(left.type, operator, left, right)


def less(left, right, operator="<"):
    return t.Compare(TRUTH, operator, left, right)


def function_of(*body, parameters=(), result: t.Type = REAL, name="value", description=""):
    return t.Function(name, print, list(parameters), result, list(body), description)


G, MADE = (
    function_of(parameters=[A, MEMORY], name="inner"),
    function_of(parameters=[A], result=PAIR, name="made"),
)
DIVIDED = less(binary("/", A, B), C)


def in_c(*statements, parameters=(), scalar="double"):
    """Return the body of a function in C in one line."""
    function = function_of(*statements, parameters=parameters)
    lines = c_code.Body(
        c_code.Printer(t.Unit([function]), scalar, [PAIR, NOTHING]), function
    ).lines()
    return " ".join(line.strip() for line in lines)


def in_st(*statements, parameters=(), result: t.Type = REAL, scalar="LREAL"):
    """Return the body of a function in Structured Text in one line."""
    function = function_of(*statements, parameters=parameters, result=result)
    pou = st_code.Body(st_code.Printer(t.Unit([function]), "axis", (PAIR,), scalar), function).pou()
    return " ".join(line.strip() for line in pou.body)


@pytest.mark.parametrize(
    ("expression", "c", "st"),
    [
        (binary("-", A, binary("-", B, C)), "alpha - (beta - gamma)", ""),
        # What was rounded before stands in brackets in Structured Text.
        (binary("-", binary("+", A, B), C), "alpha + beta - gamma", "(alpha + beta) - gamma"),
        (binary("-", binary("-", A, B), C), "alpha - beta - gamma", ""),
        (binary("-", binary("+", N, K), K), "place + count - count", ""),
        (binary("+", binary("*", A, B), C), "alpha * beta + gamma", ""),
        (binary("*", binary("+", A, B), C), "(alpha + beta) * gamma", ""),
        (binary("/", A, binary("*", B, C)), "alpha / (beta * gamma)", ""),
        (t.Negative(REAL, t.Negative(REAL, A)), "-(-alpha)", ""),
        (t.Negative(REAL, binary("*", A, B)), "-(alpha * beta)", ""),
        (binary("*", t.Negative(REAL, A), B), "-alpha * beta", "(-alpha) * beta"),
        (binary("+", A, t.Constant(REAL, -2.0)), "alpha + -2.0", "alpha + (-2.0)"),
        (t.Negative(REAL, t.Constant(REAL, -2.0)), "-(-2.0)", ""),
        (binary(">>", N, THREE), "place >> 3", "axis_floor_divided(first := place, second := 8)"),
        (
            binary("+", binary(">>", N, THREE), K),
            "(place >> 3) + count",
            "axis_floor_divided(first := place, second := 8) + count",
        ),
        (
            binary("&", binary("+", N, K), K),
            "(place + count) & count",
            "LWORD_TO_LINT(LINT_TO_LWORD(place + count) AND LINT_TO_LWORD(count))",
        ),
        (
            binary("^", N, K),
            "place ^ count",
            "LWORD_TO_LINT(LINT_TO_LWORD(place) XOR LINT_TO_LWORD(count))",
        ),
        (
            binary("//", N, K),
            "floor_divided(place, count)",
            "axis_floor_divided(first := place, second := count)",
        ),
        (
            binary("%", N, K),
            "floor_rest(place, count)",
            "axis_floor_rest(first := place, second := count)",
        ),
        (less(binary("-", A, B), binary("*", A, B)), "alpha - beta < alpha * beta", ""),
        (less(A, B, "=="), "alpha == beta", "alpha = beta"),
        (less(A, B, "!="), "alpha != beta", "alpha <> beta"),
        (t.Not(TRUTH, less(A, B)), "!(alpha < beta)", "NOT (alpha < beta)"),
        (t.Not(TRUTH, t.Not(TRUTH, P)), "!!open", "NOT (NOT open)"),
        (t.Logic(TRUTH, "and", [P, less(A, B)]), "open && alpha < beta", "open AND (alpha < beta)"),
        (
            t.Logic(TRUTH, "or", [t.Not(TRUTH, P), t.Logic(TRUTH, "and", [P, Q])]),
            "!open || (open && closed)",
            "NOT open OR (open AND closed)",
        ),
        (
            t.Convert(REAL, binary("+", N, K)),
            "(double)(place + count)",
            "DINT_TO_LREAL(place + count)",
        ),
        (
            t.Convert(INTEGER, t.Negative(REAL, A)),
            "(int32_t)-alpha",
            "axis_truncated(number := -alpha)",
        ),
        (t.Index(REAL, MEMORY, binary("+", N, K)), "memory[place + count]", ""),
        (t.Field(REAL, PARTS, "second"), "parts.second", ""),
        (
            t.Intrinsic(REAL, "sqrt", [binary("+", A, B)]),
            "root(alpha + beta)",
            "SQRT(alpha + beta)",
        ),
        (
            t.Intrinsic(REAL, "min", [A, B]),
            "least(alpha, beta)",
            "axis_min(first := alpha, second := beta)",
        ),
        (
            t.Intrinsic(INTEGER, "min", [N, K]),
            "whole_least(place, count)",
            "axis_whole_min(first := place, second := count)",
        ),
        (
            t.Call(REAL, G, [binary("-", A, B), MEMORY]),
            "inner(alpha - beta, memory)",
            "axis_inner(alpha := alpha - beta, memory := memory)",
        ),
        (t.Constant(TRUTH, True), "true", "TRUE"),
        (t.Constant(TRUTH, False), "false", "FALSE"),
        (t.Constant(INTEGER, 2**31 - 1), "2147483647", ""),
        (t.Constant(INTEGER, -(2**31)), "INT64_C(-2147483648)", "LINT#-2147483648"),
        (t.Make(NOTHING, []), "(Inner){0}", None),
    ],
)
def test_brackets_appear_where_precedence_requires_them(expression, c, st):
    assert in_c(t.Return(expression)) == f"return {c};"
    assert (
        st is None
        or in_st(t.Return(expression), result=expression.type) == f"axis_value := {st or c};"
    )


CHOSEN = binary("*", t.Select(REAL, P, A, t.Select(REAL, Q, B, C)), C)
SWAPPED = t.Make(PAIR, [t.Field(REAL, PARTS, "second"), t.Field(REAL, PARTS, "first")])


def test_a_choice_and_a_tuple_are_expressions_in_c():
    assert in_c(t.Return(CHOSEN)) == "return (open ? alpha : (closed ? beta : gamma)) * gamma;"
    assert (
        in_c(t.Return(t.Field(REAL, SWAPPED, "first")))
        == "return (Pair){parts.second, parts.first}.first;"
    )


STEP = t.Assign(A, B)


@pytest.mark.parametrize(
    ("statement", "c", "st"),
    [
        (
            t.For(N, t.Constant(INTEGER, 0), THREE, [t.Store(MEMORY, N, A), t.Continue()]),
            "for (int32_t place = 0; place < 3; ++place) { memory[place] = alpha; continue; }",
            "place := -1; WHILE place < 2 DO place := place + 1; memory[place] := alpha; CONTINUE; END_WHILE;",
        ),
        (
            t.For(t.Variable(INTEGER, "_"), N, binary("+", N, K), [t.Break()]),
            "for (int32_t round_1 = place; round_1 < place + count; ++round_1) { break; }",
            "aside_2 := place + count - 1; aside_1 := place - 1; WHILE aside_1 < aside_2 DO aside_1 := aside_1 + 1; EXIT; END_WHILE;",
        ),
        (
            t.While(less(A, B), [t.Assign(C, B)]),
            "while (alpha < beta) { gamma = beta; }",
            "WHILE alpha < beta DO gamma := beta; END_WHILE;",
        ),
        (
            t.While(DIVIDED, [t.Break()]),
            "while (alpha / beta < gamma) { break; }",
            "WHILE TRUE DO IF NOT (alpha / beta < gamma) THEN EXIT; END_IF; EXIT; END_WHILE;",
        ),
        (
            t.If(P, [], [STEP]),
            "if (!open) { alpha = beta; }",
            "IF NOT open THEN alpha := beta; END_IF;",
        ),
        (
            t.If(P, [STEP], [t.If(Q, [STEP], [STEP])]),
            "if (open) { alpha = beta; } else { if (closed) { alpha = beta; } else { alpha = beta; } }",
            "IF open THEN alpha := beta; ELSIF closed THEN alpha := beta; ELSE alpha := beta; END_IF;",
        ),
        (
            t.If(P, [STEP], [t.If(Q, [], [STEP])]),
            "if (open) { alpha = beta; } else { if (!closed) { alpha = beta; } }",
            "IF open THEN alpha := beta; ELSE IF NOT closed THEN alpha := beta; END_IF; END_IF;",
        ),
        (
            t.If(P, [STEP], [t.If(DIVIDED, [STEP], [])]),
            "if (open) { alpha = beta; } else { if (alpha / beta < gamma) { alpha = beta; } }",
            "IF open THEN alpha := beta; ELSE IF alpha / beta < gamma THEN alpha := beta; END_IF; END_IF;",
        ),
        (
            t.If(P, [t.Return(A)], [t.Evaluate(t.Call(REAL, G, [A, MEMORY]))]),
            "if (open) { return alpha; } else { (void)inner(alpha, memory); }",
            "IF open THEN axis_value := alpha; RETURN; ELSE aside_1 := axis_inner(alpha := alpha, memory := memory); END_IF;",
        ),
    ],
)
def test_statements_are_printed_in_their_blocks(statement, c, st):
    assert in_c(statement, parameters=[A, B, C, P, Q]).startswith(c)
    # An argument that takes another value is copied first.
    assert in_st(statement, parameters=[B, P, Q]) == st


COPYING = function_of(STEP, parameters=[A, B], name="inner")
WIDE = binary("//", binary(">>", N, THREE), K)
EIGHTH = (
    "axis_floor_divided(first := axis_floor_divided(first := place, second := 8), second := count)"
)


@pytest.mark.parametrize(
    ("statements", "options", "text"),
    [
        # A choice is a statement.
        (
            [t.Return(CHOSEN)],
            {},
            "IF open THEN aside_1 := alpha; ELSIF closed THEN aside_1 := beta; ELSE aside_1 := gamma; END_IF; "
            "axis_value := aside_1 * gamma;",
        ),
        (
            [t.Assign(A, t.Select(REAL, P, A, t.Select(REAL, DIVIDED, B, C)))],
            {},
            "IF open THEN alpha := alpha; ELSE IF alpha / beta < gamma THEN alpha := beta; ELSE alpha := gamma; END_IF; END_IF;",
        ),
        (
            [t.Return(t.Convert(REAL, P))],
            {},
            "IF open THEN aside_1 := 1.0; ELSE aside_1 := 0.0; END_IF; axis_value := aside_1;",
        ),
        (
            [t.Return(t.Convert(INTEGER, P))],
            {"result": INTEGER},
            "IF open THEN aside_1 := 1; ELSE aside_1 := 0; END_IF; axis_value := aside_1;",
        ),
        # A tuple is written in place unless it reads itself.
        (
            [t.Assign(PARTS, t.Make(PAIR, [A, B]))],
            {},
            "parts.first := alpha; parts.second := beta;",
        ),
        (
            [t.Assign(PARTS, SWAPPED)],
            {},
            "aside_1.first := parts.second; aside_1.second := parts.first; parts := aside_1;",
        ),
        (
            [t.Assign(PARTS, t.Call(PAIR, MADE, [A]))],
            {},
            "aside_1 := axis_made(alpha := alpha, given_back := parts);",
        ),
        (
            [t.Return(t.Field(REAL, t.Call(PAIR, MADE, [A]), "first"))],
            {},
            "aside_2 := axis_made(alpha := alpha, given_back := aside_1); axis_value := aside_1.first;",
        ),
        (
            [t.Return(t.Make(PAIR, [A, B]))],
            {"result": PAIR},
            "axis_value := TRUE; given_back.first := alpha; given_back.second := beta;",
        ),
        # Conditions that may trap are short-circuited.
        (
            [t.Return(t.Logic(TRUTH, "and", [P, DIVIDED, Q]))],
            {"result": TRUTH},
            "aside_1 := open; IF aside_1 THEN aside_1 := alpha / beta < gamma; "
            "IF aside_1 THEN aside_1 := closed; END_IF; END_IF; axis_value := aside_1;",
        ),
        (
            [t.Return(t.Logic(TRUTH, "or", [P, DIVIDED, Q]))],
            {"result": TRUTH},
            "aside_1 := open; IF NOT aside_1 THEN aside_1 := alpha / beta < gamma; "
            "IF NOT aside_1 THEN aside_1 := closed; END_IF; END_IF; axis_value := aside_1;",
        ),
        (
            [t.Return(t.Logic(TRUTH, "or", [DIVIDED, P]))],
            {"result": TRUTH},
            "axis_value := (alpha / beta < gamma) OR open;",
        ),
        # An argument that is assigned is copied.
        (
            [STEP, t.Return(A)],
            {"parameters": [A, B]},
            "alpha := alpha_given; alpha := beta; axis_value := alpha;",
        ),
        (
            [t.Return(t.Call(REAL, COPYING, [C, ONE]))],
            {},
            "axis_value := axis_inner(alpha_given := gamma, beta := 1.0);",
        ),
        ([t.Return(None)], {"result": VOID}, "axis_value := TRUE;"),
        # Indices stay of 32 bits beside wide integers.
        (
            [t.Return(t.Index(REAL, MEMORY, WIDE))],
            {},
            f"axis_value := memory[LINT_TO_DINT({EIGHTH})];",
        ),
        (
            [t.Return(t.Index(REAL, MEMORY, THREE)), t.Return(WIDE)],
            {},
            f"axis_value := memory[3]; RETURN; axis_value := {EIGHTH};",
        ),
        (
            [t.Return(t.Intrinsic(REAL, "min", [A, B]))],
            {"scalar": "REAL"},
            "axis_value := axis_single_min(first := alpha, second := beta);",
        ),
    ],
)
def test_what_is_no_expression_of_structured_text_is_a_statement(statements, options, text):
    assert in_st(*statements, **options) == text


def test_a_shift_by_a_variable_number_is_refused():
    with pytest.raises(NotExportableError, match="a shift by a variable number is not exportable"):
        in_st(t.Return(binary(">>", N, K)))


@pytest.mark.parametrize(
    ("statements", "text"),
    [
        (
            [t.Assign(A, ONE), t.Assign(A, binary("+", A, ONE)), t.Return(A)],
            "double alpha = 1.0; alpha = alpha + 1.0; return alpha;",
        ),
        (
            [t.Assign(C, ONE), t.If(P, [STEP, t.Assign(C, A)], [])],
            "double gamma = 1.0; if (open) { double alpha = beta; gamma = alpha; }",
        ),
        # Looked at elsewhere it is zero first.
        ([t.If(P, [STEP], []), t.Return(A)], "double alpha = 0.0; if"),
        ([t.If(P, [STEP], [STEP])], "double alpha = 0.0; if"),
        ([t.While(less(A, B), [STEP])], "double alpha = 0.0; while"),
        ([t.For(K, t.Constant(INTEGER, 0), N, [t.Assign(N, K)])], "int32_t place = 0; for"),
        ([t.If(P, [t.Assign(N, N)], [])], "int32_t place = 0; if"),
        ([t.If(P, [t.Assign(Q, P)], []), t.Return(Q)], "bool closed = false; if"),
        ([t.If(P, [t.Assign(PARTS, PARTS)], [])], "Pair parts = {0}; if"),
    ],
)
def test_a_variable_is_declared_with_its_first_value_if_that_precedes_all_uses(statements, text):
    assert in_c(*statements, parameters=[P, B]).startswith(text)


@pytest.mark.parametrize(
    ("value", "double", "single"),
    [
        (-2.0, "-2.0", "-2.0f"),
        (math.inf, "(double)INFINITY", "(float)INFINITY"),
        (-math.inf, "-(double)INFINITY", "-(float)INFINITY"),
    ],
)
def test_a_number_is_written_exactly(value, double, single):
    assert (number(value), number(value, "float"), number(math.nan)) == (
        double,
        single,
        "(double)NAN",
    )


def test_a_unit_has_structures_and_functions_with_descriptions():
    table = t.Variable(t.Array(2), "table")
    plain, described = (
        function_of(t.Return(ONE), name="g"),
        function_of(t.Return(PARTS), parameters=[PARTS, table, MEMORY], result=PAIR),
    )
    described.description = "Return `parts`."
    text = (
        c_code.Printer(t.Unit([plain, described]), "float", [NOTHING])
        .definitions()
        .partition("#endif\n")[2]
    )
    assert text == (
        "\ntypedef struct {\n    float first;\n    float second;\n} Pair;\n\ntypedef struct {\n    char nothing;\n} Inner;\n"
        "\nstatic inline float g(void)\n{\n    return 1.0f;\n}\n"
        "\n/* Return parts. */\nstatic inline Pair value(Pair parts, const float *table, float *memory)\n{\n    return parts;\n}\n"
    )
    types, (_, pou) = st_code.Printer(
        t.Unit([plain, described]), "axis", (NOTHING, t.Array(0))
    ).parts()
    assert [(part.name, getattr(part, "size", None)) for part in types[:3]] == [
        ("axis_Numbers_0", 1),
        ("axis_Numbers_2", 2),
        ("axis_Numbers_4", 4),
    ]
    records = [part for part in types if isinstance(part, Record)]
    assert [[(field.name, field.type) for field in part.fields] for part in records] == [
        [("first", "LREAL"), ("second", "LREAL")],
        [("nothing", "BOOL")],
    ]
    assert (pou.kind, pou.returns, {variable.section for variable in pou.variables}) == (
        "FUNCTION",
        "BOOL",
        {"VAR_IN_OUT"},
    )


def test_names_in_c_are_distinct_and_not_keywords():
    twin, of_user = (
        type("Pair", (tuple,), {"_fields": (), "__module__": name})
        for name in ("bristle.models.friction.slip_law", "bristle_user_2")
    )
    kinds = [
        PAIR,
        *(t.Struct(cls, ()) for cls in (twin, of_user, tuple)),
        t.Struct(tuple, (("_0", REAL),)),
    ]
    assert list(Names(kinds).structures.values()) == [
        "TestCPair",
        "SlipLawPair",
        "OwnPair",
        "Several",
        "Several_2",
    ]
    assert list(Names([PAIR], ["Pair"]).structures.values()) == ["Pair_2"]
    names = ("int", "int_", "x", "_0", "root", "g", "DBL_MAX")
    assert [Names([], ["g"]).variable(name) for name in names] == [
        "int_",
        "int__",
        "x",
        "part_0",
        "root_",
        "g_",
        "DBL_MAX_",
    ]


@pytest.mark.parametrize(
    ("expression", "safe"),
    [
        (less(binary("*", A, B), binary("-", A, t.Negative(REAL, B))), True),
        (less(t.Intrinsic(REAL, "abs", [A]), t.Field(REAL, PARTS, "first")), True),
        (DIVIDED, False),
        (less(binary("//", N, K), K), False),
        (less(t.Intrinsic(REAL, "sqrt", [A]), B), False),
        (less(t.Index(REAL, MEMORY, N), A), False),
        (less(t.Call(REAL, G, [A, MEMORY]), A), False),
        (less(t.Select(REAL, P, A, B), A), False),
        (less(t.Convert(REAL, N), A), False),
    ],
)
def test_expressions_that_may_trap_or_need_a_statement_are_unsafe(expression, safe):
    assert is_safe(expression) is safe


def test_minus_zero_is_just_below_zero():
    printer = st_code.Printer(t.Unit([]), "axis")
    assert printer.real(0.0) == "0.0"
    assert (
        -1e-30
        < math.prod(float(part) for part in printer.real(-0.0).strip("()").split(" * "))
        < 0.0
    )


@pytest.mark.parametrize(
    ("scalar", "texts"),
    [
        ("LREAL", ["x", "x", "axis_Numbers_3", "axis_Numbers_3"]),
        ("REAL", ["LREAL_TO_REAL(x)", "REAL_TO_LREAL(x)", "axis_Singles_3", "axis_Numbers_3"]),
    ],
)
def test_numbers_convert_to_single_precision(scalar, texts):
    printer = st_code.Printer(t.Unit([]), "axis", scalar=scalar)
    assert [
        printer.narrowed("x"),
        printer.widened("x"),
        printer.array(3),
        printer.array(3, "LREAL"),
    ] == texts


SPEED, COUNT = t.Variable(REAL, "x"), t.Variable(INTEGER, "n")


def whole(value):
    return t.Constant(INTEGER, value)


def void_of(*body, parameters=(SPEED, COUNT), result=VOID, name="f", description=""):
    return t.Function(name, print, list(parameters), result, list(body), description)


def test_integers_beyond_31_bits_and_bitwise_operations_are_64_bit():
    narrow = [
        whole(2**31 - 1),
        whole(1 - 2**31),
        t.Constant(REAL, 1e12),
        *(t.Binary(INTEGER, operator, COUNT, COUNT) for operator in "+%"),
    ]
    wide = [
        whole(2**31),
        whole(-(2**31)),
        *(t.Binary(INTEGER, operator, COUNT, COUNT) for operator in ("&", "^", ">>")),
    ]
    outcome = [
        [needs_wide_integers(t.Unit([void_of(), void_of(t.Return(e))])) for e in group]
        for group in (narrow, wide)
    ]
    assert outcome == [[False] * 5, [True] * 5]


class Held(NamedTuple):
    a: float


class Holder(NamedTuple):
    inner: Held
    b: float


def test_a_tuple_is_listed_once_after_its_inner_tuples():
    inner = t.Struct(Held, (("a", REAL),))
    outer = t.Struct(Holder, (("inner", inner), ("b", REAL)))
    assert structures_of([REAL, outer, inner, t.Array(3), outer]) == [inner, outer]
    assert structures_of([inner, outer]) == [inner, outer]
    assert structures_of([REAL, t.Array(2)]) == []


def test_types_of_a_function_include_result_arguments_and_body():
    kinds = types_in(
        void_of(
            t.Return(t.Compare(TRUTH, "<", SPEED, t.Constant(REAL, 0.0))),
            parameters=[COUNT],
            result=TRUTH,
        )
    )
    assert kinds == [TRUTH, INTEGER, TRUTH, REAL, REAL]


@pytest.mark.parametrize(
    ("line", "lines"),
    [
        ("x" * 110, ["x" * 110]),
        ("a" * 50 + ", " + "b" * 58, ["a" * 50 + ", " + "b" * 58]),
        ("a" * 50 + ", " + "b" * 59, ["a" * 50 + ",", "        " + "b" * 59]),
        ("a" * 50 + " + " + "b" * 60, ["a" * 50, "        + " + "b" * 60]),
        (
            "a" * 50 + ", " + "b" * 20 + " ? " + "c" * 60,
            ["a" * 50 + ", " + "b" * 20, "        ? " + "c" * 60],
        ),
        # In the first forty letters no line ends.
        ("a" * 30 + ", " + "b" * 90, ["a" * 30 + ", " + "b" * 90]),
    ],
)
def test_a_line_of_more_than_110_letters_breaks_after_a_comma_or_before_an_operator(line, lines):
    assert wrapped(line, "") == lines


@pytest.mark.parametrize(
    ("used", "free"), [({"g"}, "f"), ({"f"}, "f_2"), ({"f", "f_2", "f_4"}, "f_3")]
)
def test_a_used_name_gets_the_first_free_number_from_two(used, free):
    assert free_name("f", used) == free


def test_an_element_contains_text_and_then_further_elements():
    made = element("a", "text", element("b"), " more", element("c", name="d"), size="3")
    assert (made.tag, made.text, made.attrib) == ("a", "text more", {"size": "3"})
    assert [(inner.tag, inner.attrib) for inner in made] == [("b", {}), ("c", {"name": "d"})]


def test_rounds_of_bounded_loops_are_counted():
    counted = t.For(COUNT, whole(2), whole(7), [t.Assign(SPEED, SPEED)])
    open_end, open_start = t.For(COUNT, whole(0), COUNT, []), t.For(COUNT, COUNT, whole(7), [])
    until = t.While(t.Compare(TRUTH, "<", SPEED, SPEED), [counted])
    unit = t.Unit(
        [
            void_of(name="none"),
            void_of(until, open_end, open_start, name="many", description="of `x`"),
        ]
    )
    assert loops_of(unit, 21) == [
        {
            "function": "many",
            "description": "of x",
            "most": "3, which halve the stored turning points",
        },
        {"function": "many", "description": "of x", "most": "5"},
        {"function": "many", "description": "of x", "most": "the number in its argument"},
        {"function": "many", "description": "of x", "most": "the number in its argument"},
    ]


SLIP = br.friction.maxwell_slip(F_C=4.0, nu_i=[0.25, 0.75], k_i=[1e5, 2e5])
KIND = struct_type(SLIP.parameters)


def printer(scalar="double"):
    return Printer(Unit([]), scalar, [KIND])


def test_only_used_helpers_and_bit_unions_are_written():
    assert helpers_text(["min"], "double", "int32_t") == (
        "static inline double least(double a, double b)\n{\n    return b < a ? b : a;\n}\n"
    )
    for name in ("copysign", "abs", "power_of_two", "mantissa", "exponent"):
        assert helpers_text([name], "float", "int32_t").startswith(
            "typedef union {\n    float number;\n    uint32_t bits;\n} Bits;\n"
        )
    assert "uint64_t bits" in helpers_text(["abs"], "double", "int32_t")
    assert "int64_t next_below(float x)" in helpers_text(["floor"], "float", "int64_t")
    assert helpers_text([], "double", "int32_t") == ""


def test_masks_and_shifts_follow_from_the_format():
    for scalar, kind, bits in (("double", np.float64, np.uint64), ("float", np.float32, np.uint32)):
        text, info = (
            helpers_text(["power_of_two", "mantissa", "exponent", "copysign"], scalar, "int32_t"),
            np.finfo(kind),
        )
        masks = {int(mask, 16) for mask in re.findall(r"_C\((0x[0-9A-F]+)\)", text)}
        (place,) = re.findall(r"\{k \+ ([0-9.]+)", text)
        # The sign, the fraction, the bits of 1, and those of the number whose last place is 1; k and the bias beside it.
        rounder = kind(1.5 * 2.0**info.nmant)
        assert masks == {
            1 << (info.bits - 1),
            (1 << info.nmant) - 1,
            int(kind(1.0).view(bits)),
            int(rounder.view(bits)),
        }
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
    assert (
        array_text("table", np.zeros(0), printer()) == "static const double table[1] = {\n    0\n};"
    )
    assert (
        literal(2.0, INTEGER, "double"),
        literal(2, REAL, "float"),
        literal(True, INTEGER, "float"),
    ) == ("2", "2.0f", "1")


def test_variable_parameters_are_checked_against_their_ranges():
    offset = br.friction.with_slots(br.friction.coulomb, [])(F_C=1.0, offset=-0.5)
    tuned = tunable_of(offset)
    text = parameters_text(
        offset.parameters,
        struct_type(offset.parameters),
        Printer(Unit([]), "float", [struct_type(offset.parameters)]),
        "axis",
        tuned,
    )
    assert "bool within_ranges(const axis_parameters *given)" in text
    assert "given->offset >= -FLT_MAX && given->offset <= FLT_MAX" in text
    low = offset.component.variables["F_C"].min
    assert f"given->F_C >= {low!r}f" in text
    assert "given->F_C <=" not in text
    assert [line.partition(";")[0] for line in declared(tunable_of(SLIP), printer())][:2] == [
        "double F_C",
        "double k_i[2]",
    ]
    assert started(tunable_of(SLIP), printer())[1:3] == [
        "axis->parameters.k_i[0] = 100000.0;",
        "axis->parameters.k_i[1] = 200000.0;",
    ]


@pytest.mark.parametrize(
    ("scalar", "widened", "narrowed"), [("double", "", ""), ("float", "(double)", "(float)")]
)
def test_saved_numbers_have_eight_bytes_after_layout_and_marks(scalar, widened, narrowed):
    fields = [("z", REAL, "", 0.0), ("depth", INTEGER, "", 0)]
    facts = saved_facts(printer(scalar), ("position", "force"), fields, 20, "layout")
    # The layout, position, force, marks, z, depth, twenty numbers and the checksum.
    assert facts["heads"] == [{"name": "position", "at": 8}, {"name": "force", "at": 16}]
    assert (facts["marks_at"], facts["memory_at"], facts["saved"]) == (24, 48, 8 * (4 + 2 + 20 + 1))
    z, depth = facts["saved_state"]
    assert z["put"] == f"put_real(at, {widened}axis->state.z)"
    assert (z["got"], z["refused"]) == (
        f"axis->state.z = {narrowed}got_real(bytes + 32)",
        "!is_finite(got_real(bytes + 32))",
    )
    assert depth["put"] == "put(at, (uint64_t)axis->state.depth)"
    assert (depth["got"], depth["refused"]) == (
        "axis->state.depth = (int32_t)got(bytes + 40)",
        "got(bytes + 40) >= 10U",
    )
    assert saved_facts(printer(), ("effort",), [], 0, "layout")["saved"] == 8 * (3 + 1)
    assert (
        facts["layout"]
        != saved_facts(printer(scalar), ("position", "force"), fields, 20, "other")["layout"]
    )


@pytest.mark.parametrize(
    ("dt", "cycles", "period", "every"),
    [(1e-3, 1000, "1", 100), (0.4, 2, "0.8", 1), (3.0, 2, "6", 1)],
)
def test_an_example_runs_a_second_and_prints_ten_numbers(dt, cycles, period, every):
    coulomb = br.friction.coulomb(F_C=1.0)
    facts = CFiles(subject_of(coulomb), Request(coulomb, "axis_x", dt)).facts()
    assert (facts["cycles"], facts["period"], facts["every"], facts["drive"]) == (
        cycles,
        period,
        every,
        None,
    )
    assert facts["zero"] == "0.0"

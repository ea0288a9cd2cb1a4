"""C of friction models: the bits of bristle, whatever the model and its slots, what a drive needs around it, other targets."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from tests.contract.models import with_fast
from tests.exports.instructions import counted
from tests.exports.native import ALL, COMPILER, FLAGS, Native, built, compiled, differing, example_with, selected_cases, walk
from tests.exports.other_targets import TARGETS, answer, examples

import bristle as br
from bristle.engine import compilation, force_along, interpreted
from bristle.exports import subject
from bristle.exports.c import builds, write
from bristle.exports.targets import Request

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 5e-4
WATCHED = "-fsanitize=address,undefined"


def example(name, slots=()):
    return example_with(name, slots)


@pytest.fixture(scope="module")
def models(request):
    plain = {f"plain_{name}": example(name) for name in ("lugre", "coulomb", "maxwell_slip")}
    varied = {f"varied_{name}": example(name, ALL) for name in ("lugre", "gms", "preisach_lugre")}
    every = {f"sided_{name}": example(name, ("asymmetry",)) for name in br.friction.MODELS} | plain | varied
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
    watching = (watched,) if builds(compiler, watched) else ()  # some compilers come without the library of it
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
        (r"axis->state\.lost = after\.lost;", "axis->state.lost = after.lost + 1;", "continues differently"),
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
    assert differing(np.array(ran(written / "gms", CHANGED).split(), dtype=float), br.response(model, x, DT)) == 0


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
    listed = subprocess.run(["nm", "-u", "axis_x.o"], cwd=written / "gms", capture_output=True, text=True, check=True).stdout
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
    assert re.search(r"double position;.*\n.*begun;.*\n.*double force;", header)  # apart, for the time of a step
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


@pytest.mark.skipif(not builds(str(COMPILER), WATCHED), reason="needs a compiler with its sanitizers")
def test_no_saved_bytes_cause_access_outside_the_memory(written):
    (written / "preisach_contact" / "forged.c").write_text(FORGED)
    done = built(written / "preisach_contact", "forged.c", WATCHED, "-fno-sanitize-recover")
    assert done.returncode == 0, done.stderr[:2000]
    assert 100 < int(done.stdout) < 1900


def test_an_export_neither_compiles_nor_loads_a_compiler(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(compilation, "_compile", lambda *_: pytest.fail("compiles"))
    br.export(br.friction.coulomb(F_C=2.0), "c", tmp_path / "out")


SINGLE = {"lugre": ALL, "maxwell_stribeck": ("asymmetry",), "preisach_contact": ("asymmetry",)}


@pytest.fixture(scope="module")
def singles(tmp_path_factory):
    return Native({name: example(name, slots) for name, slots in SINGLE.items()}, tmp_path_factory.mktemp("single"), float32=True)


@pytest.mark.parametrize("name", SINGLE)
def test_single_precision_error_is_near_its_rounding(singles, name):
    x = np.cumsum(np.repeat([1e-7, -2e-6, 3e-5, -3e-5], 100) * np.tile([1.0, 0.5, -1.25, 0.75], 100))
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
    assert "double" not in text[text.index("typedef struct") : text.index("static inline bool is_finite")]
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
        expected = force_along(model, np.diff(x) / DT, DT, x[1:], load=1.0 + 0.01 * i[1:], temperature=300.0 + i[1:].astype(float))
    assert differing(forces[1:], expected) == 0


# --- other targets, in emulators of them; `tests.exports.other_targets` tries every model ----------------------------


@pytest.mark.parametrize(
    ("core", "name", "mean", "worst", "code"),
    [
        ("Cortex-M7", "lugre", 250, 300, 2500),
        ("Cortex-M7", "preisach_lugre", 900, 9000, 18000),
        ("Cortex-M4F", "preisach_lugre", 1200, 6000, 16000),
    ],
)
def test_a_step_fits_the_instruction_budget_of_a_drive(core, name, mean, worst, code, tmp_path):
    if TARGETS[core].lacking:
        pytest.skip(f"needs {TARGETS[core].lacking}")
    result = counted(example_with(name), core, tmp_path / "out", steps=20_000)
    assert result.mean < mean
    assert result.worst < worst
    assert result.code < code
    assert result.stack <= 1024


def test_different_bits_are_reported(monkeypatch, tmp_path):
    target = TARGETS["clang"]._replace(build=("cc",))
    if shutil.which("cc") is None:
        pytest.skip("needs a C compiler")
    monkeypatch.setattr(subject, "FNV_PRIME", subject.FNV_PRIME + 2)
    text = answer(target, examples()["plain lugre"], Path(tmp_path) / "out")
    assert "expected" in text

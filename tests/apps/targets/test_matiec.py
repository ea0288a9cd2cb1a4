"""Structured Text through MATIEC, a compiler of IEC 61131-3, where `BRISTLE_MATIEC` names its folder.

Models without a slot, with one and with five, and control laws, in double precision and in single: the bits of Python,
and of C where that is in single precision or a law.
"""

import ctypes
import os
import re
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.apps.targets.test_fmu import inputs_of
from tests.exports.native import (
    ALL,
    COMPILER,
    RUN_LAW,
    differing,
    example_with,
    library,
    library_of_laws,
    walk,
)
from tests.exports.test_laws import CASES, replayed, variant_of

import bristle as br
from bristle.apps.targets.st import st_law_files
from bristle.exports.c import law_files
from bristle.exports.described import Source
from bristle.exports.law import law_of
from bristle.models.friction.resting import with_rest

FOLDER = os.environ.get("BRISTLE_MATIEC", "")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not FOLDER or COMPILER is None, reason="BRISTLE_MATIEC names no MATIEC, or no C compiler"
    ),
]
DT, COUNT = 1e-3, 2000
SINGLE_LAWS = (
    ("cascade", "measured"),
    ("sliding_mode", "desired"),
    ("cascade", "toothed"),
    ("observer", "all"),
)
MAIN = """
#include "iec_std_lib.h"
#include "accessor.h"
TIME __CURRENT_TIME;
BOOL __DEBUG;
#include "POUS.h"
#include "POUS.c"
static AXIS_X axis;
int run(const double *given, int count, double *output)
{{
    int refused = 0;
    AXIS_X_init__(&axis, 0);
    for (int k = 0; k < count; ++k) {{
{lines}
        AXIS_X_body__(&axis);
        output[k] = axis.{output}.value;
        refused |= axis.REFUSED.value || axis.OVERFLOW.value;
    }}
    return refused;
}}
"""
AT = """
#include "out/axis_x.h"
void run_at(const double *given, int count, double *force)
{{
    static axis_x axis;
    axis_x_start(&axis);
    for (int i = 0; i < count; ++i, given += {count}) {{
        force[i] = axis_x_force{at}(&axis, {inputs});
    }}
}}
"""


def compiled(source, folder, output):
    """Return a function block in C by MATIEC: from inputs, a row for each call, to its output."""
    (folder / "c").mkdir()
    (folder / "axis_x.st").write_text(source, encoding="ascii")
    command = [
        Path(FOLDER) / "iec2c",
        "-I",
        Path(FOLDER) / "lib",
        "-T",
        folder / "c",
        folder / "axis_x.st",
    ]
    made = subprocess.run(command, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    lines = "\n".join(f"        {place} = *given++;" for place in places_of(source))
    (folder / "c" / "main.c").write_text(MAIN.format(lines=lines, output=output.upper()))
    flags = ("-std=gnu99", "-O1", "-fno-strict-aliasing", "-w", "-I")
    return library(folder, *flags, Path(FOLDER) / "lib" / "C", folder / "c" / "main.c")


def places_of(source):
    """Return where the inputs of the block are in the C of MATIEC, each number of an array by itself."""
    declared = re.search(
        r"FUNCTION_BLOCK axis_x\nVAR_INPUT\n(.*?)END_VAR", source, flags=re.DOTALL
    )[1]
    sizes = {
        name: int(last) + 1 for name, last in re.findall(r"(\w+) : ARRAY\[0\.\.(\d+)\]", source)
    }
    for name, kind in re.findall(r"^ +(\w+) : (\w+)", declared, flags=re.MULTILINE):
        if name in ("restart", "clear"):
            return
        place = f"axis.{name.upper()}.value"
        yield from (
            (f"{place}.table[{i}]" for i in range(sizes[kind])) if kind in sizes else (place,)
        )


def run(library, rows):
    """Return the outputs of a block along its inputs, none of which it refuses."""
    rows, output, pointer = (
        np.ascontiguousarray(rows),
        np.empty(len(rows)),
        ctypes.POINTER(ctypes.c_double),
    )
    refused = library.run(rows.ctypes.data_as(pointer), len(rows), output.ctypes.data_as(pointer))
    assert refused == 0
    return output


def settled(force):
    """Return forces without what stands for -0.0, which the language cannot tell from 0.0: a velocity just below it."""
    return np.where(np.abs(force) < 1e-30, 0.0, force)


# Mean, amplitude, rate
SIGNALS = {
    "load": (1.0, 0.4, 0.05),
    "temperature": (293.15, 15.0, 0.003),
    "transmitted": (0.0, 3.0, 0.02),
}


@cache
def motion(signals=()):
    """Return positions, the other inputs of a block, and a row of all inputs for each call."""
    x = walk(COUNT, seed=4)
    k = np.arange(COUNT)
    around = {
        name: mean + size * np.sin(rate * k)
        for name, (mean, size, rate) in SIGNALS.items()
        if name in signals
    }
    return x, around, np.column_stack([x, np.full(COUNT, DT), *around.values()])


def signals_of(model):
    return tuple(surrounding.field for surrounding in model.component.surroundings)


def outputs(model, folder, rows, **options):
    """Return the forces of a model in the C of MATIEC."""
    br.export(model, "st", folder / "st", **options)
    return run(compiled((folder / "st" / "axis_x.st").read_text(), folder, "force"), rows)


# The last one has loops of a single pass.
SHAPES = [(name, slots) for slots in ((), ("asymmetry",), ALL) for name in br.friction.MODELS] + [
    ("maxwell_slip", None)
]


@pytest.mark.parametrize(("name", "slots"), SHAPES)
def test_matiec_compiles_a_model_with_identical_forces(tmp_path, name, slots):
    one = br.friction.maxwell_slip(F_C=20.0, k_i=[6e6], nu_i=[1.0])
    model = one if slots is None else example_with(name, slots)
    x, around, rows = motion(signals_of(model))
    result = outputs(
        model, tmp_path, rows, rest="held" if with_rest(model, "held") != model else None
    )
    with br.engine.interpreted():
        message = {key: values[1:] for key, values in around.items()}
        expected = br.engine.force_along(
            with_rest(model, "held"), np.diff(x) / DT + 0.0, DT, x[1:], **message
        )
    assert np.ptp(expected) > 0.0
    assert differing(settled(result), np.concatenate([[0.0], expected])) == 0


@pytest.mark.parametrize("slots", [(), ALL], ids=["plain", "varied"])
@pytest.mark.parametrize("name", br.friction.MODELS)
def test_a_model_in_single_precision_is_identical_to_c(tmp_path, name, slots):
    model = example_with(name, slots)
    _, _, rows = motion(signals_of(model))
    result = outputs(model, tmp_path, rows, float32=True)
    br.export(model, "c", tmp_path / "out", float32=True)
    inputs = ", ".join(f"given[{column}]" for column in range(rows.shape[1]))
    (tmp_path / "run.c").write_text(
        AT.format(inputs=inputs, count=rows.shape[1], at="_at" if rows.shape[1] > 2 else "")
    )
    assert (
        differing(settled(result), replayed(library(tmp_path, "run.c", "out/axis_x.c"), "at", rows))
        == 0
    )


@pytest.mark.parametrize(
    ("controller", "fed", "single"),
    [(*case, False) for case in CASES] + [(*case, True) for case in SINGLE_LAWS],
)
def test_a_law_is_identical_to_the_law_in_c(tmp_path, controller, fed, single):
    law, rows = law_of(variant_of(controller, fed), single=single), inputs_of(controller, fed)
    result = run(
        compiled(st_law_files(law, "axis_x", Source())["axis_x.st"], tmp_path, "effort"), rows
    )
    in_c = library_of_laws(
        tmp_path / "c_of_law",
        {"axis_x": law_files(law, "axis_x", Source())},
        {"axis_x": RUN_LAW.format(name="axis_x")},
    )
    assert differing(result, replayed(in_c, "axis_x", rows)) == 0


@pytest.mark.parametrize(("controller", "fed"), SINGLE_LAWS[:3])
def test_a_law_with_parameters_as_inputs_compiles(tmp_path, controller, fed):
    law = law_of(variant_of(controller, fed), tunable=True)
    compiled(st_law_files(law, "axis_x", Source())["axis_x.st"], tmp_path, "effort")

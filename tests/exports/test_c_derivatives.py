"""Derivatives in C: those of bristle to the bit, beside a force whose bits stay."""

import ctypes

import numpy as np
import pytest
from tests.engine.test_derivatives import SLOTS
from tests.exports.native import (
    COMPILER,
    FLAGS,
    WARNINGS,
    built,
    compiled,
    differing,
    library,
    selected_cases,
    walk,
)
from tests.exports.test_names import TEXT

import bristle as br
from bristle.contract import example_of
from bristle.core.packing import pack
from bristle.engine.derivatives import force_with_derivatives
from bristle.exports.subject import subject_of
from bristle.exports.tunable import tunable_of
from bristle.models.friction.resting import with_rest

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 5e-4
RUN = """
#include "{name}.h"
void run_{name}(const double *x, size_t steps, size_t count, const double *parameters, const double *d_x, const double *d_dt,
                {signals}double *force, double *d_force)
{{
    static {name} axis;
    static {name}_tangent d[64];
    {name}_start(&axis);
    {change}
    for (size_t k = 0; k < count; ++k) {{
        {name}_start_d(&d[k]);
        for (size_t i = 0; i < {guard}_PARAMETERS; ++i) {{
            d[k].parameters[i] = parameters[k * {guard}_PARAMETERS + i];
        }}
    }}
    for (size_t i = 0; i < steps; ++i) {{
        force[i] = {name}_force_d(&axis, d, count, x[i], &d_x[i * count], {dt}, d_dt ? &d_dt[i * count] : NULL, {at}&d_force[i * count]);
    }}
}}
"""


class Library:
    """Models with derivatives in one library."""

    def __init__(self, models, folder, change="", **options):
        self.models = models
        for name, model in models.items():
            br.export(model, "c", folder / name, name=name, derivatives=True, **options)
            signals = subject_of(model).signals
            heads, at = (
                "".join(f"const double *{s}, " for s in signals),
                "".join(f"{s}[i], NULL, " for s in signals),
            )
            run = RUN.format(
                name=name, change=change, guard=name.upper(), dt=DT, signals=heads, at=at
            )
            (folder / f"run_{name}.c").write_text(run)
        sources = [
            file for name in models for file in (f"-I{name}", f"{name}/{name}.c", f"run_{name}.c")
        ]
        self._library = library(folder, "-O0", *WARNINGS, *sources)

    def along(self, name, x, parameters, d_x, d_dt=None, around=None):
        """Return the force of each sample and its derivatives; `parameters` has shape (direction, number)."""
        force, slopes = np.empty(x.size), np.empty(d_x.shape)
        signals = [(around or {})[signal] for signal in subject_of(self.models[name]).signals]
        arrays = [np.ascontiguousarray(a, dtype=float) for a in (parameters, d_x)]
        optional = [None if d_dt is None else np.ascontiguousarray(d_dt)]
        handed = [
            a if a is None else a.ctypes
            for a in (*arrays, *optional, *map(np.ascontiguousarray, signals), force, slopes)
        ]
        run = getattr(self._library, f"run_{name}")
        run(x.ctypes, ctypes.c_size_t(x.size), ctypes.c_size_t(d_x.shape[1]), *handed)
        return force, slopes


def packed(model, parameters):
    """Return directions in the numbers of a model, shape (direction, number), as directions in its packed parameters."""
    tuned = tunable_of(model)
    numbers = [(name, within) for name, within, _ in tuned.numbers()]

    def filled(p, row, path=()):
        parts = []
        for name, part in zip(p._fields, p, strict=True):
            inner = (*path, name)
            if hasattr(part, "_fields"):
                parts.append(filled(part, row, inner))
            elif isinstance(part, np.ndarray):
                parts.append(
                    np.array(
                        [row[numbers.index((tuned.places[inner], k))] for k in range(part.size)]
                    )
                )
            else:
                parts.append(
                    row[numbers.index((tuned.places[inner], None))]
                    if inner in tuned.places
                    else 0.0
                )
        return type(p)(*parts)

    return np.column_stack([pack(filled(model.parameters, row)) for row in parameters])


def directions_of(model, x, count=3, seed=5):
    """Return directions of parameters, each relative to its value, and of positions."""
    random = np.random.default_rng(seed)
    values = np.array([value for *_, value in tunable_of(model).numbers()])
    scale = np.where(np.isfinite(values), np.where(values == 0.0, 1e-3, values), 0.0)
    parameters = random.uniform(-1.0, 1.0, (count, values.size)) * scale
    return parameters, np.cumsum(random.uniform(-1e-6, 1e-6, (x.size, count)), axis=0)


def in_python(model, x, parameters, d_x, around=None):
    """Return force and derivatives of bristle after the first sample."""
    v, moved = np.diff(x) / DT, (np.diff(d_x, axis=0) / DT, d_x[1:])
    tail = {name: signal[1:] for name, signal in (around or {}).items()}
    with np.errstate(invalid="ignore"):
        return force_with_derivatives(
            model, packed(model, parameters), v, DT, x[1:], motion_tangents=moved, around=tail
        )


def around_of(model, count):
    """Return signals that turn: load, temperature and others that the model has."""
    turn = np.linspace(0.0, 6.0, count)
    every = {
        "load": 1.0 + 0.4 * np.sin(turn),
        "temperature": 300.0 + 15.0 * np.cos(turn),
        "transmitted": 10.0 * np.sin(3.0 * turn),
    }
    return {line.field: every[line.field] for line in model.component.surroundings}


def example(name, slots):
    return with_rest(
        example_of(
            br.friction.with_slots(br.friction.MODELS[name], slots)
            if slots
            else br.friction.MODELS[name]
        ),
        "held",
    )


QUICK = [
    ("lugre", SLOTS),
    ("gms", ()),
    ("maxwell_stribeck", SLOTS),
    ("preisach_lugre", ()),
    ("stribeck", ()),
    ("efficiency", ()),
]


@pytest.fixture(scope="module")
def quick(request, tmp_path_factory):
    wanted = [
        case
        for case in QUICK
        if (case,) in selected_cases(request, "case") or case[0] in ("lugre", "gms")
    ]
    return Library({case[0]: example(*case) for case in wanted}, tmp_path_factory.mktemp("derived"))


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("case", QUICK, ids=[case[0] for case in QUICK])
def test_derivatives_in_c_are_identical_to_python(quick, case):
    model, x = quick.models[case[0]], walk(300)
    parameters, d_x = directions_of(model, x)
    around = around_of(model, x.size)
    force, slopes = quick.along(case[0], x, parameters, d_x, around=around)
    with br.engine.interpreted():
        expected_force, expected = in_python(model, x, parameters, d_x, around=around)
    assert np.abs(expected).max() > 0.0
    assert differing(force[1:], expected_force) == 0
    assert not slopes[0].any()
    assert differing(slopes[1:] + 0.0, expected + 0.0) == 0


def test_the_derivative_by_the_time_step_is_that_of_differences(quick):
    x = np.cumsum(walk(200, seed=9) * 1e-2 + 2e-6)
    still = np.zeros((1, len(list(tunable_of(quick.models["gms"]).numbers()))))
    _, slopes = quick.along("gms", x, still, np.zeros((x.size, 1)), np.ones((x.size, 1)))
    nudge = 1e-6 * DT
    with br.engine.interpreted():
        high, low = (br.response(quick.models["gms"], x, DT + change) for change in (nudge, -nudge))
    expected = (high - low) / (2.0 * nudge)
    assert np.abs(expected).max() > 1.0
    assert np.median(np.abs(slopes[1:, 0] - expected[1:])) <= 1e-6 * np.abs(expected).max()


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("name", "slots", "tunable"), [("dahl", (), True), ("maxwell_slip", ("load",), False)]
)
def test_the_self_test_compares_derivatives(tmp_path, name, slots, tunable):
    br.export(example(name, slots), "c", tmp_path / "out", derivatives=True, tunable=tunable)
    assert "identical to bristle" in built(tmp_path / "out", "axis_x_selftest.c").stdout
    source = tmp_path / "out" / "axis_x.c"
    wrong = source.read_text().replace(
        "d_x_k - at->position", "d_x_k - 1.0000000000000002 * at->position"
    )
    source.write_text(wrong)
    assert "derivatives differ" in built(tmp_path / "out", "axis_x_selftest.c").stdout


@pytest.mark.parametrize("name", ["d", "slopes", "at"])
def test_names_of_a_model_and_of_its_export_are_apart(tmp_path, name):
    (tmp_path / "odd.py").write_text(TEXT, encoding="utf-8")
    br.export(example_of(br.load_code(tmp_path / "odd.py")), "casadi", tmp_path / "out", name=name)
    compiled(
        tmp_path / "out",
        *FLAGS,
        *WARNINGS,
        "-fsyntax-only",
        *(f"{name}{end}.c" for end in ("", "_selftest", "_casadi")),
    )


REFUSED = """
#include "axis_x.h"
#include <math.h>
#include <stdio.h>
int main(void)
{
    static axis_x axis, before;
    static axis_x_tangent d;
    const double x[] = {0.0, 1e-5, NAN, INFINITY, 2e-5, 1e308, 2e-5}, d_x = 1.0;
    axis_x_start(&axis);
    axis_x_start_d(&d);
    for (int i = 0; i < 7; ++i) {
        double d_force = 0.0;
        const double force = axis_x_force_d(&axis, &d, 1, x[i], i == 0 ? NULL : &d_x, 1e-3, NULL, &d_force);
        printf("%.17g %.17g %d\\n", force, d_force, (int)axis.flags);
        axis.flags = 0;
        before = axis;
    }
    const double force = axis_x_force_d(&before, NULL, 0, 3e-5, NULL, 1e-3, NULL, NULL);
    printf("%d\\n", force == axis_x_force(&axis, 3e-5, 1e-3));
    return 0;
}
"""


@pytest.mark.slow
def test_a_refused_input_repeats_force_and_derivatives(tmp_path):
    br.export(example("dahl", ()), "c", tmp_path / "out", derivatives=True)
    (tmp_path / "out" / "refused.c").write_text(REFUSED)
    ran = built(tmp_path / "out", "refused.c")
    *rows, alone = [line.split() for line in ran.stdout.splitlines()]
    slopes, flags = [float(row[1]) for row in rows], [int(row[2]) for row in rows]
    assert flags[:5] == [0, 0, 1, 1, 0]
    assert slopes[0] == 0.0
    assert slopes[1] > 0.0
    assert slopes[1] == slopes[2] == slopes[3] != slopes[4]
    assert alone == ["1"]


@pytest.mark.slow
def test_directions_follow_parameters_that_change_at_run_time(tmp_path):
    model, x = example("maxwell_slip", ()), walk(200, seed=4)
    library = Library(
        {"varied": model},
        tmp_path,
        "axis.parameters.F_C = 17.0; axis.parameters.k_i[1] = 2e6;",
        tunable=True,
    )
    parameters, d_x = directions_of(model, x)
    _, slopes = library.along("varied", x, parameters, d_x)
    with br.engine.interpreted():
        _, expected = in_python(
            model.with_values(F_C=17.0, k_i=[6e6, 2e6, 1e6]), x, parameters, d_x
        )
        _, before = in_python(model, x, parameters, d_x)
    assert differing(slopes[1:] + 0.0, expected + 0.0) == 0
    assert differing(before, expected) > 0

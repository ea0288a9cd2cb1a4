"""Derivatives in C: those of bristle to the bit, beside a force whose bits stay."""

import ctypes
import subprocess

import numpy as np
import pytest
from tests.engine.test_derivatives import CASES, NAMES, SLOTS, agrees, model_of
from tests.exports.native import COMPILER, FLAGS, WARNINGS, differing, selected_cases, walk
from tests.translation.complex_step import force_by_complex_steps

import bristle as br
from bristle.core.errors import InputError
from bristle.core.packing import pack, structure_of, unpacker
from bristle.engine import interpreted
from bristle.engine.derivatives import force_with_derivatives
from bristle.exports.tunable import tunable_of
from bristle.friction import MODELS, with_slots
from bristle.testing import example_of

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 5e-4
RUN = """
#include "{name}.h"
void run_{name}(const double *x, size_t steps, size_t count, const double *parameters, const double *d_x, const double *d_dt, {signals}double *force,
                double *d_force)
{{
    static {name} axis;
    static {name}_tangent d[64];
    {name}_start(&axis);
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

    def __init__(self, models, folder, **options):
        self.models, sources, includes = models, [], []
        for name, model in models.items():
            br.export(model, "c", folder / name, name=name, derivatives=True, **options)
            signals = [line.field for line in model.component.surroundings]
            heads, at = "".join(f"const double *{s}, " for s in signals), "".join(f"{s}[i], NULL, " for s in signals)
            run = RUN.format(name=name, guard=name.upper(), dt=DT, signals=heads, at=at)
            (folder / f"run_{name}.c").write_text(run)
            sources += [f"{name}/{name}.c", f"run_{name}.c"]
            includes.append(f"-I{name}")
        line = [COMPILER, "-O1", *FLAGS, *WARNINGS, *includes, "-shared", "-fPIC", *sources, "-o", "models.so", "-lm"]
        built = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
        assert built.returncode == 0, built.stderr[:4000]
        self._library = ctypes.CDLL(str(folder / "models.so"))

    def along(self, name, x, parameters, d_x, d_dt=None, around=None):
        """Return the force of each sample and its derivatives; `parameters` has shape (direction, number)."""
        force, slopes = np.empty(x.size), np.empty(d_x.shape)
        signals = [(around or {})[line.field] for line in self.models[name].component.surroundings]
        arrays = [np.ascontiguousarray(a, dtype=float) for a in (parameters, d_x)]
        optional = [None if d_dt is None else np.ascontiguousarray(d_dt)]
        handed = [a if a is None else a.ctypes for a in (*arrays, *optional, *map(np.ascontiguousarray, signals), force, slopes)]
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
                parts.append(np.array([row[numbers.index((tuned.places[inner], k))] for k in range(part.size)]))
            else:
                parts.append(row[numbers.index((tuned.places[inner], None))] if inner in tuned.places else 0.0)
        return type(p)(*parts)

    return np.column_stack([pack(filled(model.parameters, row)) for row in parameters])


def directions_of(model, x, count=3, seed=5):
    """Return directions of parameters, each relative to its value, and of positions."""
    random = np.random.default_rng(seed)
    values = np.array([value for *_, value in tunable_of(model).numbers()])
    scale = np.where(np.isfinite(values), np.where(values == 0.0, 1e-3, values), 0.0)
    parameters = random.uniform(-1.0, 1.0, (count, values.size)) * scale
    return parameters, np.cumsum(random.uniform(-1e-6, 1e-6, (x.size, count)), axis=0)


def in_python(model, x, parameters, d_x, run=force_with_derivatives, around=None):
    """Return force and derivatives of bristle after the first sample."""
    v, moved = np.diff(x) / DT, (np.diff(d_x, axis=0) / DT, d_x[1:])
    tail = {name: signal[1:] for name, signal in (around or {}).items()}
    between = {"motion_tangents": moved, "around": tail}
    if run is force_by_complex_steps:
        return run(model, packed(model, parameters), v, DT, x[1:], **between)
    with np.errstate(invalid="ignore"):
        return run(model, packed(model, parameters), v, DT, x[1:], **between)


def around_of(model, count):
    """Return signals that turn: load, temperature and others that the model has."""
    turn = np.linspace(0.0, 6.0, count)
    every = {"load": 1.0 + 0.4 * np.sin(turn), "temperature": 300.0 + 15.0 * np.cos(turn), "transmitted": 10.0 * np.sin(3.0 * turn)}
    return {line.field: every[line.field] for line in model.component.surroundings}


def refined(case):
    """Return a model whose exponents take no shortcut."""
    return example_of(with_slots(MODELS[case[0]], case[1])) if case[1] else example_of(MODELS[case[0]])


QUICK = [("lugre", SLOTS), ("gms", ()), ("maxwell_stribeck", SLOTS), ("preisach_lugre", ()), ("stribeck", ()), ("efficiency", ())]


@pytest.fixture(scope="module")
def quick(request, tmp_path_factory):
    wanted = [case for case in QUICK if (case,) in selected_cases(request, "case")]
    return Library({case[0]: refined(case) for case in wanted}, tmp_path_factory.mktemp("derived"))


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("case", QUICK, ids=[case[0] for case in QUICK])
def test_derivatives_in_c_are_those_of_python_to_the_bit(quick, case):
    model, x = quick.models[case[0]], walk(300)
    parameters, d_x = directions_of(model, x)
    around = around_of(model, x.size)
    force, slopes = quick.along(case[0], x, parameters, d_x, around=around)
    with interpreted():
        expected_force, expected = in_python(model, x, parameters, d_x, around=around)
    assert np.abs(expected).max() > 0.0
    assert differing(force[1:], expected_force) == 0
    assert not slopes[0].any()
    assert differing(slopes[1:] + 0.0, expected + 0.0) == 0

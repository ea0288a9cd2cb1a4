"""Derivatives along walks, forward and in reverse, are those of bristle for every friction model."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.engine.test_derivatives import CASES, NAMES, model_of
from tests.exports.native import COMPILER, differing, walk
from tests.exports.test_c_derivatives import around_of, directions_of, in_python

import bristle as br
from bristle.core.errors import InputError
from bristle.engine import force_along, interpreted
from bristle.exports import CompiledWalk
from bristle.exports.walk import _key

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 5e-4  # of the walks in Python
LUGRE = br.friction.lugre(
    F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m"
)


def run(compiled, function, lanes, steps, inputs, like):
    outputs = [np.full_like(array, np.nan) for array in like]
    compiled.run(function, lanes, steps, inputs, outputs)
    return outputs


def inputs_of(compiled, x, signals=None):
    around = [
        np.full(x.size, usual) if signals is None else signals[name]
        for name, usual in compiled.signals.items()
    ]
    return [
        compiled.start,
        x,
        np.array([DT]),
        np.concatenate(list(compiled.parameters.values())),
        *around,
    ]


def tangents_of(inputs, parameters, d_x):
    return [np.zeros_like(inputs[0]), d_x, np.zeros(1), parameters, *map(np.zeros_like, inputs[4:])]


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize("case", CASES, ids=NAMES)
def test_derivatives_along_a_walk_are_those_of_python_forward_and_in_reverse(case):
    model, x = model_of(*case, is_off=False), walk(300)
    compiled, around = CompiledWalk(model), around_of(model, 300)
    parameters, d_x = directions_of(model, x)
    with interpreted():
        force, slopes = in_python(model, x, parameters, d_x, around=around)
    inputs, weights = (
        inputs_of(compiled, x, around),
        np.random.default_rng(9).standard_normal(x.size),
    )
    end, walked = run(compiled, "walk", 1, x.size, inputs, inputs[:2])
    assert walked[0] == 0.0
    assert differing(walked[1:], force) == 0
    scale = np.abs(slopes).max(axis=0)
    for k, row in enumerate(parameters):
        tangents = tangents_of(inputs, row, np.ascontiguousarray(d_x[:, k]))
        _, d_force = run(compiled, "walk_forward", 1, x.size, [*inputs, *tangents], inputs[:2])
        assert np.abs(d_force[1:] - slopes[:, k]).max() <= 1e-12 * scale[k]
    adjoints = run(
        compiled, "walk_reverse", 1, x.size, [*inputs, np.zeros_like(end), weights], inputs
    )
    assert all(np.isfinite(adjoint).all() for adjoint in adjoints)
    products = parameters @ adjoints[3] + adjoints[1] @ d_x
    assert (
        np.abs(products - weights[1:] @ slopes).max()
        <= 1e-12 * np.abs(weights[1:, None] * slopes).sum(axis=0).max()
    )


@pytest.mark.parametrize(
    "name", ["lugre", pytest.param("preisach_contact", marks=pytest.mark.slow)]
)
def test_adjoints_of_all_inputs_are_the_transpose_of_all_tangents(name):
    model = model_of(name, ("load", "temperature"), is_off=False)
    compiled, x = CompiledWalk(model), walk(137)
    random, inputs = np.random.default_rng(4), inputs_of(compiled, x[:100], around_of(model, 100))
    # A state inside the motion, so that memory and all numbers of the state matter.
    inputs[0], _ = run(compiled, "walk", 1, 100, inputs, inputs[:2])
    rest = inputs_of(
        compiled, x[100:], {name: signal[100:] for name, signal in around_of(model, 137).items()}
    )
    rest[0] = inputs[0]
    sizes = [np.maximum(np.abs(array), 1e-6 * (array != 0.0)) for array in rest]
    tangents = [size * random.standard_normal(size.size) for size in sizes]
    d_end, d_force = run(compiled, "walk_forward", 1, 37, [*rest, *tangents], rest[:2])
    bars = [
        random.standard_normal(d_end.size) / np.maximum(np.abs(d_end), 1e-9),
        random.standard_normal(37),
    ]
    adjoints = run(compiled, "walk_reverse", 1, 37, [*rest, *bars], rest)
    first = bars[0] @ d_end + bars[1] @ d_force
    terms = [adjoint * tangent for adjoint, tangent in zip(adjoints, tangents, strict=True)]
    assert first == pytest.approx(
        sum(map(np.sum, terms)), rel=0.0, abs=1e-12 * sum(np.abs(term).sum() for term in terms)
    )
    assert all(np.any(adjoint) for adjoint in adjoints)


def test_lanes_are_walks_of_their_own():
    compiled = CompiledWalk(LUGRE)
    single = [inputs_of(compiled, walk(50, seed)) for seed in (1, 2, 3)]
    single[1][3] = 1.1 * single[1][3]
    together = [np.stack(arrays) for arrays in zip(*single, strict=True)]
    bars = [np.ones_like(together[0]), np.random.default_rng(0).standard_normal((3, 50))]
    for function, more, count in (("walk", [], 2), ("walk_reverse", bars, 4)):
        results = run(compiled, function, 3, 50, [*together, *more], together[:count])
        for lane, inputs in enumerate(single):
            alone = run(
                compiled, function, 1, 50, [*inputs, *(bar[lane] for bar in more)], inputs[:count]
            )
            for result, expected in zip(results, alone, strict=True):
                assert differing(result[lane], expected) == 0


@pytest.mark.parametrize(
    "name", ["maxwell_slip", pytest.param("preisach_lugre", marks=pytest.mark.slow)]
)
def test_a_walk_in_two_parts_is_the_whole_walk(name):
    model, x = model_of(name, is_off=False), walk(80)
    compiled = CompiledWalk(model)
    end, force = run(compiled, "walk", 1, 80, inputs_of(compiled, x), [compiled.start, x])
    middle, before = run(
        compiled, "walk", 1, 30, inputs_of(compiled, x[:30]), [compiled.start, x[:30]]
    )
    last, after = run(
        compiled, "walk", 1, 50, [middle, *inputs_of(compiled, x[30:])[1:]], [middle, x[30:]]
    )
    assert differing(np.append(before, after), force) == 0
    assert differing(last, end) == 0
    assert differing(force[1:], force_along(model, np.diff(x) / DT, DT, x[1:])) == 0


def test_a_refused_step_repeats_the_force_and_its_adjoint():
    compiled, x = CompiledWalk(LUGRE), walk(20)
    broken = np.insert(x, 11, np.nan)
    inputs = inputs_of(compiled, broken)
    _, force = run(compiled, "walk", 1, 21, inputs, inputs[:2])
    assert force[11] == force[10]
    before, at_rest = inputs_of(compiled, x[:11]), 0.0 * compiled.start
    of_parameters = run(
        compiled, "walk_reverse", 1, 21, [*inputs, at_rest, np.eye(21)[11]], inputs
    )[3]
    of_last = run(compiled, "walk_reverse", 1, 11, [*before, at_rest, np.eye(11)[10]], before)[3]
    assert of_parameters == pytest.approx(of_last, rel=1e-12, abs=0.0)
    assert np.any(of_last)


def test_a_state_of_another_model_is_refused():
    compiled, x = CompiledWalk(model_of("preisach_contact", is_off=False)), walk(5)
    wrong = inputs_of(compiled, x)
    wrong[0] = np.full_like(compiled.start, 1e6)
    for function, more in (
        ("walk", []),
        ("walk_reverse", [compiled.start, x]),
        ("walk_forward", wrong),
    ):
        with pytest.raises(InputError, match="state: is not a state of this model"):
            run(compiled, function, 1, 5, [*wrong, *more], wrong)


def test_a_missing_compiler_and_a_failure_are_named():
    with pytest.raises(InputError, match="needs a compiler"):
        CompiledWalk.build({"a.c": "int a;"}, None, [])
    with pytest.raises(InputError, match=f"{COMPILER}: failed: .*error"):
        CompiledWalk.build({"a.c": "int a"}, COMPILER, [])


def test_a_cached_model_needs_neither_translation_nor_compiler(monkeypatch):
    first = CompiledWalk(LUGRE)
    monkeypatch.setattr(CompiledWalk, "_built", lambda *_: pytest.fail("translates again"))
    second = CompiledWalk(LUGRE)
    assert second.library == first.library
    assert list(second.parameters.items()) == list(first.parameters.items())
    assert (second.signals, second.start.tolist()) == (first.signals, first.start.tolist())


@pytest.mark.slow
def test_a_cached_model_loads_no_compiler():
    slower = "from tests.apps.targets.test_walks import LUGRE, CompiledWalk; CompiledWalk(LUGRE); import sys; print('numba' in sys.modules)"
    assert (
        subprocess.run(
            [sys.executable, "-c", slower], capture_output=True, text=True, check=True
        ).stdout
        == "False\n"
    )


@pytest.mark.parametrize("damage", [b"not a library", pytest.param(b"", marks=pytest.mark.slow)])
def test_a_damaged_library_or_record_is_built_again(damage):
    model, x = br.friction.coulomb_viscous(F_C=12.5, F_v=3.0), walk(5)
    library = CompiledWalk(model).library
    record = next(
        place for place in library.parent.glob("walk-*.json") if library.name in place.read_text()
    )
    for file in (library, record):
        file.unlink()  # a loaded library must not change
        file.write_bytes(damage)
        compiled = CompiledWalk(model)
        _, force = run(compiled, "walk", 1, 5, inputs_of(compiled, x), [compiled.start, x])
        assert differing(force[1:], force_along(model, np.diff(x) / DT, DT, x[1:])) == 0


def test_each_value_and_each_function_of_a_model_has_a_key():
    # A component of another function, which cannot be registered.
    changed = object.__new__(type(LUGRE.component))
    vars(changed).update(vars(LUGRE.component) | {"trial": LUGRE.component.commit})
    others = [
        LUGRE.with_values(F_C=21.0),
        replace(LUGRE, kind="rotational"),
        replace(LUGRE, component=changed),
    ]
    assert len({_key(model) for model in (LUGRE, *others)}) == 4

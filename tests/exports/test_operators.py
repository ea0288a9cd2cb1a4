"""Hysteresis operators in C and Structured Text: the bits of bristle, and what an inverse does without an output."""

import numpy as np
import pytest
from tests.exports.native import COMPILER, Native, differing, in_structured_text, selected_cases, texts_of
from tests.hysteresis.paths import OPERATORS, sized, walk

import bristle as br

pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")


@pytest.fixture(scope="module")
def native(request, tmp_path_factory):
    names = {name for (name,) in selected_cases(request, "name")} | {"inverse_preisach"}
    models = {name.replace(" ", "_"): OPERATORS[name] for name in names}
    return Native(models, tmp_path_factory.mktemp("operators"))


@pytest.mark.fast_cases(5)
@pytest.mark.parametrize("name", OPERATORS)
def test_outputs_are_identical_to_bristle(native, name):
    u = sized(OPERATORS[name], walk(7, count=4000))
    outputs = br.response(OPERATORS[name], u)
    assert np.ptp(outputs) > 0.0
    assert differing(native.forces(name.replace(" ", "_"), u, 0.0), outputs) == 0


def test_an_inverse_without_an_output_repeats_the_last_output(native):
    operator = OPERATORS["inverse_preisach"]
    f_p = operator.values["f_p"]
    fixed = native.forces("inverse_preisach", [0.5 * f_p, 2.0 * f_p, 0.25 * f_p], 0.0)
    expected = br.response(operator, [0.5 * f_p, 0.25 * f_p])
    assert fixed.tolist() == [expected[0], expected[0], expected[1]]


@pytest.fixture(scope="module")
def blocks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blocks")
    names = {values: f"op_{values}".replace(" ", "_") for values in OPERATORS}
    return in_structured_text({name: texts_of(OPERATORS[values], folder, name) for values, name in names.items()}, folder)


@pytest.mark.slow
@pytest.mark.parametrize("name", OPERATORS)
def test_structured_text_is_identical(blocks, name):
    u, block = sized(OPERATORS[name], walk(7, count=4000)), f"op_{name}".replace(" ", "_")
    assert differing(blocks.run(block, excitation=u)[0], br.response(OPERATORS[name], u)) == 0
    assert blocks.selftest(block) == (True, True)


@pytest.mark.slow
def test_structured_text_repeats_the_last_output_of_an_inverse(blocks):
    operator = OPERATORS["inverse_preisach"]
    f_p = operator.values["f_p"]
    fixed, flags = blocks.run("op_inverse_preisach", excitation=[0.5 * f_p, 2.0 * f_p, 0.25 * f_p])
    expected = br.response(operator, [0.5 * f_p, 0.25 * f_p])
    assert fixed.tolist() == [expected[0], expected[0], expected[1]]
    assert flags.tolist() == [0, 2, 2]

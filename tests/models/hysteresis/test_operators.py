"""What every operator owes: pure trials, the same bits compiled, no time, no trace of what is wiped out."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from tests.models.hysteresis.paths import OPERATORS, along, sized, walk

from bristle import response
from bristle.engine import interpreted
from bristle.engine.path import after, output_along

every_operator = pytest.mark.parametrize("operator", OPERATORS.values(), ids=OPERATORS)
# Turns on a lattice: two of them are the same or far apart, as those of a measured path.
turns = st.lists(st.integers(-300, 300).map(lambda n: n / 100.0), min_size=1, max_size=8)


def assert_close(a, b, scale):
    assert np.max(np.abs(np.asarray(a) - np.asarray(b))) <= 1e-13 * (np.max(np.abs(scale)) + 1e-300)


@every_operator
def test_a_thousand_trials_do_not_change_the_memory(operator):
    state, memory = after(operator, sized(operator, walk(1, 300)))
    before, trial = memory.tobytes(), operator.component.trial
    first = trial(state, memory, 0.3, operator.parameters)
    for u in sized(operator, walk(2, 1000)).tolist():
        trial(state, memory, u, operator.parameters)
        assert memory.tobytes() == before
    assert trial(state, memory, 0.3, operator.parameters) == first


@every_operator
def test_plain_python_and_compiled_give_the_same_bits(operator):
    path = sized(operator, walk(3, 500))
    compiled = response(operator, path)
    with interpreted():
        assert np.array_equal(response(operator, path), compiled)


@every_operator
@settings(max_examples=10, deadline=None)
@given(path=turns, share=st.floats(0.01, 0.99))
def test_the_output_does_not_depend_on_the_density_of_inputs(operator, path, share):
    turned = sized(operator, np.array([0.0, *path]))
    between = turned[:-1] + share * np.diff(turned)
    dense = np.column_stack([between, turned[1:]]).ravel()
    sparse = response(operator, turned[1:])
    assert_close(
        response(operator, dense)[1::2], sparse, [sparse, np.ones_like(sparse) * np.ptp(sparse)]
    )


@every_operator
@settings(max_examples=10, deadline=None)
@given(inside=turns)
def test_a_closing_loop_wipes_out_its_inner_history(operator, inside):
    # 3.5 and -3.2 enclose all that happens inside; both are reached again before 3.8.
    end = [-3.2, 3.5, 3.8, 0.4]
    plain = response(operator, sized(operator, np.array([3.5, *end])))[-3:]
    detour = response(operator, sized(operator, np.array([3.5, -3.2, *inside, *end])))[-3:]
    assert_close(plain, detour, plain)


@every_operator
@settings(max_examples=10, deadline=None)
@given(before=turns)
def test_minor_loops_between_the_same_inputs_are_congruent(operator, before):
    # Whatever came before, a loop between the same inputs has the same shape, but for its height.
    loop = sized(operator, along([0.5, 1.0, 0.5, 1.0], 4))
    whole = sized(operator, np.array([3.5, *before]))
    item = response(operator, loop, history=sized(operator, np.array([3.5, -3.5])))[4:]
    other = response(operator, loop, history=whole)[4:]
    assert_close(item - item[0], other - other[0], item)


@every_operator
def test_a_history_is_the_path_before(operator):
    path = sized(operator, walk(4, 200))
    whole = response(operator, path)
    assert np.array_equal(response(operator, path[120:], history=path[:120]), whole[120:])
    state, memory = after(operator, path[:120])
    assert np.array_equal(
        output_along(operator, path[120:], state=state, memory=memory), whole[120:]
    )


@every_operator
def test_every_output_has_its_sample(operator):
    assert response(operator, [0.0]).shape == (1,)
    path = sized(operator, walk(5, 100))
    assert response(operator, path).shape == path.shape
    standing = np.repeat(path, 3)
    assert np.array_equal(response(operator, standing)[::3], response(operator, path))

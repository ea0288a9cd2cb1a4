"""An operator with a constant beside it: the same loops, higher, in Python and in C."""

import copy
import pickle

import numpy as np
import pytest
from tests.exports.native import COMPILER, Native

import bristle as br
from bristle.models.hysteresis.beside_constant import with_constant

STOPS = br.hysteresis.prandtl_ishlinskii(thresholds=[1e-6, 3e-6], weights=[4e6, 2e6])
CLOSED = br.hysteresis.preisach(s=1e7, f_p=20.0)
PATH = np.cumsum(np.random.default_rng(3).normal(0.0, 1e-6, 400))


@pytest.mark.parametrize("operator", [STOPS, CLOSED])
def test_its_loops_are_higher_by_the_constant(operator):
    raised = with_constant(operator, 1.5)
    with br.engine.interpreted():
        np.testing.assert_allclose(
            br.response(raised, PATH) - br.response(operator, PATH), 1.5, rtol=1e-12
        )
    assert raised.values["offset"] == 1.5
    assert with_constant(operator, 0.0) is operator
    assert pickle.loads(pickle.dumps(raised)) == raised
    assert copy.deepcopy(raised).component is raised.component


def test_an_operator_with_an_offset_takes_the_constant_there():
    grid = br.hysteresis.preisach_grid(
        low=-1e-5, high=1e-5, E=[0.0, 1.0, 2.0, 0.0, 1.0, 0.0], offset=1.0
    )
    raised = with_constant(grid, 0.5)
    assert raised.component is grid.component
    assert raised.values["offset"] == 1.5


@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
def test_c_has_the_constant_to_the_bit(tmp_path):
    models = {"stops": with_constant(STOPS, 1.5), "closed": with_constant(CLOSED, -2.5)}
    native = Native(models, tmp_path)
    with br.engine.interpreted():
        for name, model in models.items():
            assert native.forces(name, PATH, 1e-3).tolist() == br.response(model, PATH).tolist()

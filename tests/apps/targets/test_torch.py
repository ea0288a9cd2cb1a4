"""The example with PyTorch: its force and its gradients."""

import numpy as np
import pytest
from tests.examples.data import loaded
from tests.exports.native import COMPILER, walk

import bristle as br
from bristle.exports import CompiledWalk

torch = pytest.importorskip("torch")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
VALUES = {
    "F_C": "20 N",
    "F_S": "28 N",
    "v_S": "2 mm/s",
    "sigma_0": "10 N/um",
    "sigma_1": "1 kN*s/m",
    "v_d": "2 mm/s",
}
LUGRE = br.friction.lugre(**VALUES)
WARM = br.friction.find("lugre+temperature")(**VALUES, k_T=0.01)


def tensor(values):
    return torch.tensor(values, dtype=torch.float64, requires_grad=True)


@pytest.fixture(params=[LUGRE, WARM])
def force(request):
    """The function of the example for a model, of positions, time step and shares of the parameters."""
    compiled = CompiledWalk(request.param)
    numbers = torch.tensor(np.concatenate(list(compiled.parameters.values())))
    function = loaded("torch_friction.py").force
    return lambda x, dt, shares: function(compiled, x, dt, numbers * shares)


def test_the_force_of_several_axes_is_that_of_bristle(force):
    x = np.stack([walk(60), 0.5 * walk(60)])
    found = force(tensor(x), tensor([1e-3]), tensor(1.0)).detach().numpy()
    for row, path in zip(found, x, strict=True):
        assert np.array_equal(
            row[1:], br.engine.force_along(LUGRE, np.diff(path) / 1e-3, 1e-3, path[1:])
        )


# Sympy, with the newest mpmath.
@pytest.mark.filterwarnings("ignore:.*is deprecated:DeprecationWarning")
def test_gradcheck_accepts_positions_time_step_and_parameters(force):
    x = tensor(np.stack([10.0 * np.sin(0.3 * np.arange(1, 9)), 4.0 * np.cos(0.2 * np.arange(8))]))
    scaled = lambda x, dt, shares: force(1e-6 * x, 1e-3 * dt, shares)  # noqa: E731
    assert torch.autograd.gradcheck(scaled, (x, tensor([1.0]), tensor(1.0)), eps=1e-5, atol=1e-5)

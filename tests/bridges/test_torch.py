"""Friction in PyTorch: its gradients."""

import numpy as np
import pytest
from tests.exports.native import COMPILER, walk

import bristle as br
from bristle.core.errors import InputError
from bristle.engine import force_along

torch = pytest.importorskip("torch")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 1e-3
LUGRE = br.friction.lugre(F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m", v_d="2 mm/s")


@pytest.fixture
def friction():
    from bristle.bridges.torch import Friction

    return Friction(LUGRE)


def tensor(values):
    return torch.tensor(values, dtype=torch.float64, requires_grad=True)


def test_the_force_is_that_of_bristle(friction):
    x = walk(60)
    state, force = friction.walk(friction.start(), x, DT)
    assert np.array_equal(force[1:].numpy(), force_along(LUGRE, np.diff(x) / DT, DT, x[1:]))
    assert state[:3].tolist() == [x[-1], force[-1].item(), 1.0]


@pytest.mark.filterwarnings("ignore:.*is deprecated:DeprecationWarning")  # sympy, with the newest mpmath
def test_gradcheck_accepts_walks_and_steps_of_several_lanes(friction):
    x = tensor(np.stack([10.0 * np.sin(0.3 * np.arange(1, 9)), 4.0 * np.cos(0.2 * np.arange(8))]))

    def walked(x, F_C, sigma_0, dt):
        return friction.walk(friction.start(), 1e-6 * x, DT * dt, {"F_C": 20.0 * F_C, "sigma_0": 1e7 * sigma_0})

    def stepped(x, F_C):
        state = friction.start()
        for k in range(4):
            state, force = friction.force(state, 1e-6 * x[:, k], DT, {"F_C": 20.0 * F_C})
        return force, 1e6 * state[..., 3]

    assert torch.autograd.gradcheck(lambda *p: walked(*p)[1], (x, tensor([1.0, 1.1]), tensor(1.0), tensor(1.0)), eps=1e-5, atol=1e-5)
    assert torch.autograd.gradcheck(stepped, (x, tensor(1.0)), eps=1e-5, atol=1e-5)


def test_gradients_are_those_of_jax(friction):
    jax = pytest.importorskip("jax")
    from bristle.bridges.jax import Friction

    x, F_C = walk(100), tensor(20.0)
    (friction.walk(friction.start(), x, DT, {"F_C": F_C})[1] ** 2).sum().backward()
    with jax.enable_x64(True):
        same = Friction(LUGRE)
        found = jax.grad(lambda F_C: (same.walk(same.start(), x, DT, {"F_C": F_C})[1] ** 2).sum())(20.0)
    assert F_C.grad.item() == pytest.approx(float(found), rel=1e-14)


def test_single_precision_is_refused_by_name(friction):
    with pytest.raises(InputError, match=r"state: must be of double precision on the CPU; found .*torch.float32 on cpu"):
        friction.walk(friction.start().float(), walk(5), DT)

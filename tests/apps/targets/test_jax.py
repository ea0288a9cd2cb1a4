"""Friction in JAX: its derivatives under the transformations of JAX."""

import doctest
import re

import numpy as np
import pytest
from tests.docs.conftest import blocks
from tests.exports.native import COMPILER, example_with, walk

import bristle as br
from bristle.core.errors import InputError

jax = pytest.importorskip("jax")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
DT = 1e-3
LUGRE = br.friction.lugre(
    F_C="20 N", F_S="28 N", v_S="2 mm/s", sigma_0="10 N/um", sigma_1="1 kN*s/m", v_d="2 mm/s"
)


@pytest.fixture(autouse=True)
def double():
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


@pytest.fixture
def friction():
    from bristle.apps.targets.jax import Friction

    return Friction(LUGRE)


def cost(friction, x, **beside):
    """Return a function of parameters: a sum over the force of a walk."""
    return lambda p: jax.numpy.sum(friction.walk(friction.start(), x, DT, p, **beside)[1] ** 2)


def test_the_force_under_jit_is_that_of_bristle(friction):
    x = walk(60)
    state, force = jax.jit(friction.walk)(friction.start(), x, DT)
    assert np.array_equal(force[1:], br.engine.force_along(LUGRE, np.diff(x) / DT, DT, x[1:]))
    assert state[:3].tolist() == [x[-1], force[-1], 1.0]


def test_forward_and_reverse_mode_agree_with_differences(friction):
    x, p = 1e-5 * np.sin(0.3 * np.arange(50)), friction.parameters
    forward, reverse = (of(cost(friction, x))(p) for of in (jax.jacfwd, jax.grad))
    for name, value in p.items():
        near = [
            float(cost(friction, x)(p | {name: value * (1.0 + step)})) for step in (-1e-5, 1e-5)
        ]
        assert float(forward[name]) == pytest.approx(float(reverse[name]), rel=1e-12)
        assert float(reverse[name]) * value == pytest.approx(
            (near[1] - near[0]) / 2e-5, rel=1e-6, abs=1e-4
        )


def test_a_scan_over_steps_has_the_gradient_of_the_walk(friction):
    x, signs = walk(40), jax.numpy.asarray(np.random.default_rng(1).standard_normal(40))

    def scanned(p, x):
        _, force = jax.lax.scan(
            lambda state, at: friction.force(state, at, DT, p), friction.start(), x
        )
        return signs @ force

    def walked(p, x):
        return signs @ friction.walk(friction.start(), x, DT, p)[1]

    found, expected = (
        jax.jit(jax.grad(of, argnums=(0, 1)))(friction.parameters, x) for of in (scanned, walked)
    )
    for first, second in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert np.abs(first - second).max() <= 1e-12 * np.abs(second).max()


def test_lanes_by_vmap_and_by_shape_are_walks_of_their_own(friction):
    walks = np.stack([walk(30, seed) for seed in (1, 2, 3)])
    levels = np.array([19.0, 20.0, 21.0])

    def of_lane(F_C, x):
        return cost(friction, x)({"F_C": F_C})

    alone = [jax.value_and_grad(of_lane)(level, x) for level, x in zip(levels, walks, strict=True)]
    values, slopes = jax.vmap(jax.value_and_grad(of_lane))(levels, walks)
    assert np.array_equal(values, [value for value, _ in alone])
    assert np.array_equal(slopes, [slope for _, slope in alone])
    together = jax.grad(lambda levels: cost(friction, walks)({"F_C": levels}))(levels)
    assert np.array_equal(together, slopes)
    assert jax.vmap(jax.jacfwd(of_lane), (0, None))(levels, walks[0]).shape == (3,)


def test_signals_and_the_time_step_are_differentiable():
    from bristle.apps.targets.jax import Friction

    model = Friction(example_with("lugre", ("load", "temperature")))
    x, load = 1e-5 * np.sin(0.3 * np.arange(50)), np.linspace(0.8, 1.4, 50)

    def value(load, dt):
        return jax.numpy.sum(model.walk(model.start(), x, dt, load=load)[1] ** 2)

    of_load, of_dt = jax.grad(value, argnums=(0, 1))(load, DT)
    turn = np.cos(np.arange(50))
    _, forward = jax.jvp(value, (load, DT), (turn, 0.5 * DT))
    assert float(forward) == pytest.approx(float(of_load @ turn + 0.5 * DT * of_dt), rel=1e-10)
    near = [float(value(load + step * turn, DT * (1.0 + 0.5 * step))) for step in (-1e-6, 1e-6)]
    assert float(forward) == pytest.approx((near[1] - near[0]) / 2e-6, rel=1e-5)


def test_single_precision_is_refused_by_name(friction):
    with pytest.raises(
        InputError, match=r"x: must be of double precision; found 'float32'.*jax_enable_x64"
    ):
        friction.walk(friction.start(), np.zeros(3, np.float32), DT)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"parameters": {"F_c": 2.0}}, "parameters: no such name; found 'F_c'"),
        ({"load": 1.0}, "signals: no such name; found 'load', allowed no signals"),
        ({"parameters": np.ones(3)}, "parameters: has a wrong shape; found (3,), allowed (..., 7)"),
        ({"state": np.zeros(2)}, "state: has a wrong shape; found (2,), allowed (..., 4)"),
    ],
)
def test_a_wrong_argument_is_refused_by_name(friction, arguments, text):
    usual = {"state": friction.start(), "x": np.zeros(3), "dt": DT}
    with pytest.raises(InputError, match=re.escape(text)):
        friction.walk(**(usual | arguments))


def test_the_example_of_the_page_runs():
    (block,) = blocks("py")
    session = doctest.DocTestParser().get_doctest(
        block.text, {"np": np, "br": br}, block.name, str(block.page), block.line
    )
    assert len(session.examples) > 5
    assert doctest.DocTestRunner().run(session).failed == 0

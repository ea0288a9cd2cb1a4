"""Dynamic parameters beside friction with memory: the right values, honest intervals, and bodies that can exist."""

from __future__ import annotations

import numpy as np
import pytest
from tests.apps.arm.conftest import DT, GRAVITY, Pendulum, motion_with, swing

from bristle import friction
from bristle.apps.arm.files import centred
from bristle.apps.arm.motion import stops
from bristle.apps.arm.parameters import _half_widths, base_of, identify_dynamics, pseudo_inertia
from bristle.engine.motion import along

TRUE = {"I_zz": 2.0, "mc_x": 3.0, "mc_y": -1.0}
LUGRE = friction.lugre(F_C=8.0, F_S=11.0, v_S=0.05, sigma_0=4e4, sigma_1=30.0, sigma_2=4.0)


def effort_of(q, v, a, seed=0, noise=0.3):
    x = np.ascontiguousarray(q[:, 0] + 0.5 * DT * v[:, 0])
    force = along(
        LUGRE.model if hasattr(LUGRE, "model") else LUGRE,
        dt=DT,
        v=np.ascontiguousarray(v[:, 0]),
        x=x,
    )
    weight = GRAVITY * (TRUE["mc_x"] * np.sin(q[:, 0]) + TRUE["mc_y"] * np.cos(q[:, 0]))
    total = TRUE["I_zz"] * a[:, 0] + weight + force
    return (total + noise * np.random.default_rng(seed).normal(size=len(q)))[:, None]


@pytest.fixture(scope="module")
def estimated():
    t, q, v, a = swing(1, 60.0)
    return identify_dynamics(Pendulum(), motion_with(effort_of(q, v, a), t, q, v, a))


def test_gravity_and_inertia_are_found_beside_friction(estimated):
    values = {entry.name: entry for entry in estimated.base}
    assert set(values) == {"hinge.J", "hinge.mc_x", "hinge.mc_y"}
    for name, true in (("hinge.J", 2.0), ("hinge.mc_x", 3.0), ("hinge.mc_y", -1.0)):
        assert abs(values[name].value - true) < 1.5 * values[name].half_width < 0.3
    assert estimated.rotors_in_sums == {"hinge"}
    assert dict(values["hinge.J"].members) == pytest.approx({"hinge.J": 1.0, "hinge.I_zz": 1.0})


def repeated(periods):
    """Return the half-widths of a motion of 5 s that repeats, with an effort that no column explains."""
    t = np.arange(0.0, 5.0 * periods, DT)
    q, v, a = (np.zeros((t.size, 1)) for _ in range(3))
    for size, w in ((0.5, 0.4 * np.pi), (0.3, 1.2 * np.pi), (0.1, 2.0 * np.pi)):
        q[:, 0] += size * np.sin(w * t + w)
        v[:, 0] += size * w * np.cos(w * t + w)
        a[:, 0] -= size * w**2 * np.sin(w * t + w)
    effort = (
        effort_of(q, v, a, noise=0.01) + 0.5 * np.sin(25.0 * q) + 0.3 * np.abs(v) * np.sin(12.0 * q)
    )
    motion = motion_with(effort, t, q, v, a)
    assert motion.period == pytest.approx(5.0, abs=4 * DT)
    return np.array([entry.half_width for entry in identify_dynamics(Pendulum(), motion).base])


def test_errors_of_the_model_repeat_with_the_motion_and_more_periods_do_not_narrow_the_intervals():
    np.testing.assert_allclose(repeated(16), repeated(4), rtol=0.1)


def test_a_motion_with_one_free_joint_has_no_period():
    t, q, v, a = swing(2, 60.0)
    assert motion_with(q, t, q, v, a).period is None
    wave = np.sin(0.4 * np.pi * t)
    one = np.column_stack([wave, q[:, 0]])
    assert motion_with(one, t, one, one, one).period is None
    both = np.column_stack([wave, np.sin(0.8 * np.pi * t)])
    assert motion_with(both, t, both, both, both).period == pytest.approx(5.0, abs=4 * DT)


def test_half_widths_are_the_scatter_of_estimates_without_one_block():
    rng = np.random.default_rng(0)
    friction, columns, effort = (
        rng.normal(size=(60, 4)),
        rng.normal(size=(60, 1, 3)),
        rng.normal(size=(60, 1)),
    )
    friction = np.linalg.qr(friction)[0]
    blocks = np.array_split(rng.permutation(60), 12)
    design = np.hstack([friction, columns[:, 0]])
    kept = [np.setdiff1d(np.arange(60), block) for block in blocks]
    estimates = np.array(
        [np.linalg.lstsq(design[rows], effort[rows, 0], rcond=None)[0][4:] for rows in kept]
    )
    whole = np.linalg.lstsq(design, effort[:, 0], rcond=None)[0][4:]
    apart = columns - np.einsum(
        "nk,kjp->njp", friction, np.einsum("nk,njp->kjp", friction, columns)
    )
    residual = effort - friction @ (friction.T @ effort) - apart @ whole
    # Student, 11 degrees of freedom.
    expected = 2.2009852 * np.sqrt(11 / 12 * np.sum((estimates - whole) ** 2, axis=0))
    np.testing.assert_allclose(
        _half_widths(apart, residual, [friction], blocks), expected, rtol=1e-6
    )


def test_bodies_have_positive_mass_and_explain_the_efforts(estimated):
    body = estimated.bodies[0]
    assert np.linalg.eigvalsh(pseudo_inertia(body))[0] > 0.0
    assert body[1:3] == pytest.approx([3.0, -1.0], abs=0.15)
    assert body[9] + estimated.rotors[0] == pytest.approx(2.0, abs=0.1)
    assert estimated.errors[0] < 0.05


def test_a_link_without_mass_is_no_body_of_the_prior(estimated):
    # The link is too light for its moment: the mass must grow to hold the centre of mass within its moments of inertia.
    t, q, v, a = swing(1, 30.0)
    light = identify_dynamics(
        Pendulum(mass=1e-3), motion_with(effort_of(q, v, a), t, q, v, a)
    ).bodies[0]
    assert light[0] * light[9] > light[1] ** 2 + light[2] ** 2


def test_base_parameters_do_not_depend_on_the_order_of_magnitude_of_a_motion():
    places, factors = base_of(Pendulum())
    assert places == [0, 2, 3]
    assert factors.shape == (3, 11)
    assert np.count_nonzero(factors) == 4


def test_elements_slip_at_their_distance_and_remember():
    x = np.array([0.0, 0.5, 2.0, 1.5, 0.0, 0.0])[:, None].ravel()
    force = stops(x, np.array([1.0, 2.0]))
    assert force[:, 0].tolist() == [0.0, 0.5, 1.0, 0.5, -1.0, -1.0]
    assert force[:, 1].tolist() == [0.0, 0.25, 1.0, 0.75, 0.0, 0.0]


def test_a_point_mass_has_no_inertia_about_its_centre():
    mass, (x, y, z) = 2.0, (0.3, -0.2, 0.5)
    about = [
        mass * moment
        for moment in (y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y)
    ]
    of_body, centre, inertia = centred(np.array([mass, mass * x, mass * y, mass * z, *about]))
    assert of_body == mass
    np.testing.assert_allclose(centre, (x, y, z))
    np.testing.assert_allclose(inertia, np.zeros((3, 3)), atol=1e-15)

"""Poles and margins of sampled loops: published figures, another implementation, and what the simulation does."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from tests.apps.design.laws import rig

from bristle import controllers, friction, plants, references
from bristle.apps.design import Verdict, assess, runnable
from bristle.core.experiment import Experiment, Run
from bristle.engine import interpreted, run_closed_loop
from bristle.engine.contact import steady_force
from bristle.models.sensors import encoder
from bristle.report.messages import message
from bristle.simulation.assessment import Friction, Motions
from bristle.simulation.linear_system import (
    LinearSystem,
    SampledLoop,
    margins_of,
    slope_in_sliding,
    stiffness_at_rest,
)


def travelling(**parts):
    """The loop of an axis that travels."""
    reference = references.sine(amplitude=1e-3, frequency=0.25)
    return replace(
        rig(0),
        **(
            {"friction": friction.coulomb(F_C=1.0), "sensor": encoder(), "reference": reference}
            | parts
        ),
    )


def point(assessment, motions, under=Friction.NONE):
    return next(
        item for item in assessment.points if item.motions is motions and item.friction is under
    )


@pytest.mark.parametrize(
    ("delay", "outside", "inside", "radius"),
    [
        (0, 41.5, 30.8, 0.886),
        (1, 21.1, 3.6, 0.986),
        (2, 0.8, -23.5, 1.062),
        (3, -19.5, -50.6, 1.096),
    ],
)
def test_margins_of_the_paper_s_loop_outside_and_inside_the_boundary_layer(
    delay, outside, inside, radius
):
    result = assess(rig(delay))
    assert point(result, Motions.LARGE).margins.phase == pytest.approx(outside, abs=1.0)
    assert point(result, Motions.SMALL).margins.phase == pytest.approx(inside, abs=1.0)
    assert point(result, Motions.SMALL).loop.spectral_radius == pytest.approx(radius, abs=1e-3)


def test_the_gain_that_is_named_is_the_largest_that_is_stable():
    share = (
        float(message(assess(rig(3)).finding).rpartition("gains lowered to ")[2].partition(" %")[0])
        / 100.0
    )
    for factor, verdict in ((0.95 * share, Verdict.STABLE), (1.05 * share, Verdict.OSCILLATES)):
        weaker = rig(3)
        law = weaker.controller.with_values(J=factor * 4e-4)
        assert assess(replace(weaker, controller=law)).verdict is verdict


def test_a_law_without_a_boundary_layer_switches():
    result = assess(rig(0, layer=0.0))
    assert result.switches
    assert {item.motions for item in result.points} == {Motions.LARGE}


def test_terms_that_fade_with_amplitude_are_absent_at_large_motions():
    proportional = {
        "kind": "rotational",
        "J": 4e-4,
        "lambda_": 300.0,
        "K_1": 200.0,
        "cutoff": 400.0,
    }
    twisting = controllers.super_twisting(k_1=1e-3, k_2=0.2, **proportional)
    plain = controllers.sliding_mode(**proportional)
    result, expected = (assess(replace(rig(1), controller=item)) for item in (twisting, plain))
    assert result.switches
    assert not expected.switches
    bare, linear = result.bare[0].loop, expected.bare[0].loop
    assert bare.spectral_radius == pytest.approx(linear.spectral_radius, rel=1e-6)


def test_a_linear_law_has_one_loop():
    result = assess(rig(0, switching=0.0))
    assert {item.motions for item in result.points} == {Motions.ALL}


def test_the_limit_of_the_drive_does_not_change_the_loop():
    assert assess(rig(1, limit=1e-9)).worst.loop.poles == pytest.approx(
        assess(rig(1)).worst.loop.poles, rel=1e-9
    )


# --- against another implementation -----------------------------------------------------------------------------


def by_transfer_functions(k_p, k_v, mass, dt, delay):
    """Return the open loop of a cascade without integral, on a mass, as one transfer function in z."""
    plant, denominator, _ = signal.cont2discrete(([1.0], [mass, 0.0, 0.0]), dt)
    # u = k_v (k_p q + (q - q z^-1)/dt)
    law = np.array([k_v * (k_p + 1.0 / dt), -k_v / dt])
    return np.polymul(plant[0], law), np.polymul(denominator, np.r_[1.0, np.zeros(1 + delay)])


@pytest.mark.parametrize(("k_v", "delay"), [(3000.0, 0), (3000.0, 2), (9000.0, 1)])
def test_a_cascade_agrees_with_its_transfer_function(k_v, delay):
    dt, mass, k_p = 1e-3, 30.0, 40.0
    law = controllers.cascade(k_p=k_p, k_v=k_v)
    variant = travelling(
        plant=plants.inertia(M=mass), controller=law, run=Run(8.0, dt, delay=delay)
    )
    result = assess(variant).bare[0]
    over, under = by_transfer_functions(k_p, k_v, mass, dt, delay)
    expected = np.roots(np.polyadd(under, over))
    assert np.sort(np.abs(result.loop.poles))[-3:] == pytest.approx(
        np.sort(np.abs(expected))[-3:], rel=1e-7
    )
    omega = np.geomspace(0.1, np.pi / dt, 200_001)
    z = np.exp(1j * omega * dt)
    response = np.polyval(over, z) / np.polyval(under, z)
    at = np.flatnonzero(np.diff(np.sign(np.abs(response) - 1.0)))[-1]
    assert result.margins.crossover == pytest.approx(omega[at], rel=1e-3)
    assert result.margins.phase == pytest.approx(
        180.0 + np.degrees(np.angle(response[at])), abs=0.05
    )
    largest = [
        np.max(np.abs(np.roots(np.polyadd(under, g * result.margins.gain * over))))
        for g in (0.99, 1.0, 1.01)
    ]
    assert largest[1] == pytest.approx(1.0, abs=1e-6)
    assert largest[0] < 1.0 < largest[2]
    assert result.margins.sensitivity == pytest.approx(
        np.max(1.0 / np.abs(1.0 + response)), rel=1e-3
    )


# --- against the simulation -------------------------------------------------------------------------------------


def positions_of(loop, body, count):
    """The positions of a linear loop with a cascade, whose plant begins displaced and at rest."""
    moved = loop.plant.C @ body
    state, line, positions = np.array([moved, moved, 0.0, 0.0, 0.0]), [0.0] * loop.delay, []
    for _ in range(count):
        positions.append(loop.plant.C @ body)
        line.append(loop.law.C @ state + loop.law.D * positions[-1])
        state = loop.law.A @ state + loop.law.B * positions[-1]
        body = loop.plant.A @ body + loop.plant.B * line.pop(0)
    return np.array(positions)


@interpreted()
@pytest.mark.parametrize(
    ("k_v", "k_i", "delay"), [(3000.0, 0.0, 1), (3000.0, 4e4, 0), (15000.0, 0.0, 2)]
)
def test_the_linear_loop_goes_where_the_simulation_goes(k_v, k_i, delay):
    law, mass, moved = controllers.cascade(k_p=40.0, k_v=k_v, k_i=k_i), plants.inertia(M=30.0), 1e-3
    film = friction.viscous(F_v=50.0)
    variant = travelling(plant=mass, friction=film, controller=law, run=Run(1.0, 1e-3, delay=delay))
    loop = point(assess(variant), Motions.ALL, Friction.SLIDING).loop
    trace = run_closed_loop(
        mass, film, law, encoder(), np.zeros((4, 120)), 1e-3, steps=4, delay=delay, x=moved
    )
    assert positions_of(loop, np.eye(loop.plant.B.size)[0] * moved, 120) == pytest.approx(
        trace.position, rel=1e-6, abs=1e-6 * moved
    )


@interpreted()
@pytest.mark.parametrize("side", ["motor", "load"])
def test_a_table_behind_a_screw_goes_where_the_simulation_goes(side):
    screw = plants.ball_screw(kind="rotational", J=1e-4, M=20.0, lead=5e-3, k=1e7, d=200.0)
    film, guide = friction.viscous(kind="rotational", F_v=1e-3), friction.viscous(F_v=300.0)
    law, moved = controllers.cascade(kind="rotational", k_p=40.0, k_v=0.02), 1e-3
    variant = replace(
        rig(0),
        plant=screw,
        friction=film,
        table=guide,
        sensor_at=side,
        controller=law,
        run=Run(1.0, 5e-4, substeps=10, delay=1, current_lag=2e-4),
    )
    loop = point(assess(variant), Motions.ALL, Friction.SLIDING).loop
    trace = run_closed_loop(
        screw,
        film,
        law,
        encoder(kind="rotational"),
        np.zeros((4, 300)),
        5e-4,
        table=guide,
        sensor_at=side,
        steps=10,
        delay=1,
        lag=2e-4,
        x=moved,
    )
    seen = trace.position if side == "load" else trace.motor_position
    together = (np.eye(loop.plant.B.size)[0] + np.eye(loop.plant.B.size)[2]) * moved
    assert positions_of(loop, together, 300) == pytest.approx(seen, rel=1e-5, abs=1e-5 * moved)


def test_an_unexcited_mode_is_no_pole_of_the_loop():
    # The integral of a cascade without integral gain, and the far end of a spring that is pulled, both stay where they
    # are: poles at 1 that say nothing of the loop.
    law = controllers.cascade(k_p=40.0, k_v=3000.0)
    pulled = plants.pulled_inertia(M=30.0, k=0.0, v_e=1e-3)
    variants = [
        travelling(plant=variant, controller=law, run=Run(1.0, 1e-3))
        for variant in (plants.inertia(M=30.0), pulled)
    ]
    radii = [assess(variant).bare[0].loop.spectral_radius for variant in variants]
    assert radii[1] == pytest.approx(radii[0], rel=1e-6)
    assert radii[0] < 0.99


# --- friction ---------------------------------------------------------------------------------------------------

LUGRE = friction.lugre(
    kind="rotational", F_C=0.034, F_S=0.04, v_S=0.5, sigma_0=30.0, sigma_1=0.05, sigma_2=3e-3
)


def test_friction_is_a_spring_where_the_axis_is_stuck_and_a_damper_where_it_slides():
    result = assess(rig(0, model=LUGRE))
    stuck, free = (point(result, Motions.SMALL, item) for item in (Friction.STUCK, Friction.NONE))
    # The loop crosses over where inertia, spring and law balance: a spring more, a higher crossover.
    assert stuck.margins.crossover > 1.02 * free.margins.crossover
    sliding = point(result, Motions.LARGE, Friction.SLIDING)
    assert sliding.margins.phase > point(result, Motions.LARGE).margins.phase


def test_stiffness_and_damping_are_those_of_the_model():
    stuck = stiffness_at_rest(LUGRE, 5e-4)
    assert stuck.k == pytest.approx(30.0, rel=1e-6)
    assert stuck.c == pytest.approx(0.053, rel=1e-6)
    sliding = slope_in_sliding(LUGRE, 50.0)
    assert sliding.c == pytest.approx(3e-3, rel=1e-6)
    near = (steady_force(LUGRE, 0.3003) - steady_force(LUGRE, 0.2997)) / 0.0006
    assert slope_in_sliding(LUGRE, 0.3).c == pytest.approx(near, rel=0.01)
    assert near < 0.0
    assert stiffness_at_rest(friction.coulomb(kind="rotational", F_C=0.03), 5e-4) is None


@pytest.mark.parametrize("name", ["stribeck", "lugre", "gms", "preisach_lugre"])
def test_a_friction_model_has_a_linear_form_or_sticks(name):
    typical = friction.find(name)(**friction.find(name).example)
    stuck = stiffness_at_rest(typical, 1e-3)
    assert stuck is None or (stuck.k >= 0.0 and stuck.c >= 0.0)
    fast, slow = (
        0.5 * (steady_force(typical, v) - steady_force(typical, -v)) for v in (1.001, 0.999)
    )
    assert slope_in_sliding(typical, 1.0).c == pytest.approx(
        (fast - slow) / 0.002, rel=0.01, abs=1e-6 * abs(fast)
    )


def test_a_film_is_no_spring():
    stuck = stiffness_at_rest(friction.viscous(F_v=200.0), 1e-3)
    assert stuck.k == 0.0
    assert stuck.c == pytest.approx(200.0)
    assert {
        item.friction
        for item in assess(rig(0, model=friction.viscous(kind="rotational", F_v=1e-3))).points
    } == {Friction.NONE, Friction.SLIDING}


def test_an_offset_and_two_sides_are_no_slope():
    shifted = friction.find("lugre+asymmetry")(
        kind="rotational",
        F_C_pos=0.044,
        F_C_neg=0.024,
        F_S_pos=0.05,
        F_S_neg=0.03,
        v_S=0.5,
        sigma_0=30.0,
        sigma_1=0.05,
        offset=0.005,
    )
    assert stiffness_at_rest(shifted, 5e-4).k == pytest.approx(30.0, rel=1e-6)


def test_instability_by_friction_alone_is_stick_slip_and_simulated():
    weak = rig(0, slope=0.05, gain=0.05, switching=0.0, model=LUGRE)
    fast = replace(weak.reference, parameters=weak.reference.parameters._replace(amplitude=0.25))
    result = assess(replace(weak, reference=fast))
    assert result.verdict is Verdict.OSCILLATES
    assert "sticks and slips" in message(result.finding)


def test_variants_that_diverge_are_left_out():
    variants = tuple(replace(rig(delay), name=str(delay)) for delay in range(4))
    kept, judged = runnable(Experiment("delays", "rotational", variants))
    assert [variant.name for variant in kept.variants] == ["0", "1", "2"]
    verdicts = [Verdict.STABLE, Verdict.STABLE, Verdict.OSCILLATES, Verdict.DIVERGES]
    assert [judged[str(delay)].verdict for delay in range(4)] == verdicts


def loop_of(plant, gain, delay=0):
    """A plant under a law that answers the position by itself."""
    none = np.zeros(0)
    return SampledLoop(plant, LinearSystem(np.zeros((0, 0)), none, none, -gain), delay, 1e-3)


def test_a_stable_loop_has_a_positive_delay_margin():
    # A spring under a law that answers it the wrong way round, by less than the spring: above its resonance the
    # response crosses over from below -180 degrees. What is left of a turn is the delay that it stands.
    angle, faded = 0.5, 0.9
    spin = faded * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    spring = LinearSystem(spin, np.array([1.0, 0.0]), np.array([0.0, 1.0]), 0.0)
    result = 0
    for gain in np.linspace(-0.4, 0.4, 81):
        loop = loop_of(spring, gain)
        delay = margins_of(loop).delay
        if loop.is_unstable or delay is None:
            continue
        result += 1
        assert delay >= 0.0
        samples = math.floor(delay)
        assert not loop_of(spring, gain, samples).is_unstable
    assert result > 5

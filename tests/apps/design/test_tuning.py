"""How gains follow from a bandwidth, and how the widest bandwidth is found."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Annotated, NamedTuple

import pytest
from tests.apps.design.conftest import loop
from tests.apps.design.laws import RADIAN, rig

from bristle import controllers, friction, plants, references, sensors
from bristle.apps.design import Verdict
from bristle.core.contracts import Sensor
from bristle.core.experiment import Coupling, Feedforward, Run, Variant
from bristle.core.status import Status
from bristle.core.variable import Variable
from bristle.files import read_experiment, write_model
from bristle.simulation import tuning
from bristle.simulation.linear_system import DAMPED
from bristle.simulation.tuning import GAINS, inertia_of, lagging, with_known_motion


@pytest.mark.parametrize(
    ("value", "rounded"),
    [(123.4, 120.0), (0.0987, 0.098), (1.0, 1.0), (99.9, 99.0), (4567.0, 4500.0)],
)
def test_bandwidths_are_rounded_down_to_two_digits(value, rounded):
    assert tuning._rounded_down(value) == pytest.approx(rounded)


@pytest.mark.parametrize(
    ("limit", "most", "found"),
    [(123.4, None, 120.0), (777.0, None, 770.0), (123.4, 50.0, 49.0), (123.4, 60.0, 59.0)],
)
def test_the_widest_bandwidth_that_keeps_margins_is_found_from_above(limit, most, found):
    result = tuning._widest(lambda omega: omega <= limit, 1000.0, most)
    assert result == pytest.approx(found, rel=0.021)
    assert result <= min(limit, most or math.inf)


def test_no_bandwidth_is_found_if_all_violate_the_margins():
    tried = []
    assert tuning._widest(lambda omega: bool(tried.append(omega)), 1000.0, None) is None
    assert max(tried) == pytest.approx(3000.0 / 1.25)
    assert min(tried) == pytest.approx(0.1 / 1.25, rel=0.25)


class Gain(NamedTuple):
    gain: Annotated[float, Variable("1", "measured over moved")] = 1.0


UNCOUNTED = Sensor(
    name="exact",
    description="no counts",
    Parameters=Gain,
    State=Gain,
    step=lambda state, x, dt, p: (x, state),
)(kind="rotational")
LAYER = {"J": 4e-4, "lambda_": 340.0, "K_1": 340.0, "K_2": 1.0, "phi": 0.0, "cutoff": 400.0}
# Of a count in a sample that a low-pass lets through.
SHARE = 1.0 - math.exp(-2.0 * math.pi * 400.0 * 5e-4)
WIDTH = 0.125 * RADIAN * (300.0 + SHARE / 5e-4)


@pytest.mark.parametrize(
    ("name", "bandwidth", "law", "variant", "expected"),
    [
        ("cascade", 60.0, {}, loop(), {"k_v": 20.0 * 60.0, "k_p": 15.0, "k_i": 0.0}),
        (
            "cascade",
            60.0,
            {"k_i": 1.0},
            loop(),
            {"k_v": 20.0 * 60.0, "k_p": 15.0, "k_i": 20.0 * 60.0 * 6.0},
        ),
        # A surface alone has the bandwidth twice.
        ("sliding_mode", 60.0, {}, loop(), {"lambda_": 60.0, "K_1": 60.0}),
        ("disturbance_observer", 60.0, {}, loop(), {"lambda_": 60.0, "K_1": 60.0, "g": 12.0}),
        # A boundary layer contains the effect of a count; a wider one stays, and a sensor without counts needs none.
        (
            "sliding_mode",
            300.0,
            LAYER,
            rig(1),
            {"lambda_": 300.0, "K_1": 200.0, "phi": WIDTH, "K_2": 100.0 * WIDTH},
        ),
        (
            "sliding_mode",
            300.0,
            LAYER | {"phi": 1.0},
            rig(1),
            {"lambda_": 300.0, "K_1": 200.0, "phi": 1.0, "K_2": 100.0},
        ),
        (
            "sliding_mode",
            300.0,
            LAYER,
            replace(rig(1), sensor=sensors.encoder(kind="rotational")),
            {"phi": 0.0},
        ),
        ("sliding_mode", 300.0, LAYER, replace(rig(1), sensor=UNCOUNTED), {"phi": 0.0}),
    ],
)
def test_gains_follow_from_the_bandwidth(name, bandwidth, law, variant, expected):
    gains = GAINS[name](bandwidth, law, variant)
    assert {key: gains[key] for key in expected} == pytest.approx(expected, rel=0.02)
    assert "phi" in expected or set(gains) == set(expected)


def test_a_sensor_without_counts_calls_up_no_effort():
    assert tuning.count_response(replace(rig(1), sensor=UNCOUNTED)) == 0.0


@pytest.mark.parametrize(("stated", "tried"), [(0.0, {2e-4, 1e-3}), (7e-4, {7e-4, 1.2e-3})])
def test_gains_hold_for_lags_up_to_a_millisecond_or_half_a_millisecond_beyond_a_stated_lag(
    monkeypatch, stated, tried
):
    lags = set()
    monkeypatch.setattr(
        tuning, "lagging", lambda variant, lag: lags.add(round(lag, 9)) or lagging(variant, lag)
    )
    monkeypatch.setattr(tuning, "_widest", lambda keeps, rate, most: None)
    assert tuning.tuned(lagging(loop(), stated), "cascade") is None
    assert lags == tried


def test_a_loop_gets_velocity_and_inertia_feedforward():
    deaf = loop(
        controller=controllers.cascade(k_p=80.0, k_v=4000.0, k_ff=0.5),
        feedforward=replace(loop().feedforward, mass=10.0),
    )
    informed = with_known_motion(deaf)
    assert informed.controller.values["k_ff"] == 1.0
    assert informed.feedforward.mass == pytest.approx(20.0, rel=1e-3)
    near = loop(feedforward=replace(loop().feedforward, mass=20.1))
    assert with_known_motion(near) == near  # within a hundredth
    far = loop(feedforward=replace(loop().feedforward, mass=20.3))
    assert with_known_motion(far).feedforward.mass == pytest.approx(inertia_of(far))


def test_loops_that_are_proposed_have_their_names(monkeypatch):
    law = controllers.cascade(k_p=10.0, k_v=1000.0)
    requested = []

    def tuned(variant, name, bandwidth):
        requested.append((name, bandwidth))
        return tuning.Tuned(law, 42.0) if name == "cascade" else None

    monkeypatch.setattr(tuning, "tuned", tuned)
    loops, bandwidths = tuning._loops(loop(), 50.0)
    assert requested == [("cascade", 50.0), ("disturbance_observer", 50.0)]
    assert (list(loops), bandwidths) == (["as it is", "tuned"], {"tuned": 42.0})
    assert [each.name for each in loops.values()] == list(loops)
    assert loops["tuned"].controller.values["k_p"] == 10.0
    measured = loop(feedforward=replace(loop().feedforward, along="measured"))
    assert list(tuning._loops(measured, None)[0]) == [
        "as it is",
        "along the desired motion",
        "tuned",
    ]
    assert tuning._loops(measured, None)[0]["tuned"].feedforward.along == "desired"
    same = loop(controller=law)
    assert list(tuning._loops(same, None)[0]) == ["as it is"]
    observing = loop(
        controller=controllers.disturbance_observer(J=20.0, lambda_=100.0, K_1=100.0, g=20.0)
    )
    requested.clear()
    tuning._loops(observing, None)
    assert requested == [("disturbance_observer", None)]


def test_loops_that_would_not_diverge_are_simulated_twice_at_most(monkeypatch):
    ran, judged = [], []
    loops = {
        name: loop(name)
        for name in ("as it is", "along the desired motion", "tuned", "with an observer")
    }
    stated = replace(loops["with an observer"], run=replace(loop().run, current_lag=3e-4, seeds=5))
    loops["with an observer"] = stated

    def assessed(variant):
        judged.append((variant.name, variant.run.current_lag))
        verdict = Verdict.DIVERGES if variant.name == "along the desired motion" else Verdict.STABLE
        return SimpleNamespace(verdict=verdict, name=variant.name)

    def simulated(experiment, progress):
        ran.append([(each.name, each.run.seeds) for each in experiment.variants])
        bad = Status.NOT_FINITE
        outcomes = {
            each.name: SimpleNamespace(status=Status.OK, following_error=each.name, effort_rms=7.0)
            for each in experiment.variants
        }
        outcomes["tuned"].status = bad
        return SimpleNamespace(variants=outcomes)

    monkeypatch.setattr(tuning, "assess", assessed)
    monkeypatch.setattr(tuning, "simulate", simulated)
    monkeypatch.setattr(
        tuning,
        "_loops",
        lambda variant, bandwidth: (loops, {"tuned": 42.0, "with an observer": 30.0}),
    )
    present, desired, tuned, observing = tuning.proposals_for(
        loop(run=replace(loop().run, seeds=5))
    )
    assert [item.name for item in (present, desired, tuned, observing)] == list(loops)
    # Gains are judged with the largest lag that nobody stated, the loop as it is with none.
    assert dict(judged) == {
        "as it is": 0.0,
        "along the desired motion": 0.0,
        "tuned": 1e-3,
        "with an observer": 3e-4,
    }
    assert ran == [[("as it is", 2), ("tuned", 2), ("with an observer", 2)]]
    assert [item.following_error for item in (present, desired, tuned, observing)] == [
        "as it is",
        None,
        None,
        "with an observer",
    ]
    assert [item.effort_rms for item in (present, desired, tuned, observing)] == [
        7.0,
        None,
        None,
        7.0,
    ]
    assert [item.bandwidth for item in (present, desired, tuned, observing)] == [
        None,
        None,
        42.0,
        30.0,
    ]
    assert present.stiffness == pytest.approx(80.0 * 4000.0, rel=1e-6)
    assert present.count_effort == pytest.approx(4000.0 * (1e-3 + 80.0 * 1e-6), rel=1e-6)
    tuning.proposals_for(loop(), simulated=False)
    assert [name for name, _ in ran[-1]] == ["tuned", "with an observer"]


ARM = 10e-3 / (2.0 * math.pi)


def on_a_screw(antiresonance, load=150.0, motor=5e-4):
    """A loop on the motor of a table behind a screw, without integral and friction."""
    k = load * (2.0 * math.pi * antiresonance) ** 2
    damper = 2.0 * DAMPED * load * 2.0 * math.pi * antiresonance
    return Variant(
        name="screw",
        plant=plants.ball_screw(kind="rotational", J=motor, M=load, lead=10e-3, k=k, d=damper),
        friction=friction.viscous(kind="rotational", F_v=0.0),
        table=friction.viscous(F_v=0.0),
        controller=controllers.cascade(kind="rotational", k_p=1.0, k_v=1e-3, k_i=1e-3),
        sensor=sensors.encoder(kind="rotational"),
        sensor_at="motor",
        reference=references.sine(kind="rotational", amplitude=1.0, frequency=1.0),
        feedforward=Feedforward(),
        run=Run(1.0, 1e-3, delay=1, current_lag=5e-4),
    )


def as_one_mass(variant):
    """The same loop as one mass, with the coupling that an identification reports."""
    p = variant.plant.values
    load = p["M"] * ARM**2
    coupling = Coupling(math.sqrt(p["k"] / p["M"]) / (2.0 * math.pi), load / p["J"])
    return replace(
        variant,
        plant=plants.inertia(kind="rotational", M=p["J"] + load),
        table=None,
        sensor_at="load",
        coupling=coupling,
    )


def test_a_bandwidth_stays_below_the_antiresonance_of_the_load():
    rigid, held = replace(as_one_mass(on_a_screw(7.0)), coupling=None), on_a_screw(7.0)
    bandwidths = [
        tuning.tuned(variant, "cascade", 30.0 * math.pi).bandwidth for variant in (rigid, held)
    ]
    assert bandwidths[1] <= 14.0 * math.pi < bandwidths[0]


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("antiresonance", [7.0, 22.0, 70.0, 300.0])
def test_a_reported_coupling_gives_the_gains_of_the_two_masses(antiresonance):
    screw = on_a_screw(antiresonance)
    bandwidths = [
        tuning.tuned(variant, "cascade").bandwidth for variant in (screw, as_one_mass(screw))
    ]
    assert bandwidths[1] == pytest.approx(bandwidths[0], rel=0.03)


def test_a_coupling_travels_from_the_results_to_the_loop(tmp_path):
    treatment = {"cutoff": 20.0, "antiresonance": 30.0, "resonance": 50.0, "inertia_ratio": 1.8}
    write_model(
        tmp_path / "model.toml",
        plants.inertia(M=3.0),
        friction.coulomb(F_C=2.0),
        treatment=treatment,
    )
    experiment = tmp_path / "experiment.toml"
    experiment.write_text(
        'schema = 1\nkind = "translational"\n[friction]\nfile = "model.toml"\n[controller]\nmodel = "cascade"\nk_p = 1.0\nk_v = 1.0\n'
        '[reference]\nmodel = "sine"\namplitude = 1e-3\nfrequency = 1.0\n[run]\nduration = 0.1\nsample_time = 1e-3\n[compare.base]\n'
    )
    assert read_experiment(experiment).variants[0].coupling == Coupling(30.0, 1.8)
    write_model(
        tmp_path / "model.toml",
        plants.inertia(M=3.0),
        friction.coulomb(F_C=2.0),
        treatment={"cutoff": 20.0},
    )
    assert read_experiment(experiment).variants[0].coupling is None

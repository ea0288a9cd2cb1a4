"""The stranger's axes do what their truth says: momentum, friction, delays, encoder, seeds and lies."""

import json
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from benchmarks.strangers import (
    FAMILIES,
    HABITS,
    LIES,
    draw,
    make,
    make_record,
    record_of,
    simulate,
)
from benchmarks.strangers.__main__ import main
from benchmarks.strangers.contact import contact_of
from benchmarks.strangers.recording import plain
from benchmarks.strangers.steps import bristle_step, static_step

pytestmark = pytest.mark.slow


def shortened(truth, seconds=5.0, **loop):
    motion = replace(truth.motion, duration=seconds)
    recording = replace(truth.recording, lost=())
    return replace(truth, motion=motion, recording=recording, loop=replace(truth.loop, **loop))


def ideal(truth, seconds=5.0):
    """No encoder steps, no noise, ripple or cogging, no level that changes, and a trace that hides nothing."""
    truth = plain(shortened(truth, seconds))
    return replace(
        truth,
        axis=replace(truth.axis, cogging=0.0),
        friction=replace(truth.friction, scatter=0.0),
        motor=replace(truth.motor, noise=0.0, ripple=0.0),
        encoder=replace(truth.encoder, resolution=0.0),
    )


@pytest.mark.parametrize("linear", [True, False])
def test_momentum_of_a_record(linear):
    """What the record alone gives (second difference of position, true friction) is the effort that it shows."""
    truth = ideal(draw(4, "coulomb", "strokes", linear))
    record, period = make_record(truth), truth.recording.trace_period
    v, a = np.diff(record.position) / period, np.diff(record.position, 2) / period**2
    # A row shows the mean before its instant.
    effort = 0.5 * (record.effort[1:-1] + record.effort[2:])
    left = truth.mass * a + truth.steady(0.5 * (v[1:] + v[:-1])) + truth.axis.gravity - effort
    moving = np.minimum(np.abs(v[1:]), np.abs(v[:-1])) > 1e-3 * np.abs(v).max()
    assert moving.mean() > 0.3
    assert np.quantile(np.abs(left[moving]), 0.99) < 5e-3 * max(truth.friction.F_C)


@pytest.mark.fast_cases(3)
@pytest.mark.parametrize("family", FAMILIES)
def test_half_the_step_gives_the_same_result(family):
    """Everything on but the encoder's steps, whose flips would tell rounding errors apart."""
    truth = shortened(draw(7, family))
    truth = replace(truth, encoder=replace(truth.encoder, resolution=0.0))
    coarse, fine = simulate(truth), simulate(truth, finer=2)
    level = max(truth.friction.F_C)
    off = np.abs(coarse.command - fine.command) / level
    rubbed = np.abs(coarse.friction - fine.friction) / level
    assert np.sqrt(np.mean(off**2)) < 2e-5
    assert np.quantile(off, 0.999) < 1e-4
    assert np.quantile(rubbed, 0.99) < 1e-4


def test_bristles_against_another_solver():
    """A mass on LuGre friction under a swinging force, also by an implicit method of scipy."""
    from scipy.integrate import solve_ivp

    truth = draw(2, "lugre", linear=True)
    f = replace(
        truth.friction,
        F_C=(1.0, 0.9),
        F_S=(1.5, 1.3),
        v_S=2e-3,
        F_v=(3.0, 2.0),
        sigma_0=1e5,
        sigma_1=60.0,
    )

    def rates(t, y):
        _, v, z = y
        side = 0 if v >= 0 else 1
        level = f.F_C[side] + (f.F_S[side] - f.F_C[side]) * np.exp(-((v / f.v_S) ** 2))
        slip = v - f.sigma_0 * abs(v) / level * z
        return [
            v,
            2.5 * np.sin(60.0 * t) - f.sigma_0 * z - f.sigma_1 * slip - f.F_v[side] * v,
            slip,
        ]

    h, count = 5e-6, 40_000
    exact = solve_ivp(rates, (0.0, h * count), [0.0, 0.0, 0.0], "LSODA", rtol=1e-10, atol=1e-13).y[
        :, -1
    ]
    c, z, after, v, q, guess = contact_of(f), np.zeros(1), np.zeros(1), 0.0, 0.0, 0.0
    for k in range(count):
        pull = 2.5 * np.sin(60.0 * h * (k + 0.5))
        new, _, _ = bristle_step(c, 1.0, pull, v, v + guess, z, after, 0.0, 1.0, 1.0, h)
        q, guess, v, z[:] = q + 0.5 * h * (v + new), new - v, new, after
    assert q == pytest.approx(exact[0], rel=1e-4)
    assert v == pytest.approx(exact[1], rel=1e-3)
    assert z[0] == pytest.approx(exact[2], rel=1e-3)


def test_a_thrown_mass_stops_at_the_coulomb_distance():
    f = replace(draw(2, "coulomb").friction, F_C=(2.0, 1.0), F_S=(2.0, 1.0), F_v=(0.0, 0.0))
    c, v, q, h, steps = contact_of(f), 0.3, 0.0, 1.7e-5, 0
    while v != 0.0:
        v, _, travel = static_step(c, 4.0, 0.0, v, 1.0, 1.0, h)
        q, steps = q + travel, steps + 1
    assert q == pytest.approx(4.0 * 0.3**2 / 2.0 / 2.0, rel=1e-9)
    assert steps == int(np.ceil(4.0 * 0.3 / 2.0 / h))
    assert static_step(c, 4.0, -0.99, 0.0, 1.0, 1.0, h) == (0.0, -0.99, 0.0)
    assert static_step(c, 4.0, -1.01, 0.0, 1.0, 1.0, h)[0] < 0.0


@pytest.mark.parametrize(
    "family", ["coulomb", "lugre", "maxwell", "root_viscous", "stribeck_half", "stribeck_cubic"]
)
def test_sliding_friction_is_the_steady_law(family):
    truth = ideal(draw(11, family, "strokes"), 12.0)
    run = simulate(truth)
    period = truth.recording.trace_period
    steady = np.abs(np.gradient(run.v, period)) < 0.02 * truth.motion.acceleration
    for sign in (1.0, -1.0):
        here = steady & (sign * run.v > 5.0 * truth.friction.v_S)
        assert here.sum() > 150
        error = np.abs(run.friction[here] - truth.steady(run.v[here])) / max(truth.friction.F_C)
        assert np.median(error) < 2e-3


def test_heat_and_scatter_set_the_level():
    truth = ideal(draw(5, "coulomb", "one_speed"), 10.0)
    hot = replace(truth, friction=replace(truth.friction, heat=(1.2, 0.8), heat_time=5.0))
    assert draw(5, "heat").friction.heat == (1.2, 0.8)
    run = simulate(hot)
    sliding = np.flatnonzero(np.abs(run.v) > 0.5 * np.abs(run.v).max())
    share = (np.abs(run.friction[sliding]) / np.abs(hot.steady(run.v[sliding])))[[5, -5]]
    assert 1.12 < share[0] < 1.2
    assert 0.8 < share[1] < 0.85
    rough = replace(truth, friction=replace(truth.friction, scatter=0.03))
    run = simulate(rough)
    sliding = np.abs(run.v) > 0.9 * np.abs(run.v).max()
    side = (run.v[sliding] < 0.0).astype(int)
    f = rough.friction
    dry = np.abs(run.friction[sliding]) - np.asarray(f.F_v)[side] * np.abs(run.v[sliding])
    share = dry / np.asarray(f.F_C)[side]
    strokes = [
        part
        for part in np.split(share, 1 + np.flatnonzero(np.diff(np.flatnonzero(sliding)) > 1))
        if part.size > 20
    ]
    levels = np.array([np.median(part) for part in strokes])
    assert levels.size >= 5
    assert 0.01 < levels.std() < 0.06
    assert max(np.quantile(np.abs(part - np.median(part)), 0.9) for part in strokes) < 2e-3


def lead_of(x, y, period, low, high):
    """By how much x runs ahead of y [s]: from the phase of their cross-spectrum, weighted as a cross-correlation is."""
    w = np.hanning(x.size)
    X, Y = np.fft.rfft(w * (x - x.mean())), np.fft.rfft(w * (y - y.mean()))
    f = np.fft.rfftfreq(x.size, period)
    cross = (X * np.conj(Y))[(f > low) & (f < high)]
    f = f[(f > low) & (f < high)]
    return np.sum(np.abs(cross) * f * np.angle(cross)) / np.sum(np.abs(cross) * 2.0 * np.pi * f**2)


CHANNELS = [
    {"source": "command"},
    {"source": "command", "effort_late": 2, "effort_filter": 1.5e-3},
    {"source": "acted"},
    {"source": "acted", "effort_late": 3},
    {"source": "acted", "effort_filter": 3e-3, "position_filter": 2e-3},
    {"source": "command", "every": 2, "effort_late": 1},
    {"source": "command", "every": 1, "per_tick": 2},
]


@pytest.mark.parametrize("channel", CHANNELS)
@pytest.mark.parametrize("delay", [0, 2])
def test_lead_of_the_effort_in_the_record_alone(channel, delay):
    """An axis almost without friction: mass times acceleration, from the positions, is the force at the stamps."""
    truth = ideal(shortened(draw(13, "coulomb", "multisine", True), delay=delay), 12.0)
    little = (1e-6 * truth.mass, 1e-6 * truth.mass)
    friction = replace(truth.friction, F_C=little, F_S=little, F_v=(0.0, 0.0))
    loop = replace(
        truth.loop,
        period=1e-3,
        kp=10.0,
        kv=60.0 * truth.mass,
        ki=400.0 * truth.mass,
        kind="cascade",
    )
    recording = replace(truth.recording, trace_period=1e-3 / channel.get("per_tick", 1), **channel)
    motor = replace(truth.motor, lag=0.8e-3, limit=1e9)
    motion = replace(
        truth.motion,
        frequencies=(0.7, 2.3, 5.1, 8.3),
        amplitudes=(4e-3, 2e-3, 2e-3, 2e-3),
        phases=(0.0,) * 4,
    )
    truth = replace(
        truth,
        friction=friction,
        loop=loop,
        recording=recording,
        motor=motor,
        motion=motion,
        axis=replace(truth.axis, gravity=0.0),
    )
    record = make_record(truth)
    a = np.diff(record.position, 2) / truth.period**2
    lead = lead_of(record.effort[1:-1], a, truth.period, 0.5, 12.0)
    assert lead == pytest.approx(truth.effort_lead + truth.position_lag, abs=4e-5)


def test_the_encoder_rounds_and_has_a_periodic_error():
    truth = plain(shortened(draw(9, "lugre", "one_direction", False), 10.0))
    encoder = replace(truth.encoder, resolution=2.0 * np.pi / 20_000, amplitudes=(6.0, 3.0, 1.5))
    truth = replace(truth, encoder=encoder)
    run = simulate(truth)
    record = record_of(truth, run)
    counts = record.position / encoder.resolution
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    error = (record.position - run.q) / encoder.resolution
    x = run.q * 2.0 * np.pi / encoder.period
    waves = np.column_stack([f(n * x) for n in (1, 2, 16) for f in (np.sin, np.cos)])
    parts = np.linalg.lstsq(waves, error, rcond=None)[0].reshape(3, 2)
    np.testing.assert_allclose(np.hypot(*parts.T), encoder.amplitudes, rtol=0.05)
    assert np.abs(error - waves @ parts.ravel()).max() < 0.75


def test_a_seed_reproduces_itself_and_another_does_not():
    (truth, record), (again, second), (other, _) = (
        make(21, "maxwell"),
        make(21, "maxwell"),
        make(22, "maxwell"),
    )
    assert truth == again
    assert truth != other
    assert np.array_equal(record.position, second.position)
    assert np.array_equal(record.effort, second.effort)


def test_drawn_axes_span_the_documented_ranges():
    truths = [draw(seed, family) for family in FAMILIES for seed in range(60)]
    linear = np.array([t.mass for t in truths if t.axis.linear])
    rotary = np.array([t.mass for t in truths if not t.axis.linear])
    assert linear.max() / linear.min() > 3e3
    assert rotary.max() / rotary.min() > 3e3
    assert 0.25 < np.mean([t.axis.gravity > 0.0 for t in truths]) < 0.42
    assert 0.25 < np.mean([t.axis.cogging > 0.0 for t in truths]) < 0.42
    assert {t.motion.kind for t in truths} >= {
        "strokes",
        "multisine",
        "sine",
        "presliding",
        "cycle",
    }
    assert all(0.2e-3 < t.recording.trace_period * t.recording.every < 2.1e-3 for t in truths)
    assert {t.loop.delay for t in truths} == {0, 1, 2, 3}
    assert len(HABITS) >= 6
    assert set(HABITS) <= set(LIES)


def test_play_lets_the_load_lag():
    truth = shortened(draw(8, "backlash", "strokes"))
    run = simulate(truth)
    gap = (run.q - run.load) / truth.axis.half_play
    assert gap.max() > 0.99
    if truth.axis.gravity == 0.0:
        assert gap.min() < -0.99


@cache
def short_record(seed):
    """A truth, and its record of 15 s, of which no lie may change anything in place."""
    truth = draw(seed, "lugre", "strokes", linear=seed == 5)
    truth = replace(truth, motion=replace(truth.motion, duration=15.0))
    record = make_record(truth)
    for values in (record.t, record.position, record.effort, record.reference, record.velocity):
        if values is not None:
            values.setflags(write=False)
    return truth, record


@pytest.mark.fast_cases(len(LIES))
@pytest.mark.parametrize("name", sorted(LIES))
@pytest.mark.parametrize("seed", [5, 41])
def test_each_lie_lies(name, seed):
    truth, record = short_record(seed)
    lied = LIES[name](truth, record, 3)
    assert lied.name == name
    assert lied.told
    assert np.isfinite(lied.record.position).all()
    if lied.claimed_mass is not None:
        assert abs(np.log(lied.claimed_mass / truth.mass)) > 0.2
        return
    pairs = [
        (getattr(record, k), getattr(lied.record, k))
        for k in ("t", "position", "effort", "velocity")
    ]
    assert any(b is not None and (a is None or not np.array_equal(a, b)) for a, b in pairs)
    sizes = {x.size for _, x in pairs if x is not None}
    assert len(sizes) == 1


def test_the_command_line_writes_record_and_truth(tmp_path, monkeypatch):
    out = tmp_path / "x.csv"
    monkeypatch.setattr(
        sys,
        "argv",
        ["benchmarks.strangers", "--seed", "5", "--family", "coulomb", "--out", str(out)],
    )
    main()
    header = out.read_text(encoding="utf-8").splitlines()[0].split(",")
    table = np.loadtxt(out, delimiter=",", skiprows=1)
    truth, record = make(5, "coulomb")
    assert header[0] == "time [s]"
    assert table.shape == (record.t.size, len(header))
    np.testing.assert_allclose(table[:, 2], record.effort, rtol=1e-8)
    assert (
        json.loads(out.with_suffix(".json").read_text(encoding="utf-8"))["axis"]["mass"]
        == truth.mass
    )

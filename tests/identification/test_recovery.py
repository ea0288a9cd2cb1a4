"""Known truth is recovered: from several logs, in any units, of a user's model, and behind a coarse encoder."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    Motion,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    slow_log,
)
from tests.identification.rigid import identify

from bristle import friction
from bristle.core import Axis, InputError, Variable
from bristle.core.axis import Cogging
from bristle.core.dimensions import exponents_of
from bristle.files import load_code
from bristle.identification.least_squares import Search, Sliding
from bristle.identification.parameter_space import Transform
from bristle.identification.parameters import Scales
from bristle.logs import checked
from bristle.report.judgement import feedforward_of, judged
from bristle.report.messages import assumptions_of, note_of, warnings_of


@pytest.mark.slow
def test_standard_errors_are_valid_for_white_noise():
    scores = []
    for seed in range(40):
        parameters = identify(
            sliding_log(seed), "coulomb_viscous", axis=STATED, blocks=0, draws=0
        ).best.parameters
        scores.append(
            [
                (parameters[name].value - truth) / parameters[name].std
                for name, truth in TRUTH.items()
            ]
        )
    scores = np.array(scores)
    # The spread of 40 draws is known to 11 %, its mean to 0.16; central differences shift M by a known 1e-4.
    assert np.all(np.abs(scores.mean(axis=0)) < [0.8, 0.5, 0.5, 0.5])
    assert np.all((scores.std(axis=0) > 0.65) & (scores.std(axis=0) < 1.4))


@pytest.mark.slow
def test_each_direction_has_its_own_friction():
    motion = sines()
    forward = sliding_effort(motion, F_C=9.0, F_v=25.0, offset=0.0)
    backward = sliding_effort(motion, F_C=6.0, F_v=40.0, offset=0.0)
    log = log_of(motion, np.where(motion.velocity > 0.0, forward, backward))
    parameters = identify(log, "coulomb_viscous+asymmetry", axis=STATED, draws=0).best.parameters
    for name, truth in {
        "F_C_pos": 9.0,
        "F_C_neg": 6.0,
        "F_v_pos": 25.0,
        "F_v_neg": 40.0,
        "M": 12.0,
    }.items():
        assert abs(parameters[name].value - truth) < 4.0 * parameters[name].std
        assert parameters[name].status == "identified"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("dahl", {"sigma_0": 1e5, "F_C": 8.0, "sigma_2": 30.0, "offset": 0.5}),
        (
            "lugre",
            {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "sigma_0": 1e5, "sigma_2": 30.0, "offset": 0.5},
        ),
        ("stribeck", {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "F_v": 30.0, "offset": 0.5}),
    ],
)
def test_nonlinear_models_are_recovered(name, truth):
    fit = identify(slow_log(friction.find(name)(**truth)), name, axis=STATED, draws=0).best
    for parameter, value in truth.items():
        estimate = fit.parameters[parameter]
        assert estimate.status == "identified", note_of(estimate)
        assert estimate.value == pytest.approx(value, rel=0.03), parameter
        assert estimate.relative_std_percent < 8.0
    assert fit.parameters["M"].value == pytest.approx(12.0, rel=0.01)


@pytest.mark.slow
def test_a_gap_and_its_hardening_are_recovered():
    truth = {
        "F_C": 8.0,
        "give": 4e-4,
        "gap": 6e-4,
        "n": 2.0,
        "share": 0.1,
        "sigma_2": 30.0,
        "offset": 0.5,
    }
    log = slow_log(friction.find("gap_slider")(**truth), duration=6.0)
    parameters = identify(
        log, "gap_slider", axis=STATED, mass=12.0, blocks=0, draws=0
    ).best.parameters
    for name, value in truth.items():
        assert parameters[name].status == "identified", note_of(parameters[name])
        assert parameters[name].value == pytest.approx(value, rel=0.03), name


@pytest.mark.slow
def test_a_bound_is_respected_and_reported():
    fit = identify(sliding_log(F_v=-5.0), "coulomb_viscous", axis=STATED, draws=0).best
    bounded = fit.parameters["F_v"]
    assert (bounded.value, bounded.status, bounded.std) == (0.0, "at_edge", None)
    assert any(sentence.startswith("F_v has no standard error") for sentence in warnings_of(fit))
    assert fit.parameters["F_C"].std > 0.0


@pytest.mark.slow
def test_predicted_and_measured_are_traced():
    fit = identify(sliding_log(), "coulomb_viscous", axis=STATED, draws=0).best
    traces = fit.traces
    assert (
        traces.time.shape
        == traces.velocity.shape
        == traces.measured.shape
        == traces.predicted.shape
    )
    assert np.all(np.diff(traces.time) > 0.0)
    relative = np.linalg.norm(traces.residual) / np.linalg.norm(traces.measured)
    assert 100.0 * relative == pytest.approx(fit.force_error_percent)
    assert fit.metrics["force_error_percent"] == fit.force_error_percent
    # Of the effort, inertia takes none that friction does: the same residual is a larger share of what is left.
    friction_alone = traces.measured - fit.plant.values["M"] * traces.acceleration
    share = np.std(traces.measured) / np.std(friction_alone)
    assert fit.metrics["friction_error_percent"] == pytest.approx(
        share * fit.force_error_percent, rel=0.05
    )


@pytest.mark.slow
@pytest.mark.parametrize("model", ["coulomb_viscous", "coulomb_viscous+asymmetry"])
def test_weight_is_not_friction_in_relative_errors(model):
    light, heavy = (
        identify(sliding_log(offset=offset), model, axis=STATED, draws=0, blocks=0).best
        for offset in (0.0, 6.0)
    )
    assert heavy.friction_alone_error_percent == pytest.approx(
        light.friction_alone_error_percent, rel=0.02
    )
    assert heavy.friction_error_percent < 0.9 * light.friction_error_percent
    assert heavy.metrics["friction_alone_error_percent"] == heavy.friction_alone_error_percent


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "path"),
    [
        ({"mass": 0.0}, "mass"),
        ({"mass": float("nan")}, "mass"),
        ({"offset": float("inf")}, "offset"),
        ({"offset": "7 J"}, "offset"),
        ({"offset": "some"}, "offset"),
        ({"mass": "3 N"}, "mass"),
        ({"cutoff": "60 rad/s"}, "cutoff"),
        ({"decimation": 2.5}, "decimation"),
        ({"blocks": float("nan")}, "blocks"),
        ({"blocks": 1}, "blocks"),
        ({"blocks": 2.5}, "blocks"),
        ({"blocks": 500}, "blocks"),
    ],
)
def test_an_argument_out_of_range_is_named(arguments, path):
    with pytest.raises(InputError) as caught:
        identify(sliding_log(), **({"model": "coulomb_viscous"} | arguments))
    assert caught.value.path == path


# By what the parameters change where lengths are multiplied by the first number and forces by the second.
POWERS = {
    "M": (-1, 1),
    "F_C": (0, 1),
    "F_S": (0, 1),
    "F_v": (-1, 1),
    "sigma_2": (-1, 1),
    "v_S": (1, 0),
    "sigma_0": (-1, 1),
    "offset": (0, 1),
}


TRUTHS = {
    "coulomb_viscous": {"F_C": 8.0, "F_v": 30.0, "offset": 0.5},
    "stribeck": {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3, "F_v": 30.0, "offset": 0.5},
    "lugre": {
        "F_C": 8.0,
        "F_S": 11.0,
        "v_S": 4e-3,
        "sigma_0": 1e5,
        "sigma_1": 60.0,
        "sigma_2": 30.0,
        "offset": 0.5,
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("name", list(TRUTHS))
def test_magnitudes_scale(name):
    log = slow_log(friction.find(name)(**TRUTHS[name]), duration=10.0)
    length, force = 2.0**9, 2.0**-12
    motion = Motion(
        log.time.values, length * log.position.values, log.position.values, log.position.values
    )
    small = log_of(motion, force * log.effort.values, kind="rotational")
    item, other = (
        identify(log, name, blocks=0, draws=0).best,
        identify(small, name, blocks=0, draws=0).best,
    )
    assert other.force_error_percent == pytest.approx(item.force_error_percent, rel=1e-4)
    for parameter, estimate in item.parameters.items():
        if parameter not in POWERS:
            continue
        of_length, of_force = POWERS[parameter]
        scale = length**of_length * force**of_force
        scaled = other.parameters[parameter]
        assert scaled.value == pytest.approx(scale * estimate.value, rel=2e-3), parameter
        assert scaled.std == pytest.approx(scale * estimate.std, rel=0.02), parameter
        assert scaled.status == estimate.status
    assert other.parameters["M"].unit == "kg*m^2"
    assert other.parameters["F_C"].unit == "N*m"
    assert other.plant.kind == other.friction.kind == "rotational"


def test_a_log_of_impossible_extent_is_reported_with_its_units():
    log = slow_log(friction.find("stribeck")(**TRUTHS["stribeck"]), duration=10.0)
    slow = Motion(
        1e11 * log.time.values, log.position.values, log.position.values, log.position.values
    )
    with pytest.raises(
        InputError, match=r"v_S: would have the range .* for the extent of this log.* units of time"
    ):
        identify(log_of(slow, log.effort.values), "stribeck", blocks=0, draws=0)


def test_reversing_the_axis_exchanges_the_directions():
    truth = friction.find("coulomb_viscous+asymmetry")(
        F_C_pos=9.0, F_C_neg=6.0, F_v_pos=20.0, F_v_neg=40.0
    )
    log = slow_log(truth, duration=5.0)
    motion = Motion(log.time.values, -log.position.values, log.position.values, log.position.values)
    turned = log_of(motion, -log.effort.values)
    name = "coulomb_viscous+asymmetry"
    item, other = (
        identify(entry, name, axis=STATED, blocks=0, draws=0).best.friction.values
        for entry in (log, turned)
    )
    for parameter in ("F_C", "F_v"):
        assert other[f"{parameter}_pos"] == pytest.approx(item[f"{parameter}_neg"], rel=1e-9)
        assert other[f"{parameter}_neg"] == pytest.approx(item[f"{parameter}_pos"], rel=1e-9)
    assert np.isfinite(list(item.values())).all()


FAST = {
    "amplitudes": (0.02, 0.004, 0.0015),
    "frequencies": (0.5, 3.1, 7.3),
    "phases": (0.3, 1.1, 2.5),
}
AXIS = Axis(kind="translational")


@cache
def coarse_log(step, seconds=20.0):
    motion = sines(seconds, 5e-4, **FAST)
    return log_of(motion, sliding_effort(motion, noise=0.05), step=step)


@cache
def coarsely(**named):
    """An encoder whose steps make more noise in the acceleration than friction takes."""
    return result(coarse_log(2.5e-5), **named)


def result(log, axis=AXIS, **named):
    return identify(log, "coulomb_viscous", axis=axis, blocks=0, draws=0, **named)


@pytest.mark.slow
def test_noise_of_a_coarse_encoder_does_not_hide_friction():
    usual, calm = coarsely(decimation=10), coarsely()
    assert usual.best.metrics["friction_error_percent"] > 40.0
    assert calm.best.metrics["friction_error_percent"] < 8.0
    assert calm.treatment["decimation"] > 20
    for name in ("F_C", "F_v", "offset"):
        assert calm.best.parameters[name].value == pytest.approx(TRUTH[name], rel=0.02)


@pytest.mark.slow
def test_fewer_rows_are_reported_with_their_cost():
    (message,) = (
        text for text in assumptions_of(coarsely().best) if "the usual number of rows" in text
    )
    share = float(message.split(" % of friction")[0].split()[-1])
    # White noise of a step over the root of twelve, in acceleration up to 100 Hz, times the inertia.
    motion = sines(20.0, 5e-4, **FAST)
    turned = np.fft.rfftfreq(motion.time.size, 5e-4)
    white = (
        2.5e-5
        / 12.0**0.5
        * np.sqrt(np.mean(np.where(turned < 100.0, (2.0 * np.pi * turned) ** 4, 0.0)))
    )
    friction = np.std(TRUTH["F_C"] * np.sign(motion.velocity) + TRUTH["F_v"] * motion.velocity)
    assert share == pytest.approx(100.0 * TRUTH["M"] * white / friction, rel=0.15)


@pytest.mark.slow
def test_fewer_rows_are_reported_if_cogging_repeats_the_search_for_the_delay():
    cogs = replace(AXIS, cogging=Cogging("motor", 0.012))
    assert any(
        "the usual number of rows" in text
        for text in assumptions_of(result(coarse_log(2.5e-5), cogs).best)
    )


@pytest.mark.slow
def test_noise_above_friction_is_reported_in_plain_numbers():
    (message,) = (
        text
        for text in assumptions_of(result(coarse_log(8e-5)).best)
        if "the usual number of rows" in text
    )
    assert 100.0 < float(message.split(" % of friction")[0].split()[-1]) < 500.0
    assert "e+" not in message


@pytest.mark.slow
def test_a_stated_decimation_is_kept():
    assert coarsely(decimation=10).treatment["decimation"] == 10
    assert (
        result(coarse_log(2.5e-5, 7.0), replace(AXIS, decimation=12)).treatment["decimation"] == 12
    )


LOGS = [sliding_log(seed) for seed in (1, 2)]


@pytest.mark.slow
def test_logs_are_fitted_together():
    logs = [sliding_log(seed, noise=1.0) for seed in (1, 2, 3)]
    alone = identify(logs[0], "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    identification = identify(logs, "coulomb_viscous", axis=STATED, draws=0)
    for name, true in TRUTH.items():
        estimate = identification.best.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.larger_std, name
    # Three times the rows, and no row between the logs.
    assert identification.best.parameters["F_C"].std < 0.75 * alone.parameters["F_C"].std
    assert identification.treatment["rows"] == pytest.approx(3 * alone.traces.time.size, rel=0.01)
    assert len(identification.best.held_out.block_errors_percent) == 5
    assert identification.further_logs == tuple(logs[1:])
    assert np.all(np.diff(identification.best.traces.time) > 0.0)


@pytest.mark.parametrize(("level", "place"), [(16.0, 0), (10.0, 2), (8.4, None)])
def test_a_log_whose_friction_differs_is_named(level, place):
    logs = list(LOGS)
    logs.insert(place or 0, sliding_log(4, F_C=level))
    diagnostics = identify(logs, "coulomb_viscous", axis=STATED, blocks=0, draws=0).best.diagnostics
    named = [
        (found.numbers["log"], found.numbers["percent"] > 10.0)
        for found in diagnostics
        if found.code == "log_differs"
    ]
    assert named == ([] if place is None else [(f"log {place + 1}", True)])


def passages(speed, sides, seed):
    """A log of passages at one speed, each in the direction of its side, from rest to rest."""
    rise = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 150))
    once = np.concatenate([np.zeros(200), rise, np.ones(500), rise[::-1]])
    v = speed * np.outer(sides, once).ravel()
    motion = Motion(
        1e-3 * np.arange(v.size), 1e-3 * (np.cumsum(v) - 0.5 * v), v, np.gradient(v, 1e-3)
    )
    return log_of(motion, sliding_effort(motion, seed), step=1e-6)


def test_logs_of_one_direction_or_one_speed_are_one_experiment():
    logs = [passages(0.1, [1] * 5, 1), passages(0.3, [-1] * 5, 2), passages(0.6, [1, -1, 1, -1], 3)]
    assert all(
        {finding.code for finding in checked(log)} & {"one_direction", "one_speed"} for log in logs
    )
    identification = identify(logs, "coulomb_viscous", axis=STATED, draws=0)
    best = identification.best
    assert judged(best, identification.settings).level == "usable"
    assert feedforward_of(identification).startswith("safe to try")
    assert best.held_out.mean_percent < 1.1 * best.force_error_percent
    assert {name: best.parameters[name].value for name in TRUTH} == pytest.approx(TRUTH, rel=0.01)


def test_each_log_has_its_axis_or_one_axis_is_shared():
    logs, axes = LOGS, [replace(STATED, resolution=step) for step in (1e-7, 1e-6)]
    both, shared = (
        identify(logs, "coulomb_viscous", axis=axis, blocks=0, draws=0).best
        for axis in (axes, axes[0])
    )
    assert both.parameters["M"].value == pytest.approx(shared.parameters["M"].value, rel=1e-3)


MOTION = sines(dt=2e-3)
SLOWER = log_of(MOTION, sliding_effort(MOTION))


@pytest.mark.parametrize(
    ("logs", "axis", "told"),
    [
        (
            LOGS[:1],
            [Axis(resolution=1e-7), Axis(resolution=1e-6)],
            r"2 axis files for 1 log; allowed 1\.",
        ),
        ([], STATED, "names no log"),
        (
            [LOGS[0], log_of(MOTION, sliding_effort(MOTION))],
            replace(STATED, cutoff=20.0),
            "was sampled every 2 ms, the first log every 1 ms",
        ),
        (LOGS, [Axis(cutoff=50.0), Axis(cutoff=40.0)], "different cutoff than the first log"),
        ([LOGS[0], replace(LOGS[1], kind="rotational")], STATED, "a different kind of axis"),
    ],
)
def test_incompatible_logs_are_rejected_by_name(logs, axis, told):
    with pytest.raises(InputError, match=told):
        identify(logs, "coulomb_viscous", axis=axis, draws=0)


OWN = load_code(Path(__file__).parents[2] / "examples" / "quadratic_drag.py")
DRAG = {"M": 12.0, "F_C": 8.0, "F_q": 40.0}


@pytest.mark.parametrize(
    ("length", "force", "kind"),
    [
        (1.0, 1.0, "translational"),
        (2.0**-20, 2.0**9, "translational"),
        (2.0**11, 2.0**-12, "rotational"),
    ],
)
def test_a_drag_coefficient_is_found_for_any_magnitude(length, force, kind):
    moved = sines(5.0)
    drag = DRAG["F_q"] * moved.velocity * np.abs(moved.velocity)
    effort = DRAG["M"] * moved.acceleration + DRAG["F_C"] * np.sign(moved.velocity) + drag
    effort += np.random.default_rng(3).normal(0.0, 0.1, effort.size)
    motion = Motion(
        moved.time, length * moved.position, length * moved.velocity, length * moved.acceleration
    )
    best = identify(log_of(motion, force * effort, kind=kind), OWN, blocks=0, draws=0).best
    result = best.parameters["F_q"]
    assert result.status == "identified"
    assert result.value == pytest.approx(DRAG["F_q"] * force / length**2, rel=0.02)
    assert result.unit == {"translational": "N*s^2/m^2", "rotational": "N*m*s^2/rad^2"}[kind]


SCALES = Scales(
    force=8.0,
    peak=20.0,
    speed=0.2,
    slowest=1e-3,
    acceleration=3.0,
    stroke=0.05,
    shortest=1e-6,
    duration=10.0,
    sample_time=1e-3,
)
DIMENSIONS = Scales(
    force="force",
    peak="force",
    speed="length/time",
    slowest="length/time",
    acceleration="length/time^2",
    stroke="length",
    shortest="length",
    duration="time",
    sample_time="time",
)


def ratio(quantity, force, length, time):
    """Factor of a quantity if forces, lengths and times are multiplied by these factors."""
    by = {"force": force, "length": length, "time": time}
    return np.prod([by[name] ** power for name, power in exponents_of(quantity).items()])


@pytest.mark.parametrize(
    "quantity",
    [
        "force",
        "length",
        "time",
        "1/time",
        "1/length",
        "length/time",
        "length/time^2",
        "length/time^3",
        "force/length",
        "force*time/length",
        "force*time^2/length^2",
        "force/length/time",
        "mass",
        "force/time",
        "force^0.5*time^1.5",
        "frequency",
    ],
)
def test_typical_values_of_a_search_have_the_dimension_of_the_parameter(quantity):
    by = (3.0, 7.0, 11.0)
    other = Scales(*(value * ratio(of, *by) for value, of in zip(SCALES, DIMENSIONS, strict=True)))
    for excitation in ("", "speed", "presliding"):
        variable = Variable(quantity, "a parameter", excitation=excitation)
        expected = pytest.approx(ratio(quantity, *by), rel=1e-12)
        assert other.magnitude(variable) / SCALES.magnitude(variable) == expected
        ends = zip(other.range(variable), SCALES.range(variable), strict=True)
        assert [item / before for item, before in ends] == [expected, expected]
        starts = []
        for scales in (other, SCALES):
            sliding = Sliding({}, scales.force, scales.force / scales.speed)
            search, coordinate = (
                SimpleNamespace(sliding=sliding, scales=scales),
                Transform("p", "plain", 1.0, *4 * (0.0,)),
            )
            starts.append(Search._draw(search, coordinate, variable, np.random.default_rng(1)))
        assert starts[0] / starts[1] == expected

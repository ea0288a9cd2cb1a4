"""What is written into a drive: the table of friction over velocity, its levels, its curve, and how far a reversal goes."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log, slow_log

from bristle import friction
from bristle.core import InputError
from bristle.core.diagnostic import Diagnostic
from bristle.engine.contact import steady_force
from bristle.identification import identify
from bristle.identification.result import Bands, Resampling
from bristle.models.plants import inertia, oscillator
from bristle.prediction import drive_table
from bristle.prediction.drive_table import (
    _line_below,
    _reached,
    largest_deviation,
    level_values,
    levels_of,
    placed,
    resolved_side,
    reversal_distance,
    steady_curve,
    steady_side,
    table_error,
    without_fall,
)


@pytest.fixture(scope="module")
def fit():
    return identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0).best


@pytest.fixture(scope="module")
def curved():
    """A model whose steady friction bends, on a log of both directions."""
    fit = identify(
        slow_log(friction.stribeck(F_C=8.0, F_S=11.0, v_S=4e-3, F_v=30.0)),
        "stribeck",
        blocks=0,
        draws=0,
    ).best
    return replace(fit, friction=friction.stribeck(F_C=8.0, F_S=11.0, v_S=1e-3, F_v=30.0))


def test_the_table_covers_the_velocities_of_the_log(curved):
    fit = curved
    table = drive_table(fit)
    velocities = [velocity for velocity, _ in table]
    assert len(table) == 20
    assert velocities == sorted(velocities)
    assert velocities[0] == pytest.approx(np.min(fit.traces.velocity))
    assert velocities[-1] == pytest.approx(np.max(fit.traces.velocity))
    assert np.diff(velocities[10:])[:-1].max() < 0.3 * np.diff(velocities)[-1]


def test_straight_friction_needs_only_its_ends(fit):
    table = drive_table(fit)
    assert len(table) == 4
    assert largest_deviation(fit, table) < 1e-5


@pytest.mark.parametrize(
    ("force", "rising"),
    [
        ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]),
        ([9.0, 5.0, 2.0, 4.0, 3.0, 7.0], [2.0, 2.0, 2.0, 3.0, 3.0, 7.0]),
        ([3.0, 1.0], [1.0, 1.0]),
    ],
)
def test_a_curve_without_fall_is_the_largest_rising_curve_below(force, rising):
    speed = np.arange(len(force), dtype=float)
    assert (
        without_fall(np.column_stack([speed, force])).tolist()
        == np.column_stack([speed, rising]).tolist()
    )


def test_the_table_of_a_drive_leaves_out_the_peak_of_a_break_away(curved):
    table = np.array(drive_table(curved, entries=40))
    for way in (1.0, -1.0):
        speed, force = (way * table[np.signbit(table[:, 0]) == (way < 0.0)][:: int(way)]).T
        assert np.all(np.diff(force) >= 0.0)
        steady = [way * steady_force(curved.friction, way * max(v, 1e-9)) for v in speed.tolist()]
        assert np.all(force <= np.add(steady, 1e-3))
        assert force[0] < 0.8 * 11.0


def test_the_deviation_is_the_largest_gap_to_the_model(curved):
    coarse = [(-0.04, -9.2), (-0.0, -11.0), (0.0, 11.0), (0.04, 9.2)]
    speeds = np.linspace(1e-6, float(np.max(curved.traces.velocity)), 4000)
    gaps = [
        abs(np.interp(v, [0.0, 0.04], [11.0, 9.2]) - steady_force(curved.friction, v))
        for v in speeds.tolist()
    ]
    assert largest_deviation(curved, coarse) == pytest.approx(max(gaps), rel=0.05)


def test_standstill_has_one_entry_for_each_side(fit):
    (below, force_below), (above, force_above) = (
        entry for entry in drive_table(fit) if entry[0] == 0.0
    )
    assert math.copysign(1.0, below) == -1.0
    assert math.copysign(1.0, above) == 1.0
    values = fit.friction.values
    assert 0.5 * (force_above - force_below) == pytest.approx(values["F_C"], rel=1e-6)
    assert 0.5 * (force_above + force_below) == pytest.approx(values["offset"], rel=1e-6)


def test_a_log_of_one_direction_gives_a_table_of_one_direction(curved):
    forward = replace(curved.traces, velocity=np.abs(curved.traces.velocity))
    table = drive_table(replace(curved, traces=forward), entries=12)
    assert [math.copysign(1.0, velocity) for velocity, _ in table] == [1.0] * 12
    assert len(drive_table(curved, entries=15)) == 14, "an odd size is not exceeded"


@pytest.mark.parametrize("entries", [3, 1001, 7.5])
def test_a_size_out_of_range_is_refused(fit, entries):
    with pytest.raises(InputError, match="entries"):
        drive_table(fit, entries=entries)


@pytest.mark.parametrize(
    ("friction_of", "level", "slope", "off", "off_of_level"),
    [
        (lambda v: 5.0 + 2.0 * v, 5.0, 2.0, 0.0, 2.0),
        (lambda v: 5.0 - 2.0 * v, 3.0, 0.0, 2.0, 2.0),  # a level never falls
        (lambda v: 5.0 + 2.0 * v + np.where(v == 0.0, 3.0, 0.0), 5.0, 2.0, 3.0, 3.0),
    ],
)
def test_a_level_with_its_viscous_part_touches_friction_from_below(
    friction_of, level, slope, off, off_of_level
):
    # Dense near rest, where a peak counts by the width that it has.
    speed = np.union1d(np.geomspace(1e-6, 1.0, 150), np.linspace(0.0, 1.0, 150))
    line = _line_below(np.column_stack([speed, friction_of(speed)]))
    assert tuple(line) == pytest.approx((level, slope, off, off_of_level), abs=1e-4)


def test_levels_of_both_directions_exclude_the_constant_force():
    model = friction.find("coulomb_viscous+asymmetry")(
        F_C_pos=8.0, F_C_neg=6.0, F_v_pos=30.0, F_v_neg=20.0, offset=1.5
    )
    speed = np.linspace(0.0, 0.1, 20)
    sides = {
        1.0: np.column_stack([speed, 9.5 + 30.0 * speed]),
        -1.0: np.column_stack([speed, 4.5 + 20.0 * speed]),
    }
    levels = levels_of(inertia(M=3.0), model, sides)
    assert levels == pytest.approx((3.0, 1.5, 8.0, 6.0, 30.0, 20.0, 0.0, 3.0), abs=1e-9)
    forward = levels_of(None, model, {1.0: sides[1.0]})
    assert (forward.inertia, forward.backward, forward.viscous_backward) == (0.0, None, None)
    assert (forward.forward, forward.deviation_of_levels) == pytest.approx((8.0, 3.0))


def test_level_values_are_those_of_the_fit(fit):
    values, levels = fit.friction.values, level_values(fit)
    assert (levels.forward, levels.backward) == pytest.approx(
        (values["F_C"], values["F_C"]), rel=1e-6
    )
    assert (levels.viscous_forward, levels.constant) == pytest.approx(
        (values["F_v"], values["offset"]), rel=1e-6
    )
    assert levels.inertia == fit.plant.values["M"]


def test_a_plant_on_a_spring_has_no_table(fit):
    sprung = replace(fit, plant=oscillator(M=2.0, c=0.0, k=100.0))
    assert (drive_table(sprung), steady_curve(sprung), level_values(sprung)) == ([], [], None)


def test_a_log_that_never_slid_has_no_table(fit):
    doubted = replace(fit, diagnostics=(Diagnostic("never_slides", "", "warning"),))
    assert (doubted.never_slid, drive_table(doubted), fit.never_slid) == (True, [], False)


@pytest.mark.parametrize(("name", "never_slid"), [("F_C", True), ("F_S", False), ("F_v", False)])
def test_a_sliding_level_beyond_the_effort_means_that_the_log_never_slid(curved, name, never_slid):
    reason = Diagnostic("beyond_effort", name)
    estimates = [
        replace(item, reason=reason) if item.name == name else item for item in curved.estimates
    ]
    assert replace(curved, estimates=tuple(estimates)).never_slid is never_slid


def test_a_steady_curve_is_dense_near_rest_on_both_sides(curved):
    velocity, force = np.array(steady_curve(curved)).T
    top = float(np.max(curved.traces.velocity))
    assert np.all(np.diff(velocity) >= 0.0)
    assert np.sum(np.signbit(velocity)) == pytest.approx(velocity.size / 2, abs=2)
    assert np.sum((velocity > 0.0) & (velocity < 1e-3 * top)) > 70
    assert velocity.size > 590
    # The curve of the model with its sign: friction against the motion.
    assert force[-1] == pytest.approx(steady_force(curved.friction, top))
    assert force[0] == pytest.approx(
        steady_force(curved.friction, float(np.min(curved.traces.velocity)))
    )


STRIBECK = friction.stribeck(F_C=8.0, F_S=11.0, v_S=1e-3, F_v=30.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_steady_side_is_the_force_along_the_motion_from_rest_on(direction):
    model = (
        friction.find("stribeck")(**STRIBECK.values, offset=1.0)
        if "offset" not in STRIBECK.values
        else STRIBECK
    )
    curve = steady_side(model, direction, 0.1, 20)
    speed, force = curve.T
    assert (speed[0], speed[-1]) == (0.0, 0.1)
    assert np.all(np.diff(speed) > 0.0)
    assert force == pytest.approx(
        8.0
        + 3.0 * np.exp(-((speed / 1e-3) ** 2))
        + 30.0 * speed
        + direction * model.values["offset"],
        rel=1e-6,
    )
    assert not curve.flags.writeable


def test_a_resolved_side_is_a_line_between_its_points():
    curve, off = resolved_side(STRIBECK, 1.0, 0.1)
    assert 0.0 <= off <= 2e-5 * 11.0
    between = np.linspace(1e-6, 0.1, 3001)
    gaps = np.interp(between, *curve.T) - [steady_force(STRIBECK, v) for v in between.tolist()]
    assert np.max(np.abs(gaps)) < 1e-3
    assert 60 < len(curve) < 800
    flat, none_off = resolved_side(friction.coulomb(F_C=8.0), 1.0, 0.1)
    assert none_off == pytest.approx(0.0, abs=1e-12)
    assert len(flat) < 100


X = np.linspace(0.0, 4.0, 41)
BENT = np.column_stack([X, np.abs(X - 1.0)])


@pytest.mark.parametrize(
    ("curve", "count", "points"),
    [
        (BENT, 3, [0, 10, 40]),
        (BENT, 10, [0, 10, 40]),
        (BENT, 2, [0, 40]),
        (np.column_stack([X, 2.0 * X]), 5, [0, 40]),
        (
            np.column_stack([X, X**2]),
            5,
            [0, pytest.approx(10, abs=1), pytest.approx(20, abs=1), pytest.approx(30, abs=1), 40],
        ),
    ],
)
def test_points_are_placed_as_far_as_straight_lines_reach(curve, count, points):
    assert placed(curve, count) == points


@pytest.mark.parametrize(
    ("allowed", "count", "points"), [(1e-9, 3, [0, 10, 40]), (1e-9, 2, None), (2.0, 2, [0, 40])]
)
def test_too_many_points_give_no_result(allowed, count, points):
    assert _reached(BENT, allowed, count) == points


def test_the_error_of_a_table_along_a_log_is_its_missing_force():
    log, model = sliding_log(), friction.coulomb_viscous(F_C=8.0, F_v=30.0)
    speed = np.linspace(0.0, 1.0, 50)
    side = np.column_stack([speed, 8.0 + 30.0 * speed])
    exact = table_error(model, None, log, None, {1.0: side, -1.0: side}, {"cutoff": 50.0})
    higher = side + np.array([0.0, 2.0])
    off = table_error(model, None, log, None, {1.0: higher, -1.0: higher}, {"cutoff": 50.0})
    forward = table_error(model, None, log, None, {1.0: higher, -1.0: side}, {"cutoff": 50.0})
    assert exact[1] < 0.05 * off[1]
    assert off[1] == pytest.approx(2.0, rel=0.1)
    assert off[0] >= off[1]
    assert forward[1] == pytest.approx(2.0 / math.sqrt(2.0), rel=0.2)


def test_a_table_of_another_kind_of_axis_or_without_effort_is_refused():
    log, model = sliding_log(), friction.coulomb(F_C=8.0)
    with pytest.raises(InputError, match="log: is not of the same kind of axis"):
        table_error(friction.coulomb(F_C=8.0, kind="rotational"), None, log, None, {}, {})
    with pytest.raises(InputError, match="log: has no effort"):
        table_error(model, None, replace(log, effort=None), None, {}, {})


def curve_band(fit):
    return [half for _, half in steady_curve(fit, band=True)]


def with_draws(fit, **draws):
    bands = Bands(
        {name: np.asarray(values) for name, values in draws.items()},
        scatter=0.0,
        noise=0.0,
        unexplained=0.0,
    )
    return replace(fit, resampling=Resampling(bands, scatter=None, half_cycles=0, resolution=0.0))


def test_the_band_of_the_curve_is_wider_where_its_parameters_are_less_certain(fit):
    assert curve_band(fit) == []  # without draws
    deviations = np.random.default_rng(3).normal(size=32)
    F_C, F_v = fit.friction.values["F_C"], fit.friction.values["F_v"]
    velocity = np.array([v for v, _ in steady_curve(fit)])
    by_level = np.array(curve_band(with_draws(fit, F_C=F_C * (1.0 + 0.01 * deviations))))
    assert by_level == pytest.approx(np.full(velocity.size, by_level[0]), rel=1e-6)
    assert 0.5 < by_level[0] / (1.96 * 0.01 * F_C) < 2.0
    by_slope = np.array(curve_band(with_draws(fit, F_v=F_v * (1.0 + 0.01 * deviations))))
    forward = by_slope[velocity > 0.0]
    assert np.all(np.diff(forward) >= 0.0)
    assert forward[-1] == pytest.approx(by_level[0] * F_v * velocity[-1] / F_C, rel=1e-3)
    doubled = curve_band(with_draws(fit, F_v=F_v * (1.0 + 0.02 * deviations)))
    assert doubled == pytest.approx(2.0 * by_slope, rel=1e-6)


HARDENING = {"alpha": 5e4, "beta": 1e3, "gamma": 0.8, "delta": -1.1}


def test_a_force_that_hardens_without_bound_has_no_steady_curve(curved):
    hardening = replace(curved, friction=friction.bouc_wen_classic(**HARDENING))
    with warnings.catch_warnings(action="error"):
        assert (drive_table(hardening), steady_curve(hardening), level_values(hardening)) == (
            [],
            [],
            None,
        )
        (drawn,) = with_draws(hardening, beta=[1e6]).resampling.bands.models(hardening.friction, 1)
        assert reversal_distance(drawn, 0.1) == 0.0
    with pytest.raises(InputError, match="not finite"):
        steady_force(hardening.friction, 0.1)


@pytest.mark.slow
def test_draws_that_harden_without_bound_widen_the_band_of_the_curve(curved):
    bounded, delta = (
        replace(curved, friction=friction.bouc_wen_classic(**(HARDENING | {"delta": 0.3}))),
        0.3 * np.linspace(0.8, 1.2, 6),
    )
    with warnings.catch_warnings(action="error"):
        narrow, wide, open_ended = (
            curve_band(with_draws(bounded, delta=np.where(np.arange(6) < count, -1.1, delta)))
            for count in (0, 2, 3)
        )
    assert len(narrow) == len(steady_curve(bounded))
    assert np.all(np.array(wide) > 1.1 * np.array(narrow))
    assert np.all(np.isfinite(wide))
    assert open_ended == []


@pytest.mark.parametrize(
    ("model", "distance", "tolerance"),
    [
        # From -F to F the force is F (1 - 2 exp(-x sigma_0 / F)): 5 % of the change of 2 F is left after ln 20, of F alone after ln 40.
        (friction.lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=1e6), math.log(20.0) * 1e-5, 0.1),
        (friction.lugre(F_C=10.0, F_S=10.0, v_S=1e-3, sigma_0=1e8), math.log(20.0) * 1e-7, 0.1),
        # A spring that hardly yields over a tenth of a metre: 95 % of the change are there after 95 % of the way.
        (friction.lugre(F_C=1e4, F_S=1e4, v_S=1.0, sigma_0=1e2), 0.095, 0.01),
        (friction.coulomb(F_C=10.0), 0.0, 0.01),
    ],
)
def test_a_reversal_goes_as_far_as_its_force_changes(model, distance, tolerance):
    assert reversal_distance(model, 0.1) == pytest.approx(distance, rel=tolerance)

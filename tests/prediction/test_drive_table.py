import math
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log, slow_log

from bristle import friction
from bristle.core import InputError
from bristle.engine.contact import steady_force
from bristle.identification import identify
from bristle.prediction import drive_table
from bristle.prediction.drive_table import largest_deviation


@pytest.fixture(scope="module")
def fit():
    return identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0).best


@pytest.fixture(scope="module")
def curved():
    """A model whose steady friction bends, on a log of both directions."""
    fit = identify(slow_log(friction.stribeck(F_C=8.0, F_S=11.0, v_S=4e-3, F_v=30.0)), "stribeck", blocks=0, draws=0).best
    return replace(fit, friction=friction.stribeck(F_C=8.0, F_S=11.0, v_S=1e-3, F_v=30.0))


def test_it_covers_the_velocities_of_the_log(curved):
    fit = curved
    table = drive_table(fit)
    velocities = [velocity for velocity, _ in table]
    assert len(table) == 20
    assert velocities == sorted(velocities)
    assert velocities[0] == pytest.approx(np.min(fit.traces.velocity))
    assert velocities[-1] == pytest.approx(np.max(fit.traces.velocity))
    assert np.diff(velocities[10:])[:-1].max() < 0.3 * np.diff(velocities)[-1]


def test_straight_friction_takes_no_more_than_its_ends(fit):
    table = drive_table(fit)
    assert len(table) == 4
    assert largest_deviation(fit, table) < 1e-5


def test_no_other_places_come_closer_to_the_model(curved):
    table = drive_table(curved)
    deviation = largest_deviation(curved, table)
    assert 0.0 < deviation < 0.02 * 11.0
    top = table[-1][0]
    for power in (1.0, 2.0, 3.0):
        speeds = top * np.linspace(0.0, 1.0, 10) ** power
        other = [(v, steady_force(curved.friction, max(v, 1e-12))) for v in speeds.tolist()]
        assert largest_deviation(curved, other) > 1.5 * deviation
    for number in range(11, 19):
        velocity = 0.8 * table[number][0] + 0.2 * table[number + 1][0]
        moved = [*table[:number], (velocity, steady_force(curved.friction, velocity)), *table[number + 1 :]]
        assert largest_deviation(curved, moved) >= deviation


def test_the_deviation_is_the_largest_gap_to_the_model(curved):
    coarse = [(-0.04, -9.2), (-0.0, -11.0), (0.0, 11.0), (0.04, 9.2)]
    speeds = np.linspace(1e-6, float(np.max(curved.traces.velocity)), 4000)
    gaps = [abs(np.interp(v, [0.0, 0.04], [11.0, 9.2]) - steady_force(curved.friction, v)) for v in speeds.tolist()]
    assert largest_deviation(curved, coarse) == pytest.approx(max(gaps), rel=0.05)


def test_standstill_has_one_entry_for_each_side(fit):
    (below, force_below), (above, force_above) = (entry for entry in drive_table(fit) if entry[0] == 0.0)
    assert math.copysign(1.0, below) == -1.0
    assert math.copysign(1.0, above) == 1.0
    values = fit.friction.values
    assert 0.5 * (force_above - force_below) == pytest.approx(values["F_C"], rel=1e-6)
    assert 0.5 * (force_above + force_below) == pytest.approx(values["offset"], rel=1e-6)


@pytest.mark.parametrize("v", [-0.2, -3e-3, -1e-9, 1e-9, 1e-4, 4e-3, 0.5])
def test_bristles_settle_to_the_static_map(v):
    sliding = {"F_C": 8.0, "F_S": 11.0, "v_S": 4e-3}
    bristles = friction.lugre(sigma_0=1e5, sigma_1=60.0, sigma_2=30.0, **sliding)
    assert steady_force(bristles, v) == pytest.approx(steady_force(friction.stribeck(F_v=30.0, **sliding), v), rel=1e-9)


def test_a_model_with_memory_settles_to_its_level():
    model = friction.maxwell_slip(F_C=8.0, k_i=[1e4, 2e5, 3e6], nu_i=[0.2, 0.5, 0.3])
    assert steady_force(model, 1e-7) == pytest.approx(8.0, rel=1e-9)
    assert steady_force(model, -2.0) == pytest.approx(-8.0, rel=1e-9)


def test_a_log_of_one_direction_gives_a_table_of_one_direction(curved):
    forward = replace(curved.traces, velocity=np.abs(curved.traces.velocity))
    table = drive_table(replace(curved, traces=forward), entries=12)
    assert len(table) == 12
    assert all(math.copysign(1.0, velocity) > 0.0 for velocity, _ in table)


@pytest.mark.parametrize("entries", [3, 1001, 7.5])
def test_a_size_out_of_range_is_refused(fit, entries):
    with pytest.raises(InputError, match="entries"):
        drive_table(fit, entries=entries)


def test_an_odd_size_is_not_exceeded(curved):
    assert len(drive_table(curved, entries=15)) == 14

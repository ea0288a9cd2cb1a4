"""Standard errors of least squares, against those that textbooks give for a mean and a straight line."""

import numpy as np
import pytest
from scipy import stats
from tests.identification.known_logs import Motion, log_of, sliding_effort
from tests.identification.test_redundancy import one_way

from bristle.core import Axis
from bristle.identification import identify
from bristle.identification.problem import _root

BLOCKS = 40  # over which residuals may be correlated
ROWS = 20 * BLOCKS


def one_way_log(**friction):
    # Ten samples a row, and fifty more at either edge.
    motion = Motion(*(signal[: 10 * ROWS + 100] for signal in one_way()))
    return log_of(motion, sliding_effort(motion, **friction))


def test_a_level_alone_is_a_mean():
    log, message = one_way_log(F_v=0.0, offset=0.0), {"mass": 12.0, "offset": 0.0, "axis": Axis(held=False)}
    fit = identify(log, "coulomb", blocks=0, draws=0, **message).best
    level, friction = fit.parameters["F_C"], fit.traces.friction
    assert friction.size == ROWS
    assert level.value == pytest.approx(friction.mean())
    assert level.std == pytest.approx(stats.sem(friction), rel=1e-9)
    # For errors that last: of the means over blocks, which are independent then.
    assert level.robust_std == pytest.approx(stats.sem(friction.reshape(BLOCKS, -1).mean(axis=1)), rel=1e-9)


def test_viscous_friction_with_an_offset_is_a_straight_line():
    fit = identify(one_way_log(F_C=0.0), "viscous", mass=12.0, blocks=0, draws=0).best
    line = stats.linregress(fit.traces.velocity, fit.traces.friction)
    slope, intercept = (fit.parameters[name] for name in ("F_v", "offset"))
    assert (slope.value, intercept.value) == pytest.approx((line.slope, line.intercept), rel=1e-6)
    assert (slope.std, intercept.std) == pytest.approx((line.stderr, line.intercept_stderr), rel=1e-6)


def test_of_a_variance_that_rounding_left_below_nothing_no_error_is_known():
    with np.errstate(all="raise"):
        assert _root(np.array([-1e-30, 0.0, 4.0])).tolist() == [np.inf, 0.0, 2.0]

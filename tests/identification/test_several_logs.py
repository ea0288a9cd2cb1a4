"""Several logs of one axis: fitted together, each held out in turn."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, sliding_log

from bristle.core import InputError
from bristle.core.axis import Axis
from bristle.identification import identify

pytestmark = pytest.mark.usefixtures("of_one_mass")


LOGS = [sliding_log(seed) for seed in (1, 2)]


def test_logs_are_fitted_together_and_each_is_held_out_in_turn():
    logs = [sliding_log(seed, noise=1.0) for seed in (1, 2, 3)]
    alone = identify(logs[0], "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    identification = identify(logs, "coulomb_viscous", axis=STATED, draws=0)
    for name, true in TRUTH.items():
        estimate = identification.best.parameters[name]
        assert abs(estimate.value - true) < 4.0 * estimate.larger_std, name
    # Three times the rows, and no row between the logs.
    assert identification.best.parameters["F_C"].std < 0.75 * alone.parameters["F_C"].std
    assert identification.treatment["rows"] == pytest.approx(3 * alone.traces.time.size, rel=0.01)
    assert identification.best.held_out.of == "logs"
    assert len(identification.best.held_out.block_errors_percent) == 3
    assert identification.further_logs == tuple(logs[1:])
    assert np.all(np.diff(identification.best.traces.time) > 0.0)


def test_a_different_log_has_a_large_held_out_error():
    odd = sliding_log(4, F_C=16.0)
    errors = identify([*LOGS, odd], "coulomb_viscous", axis=STATED, draws=0).best.held_out.block_errors_percent
    assert errors[2] > 1.5 * max(errors[:2])


def test_each_log_has_its_axis_or_one_axis_is_shared():
    logs, axes = LOGS, [replace(STATED, resolution=step) for step in (1e-7, 1e-6)]
    both, shared = (identify(logs, "coulomb_viscous", axis=axis, blocks=0, draws=0).best for axis in (axes, axes[0]))
    assert both.parameters["M"].value == pytest.approx(shared.parameters["M"].value, rel=1e-3)


MOTION = sines(dt=2e-3)
SLOWER = log_of(MOTION, sliding_effort(MOTION))


@pytest.mark.parametrize(
    ("logs", "axis", "told"),
    [
        (LOGS[:1], [Axis(resolution=1e-7), Axis(resolution=1e-6)], r"2 axis files for 1 log; allowed 1 axis file"),
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

"""Several logs of one axis: fitted together, each held out in turn."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, log_of, sines, sliding_effort, sliding_log

from bristle.core import InputError
from bristle.core.axis import Axis
from bristle.identification import identify

pytestmark = pytest.mark.usefixtures("of_one_mass")


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
    errors = identify([sliding_log(1), sliding_log(2), odd], "coulomb_viscous", axis=STATED, draws=0).best.held_out.block_errors_percent
    assert errors[2] > 1.5 * max(errors[:2])


def test_each_log_has_its_axis_or_one_axis_is_shared():
    first, second = sliding_log(1), sliding_log(2)
    axes = [replace(STATED, resolution=step) for step in (1e-7, 1e-6)]
    both = identify([first, second], "coulomb_viscous", axis=axes, blocks=0, draws=0).best
    item = identify([first, second], "coulomb_viscous", axis=axes[0], blocks=0, draws=0).best
    assert both.parameters["M"].value == pytest.approx(item.parameters["M"].value, rel=1e-3)
    with pytest.raises(InputError, match=r"2 axis files for 1 log; allowed 1 axis file"):
        identify([first], "coulomb_viscous", axis=axes, draws=0)
    with pytest.raises(InputError, match="names no log"):
        identify([], "coulomb_viscous", axis=STATED, draws=0)


def test_incompatible_logs_are_rejected_by_name():
    first, motion = sliding_log(1), sines(dt=2e-3)
    slower = log_of(motion, sliding_effort(motion))
    with pytest.raises(InputError, match="was sampled every 2 ms, the first log every 1 ms"):
        identify([first, slower], "coulomb_viscous", cutoff=20.0, draws=0)
    with pytest.raises(InputError, match="different cutoff than the first log"):
        identify([first, sliding_log(2)], "coulomb_viscous", axis=[Axis(cutoff=50.0), Axis(cutoff=40.0)], draws=0)
    with pytest.raises(InputError, match="a different kind of axis"):
        identify([first, replace(sliding_log(2), kind="rotational")], "coulomb_viscous", axis=STATED, draws=0)

"""`bristle tune` in LinuxCNC's HAL: an axis tuned and restored, and restored after kills."""

import time

import numpy as np
import pytest
from tests.tune.conftest import killed
from tests.tune.linuxcnc.session import axis

from bristle.files import read_machine
from bristle.tune import Limits, MachineStoppedError, Options, tune, undo
from bristle.tune.journal import Journal
from bristle.tune.machines import connected

pytestmark = pytest.mark.slow
SEED = 105
OPTIONS = Options(models="dahl", duration=20.0)


def test_an_axis_is_tuned_and_restored(tmp_path):
    with axis(SEED, tmp_path) as (hal, file, _):
        links, functions = hal.links(), hal.functions("servo")
        result = tune(file, tmp_path / "out", move=True, options=OPTIONS)
        assert result.outcome == "kept", result.reason
        assert result.change_percent is not None
        assert result.change_percent < -50.0
        assert hal.get("bristle-guard.gain-now")[0] == pytest.approx(result.facts["comparison"]["gain"], abs=1e-6)
        assert undo(tmp_path / "out").outcome == "undone"
        assert (hal.links(), hal.functions("servo")) == (links, functions)


def test_a_killed_run_loses_its_gain_and_is_restored(tmp_path):
    # Behind the first of these lines the motor gets a test effort, behind the last the whole feedforward.
    places = {("check", 3): 0.0, ("stages", 1): 0.0, ("stages", 6): 0.9}
    with axis(SEED, tmp_path) as (hal, file, _):
        links, functions = hal.links(), hal.functions("servo")
        for place, gain in places.items():
            assert killed(place, lambda: tune(file, tmp_path / "out", move=True, options=OPTIONS))
            assert hal.get("bristle-guard.gain-now")[0] >= gain
            time.sleep(2.5)  # the patience of the guard, and its ramp
            assert hal.get("bristle-guard.gain-now")[0] == 0.0
            assert hal.get("bristle-guard.ok", "bristle-guard.why") == [0.0, 4.0]
            assert hal.get("bristle-guard.total") == pytest.approx(hal.get("pid.0.output"), abs=1.0)
            tune(file, tmp_path / "out", options=OPTIONS)
            assert (hal.links(), hal.functions("servo")) == (links, functions)
            assert Journal(tmp_path / "out").last("restored")["identical"]


def test_an_overrun_of_the_sampler_is_refused_with_its_number(tmp_path, monkeypatch):
    monkeypatch.setattr("bristle.tune.linuxcnc.machine.DEPTH", 3000)
    with axis(SEED, tmp_path) as (hal, file, _):
        machine = connected(read_machine(file))
        state = machine.state()
        machine.arm(Limits(1.0, 1e6, (-1.0, 1.0)))
        with pytest.raises(MachineStoppedError, match=r"the sampler lost \d{2,} rows") as stopped:
            machine.record(np.zeros(2900), lambda: None)
        assert stopped.value.reason == "lost_samples"
        machine.restore(state)
        assert hal.components() == state["components"]

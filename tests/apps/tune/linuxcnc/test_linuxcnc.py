"""`bristle tune` in LinuxCNC's HAL: an axis tuned and restored, and restored after kills."""

import json
import time

import numpy as np
import pytest
from tests.apps.tune.conftest import killed
from tests.apps.tune.linuxcnc.session import axis, start

from bristle.apps.tune import (
    Limits,
    MachineRefusedError,
    MachineStoppedError,
    Options,
    save,
    tune,
    undo,
)
from bristle.apps.tune.journal import Journal
from bristle.apps.tune.machines import connected
from bristle.apps.tune.run import rms
from bristle.files import read_machine

pytestmark = pytest.mark.slow
SEED = 105
OPTIONS = Options(models="dahl", duration=20.0)


def test_an_axis_is_tuned_and_restored(tmp_path):
    with axis(SEED, tmp_path) as (hal, file, cycle):
        links, functions = hal.links(), hal.functions("servo")
        result = tune(file, tmp_path / "out", move=True, options=OPTIONS)
        assert result.outcome == "kept", result.reason
        assert result.change_percent is not None
        assert result.change_percent < -50.0
        time.sleep(0.5)
        assert hal.get("bristle-guard.gain-now")[0] == pytest.approx(
            result.facts["comparison"]["gain"], abs=1e-6
        )
        _saved_and_restarted(
            hal, file, cycle, result.facts["comparison"]["changes"]["following_error.rms"]["before"]
        )
        assert undo(tmp_path / "out").outcome == "undone"
        assert (hal.links(), hal.functions("servo")) == (links, functions)
        assert list((tmp_path / "config").iterdir()) == []


def _saved_and_restarted(hal, file, cycle, without):
    """Save the kept feedforward, restart HAL, load the saved file, and compare."""
    out, saved, motion = (
        file.parent / "out",
        file.parent / "config/bristle.hal",
        1e-3 * np.tile(cycle, 4),
    )
    machine = connected(read_machine(file))
    with_feedforward, state = machine.record(motion, lambda: None), machine.state()
    result = save(out)
    assert str(saved) in result.facts["save"]["places"]
    assert f"HALFILE = {saved}" in result.facts["save"]["loads"]
    gain = hal.get("bristle-guard.gain-now")
    start(hal, SEED)
    machine = connected(read_machine(file))
    assert machine.state() != state
    with pytest.raises(MachineRefusedError, match="not as the run left it: state: links: "):
        save(out)
    hal.run(*saved.read_text().splitlines())
    time.sleep(0.5)
    assert machine.state() == json.loads(json.dumps(state))
    assert hal.get("bristle-guard.gain-now") == gain
    assert save(out).facts == result.facts
    again = machine.record(motion, lambda: None)
    size = cycle.size
    assert rms(again.error[size:]) == pytest.approx(
        rms(with_feedforward.error[size:]), abs=0.02 * without
    )
    np.testing.assert_allclose(
        again.effort[size:], with_feedforward.effort[size:], atol=0.1 * np.max(np.abs(again.effort))
    )


def test_a_killed_run_loses_its_gain_and_is_restored(tmp_path):
    # Behind the first of these lines the motor gets a test effort, behind the last the whole feedforward.
    places = {("check", 4): 0.0, ("stages", 1): 0.0, ("stages", 9): 0.9}
    with axis(SEED, tmp_path) as (hal, file, _):
        links, functions = hal.links(), hal.functions("servo")
        for place, gain in places.items():
            assert killed(place, lambda: tune(file, tmp_path / "out", move=True, options=OPTIONS))
            assert hal.get("bristle-guard.gain-now")[0] >= gain
            time.sleep(2.5)  # the patience of the guard, and its ramp
            assert hal.get("bristle-guard.gain-now")[0] == 0.0
            assert hal.get("bristle-guard.ok", "bristle-guard.why") == [0.0, 4.0]
            assert hal.get("bristle-guard.total") == pytest.approx(hal.get("pid.0.output"), abs=1.0)
            undo(tmp_path / "out")
            assert (hal.links(), hal.functions("servo")) == (links, functions)
            assert Journal(tmp_path / "out").last("restored")["identical"]


def test_an_overrun_of_the_sampler_is_refused_with_its_number(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "bristle.apps.tune.linuxcnc.machine.LOAD_SAMPLER", "loadrt sampler depth=2000 cfg=fffu"
    )
    with axis(SEED, tmp_path) as (hal, file, _):
        machine = connected(read_machine(file))
        state = machine.state()
        machine.arm(Limits(1.0, 1e6, (-1.0, 1.0)))
        with pytest.raises(MachineStoppedError, match=r"the sampler lost \d{3,} rows") as stopped:
            machine.record(np.zeros(2900), lambda: None)
        assert stopped.value.reason == "lost_samples"
        machine.restore(state)
        assert hal.components() == state["components"]

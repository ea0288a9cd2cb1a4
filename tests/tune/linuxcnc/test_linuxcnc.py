"""`bristle tune` in LinuxCNC's HAL: an axis tuned and restored, and restored after kills."""

import time

import pytest
from tests.tune.conftest import killed
from tests.tune.linuxcnc.session import axis

from bristle.tune import Options, tune, undo
from bristle.tune.journal import Journal

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
    with axis(SEED, tmp_path) as (hal, file, _):
        links, functions = hal.links(), hal.functions("servo")
        for entry in (5, 12, 17):
            last = len(Journal(tmp_path / "out").entries)
            assert killed(last + entry, lambda: tune(file, tmp_path / "out", move=True, options=OPTIONS))
            if "bristle_guard" in hal.components():
                time.sleep(1.0)  # ten seconds of the axis
                assert hal.get("bristle-guard.gain-now")[0] == 0.0
            tune(file, tmp_path / "out", options=OPTIONS)
            assert (hal.links(), hal.functions("servo")) == (links, functions)
            last = Journal(tmp_path / "out").last("restored")
            assert last is None or last["identical"], last

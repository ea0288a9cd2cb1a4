"""The gates of a run, on records that are made here: each lets the right axis pass, and refuses the wrong one by name."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.tune.machine import BenchMachine, written

import bristle as br
from bristle.core.diagnostic import Diagnostic
from bristle.files import read_machine
from bristle.prediction import first_gain
from bristle.tune import MachineRefusedError, Recording, steps
from bristle.tune.journal import Journal
from bristle.tune.run import Options, Run


class Scripted(BenchMachine):
    """A machine whose error, effort and noise at rest are functions of the gain."""

    def __init__(self, bench, *, error=lambda gain: 1e-4 * (1.0 - 0.9 * gain), effort=lambda _: 10.0, noise=lambda _: 0.01):
        super().__init__(bench)
        self.of, self.now = {"error": error, "effort": effort, "noise": noise}, 0.0

    def set(self, *, gain=0.0, offset=0.0):
        self.now = gain

    def load(self, feedforward):
        self.now = 0.0

    def record(self, reference, alive):
        moves = np.gradient(reference)
        wave = moves / max(np.max(np.abs(moves)), 1e-12)
        swing = self.of["noise"](self.now) * np.random.default_rng(1).standard_normal(reference.size) * (moves == 0.0)
        error, effort = self.of["error"](self.now), self.of["effort"](self.now)
        return Recording(reference, reference - error * wave, np.sqrt(2.0) * effort * wave + swing)


@pytest.fixture
def prepared(tmp_path, monkeypatch):
    """Return a function that makes a run on a scripted machine."""
    monkeypatch.setattr(steps, "_feedforward", lambda _: SimpleNamespace(name="bristle_0", lead=0.0))

    def run(**script):
        file, bench, _ = written(tmp_path, 4, 6)
        made = Run(read_machine(file), Scripted(bench, **script), tmp_path, Journal(tmp_path), Options())
        made.step, made.facts["before"] = "stages", {"error": 1e-4}
        return made

    return run


def test_the_gain_with_the_smallest_error_is_taken(prepared):
    run = prepared(error=lambda gain: 1e-4 * (0.1 + abs(gain - 0.5)))
    steps.stages(run)
    assert run.facts["stages"]["gain"] == 0.5


def test_the_safe_gain_keeps_the_effort_within_its_ratio(prepared):
    run = prepared(effort=lambda gain: 10.0 * (1.0 + 0.1 * gain))
    steps.stages(run)
    # 1.05 less one per cent: the effort rises by 4 % at a gain of 0.4
    assert run.facts["stages"]["gain"] == pytest.approx(0.4, abs=0.02)


def test_an_axis_whose_effort_rises_at_once_is_refused(prepared):
    with pytest.raises(MachineRefusedError, match="without a larger effort") as refused:
        steps.stages(prepared(effort=lambda gain: 10.0 * (1.0 + 0.4 * gain)))
    assert refused.value.code == "no_gain"


def test_an_axis_that_hunts_with_the_feedforward_is_refused(prepared):
    with pytest.raises(MachineRefusedError) as refused:
        steps.stages(prepared(noise=lambda gain: 0.01 if gain < 0.4 else 1.0))
    assert refused.value.code == "hunts_with_feedforward"


def test_an_axis_that_hunts_without_feedforward_is_refused(prepared):
    with pytest.raises(MachineRefusedError) as refused:
        steps.before(prepared(noise=lambda _: 6.0))
    assert refused.value.code == "hunts"
    steps.before(prepared(noise=lambda _: 0.5))


def change(before, after, verdict):
    return {"before": before, "after": after, "verdict": verdict}


BETTER = {
    "following_error.rms": change(1.0, 0.1, "lower"),
    "effort.rms": change(1.0, 1.03, "higher"),
    "friction.level": change(1, 2, "higher"),
}


@pytest.mark.parametrize(
    ("changed", "code", "word"),
    [
        ({}, "", ""),
        ({"helped": False}, "not_better", "not significantly lower"),
        ({"ratios": {"settling time": 1.06}}, "something_worse", "settling time"),
        ({"changes": BETTER | {"effort.rms": change(1.0, 1.06, "higher")}}, "something_worse", "effort.rms"),
        ({"changes": BETTER | {"reversals.forward_to_backward": change(1.0, 1.2, "higher")}}, "something_worse", "reversals"),
        ({"changes": BETTER | {"reversals.forward_to_backward": change(1.0, 1.2, "no_change")}}, "", ""),
    ],
)
def test_a_feedforward_stays_only_if_nothing_else_is_worse(prepared, changed, code, word):
    run = prepared()
    run.step = "verdict"
    run.facts["comparison"] = {"helped": True, "gain": 0.5, "ratios": {"settling time": 1.0}, "changes": BETTER} | changed
    if code:
        with pytest.raises(MachineRefusedError, match=word) as refused:
            steps.verdict(run)
        assert (refused.value.code, run.machine.kept) == (code, False)
    else:
        steps.verdict(run)
        assert (run.machine.kept, run.machine.now) == (True, 0.5)


def test_the_effort_precedes_the_motion_by_delay_and_lag(finished):
    machine, _, result = finished
    plant = machine.bench.plant
    # a sampled loop holds its effort: half a sample more
    assert result.facts["identification"]["lead"] == pytest.approx((plant.delay + 0.5) * plant.sample_time + plant.lag, abs=2e-4)


def test_a_model_that_explains_too_little_stops_the_run(identified, monkeypatch):
    make, folder = identified
    run = Run(read_machine(folder / "machine.toml"), make(), folder / "out", Journal(folder / "out"), Options(models="coulomb", draws=0))
    run.step = "identification"
    monkeypatch.setattr(steps, "first_gain", lambda _: 0.0)
    monkeypatch.setattr(steps, "identify", lambda log, *_, **__: br.identify(log, "coulomb_viscous", draws=0))
    with pytest.raises(MachineRefusedError) as refused:
        steps.identification(run)
    assert refused.value.code == "no_usable_model"


def fit(*diagnostics, error=10.0):
    return SimpleNamespace(diagnostics=diagnostics, friction_alone_error_percent=error, plant=SimpleNamespace(values={"k": 1.0}))


@pytest.mark.parametrize(("error", "gain"), [(49.0, 0.25), (51.0, 0.0)])
def test_the_first_gain_needs_a_model_that_explains_half_of_the_friction(error, gain):
    assert first_gain(fit(error=error)) == gain
    assert first_gain(fit(Diagnostic("one_speed"), error=error)) == gain


@pytest.mark.parametrize("fault", [Diagnostic("sign_reversed", severity="error"), Diagnostic("one_direction")])
def test_a_faulty_log_has_no_first_gain(fault):
    assert first_gain(fit(fault, error=1.0)) == 0.0


class Pushed(Scripted):
    """A machine at rest that answers test efforts: along the effort, by its integral action, or with motions of its own."""

    def __init__(self, bench, *, stiffness=np.inf, integral=0.0, wander=0.0):
        super().__init__(bench)
        self.stiffness, self.integral, self.wander = stiffness, integral, wander
        self.random = np.random.default_rng(3)

    def set(self, *, gain=0.0, offset=0.0):
        self.offset = offset

    def record(self, reference, alive):
        still = np.ones(reference.size)
        position = self.offset / self.stiffness + self.wander * self.random.standard_normal()
        return Recording(reference, position * still, (1.0 - self.integral) * self.offset * still)


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        ({"stiffness": 1e7}, ""),
        ({"stiffness": 1e7, "wander": 1e-7}, ""),
        ({"integral": 0.9}, ""),
        ({"stiffness": -1e7}, "wrong_sign"),
        ({}, "no_effect"),
        ({"wander": 1e-4}, "hunts"),
    ],
)
def test_an_answer_to_a_test_effort_is_that_of_the_axis(tmp_path, answer, code):
    file, bench, _ = written(tmp_path, 4, 6)
    run = Run(read_machine(file), Pushed(bench, **answer), tmp_path, Journal(tmp_path), Options())
    if not code:
        found = steps._answer(run)
        assert found["test_effort"] <= 0.04 * run.limits.effort
    else:
        with pytest.raises(MachineRefusedError) as refused:
            steps._answer(run)
        assert refused.value.code == code

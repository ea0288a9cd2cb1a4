"""The gates of a run, on records that are made here: each lets the right axis pass, and refuses the wrong one by name."""

from contextlib import ExitStack
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from tests.apps.tune.machine import BenchMachine, written

from bristle.apps.tune import MachineRefusedError, Recording, steps
from bristle.apps.tune.journal import Journal
from bristle.apps.tune.run import Options, Run
from bristle.core.diagnostic import Diagnostic
from bristle.files import growing_folder, read_machine
from bristle.identification.result import Identification
from bristle.prediction import first_gain


class Scripted(BenchMachine):
    """A machine whose error, effort and noise at rest are functions of the gain."""

    def __init__(
        self,
        bench,
        *,
        error=lambda gain: 1e-4 * (1.0 - 0.9 * gain),
        effort=lambda _: 10.0,
        noise=lambda _: 0.01,
    ):
        super().__init__(bench)
        self.of, self.now = {"error": error, "effort": effort, "noise": noise}, 0.0

    def set(self, *, gain=0.0, offset=0.0):
        self.now = gain

    def load(self, feedforward):
        self.now = 0.0

    def record(self, reference, alive):
        moves = np.gradient(reference)
        wave = moves / max(np.max(np.abs(moves)), 1e-12)
        swing = (
            self.of["noise"](self.now)
            * np.random.default_rng(1).standard_normal(reference.size)
            * (moves == 0.0)
        )
        error, effort = self.of["error"](self.now), self.of["effort"](self.now)
        return Recording(reference, reference - error * wave, np.sqrt(2.0) * effort * wave + swing)


@pytest.fixture
def prepared(tmp_path, monkeypatch):
    """Return a function that makes a run on a scripted machine."""
    with ExitStack() as folders:
        yield preparing(tmp_path, monkeypatch, folders)


def preparing(tmp_path, monkeypatch, folders):
    monkeypatch.setattr(
        steps,
        "_feedforward",
        lambda _, identified: SimpleNamespace(name=identified["results"], lead=0.0),
    )

    def run(**script):
        file, bench, _ = written(tmp_path, 4, 6)
        grown, _ = folders.enter_context(
            growing_folder(tmp_path / f"run-{len(list(tmp_path.iterdir()))}", "run")
        )
        made = Run(
            read_machine(file), Scripted(bench, **script), grown, Journal(grown.path), Options()
        )
        made.step = "stages"
        made.facts |= {
            "before": {"error": 1e-4},
            "identification": {"results": "results", "usable": True},
        }
        return made

    return run


@pytest.mark.parametrize(
    ("script", "gain"),
    [
        ({"error": lambda gain: 1e-4 * (0.1 + abs(gain - 0.5))}, 0.5),
        # 1.05 less one per cent: the effort rises by 4 % at a gain of 0.4
        ({"effort": lambda gain: 10.0 * (1.0 + 0.1 * gain)}, pytest.approx(0.4, abs=0.02)),
        ({"error": lambda gain: 1e-4 * (1.0 - gain if gain < 0.4 else 1.6)}, 0.25),
    ],
    ids=["smallest error", "effort within its ratio", "larger error ends the ladder"],
)
def test_the_best_harmless_gain_is_taken(prepared, script, gain):
    run = prepared(**script)
    steps.stages(run)
    assert run.facts["stages"]["gain"] == gain


@pytest.mark.parametrize(
    ("script", "code", "words"),
    [
        ({"effort": lambda gain: 10.0 * (1.0 + 0.4 * gain)}, "no_gain", "without a larger effort"),
        (
            {"error": lambda gain: 1e-4 * (1.0 + 0.4 * gain)},
            "worse",
            r"at gain 0\.25 the following error is 110%",
        ),
        ({"noise": lambda gain: 0.01 if gain < 0.4 else 1.0}, "hunts_with_feedforward", "."),
    ],
    ids=lambda item: item if isinstance(item, str) else "",
)
def test_an_axis_without_a_harmless_gain_is_refused(prepared, script, code, words):
    with pytest.raises(MachineRefusedError, match=words) as refused:
        steps.stages(prepared(**script))
    assert refused.value.code == code


def test_an_effort_that_does_negative_work_is_refused(prepared):
    run = prepared(effort=lambda _: -10.0)
    with pytest.raises(MachineRefusedError, match="negative work") as refused:
        steps.warm_up(run)
    assert refused.value.code == "wrong_sign"


@pytest.mark.slow
def test_an_axis_that_hunts_without_feedforward_is_refused(prepared):
    with pytest.raises(MachineRefusedError) as refused:
        steps.before(prepared(noise=lambda _: 6.0))
    assert refused.value.code == "hunts"
    steps.before(prepared(noise=lambda _: 0.5))


def test_a_single_slip_at_rest_is_not_hunting(prepared):
    noises = iter([0.01, 1.0, *10 * [0.01]])  # one record at gain 0.25 swings
    run = prepared(noise=lambda _: next(noises))
    steps.stages(run)
    assert run.facts["stages"]["gain"] == 1.0


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    ("usable", "refined", "noise", "used"),
    [
        (True, 0.5, 0.01, "refined"),
        (True, 1.5, 0.01, "results"),
        (False, 0.5, 0.01, "results"),
        (True, 0.5, 1.0, "results"),
    ],
)
def test_the_better_of_both_feedforwards_goes_on(
    prepared, monkeypatch, usable, refined, noise, used
):
    """The second feedforward is used if it is usable, does not make the axis hunt, and leaves a smaller error."""
    loaded = ["results"]
    run = prepared(
        error=lambda gain: (
            1e-4 * (1.0 - 0.5 * gain * (2.0 - refined if loaded[-1] == "refined" else 1.0))
        ),
        noise=lambda gain: noise if gain > 0.9 and loaded[-1] == "refined" else 0.01,
    )
    monkeypatch.setattr(run.machine, "load", lambda feedforward: loaded.append(feedforward.name))
    monkeypatch.setattr(steps, "_to_refine", lambda run: run.motion(1))
    monkeypatch.setattr(
        steps, "_identified", lambda run, record, folder: {"usable": usable, "results": folder}
    )
    steps.stages(run)
    run.step = "refinement"
    steps.refinement(run)
    assert (run.facts["refinement"]["results"], loaded[-1]) == (used, used)
    assert run.facts["refinement"]["gain"] == 1.0


def compared(run):
    """The facts of a comparison at gain 1."""
    run.step, run.facts["refinement"] = "comparison", {"gain": 1.0}
    steps.comparison(run)
    return run.facts["comparison"]


@pytest.mark.slow
def test_records_alternate_so_that_a_drift_cancels(prepared):
    run, gains = prepared(), []
    record = run.machine.record
    run.machine.record = lambda reference, alive: (
        gains.append(run.machine.now) or record(reference, alive)
    )
    facts = compared(run)
    places = {
        gain: np.array([place for place, own in enumerate(gains) if own == gain])
        for gain in (0.0, 1.0)
    }
    for power in (0, 1, 2):
        assert np.sum(places[0.0] ** power) == np.sum(places[1.0] ** power)
    assert facts["changes"]["following_error.rms"]["change_percent"] == pytest.approx(
        -90.0, abs=0.5
    )
    times = [log.time.values for log in (*run.compared.logs_before, *run.compared.logs_after)]
    spans = sorted((time[0], time[-1]) for time in times)
    assert all(end < begin for (_, end), (begin, _) in pairwise(spans))


@pytest.fixture
def uncompared(monkeypatch):
    """The logs of both sides are not compared: for what follows from their records."""
    monkeypatch.setattr(
        steps, "compare", lambda *logs, axis: SimpleNamespace(changes={}, helped=True)
    )
    monkeypatch.setattr(Run, "log", lambda self, name: name)


@pytest.mark.usefixtures("uncompared")
@pytest.mark.parametrize(
    ("noise", "expected"),
    [
        (lambda gain: 1.0 + gain, 2.0),
        (lambda gain: 0.05 + 0.2 * gain, 1.0),  # less than a twentieth of the effort in motion
    ],
)
def test_the_noise_at_rest_of_both_sides_is_compared_above_a_share_of_the_effort(
    prepared, noise, expected
):
    found = compared(prepared(noise=noise))["ratios"]["noise at rest"]
    assert found["value"] == pytest.approx(expected, rel=1e-6)
    assert found["interval"] == pytest.approx([expected, expected], rel=1e-3)


@pytest.mark.slow
@pytest.mark.usefixtures("uncompared")
def test_the_noise_of_an_encoder_count_does_not_count(prepared):
    def toggling(counts):
        run = prepared(noise=lambda gain: 1.0 + 0.5 * gain)
        record, size = run.machine.record, counts * run.axis.resolution

        def toggled(reference, alive):
            found = record(reference, alive)
            side = np.sign(np.random.default_rng(2).standard_normal(reference.size))
            return Recording(found.reference, found.position + 0.5 * size * side, found.effort)

        run.machine.record = toggled
        return compared(run)["ratios"]["noise at rest"]["value"]

    assert toggling(1) == pytest.approx(1.0)
    assert toggling(20) == pytest.approx(1.5, rel=1e-3)


def test_ratios_have_the_interval_of_records_as_replicates():
    before, after = [1.0, 1.3, 0.9, 1.1], [2.0, 2.8, 1.7, 2.5]
    found = steps._ratio(before, after)
    ends = stats.ttest_ind(np.log(after), np.log(before), equal_var=False).confidence_interval()
    assert found["interval"] == pytest.approx(np.exp(ends).tolist())
    assert found["value"] == pytest.approx(stats.gmean(after) / stats.gmean(before))


def test_the_settling_time_is_that_of_all_stops(prepared):
    run = prepared()
    step, rest = run.sample_time, np.zeros(500)
    move = np.linspace(0.0, 1e-3, 200)
    reference = np.concatenate([rest, move, rest + 1e-3, move[::-1], rest])
    # The error enters its band of a quarter of 1e-4 after 100 ms and 400 ms.
    away = np.zeros(reference.size)
    away[: 700 + 100] = away[900 + 300 : 1400 + 400] = 1e-4
    assert steps._settling(run, Recording(reference, reference - away, away)) == pytest.approx(
        np.sqrt(0.1 * 0.4), rel=0.02
    )
    assert steps._settling(run, Recording(reference, reference, away)) == pytest.approx(0.05)
    assert step == 1e-3


def change(before, after, verdict):
    return {"before": before, "after": after, "verdict": verdict}


def ratio(value, low, high):
    return {"value": value, "interval": [low, high]}


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
        ({"ratios": {"settling time": ratio(1.06, 1.01, 1.4)}}, "something_worse", "settling time"),
        ({"ratios": {"settling time": ratio(1.04, 1.01, 1.4)}}, "", ""),
        ({"ratios": {"settling time": ratio(1.2, 0.99, 1.4)}}, "", ""),
        ({"ratios": {"noise at rest": ratio(1.6, 0.5, 8.0)}}, "something_worse", "noise at rest"),
        (
            {"changes": BETTER | {"effort.rms": change(1.0, 1.06, "higher")}},
            "something_worse",
            "effort.rms",
        ),
        (
            {"changes": BETTER | {"reversals.forward_to_backward": change(1.0, 1.2, "higher")}},
            "something_worse",
            "reversals",
        ),
        (
            {"changes": BETTER | {"reversals.forward_to_backward": change(0.2, 0.9, "higher")}},
            "",
            "",
        ),
        (
            {"changes": BETTER | {"reversals.forward_to_backward": change(1.0, 1.2, "no_change")}},
            "",
            "",
        ),
    ],
)
def test_a_feedforward_stays_only_if_nothing_else_is_worse(prepared, changed, code, word):
    run = prepared()
    run.step = "verdict"
    run.facts["refinement"] = {"results": "results"}
    run.facts["comparison"] = {
        "helped": True,
        "gain": 0.5,
        "ratios": {"settling time": ratio(1.0, 1.0, 1.0)},
        "changes": BETTER,
    } | changed
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
    assert result.facts["identification"]["lead"] == pytest.approx(
        (plant.delay + 0.5) * plant.sample_time + plant.lag, abs=2e-4
    )


def test_a_model_that_explains_too_little_stops_the_run(prepared, monkeypatch):
    found = {"usable": False, "verdict": "Not usable", "reasons": ["one", "two", "three"]}
    monkeypatch.setattr(steps, "_identified", lambda run, record, folder: found)
    with pytest.raises(MachineRefusedError, match="Not usable: one; two") as refused:
        steps.identification(prepared())
    assert refused.value.code == "no_usable_model"


def test_an_interrupted_identification_ends_the_run(identified, monkeypatch):
    make, folder = identified
    run = Run(
        read_machine(folder / "machine.toml"),
        make(),
        folder / "out",
        Journal(folder / "out"),
        Options(models="coulomb", draws=0),
    )
    run.step = "identification"
    monkeypatch.setattr(
        steps, "identify", lambda log, *_, **__: Identification((), log, unfinished="interrupted")
    )
    with pytest.raises(KeyboardInterrupt):
        steps.identification(run)


def fit(*diagnostics, error=10.0):
    return SimpleNamespace(
        diagnostics=diagnostics,
        friction_alone_error_percent=error,
        plant=SimpleNamespace(values={"k": 1.0}),
    )


@pytest.mark.parametrize(("error", "gain"), [(49.0, 0.25), (51.0, 0.0)])
def test_the_first_gain_needs_a_model_that_explains_half_of_the_friction(error, gain):
    assert first_gain(fit(error=error)) == gain
    assert first_gain(fit(Diagnostic("one_speed"), error=error)) == gain


@pytest.mark.parametrize(
    "fault", [Diagnostic("sign_reversed", severity="error"), Diagnostic("one_direction")]
)
def test_a_faulty_log_has_no_first_gain(fault):
    assert first_gain(fit(fault, error=1.0)) == 0.0


class Pushed(Scripted):
    """A machine at rest that answers test efforts: along the effort, by its integral action, or with motions of its own."""

    def __init__(
        self,
        bench,
        *,
        stiffness=np.inf,
        integral=0.0,
        wander=0.0,
        overshoots=0.0,
        net=-1.0,
        against=0.0,
        growth=1.0,
    ):
        super().__init__(bench)
        self.growth, self.count = growth, -1
        self.overshoots, self.net, self.against = overshoots, net, against
        self.stiffness, self.integral, self.wander = stiffness, integral, wander
        self.random = np.random.default_rng(3)

    def set(self, *, gain=0.0, offset=0.0):
        self.offset = offset

    def record(self, reference, alive):
        still = np.ones(reference.size)
        # The integral action may reverse the net effort of a small test effort.
        net = self.net if abs(self.offset) < self.overshoots else 1.0 - self.integral
        side = -1.0 if abs(self.offset) < self.against else 1.0
        self.count += 1
        stretch = self.growth ** (self.count % 6)
        position = (
            side * np.sign(net) * stretch * self.offset / self.stiffness
            + self.wander * self.random.standard_normal()
        )
        return Recording(reference, position * still, net * self.offset * still)


@pytest.mark.parametrize(
    ("answer", "code"),
    [
        ({"stiffness": 1e7}, ""),
        ({"stiffness": 1e7, "wander": 1e-7}, ""),
        ({"integral": 0.9}, ""),
        ({"stiffness": 1e5, "overshoots": 2.0}, ""),
        ({"stiffness": 1e6, "growth": 1.45}, ""),
        ({"stiffness": 1e5, "overshoots": 20.0, "net": -0.1}, ""),
        ({"stiffness": 1e5, "overshoots": 20.0, "net": -1.0}, ""),
        ({"stiffness": 1e5, "against": 2.0}, "wrong_sign"),
        ({"stiffness": -1e7}, "wrong_sign"),
        ({}, "no_effect"),
        ({"wander": 1e-4}, "hunts"),
    ],
)
def test_an_answer_to_a_test_effort_is_that_of_the_axis(tmp_path, answer, code):
    file, bench, _ = written(tmp_path, 4, 6)
    with growing_folder(tmp_path / "out", "run") as (grown, _):
        run = Run(
            read_machine(file), Pushed(bench, **answer), grown, Journal(grown.path), Options()
        )
        if not code:
            found = steps._answer(run)
            assert found["test_effort"] <= 0.04 * run.limits.effort
        else:
            with pytest.raises(MachineRefusedError) as refused:
                steps._answer(run)
            assert refused.value.code == code

"""Simulated signals and their replicates: disturbances, their size, and held-out parts."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from bristle import controllers, friction
from bristle.core import Axis, InputError
from bristle.identification import output_error
from bristle.identification.half_cycles import Disturbance, Groups
from bristle.identification.output_error import (
    LAG,
    Changed,
    OutputError,
    SignalReplicates,
    Simulation,
    loop_of,
)
from bristle.identification.outputs import Effort, Mechanism, Position
from bristle.logs.log import Log
from bristle.models.plants import inertia

COUNT, CYCLES = 12_000, 3000
INDEX = np.arange(COUNT) // (COUNT // CYCLES)
SPLIT = 5002  # samples of the first segment, which ends within a half-cycle


def output(count, **more):
    """A segment whose signal is 7 everywhere, which reads the push alone."""
    return SimpleNamespace(
        measured=np.zeros(count),
        position=np.zeros(count),
        simulated=lambda mechanism: np.full(count, 7.0),
        leaning=lambda mechanism, slope: slope,
        read=lambda mechanism, pure, push, disturbance, rng: push,
        **more,
    )


def disturbance_with(**sizes):
    """One that has these causes alone."""
    return Disturbance(**({"scatter": 0.0, "noise": 0.0, "resolution": 0.0} | sizes))


def drawn(slope=1.0, left=0.0, side=1.0, seed=3, **disturbed):
    """The change of a log of two segments, drawn anew."""
    error = SimpleNamespace(
        outputs=(output(SPLIT), output(COUNT - SPLIT)),
        half_cycles=Groups(INDEX),
        mechanism=lambda values: values,
    )
    replicates = SignalReplicates(error, {}, np.full(COUNT, slope), np.full(COUNT, left))
    return replicates.draw(disturbance_with(**disturbed), np.random.default_rng(seed), side)


@pytest.mark.parametrize("scatter", [0.05, 0.2])
def test_each_half_cycle_of_all_segments_has_one_random_level(scatter):
    result = drawn(slope=3.0, scatter=scatter)
    assert result.pure.tolist() == [7.0] * COUNT
    levels = result.change.reshape(CYCLES, -1)
    assert np.all(levels == levels[:, :1])
    assert np.std(levels[:, 0]) == pytest.approx(3.0 * scatter, rel=0.05)
    assert np.mean(levels[:, 0]) == pytest.approx(0.0, abs=3.0 * scatter / 15.0)
    assert np.max(np.abs(levels)) < 3.0 * scatter * 5.0


@pytest.mark.parametrize("unexplained", [0.5, 1.0])
def test_a_residual_keeps_its_size_and_changes_its_sign(unexplained):
    change = drawn(left=2.0, unexplained=unexplained).change
    assert set(change.tolist()) == {-2.0 * unexplained, 2.0 * unexplained}


def test_the_mirror_image_of_a_draw_has_reversed_disturbances():
    there, back = (
        drawn(slope=3.0, left=2.0, scatter=0.1, unexplained=1.0, side=side) for side in (1.0, -1.0)
    )
    assert back.change.tolist() == (-there.change).tolist()
    assert back.pure.tolist() == there.pure.tolist()


def test_a_random_log_has_its_change_as_residual_at_the_solution():
    simulated = np.array([1.0, 2.0, np.nan])
    error = SimpleNamespace(
        parameters=SimpleNamespace(free=("a",), complete=dict),
        simulated=lambda values: values["a"] * simulated,
    )
    changed = Changed(
        SimpleNamespace(error=error, values={"a": 1.0}),
        np.array([1.0, 2.0, 3.0]),
        np.array([0.1, -0.2, 0.3]),
    )
    assert changed.residual({"a": 1.0}).tolist() == [0.1, -0.2, 0.3]
    left = changed.residual({"a": 2.0})
    assert left[:2] == pytest.approx([1.0 + 0.1 - 2.0, 2.0 - 0.2 - 4.0])
    assert left[2] < -1e11  # a signal that left the finite numbers is no fit


def folds_of(*outputs, segments=(1,), **rows):
    """The folds of an error with these outputs, in five parts where there is one."""
    dataset = SimpleNamespace(
        **({"effort": np.zeros(8), "segments": segments, "sample_time": 0.1} | rows)
    )
    return OutputError(SimpleNamespace(dataset=dataset), outputs).folds(5)


def test_a_block_of_each_of_several_segments_is_held_out_with_its_rows():
    of_rows, times = (
        np.array([0, 0, 0, 1, 1, 1, 1, 1]),
        np.array([2.0, 2.12, 2.23, 7.0, 7.12, 7.23, 7.34, 7.45]),
    )
    segments = SimpleNamespace(time=times[:3]), SimpleNamespace(time=times[3:])
    each = [output(5, phase=np.arange(5) / 5, period=5)] * 2
    name, folds = folds_of(*each, segments=segments, segment_of_row=of_rows, time=times)
    assert name == "time blocks"
    assert [np.flatnonzero(fold.held_out).tolist() for fold in folds] == [
        [number, number + 5] for number in range(5)
    ]
    assert [fold.fitted.tolist() for fold in folds] == [(~fold.held_out).tolist() for fold in folds]
    assert [np.flatnonzero(fold.of_dataset).tolist() for fold in folds] == [
        [0, 3],
        [1, 4],
        [2, 5],
        [6],
        [7],
    ]
    # A segment too short for the filters of the rows.
    _, unlike = folds_of(*each, segment_of_row=np.zeros(8))
    assert all(fold.of_dataset.all() for fold in unlike)


def test_a_periodic_log_is_held_out_in_parts_of_its_period():
    period = 10
    phase = np.arange(20) % period / period
    # From 3 s on, in periods of 1 s.
    times = np.array([3.0, 3.15, 3.25, 3.95, 4.05, 4.2, 4.85, 4.99])
    name, folds = folds_of(
        output(20, phase=phase, period=period),
        segments=(SimpleNamespace(time=times),),
        segment_of_row=np.zeros(8, int),
        time=times,
    )
    assert name == "time blocks"
    for number, fold in enumerate(folds):
        assert np.flatnonzero(fold.held_out).tolist() == [
            2 * number,
            2 * number + 1,
            2 * number + 10,
            2 * number + 11,
        ]
        assert np.array_equal(fold.fitted, ~fold.held_out)
    assert [np.flatnonzero(fold.of_dataset).tolist() for fold in folds] == [
        [0, 1, 4],
        [2, 5],
        [],
        [],
        [3, 6, 7],
    ]


TIME = 0.01 * np.arange(200)
LOG = Log(
    time=TIME, position=np.sin(TIME), effort=np.cos(TIME), reference=np.sin(TIME), sample_time=0.01
)
BLIND = Log(time=TIME, position=np.sin(TIME), effort=np.cos(TIME), sample_time=0.01)
LAW = controllers.cascade(k_p=10.0, k_v=200.0)


@pytest.mark.parametrize(
    ("log", "axis", "loop"),
    [
        (LOG, Axis(controller=LAW), Effort),
        (BLIND, Axis(controller=LAW), Position),
        (LOG, Axis(), Position),
        (LOG, None, Position),
        (LOG, Axis(controller=LAW, loop="open"), Position),
        (BLIND, Axis(loop="closed"), Effort),
        (LOG, Axis(controller=LAW, seeks_lag=True), Effort),
    ],
)
def test_the_axis_decides_the_loop_and_else_a_known_loop_is_closed(log, axis, loop):
    assert loop_of([log], [axis]) is loop
    assert loop_of([log, log], [axis, axis]) is loop


def test_a_loop_is_closed_if_that_of_every_log_is_known():
    assert loop_of([LOG, BLIND], [Axis(controller=LAW)] * 2) is Position


@pytest.mark.parametrize(
    ("axes", "told"),
    [
        ([Axis(loop="open"), Axis(loop="closed")], r"identification\.loop: differs between axes"),
        ([Axis(seeks_lag=True)], r"effort\.lag: can be identified in a closed loop only"),
    ],
)
def test_a_loop_that_cannot_be_simulated_is_refused(axes, told):
    with pytest.raises(InputError, match=told):
        loop_of([LOG] * len(axes), axes)


def position(count=20_000, pure=None):
    """An output of a position, its pure signal a ramp over many steps of an encoder."""
    pure = np.linspace(0.0, 1.0, count) if pure is None else pure
    return Position(
        np.zeros(count), np.zeros(count), SimpleNamespace(effort=np.zeros(4 * 500), steps=4)
    ), pure


def test_an_encoder_reads_whole_steps_from_a_random_phase():
    item, pure = position()
    change = item.read(
        None,
        pure,
        np.full(pure.size, 0.3),
        disturbance_with(resolution=1e-2),
        np.random.default_rng(1),
    )
    read = (pure + change) / 1e-2
    assert read - read[0] == pytest.approx(np.round(read - read[0]), abs=1e-6)
    assert read[0] != pytest.approx(np.round(read[0]), abs=1e-3)
    assert np.max(np.abs(change - 0.3)) <= 0.5e-2 * (1.0 + 1e-9)
    assert np.std(change - 0.3) == pytest.approx(1e-2 / 12.0**0.5, rel=0.02)


def test_a_position_without_steps_has_only_jitter():
    item, pure = position()
    change = (
        item.read(None, pure, 2.0 * pure, disturbance_with(jitter=1e-3), np.random.default_rng(1))
        - 2.0 * pure
    )
    assert np.std(change) == pytest.approx(1e-3, rel=0.03)
    assert np.mean(change) == pytest.approx(0.0, abs=3e-5)


def test_a_position_has_the_period_of_its_effort():
    item, _ = position()
    assert item.period == 500
    assert item.phase[[0, 250, 500, 750]].tolist() == [0.0, 0.5, 0.0, 0.5]
    assert item.leaning(None, np.arange(3.0)).tolist() == [0.0, 1.0, 2.0]


def test_errors_of_a_fit_have_the_unit_of_its_signal_and_its_lag():
    item, _ = position(4)
    item = Position(np.array([3.0, -3.0, 1.0, -1.0]), item.position, item.loop)
    error = OutputError(None, (item,))
    object.__setattr__(error, "residual", lambda free: np.array([1.0, -1.0, 1.0, -1.0]))
    assert error.errors({}) == {
        "position_error_percent": pytest.approx(100.0 / 5.0**0.5),
        "position_rmse": 1.0,
    }
    assert error.errors({LAG: 2e-3})[LAG] == 2e-3


class Loop:
    """A loop of five samples that ends after three, and notes what it is run with."""

    count = 5

    def __init__(self):
        self.runs = []

    def moved_by(self, way):
        self.runs.append(way)
        return self

    def run(self, plant, model, sensor, *, lag, disturbance):
        self.runs.append((plant, model, sensor.values, lag, disturbance))
        return SimpleNamespace(
            command=np.array([1.0, 2.0, 3.0]), friction=np.array([4.0, 5.0, 6.0])
        )


PLANT = inertia(M=2.0)
SLIDING = friction.with_slots(friction.coulomb_viscous, [])(F_C=8.0, F_v=30.0, offset=1.5)


def test_an_effort_in_the_loop_is_simulated_with_a_perfect_encoder_and_the_lag():
    loop = Loop()
    item = Effort(np.zeros(5), np.zeros(5), loop)
    for lag in ({}, {LAG: 2e-3}):
        signal = item.simulated(Mechanism(PLANT, SLIDING, {"offset": 1.5} | lag))
        assert signal[:3].tolist() == [1.0, 2.0, 3.0]
        assert np.isnan(signal[3:]).all()  # where the loop left the finite numbers
    assert [run[2]["resolution"] for run in loop.runs] == [0.0, 0.0]
    assert [run[3:] for run in loop.runs] == [(None, None), (2e-3, None)]
    assert (loop.runs[0][0], loop.runs[0][1], item.period) == (PLANT, SLIDING, 5)
    assert item.leaning(Mechanism(PLANT, SLIDING, {"offset": 1.5}), np.zeros(5))[:3].tolist() == [
        2.5,
        3.5,
        4.5,
    ]


def test_an_effort_is_read_through_the_encoder_from_a_random_phase():
    loop = Loop()
    item = Effort(np.zeros(5), np.zeros(5), loop)
    push = np.arange(5.0)
    change = item.read(
        Mechanism(PLANT, SLIDING, {}),
        np.full(5, 0.5),
        push,
        disturbance_with(resolution=1e-3, jitter=2e-4),
        np.random.default_rng(1),
    )
    assert change[:3].tolist() == [0.5, 1.5, 2.5]
    way, (_, _, sensor, lag, disturbance) = loop.runs
    assert 0.0 < way < 1e-3
    assert (sensor["resolution"], sensor["noise"], lag) == (1e-3, 2e-4, None)
    assert disturbance.tolist() == push.tolist()


def test_a_position_is_integrated_more_finely_at_the_end():
    assert [(kind.is_refined, kind.away_evaluations) for kind in (Position, Effort)] == [
        (True, 15),
        (False, 5),
    ]


def test_a_position_is_that_of_the_plant_with_its_friction():
    asked = []
    loop = SimpleNamespace(position=lambda *given: asked.append(given) or (np.arange(4.0), None))
    assert Position(np.zeros(4), np.zeros(4), loop).simulated(
        Mechanism(PLANT, SLIDING, {})
    ).tolist() == [0.0, 1.0, 2.0, 3.0]
    assert asked == [(PLANT, SLIDING, None)]


def test_half_cycles_of_a_simulation_are_counted_through_all_segments_without_trembles():
    there = np.array([0.0, 1.0, 2.0, 1.9, 3.0, 2.0, 1.0])
    outputs = tuple(SimpleNamespace(position=part) for part in (there, there[::-1]))
    for resolution, count in ((0.4, 4), (0.01, 8)):  # a step of 0.1 back is no turn, and is two
        dataset = SimpleNamespace(resolution=resolution, noise=0.0)
        assert OutputError(SimpleNamespace(dataset=dataset), outputs).half_cycles.count == count


@dataclass(frozen=True)
class Whole:
    """An inverse problem that knows its parameters alone."""

    parameters: object


@dataclass(frozen=True)
class Parameters:
    """Names that are free, and quantities of the loop."""

    free: tuple
    loop: object = None


def told_of(*axes, fine=False):
    """The problem of logs with two segments each, whose outputs are what they are made from."""

    class Outputs:
        of = staticmethod(
            lambda log, axis, part, fine: (log.reference is not None, axis, part, fine)
        )

    parts = (slice(0, 50), slice(60, 200))
    logs = [replace(log, segments=parts) for log in (LOG, BLIND)]
    return OutputError.of(Outputs, Whole(Parameters(("F_C",))), logs, axes, fine=fine)


@pytest.mark.parametrize("fine", [False, True])
def test_each_segment_of_each_log_is_an_output_with_the_axis_of_its_log(fine):
    one, two = Axis(controller=LAW), Axis(controller=LAW, seeks_lag=True)
    outputs = told_of(one, two, fine=fine).outputs
    assert [(followed, part.start, part.stop) for followed, _, part, _ in outputs] == [
        (True, 0, 50),
        (True, 60, 200),
        (False, 0, 50),
        (False, 60, 200),
    ]
    assert [axis for _, axis, _, _ in outputs] == [one, one, two, two]
    assert {finely for *_, finely in outputs} == {fine}


def test_a_lag_requested_by_one_axis_is_free_in_all_logs():
    without, sought = Axis(controller=LAW), Axis(controller=LAW, seeks_lag=True)
    plain = told_of(without, without)
    assert (plain.parameters.free, plain.parameters.loop) == (("F_C",), None)
    parameters = told_of(without, sought).parameters
    assert parameters.free == ("F_C", LAG)
    lag = parameters.loop[LAG]
    assert (lag.quantity, lag.min, lag.excitation) == ("time", 0.0, "drive")
    assert lag.max == pytest.approx(20.0 * LOG.sample_time)
    assert 0.0 < lag.nominal <= LOG.sample_time


class Refits:
    """Searches that end where they begin, at errors that they are told; they note where they begin and for how long."""

    def __init__(self, *costs):
        self.costs, self.starts, self.problems, self.told = iter(costs), [], [], []

    def search(self, problem, unit=0.0, *, simulates=False):
        self.problems.append((problem, unit, simulates))
        return self

    def refit(self, start, rows=None, limit=None, best=None):
        self.starts.append((dict(start), limit))
        return Ended(dict(start), next(self.costs))

    def as_far_as_it_came(self, work):
        best = output_error.BestSoFar()
        work(best)
        self.best = best
        return best.result

    def percent(self, cost):
        return 12.0


@dataclass(frozen=True)
class Ended:
    """A descent that ended."""

    values: dict
    cost: float
    unfinished: bool = False
    theta: object = None

    @property
    def space(self):
        return SimpleNamespace(names=tuple(self.values))


def estimated(*costs, refined=False, unfinished=False, lag=None):
    """The searches of an estimation by simulation, and what it ends with."""
    loop = SimpleNamespace(is_refined=refined, away_evaluations=7, code="output_error_open")
    refits, problems, reports = Refits(*costs), [], []

    class Told(Simulation):
        def error(self, inverse, *, fine=False):
            problems.append(SimpleNamespace(inverse=inverse, magnitude=3.0, fine=fine))
            return problems[-1]

    if unfinished:
        work = refits.as_far_as_it_came
        refits.as_far_as_it_came = lambda part: replace(work(part), unfinished=True)
    start = Ended({"F_C": 8.0, "F_v": 30.0} | ({} if lag is None else {LAG: lag}), 9.0)
    result = Told([LOG], [Axis()], loop).estimate(
        refits, "inverse", start, lambda share, text="": reports.append(share)
    )
    return refits, result, reports


def test_a_simulation_starts_from_inverse_dynamics_and_twice_from_around_the_best():
    refits, result, reports = estimated(5.0, 4.0, 6.0)
    (first, most), (second, fewer), (third, few) = refits.starts
    assert first == {"F_C": 8.0, "F_v": 30.0, LAG: pytest.approx(0.2 * LOG.sample_time)}
    assert most > fewer == few == 7
    for away, best in ((second, first), (third, second)):
        for name, value in away.items():
            assert value != best[name]
            assert abs(np.log(value / best[name])) < 1.2
    assert result.solution.cost == 4.0
    assert reports == sorted(set(reports))
    assert 0.0 < reports[0] < 0.5 < reports[-1] < 1.0
    assert estimated(5.0, 4.0, 6.0)[0].starts == refits.starts  # the same fit twice


def test_a_known_lag_is_the_start_of_a_simulation():
    assert estimated(5.0, 5.0, 5.0, lag=3e-3)[0].starts[0][0][LAG] == 3e-3


def test_further_starts_scatter_by_a_third():
    ratios = []
    for lag in np.linspace(1e-3, 2e-3, 3):
        (first, _), *others = estimated(1.0, 2.0, 2.0, lag=float(lag))[0].starts
        ratios += [np.log(away[name] / first[name]) for away, _ in others for name in first]
    assert 0.1 < np.std(ratios) < 0.6


def test_a_refined_loop_is_integrated_more_finely_at_the_end():
    plain, estimation, _ = estimated(5.0, 4.0, 6.0)
    assert [(problem.fine, unit, simulates) for problem, unit, simulates in plain.problems] == [
        (False, 3.0, True)
    ]
    assert (estimation.problem, estimation.inverse) == (plain.problems[0][0], "inverse")
    assert estimation.problem.fine is False
    refits, estimation, _ = estimated(5.0, 4.0, 6.0, 3.5, refined=True)
    assert [(problem.fine, unit, simulates) for problem, unit, simulates in refits.problems] == [
        (False, 3.0, True),
        (True, 3.0, True),
    ]
    start, limit = refits.starts[-1]
    assert start == refits.starts[1][0]
    assert 1 < limit < refits.starts[0][1]
    assert (estimation.problem.fine, estimation.solution.cost, estimation.solution.unfinished) == (
        True,
        3.5,
        False,
    )
    assert [note.code for note in estimation.diagnostics] == ["output_error_open"]
    assert [note.severity for note in estimation.diagnostics] == ["note"]


def test_an_interrupted_search_is_evaluated_on_the_finer_loop():
    refits, estimation, _ = estimated(5.0, 4.0, 6.0, 3.5, refined=True, unfinished=True)
    assert refits.starts[-1][1] == 1
    assert estimation.solution.unfinished


@pytest.mark.parametrize("linear", [True, False])
def test_an_interrupted_start_is_returned(monkeypatch, linear):
    start, problem = (
        Ended({"F_C": 8.0}, 1.0, unfinished=True),
        SimpleNamespace(parameters=SimpleNamespace(is_linear=linear)),
    )
    problem.residual = lambda values: [values["F_C"]]
    asked, reports = [], []
    monkeypatch.setattr(output_error, "linear", lambda given: asked.append("linear") or start)

    def solve(report):
        asked.append("search")
        report(1.0)
        return start

    context = SimpleNamespace(
        problem=lambda component: problem,
        search=lambda given, simulates: SimpleNamespace(solve=solve),
    )
    estimation = Simulation([LOG], [Axis()], Position)(
        context, friction.coulomb, lambda share, text="": reports.append(share)
    )
    assert (estimation.problem, estimation.inverse, estimation.solution) == (
        problem,
        problem,
        start,
    )
    assert estimation.residual_without(None) == [8.0]
    assert asked == ["linear" if linear else "search"]
    assert all(0.0 < share < 0.5 for share in reports)


def test_an_error_simulates_each_segment_once_and_measures_them_all():
    outputs = tuple(
        SimpleNamespace(
            measured=np.array(part),
            simulated=lambda mechanism, part=part: mechanism.values["a"] * np.array(part),
        )
        for part in ([1.0, 2.0], [6.0])
    )
    inverse = SimpleNamespace(
        parameters=SimpleNamespace(complete=dict),
        plant=lambda values: PLANT,
        model=lambda values: SLIDING,
        dataset=SimpleNamespace(sample_time=0.02),
    )
    error = OutputError(inverse, outputs)
    assert error.measured.tolist() == [1.0, 2.0, 6.0]
    assert error.residual({"a": 0.5}).tolist() == [0.5, 1.0, 3.0]
    assert error.magnitude == pytest.approx(14.0**0.5 / 3.0**0.5)
    assert error.row_time == 0.02
    assert error.mechanism({"a": 1.0})[:2] == (PLANT, SLIDING)
    assert not error.away.rows.any()
    assert error.away.position.tolist() == [0.0] * 3

"""Prediction errors: the contact identified by an observer, on logs of an axis simulated here in plain Python."""

import math
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace
from types import SimpleNamespace as Some

import numpy as np
import pytest

import bristle as br
from bristle.core import Axis, InputError
from bristle.core.diagnostic import Diagnostic
from bristle.identification import observed_fit, observer
from bristle.identification.dataset import Dataset
from bristle.identification.ladder import Ladder
from bristle.identification.observed_fit import foreseen
from bristle.identification.observer import BEND, DELAY, Expected, Recorded
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import ParameterSet, Scales
from bristle.plants import inertia
from bristle.plants.terms import with_terms
from bristle.report.messages import message

TRUTH = {"M": 3.0, "F_C": 12.0, "F_S": 16.0, "v_S": 4e-3, "sigma_0": 2.5e6, "sigma_1": 1200.0, "sigma_2": 25.0}
DT, FINER, STEP = 1e-3, 20, 2e-7
LATE = 2  # samples, by which the effort is recorded late


@pytest.fixture(scope="module")
def columns():
    """A loop of position and velocity that follows strokes at several speeds; the encoder rounds, the record is late."""
    count, h, p = 5000, DT / FINER, TRUTH
    time = DT * np.arange(count)
    speed = np.repeat([0.004, 0.02, 0.06, 0.01, 0.03], count // 5)
    reference = np.cumsum(speed * np.sin(2.0 * np.pi * 2.2 * time)) * DT
    x, v, z, u, before = 0.0, 0.0, 0.0, 0.0, 0.0
    position, effort = np.empty(count), np.empty(count)
    for k in range(count):
        position[k] = STEP * math.floor(x / STEP + 0.5)
        u = 3e4 * (reference[k] - position[k]) - 500.0 * (position[k] - before) / DT
        before, effort[k] = position[k], u
        for _ in range(FINER):
            g = (p["F_C"] + (p["F_S"] - p["F_C"]) * math.exp(-((v / p["v_S"]) ** 2))) / p["sigma_0"]
            # The bristle by its exact solution for a velocity that is constant over the step.
            end = math.copysign(g, v) if v else z
            z_next = end + (z - end) * math.exp(-abs(v) * h / g)
            force = p["sigma_0"] * 0.5 * (z + z_next) + p["sigma_1"] * (z_next - z) / h + p["sigma_2"] * v
            v += h / p["M"] * (u - force)
            x, z = x + h * v, z_next
    return {"time": time, "position": position, "effort": np.concatenate([np.full(LATE, effort[0]), effort[:-LATE]])}


@pytest.fixture(scope="module")
def identified(columns):
    return br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)


@pytest.fixture(scope="module")
def plain(columns):
    return br.identify(columns, "lugre", axis=Axis(resolution=STEP), method="inverse_dynamics", blocks=0, draws=20)


def test_an_observer_finds_the_contact_despite_a_coarse_encoder(identified):
    errors = {name: identified.parameters[name].value / value - 1.0 for name, value in TRUTH.items()}
    assert abs(errors["M"]) < 2e-3
    assert abs(errors["F_C"]) < 5e-3
    assert abs(errors["F_S"]) < 0.01
    assert abs(errors["sigma_0"]) < 0.02
    assert abs(errors["v_S"]) < 0.03


def test_intervals_of_an_observer_are_narrow_and_contain_the_truth(identified):
    for name in ("M", "F_C", "F_S", "v_S", "sigma_0"):
        low, high = identified.parameters[name].interval
        assert low < TRUTH[name] < high, name
        assert high - low < 0.3 * TRUTH[name], name


def test_the_report_states_the_observer_of_the_position(identified):
    (told,) = [one for one in identified.best.diagnostics if one.code == "prediction_error"]
    assert told.severity == "note"
    assert 0.25 * STEP < told.numbers["error"] < STEP
    assert 0.5 < told.numbers["times"] < 1.5


def test_the_delay_is_that_of_the_observer(identified, plain):
    (late,), (first,) = (
        [one for one in result.best.diagnostics if one.code in ("delay_found", "delay_rough")] for result in (identified, plain)
    )
    # The effort is recorded late, and each value acts until the next.
    assert late.numbers["samples"] == pytest.approx(LATE - 0.5, abs=0.05)
    assert late.numbers["delay"] == pytest.approx(DT * late.numbers["samples"])
    assert 0.0 < late.numbers["half_width"] < DT
    assert late.numbers["samples"] != first.numbers["samples"]


def test_a_level_has_a_prior_from_inverse_dynamics_and_scatters_by_half_cycles(columns, plain, monkeypatch):
    calls, scattering = [], observer.PredictionErrors.scattering

    def recorded(problem, values, scatter):
        calls.append((problem, values, scatter, scattering(problem, values, scatter)))
        return calls[-1][-1]

    monkeypatch.setattr(observer.PredictionErrors, "scattering", recorded)
    br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    problem, values, scatter, scattered = calls[0]
    assert scatter == plain.best.resampling.scatter.value
    level = plain.parameters["F_C"]
    (expected,) = [one for one in problem.expected if one.powers == {"F_C": 1.0}]
    assert not expected.logarithmic
    assert expected.mean == level.value
    assert expected.std == pytest.approx(0.5 * (level.interval[1] - level.interval[0]) / 1.96, rel=1e-3)
    # The column is the change of the prediction where all levels rise together.
    free = {name: values[name] for name in problem.parameters.free}
    raised = {name: value * (1.0 + 1e-5 * (name in ("F_C", "F_S"))) for name, value in free.items()}
    whole = replace(problem, scatter=None)
    change = (whole.residual(free) - whole.residual(raised))[: problem.settled_rows] / 1e-5
    assert scattered.scatter.column == pytest.approx(change, rel=1e-2, abs=1e-3 * np.max(np.abs(change)))
    assert problem.scattering(values, 0.0) is problem
    mean_of_two = 0.5 * math.hypot(scatter, scatter)
    starts, column = scattered.scatter.starts, scattered.scatter.column
    assert scattered.scatter.share == pytest.approx(observer.LevelScatter.of(starts, column, mean_of_two, problem.unit).share)


def ladder_of(thetas, variances):
    """Return a ladder whose rungs end at these coordinates, the last of which is a delay."""
    space = SimpleNamespace(names=("a", "b", DELAY))
    rungs = tuple(SimpleNamespace(solution=Solution(space, np.array(theta), np.eye(3)), problem=None) for theta in thetas)
    return Ladder(rungs, tuple(map(np.diag, variances)))


def test_rungs_are_weighted_by_their_precision_except_in_the_channel():
    ladder = ladder_of([(0.0, 0.0, 0.0), (1.0, 2.0, 5.0)], [(1.0, 4.0, 9.0), (4.0, 16.0, 1e-9)])
    assert ladder.weights == pytest.approx([16.0 / 17.0, 1.0 / 17.0])
    assert ladder.best is ladder.rungs[0]
    assert ladder.solution.theta == pytest.approx(np.array([1.0, 2.0, 5.0]) / 17.0)


def test_the_spread_of_the_rungs_is_in_the_covariance():
    ladder = ladder_of([(0.0, 0.0, 0.0), (0.0, 6.0, 0.0), (0.0, 0.0, 3.0)], [(1.0, 4.0, 9.0)] * 3)
    spread = np.cov(np.array([(0.0, 0.0, 0.0), (0.0, 6.0, 0.0), (0.0, 0.0, 3.0)]), rowvar=False)
    assert ladder.covariance == pytest.approx(np.diag([1.0, 4.0, 9.0]) + spread)


def test_a_rung_without_information_on_a_coordinate_is_weighted_by_the_others():
    ladder = ladder_of([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)], [(1.0, 0.0, 1.0), (1.0, 1.0, 1.0)])
    assert ladder.weights == pytest.approx([0.5, 0.5])
    assert ladder_of([(2.0, 3.0, 4.0)], [(0.0, 0.0, 0.0)]).solution.theta == pytest.approx([2.0, 3.0, 4.0])


def test_intervals_include_the_ladder_and_inverse_dynamics(monkeypatch):
    monkeypatch.setattr(observed_fit, "_apart", lambda *_: np.array([0.0, 2.0, 0.0]))
    ladder = ladder_of([(0.0, 0.0, 0.0)], [(1.0, 4.0, 9.0)])
    matrix = observed_fit.variance_of(ladder, {}, 2.0) / observed_fit.STUDENT**2
    assert np.diag(matrix) == pytest.approx([4.0, 32.0, 36.0])


def test_missed_percent_contains_scatter_and_unexplained_force_without_noise(identified):
    fit = identified.best
    size, percent = float(np.sqrt(np.mean(fit.traces.residual**2))), fit.friction_alone_error_percent

    def missed(unexplained, scatter):
        bands = replace(fit.resampling.bands, unexplained=unexplained, scatter=scatter)
        return replace(fit, resampling=replace(fit.resampling, bands=bands)).missed_percent

    assert missed(0.0, 0.0) == 0.0
    assert missed(0.5 * size, 0.0) == pytest.approx(0.5 * percent)
    assert missed(0.3 * size, 0.004 * percent) == pytest.approx(0.5 * percent)
    assert missed(2.0 * size, 0.0) == percent
    assert replace(fit, resampling=None).missed_percent == percent


def test_an_observer_finds_the_contact_despite_a_filtered_position(columns):
    kept, shown = math.exp(-DT / 3e-3), np.empty(columns["position"].size)
    last = columns["position"][0]
    for k, position in enumerate(columns["position"]):
        last = shown[k] = kept * last + (1.0 - kept) * position
    result = br.identify({**columns, "position": shown}, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    assert result.treatment["position_smoothing"] == pytest.approx(3e-3, rel=0.1)
    assert result.parameters["sigma_0"].value == pytest.approx(TRUTH["sigma_0"], rel=0.05)
    assert result.parameters["F_S"].value == pytest.approx(TRUTH["F_S"], rel=0.02)


def test_a_position_of_whole_steps_is_unfiltered_and_of_partial_steps_filtered():
    segments = [SimpleNamespace(recorded=STEP * np.array([0.0, 3.0, 3.0, 4.0, 9.0]))]
    off_grid = Dataset.off_grid.fget
    assert not off_grid(SimpleNamespace(segments=segments, resolution=STEP))
    assert off_grid(SimpleNamespace(segments=segments, resolution=1.6 * STEP))
    assert not off_grid(SimpleNamespace(segments=segments, resolution=0.0))
    segments = [SimpleNamespace(recorded=STEP * np.array([0.0, 1.0, 2.4, 5.1, 9.0]))]  # of no grid: the smallest step is no encoder's
    assert not off_grid(SimpleNamespace(segments=segments, resolution=STEP))


def test_an_unknown_filter_widens_the_intervals_of_an_observer(columns, monkeypatch):
    widths, seen = [], SimpleNamespace(of_position=True)
    assert observed_fit._filtered_unseen(SimpleNamespace(off_grid=True, alignment=None))
    assert not observed_fit._filtered_unseen(SimpleNamespace(off_grid=True, alignment=seen))
    for unseen in (False, True):
        monkeypatch.setattr(observed_fit, "_filtered_unseen", lambda _, unseen=unseen: unseen)
        low, high = of_observer(columns, monkeypatch).parameters["sigma_1"].interval
        widths.append(high - low)
    assert widths[1] == pytest.approx(2.5 * widths[0], rel=0.05)


def test_an_uncertain_inertia_widens_dependent_intervals(columns, monkeypatch):
    widths, held_in = [], observed_fit.held_in
    for times in (1.0, 100.0):

        def unsure(*arguments, times=times):
            held = held_in(*arguments)
            return {**held, "M": held["M"]._replace(half_width=times * held["M"].half_width)}

        monkeypatch.setattr(observed_fit, "held_in", unsure)
        low, high = of_observer(columns, monkeypatch).parameters["F_C"].interval
        widths.append(high - low)
    assert widths[1] > 1.3 * widths[0]


def test_an_effort_of_a_sensor_next_to_the_contact_moves_no_mass(columns):
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP, keeps_rests=True), blocks=0, draws=20)
    assert "prediction_error" not in {one.code for one in result.best.diagnostics}


def test_directional_forces_are_those_of_inverse_dynamics():
    component = br.friction.find("lugre+asymmetry")
    names = ("M", *component.variables)
    parameters = ParameterSet(component, names, {})
    estimation = SimpleNamespace(inverse=SimpleNamespace(parameters=parameters), solution=SimpleNamespace(values=dict.fromkeys(names, 2.0)))
    fit = SimpleNamespace(parameters={name: SimpleNamespace(interval=(1.0, 4.0)) for name in names})
    held = observed_fit.held_in(fit, estimation)
    assert set(held) == {"M", "F_C_pos", "F_C_neg", "sigma_2_pos", "sigma_2_neg", "offset"}
    assert {(entry.value, entry.half_width) for entry in held.values()} == {(2.0, 1.5)}


def test_a_model_without_a_contact_keeps_the_parameters_of_inverse_dynamics(columns):
    plain, asked = (
        br.identify(columns, "coulomb_viscous", axis=Axis(resolution=STEP), method=method, blocks=0, draws=20)
        for method in ("inverse_dynamics", "prediction_error")
    )
    assert {name: one.value for name, one in plain.parameters.items()} == {name: one.value for name, one in asked.parameters.items()}
    assert plain.best.diagnostics == asked.best.diagnostics


def test_a_diagnostic_of_inverse_dynamics_is_removed_with_its_value(columns, monkeypatch):
    def doubted(fit, *arguments):
        doubts = (
            Diagnostic("small_effect", "sigma_0"),
            Diagnostic("widened", numbers={"names": ("sigma_0",), "times": 2.5}),
            Diagnostic("delay_or_filter", severity="warning"),
            Diagnostic("filter_suspect", severity="warning"),
        )
        return foreseen(replace(fit, diagnostics=(*fit.diagnostics, *doubts)), *arguments)

    monkeypatch.setattr(import_module("bristle.identification.intervals"), "foreseen", doubted)
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    assert result.parameters["sigma_0"].status == "identified"
    codes = {one.code: one.severity for one in result.best.diagnostics}
    assert not {"small_effect", "widened", "delay_or_filter"}.intersection(codes)
    assert codes["filter_suspect"] == "note"


def test_values_that_a_model_does_not_allow_are_reported_and_rejected(columns, plain, monkeypatch):
    def refused(*_):
        raise InputError("the best fit of lugre has values that the model does not allow", path="model")

    monkeypatch.setattr("bristle.identification.observed_fit.fit_of", refused)
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    (told,) = [one for one in result.best.diagnostics if one.code == "prediction_error"]
    assert "has values that the model does not allow" in message(told)
    assert result.parameters["sigma_0"].value == plain.parameters["sigma_0"].value


def test_pieces_of_a_long_log_give_the_same_contact(columns, identified, monkeypatch):
    monkeypatch.setattr("bristle.identification.observer.MOST", 4000)
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    assert result.parameters["sigma_0"].value != identified.parameters["sigma_0"].value
    assert result.parameters["sigma_0"].value == pytest.approx(TRUTH["sigma_0"], rel=0.06)


def test_progress_never_decreases_with_an_observer(columns):
    shares = []
    br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20, progress=lambda share, _: shares.append(share))
    assert shares == sorted(shares)
    assert shares[-1] <= 1.0


def test_a_diverging_replicate_is_dropped(monkeypatch):
    axis = SimpleNamespace(replicate=lambda *_: None)
    monkeypatch.setattr(observed_fit, "IdentifiedAxis", lambda *_: axis)
    inverse = SimpleNamespace(parameters=SimpleNamespace(complete=lambda _: {DELAY: 0.0, BEND: 0.0}), plant=str, model=str, dataset=None)
    rung = SimpleNamespace(
        problem=SimpleNamespace(inverse=inverse, parts=(None,), lag=0.0, dt=DT, steps=2), solution=SimpleNamespace(values={})
    )
    assert observed_fit.replicate(rung, observed_fit.Unseen(0.0, 0.0, 0.0), None) is None


def test_a_delay_has_a_prior_from_the_first_stage_and_errors_are_positions(columns, monkeypatch):
    rungs = []

    def noted(rung, *_):
        rungs.append(rung)
        raise KeyboardInterrupt

    monkeypatch.setattr(observed_fit, "errors_of_replicates", noted)
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    (rung,) = rungs
    (delay,) = [expected for expected in rung.problem.expected if DELAY in expected.powers]
    assert delay.mean == pytest.approx(result.treatment["delay"])
    assert delay.std == pytest.approx(result.treatment["delay_half_width"] / 1.96, rel=1e-3)
    residual = rung.problem.residual(rung.solution.values)
    errors, beforehand = residual[: -len(rung.problem.expected)], residual[-len(rung.problem.expected) :]
    assert np.sum(beforehand**2) > 1e-5 * np.sum(errors**2)
    assert rung.error == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-6)


def test_a_replicate_has_the_known_forces_of_its_log(columns):
    friction = br.friction.lugre(**{name: value for name, value in TRUTH.items() if name != "M"})
    plain, pulled = inertia(M=3.0), with_terms(inertia, columns=("weight",))(M=3.0, known_weight=0.5)
    dataset, channel = SimpleNamespace(resolution=STEP), observed_fit.Channel(0.0, 0.0, 0.0)
    weight = np.linspace(20.0, 60.0, 5000)
    logs = []
    for plant, effort, known in ((plain, columns["effort"], ()), (pulled, columns["effort"] + 0.5 * weight, (weight,))):
        axis = observed_fit.IdentifiedAxis(plant, friction, dataset, DT, 4, channel)
        part = Recorded(columns["position"], effort, known)
        logs.append(axis.replicate(part, observed_fit.Unseen(0.0, 0.0, 0.0), np.random.default_rng(1)))
    assert logs[1].position == pytest.approx(logs[0].position, abs=0.2 * STEP)
    assert (logs[1].effort - logs[0].effort)[100:-100] == pytest.approx(0.5 * weight[100:-100], abs=0.05)
    assert logs[1].columns == (weight,)


def test_the_constant_force_is_that_of_inverse_dynamics(plain, identified):
    assert plain.parameters["sigma_0"].value != identified.parameters["sigma_0"].value
    assert plain.parameters["offset"].value == identified.parameters["offset"].value


def test_intervals_of_sliding_reach_to_inverse_dynamics(identified, columns, monkeypatch):
    def width(result):
        low, high = result.parameters["F_C"].interval
        return high - low

    monkeypatch.setattr("bristle.identification.observed_fit.SHOWN_BY_SLIDING", ())
    narrow = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)
    assert narrow.parameters["F_C"].value == identified.parameters["F_C"].value
    assert width(narrow) < width(identified)


def test_a_log_of_segments_below_a_second_keeps_the_parameters_of_inverse_dynamics(columns, monkeypatch):
    monkeypatch.setattr("bristle.identification.observer.SHORTEST", 10.0)
    plain, asked = (
        br.identify(columns, "lugre", axis=Axis(resolution=STEP), method=method, blocks=0, draws=20)
        for method in ("inverse_dynamics", "prediction_error")
    )
    assert plain.parameters["sigma_0"].value == asked.parameters["sigma_0"].value
    (told,) = [one for one in asked.best.diagnostics if one.code == "prediction_error"]
    assert "no observer was usable: no segment of the log lasts a second" in message(told)


def test_an_effort_is_shifted_by_its_delay_and_sharpened_by_its_bend():
    omega, dt = 2.0 * np.pi * 5.0, 1e-3
    time = dt * np.arange(1001)
    recorded = Recorded(np.zeros(1001), np.sin(omega * time), ())
    moved, by_delay, by_bend = recorded.efforts(3e-3, 2e-5, dt)
    inner = slice(300, 700)
    sharper = math.exp(2e-5 * omega**2)
    assert moved[:-1][inner] == pytest.approx(sharper * np.sin(omega * (time + 3e-3))[inner], abs=2e-3)
    assert by_delay[:-1][inner] == pytest.approx(sharper * omega * np.cos(omega * (time + 3e-3))[inner], abs=0.1)
    assert by_bend[:-1][inner] == pytest.approx(sharper * omega**2 * np.sin(omega * (time + 3e-3))[inner], abs=2.0)


def test_a_prior_of_a_ratio_is_a_row_with_its_derivatives():
    expected = Expected({"F_S": 1.0, "F_C": -1.0}, logarithmic=True, mean=0.3, std=0.5, weight=4.0)
    names = ("F_C", "F_S", DELAY, BEND)
    values = {"F_C": 10.0, "F_S": 15.0, DELAY: 0.0, BEND: 0.0}
    row = expected.row(values, names, 0.1)
    assert row[0] == pytest.approx(0.1 * 2.0 / 0.5 * (math.log(1.5) - 0.3))
    near = expected.row({**values, "F_S": 15.0 + 1e-6}, names, 0.1)
    assert row[1:] == pytest.approx([-0.4 / 10.0, (near[0] - row[0]) / 1e-6, 0.0, 0.0], rel=1e-6, abs=1e-12)


def test_the_search_starts_half_a_sample_later_for_a_zero_order_hold(columns, monkeypatch):
    starts = []

    def first(errors, start, *_):
        starts.append(start[DELAY])
        raise KeyboardInterrupt

    monkeypatch.setattr("bristle.identification.observer.climbed", first)
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP, held=True), blocks=0, draws=20)
    assert starts == [pytest.approx(result.treatment["delay"] - 0.5 * DT)]
    assert result.unfinished == "interrupted: the parameters are those of inverse dynamics"


def of_observer(columns, monkeypatch, times=1.0, **changes):
    """Identify where the log is predicted so many times as badly as its replicates, and its estimation is changed."""

    def asked(fit, estimation, *arguments):
        return foreseen(fit, replace(estimation, **changes), *arguments)

    def few(rung, *_):
        return np.full(2, rung.error / times)

    monkeypatch.setattr(import_module("bristle.identification.intervals"), "foreseen", asked)
    monkeypatch.setattr(observed_fit, "errors_of_replicates", few)
    return br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=20)


def test_a_log_predicted_worse_than_its_replicates_keeps_inverse_dynamics(columns, plain, monkeypatch):
    result = of_observer(columns, monkeypatch, times=1.4)
    (told,) = [one for one in result.best.diagnostics if one.code == "prediction_error"]
    assert "predicts the next position 1.4 times worse" in message(told)
    assert result.parameters["sigma_0"].value == plain.parameters["sigma_0"].value


def test_intervals_widen_as_the_log_is_predicted_worse(columns, monkeypatch):
    widths = []
    for times in (0.5, 1.0, 1.3):
        low, high = of_observer(columns, monkeypatch, times=times).parameters["sigma_1"].interval
        widths.append(high - low)
    assert widths[0] == widths[1]
    assert widths[2] == pytest.approx(1.3 * widths[1], rel=0.05)


def test_without_draws_the_parameters_are_those_of_inverse_dynamics(columns, plain):
    result = br.identify(columns, "lugre", axis=Axis(resolution=STEP), blocks=0, draws=0)
    assert result.parameters["sigma_0"].value == plain.parameters["sigma_0"].value


def test_an_observer_without_draws_is_rejected(columns):
    with pytest.raises(InputError, match="draws") as refused:
        br.identify(columns, "lugre", axis=Axis(resolution=STEP), method="prediction_error", blocks=0, draws=0)
    assert "--method inverse_dynamics" in refused.value.mend


def test_the_inertia_is_that_of_the_first_stage_and_widens_dependent_intervals(identified, plain):
    assert identified.parameters["M"].value == plain.parameters["M"].value
    assert identified.parameters["M"].interval == plain.parameters["M"].interval


def test_a_fall_that_filtered_rows_hide_is_sought_again(columns):
    blurred = br.identify(columns, "lugre", axis=Axis(resolution=STEP, cutoff=8.0), blocks=0, draws=20)
    assert blurred.parameters["v_S"].value == pytest.approx(TRUTH["v_S"], rel=0.1)


def test_bands_contain_the_parameters_of_the_model(columns, monkeypatch):
    result = of_observer(columns, monkeypatch, finished=lambda values: {"F_C": 2.0 * values["F_C"]})
    draws = result.best.resampling.bands.draws
    assert np.mean(draws["F_C"]) == pytest.approx(2.0 * result.parameters["F_C"].value, rel=0.01)


def test_an_observer_seeks_a_contact_between_the_samples():
    scales = Scales(1.0, 2.0, 0.5, 0.01, 1.0, 0.1, 1e-5, 10.0, 1e-3)
    finer = observer._finer(scales, 1e-7)
    assert (finer.shortest, finer.slowest) == (1e-7, observer.SLOWEST * 0.5)
    assert observer._finer(scales, 0.0).shortest == scales.shortest
    assert observer._finer(scales._replace(slowest=1e-6), 1e-3)[:] == scales._replace(slowest=1e-6)[:]


@pytest.mark.parametrize(("cost", "priors", "error"), [(8.0, 0.0, 2e-6), (10.0, 2e-6, 2e-6), (1.0, 3e-6, np.inf), (np.nan, 0.0, np.inf)])
def test_an_observer_that_lost_the_motion_has_no_error(monkeypatch, cost, priors, error):
    monkeypatch.setattr(observer, "replace", lambda context, **_: context)
    monkeypatch.setattr(observer, "_finer", lambda scales, resolution: scales)
    solution = Some(cost=cost, values={"F_C": 1.0})
    search = Some(descend=lambda theta, **_: solution, space=Some(theta=lambda values: values))
    errors = Some(
        inverse=Some(dataset=Some(resolution=1e-7)),
        unit=1e-6,
        parameters=Some(free=("F_C",), complete=dict),
        beforehand=lambda values: np.array([[priors]]),
        settled_rows=4,
    )
    rung = observer.climbed(errors, {"F_C": 1.0}, Some(scales=1, search=lambda *_: search))
    assert rung.error == pytest.approx(error)

"""Prediction errors: the contact identified by an observer, on logs of an axis simulated here in plain Python."""

import math
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.rigid import IDENTIFYING, identify
from tests.identification.watched import watched

import bristle as br
from bristle.core import Axis, InputError
from bristle.core.diagnostic import Diagnostic
from bristle.identification import intervals, observed_fit, observer
from bristle.identification.dataset import Alignment, Dataset
from bristle.identification.half_cycles import Disturbance
from bristle.identification.ladder import Ladder
from bristle.identification.observed_fit import foreseen
from bristle.identification.observer import BEND, DELAY, Expected, Recorded, observable
from bristle.identification.parameter_space import Solution
from bristle.identification.parameters import Fixed, ParameterSet, Scales
from bristle.logs.filters import through_filter
from bristle.logs.log import Log
from bristle.models.plants import inertia, with_terms
from bristle.report.messages import message

TRUTH = {
    "M": 3.0,
    "F_C": 12.0,
    "F_S": 16.0,
    "v_S": 4e-3,
    "sigma_0": 2.5e6,
    "sigma_1": 1200.0,
    "sigma_2": 25.0,
}
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
            force = (
                p["sigma_0"] * 0.5 * (z + z_next)
                + p["sigma_1"] * (z_next - z) / h
                + p["sigma_2"] * v
            )
            v += h / p["M"] * (u - force)
            x, z = x + h * v, z_next
    return {
        "time": time,
        "position": position,
        "effort": np.concatenate([np.full(LATE, effort[0]), effort[:-LATE]]),
    }


def identified_from(columns, **axis):
    return identify(columns, "lugre", axis=Axis(resolution=STEP, **axis), blocks=0, draws=20)


@pytest.fixture(scope="module")
def observed(columns):
    """The one identification of these tests: its result, the fit of inverse dynamics before it, and the ladder of observers."""
    places = (
        (intervals, "foreseen"),
        (observed_fit, "climb"),
        (observed_fit, "errors_of_replicates"),
    )
    shares = []
    with watched((IDENTIFYING, "with_intervals"), *places) as calls:
        axis = Axis(resolution=STEP)
        result = identify(
            columns,
            "lugre",
            axis=axis,
            blocks=0,
            draws=20,
            progress=lambda share, _: shares.append(share),
        )
    foreseeing, climbing = calls["foreseen"][0], calls["climb"][0]
    plain, estimation, context, logs, _ = foreseeing.given
    return Some(
        result=result,
        shares=shares,
        plain=plain,
        estimation=estimation,
        context=context,
        logs=logs,
        climbing=climbing,
        ladder=Ladder.of(climbing.returned),
        errors=calls["errors_of_replicates"][0].returned,
        bounding=calls["with_intervals"][0].given,
    )


@pytest.fixture
def again(observed, monkeypatch):
    """Return the fit of the observers from the same ladder, with so many times the error of replicates, and changes of the estimation."""
    monkeypatch.setattr(observed_fit, "climb", lambda *_: observed.climbing.returned)
    monkeypatch.setattr(observed_fit, "Ladder", Some(of=lambda _: observed.ladder))

    def fit(times=None, plain=observed.plain, **changes):
        errors = np.full(2, observed.ladder.best.error / times) if times else observed.errors
        monkeypatch.setattr(observed_fit, "errors_of_replicates", lambda *_: errors)
        return foreseen(
            plain, replace(observed.estimation, **changes), observed.context, observed.logs
        )

    return fit


def width(fit, name):
    low, high = fit.parameters[name].interval
    return high - low


def told_in(fit):
    (told,) = [one for one in fit.diagnostics if one.code == "prediction_error"]
    return told


@pytest.mark.parametrize(
    ("name", "error"), [("M", 2e-3), ("F_C", 5e-3), ("F_S", 0.01), ("sigma_0", 0.02), ("v_S", 0.03)]
)
def test_an_observer_finds_the_contact_despite_a_coarse_encoder_with_narrow_intervals(
    observed, name, error
):
    estimate = observed.result.best.parameters[name]
    assert estimate.value == pytest.approx(TRUTH[name], rel=error)
    low, high = estimate.interval
    assert low < TRUTH[name] < high
    assert high - low < 0.3 * TRUTH[name]


def test_the_report_states_the_observer_of_the_position(observed):
    told = told_in(observed.result.best)
    assert told.severity == "note"
    assert 0.25 * STEP < told.numbers["error"] < STEP
    assert 0.5 < told.numbers["times"] < 1.5


def test_the_delay_is_that_of_the_observer(observed):
    (late,), (first,) = (
        [one for one in fit.diagnostics if one.code in ("delay_found", "delay_rough")]
        for fit in (observed.result.best, observed.plain)
    )
    # The effort is recorded late, and each value acts until the next.
    assert late.numbers["samples"] == pytest.approx(LATE - 0.5, abs=0.05)
    assert late.numbers["delay"] == pytest.approx(DT * late.numbers["samples"])
    assert 0.0 < late.numbers["half_width"] < DT
    assert late.numbers["samples"] != first.numbers["samples"]


@pytest.mark.parametrize(("held", "samples"), [(None, 2.0), (True, 2.5)])
def test_the_delay_of_a_held_effort_is_half_a_sample_longer(observed, held, samples):
    dataset = replace(observed.context.dataset, held=held)
    told = observed_fit._about_delay(
        dataset, DT * np.linspace(1.9, 2.1, 101), observed.context.settings
    )
    assert told.numbers["samples"] == pytest.approx(samples)
    assert told.numbers["half_width"] == pytest.approx(0.095 * DT)


def test_progress_is_told_until_the_end_of_the_observers(observed):
    assert (observed.shares[0], observed.shares[-1]) == (0.0, 1.0)


def test_plant_and_constant_force_are_those_of_inverse_dynamics(observed):
    plain, result = observed.plain.parameters, observed.result.best.parameters
    assert plain["sigma_0"].value != result["sigma_0"].value
    assert plain["offset"].value == result["offset"].value
    assert (plain["M"].value, plain["M"].interval) == (result["M"].value, result["M"].interval)


def test_a_level_has_a_prior_from_inverse_dynamics_and_scatters_by_half_cycles(observed):
    rung, scatter = observed.climbing.returned[0], observed.climbing.given[6]
    problem, values = rung.problem, rung.solution.values
    assert scatter == observed.plain.resampling.scatter.value
    level = observed.plain.parameters["F_C"]
    (expected,) = [one for one in problem.expected if one.powers == {"F_C": 1.0}]
    assert not expected.logarithmic
    assert expected.mean == level.value
    assert expected.std == pytest.approx(
        0.5 * (level.interval[1] - level.interval[0]) / 1.96, rel=1e-3
    )
    assert problem.scatter is not None
    # The column is the change of the prediction where all levels rise together.
    whole = replace(problem, scatter=None)
    scattered = whole.scattering(values, scatter)
    raised = {
        name: value * (1.0 + 1e-5 * (name in ("F_C", "F_S"))) for name, value in values.items()
    }
    change = (whole.residual(values) - whole.residual(raised))[: problem.settled_rows] / 1e-5
    assert scattered.scatter.column == pytest.approx(
        change, rel=1e-2, abs=1e-3 * np.max(np.abs(change))
    )
    assert whole.scattering(values, 0.0) is whole
    mean_of_two = 0.5 * math.hypot(scatter, scatter)
    starts, column = scattered.scatter.starts, scattered.scatter.column
    assert scattered.scatter.share == pytest.approx(
        observer.LevelScatter.of(starts, column, mean_of_two, problem.unit).share
    )


def test_a_delay_has_a_prior_from_the_first_stage_and_errors_are_positions(observed):
    rung, treatment = observed.ladder.best, observed.result.treatment
    (delay,) = [expected for expected in rung.problem.expected if DELAY in expected.powers]
    assert delay.mean == pytest.approx(treatment["delay"])
    assert delay.std == pytest.approx(treatment["delay_half_width"] / 1.96, rel=1e-3)
    residual = rung.problem.residual(rung.solution.values)
    errors, beforehand = (
        residual[: -len(rung.problem.expected)],
        residual[-len(rung.problem.expected) :],
    )
    assert np.sum(beforehand**2) > 1e-5 * np.sum(errors**2)
    assert rung.error == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-6)


def ladder_of(thetas, variances):
    """Return a ladder whose rungs end at these coordinates, the last of which is a delay."""
    space = Some(names=("a", "b", DELAY))
    rungs = tuple(
        Some(solution=Solution(space, np.array(theta), np.eye(3)), problem=None) for theta in thetas
    )
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
    assert ladder_of([(2.0, 3.0, 4.0)], [(0.0, 0.0, 0.0)]).solution.theta == pytest.approx(
        [2.0, 3.0, 4.0]
    )


def test_intervals_include_the_ladder_and_inverse_dynamics(monkeypatch):
    monkeypatch.setattr(observed_fit, "_apart", lambda *_: np.array([0.0, 2.0, 0.0]))
    ladder = ladder_of([(0.0, 0.0, 0.0)], [(1.0, 4.0, 9.0)])
    matrix = observed_fit.variance_of(ladder, {}, 2.0) / observed_fit.STUDENT**2
    assert np.diag(matrix) == pytest.approx([4.0, 32.0, 36.0])


def test_missed_percent_contains_scatter_and_unexplained_force_without_noise(observed):
    fit = observed.result.best
    size, percent = (
        float(np.sqrt(np.mean(fit.traces.residual**2))),
        fit.friction_alone_error_percent,
    )

    def missed(unexplained, scatter):
        bands = replace(fit.resampling.bands, unexplained=unexplained, scatter=scatter)
        return replace(fit, resampling=replace(fit.resampling, bands=bands)).missed_percent

    assert missed(0.0, 0.0) == 0.0
    assert missed(0.5 * size, 0.0) == pytest.approx(0.5 * percent)
    assert missed(0.3 * size, 0.004 * percent) == pytest.approx(0.5 * percent)
    assert missed(2.0 * size, 0.0) == percent
    assert replace(fit, resampling=None).missed_percent == percent


def test_an_uncertain_inertia_widens_dependent_intervals(observed):
    rung = observed.ladder.best
    parameters = rung.problem.parameters
    widths = []
    for times in (1.0, 100.0):
        mass = parameters.fixed["M"]
        unsure = {**parameters.fixed, "M": mass._replace(half_width=times * mass.half_width)}
        inverse = replace(rung.problem.inverse, parameters=replace(parameters, fixed=unsure))
        ladder = Ladder.of([rung._replace(problem=replace(rung.problem, inverse=inverse))])
        widths.append(ladder.covariance[rung.solution.space.names.index("F_C")].max() ** 0.5)
    assert widths[1] > 1.3 * widths[0]


def test_an_unknown_filter_widens_the_intervals_of_an_observer(observed, again, monkeypatch):
    seen = Some(of_position=True)
    assert observed_fit._filtered_unseen(Some(off_grid=True, alignment=None))
    assert not observed_fit._filtered_unseen(Some(off_grid=True, alignment=seen))
    monkeypatch.setattr(observed_fit, "_filtered_unseen", lambda _: True)
    assert width(again(), "sigma_1") == pytest.approx(
        2.5 * width(observed.result.best, "sigma_1"), rel=0.05
    )


def test_intervals_of_sliding_reach_to_inverse_dynamics(observed, again, monkeypatch):
    monkeypatch.setattr(observed_fit, "SHOWN_BY_SLIDING", ())
    narrow, wide = again(), observed.result.best
    assert narrow.parameters["F_C"].value == wide.parameters["F_C"].value
    assert width(narrow, "F_C") < width(wide, "F_C")


def test_intervals_widen_as_the_log_is_predicted_worse(again):
    better, alike, worse = (width(again(times), "sigma_1") for times in (0.5, 1.0, 1.3))
    assert better == alike
    assert worse == pytest.approx(1.3 * alike, rel=0.05)


def test_bands_contain_the_parameters_of_the_model(again):
    fit = again(finished=lambda values: {"F_C": 2.0 * values["F_C"]})
    assert np.mean(fit.resampling.bands.draws["F_C"]) == pytest.approx(
        2.0 * fit.parameters["F_C"].value, rel=0.01
    )


def test_a_diagnostic_of_inverse_dynamics_is_removed_with_its_value(observed, again):
    doubts = (
        Diagnostic("small_effect", "sigma_0"),
        Diagnostic("widened", numbers={"names": ("sigma_0",), "times": 2.5}),
        Diagnostic("delay_or_filter", severity="warning"),
        Diagnostic("filter_suspect", severity="warning"),
    )
    fit = again(plain=replace(observed.plain, diagnostics=(*observed.plain.diagnostics, *doubts)))
    assert fit.parameters["sigma_0"].status == "identified"
    codes = {one.code: one.severity for one in fit.diagnostics}
    assert not {"small_effect", "widened", "delay_or_filter"}.intersection(codes)
    assert codes["filter_suspect"] == "note"


def test_a_log_predicted_worse_than_its_replicates_keeps_inverse_dynamics(observed, again):
    fit = again(1.4)
    assert "predicts the next position 1.4 times worse" in message(told_in(fit))
    assert fit.estimates == observed.plain.estimates


def test_values_that_a_model_does_not_allow_are_reported_and_rejected(observed, again, monkeypatch):
    def refused(*_):
        raise InputError(
            "the best fit of lugre has values that the model does not allow", path="model"
        )

    monkeypatch.setattr(observed_fit, "fit_of", refused)
    fit = again()
    assert "has values that the model does not allow" in message(told_in(fit))
    assert fit.estimates == observed.plain.estimates


def test_a_log_of_segments_below_a_second_keeps_the_parameters_of_inverse_dynamics(
    observed, monkeypatch
):
    monkeypatch.setattr(observer, "SHORTEST", 10.0)
    fit = foreseen(observed.plain, observed.estimation, observed.context, observed.logs)
    assert fit.estimates == observed.plain.estimates
    assert "no observer was usable: no segment of the log lasts a second" in message(told_in(fit))


def test_an_interrupted_observer_leaves_the_parameters_of_inverse_dynamics(observed, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(intervals, "with_uncertainty", lambda *_: observed.plain)
    monkeypatch.setattr(intervals, "foreseen", interrupted)
    passed, remark = intervals.with_intervals(*observed.bounding)
    assert passed.fits[0] is observed.plain
    assert remark == "interrupted: the parameters are those of inverse dynamics"


def test_an_observer_without_draws_is_rejected(columns):
    with pytest.raises(InputError, match="draws") as refused:
        identify(
            columns,
            "lugre",
            axis=Axis(resolution=STEP),
            method="prediction_error",
            blocks=0,
            draws=0,
        )
    assert "--method inverse_dynamics" in refused.value.mend


@pytest.mark.parametrize(
    ("model", "treatment", "mass", "moves"),
    [
        ("lugre", {}, 3.0, True),
        ("lugre", {}, 0.0, False),
        # The effort of a sensor next to the contact moves no mass.
        ("lugre", {"keeps_rests": True}, 3.0, False),
        ("lugre", {"keeps_rests": True, "creeping": True}, 3.0, True),
        ("coulomb_viscous", {}, 3.0, False),
        ("lugre+transmitted", {}, 3.0, False),
        ("lugre+temperature", {}, 3.0, False),
    ],
)
def test_an_observer_needs_a_mass_a_contact_and_no_recorded_surroundings(
    observed, model, treatment, mass, moves
):
    component = br.friction.find(model)
    parameters = ParameterSet(component, ("M", *component.variables), {})
    inverse = replace(
        observed.estimation.inverse,
        dataset=replace(observed.context.dataset, **treatment),
        parameters=parameters,
    )
    values = {**dict.fromkeys(parameters.variables, 1.0), "M": mass}
    assert observable(inverse, values) == moves


def test_a_model_without_a_contact_keeps_inverse_dynamics(observed, monkeypatch):
    monkeypatch.setattr(observed_fit, "observable", lambda *_: False)
    assert (
        foreseen(observed.plain, observed.estimation, observed.context, observed.logs)
        is observed.plain
    )


@pytest.fixture
def first_search(observed, monkeypatch):
    """Return the first search of a ladder, its problem and its start, where the problem of inverse dynamics is changed."""
    searches = []

    def lost(errors, start, *_):
        searches.append((errors, start))
        return observer.Rung(errors, None, math.inf)

    def search(**changes):
        inverse, start, logs, context, held, levels, scatter, _ = observed.climbing.given
        monkeypatch.setattr(observer, "climbed", lost)
        assert (
            observer.climb(replace(inverse, **changes), start, logs, context, held, levels, scatter)
            == ()
        )
        return searches[0]

    return search


@pytest.mark.parametrize(("held", "samples"), [(True, 0.5), (None, 0.0)])
def test_the_search_starts_half_a_sample_later_for_a_zero_order_hold(
    observed, first_search, held, samples
):
    dataset = replace(observed.context.dataset, held=held)
    _, start = first_search(dataset=dataset)
    assert start[DELAY] == pytest.approx(observed.result.treatment["delay"] - samples * DT)


def test_a_fall_that_filtered_rows_hide_is_sought_again(observed, first_search):
    parameters = observed.estimation.inverse.parameters
    hidden = {**parameters.fixed, "v_S": Fixed(1.0, reason="", redundant=True)}
    free = tuple(name for name in parameters.free if name != "v_S")
    errors, start = first_search(parameters=replace(parameters, free=free, fixed=hidden))
    assert "v_S" in errors.parameters.free
    assert start["v_S"] == pytest.approx(0.02 * np.max(np.abs(observed.context.dataset.velocity)))


@pytest.mark.slow
def test_a_fall_is_found_behind_a_low_cutoff(columns):
    assert identified_from(columns, cutoff=8.0).best.parameters["v_S"].value == pytest.approx(
        TRUTH["v_S"], rel=0.1
    )


@pytest.mark.slow
def test_an_observer_finds_the_contact_despite_a_filtered_position(columns):
    result = identified_from({**columns, "position": through_filter(columns["position"], 3e-3, DT)})
    assert result.treatment["position_smoothing"] == pytest.approx(3e-3, rel=0.1)
    assert result.best.parameters["sigma_0"].value == pytest.approx(TRUTH["sigma_0"], rel=0.05)
    assert result.best.parameters["F_S"].value == pytest.approx(TRUTH["F_S"], rel=0.02)


@pytest.mark.parametrize("of_position", [True, False])
def test_a_known_filter_is_removed_from_its_channel(of_position):
    time = DT * np.arange(2000)
    phase, lag = 2.0 * np.pi * 20.0 * time, 2.0 * np.pi * 20.0 * 3e-3
    # Its mean delay is that of the log.
    sharp, filtered = (np.sin(phase), np.sin(phase + lag - np.arctan(lag)) / np.hypot(1.0, lag))
    log = Log.from_columns({"time": time, "position": filtered, "effort": filtered})
    alignment = Alignment(smoothing=-3e-3 if of_position else 3e-3, of_position=of_position)
    (part,) = observer._parts([log], alignment, DT)
    renewed, kept = (part.position, part.effort) if of_position else (part.effort, part.position)
    assert renewed[300:-300] == pytest.approx(sharp[300:-300], abs=0.02)
    assert kept == pytest.approx(filtered, abs=1e-15)


@pytest.mark.parametrize(("most", "starts"), [(4000, [0, 1333, 2666, 4000]), (150_000, [0])])
def test_a_long_log_is_observed_in_pieces(columns, monkeypatch, most, starts):
    monkeypatch.setattr(observer, "MOST", most)
    parts = list(observer._parts([Log.from_columns(columns)], Alignment(), DT))
    length = 5000 if len(starts) == 1 else 1000
    assert [part.position.tolist() for part in parts] == [
        columns["position"][first : first + length].tolist() for first in starts
    ]
    assert [part.effort.tolist() for part in parts] == [
        columns["effort"][first : first + length].tolist() for first in starts
    ]


def test_a_position_of_whole_steps_is_unfiltered_and_of_partial_steps_filtered():
    segments = [Some(recorded=STEP * np.array([0.0, 3.0, 3.0, 4.0, 9.0]))]
    off_grid = Dataset.off_grid.fget
    assert not off_grid(Some(segments=segments, resolution=STEP))
    assert off_grid(Some(segments=segments, resolution=1.6 * STEP))
    assert not off_grid(Some(segments=segments, resolution=0.0))
    # Of no grid: the smallest step is no encoder's.
    segments = [Some(recorded=STEP * np.array([0.0, 1.0, 2.4, 5.1, 9.0]))]
    assert not off_grid(Some(segments=segments, resolution=STEP))


def test_directional_forces_are_those_of_inverse_dynamics():
    component = br.friction.find("lugre+asymmetry")
    names = ("M", *component.variables)
    parameters = ParameterSet(component, names, {})
    estimation = Some(
        inverse=Some(parameters=parameters), solution=Some(values=dict.fromkeys(names, 2.0))
    )
    fit = Some(parameters={name: Some(interval=(1.0, 4.0)) for name in names})
    held = observed_fit.held_in(fit, estimation)
    assert set(held) == {"M", "F_C_pos", "F_C_neg", "sigma_2_pos", "sigma_2_neg", "offset"}
    assert {(entry.value, entry.half_width) for entry in held.values()} == {(2.0, 1.5)}


def test_a_diverging_replicate_is_dropped(monkeypatch):
    axis = Some(replicate=lambda *_: None)
    monkeypatch.setattr(observed_fit, "IdentifiedAxis", lambda *_: axis)
    inverse = Some(
        parameters=Some(complete=lambda _: {DELAY: 0.0, BEND: 0.0}),
        plant=str,
        model=str,
        dataset=None,
    )
    rung = Some(
        problem=Some(inverse=inverse, parts=(None,), lag=0.0, dt=DT, steps=2),
        solution=Some(values={}),
    )
    assert observed_fit.replicate(rung, Disturbance(0.0, 0.0, 0.0), None) is None


def test_a_replicate_has_the_known_forces_of_its_log(columns):
    friction = br.friction.lugre(**{name: value for name, value in TRUTH.items() if name != "M"})
    plain, pulled = (
        inertia(M=3.0),
        with_terms(inertia, columns=("weight",))(M=3.0, known_weight=0.5),
    )
    dataset, channel = Some(resolution=STEP), observed_fit.Channel(0.0, 0.0, 0.0)
    weight = np.linspace(20.0, 60.0, 5000)
    logs = []
    for plant, effort, known in (
        (plain, columns["effort"], ()),
        (pulled, columns["effort"] + 0.5 * weight, (weight,)),
    ):
        axis = observed_fit.IdentifiedAxis(plant, friction, dataset, DT, 4, channel)
        part = Recorded(columns["position"], effort, known)
        logs.append(axis.replicate(part, Disturbance(0.0, 0.0, 0.0), np.random.default_rng(1)))
    assert logs[1].position == pytest.approx(logs[0].position, abs=0.2 * STEP)
    assert (logs[1].effort - logs[0].effort)[100:-100] == pytest.approx(
        0.5 * weight[100:-100], abs=0.05
    )
    assert logs[1].columns == (weight,)


def test_an_effort_is_shifted_by_its_delay_and_sharpened_by_its_bend():
    omega, dt = 2.0 * np.pi * 5.0, 1e-3
    time = dt * np.arange(1001)
    recorded = Recorded(np.zeros(1001), np.sin(omega * time), ())
    moved, by_delay, by_bend = recorded.efforts(3e-3, 2e-5, dt)
    inner = slice(300, 700)
    sharper = math.exp(2e-5 * omega**2)
    assert moved[:-1][inner] == pytest.approx(
        sharper * np.sin(omega * (time + 3e-3))[inner], abs=2e-3
    )
    assert by_delay[:-1][inner] == pytest.approx(
        sharper * omega * np.cos(omega * (time + 3e-3))[inner], abs=0.1
    )
    assert by_bend[:-1][inner] == pytest.approx(
        sharper * omega**2 * np.sin(omega * (time + 3e-3))[inner], abs=2.0
    )


def test_a_prior_of_a_ratio_is_a_row_with_its_derivatives():
    expected = Expected({"F_S": 1.0, "F_C": -1.0}, logarithmic=True, mean=0.3, std=0.5, weight=4.0)
    names = ("F_C", "F_S", DELAY, BEND)
    values = {"F_C": 10.0, "F_S": 15.0, DELAY: 0.0, BEND: 0.0}
    row = expected.row(values, names, 0.1)
    assert row[0] == pytest.approx(0.1 * 2.0 / 0.5 * (math.log(1.5) - 0.3))
    near = expected.row({**values, "F_S": 15.0 + 1e-6}, names, 0.1)
    assert row[1:] == pytest.approx(
        [-0.4 / 10.0, (near[0] - row[0]) / 1e-6, 0.0, 0.0], rel=1e-6, abs=1e-12
    )


def test_an_observer_seeks_a_contact_between_the_samples():
    scales = Scales(1.0, 2.0, 0.5, 0.01, 1.0, 0.1, 1e-5, 10.0, 1e-3)
    finer = observer._finer(scales, 1e-7)
    assert (finer.shortest, finer.slowest) == (1e-7, observer.SLOWEST * 0.5)
    assert observer._finer(scales, 0.0).shortest == scales.shortest
    assert (
        observer._finer(scales._replace(slowest=1e-6), 1e-3)[:] == scales._replace(slowest=1e-6)[:]
    )


@pytest.mark.parametrize(
    ("cost", "priors", "error"),
    [(8.0, 0.0, 2e-6), (10.0, 2e-6, 2e-6), (1.0, 3e-6, np.inf), (np.nan, 0.0, np.inf)],
)
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

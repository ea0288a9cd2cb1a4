"""Estimates before any model: delay between effort and position, a filter in one channel, inertia."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.signal import lfilter
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort
from tests.identification.rigid import IDENTIFYING, identify

from bristle.core import Axis
from bristle.core.diagnostic import Diagnostic
from bristle.engine import force_along
from bristle.identification.estimation import along_the_motion
from bristle.identification.first_stage import alignment_of
from bristle.identification.settings import DEFAULT, Settings
from bristle.identification.uncertainty import _unsure
from bristle.models.friction import find
from bristle.prediction import predict
from bristle.prediction.predict import TREATED
from bristle.report.messages import assumptions_of, warnings_of

DT, FINE = 1e-3, 4e-5
FAST = {
    "duration": 12.0,
    "amplitudes": (0.02, 0.004, 0.0015),
    "frequencies": (0.5, 3.1, 7.3),
    "phases": (0.3, 1.1, 2.5),
}


def behind(signal, lag):
    """A signal on the fine grid behind a first-order filter."""
    keep = np.exp(-FINE / lag)
    return lfilter([1.0 - keep], [1.0, -keep], signal - signal[0]) + signal[0]


def before(signal, lag):
    """A signal on the fine grid before such a filter: what was commanded."""
    keep = np.exp(-FINE / lag)
    return (signal - keep * np.concatenate([signal[:1], signal[:-1]])) / (1.0 - keep)


@cache
def late(delay=0.0, *, step=0.0, effort_lag=0.0, position_lag=0.0, command_lag=0.0, bends=0.0):
    """A log whose effort was recorded so much later than it acted [s], and what was filtered by the way; friction may bend [N/m]."""
    fine = sines(dt=FINE, **FAST)
    effort = sliding_effort(fine, noise=0.0)
    if bends:
        friction = force_along(find("dahl")(F_C=TRUTH["F_C"], sigma_0=bends), fine.velocity, FINE)
        effort = sliding_effort(fine, noise=0.0, F_C=0.0) + friction
    effort = behind(effort, effort_lag) if effort_lag else effort
    # A spike of a command that falls between samples is recorded, too.
    effort = (
        uniform_filter1d(before(effort, command_lag), round(DT / FINE)) if command_lag else effort
    )
    place = behind(fine.position, position_lag) if position_lag else fine.position
    motion = sines(dt=DT, **FAST)
    recorded = np.interp(motion.time - delay, fine.time, effort)
    motion = motion._replace(position=np.interp(motion.time, fine.time, place))
    return log_of(
        motion, recorded + np.random.default_rng(5).normal(0.0, 0.05, recorded.size), step=step
    )


@cache
def found_in(delay=0.0):
    """What the first stage finds in a log with this delay."""
    return alignment_of([late(delay)], [None], DEFAULT)


@pytest.mark.parametrize(
    "samples",
    [0.0, 2.2, *(pytest.param(samples, marks=pytest.mark.slow) for samples in (-1.7, -0.5, 6.3))],
)
def test_a_delay_is_found_to_a_fraction_of_a_sample(samples):
    result = found_in(samples * DT)
    assert abs(result.delay - samples * DT) < result.delay_half_width < 0.15 * DT
    assert result.smoothing is None
    assert abs(result.mass - TRUTH["M"]) < result.mass_half_width < 0.005 * TRUTH["M"]


@pytest.mark.slow
def test_encoder_steps_do_not_bias_the_inertia():
    log, rows = late(-0.5 * DT, step=1e-4), {"cutoff": 200.0, "decimation": 8}
    mass = identify(log, "coulomb_viscous", blocks=0, draws=0, **rows).best.parameters["M"]
    # Least squares finds less than 0.97 of it. Three sines that repeat meet the same steps again and again: 1 % is left of them.
    assert mass.value == pytest.approx(TRUTH["M"], rel=0.015)
    assert mass.status == "identified"


def error_of(fit, log):
    """Error of a prediction of the log with the treatment of its fit."""
    treatment = {name: fit.treatment[name] for name in TREATED if name in fit.treatment}
    return predict(fit.best.plant, fit.best.friction, log, **treatment).metrics[
        "force_error_percent"
    ]


def codes_of(fit):
    return {diagnostic.code for diagnostic in fit.diagnostics}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("channel", "key", "lag", "model"),
    [
        ("effort", "smoothing", 3e-3, "coulomb_viscous"),
        ("position", "position_smoothing", 3e-3, "coulomb_viscous"),
        ("command", "smoothing", -3e-3, "dahl"),
    ],
)
def test_a_filter_in_one_channel_is_found_and_removed(channel, key, lag, model):
    # What jumps when the motion turns has no command.
    log = late(**{f"{channel}_lag": abs(lag)}, bends=1e6 if channel == "command" else 0.0)
    fit = identify(log, model, blocks=0, draws=0)
    assert {"smoothing", "position_smoothing"} & set(fit.treatment) == {key}
    assert fit.treatment[key] == pytest.approx(lag, rel=0.15)
    assert 0.0 < fit.treatment[f"{key}_half_width"] < 0.1 * abs(lag)
    viscous = "sigma_2" if model == "dahl" else "F_v"
    for name, true in (("M", TRUTH["M"]), (viscous, TRUTH["F_v"]), ("F_C", TRUTH["F_C"])):
        assert fit.best.parameters[name].value == pytest.approx(true, rel=0.01), name
    text = next(
        diagnostic for diagnostic in fit.best.diagnostics if diagnostic.code == "filter_suspect"
    )
    assert text.numbers["channel"] == channel
    words = (
        "is probably a command" if channel == "command" else f"the {channel} passed a filter with"
    )
    assert any(words in diagnostic for diagnostic in warnings_of(fit.best))
    assert error_of(fit, log) == pytest.approx(fit.best.force_error_percent, rel=1e-9)


@pytest.mark.slow
def test_the_search_for_the_channel_reports_progress_and_can_be_interrupted(monkeypatch):
    log, text = late(position_lag=3e-3), list[str]()
    identify(
        log, "coulomb_viscous", blocks=0, draws=0, progress=lambda share, task: text.append(task)
    )
    assert "looking for the channel that was filtered" in text

    def interrupted(*arguments):
        estimation = along_the_motion(*arguments)
        return replace(estimation, solution=replace(estimation.solution, unfinished=True))

    monkeypatch.setattr(IDENTIFYING, "along_the_motion", interrupted)
    with pytest.raises(KeyboardInterrupt):
        identify(log, "coulomb_viscous", blocks=0, draws=0)


@pytest.mark.slow
def test_a_late_effort_biases_no_parameter_and_is_reported():
    log = late(3.0 * DT)
    fit = identify(log, "coulomb_viscous", blocks=0, draws=0)
    assert "stages_differ" not in codes_of(fit.best)
    assert fit.treatment["delay"] == pytest.approx(3.0 * DT, abs=0.1 * DT)
    assert assumptions_of(fit.best)[0].startswith("the effort lags the position by 3")
    for name in ("M", "F_C"):
        assert fit.best.parameters[name].value == pytest.approx(TRUTH[name], rel=0.01)
    assert error_of(fit, log) == pytest.approx(fit.best.force_error_percent, rel=1e-9)
    assert (
        fit.best.force_error_percent
        < 0.7 * predict(fit.best.plant, fit.best.friction, log).metrics["force_error_percent"]
    )


def test_a_stated_delay_is_left_alone():
    stated = identify(
        late(3.0 * DT), "coulomb_viscous", axis=Axis(seeks_delay=False), blocks=0, draws=0
    )
    assert "delay" not in stated.treatment
    assert not {"delay_found", "delay_rough", "delay_unknown"} & codes_of(stated.best)


def test_a_log_that_does_not_show_the_delay_is_accepted():
    motion = sines(12.0, DT, (0.03,), (0.2,), (0.0,))
    fit = identify(
        log_of(motion, sliding_effort(motion, noise=1.0)), "coulomb_viscous", blocks=0, draws=0
    ).best
    assert "delay_unknown" in codes_of(fit)
    assert any(
        "hardly determines the delay of the effort" in diagnostic for diagnostic in warnings_of(fit)
    )


@pytest.mark.slow
def test_presliding_is_not_taken_for_a_delay():
    fine = sines(12.0, 1e-4, (6e-6, 3e-6), (0.5, 1.7), (0.0, 1.0))
    friction = force_along(
        find("maxwell_slip")(F_C=20.0, k_i=[3e6, 2e6], nu_i=[0.5, 0.5]), fine.velocity, 1e-4
    )
    assert (
        alignment_of(
            [log_of(type(fine)(*(item[::10] for item in fine)), friction[::10])], [None], DEFAULT
        ).delay
        is None
    )


def test_long_presliding_is_not_taken_for_a_filter():
    result = alignment_of([late(bends=1e5)], [None], DEFAULT)
    assert result.smoothing is None
    assert abs(result.mass - TRUTH["M"]) < 0.003 * TRUTH["M"]


@pytest.mark.slow
def test_uncertainty_of_the_delay_widens_dependent_intervals():
    sure, unsure = (
        identify(
            late(0.0),
            "coulomb_viscous",
            alignment=replace(found_in(0.0), delay_half_width=width),
            blocks=0,
            draws=20,
        ).best
        for width in (0.0, 3.0 * DT)
    )
    assert np.ptp(unsure.parameters["F_v"].interval) > 3.0 * np.ptp(sure.parameters["F_v"].interval)


@pytest.mark.parametrize(("samples", "way"), [(3.0, "lags"), (-3.0, "leads")])
def test_a_roughly_known_delay_is_removed_and_reported_as_uncertain_without_a_sign(samples, way):
    fit = identify(
        late(samples * DT),
        "coulomb_viscous",
        blocks=0,
        draws=0,
        settings=Settings(delay_rough=0.01),
    ).best
    (printed,) = (text for text in warnings_of(fit) if "by roughly" in text)
    assert f"{way} the position by roughly 3 ms (3.0 samples" in printed
    assert fit.parameters["M"].value == pytest.approx(TRUTH["M"], rel=0.002)


@pytest.mark.parametrize(
    "code", ["delay_unknown", "delay_rough", "delay_or_filter", "filter_suspect", "stages_differ"]
)
def test_each_doubt_about_the_treatment_counts_for_reversal_parameters(code):
    variables = find("lugre").variables
    solution = SimpleNamespace(space=SimpleNamespace(reported=(*variables, "k_1")))
    estimation = SimpleNamespace(
        resampled=(SimpleNamespace(parameters=SimpleNamespace(variables=variables)), solution)
    )
    assert set(_unsure([Diagnostic(code)], estimation)) == {"F_S", "v_S", "sigma_0", "sigma_1"}
    assert _unsure([Diagnostic("structure")], estimation) == ()


@pytest.mark.slow
@pytest.mark.parametrize("lags", [{}, {"effort_lag": 4e-3}])
def test_the_channel_is_not_sought_if_only_the_effort_can_be_filtered(monkeypatch, lags):
    requested = []
    monkeypatch.setattr(IDENTIFYING, "_left", lambda context: requested.append(0) or 0.0)
    identify(late(**lags), "coulomb_viscous", blocks=0, draws=0)
    assert not requested
    identify(late(position_lag=4e-3), "coulomb_viscous", blocks=0, draws=0)
    assert len(requested) == 2


def test_thresholds_decide_which_values_are_known():
    assert alignment_of([late(3.0 * DT)], [None], Settings(delay_unsure=0.01)).delay is None

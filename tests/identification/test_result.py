"""Results of an identification: friction along the log, notes, and checks of each log."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.identification.known_logs import STATED, TRUTH, sliding_log
from tests.identification.rigid import identify
from tests.logs.test_check import MASS, Run

from bristle.core.diagnostic import Diagnostic
from bristle.identification import Identification
from bristle.identification.estimate import Estimate
from bristle.identification.excitation import TRADED
from bristle.identification.result import LACKING, TRADED_IN
from bristle.models.friction import coulomb, viscous, with_slots
from bristle.prediction import predict
from bristle.report.identification import why_only_similar
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import DOUBTED, parameter_table
from bristle.report.sentences.checks import CHECKS

QUICK = {"axis": STATED, "draws": 0, "blocks": 0}


def test_friction_is_the_effort_minus_that_of_the_plant():
    traces = identify(sliding_log(noise=0.01), "coulomb_viscous", **QUICK).best.traces
    expected = (
        TRUTH["F_C"] * np.sign(traces.velocity) + TRUTH["F_v"] * traces.velocity + TRUTH["offset"]
    )
    # The filter rounds what jumps at reversals.
    assert np.median(np.abs(traces.friction - expected)) < 0.1
    assert np.mean(traces.friction) == pytest.approx(np.mean(expected), abs=0.05)


def test_a_note_of_one_log_names_it_and_a_common_note_does_not():
    logs = [
        replace(sliding_log(seed), source=Path(f"{seed}.csv"), notes=("of all", *notes))
        for seed, notes in enumerate(((), ("of one",)))
    ]
    assert identify(logs, "coulomb_viscous", **QUICK).notes == ("of all", "1.csv: of one")


def test_an_interval_is_that_of_the_larger_error_or_of_replicates():
    estimate = Estimate("F_C", "N", "level", -4.0, 0.1, robust_std=0.2)
    assert estimate.relative_std_percent == pytest.approx(2.5)
    assert estimate.larger_std == 0.2
    assert estimate.ends == pytest.approx((-4.392, -3.608), abs=1e-3)
    assert estimate.interval_percent == pytest.approx(9.8, abs=0.01)
    assert replace(estimate, interval=(-5.0, -3.0)).interval_percent == 25.0
    for changed, larger in (
        ({"std": None}, 0.2),
        ({"robust_std": None}, 0.1),
        ({"robust_std": 0.05}, 0.1),
    ):
        assert replace(estimate, **changed).larger_std == larger
    unknown = replace(estimate, std=None, robust_std=None)
    assert (
        unknown.relative_std_percent,
        unknown.larger_std,
        unknown.ends,
        unknown.interval_percent,
    ) == (None, None, None, None)
    zero = replace(estimate, value=0.0)
    assert (zero.relative_std_percent, zero.interval_percent) == (None, None)
    assert zero.ends is not None


def fit_with(name, *estimates, levels=True):
    component = with_slots(coulomb, ["asymmetry"]) if levels else viscous
    friction = SimpleNamespace(component=component)
    return SimpleNamespace(
        name=name,
        friction=friction,
        estimates=estimates,
        parameters={entry.name: entry for entry in estimates},
        with_constant=(),
    )


def notes_of(*fits, left_out=None, logs=((),)):
    recorded = [
        SimpleNamespace(notes=notes, source=Path(f"{number}.csv"))
        for number, notes in enumerate(logs)
    ]
    return Identification(fits, recorded[0], {}, tuple(recorded[1:]), left_out=left_out or {}).notes


def constant(value, std=0.1, robust=None, status="identified"):
    return Estimate("offset", "N", "constant", value, std, status=status, robust_std=robust)


HELD = replace(constant(0.0, None), status="held", reason=Diagnostic("held_levels", "offset"))
LEVELS = (Estimate("F_C_pos", "N", "level", 8.0, 0.1), Estimate("F_C_neg", "N", "level", 6.0, 0.1))


@pytest.mark.parametrize(
    ("other", "noted"),
    [
        (constant(2.1), True),
        (constant(1.9), False),  # a quarter of the larger level
        (constant(-2.1), True),
        (constant(2.5, std=0.8, robust=0.9), False),
        (constant(2.5, std=0.9, robust=0.8), True),
        (constant(2.5, status="unidentifiable"), False),
        (constant(2.5, std=None), False),
    ],
)
def test_a_large_significant_constant_force_of_another_model_is_noted(other, noted):
    assert bool(notes_of(fit_with("best", *LEVELS, HELD), fit_with("other", other))) is noted


def test_the_note_about_a_constant_force_names_the_first_model_and_a_line():
    (note,) = notes_of(
        fit_with("best", *LEVELS, HELD),
        fit_with("other", constant(2.1)),
        fit_with("third", constant(5.0)),
    )
    assert note.startswith(
        "best holds offset at 0, as every model with +asymmetry does. other identified offset = 2.1 N"
    )
    assert 'offset = "2.1 N" under [plant]' in note
    assert notes_of(fit_with("best", *LEVELS), fit_with("other", constant(5.0))) == ()
    # No level to compare with.
    assert (
        len(
            notes_of(
                fit_with("best", HELD, levels=False), fit_with("other", constant(0.2, std=0.01))
            )
        )
        == 1
    )


def test_omitted_models_are_named_last():
    notes = notes_of(
        fit_with("best", *LEVELS), left_out={"gms": "too few rows"}, logs=(("a", "b"), ("b",))
    )
    assert notes == ("0.csv: a", "b", "gms is omitted: too few rows")


RUNS = {"one_speed": {"speeds": (0.3,)}, "one_direction": {"back": False}}


def fits_to(log, model="coulomb_viscous", **requested):
    return identify(log, model, axis=STATED, draws=0, blocks=0, **requested).fits


@cache
def fit_to(code, **requested):
    """The fit to a log that lacks what the check of this code wants, or to a good one."""
    return fits_to(Run(0, **RUNS.get(code, {})).log(), **requested)[0]


def reported(fit, code):
    return [diagnostic for diagnostic in fit.diagnostics if diagnostic.code == code]


@pytest.mark.parametrize(
    ("code", "traded"),
    [("one_speed", {"F_C", "F_v", "offset"}), ("one_direction", {"F_C", "offset"})],
)
def test_every_confounded_parameter_is_named_and_has_a_remark_in_its_row(code, traded):
    fit = fit_to(code)
    (result,) = reported(fit, code)
    assert set(result.numbers["names"]) == traded
    assert (
        code == "one_direction"
    ) or "F_v, F_C, offset: these parameters are confounded" in message(result)
    doubted = {
        estimate.name for estimate in fit.estimates if estimate.status == "identified"
    } & traded
    remarks = {row[0]: row[-1] for row in parameter_table(fit).rows}
    assert doubted
    assert {name for name, remark in remarks.items() if DOUBTED in remark} == doubted


def test_every_finding_with_parameters_marks_their_rows():
    assert set(TRADED) <= {*TRADED_IN, *LACKING}


def test_a_known_parameter_is_not_confounded():
    (result,) = reported(fit_to("one_direction", offset=2.0), "one_direction")
    assert set(result.numbers["names"]) == {"F_C"}


def test_parameters_of_a_clipped_effort_are_effective():
    run = Run(0, (0.1, 0.5, 0.9))
    top = 0.6 * np.max(np.abs(run.effort()))
    noise = np.random.default_rng(0).normal(0.0, 0.3, run.t.size)
    (fit,) = fits_to(run.log(effort=np.clip(run.effort(), -top, top) + noise))
    assert {"M", "F_v", "F_C"} <= set(fit.effective)
    assert "effective" in {row[-1] for row in parameter_table(fit).rows}
    assert "similar motions, because the effort is clipped" in why_only_similar(fit)


def test_a_good_log_has_no_warnings_and_no_doubted_or_effective_parameters():
    fit = fit_to("", mass=MASS)
    assert [
        diagnostic.code
        for diagnostic in fit.diagnostics
        if diagnostic.code in set(CHECKS) - {"motion_repeats"}
    ] == []
    assert (fit.doubted, fit.effective) == ((), ())


def test_the_given_mass_is_compared():
    (result,) = reported(fit_to("", mass=2.0 * MASS), "mass_contradicts")
    assert result.numbers["ratio"] == pytest.approx(2.0, rel=0.03)
    assert "is 2 times the 12 kg that the log shows" in message(result)


def test_each_model_has_the_finding_and_its_threshold_can_be_set():
    log = Run(0).log(effort=-Run(0).effort())
    assert all(
        "sign of the effort seems reversed" in " ".join(warnings_of(fit))
        for fit in fits_to(log, "coulomb,coulomb_viscous")
    )
    assert reported(fits_to(log, settings={"reversed_work": 1.0})[0], "sign_reversed") == []


def test_fits_do_not_cross_lost_rows():
    run = Run(0)
    left = np.r_[: 16_000 // 3, 16_000 // 3 + 137 : 16_000]
    log = Run(0).log(
        time=1e-3 * np.arange(left.size),
        position=np.round(run.x, 7)[left],
        effort=run.effort()[left],
    )
    (fit,) = fits_to(log)
    assert "rows_lost" in {diagnostic.code for diagnostic in fit.diagnostics}
    assert fit.plant.values["M"] == pytest.approx(MASS, rel=2e-3)
    # Nor is it predicted across them: the step there would be an acceleration of many g.
    assert (
        predict(fit.plant, fit.friction, log).metrics["force_error_percent"]
        < 1.5 * fit.force_error_percent
    )

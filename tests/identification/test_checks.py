"""Checks of a log are reported with every fit, with the parameters that they concern."""

from functools import cache

import numpy as np
import pytest
from tests.identification.known_logs import STATED
from tests.identification.rigid import identify
from tests.logs.test_check import MASS, Run

from bristle.identification.excitation import TRADED
from bristle.identification.result import LACKING, TRADED_IN
from bristle.prediction import predict
from bristle.report.identification import why_only_similar
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import DOUBTED, parameter_table
from bristle.report.sentences.checks import CHECKS

RUNS = {"one_speed": {"speeds": (0.3,)}, "one_direction": {"back": False}}


def fits_to(log, model="coulomb_viscous", **requested):
    return identify(log, model, axis=STATED, draws=0, blocks=0, **requested).fits


@cache
def fit_to(code, **requested):
    """The fit to a log that lacks what the check of this code wants, or to a good one."""
    return fits_to(Run(0, **RUNS.get(code, {})).log(), **requested)[0]


def reported(fit, code):
    return [diagnostic for diagnostic in fit.diagnostics if diagnostic.code == code]


@pytest.mark.parametrize(("code", "traded"), [("one_speed", {"F_C", "F_v", "offset"}), ("one_direction", {"F_C", "offset"})])
def test_every_confounded_parameter_is_named_and_has_a_remark_in_its_row(code, traded):
    fit = fit_to(code)
    (result,) = reported(fit, code)
    assert set(result.numbers["names"]) == traded
    assert (code == "one_direction") or "F_v, F_C, offset: these parameters are confounded" in message(result)
    doubted = {estimate.name for estimate in fit.estimates if estimate.status == "identified"} & traded
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
    assert [diagnostic.code for diagnostic in fit.diagnostics if diagnostic.code in set(CHECKS) - {"motion_repeats"}] == []
    assert (fit.doubted, fit.effective) == ((), ())


def test_the_given_mass_is_compared():
    (result,) = reported(fit_to("", mass=2.0 * MASS), "mass_contradicts")
    assert result.numbers["ratio"] == pytest.approx(2.0, rel=0.03)
    assert "is 2 times the 12 kg that the log shows" in message(result)


def test_each_model_has_the_finding_and_its_threshold_can_be_set():
    log = Run(0).log(effort=-Run(0).effort())
    assert all("sign of the effort seems reversed" in " ".join(warnings_of(fit)) for fit in fits_to(log, "coulomb,coulomb_viscous"))
    assert reported(fits_to(log, settings={"reversed_work": 1.0})[0], "sign_reversed") == []


def test_fits_do_not_cross_lost_rows():
    run = Run(0)
    left = np.r_[: 16_000 // 3, 16_000 // 3 + 137 : 16_000]
    log = Run(0).log(time=1e-3 * np.arange(left.size), position=np.round(run.x, 7)[left], effort=run.effort()[left])
    (fit,) = fits_to(log)
    assert "rows_lost" in {diagnostic.code for diagnostic in fit.diagnostics}
    assert fit.plant.values["M"] == pytest.approx(MASS, rel=2e-3)
    # Nor is it predicted across them: the step there would be an acceleration of many g.
    assert predict(fit.plant, fit.friction, log).metrics["force_error_percent"] < 1.5 * fit.force_error_percent

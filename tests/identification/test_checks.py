"""Checks of a log are reported with every fit, with the parameters that they concern."""

import numpy as np
import pytest
from tests.logs.test_check import MASS, Run

from bristle.identification import identify
from bristle.identification.excitation import TRADED
from bristle.identification.result import LACKING, TRADED_IN
from bristle.prediction import predict
from bristle.report.identification import why_only_similar
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import DOUBTED, parameter_table
from bristle.report.sentences.checks import CHECKS


def reported(log, code, model="coulomb_viscous", **requested):
    """Return the diagnostics of a fit with one code."""
    return [diagnostic for diagnostic in identify(log, model, draws=0, blocks=0, **requested).best.diagnostics if diagnostic.code == code]


def test_every_parameter_confounded_at_one_speed_is_named():
    (result,) = reported(Run(0, (0.3,)).log(), "one_speed")
    assert set(result.numbers["names"]) == {"F_C", "F_v", "offset"}
    assert "F_v, F_C, offset: these parameters are confounded" in message(result)


def test_every_parameter_confounded_in_one_direction_is_named():
    (result,) = reported(Run(0, back=False).log(), "one_direction")
    assert set(result.numbers["names"]) == {"F_C", "offset"}


@pytest.mark.parametrize(
    ("run", "traded"),
    [(Run(0, (0.3,)), {"F_C", "F_v", "offset"}), (Run(0, back=False), {"F_C", "offset"})],
    ids=["one speed", "one direction"],
)
def test_a_parameter_with_an_unreliable_interval_has_a_remark_in_its_row(run, traded):
    fit = identify(run.log(), "coulomb_viscous", draws=0, blocks=0).best
    doubted = {estimate.name for estimate in fit.estimates if estimate.status == "identified"} & traded
    remarks = {row[0]: row[-1] for row in parameter_table(fit).rows}
    assert doubted
    assert {name for name, remark in remarks.items() if DOUBTED in remark} == doubted
    right = identify(Run(0).log(), "coulomb_viscous", mass=MASS, draws=0, blocks=0).best
    assert right.doubted == ()


def test_every_finding_with_parameters_marks_their_rows():
    assert set(TRADED) <= {*TRADED_IN, *LACKING}


def test_a_known_parameter_is_not_confounded():
    (result,) = reported(Run(0, back=False).log(), "one_direction", offset=2.0)
    assert set(result.numbers["names"]) == {"F_C"}


def test_parameters_of_a_clipped_effort_are_effective():
    run = Run(0, (0.1, 0.5, 0.9))
    top = 0.6 * np.max(np.abs(run.effort()))
    noise = np.random.default_rng(0).normal(0.0, 0.3, run.t.size)
    identification = identify(run.log(effort=np.clip(run.effort(), -top, top) + noise), "coulomb_viscous", draws=0, blocks=0)
    assert {"M", "F_v", "F_C"} <= set(identification.best.effective)
    assert "effective" in {row[-1] for row in parameter_table(identification.best).rows}
    assert "similar motions, because the effort is clipped" in why_only_similar(identification.best)
    assert identify(Run(0).log(), "coulomb_viscous", draws=0, blocks=0).best.effective == ()


def test_a_good_log_has_no_warnings():
    fit = identify(Run(0).log(), "coulomb_viscous", mass=MASS, draws=0, blocks=0).best
    assert [diagnostic.code for diagnostic in fit.diagnostics if diagnostic.code in set(CHECKS) - {"motion_repeats"}] == []


def test_the_given_mass_is_compared():
    (result,) = reported(Run(0).log(), "mass_contradicts", mass=2.0 * MASS)
    assert result.numbers["ratio"] == pytest.approx(2.0, rel=0.03)
    assert "is 2 times the 12 kg that the log shows" in message(result)


def test_each_model_has_the_finding_and_its_threshold_can_be_set():
    log = Run(0).log(effort=-Run(0).effort())
    every = identify(log, "coulomb,coulomb_viscous", draws=0, blocks=0).fits
    assert all("sign of the effort seems reversed" in " ".join(warnings_of(fit)) for fit in every)
    assert reported(log, "sign_reversed", settings={"reversed_work": 1.0}) == []


def test_fits_do_not_cross_lost_rows():
    run = Run(0)
    left = np.r_[: 16_000 // 3, 16_000 // 3 + 137 : 16_000]
    log = Run(0).log(time=1e-3 * np.arange(left.size), position=np.round(run.x, 7)[left], effort=run.effort()[left])
    fit = identify(log, "coulomb_viscous", draws=0, blocks=0).best
    assert "rows_lost" in {diagnostic.code for diagnostic in fit.diagnostics}
    assert fit.plant.values["M"] == pytest.approx(MASS, rel=2e-3)
    # Nor is it predicted across them: the step there would be an acceleration of many g.
    assert predict(fit.plant, fit.friction, log).metrics["force_error_percent"] < 1.5 * fit.force_error_percent

"""The report of an identification."""

import math
import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import STATED, sliding_log
from tests.report.pages import Page
from tests.report.test_pages import identification_page

from bristle.friction import MODELS, find
from bristle.identification import identify
from bristle.logs import Log
from bristle.prediction import drive_table, predict
from bristle.prediction.following import following_of, loop_of
from bristle.report.identification import identification_report
from bristle.report.judgement import ADVICE, next_measurements
from bristle.report.messages import assumptions_of, warnings_of
from bristle.report.model_tables import parameter_table
from bristle.report.page import worded
from bristle.simulation import simulate

pytestmark = pytest.mark.usefixtures("undrawn")


def plain(text: str) -> float:
    return float(text.replace("−", "-").replace("± ", ""))


def moved_by(shift):
    """A log whose effort is late by this many samples."""
    log = sliding_log()
    part = slice(50, 4050)
    effort = np.roll(log.effort.values, shift)[part]
    return Log(time=log.time.values[part], position=log.position.values[part], effort=effort, sample_time=1e-3)


def told_of(log, **options):
    return " ".join(assumptions_of(identify(log, "coulomb_viscous", draws=0, blocks=0, **options).best))


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("shift", "stands"), [(3, "lags"), (-3, "leads")])
def test_removed_delay_is_reported(shift, stands):
    words = rf"the effort {stands} the position by \d\.\d+ ms \(\d\.\d\d samples; .*, and removed it"
    assert re.search(words, told_of(moved_by(shift)))


@pytest.mark.slow
@pytest.mark.parametrize("options", [{"settings": {"delay_rough": 0.0}}, {"axis": STATED}])
def test_a_delay_that_hardly_shows_or_was_stated_is_not_told(options):
    assert ", and removed it" not in told_of(moved_by(3), **options)


def test_interval_of_the_table_uses_the_larger_error(workbench):
    fit = workbench.identified.best
    wider = tuple(replace(item, robust_std=item.std and 3.0 * item.std) for item in fit.estimates)
    table = parameter_table(replace(fit, estimates=wider))
    for row, estimate in zip(table.rows, fit.estimates, strict=True):
        cells = dict(zip(table.heads, row, strict=True))
        if estimate.std is None:
            assert cells["95 % interval [%]"] == "–"
        else:
            # Of what was found before any model, the interval itself is known.
            percent = estimate.interval_percent if estimate.interval else 3.0 * 1.96 * estimate.relative_std_percent
            assert plain(cells["95 % interval [%]"]) == pytest.approx(percent, rel=0.06)


def test_unidentified_parameter_has_advice_to_measure(workbenches):
    bench = workbenches["rotational"]
    richer_first = replace(bench.identified, fits=bench.identified.fits[::-1])
    bench = replace(bench, identified=richer_first)
    unknown = [estimate.name for estimate in bench.identified.best.estimates if estimate.status == "unidentifiable"]
    assert unknown
    words = Page(identification_page(bench)).words
    assert all(Page(worded(warning)).words in words for warning in warnings_of(bench.identified.best))
    for names, motion in next_measurements(bench.identified.best):
        assert Page(worded(f"{names}: {motion}")).words in words


def test_every_excitation_has_advice():
    requested = {variable.excitation for model in MODELS.values() for variable in model.variables.values()}
    assert requested - {""} <= set(ADVICE)


def test_report_has_assumptions_and_provenance(stage):
    words = Page(identification_page(stage)).words
    assert all(Page(worded(item)).words in words for item in assumptions_of(stage.identified.best))
    assert all(fact in words for fact in ("stage.csv", "0" * 64, "1 ms (1000 Hz)", "6 s", "made by a simulation", "column q"))


def test_report_has_the_assumptions_of_the_prediction(stage):
    axis = replace(stage.axis, presliding=2e-6)
    best = stage.identified.best
    predicted = predict(best.plant, best.friction, stage.log, axis, "closed-loop")
    assumed = Page(identification_page(stage, prediction=predicted)).words.split("Assumptions")[-1]
    assert "closed-loop prediction: bristle simulated the static friction with the pre-sliding distance of the axis file, 2 µm" in assumed


@pytest.mark.slow
def test_parameters_at_an_edge_or_infinite_are_reported(stage):
    lugre = identify(stage.log, find("lugre"), axis=stage.axis, blocks=0, draws=0)
    assert "∞" in Page(identification_page(stage, identification=lugre, simulation=None, prediction=None)).words
    assert [estimate.name for estimate in lugre.best.estimates if math.isinf(estimate.value)] == ["v_d"]


@pytest.mark.slow
@pytest.mark.measured
def test_the_report_of_a_measured_axis():
    folder = os.environ.get("BRISTLE_DATA")
    if not folder:
        pytest.skip("BRISTLE_DATA is not set")
    from bristle.files import read_axis
    from bristle.logs import read_log

    axis = read_axis(Path(__file__).parents[2] / "examples" / "emps" / "axis.toml")
    log = read_log(Path(folder) / "emps" / "DATA_EMPS.mat", axis)
    identification = identify(log, "coulomb_viscous,coulomb_viscous+asymmetry", axis=axis, draws=0)
    best = identification.best
    loop = simulate(loop_of(best.plant, best.friction, log, axis))
    text = identification_report(
        identification,
        prediction=predict(best.plant, best.friction, log, axis, "closed-loop"),
        simulation=loop,
        table=drive_table(best),
        command="bristle identify",
        axis_name=axis.name,
        provenance={},
    )
    words = Page(text).words
    for told in ("model coulomb_viscous+asymmetry", "Values to enter into the drive", "lowers the following error"):
        assert told in words


def test_unidentified_parameters_are_named_once_on_the_first_page(workbenches):
    bench = workbenches["rotational"]
    fit = bench.identified.best
    open_ = tuple(replace(estimate, status="unidentifiable") for estimate in fit.estimates)
    text = identification_page(bench, identification=replace(bench.identified, fits=(replace(fit, estimates=open_),)))
    verdict = Page(text.partition('<div class="tabs">')[0]).words
    assert "the level of friction is not identified" in verdict
    assert "Values to enter" not in Page(text).words
    assert Page(text).words.count("not identified: M") == 1


def test_without_simulation_the_following_error_is_measured(stage):
    words = Page(identification_page(stage, simulation=None, following=following_of(stage.log))).words
    assert [told in words for told in ("Following error in the log", "without and with compensation")] == [True, False]

"""The thresholds: documented, checked, passed on from the call, the axis and the command line, and shown."""

import math
from dataclasses import replace

import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.core import Axis, InputError
from bristle.core.errors import InputWarning
from bristle.identification import identify
from bristle.identification.settings import DEFAULT, Settings
from bristle.report.model_tables import changed_settings

pytestmark = pytest.mark.usefixtures("of_one_mass")

AS_TREATED = Axis(seeks_delay=False, cutoff=100.0)  # each model has its own inertia


@pytest.fixture(scope="module")
def log():
    motion = sines(6.0)
    return log_of(motion, sliding_effort(motion, noise=3.0))


def fitted(log, axis=AS_TREATED, blocks=0, **options):
    return identify(log, "coulomb_viscous", axis=axis, draws=0, blocks=blocks, **options)


def codes(result):
    return [diagnostic.code for diagnostic in result.best.diagnostics]


@pytest.fixture(scope="module")
def usual(log):
    """The result with all thresholds at their defaults."""
    return fitted(log)


def test_each_threshold_has_a_meaning_and_its_default_is_allowed():
    assert len(Settings.described()) > 20
    for threshold in Settings.described():
        assert len(threshold.meaning) > 10, threshold.name
        assert threshold.unit, threshold.name
        assert threshold.least <= threshold.default <= threshold.most, threshold.name
    assert Settings.of({threshold.name: threshold.default for threshold in Settings.described()}) == DEFAULT


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"unsure": 1.0}, "settings.unsure"),
        ({"unsure_std": -1.0}, ">= 0"),
        ({"inseparable": 1.5}, "0 to 1"),
        ({"unsure_std": math.nan}, "settings.unsure_std"),
        ({"unsure_std": True}, "settings.unsure_std"),
        ({"unsure_std": "0.5"}, "settings.unsure_std"),
    ],
)
def test_an_unknown_or_out_of_range_threshold_is_rejected(given, told):
    with pytest.raises(InputError, match=told):
        Settings.of(given)


def test_thresholds_of_the_call_override_those_of_the_axis(log):
    axis = replace(AS_TREATED, settings={"unsure_std": 1e-9, "inseparable": 0.9})
    strict = fitted(log, axis)
    assert strict.best.parameters["M"].status == "unidentifiable"
    assert strict.settings.changed == {"unsure_std": 1e-9, "inseparable": 0.9}
    mild = fitted(log, axis, settings={"unsure_std": 0.5})
    assert {estimate.status for estimate in mild.best.estimates} == {"identified"}
    assert mild.settings.changed == {"inseparable": 0.9}
    # Nothing but what is said of the fit depends on them.
    for name, estimate in strict.best.parameters.items():
        assert estimate.value == mild.best.parameters[name].value
    with pytest.raises(InputError, match=r"identification\.settings\.nothing"):
        fitted(log, Axis(settings={"nothing": 1.0}))


@pytest.mark.parametrize(
    ("changed", "code"),
    [
        ({"acceleration_noise": 0.0}, "noisy_acceleration"),
        ({"poor_error": 0.0}, "unexplained"),
        ({"inseparable": 0.0}, "correlated"),
        ({"unsure_std": 1e-9}, "low_acceleration"),
    ],
)
def test_a_threshold_decides_the_diagnostics(log, usual, changed, code):
    assert code not in codes(usual)
    assert code in codes(fitted(log, settings=changed))


def test_rows_of_a_held_out_block_decide_the_number_of_blocks(log, usual):
    rows = usual.treatment["rows"]
    for least, blocks in ((rows // 10, 5), (rows // 4, 3)):
        found = fitted(log, blocks=None, settings={"held_out_rows": float(least), "lines_gain": 1.0})
        assert len(found.best.held_out.block_errors_percent) == blocks
    assert "too_short" in codes(fitted(log, blocks=None, settings={"held_out_rows": float(rows)}))


def test_a_table_shows_the_thresholds_that_were_changed():
    changed = Settings.of({"unsure_std": 0.25})
    assert changed_settings(DEFAULT) is None
    table = changed_settings(changed)
    assert [tuple(row[:3]) for row in table.rows] == [("unsure_std", "0.25", "0.5")]
    assert set(changed.as_data()) == {threshold.name for threshold in Settings.described()}  # all of them stand in summary.json


THRESHOLDS_OF_0_2 = """
amplitude_half_cycles at_odds clear_std coloured_correlation coloured_error delay_inertia filter_seen flat_rise follows
half_sample_damping hopeless_std missing_effort missing_share missing_share_around moved negligible_force nested_loop
noisy_inertia repeated_overlap repeated_size reversal_error reversal_excess reversal_lag reversal_periods reversal_share seen_rise
stages_apart tremble unfinished_error white_lags white_level
"""


@pytest.mark.parametrize("name", THRESHOLDS_OF_0_2.split())
def test_a_threshold_of_the_last_release_has_no_effect_and_warns(name):
    assert name not in {threshold.name for threshold in Settings.described()}
    with pytest.warns(InputWarning, match=rf"settings\.{name}: has no effect any more"):
        assert Settings.of({name: 1.0}) == DEFAULT

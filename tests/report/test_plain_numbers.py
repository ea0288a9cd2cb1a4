"""Numbers and reasons in readable sentences."""

from types import SimpleNamespace

import pytest

from bristle.core.diagnostic import Diagnostic
from bristle.identification.estimate import Estimate
from bristle.logs.break_away import BreakAway
from bristle.report.log import break_away_table
from bristle.report.messages import message
from bristle.report.model_tables import _parameter_row


def reported(code, **numbers):
    return message(Diagnostic(code, "sigma_0" if "reversals" in numbers else "", numbers=numbers))


def test_percentage_has_no_power_of_ten():
    text = reported("missing_position", force=3.0, percent=318.0, share_percent=50.0, model="", compared="")
    assert "318 %" in text
    assert "e+" not in text


@pytest.mark.parametrize(("key", "other", "said"), [("model", "compared", "Next: try {}"), ("compared", "model", "also compared {}")])
def test_model_is_suggested_or_reported_as_compared(key, other, said):
    named = "stribeck_free+position"
    text = reported("missing_position", force=3.0, percent=3.0, share_percent=50.0, **{key: named, other: ""})
    assert said.format(f"`{named}`") in text


@pytest.mark.parametrize(
    ("model", "compared", "end"),
    [
        ("", "", "This model already has a ripple of one period: look for a second period in motor, screw and belt"),
        (
            "",
            "coulomb+periodic",
            "Cogging or a screw is the likely cause. bristle also compared `coulomb+periodic`, but its error is no smaller",
        ),
        ("coulomb+periodic", "", "Cogging or a screw is the likely cause. Next: try `coulomb+periodic`"),
    ],
)
def test_ripple_suggests_a_model_unless_compared_or_present(model, compared, end):
    numbers = {"period": 0.01, "amplitude": 2.0, "percent": 5.0, "model": model, "compared": compared}
    assert reported("missing_ripple", share_percent=50.0, force=1.0, **numbers).endswith(end)


def test_motion_in_one_direction_has_no_negative_share():
    assert "%" not in reported("one_direction", direction="forward", percent=0.0)
    assert "for all but 0.4 % of its travel" in reported("one_direction", direction="forward", percent=0.4)


def test_equal_speeds_are_written_once():
    assert "at one speed, 20 mm/s." in reported("one_speed", slowest=0.02, fastest=0.0200001)
    assert "18 mm/s to 21 mm/s" in reported("one_speed", slowest=0.018, fastest=0.021)


@pytest.mark.parametrize(
    ("reversals", "samples", "said", "unsaid"),
    [(3632, 435.0, "slow enough for the filter", "only"), (3632, 4.0, "each of 3632", "only"), (7, 4.0, "only 7 reversals", "slow enough")],
)
def test_reversals_are_called_few_or_fast_by_their_number(reversals, samples, said, unsaid):
    text = reported("few_reversals", reversals=reversals, zone=5e-6, samples=samples, filter_samples=10.0)
    assert said in text
    assert unsaid not in text


def row(value, interval, unit="N*m"):
    estimate = Estimate("offset", unit, "offset", value, None, "unidentifiable", interval=interval)
    return tuple(_parameter_row(estimate, {}, plain=False, remark="").values())


def test_very_large_half_width_is_more_than_ten_times():
    cells = row(1e-6, (-0.43, 0.47))
    assert "> 1000" in cells
    assert not any("e+" in cell or "−430000" in cell for cell in cells)


def test_interval_around_zero_has_the_unit_of_its_ends():
    cells = row(1e-6, (-0.43, 0.47))
    assert "−430 to 470" in cells
    assert "mN·m" in cells


def test_tiny_interval_has_no_digits_of_rounding():
    cells = row(2.106e-4, (2.106e-4 - 5e-19, 2.106e-4 + 5e-19), "m/s")
    assert not any("e+" in cell or "e−" in cell for cell in cells)
    assert "< 0.001" in cells


def test_interval_of_equal_break_aways_has_no_equal_ends():
    alike = BreakAway(0.001, 12, 1.5674, (1.5674, 1.5674), 1e-4, (0.9e-4, 1.1e-4))
    best = SimpleNamespace(plant=SimpleNamespace(kind="translational"))
    row = break_away_table(SimpleNamespace(break_aways=(alike,), best=best)).rows[0]
    assert "1.57, to the last digit" in row
    assert not any(cell.partition(" to ")[0] == cell.partition(" to ")[2] for cell in row)

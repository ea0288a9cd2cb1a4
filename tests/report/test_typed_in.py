"""Values of an identification for a drive, in units of the drive."""

from types import SimpleNamespace as Some

import pytest
from tests.report import known
from tests.report.known import estimate

from bristle.core import Axis
from bristle.core.axis import Column
from bristle.core.diagnostic import Diagnostic
from bristle.report import identification as report
from bristle.report.identification import _for_the_drive, _typed_in


def levels(**changes):
    usual = {"inertia": 12.0, "forward": 8.0, "backward": 9.0, "constant": 0.0, "deviation": 0.5}
    return Some(**usual | {"viscous_forward": 30.0, "viscous_backward": 30.0} | changes)


def fit(status="identified", *diagnostics, mass=None, kind="translational"):
    estimates = [estimate("M", 12.0, mass or status), estimate("F_C", 8.0, status), estimate("F_v", 0.0, "held")]
    return known.fit(*estimates, kind=kind, velocity=(-0.5, 0.2), diagnostics=diagnostics)


@pytest.fixture
def typed(monkeypatch):
    """The values to enter, for given levels and distance."""

    def lines(outcome=None, axis=None, distance=0.0, item=None, **changes):
        fastest = []
        monkeypatch.setattr(report, "level_values", lambda fit: outcome if outcome != "usual" else levels(**changes))
        monkeypatch.setattr(report, "reversal_distance", lambda friction, speed: fastest.append(speed) or distance)
        result = _typed_in(item or fit(), axis)
        assert fastest in ([], [0.5])
        return [line.replace("\u00a0", " ") for line in result]

    return lines


def test_levels_are_by_direction_with_the_viscous_part(typed):
    assert typed("usual") == [
        "mass 12 kg",
        "F+ 8 N, F− 9 N, viscous 30 N·s/m: these values are at most 500 mN below the steady friction, never above it",
        "or use the table for the drive, below",
    ]
    assert (
        "F− 9 N, constant 2 N, viscous forward 30 N·s/m, viscous backward 40 N·s/m:"
        in typed("usual", constant=2.0, viscous_backward=40.0)[1]
    )
    assert typed("usual", forward=None, viscous_forward=None, viscous_backward=0.0)[1].startswith("F− 9 N: these values are at most")
    assert typed("usual", item=fit(kind="rotational"))[0] == "inertia 12 kg·m²"


def test_unidentified_mass_is_not_reported(typed):
    assert typed("usual", item=fit(mass="unidentifiable"))[0] == "mass: not identified"


def test_positive_distance_of_a_reversal_is_reported(typed):
    assert typed("usual", distance=4e-6)[2] == "after a reversal, 95 % of the friction builds up within 4 µm"


def test_levels_are_also_in_units_of_the_drive(typed):
    columns = {"position": Column("x", "mm", "m", 1.0), "effort": Column("u", "V", "V", 35.0)}
    lines = typed("usual", Axis(columns=columns))
    assert lines[2] == f"in V: F+ {8.0 / 35.0:.3f}, F− {9.0 / 35.0:.3f}"


@pytest.mark.parametrize(
    ("item", "words"),
    [
        (fit("unidentifiable"), "no values: no parameter was identified"),
        (
            fit("identified", Diagnostic("never_slides")),
            "no values: the log never slides, so it shows no level of friction. Record sliding motion",
        ),
        (fit(), "no values: a plant on a spring has no constant-velocity motion"),
    ],
)
def test_empty_answer_has_a_reason(typed, item, words):
    assert typed(None, item=item) == [words]


@pytest.mark.parametrize(("deviation", "words"), [(8.9e-6, "follow the model"), (9.1e-6, "deviate from the model by 9.1 µN at most")])
def test_straight_lines_follow_the_model_within_rounding(deviation, words, monkeypatch):
    monkeypatch.setattr(report, "largest_deviation", lambda fit, table: deviation)
    lead, block = _for_the_drive(fit(), [(-0.1, -9.0), (0.1, 8.0)], None)
    assert f"Straight\nlines between the rows {words}." in lead
    assert block.content.rows[0][0] == "1"
    assert block.further == ("The same table in SI units, to be copied:", "velocity [m/s],effort [N]\n-0.1,-9\n0.1,8")

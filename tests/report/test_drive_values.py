"""The distance of a reversal in JSON and on the first page, with the levels for a drive."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log

import bristle as br
from bristle.identification import identify
from bristle.report.identification import answers
from bristle.report.summary import identification_summary

AXIS = br.read_axis(
    {
        "schema": 1,
        "kind": "translational",
        "columns": {
            "time": {"column": "t", "unit": "s"},
            "position": {"column": "q", "unit": "mm"},
            "effort": {"column": "u", "unit": "N"},
        },
        "transmission": {"lead": "10 mm"},
    }
)
SOFT = br.friction.lugre(F_C=8.0, F_S=8.0, v_S=4e-3, sigma_0=1e5)
DISTANCE = 8.0 / 1e5 * np.log(20.0)  # of a bristle that slips exponentially, 5 % of the change is left


@pytest.fixture(scope="module")
def with_memory():
    identified = identify(sliding_log(), "coulomb_viscous", blocks=0, draws=0)
    return replace(identified, fits=(replace(identified.best, friction=SOFT), *identified.fits[1:]))


def test_summary_has_the_distance_of_a_reversal(with_memory):
    summary = identification_summary(with_memory, table=(), simulation=None, prediction=None, provenance={}, axis=AXIS)
    levels = summary["drive_levels"]
    assert levels["reversal_distance"] == pytest.approx(DISTANCE, rel=0.1)
    assert levels["units"]["mm"]["reversal_distance"] == pytest.approx(1e3 * levels["reversal_distance"])
    turned = levels["units"]["deg of the motor"]["reversal_distance"]
    assert turned == pytest.approx(levels["reversal_distance"] / 0.01 * 360.0)


def test_unidentified_inertia_has_no_value(with_memory):
    best = with_memory.best
    estimates = tuple(replace(estimate, status="unidentifiable") if estimate.name == "M" else estimate for estimate in best.estimates)
    vague = replace(with_memory, fits=(replace(best, estimates=estimates),))
    lines = [dict(answers(estimate, None, None, AXIS))["Values to enter"] for estimate in (with_memory, vague)]
    assert [sum(("at the motor" in line and "kg" in line) or "g·cm²" in line for line in page) for page in lines] == [1, 0]
    assert lines[1][0] == "mass: not identified"


def test_first_page_has_the_distance_of_models_with_memory(with_memory):
    typed = dict(answers(with_memory, None, None, AXIS))["Values to enter"]
    message = next(line for line in typed if line.startswith("after a reversal"))
    assert "µm" in message
    assert "deg of the motor" in message
    static = replace(with_memory, fits=(replace(with_memory.best, friction=br.friction.coulomb(F_C=8.0)),))
    assert not any("reversal" in line for line in dict(answers(static, None, None, AXIS))["Values to enter"])

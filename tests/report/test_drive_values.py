"""The distance of a reversal in JSON and on the first page, with the levels for a drive."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log

import bristle as br
from bristle.identification import identify
from bristle.report.cards import cards_of
from bristle.report.model_tables import values_to_enter
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


def values(identification):
    return {row[0]: row[1:] for row in values_to_enter(identification.best, AXIS).rows}


def test_unidentified_inertia_has_no_value(with_memory):
    best = with_memory.best
    estimates = tuple(replace(estimate, status="unidentifiable") if estimate.name == "M" else estimate for estimate in best.estimates)
    vague = replace(with_memory, fits=(replace(best, estimates=estimates),))
    assert "at the motor" in values(with_memory)["Mass or inertia"][0]
    assert "Mass or inertia" not in values(vague)


def test_card_has_the_distance_of_models_with_memory(with_memory):
    cards = {card.label: card for card in cards_of(with_memory.best, AXIS, usable=True)}
    assert "µm" in cards["Builds up over"].value
    assert "deg of the motor" in cards["Builds up over"].remark
    static = replace(with_memory.best, friction=br.friction.coulomb(F_C=8.0))
    assert "Builds up over" not in {card.label for card in cards_of(static, AXIS, usable=True)}

"""Information criteria penalise parameters without effect, and reward useful parameters."""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, slow_log
from tests.identification.rigid import identify
from tests.identification.test_elements import KNOWN, elements_log

from bristle import friction
from bristle.files import load_code
from bristle.report.model_tables import comparison_table


@pytest.fixture(scope="module")
def compared():
    motion = sines(6.0)
    identification = identify(
        log_of(motion, sliding_effort(motion)), "viscous,coulomb_viscous,coulomb_viscous+asymmetry", axis=STATED, draws=0, blocks=0
    )
    return {fit.name: fit for fit in identification.fits}


def test_the_truth_costs_least(compared):
    bic = {name: fit.information.bic for name, fit in compared.items()}
    assert min(bic, key=bic.get) == "coulomb_viscous"
    assert bic["viscous"] > 100.0
    assert bic["coulomb_viscous+asymmetry"] > 0.0


def test_each_criterion_is_the_difference_from_its_smallest_value(compared):
    assert [min(getattr(fit.information, criterion) for fit in compared.values()) for criterion in ("aic", "bic")] == [0.0, 0.0]


def price_between(item, other):
    """How many parameters one fit has more than another, from the prices of both criteria."""
    aic, bic = (getattr(other.information, name) - getattr(item.information, name) for name in ("aic", "bic"))
    return (bic - aic) / (np.log(item.information.measurements) - 2.0)


def test_both_criteria_differ_by_the_price_of_a_parameter(compared):
    item, other = compared["coulomb_viscous"], compared["coulomb_viscous+asymmetry"]
    assert price_between(item, other) == pytest.approx(len(other.correlation_names) - len(item.correlation_names))
    assert item.information.measurements <= item.traces.time.size
    assert {"aic", "bic"} <= set(item.metrics)


def test_each_element_that_slips_has_its_price():
    identification = identify(elements_log(duration=6.0), "dahl,maxwell_slip", axis=KNOWN, draws=0, blocks=0)
    fits = {fit.name: fit for fit in identification.fits}
    item, other = fits["dahl"], fits["maxwell_slip"]
    elements = len(other.friction.values["k_i"])
    assert elements >= 3
    # Stiffness of each element, viscous friction and offset.
    assert price_between(item, other) == pytest.approx(elements + 2 - len(item.correlation_names))
    assert int({row[0]: row[2] for row in comparison_table(identification).rows}["maxwell_slip"]) == elements + 2


def test_a_model_that_ignores_its_parameters_identifies_none_of_them(tmp_path):
    text = (Path(__file__).parents[2] / "examples" / "quadratic_drag.py").read_text()
    (tmp_path / "own.py").write_text(re.sub(r"    return p\.F_C.*", "    return 5.0, Move()", text))
    log = slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0), duration=10.0)
    identification = identify(log, load_code(tmp_path / "own.py"), axis=STATED, mass=28.0, offset=0.0, draws=0, blocks=0)
    assert identification.best.parameters["F_C"].status == "unidentifiable"

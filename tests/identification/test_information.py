"""Information criteria: parameters that explain nothing cost, those that explain something pay."""

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.identification import identify


@pytest.fixture(scope="module")
def compared():
    motion = sines(10.0)
    found = identify(
        log_of(motion, sliding_effort(motion)), "viscous,coulomb_viscous,coulomb_viscous+asymmetry", draws=0, blocks=0
    )
    return {fit.name: fit for fit in found.fits}


def test_the_truth_costs_least(compared):
    bic = {name: fit.information.bic for name, fit in compared.items()}
    assert min(bic, key=bic.get) == "coulomb_viscous"
    assert bic["viscous"] > 100.0
    assert bic["coulomb_viscous+asymmetry"] > 0.0


def test_both_criteria_differ_by_the_price_of_a_parameter(compared):
    one, other = compared["coulomb_viscous"], compared["coulomb_viscous+asymmetry"]
    more = len(other.correlation_names) - len(one.correlation_names)
    aic = other.information.aic - one.information.aic
    bic = other.information.bic - one.information.bic
    assert bic - aic == pytest.approx(more * (np.log(one.information.measurements) - 2.0))
    assert one.information.measurements <= one.traces.time.size
    assert {"aic", "bic"} <= set(one.metrics)

"""What is said of an estimate at the edge of its model or of what was searched."""

import pytest
from tests.identification.known_logs import sliding_log

from bristle.identification import identify


def codes(fit, name):
    return [one.code for one in fit.diagnostics if one.parameter == name]


@pytest.mark.parametrize(("F_v", "expected"), [(30.0, []), (-3.0, ["edge_of_model"])])
def test_a_coefficient_that_would_be_negative_stays_at_the_edge_of_its_model(F_v, expected):
    fit = identify(sliding_log(F_v=F_v), "coulomb_viscous", draws=0, blocks=0).best
    assert codes(fit, "F_v") == expected
    assert fit.parameters["F_v"].value == pytest.approx(max(F_v, 0.0), abs=1.0)

"""The bound of the deflection in sliding."""

import math

import pytest
from tests.simulation.certificates.ballscrew import (
    F_S,
    STIFFNESS,
    UM,
    composite,
    lugre,
    maxwell_slip,
)

from bristle import friction
from bristle.simulation.certificates import check
from bristle.simulation.certificates.certify import well_posed
from bristle.simulation.certificates.quasi_static import holding_of


def well_posed_of(model):
    return well_posed(model, holding_of(model))


@pytest.mark.parametrize("transition", ["paper", "leuven", "elastoplastic"])
@pytest.mark.parametrize(
    ("kernel", "micrometres"), [("dahl_masing", 6.207), ("reformed_dahl_exact", 11.380)]
)
def test_the_bound_of_the_deflection(transition, kernel, micrometres):
    result = well_posed_of(composite(transition, kernel=kernel))
    assert result.value / UM == pytest.approx(micrometres, abs=6e-4)
    assert result.passed
    assert "20 % above F_S" in result.advice


@pytest.mark.parametrize("ratio", [1.05, 1.5, 2.0])
def test_the_bound_is_at_the_static_force_of_the_operator(ratio):
    f_p = ratio * F_S
    assert well_posed_of(composite(f_p=f_p)).value == pytest.approx(
        f_p * F_S / (STIFFNESS * (f_p - F_S)), rel=1e-6
    )


def test_an_elastic_part_that_never_yields_is_found():
    result = check(friction.bouc_wen(s=1e6, F_C=20.0, alpha=0.01))
    assert [name for name, item in result.items() if item.applies] == ["passive", "dissipation"]
    assert "spring" in result["drift"].advice


@pytest.mark.parametrize(("ratio", "finite"), [(0.95, False), (1.0, False), (1.02, True)])
def test_without_saturation_well_above_the_static_force_it_grows(ratio, finite):
    result = well_posed_of(composite(f_p=ratio * F_S, validate=False))
    assert math.isfinite(result.value) is finite
    assert result.value > result.threshold or not finite
    assert not result.passed
    assert "raise f_p to at least 136.5 mN·m" in result.advice


def test_the_limit_is_the_bound_at_the_least_margin():
    least = well_posed_of(composite(f_p=1.05 * F_S))
    assert well_posed_of(composite()).threshold == pytest.approx(least.value, rel=1e-9)
    assert least.passed


@pytest.mark.parametrize(("model", "bound"), [(lugre(), F_S / STIFFNESS), (maxwell_slip(), F_S)])
def test_other_models_are_bounded_for_all_parameters(model, bound):
    result = well_posed_of(model)
    assert (result.value, result.passed) == (pytest.approx(bound, rel=1e-12), True)

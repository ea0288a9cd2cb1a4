"""Passivity: the condition, its forms, and that the condition means what it says."""

import math

import pytest
from tests.certificates.ballscrew import F_C, F_S, V_S, composite, gms, lugre

from bristle import friction
from bristle.certificates import check, needed_damping
from bristle.core.variable import unit_of

RATIO = (F_S - F_C) / F_C
EDGE = 4.0 * math.sqrt(2.0 * math.e) * F_C


def passive_of(model):
    return check(model)["passive"]


@pytest.mark.parametrize(
    ("model", "needed"),
    [
        (lugre, RATIO),
        (lambda **values: composite("paper", **values), RATIO),
        (composite, RATIO),
        (lambda **values: composite("leuven", n=2, **values), (F_S / F_C) ** 2 - 1.0),
        (lambda **values: composite("leuven", n=8, **values), (F_S / F_C) ** 8 - 1.0),
    ],
)
def test_the_condition_for_constant_micro_damping(model, needed):
    sigma_1 = 0.25
    found = passive_of(model(sigma_1=sigma_1, sigma_2=0.9 * sigma_1 * needed))
    assert found.threshold == pytest.approx(sigma_1 * needed, rel=1e-8)
    assert found.unit == unit_of("force*time/length", "rotational")
    assert not found.passed
    assert passive_of(model(sigma_1=sigma_1, sigma_2=sigma_1 * needed)).passed


def test_the_advice_passes_when_followed():
    failed = passive_of(lugre())
    assert not failed.passed
    assert passive_of(lugre(sigma_2=failed.threshold)).passed


def test_micro_damping_that_fades_early_needs_no_viscosity():
    sigma_1 = 0.1
    # The bound 4 sqrt(2e) F_C is sufficient, and known to be violated pointwise at its double.
    assert passive_of(lugre(sigma_1=sigma_1, sigma_2=0.0, v_d=EDGE / sigma_1)).passed
    assert not passive_of(lugre(sigma_1=sigma_1, sigma_2=0.0, v_d=2.0 * EDGE / sigma_1)).passed
    assert not passive_of(lugre(sigma_1=sigma_1, sigma_2=0.0)).passed


def test_where_the_bristle_force_is_unlimited_the_bound_is_sharp():
    def needed(v_d):
        return needed_damping(
            10.0 * F_S, V_S, lambda v: F_C, lambda v: 0.1 * math.exp(-((v / v_d) ** 2)), lambda q, G: q / G
        )

    assert needed(0.999 * EDGE / 0.1) == 0.0
    assert needed(1.01 * EDGE / 0.1) > 0.0


def test_the_worse_direction_counts():
    asymmetric = friction.find("lugre+asymmetry")
    found = passive_of(
        asymmetric(F_C_pos=20.0, F_C_neg=20.0, F_S_pos=28.0, F_S_neg=24.0, v_S=2e-3, sigma_0=1e7, sigma_1=1e3,
                   sigma_2_pos=300.0, sigma_2_neg=300.0)
    )  # fmt: skip
    assert found.threshold == pytest.approx(400.0, rel=1e-8)
    assert not found.passed


def test_nothing_is_claimed_where_no_condition_is_known():
    assert not passive_of(gms()).applies

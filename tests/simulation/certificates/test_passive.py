"""Passivity: the condition, its forms, and that the condition means what it says."""

import math
from pathlib import Path

import pytest
from tests.simulation.certificates.ballscrew import (
    F_C,
    F_S,
    SLIDING,
    STIFFNESS,
    V_S,
    composite,
    gms,
    lugre,
)

from bristle import friction
from bristle.core.variable import unit_of
from bristle.files.user_model import load_code
from bristle.simulation.certificates import needed_damping, passive

EXAMPLE = Path(__file__).parents[3] / "examples" / "quadratic_drag.py"
RATIO = (F_S - F_C) / F_C
EDGE = 4.0 * math.sqrt(2.0 * math.e) * F_C


def elastoplastic(**values):
    return friction.elastoplastic(**SLIDING, sigma_0=STIFFNESS, **values)


def passive_of(model):
    return passive.passive(model, False)


@pytest.mark.fast_cases(2)
@pytest.mark.parametrize(
    ("model", "needed"),
    [
        (lugre, RATIO),
        (lambda **values: composite("paper", **values), RATIO),
        (composite, RATIO),
        (lambda **values: elastoplastic(z_ba=0.0, **values), RATIO),
        (lambda **values: elastoplastic(z_ba=0.9 * F_C / STIFFNESS, **values), RATIO),
        (lambda **values: composite("leuven", n=2, **values), (F_S / F_C) ** 2 - 1.0),
        (lambda **values: composite("leuven", n=8, **values), (F_S / F_C) ** 8 - 1.0),
    ],
)
def test_the_condition_for_constant_micro_damping(model, needed):
    sigma_1 = 0.25
    result = passive_of(model(sigma_1=sigma_1, sigma_2=0.9 * sigma_1 * needed))
    assert result.threshold == pytest.approx(sigma_1 * needed, rel=1e-8)
    assert result.unit == unit_of("force*time/length", "rotational")
    assert not result.passed
    assert passive_of(model(sigma_1=sigma_1, sigma_2=sigma_1 * needed)).passed


@pytest.mark.parametrize(
    ("model", "present"),
    [
        (friction.coulomb(F_C=8.0), 0.0),
        (friction.viscous(F_v=30.0), 30.0),
        (friction.coulomb_viscous(F_C=8.0, F_v=30.0), 30.0),
        (friction.stribeck(F_C=8.0, F_S=12.0, v_S=1e-3, F_v=30.0), 30.0),
        (friction.dahl(F_C=8.0, sigma_0=1e6, sigma_2=30.0), 30.0),
    ],
    ids=lambda item: getattr(item, "name", None),
)
def test_friction_that_returns_no_energy_is_passive_for_any_viscosity(model, present):
    result = passive_of(model)
    assert result.applies
    assert (result.value, result.threshold, result.passed) == (present, 0.0, True)


# The bound 4 sqrt(2e) F_C is sufficient, and known to be violated pointwise at its double.
@pytest.mark.parametrize(
    ("v_d", "passed"), [(EDGE / 0.1, True), (2.0 * EDGE / 0.1, False), (math.inf, False)]
)
def test_micro_damping_that_fades_early_needs_no_viscosity(v_d, passed):
    assert passive_of(lugre(sigma_1=0.1, sigma_2=0.0, v_d=v_d)).passed is passed


def test_the_bound_is_sharp_for_an_unlimited_bristle_force():
    def needed(v_d):
        return needed_damping(
            10.0 * F_S,
            V_S,
            lambda v: F_C,
            lambda v: 0.1 * math.exp(-((v / v_d) ** 2)),
            lambda q, G: q / G,
        )

    assert needed(0.999 * EDGE / 0.1) == 0.0
    assert needed(1.01 * EDGE / 0.1) > 0.0


def test_the_worse_direction_counts():
    asymmetric = friction.find("lugre+asymmetry")
    result = passive_of(
        asymmetric(
            F_C_pos=20.0,
            F_C_neg=20.0,
            F_S_pos=28.0,
            F_S_neg=24.0,
            v_S=2e-3,
            sigma_0=1e7,
            sigma_1=1e3,
            sigma_2_pos=300.0,
            sigma_2_neg=300.0,
        )
    )
    assert result.threshold == pytest.approx(400.0, rel=1e-8)
    assert not result.passed


ACTIVE = friction.gms(F_C=20.0, F_S=28.0, v_S=2e-3, C=2e3, k_i=[1e7], nu_i=[1.0], sigma_2=8000.0)


# From the elements of GMS and from the last turn of reformed Dahl more energy comes back than went in.
@pytest.mark.parametrize("model", [ACTIVE, gms(), friction.reformed_dahl(s=1e7, f_p=20.0)])
def test_friction_that_returns_more_energy_is_not_passive_for_any_viscosity(model):
    assert (passive_of(model).applies, passive_of(model).passed, passive_of(model).threshold) == (
        True,
        False,
        math.inf,
    )


def test_gms_is_passive_without_a_stribeck_effect():
    assert passive_of(ACTIVE.with_values(F_S=20.0)).passed


def test_no_verdict_without_a_known_condition():
    of_a_user = load_code(EXAMPLE)
    assert not passive_of(of_a_user(**of_a_user.example)).applies


@pytest.mark.parametrize(
    ("summit", "height"),
    [
        ((0.123456, 0.654321), 0.0),
        ((-0.9, -1.3), 0.0),
        ((passive.DECADES[1] + 1.0, 0.5), -1.0),  # at the ends of the speeds and of the forces
        ((0.2, 5.0), -9.0),
        ((0.2, -5.0), -9.0),
    ],
)
def test_a_maximum_is_found_from_its_neighbourhood_within_the_ends(summit, height):
    def hill(x, q):
        return -((x - summit[0]) ** 2) - (q - summit[1]) ** 2

    start = (min(summit[0], passive.DECADES[1]) + 0.3, min(max(summit[1], -2.0), 2.0) - 0.2)
    assert passive._summit(hill, start, (0.5, 0.5), 2.0) == pytest.approx(height, abs=1e-12)

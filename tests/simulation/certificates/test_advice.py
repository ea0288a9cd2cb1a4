"""What certificates say and hold against what, by contacts whose answer is known beforehand."""

import math

import numpy as np
import pytest
from tests.simulation.certificates.ballscrew import F_S, RIPPLE, composite, lugre, maxwell_slip

from bristle import friction, hysteresis
from bristle.core.errors import InputError
from bristle.simulation.certificates import certify
from bristle.simulation.certificates.certificate import Certificate, as_friction, not_applicable
from bristle.simulation.certificates.certify import (
    Loop,
    closure,
    default_loop,
    dissipation,
    drift,
    well_posed,
)
from bristle.simulation.certificates.passive import Damping, damping_of, needed_damping, passive
from bristle.simulation.certificates.quasi_static import Holding, Path, holding_of

UNEVEN = Holding(-1.0, 3.0, 2e-6)


def test_levels_are_shares_of_the_way_to_break_away():
    assert (
        UNEVEN.half,
        UNEVEN.level(0.0),
        UNEVEN.level(1.0),
        UNEVEN.level(-1.0),
        UNEVEN.level(0.5),
    ) == (2.0, 1.0, 3.0, -1.0, 2.0)


@pytest.mark.parametrize(
    ("holding", "breaks_away", "has_presliding"),
    [
        (UNEVEN, True, True),
        (Holding(-1.0, 3.0, 0.0), True, False),
        (Holding(0.0, 0.0, 1.0), False, False),
        (Holding(-math.inf, math.inf, 1.0), False, False),
    ],
)
def test_a_contact_breaks_away_at_a_force_between_zero_and_infinity(
    holding, breaks_away, has_presliding
):
    assert (holding.breaks_away, holding.has_presliding) == (breaks_away, has_presliding)


def test_a_certificate_that_does_not_apply_has_a_reason_and_no_value():
    assert not_applicable("N", "why") == Certificate(False, None, "N", None, None, "why")


def test_an_operator_as_friction_has_the_mean_of_both_ends_of_a_step():
    spring = as_friction(hysteresis.stop(r=1.0))
    path = Path(spring, Holding(-1.0, 1.0, 0.5))
    path.to_position(0.5)
    x, force = path.trace
    assert path.force == pytest.approx(0.5)
    assert force[1:-1] == pytest.approx(x[1:-1])  # the mean force of a step is that in its middle


# --- drift ----------------------------------------------------------------------------------------------------------


def test_drift_is_stated_per_hour():
    item = drift(lugre(), holding_of(lugre()), RIPPLE, False)
    assert drift(lugre(), holding_of(lugre()), None, False) == drift(
        lugre(), holding_of(lugre()), (0.3 * F_S, 0.6 * F_S), False
    )
    assert not item.passed
    assert item.value > item.threshold > 0.0
    # Ten cycles in a second for an hour.
    assert item.advice.startswith(f"It drifts {36_000 * item.value:.3g} rad ")
    assert item.advice.endswith(
        "in an hour at 10 Hz: take maxwell_slip, gms, or preisach_lugre with its gate"
    )


def test_a_contact_that_rests_moves_by_less_than_a_millionth_of_its_way():
    model = maxwell_slip()
    item = drift(model, holding_of(model), RIPPLE, False)
    path = Path(model, holding_of(model))
    path.to_force(RIPPLE[1])
    assert item.threshold == pytest.approx(1e-6 * path.x)
    assert abs(item.value) <= item.threshold
    assert (item.passed, item.advice) == (True, "It does not drift")


@pytest.mark.parametrize(
    ("model", "holding", "is_magnetic", "advice"),
    [
        (lugre(), holding_of(lugre()), True, "magnet"),
        (lugre(), Holding(-math.inf, math.inf, 0.0), False, "no break-away force"),
        (
            friction.coulomb(F_C=2.0),
            Holding(-2.0, 2.0, 0.0),
            False,
            "It rests: no motion below break-away",
        ),
    ],
)
def test_drift_applies_to_friction_with_a_break_away_force(model, holding, is_magnetic, advice):
    item = drift(model, holding, None, is_magnetic)
    assert advice in item.advice
    assert (item.value, item.passed) == ((0.0, True) if item.applies else (None, None))


# --- closure --------------------------------------------------------------------------------------------------------


def test_the_missing_force_is_a_share_of_break_away_with_the_sign_of_the_load():
    model = lugre()
    holding = holding_of(model)
    x1, x2 = default_loop(model, holding)
    item, mirrored = (closure(model, holding, loop) for loop in ((x1, x2), (-x1, -x2)))
    path = Path(model, holding)
    path.to_position(x1)
    loaded = path.force
    assert loaded == pytest.approx(0.85 * F_S, rel=1e-3)
    assert x2 == 0.5 * x1
    path.to_position(x2)
    path.to_position(x1)
    assert item.value == pytest.approx((path.force - loaded) / F_S)
    assert mirrored.value == pytest.approx(item.value)
    assert (item.threshold, item.unit, item.passed) == (1e-3, "1", False)
    assert item.advice.startswith(
        f"{100.0 * abs(item.value):.3g} % of break-away is missing at the return"
    )


def test_a_loop_that_returns_to_its_force_is_closed():
    model = maxwell_slip()
    item = closure(model, holding_of(model), None)
    assert (item.passed, item.advice) == (True, "It returns to its former force")
    assert abs(item.value) < 1e-9
    assert not closure(model, Holding(-1.0, 1.0, 0.0), None).applies


@pytest.mark.parametrize(
    ("call", "pair", "words"),
    [
        *(
            (
                lambda ripple: drift(lugre(), Holding(-F_S, F_S, 1e-3), ripple, False),
                ripple,
                r"force_ripple.*above -0\.13 and below 0\.13 N\*m",
            )
            for ripple in ((-F_S, 0.0), (0.0, F_S), (0.05, 0.05), (0.06, 0.04))
        ),
        *(
            (
                lambda loop: closure(lugre(), Holding(-F_S, F_S, 1e-3), loop),
                loop,
                r"loop.*must be two reversal positions.*for example .3e-6, 1\.5e-6. rad",
            )
            for loop in (
                (0.0, 0.0),
                (1e-3, 1e-3),
                (1e-3, 2e-3),
                (-1e-3, -2e-3),
                (math.inf, 0.0),
                (1e-3, math.nan),
            )
        ),
    ],
)
def test_a_ripple_lies_where_the_contact_rests_and_a_loop_turns_away_from_zero_and_back(
    call, pair, words
):
    with pytest.raises(InputError, match=words):
        call(pair)


# --- energy ---------------------------------------------------------------------------------------------------------


def test_coulomb_keeps_all_work_and_a_spring_keeps_no_work():
    turn = np.sin(np.linspace(0.0, 2.0 * np.pi, 401))
    assert certify._share_kept(friction.coulomb(F_C=2.0), turn, 1.0) == pytest.approx(1.0)
    spring = as_friction(hysteresis.stop(r=10.0))
    assert certify._share_kept(spring, turn, 1.0) == pytest.approx(0.0, abs=1e-9)
    assert certify._share_kept(spring, np.zeros(11), 1.0) == 0.0


def test_cycles_that_return_energy_are_stated_by_their_share(monkeypatch):
    model, holding, loop = (
        friction.coulomb(F_C=1.0),
        Holding(-1.0, 1.0, 0.0),
        Loop(1e-3, 1.0, False),
    )
    shares = iter([0.5, -0.125, *(0.1 for _ in range(1000))])
    monkeypatch.setattr(certify, "_share_of_random_cycle", lambda *requested: next(shares))
    item = dissipation(model, holding, loop)
    assert (item.value, item.threshold, item.unit, item.passed) == (-0.125, 0.0, "1", False)
    assert (
        item.advice
        == "A closed cycle returns energy, 12.5 % of all work in it: see passive for the remedy"
    )
    fine = dissipation(model, holding, loop)
    assert (fine.value, fine.passed, fine.advice) == (0.1, True, "No cycle of 200 returns energy")


def test_cycles_are_as_wide_as_the_contact_and_run_backward_for_a_magnet(monkeypatch):
    requested = []
    monkeypatch.setattr(
        certify,
        "_share_of_random_cycle",
        lambda model, generator, scale, sense: requested.append((scale, sense)) or 1.0,
    )
    for holding, loop in (
        (Holding(-1.0, 1.0, 2e-6), Loop(1e-3, 1.0, False)),
        (Holding(-1.0, 1.0, 0.0), Loop(1e-3, -1.0, True)),
    ):
        dissipation(None, holding, loop)
    assert (requested[0], requested[-1], len(requested)) == ((2e-6, 1.0), (1e-3, -1.0), 400)


@pytest.mark.parametrize(
    ("shares", "expected"),
    [((0.2,), 0.2), ((-0.4, -0.3), -0.3), ((-0.4, -0.1), 0.0), ((-1e-10,), -1e-10)],
)
def test_a_loss_that_finer_steps_remove_is_ignored(monkeypatch, shares, expected):
    kept, sizes = iter(shares), []

    def share(model, x, duration):
        sizes.append(x.size)
        return next(kept)

    monkeypatch.setattr(certify, "_share_kept", share)
    assert certify._share_of_random_cycle(None, np.random.default_rng(1), 1e-6, 1.0) == expected
    assert sizes == [401, 3201][: len(shares)]


def test_random_cycles_are_closed_and_up_to_a_hundred_times_as_wide(monkeypatch):
    reaches, speeds = [], []

    def share(model, x, duration):
        assert x[0] == pytest.approx(x[-1], abs=1e-9 * np.max(np.abs(x)))
        reaches.append(np.max(np.abs(x)))
        speeds.append(np.sum(np.abs(np.diff(x))) / duration)
        return 1.0

    monkeypatch.setattr(certify, "_share_kept", share)
    generator = np.random.default_rng(3)
    for _ in range(300):
        assert certify._share_of_random_cycle(None, generator, 1.0, 1.0) == 1.0
    assert 0.01 < np.min(reaches) < 0.2
    assert 50.0 < np.max(reaches) < 500.0
    assert 1e-6 <= np.min(speeds) < 1e-5
    assert 10.0 < np.max(speeds) <= 100.0


# --- deflection -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("share", "passed", "advice"),
    [
        (1.2, True, "f_p is 20 % above F_S"),
        (1.02, False, "f_p is only 2 % above F_S: raise f_p to at least 136.5 mN·m"),
    ],
)
def test_saturation_is_compared_with_the_larger_static_force(share, passed, advice):
    model = composite(f_p=share * F_S, validate=False)
    item = well_posed(model, holding_of(model))
    assert (item.passed, item.unit) == (passed, "rad")
    assert item.advice.startswith(advice)


def test_other_models_are_bounded_by_their_static_force():
    item = well_posed(lugre(), holding_of(lugre()))
    assert (item.value, item.threshold, item.passed) == (
        pytest.approx(F_S / 100.0, rel=1e-3),
        math.inf,
        True,
    )
    assert item.advice == "The deflection is bounded for all parameters"
    assert not well_posed(lugre(), Holding(-1.0, 1.0, 0.0)).applies
    operator = as_friction(hysteresis.stop(r=1e-6))
    assert not well_posed(operator, holding_of(operator)).applies


# --- passivity ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("damping", "passed", "advice"),
    [
        (Damping(0.0), True, "Passive for any viscous coefficient"),
        (Damping(5.0, 3.0), True, "sigma_2 exceeds the least value for passivity by 2 N·s/m"),
        (Damping(3.0, 3.0), True, "sigma_2 exceeds the least value for passivity by 0 N·s/m"),
        (
            Damping(2.9, 3.0),
            False,
            "Bristles charged at rest and released at speed return energy: raise sigma_2 to at least 3 N·s/m",
        ),
        (
            Damping(2.9, math.inf, "It lies"),
            False,
            "It lies: no viscous coefficient can compensate this",
        ),
    ],
)
def test_damping_is_compared_with_the_least_value(monkeypatch, damping, passed, advice):
    monkeypatch.setattr("bristle.simulation.certificates.passive.damping_of", lambda p: damping)
    item = passive(friction.viscous(F_v=1.0), False)
    assert (item.value, item.threshold, item.passed) == (damping.present, damping.needed, passed)
    assert item.advice.replace("3.000", "3").replace("2.000", "2").replace("0.000", "0") == advice
    assert not passive(friction.viscous(F_v=1.0), True).applies


def test_the_side_with_the_smaller_margin_counts(monkeypatch):
    sides = iter([Damping(5.0, 1.0), Damping(5.0, 4.0)])
    monkeypatch.setattr("bristle.simulation.certificates.passive.damping_of", lambda p: next(sides))
    uneven = friction.find("viscous+asymmetry")(F_v_pos=5.0, F_v_neg=5.0)
    assert passive(uneven, False).threshold == 4.0
    sides = iter([Damping(5.0, 1.0), None])
    assert not passive(uneven, False).applies


def beta(value):
    return friction.bouc_wen(
        **(friction.bouc_wen.example | {"beta": value}), validate=False
    ).parameters


def stops(weights, spring):
    return hysteresis.prandtl_ishlinskii(
        thresholds=[1e-6, 2e-6], weights=weights, spring=spring
    ).parameters


@pytest.mark.parametrize(
    ("p", "needed"),
    [
        *((beta(value), needed) for value, needed in ((0.5, 0.0), (0.6, 0.0), (0.49, math.inf))),
        *((stops(*weights), 0.0) for weights in (([1.0, 2.0], 0.0), ([1.0, 0.0], 3.0))),
    ],
)
def test_bouc_wen_returns_energy_below_a_half_and_stops_with_positive_weights_never(p, needed):
    assert damping_of(p).needed == needed


# Constant micro-damping needs sigma_1 (F_S - F_C)/F_C.
@pytest.mark.parametrize(("sigma_1", "needed"), [(0.0, 0.0), (500.0, 200.0)])
def test_the_needed_viscosity_grows_with_micro_damping(sigma_1, needed):
    assert needed_damping(
        28.0, 1e-3, lambda v: 20.0, lambda v: sigma_1, lambda q, G: q / G
    ) == pytest.approx(needed, rel=1e-8)

"""Operators side by side: ranked by what they were not fitted to, and whether any of them can be adequate."""

import numpy as np
import pytest
from tests.golden.simulated import MASING, NOISE, recorded, reversal_curves, to_and_fro

import bristle as br
from bristle.core.errors import InputError
from bristle.identification.hysteresis import predict_operator
from bristle.identification.hysteresis.result import congruency_of
from bristle.logs.curves import Curve, Curves


@pytest.fixture(scope="module")
def friction():
    rng = np.random.default_rng(11)
    return recorded(MASING, to_and_fro(rng, turns=50, samples=800), rng)


def test_operators_are_ranked_by_held_out_error(friction):
    message, shares = [], []
    result = br.identify_operator(
        friction,
        "all",
        cells=12,
        progress=lambda share, text: (message.append(text), shares.append(share)),
    )
    assert [fit.rank for fit in result.fits] == [1, 2, 3]
    assert result.best.name == "preisach"
    held_out = [fit.held_out.mean_percent for fit in result.fits]
    assert held_out == sorted(held_out)
    assert result.best.operator.values["s"] == pytest.approx(1.0, rel=0.02)
    assert list(dict.fromkeys(message)) == [
        "fitting prandtl_ishlinskii",
        "fitting preisach",
        "fitting preisach_grid",
    ]
    assert len(shares) == 3 * 6
    assert shares == sorted(shares)
    for fit in result.fits:
        assert predict_operator(fit.operator, friction, fit.offset).rmse == pytest.approx(
            fit.prediction.rmse
        )


def test_all_operators_are_identified_by_default(friction):
    fits = [
        br.identify_operator(friction, *named, cells=4, stops=5, folds=0).fits
        for named in ((), ("all",), (["all"],))
    ]
    assert (
        [fit.name for fit in fits[0]]
        == [fit.name for fit in fits[1]]
        == [fit.name for fit in fits[2]]
    )
    assert {fit.name for fit in fits[0]} == {"prandtl_ishlinskii", "preisach", "preisach_grid"}


@pytest.mark.slow
def test_curves_are_left_out_by_turns():
    curves = reversal_curves(MASING)
    result = br.identify_operator(
        Curves(curves, start="saturated"), "reversal_table,preisach_grid", cells=6
    )
    assert result.best.name == "reversal_table"
    assert len(result.best.held_out.block_errors_percent) == 5
    assert result.best.held_out.mean_percent < 0.2
    # The table goes through its own curves.
    assert result.best.prediction.error_percent < 0.01


def test_congruency_equals_the_noise_for_an_adequate_operator(friction):
    result = congruency_of(friction)
    # The noise of a sample and that of the turning point.
    assert NOISE < result.alike < 3.0 * NOISE
    assert NOISE < result.anywhere < 3.0 * NOISE


def test_congruency_detects_data_that_no_operator_can_follow():
    rng = np.random.default_rng(12)
    u = to_and_fro(rng)
    lugre = br.friction.dahl(sigma_0=1.0, F_C=1.0)
    chained = Curves((Curve(u, br.response(lugre, u, 1.0)),))
    assert congruency_of(chained).alike > 0.05
    centred = br.hysteresis.preisach(kernel="reformed_dahl_exact", s=1.0, f_p=1.0)
    result = congruency_of(recorded(centred, u))
    assert result.anywhere > 5.0 * result.alike
    assert (
        congruency_of(Curves((Curve(np.linspace(0.0, 1.0, 50), np.linspace(0.0, 1.0, 50)),))).alike
        is None
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"model": "preisach_lugre"}, "is not a valid choice; .* reversal_table, all"),
        ({"model": "all,preisach"}, "each once"),
        ({"model": "preisach,preisach"}, "each once"),
        ({"model": "reversal_table"}, "needs reversal curves"),
        ({"folds": 1}, "folds: out of range"),
        (
            {"model": "preisach_grid", "cells": 101},
            "cells: out of range; found 101, allowed 2 to 100",
        ),
        ({"stops": 1}, "stops: out of range; found 1, allowed 2 to"),
        ({"folds": 500}, "too few samples for so many folds"),
    ],
)
def test_unsuitable_requests_are_refused(friction, arguments, words):
    with pytest.raises(InputError, match=words):
        br.identify_operator(friction, **({"model": "prandtl_ishlinskii"} | arguments))

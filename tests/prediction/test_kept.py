"""A fit from the numbers that its files keep."""

import math
from dataclasses import fields

import numpy as np
import pytest

from bristle import friction, plants
from bristle.identification.result import Traces
from bristle.prediction.kept import fit_of

PLANT, FRICTION = plants.inertia(M=2.0), friction.coulomb(F_C=20.0)


def estimate(value, status="identified", interval=(1.0, 3.0)):
    entry = {
        "unit": "N",
        "description": "a force",
        "value": value,
        "std": 0.1,
        "status": status,
        "interval": interval and list(interval),
    }
    return entry | {"larger_std": 0.1, "robust_std": 0.2}


METRICS = {
    "position_error_percent": 1.0,
    "position_rmse": 2.0,
    "loop_error_percent": None,
    "loop_rmse": 4.0,
    "condition_number": 5.0,
    "force_error_percent": 6.0,
}
SUMMARY = {
    "diagnostics": [
        {
            "code": "at_bound",
            "parameter": "F_C",
            "severity": "warning",
            "numbers": {"bound": 3.0, "names": ["F_C", "M"]},
        },
        {"code": "held_levels", "parameter": "F_C", "severity": "note", "numbers": {}},
        {"code": "white", "parameter": "", "severity": "note", "numbers": {}},
    ],
    "metrics": METRICS,
    "correlation": {"values": [[1.0, 0.5], [0.5, 1.0]], "names": ["M", "F_C"]},
    "parameters": {"M": estimate(2.0), "F_C": estimate(20.0, "at_edge", None)},
    "combinations": {"M + F_C": estimate(22.0)},
    "treatment": {"lag": 3e-3},
    "resampling": None,
}


def summary(**changes):
    return SUMMARY | changes


RESAMPLING = {
    "scatter": {"value": 0.05, "low": 0.04, "high": 0.07},
    "noise": 1.0,
    "unexplained": 2.0,
    "lasting": 3.0,
    "inflation": 4.0,
    "left_in_closed_loop": 5.0,
    "left_in_open_loop": 6.0,
    "half_cycles": 30,
    "resolution": 1e-6,
    "virgin_curve": {"x": [1.0, 2.0], "force": [3.0, 4.0], "low": [5.0, 6.0], "high": [7.0, 8.0]},
    "virgin_curve_from": 1e-7,
}
TRACES = {field.name: np.arange(3.0) for field in fields(Traces)}


def kept(reported, draws=None, bands=None):
    return fit_of(PLANT, FRICTION, reported, TRACES, draws or {}, bands)


NULLS = METRICS | {"condition_number": None, "force_error_percent": None}
ENDLESS = {"M": estimate(2.0), "F_C": estimate(None)}


@pytest.mark.parametrize(
    ("changes", "read", "expected"),
    [
        ({}, lambda fit: (fit.plant, fit.friction, fit.lag), (PLANT, FRICTION, 3e-3)),
        ({}, lambda fit: fit.correlation.tolist(), [[1.0, 0.5], [0.5, 1.0]]),
        ({}, lambda fit: fit.correlation_names, ("M", "F_C")),
        ({}, lambda fit: {name: getattr(fit, name) for name in METRICS}, METRICS),
        (
            {},
            lambda fit: [(item.name, item.value) for item in fit.combinations],
            [("M + F_C", 22.0)],
        ),
        # A null becomes not a number, and the value of a parameter without limit infinite.
        (
            {"metrics": NULLS},
            lambda fit: [fit.condition_number, fit.force_error_percent],
            pytest.approx([math.nan] * 2, nan_ok=True),
        ),
        ({"parameters": ENDLESS}, lambda fit: fit.estimates[1].value, math.inf),
        # An unidentified parameter has the first reason.
        ({}, lambda fit: numbers_of(fit.estimates[0]), ("M", 2.0, 0.1, 0.2, (1.0, 3.0), None)),
        (
            {},
            lambda fit: (
                fit.estimates[1].status,
                fit.estimates[1].interval,
                fit.estimates[1].reason.code,
            ),
            ("at_edge", None, "at_bound"),
        ),
        # Diagnostics keep their numbers and the kind of axis.
        (
            {},
            lambda fit: told_by(fit.diagnostics[0]),
            ("at_bound", "F_C", "warning", "translational"),
        ),
        ({}, lambda fit: dict(fit.diagnostics[0].numbers), {"bound": 3.0, "names": ("F_C", "M")}),
        # Without draws the uncertainty is unknown.
        ({}, lambda fit: fit.resampling, None),
        ({"resampling": RESAMPLING}, lambda fit: fit.resampling, None),
    ],
)
def test_a_fit_has_the_numbers_of_its_summary(changes, read, expected):
    assert read(kept(summary(**changes))) == expected


def numbers_of(item):
    return item.name, item.value, item.std, item.robust_std, item.interval, item.reason


def told_by(item):
    return item.code, item.parameter, item.severity, item.kind


@pytest.mark.parametrize("place", ["draws", "bands"])
def test_uncertainty_has_all_draws_or_those_of_the_model_file(place):
    draws = {"F_C": np.array([19.0, 21.0])}
    reported = {"draws": draws} if place == "draws" else {"bands": {"draws": draws}}
    resampling = kept(summary(resampling=RESAMPLING), **reported).resampling
    bands = resampling.bands
    assert bands.draws["F_C"].tolist() == [19.0, 21.0]
    numbers = (
        bands.scatter,
        bands.noise,
        bands.unexplained,
        bands.lasting,
        bands.inflation,
        bands.left_in_closed_loop,
        bands.left_in_open_loop,
    )
    assert numbers == (0.05, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    assert tuple(resampling.scatter) == (0.05, 0.04, 0.07)
    assert (resampling.half_cycles, resampling.resolution) == (30, 1e-6)
    assert resampling.curve == ((1.0, 3.0, 5.0, 7.0), (2.0, 4.0, 6.0, 8.0))
    assert resampling.curve_from == 1e-7


def test_all_draws_take_precedence_over_those_of_the_model_file():
    both = kept(
        summary(resampling=RESAMPLING),
        {"F_C": np.array([1.0])},
        {"draws": {"F_C": np.array([2.0])}},
    )
    assert both.resampling.bands.draws["F_C"].tolist() == [1.0]


def test_draws_without_a_resampling_are_of_no_use():
    assert kept(summary(), {"F_C": np.array([1.0])}).resampling is None

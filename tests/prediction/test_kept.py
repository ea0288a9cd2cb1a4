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
    entry = {"unit": "N", "description": "a force", "value": value, "std": 0.1, "status": status, "interval": interval and list(interval)}
    return entry | {"larger_std": 0.1, "robust_std": 0.2}


def summary(**changes):
    diagnostics = [
        {"code": "at_bound", "parameter": "F_C", "severity": "warning", "numbers": {"bound": 3.0, "names": ["F_C", "M"]}},
        {"code": "held_levels", "parameter": "F_C", "severity": "note", "numbers": {}},
        {"code": "white", "parameter": "", "severity": "note", "numbers": {}},
    ]
    names = ("position_error_percent", "position_rmse", "loop_error_percent", "loop_rmse", "condition_number", "force_error_percent")
    reported = {
        "diagnostics": diagnostics,
        "metrics": dict(zip(names, (1.0, 2.0, None, 4.0, 5.0, 6.0), strict=True)),
        "correlation": {"values": [[1.0, 0.5], [0.5, 1.0]], "names": ["M", "F_C"]},
        "parameters": {"M": estimate(2.0), "F_C": estimate(20.0, "at_edge", None)},
        "combinations": {"M + F_C": estimate(22.0)},
        "treatment": {"lag": 3e-3},
        "resampling": None,
    }
    return reported | changes


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


def test_a_fit_has_the_numbers_of_its_summary():
    fit = kept(summary())
    assert (fit.plant, fit.friction, fit.lag) == (PLANT, FRICTION, 3e-3)
    assert fit.correlation.tolist() == [[1.0, 0.5], [0.5, 1.0]]
    assert fit.correlation_names == ("M", "F_C")
    assert (fit.position_error_percent, fit.position_rmse, fit.loop_error_percent, fit.loop_rmse) == (1.0, 2.0, None, 4.0)
    assert (fit.condition_number, fit.force_error_percent) == (5.0, 6.0)
    assert [(item.name, item.value) for item in fit.combinations] == [("M + F_C", 22.0)]
    assert fit.resampling is None


def test_a_null_in_a_summary_becomes_not_a_number():
    reported = summary()
    reported["metrics"] |= {"condition_number": None, "force_error_percent": None}
    fit = kept(reported)
    assert math.isnan(fit.condition_number)
    assert math.isnan(fit.force_error_percent)


def test_the_value_of_a_parameter_without_limit_is_infinite():
    reported = summary()
    reported["parameters"]["F_C"]["value"] = None
    assert kept(reported).estimates[1].value == math.inf


def test_an_unidentified_parameter_has_the_first_reason():
    mass, force = kept(summary()).estimates
    assert (mass.name, mass.value, mass.std, mass.robust_std, mass.interval, mass.reason) == ("M", 2.0, 0.1, 0.2, (1.0, 3.0), None)
    assert (force.status, force.interval, force.reason.code) == ("at_edge", None, "at_bound")


def test_diagnostics_keep_their_numbers_and_the_kind_of_axis():
    first, *_ = kept(summary()).diagnostics
    assert (first.code, first.parameter, first.severity, first.kind) == ("at_bound", "F_C", "warning", "translational")
    assert dict(first.numbers) == {"bound": 3.0, "names": ("F_C", "M")}


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
    both = kept(summary(resampling=RESAMPLING), {"F_C": np.array([1.0])}, {"draws": {"F_C": np.array([2.0])}})
    assert both.resampling.bands.draws["F_C"].tolist() == [1.0]


def test_without_draws_the_uncertainty_is_unknown():
    assert kept(summary(resampling=RESAMPLING)).resampling is None
    assert kept(summary(), {"F_C": np.array([1.0])}).resampling is None

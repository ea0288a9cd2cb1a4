"""Simulations, runs and predictions as tables and in a few lines; what has `kind` has units."""

import json

import numpy as np
import pytest
from tests.apps.design.conftest import loop

import bristle as br
from bristle import engine, friction, plants
from bristle.core.experiment import Experiment, Run
from bristle.core.tabular import SIGNALS
from bristle.engine import interpreted
from bristle.simulation import Prediction

pytestmark = pytest.mark.usefixtures("in_plain_python")

T = np.arange(20) * 0.05


def variant(name, duration=0.1, **changes):
    return loop(name=name, run=Run(duration, 1e-3, settle=0.02), **changes)


@pytest.fixture(scope="module")
def simulated():
    with interpreted():
        return br.simulate(
            Experiment("small", "translational", (variant("base"), variant("longer", 0.15)))
        )


def test_each_variant_is_a_table_with_units(simulated):
    item = simulated.variants["base"]
    message = item.to_dict()
    assert set(message["signals"]) == {
        name for name in SIGNALS if isinstance(getattr(item, name, None), np.ndarray)
    }
    assert message["signals"]["measured"] == item.measured.tolist()
    assert message["following_error"]["rms"] == item.following_error.rms
    assert message["units"]["command"] == "N"
    assert json.loads(json.dumps(message)) == message


def test_and_a_data_set_over_variants_and_time(simulated):
    pytest.importorskip("xarray")
    result = simulated.to_xarray()
    assert result.sizes == {"variant": 2, "time": 150}
    short = result["effort"].sel(variant="base")
    assert np.array_equal(short[:100], simulated.variants["base"].effort)
    assert np.all(np.isnan(short[100:]))
    assert result["effort"].attrs["units"] == "N"
    assert result.attrs["name"] == "small"


def test_results_are_shown_on_one_screen(simulated):
    for item in (simulated, *simulated.variants.values()):
        assert 3 <= len(repr(item).splitlines()) <= 30
        assert max(map(len, repr(item).splitlines())) <= 130
        assert item._repr_html_().startswith("<div><strong>")
    lines = repr(simulated).splitlines()
    assert (lines[0], lines[2].split()[0], lines[2].split()[-1]) == (
        "small: 2 variants simulated",
        "base",
        "completed",
    )


@pytest.mark.parametrize(("kind", "unit"), [("translational", "N"), ("rotational", "N*m")])
def test_a_run_knows_the_kind_of_its_axis(kind, unit):
    model, plant = (
        friction.lugre(kind=kind, **friction.lugre.example),
        plants.inertia(kind=kind, M=2.0),
    )
    adaptive = engine.run_adaptive(plant, model, np.full(20, 40.0), 1e-3, tolerance=1e-7)
    trace = engine.run_open_loop(plant, model, np.full(20, 40.0), 1e-3)
    assert (adaptive.kind, adaptive.to_dict()["steps"], trace.kind) == (kind, adaptive.steps, kind)
    assert (trace.to_dict()["units"]["friction"], trace.to_dict()["state"]) == (
        unit,
        {"z": trace.state.z},
    )


@pytest.mark.parametrize(("unit", "effort"), [("m", "N"), ("rad", "N*m")])
def test_a_prediction_has_its_bands_in_its_table(unit, effort):
    metrics = {"force_error_percent": 12.5, "position_error_percent": None, "position_unit": unit}
    parts = {
        "effort": np.cos(T),
        "effort_predicted": np.cos(T) + 0.1,
        "position": np.sin(T),
        "position_predicted": None,
    }
    message = Prediction(
        mode="inverse", time=T, metrics=metrics, half_width=np.full(T.size, 0.2), **parts
    ).to_dict()
    assert list(message["signals"]) == [
        "time",
        "position",
        "effort",
        "effort_predicted",
        "half_width",
    ]
    assert (message["inside_percent"], message["metrics"]["force_error_percent"]) == (100.0, 12.5)
    assert message["units"]["effort_predicted"] == effort

"""What several folders of tests need: an axis with known friction, its log, and what bristle makes of it."""

import gc
import itertools
from dataclasses import dataclass
from numbers import Complex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings, strategies
from markupsafe import Markup

from bristle import controllers, friction, plants
from bristle.core import Axis
from bristle.core.content import Origin
from bristle.core.variable import KINDS, Kind, unit_of
from bristle.engine import interpreted
from bristle.identification import Identification, identify
from bristle.logs.log import Channel, Log
from bristle.prediction import drive_table, predict
from bristle.simulation import Prediction, SimulationResult, simulate
from bristle.simulation.compensation import compensation_experiment


@dataclass(frozen=True)
class Workbench:
    """A self-made axis: the log of its loop, and each result that a report is made from."""

    axis: Axis
    log: Log
    identified: Identification
    table: list[tuple[float, float]]
    looped: SimulationResult
    predicted: Prediction


Approximate = type(pytest.approx(1.0))
tolerance_of_pytest = Approximate.tolerance.fget


def tolerance_of(comparison):
    """Return what `pytest.approx` allows: in SI a square of a micrometre is as small as its absolute tolerance of 1e-12."""
    expected = comparison.expected
    if comparison.abs is None and isinstance(expected, Complex) and expected != 0.0:
        return abs(expected) * (
            comparison.DEFAULT_RELATIVE_TOLERANCE if comparison.rel is None else comparison.rel
        )
    return tolerance_of_pytest(comparison)


Approximate.tolerance = property(tolerance_of)
# A machine that does other work is no fault of what is tested.
settings.register_profile("untimed", deadline=None)
settings.load_profile("untimed")
# Per kind of axis: a stage of 12 kg, and a joint of 4e-4 kg*m^2.
MASS = {"translational": 12.0, "rotational": 4e-4}
FRICTION = {
    "translational": {"F_C": 8.0, "F_S": 10.0, "v_S": 5e-3, "F_v": 30.0},
    "rotational": {"F_C": 0.034, "F_S": 0.04, "v_S": 0.5, "F_v": 3e-3},
}
COUNT = itertools.count()
# Ten thousand tests, what they import and what compiles kernels are many objects, and are looked through in vain.
gc.set_threshold(50_000, 10, 20)
STROKE = {"translational": 0.02, "rotational": 2.0}


def build_workbench(kind: Kind) -> Workbench:
    """Let a stribeck axis follow three sines, record it, and do the main job on the record."""
    dt = 1e-3
    t = dt * np.arange(6000)
    reference = (
        STROKE[kind]
        * (np.sin(3.1 * t) + 0.4 * np.sin(10.7 * t) + 0.1 * np.sin(29.0 * t))
        * np.minimum(t, 1.0)
    )
    plant = plants.inertia(kind=kind, M=MASS[kind])
    truth = friction.stribeck(kind=kind, **FRICTION[kind])
    law = controllers.cascade(kind=kind, k_p=80.0, k_v=250.0 * MASS[kind])
    step = 1e-5 * STROKE[kind]
    recorded = simulate(
        compensation_experiment(plant, truth, truth, law, reference, dt, resolution=step)
    ).variants["as_recorded"]
    length, force = unit_of("length", kind), unit_of("force", kind)
    log = Log(
        time=Channel(recorded.time, "s", "t"),
        position=Channel(recorded.measured, length, "q"),
        effort=Channel(recorded.effort, force, "u"),
        reference=Channel(recorded.reference, length, "r"),
        sample_time=dt,
        segments=(slice(0, recorded.time.size),),
        source=Path("stage.csv"),
        origin=Origin("stage.csv", "0" * 64),
        notes=("made by a simulation",),
        kind=kind,
    )
    axis = Axis(name="stage", kind=kind, resolution=step, controller=law)
    identified = identify(log, "coulomb_viscous,stribeck+asymmetry", axis=axis, draws=0)
    best = identified.best
    looped = simulate(
        compensation_experiment(
            plant, truth, best.friction, law, reference, dt, resolution=step, name="stage"
        )
    )
    return Workbench(
        axis,
        log,
        identified,
        drive_table(best),
        looped,
        predict(best.plant, best.friction, log, axis, "closed-loop"),
    )


def pytest_collection_finish():
    """Let Hypothesis make its table of characters, which costs the first test two seconds; never look again through what stays."""
    strategies.text().validate()
    gc.freeze()


@pytest.fixture(autouse=True)
def nothing_remembered(tmp_path_factory, monkeypatch):
    """Nobody has allowed any code yet, and what is allowed here is forgotten."""
    # `mktemp` would read the whole folder of ten thousand tests for each of them.
    monkeypatch.setenv(
        "BRISTLE_STATE_DIR", str(tmp_path_factory.getbasetemp() / "states" / str(next(COUNT)))
    )


@pytest.fixture
def in_plain_python():
    """Nothing is compiled: for motions of so few steps that the compiler would take longer."""
    with interpreted():
        yield


@pytest.fixture
def undrawn(monkeypatch):
    """Reports have their captions, and no figure is drawn: for tests of what stands beside figures."""
    from bristle.report import page

    def picture(name, draw, alternative, caption, **_):
        return page.Picture(
            f"figure-{name}", Markup('<svg role="img" aria-label="not drawn"></svg>'), caption
        )

    monkeypatch.setattr(page, "picture", picture)


@pytest.fixture(scope="session")
def workbenches() -> dict[Kind, Workbench]:
    """The self-made axis of each kind."""
    return {kind: build_workbench(kind) for kind in KINDS}


@pytest.fixture(params=KINDS)
def workbench(request, workbenches) -> Workbench:
    """The self-made axis, of each kind in turn."""
    return workbenches[request.param]


@pytest.fixture
def stage(workbenches) -> Workbench:
    """The self-made axis that moves along a line."""
    return workbenches["translational"]

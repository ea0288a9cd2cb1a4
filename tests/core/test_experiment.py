"""Experiments as they are described: defaults, ranges, and what does not go together."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bristle import controllers, friction, plants, references, sensors
from bristle.core.errors import InputError
from bristle.core.experiment import Effort, Experiment, Feedforward, Learning, Run, Start, Variant, substeps_for


def variant(**changes):
    parts = {
        "name": "loop",
        "plant": plants.inertia(M=2.0),
        "friction": friction.coulomb(F_C=1.0),
        "controller": controllers.cascade(k_p=80.0, k_v=500.0),
        "sensor": sensors.encoder(resolution=0.0),
        "reference": references.recorded(position=np.zeros(100), sample_time=1e-3),
        "feedforward": Feedforward(),
        "run": Run(0.1, 1e-3),
    }
    return Variant(**parts | changes)


def test_a_run_counts_from_its_first_sample_once_without_lag_or_limit():
    run = Run(2.0, 1e-3)
    assert (run.settle, run.delay, run.current_lag, run.seeds, run.tolerance) == (0.0, 0, 0.0, 1, 0.0)
    assert run.effort_limit == math.inf
    assert run.substeps == 4
    assert Run(2.0, 1e-3, tolerance=1e-9).substeps == 0
    assert Run(2.0, 1e-3, substeps=10_000, seeds=1000, delay=64).seeds == 1000
    feedforward = Feedforward()
    assert (feedforward.mass, feedforward.gain, feedforward.offset, feedforward.asymmetry) == (0.0, 1.0, 0.0, 0.0)
    assert (feedforward.limit, feedforward.rate_limit, feedforward.conditioning) == (math.inf, math.inf, 0.0)
    assert (feedforward.along, feedforward.rest, feedforward.friction) == ("desired", "held", None)
    assert Start(0.5) == Start(0.5, 0.0, 0.0, None)


@pytest.mark.parametrize(
    "wrong",
    [
        *({"seeds": 0}, {"seeds": 1001}, {"substeps": 10_001}, {"delay": 65}, {"delay": -1}, {"settle": -1e-3}, {"tolerance": -1e-9}),
        *({"current_lag": -1e-3}, {"effort_limit": -1.0}, {"duration": 0.0}, {"sample_time": 0.0}, {"duration": 2e4}),
    ],
)
def test_a_run_out_of_range_is_refused_by_key(wrong):
    (name,) = wrong
    with pytest.raises(InputError) as reported:
        Run(**{"duration": 2.0, "sample_time": 1e-3} | wrong)
    assert reported.value.path == name


def test_the_documented_number_of_samples_is_allowed():
    assert Run(1e4, 1e-3).duration == 1e4
    with pytest.raises(InputError, match="up to 10000000 samples"):
        Run(1.001e4, 1e-3)


def test_steps_of_the_integration_are_a_quarter_of_a_millisecond_at_most_and_four_at_least():
    assert [substeps_for(dt) for dt in (1e-4, 1e-3, 1.0001e-3, 2e-3, 2.1e-3)] == [4, 4, 5, 8, 9]
    assert substeps_for(1e-3 * (1.0 + 1e-9)) == 4


def test_a_tolerance_needs_an_open_loop_without_a_drive():
    effort = Effort(np.zeros(100))
    loose = Run(0.1, 1e-3, tolerance=1e-9)
    assert variant(run=loose, effort=effort).run is loose
    with pytest.raises(InputError, match="determines the steps"):
        Run(0.1, 1e-3, tolerance=1e-9, substeps=4)
    for wrong, words in (
        ({"run": loose}, "is only for open loops"),
        ({"run": replace(loose, delay=1), "effort": effort}, "cannot include the drive"),
        ({"run": replace(loose, current_lag=1e-3), "effort": effort}, "cannot include the drive"),
    ):
        with pytest.raises(InputError, match=words):
            variant(**wrong)


def test_the_first_samples_of_a_loop_have_the_disturbances_of_these():
    loop = variant(disturbance=np.arange(100.0), injected=-np.arange(100.0))
    first = loop.first(40)
    assert first.run.duration == pytest.approx(0.04)
    assert (first.disturbance.tolist(), first.injected.tolist()) == (list(range(40)), [-k for k in range(40)])
    assert variant().first(40).disturbance is None


def test_loops_are_equal_if_all_samples_are_equal():
    loop = variant(effort=Effort(np.arange(3.0)), disturbance=np.arange(5.0))
    assert loop.is_like(variant(effort=Effort(np.arange(3.0), "again"), disturbance=np.arange(5.0)))
    assert not loop.is_like(variant(effort=Effort(np.arange(3.0) + 1.0), disturbance=np.arange(5.0)))
    assert not loop.is_like(variant(effort=Effort(np.arange(3.0)), disturbance=np.arange(6.0)))
    assert not loop.is_like(variant(disturbance=np.arange(5.0)))
    assert not variant().is_like(variant(plant=plants.inertia(M=3.0)))
    assert not variant().is_like(variant(sensor_at="motor"))


def test_names_of_variants_are_unique():
    loop = variant()
    assert Experiment("e", "translational", loop).variants == (loop,)
    with pytest.raises(InputError, match="has two variants with the same name"):
        Experiment("e", "translational", (loop, variant()))
    assert len(Experiment("e", "translational", (loop, variant(name="other"))).variants) == 2


def test_learning_counts_its_trials():
    assert Learning(1, 2.0, 0.0, 20.0).trials == 1
    for wrong in ({"trials": 0}, {"trials": 1001}, {"k_e": -1.0}, {"k_d": -1.0}, {"cutoff": 0.0}):
        with pytest.raises(InputError):
            Learning(**{"trials": 1, "k_e": 2.0, "k_d": 0.0, "cutoff": 20.0} | wrong)


def run_of(**given):
    return Run(**{"duration": 1.0, "sample_time": 1e-3} | given)


def learning_of(**given):
    return Learning(**{"trials": 1, "k_e": 1.0, "k_d": 0.0, "cutoff": 20.0} | given)


@pytest.mark.parametrize(
    ("made", "name", "ends", "beyond"),
    [
        (Feedforward, "asymmetry", (-1.0, 1.0), (-1.001, 1.001)),
        *((Feedforward, name, (0.0,), (-1e-9,)) for name in ("mass", "limit", "rate_limit", "conditioning")),
        *((run_of, name, (0.0,), (-1e-9,)) for name in ("settle", "effort_limit", "current_lag")),
        (run_of, "delay", (0, 64), (-1, 65)),
        (run_of, "seeds", (1, 1000), (0, 1001)),
        (run_of, "substeps", (1, 10_000), (-1, 10_001)),
        (learning_of, "cutoff", (1e-3,), (0.9e-3,)),
        (learning_of, "trials", (1, 1000), (0, 1001)),
        *((learning_of, name, (0.0,), (-1e-9,)) for name in ("k_e", "k_d")),
    ],
)
def test_a_number_of_a_loop_is_taken_at_its_ends_and_refused_beyond(made, name, ends, beyond):
    assert [getattr(made(**{name: value}), name) for value in ends] == list(ends)
    for value in beyond:
        with pytest.raises(InputError, match=name):
            made(**{name: value})


def test_a_tolerance_needs_a_plant_with_a_single_mass():
    screw = plants.ball_screw(J=1e-4, M=20.0, lead=5e-3, k=1e8, kind="rotational")
    with pytest.raises(InputError, match=r"run\.tolerance: needs a plant with one mass, but ball_screw"):
        variant(plant=screw, run=Run(0.1, 1e-3, tolerance=1e-9), effort=Effort(np.zeros(100)))
    assert variant(plant=screw).plant is screw

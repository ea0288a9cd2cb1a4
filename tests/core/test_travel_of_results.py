"""What is read, described and found travels, too: axes, logs, experiments and every kind of result."""

import copy
import pickle
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from tests.apps.design.conftest import loop
from tests.core.elsewhere import there_and_back
from tests.core.same_bits import bits_of
from tests.golden.simulated import MASING, recorded, to_and_fro
from tests.identification.known_logs import sliding_log, slow_log
from tests.prediction.excitation.axes import STAGE

import bristle as br
from bristle import controllers, friction, hysteresis, plants, sensors
from bristle.contract import example_of
from bristle.core.experiment import Experiment, Learning, Run
from bristle.engine import interpreted, run_adaptive, run_batch, run_closed_loop, run_open_loop
from bristle.identification.hysteresis import predict_operator

ROOT = Path(__file__).parents[2]
PAPER = ROOT / "src" / "bristle" / "apps" / "paper" / "experiments"
AXES = [file for file in ROOT.glob("examples/*/axis*.toml") if "magnetic" not in file.read_text()]
ELEMENTS = example_of(friction.maxwell_slip)


def experiment(**changes):
    """A tenth of a second of a small loop that errs, in two runs."""
    run = Run(0.1, 1e-3, delay=1, settle=0.02, seeds=2)
    return Experiment("small", "translational", (loop(run=run, **changes),))


def operators():
    curves = recorded(
        MASING,
        to_and_fro(np.random.default_rng(11), turns=50, samples=800),
        np.random.default_rng(1),
    )
    result = br.identify_operator(curves, cells=12)
    return curves, result, predict_operator(result.best.operator, curves, result.best.offset)


def runs():
    lugre, plant, effort = (
        example_of(friction.lugre),
        plants.inertia(M=2.0),
        40.0 * np.sin(np.arange(50.0)),
    )
    desired = np.zeros((4, 50))
    sensor, law = sensors.encoder(resolution=1e-6), controllers.cascade(k_p=80.0, k_v=400.0)
    return [
        run_open_loop(plant, lugre, effort, 1e-3),
        run_adaptive(plant, lugre, effort, 1e-3, tolerance=1e-9),
        run_batch(plant, [lugre, lugre], effort, 1e-3),
        run_closed_loop(plant, ELEMENTS, law, sensor, desired, 1e-3),
    ]


def predictions(stage):
    stage = stage()
    best, again = stage.identified.best, stage.identified.fits[-1]
    modes = ("inverse", "open-loop", "closed-loop")
    return [
        *(br.predict(best.plant, best.friction, stage.log, stage.axis, mode) for mode in modes),
        br.predict(again.plant, again.friction, stage.log, stage.axis, "inverse"),
    ]


RESULTS = {
    "log": lambda stage: sliding_log(),
    "simulation": lambda stage: stage().looped,
    "simulation of several runs": lambda stage: br.simulate(experiment()),
    "learned": lambda stage: br.simulate(experiment(learning=Learning(2, 1e4, 0.0, 50.0))),
    "identification": lambda stage: stage().identified,
    "with intervals": lambda stage: br.identify(
        stage().log, "stribeck+asymmetry", axis=stage().axis, draws=20
    ),
    "of elements": lambda stage: br.identify(
        slow_log(ELEMENTS, duration=6.0), "maxwell_slip", draws=20, blocks=2
    ),
    "predictions": predictions,
    "operators": lambda stage: operators(),
    "certificates": lambda stage: [
        br.check(item) for item in (example_of(friction.lugre), hysteresis.stop(r=1.0))
    ],
    "design": lambda stage: br.design(experiment()),
    "motion to run": lambda stage: br.excite(
        STAGE, duration="15 s", purposes="presliding", draws=0
    ),
    "runs": lambda stage: runs(),
}


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("result", RESULTS.values(), ids=RESULTS)
def test_results_travel_to_the_bit(result, request):
    actual = result(partial(request.getfixturevalue, "stage"))
    expected = bits_of(actual)
    for protocol in (2, pickle.HIGHEST_PROTOCOL):
        assert bits_of(pickle.loads(pickle.dumps(actual, protocol))) == expected
    assert bits_of(copy.deepcopy(actual)) == expected
    assert bits_of(there_and_back(actual)) == expected


def test_objects_from_files_can_be_pickled():
    experiments = [file for pattern in ("set_[ab].toml", "low*") for file in PAPER.glob(pattern)]
    experiments += (ROOT / "benchmarks" / "experiments").glob("*.toml")
    models = [*PAPER.glob("*_rig.toml"), *PAPER.glob("*_identified.toml")]
    fixed = [
        *(br.read_experiment(file) for file in experiments),
        *(br.read_model(file) for file in models),
        *(br.read_axis(file) for file in AXES),
    ]
    assert len(fixed) > 12
    assert bits_of(pickle.loads(pickle.dumps(fixed))) == bits_of(fixed)
    assert bits_of(copy.deepcopy(fixed)) == bits_of(fixed)


def test_a_difference_of_a_single_bit_is_detected():
    with interpreted():
        result = run_open_loop(
            plants.inertia(M=2.0), example_of(friction.lugre), np.full(20, 40.0), 1e-3
        )
    other = copy.deepcopy(result)
    assert bits_of(other) == bits_of(result)
    other.position[3] = np.nextafter(other.position[3], 1.0)
    assert bits_of(other) != bits_of(result)
    assert bits_of(friction.coulomb(F_C=0.0)) != bits_of(friction.coulomb(F_C=-0.0))

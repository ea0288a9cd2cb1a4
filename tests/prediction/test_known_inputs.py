"""Known inputs join the output of a controller before the limit of the drive, which bounds their sum."""

from dataclasses import replace

import numpy as np
import pytest

from bristle.apps.design.analysis import _axis
from bristle.apps.targets.page.loop import _signals
from bristle.core import InputError
from bristle.core.experiment import Experiment
from bristle.engine import interpreted
from bristle.exports.effect import _at_rest
from bristle.files import read_experiment
from bristle.models.controllers import cascade
from bristle.models.friction import coulomb_viscous
from bristle.models.plants import inertia
from bristle.simulation import compensation_experiment, simulate

M, F_V, F_C, K_P, K_V, DT = 95.0, 203.0, 20.4, 160.18, 243.45, 1e-3
EXPERIMENT = """
schema = 1
kind = "translational"
plant = { model = "inertia", M = 3.0 }
friction = { model = "coulomb", F_C = 2.0 }
controller = { model = "cascade", k_p = 1.0, k_v = 1.0 }
reference = { model = "sine", amplitude = 1e-3, frequency = 1.0 }
run = { duration = 3e-3, sample_time = 1e-3 }
injected = { file = "loop.csv" }
compare = { base = {} }
"""


@pytest.fixture
def pushed():
    """A loop that is pushed by a force and by a known input."""
    model, x = coulomb_viscous(F_C=F_C, F_v=F_V), 0.01 * np.sin(np.arange(400) * 0.01)
    return compensation_experiment(
        inertia(M=M),
        model,
        model,
        cascade(k_p=K_P, k_v=K_V),
        x,
        DT,
        disturbance=np.linspace(-1.0, 2.0, 400),
        injected=np.linspace(0.5, 0.75, 400),
    ).variants[0]


@interpreted()
def test_the_first_samples_of_a_loop_have_their_known_inputs(pushed):
    first = pushed.first(100)
    assert first.run.duration == pytest.approx(100 * DT)
    np.testing.assert_array_equal(first.disturbance, pushed.disturbance[:100])
    np.testing.assert_array_equal(first.injected, pushed.injected[:100])
    outcome = simulate(Experiment("first", "translational", (first,))).variants[first.name]
    assert outcome.measured.size == 100


def test_moves_and_circles_of_other_lengths_have_no_known_inputs_of_the_log(pushed):
    assert _at_rest(pushed).injected is None
    assert all(
        variant.injected is None for variant in (_axis(pushed, 0.01, 0.1, axis) for axis in "xy")
    )


def test_a_page_applies_known_inputs_like_a_force_along_the_motion(pushed):
    alike = replace(pushed, disturbance=pushed.disturbance - pushed.injected, injected=None)
    x = 0.01 * np.sin(np.arange(400) * 0.01)
    assert _signals(pushed, x, 400) == _signals(alike, x, 400)
    assert _signals(pushed, x, 400) != _signals(replace(pushed, injected=None), x, 400)


def test_an_experiment_whose_file_lacks_named_known_inputs_is_refused(tmp_path):
    (tmp_path / "experiment.toml").write_text(EXPERIMENT)
    head, rows = (
        "time [s],reference [m],unexplained [N]",
        "".join(f"\n{DT * k:g},0,0" for k in range(5)),
    )
    (tmp_path / "loop.csv").write_text(head + rows)
    with pytest.raises(InputError, match=r"injected\.file: has no column of known inputs"):
        read_experiment(tmp_path / "experiment.toml")
    (tmp_path / "loop.csv").write_text(
        head + ",injected [N]" + rows.replace(",0\n", ",0,2\n") + ",2"
    )
    assert read_experiment(tmp_path / "experiment.toml").variants[0].injected.tolist() == [2.0] * 3

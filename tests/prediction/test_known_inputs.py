"""Known inputs join the output of a controller before the limit of the drive, which bounds their sum."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.cli.conftest import bristle  # noqa: F401

from bristle.controllers import cascade
from bristle.core.experiment import Experiment
from bristle.exports.effect import _at_rest
from bristle.exports.page.loop import _signals
from bristle.friction import coulomb_viscous
from bristle.loop.design import _axis
from bristle.plants import inertia
from bristle.simulation import compensation_experiment, simulate

M, F_V, F_C, FORCE_CONSTANT, LIMIT, GAIN = 95.0, 203.0, 20.4, 35.15, 10.0, 1.0139
K_P, K_V, DT = 160.18, 243.45, 1e-3

AXIS = f"""
schema = 1
kind = "translational"
columns.time = {{ column = "t", unit = "s" }}
columns.position = {{ column = "x", unit = "m" }}
columns.reference = {{ column = "r", unit = "m" }}
columns.effort = {{ column = "sum", unit = "V" }}
effort = {{ force_constant = "{FORCE_CONSTANT} N/V", limit = "{LIMIT} V" }}
injected = [{{ column = "pulses", gain = "{GAIN} V" }}]
encoder.resolution = "50 nm"
timing.delay = 0
plant.presliding = "2 um"
controller = {{ model = "cascade", k_p = "{K_P} 1/s", k_v = "{K_V} V*s/m", averaging = 2 }}
"""
IDENTIFY = ("identify", "log.csv", "--axis", "axis.toml", "--model", "coulomb_viscous", "--draws", "0", "--out", "fit")


def axis_under_pulses(count=8000, parts=20):
    """Record an axis whose controller asks for more than the drive gives, integrated by hand."""
    t = DT * np.arange(count)
    reference = 0.11 * (1.0 - np.cos(0.5 * np.pi * t)) + 0.018 * np.sin(2.6 * np.pi * t)
    pulses = np.random.default_rng(11).choice([-5.0, 5.0], count // 100)[np.arange(count) // 100]
    pulses[:500] = 0.0
    rows, x, v, before = [], 0.0, 0.0, (0.0, 0.0)
    for k in range(count):
        measured = round(x / 50e-9) * 50e-9
        speed = 0.5 * (measured - before[1]) / DT
        law = K_V * (K_P * (reference[k] - measured) - speed)
        total = min(max(law + GAIN * pulses[k], -LIMIT), LIMIT)
        rows.append((t[k], measured, reference[k], total, pulses[k], law))
        before = (measured, before[0])
        for _ in range(parts):
            v += DT / parts * (FORCE_CONSTANT * total - F_C * np.tanh(v / 2e-5) - F_V * v) / M
            x += DT / parts * v
    return np.array(rows)


@pytest.fixture(scope="module")
def recorded():
    return axis_under_pulses()


@pytest.fixture
def place(tmp_path, monkeypatch, recorded):
    monkeypatch.chdir(tmp_path)
    Path("axis.toml").write_text(AXIS)
    np.savetxt("log.csv", recorded[:, :5], delimiter=",", header="t,x,r,sum,pulses", comments="", fmt="%.9g")
    return tmp_path


@pytest.mark.slow
def test_a_law_that_commands_more_than_the_limit_is_identified_and_predicted(bristle, place, recorded):  # noqa: F811
    assert np.abs(recorded[:, 5]).max() > 1.09 * LIMIT
    fit = bristle(*IDENTIFY, "--json")
    assert fit.code == 0, fit.err
    result = {name: fit.data["parameters"][name]["value"] for name in ("M", "F_v", "F_C")}
    assert result == pytest.approx({"M": M, "F_v": F_V, "F_C": F_C}, rel=0.03)
    following = np.ptp((recorded[:, 2] - recorded[:, 1])[500:])
    loop = bristle("run", "fit/experiment.toml", "--json", "--out", "loop")
    assert loop.code == 0, loop.err
    simulated = loop.data["variants"]["as_recorded"]["following_error"]["peak_to_peak"]
    assert simulated == pytest.approx(following, rel=0.02)
    predicted = bristle("predict", "fit/model.toml", "log.csv", "--axis", "axis.toml", "--mode", "closed-loop", "--json")
    assert predicted.code == 0, predicted.err
    assert predicted.data["metrics"]["position_error_percent"] < 0.1


@pytest.mark.slow
def test_an_experiment_whose_file_lacks_named_known_inputs_is_refused(bristle, place):  # noqa: F811
    assert bristle(*IDENTIFY).code == 0
    lines = Path("fit/loop.csv").read_text().splitlines()
    Path("fit/loop.csv").write_text("\n".join(line.rpartition(",")[0] for line in lines))
    ended = bristle("run", "fit/experiment.toml")
    assert ended.code == 2
    assert "injected.file: has no column of known inputs" in ended.err


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


def test_the_first_samples_of_a_loop_have_their_known_inputs(pushed):
    first = pushed.first(100)
    assert first.run.duration == pytest.approx(100 * DT)
    np.testing.assert_array_equal(first.disturbance, pushed.disturbance[:100])
    np.testing.assert_array_equal(first.injected, pushed.injected[:100])
    outcome = simulate(Experiment("first", "translational", (first,))).variants[first.name]
    assert outcome.measured.size == 100


def test_moves_and_circles_of_other_lengths_have_no_known_inputs_of_the_log(pushed):
    assert _at_rest(pushed).injected is None
    assert all(variant.injected is None for variant in (_axis(pushed, 0.01, 0.1, axis) for axis in "xy"))


def test_a_page_applies_known_inputs_like_a_force_along_the_motion(pushed):
    alike = replace(pushed, disturbance=pushed.disturbance - pushed.injected, injected=None)
    x = 0.01 * np.sin(np.arange(400) * 0.01)
    assert _signals(pushed, x, 400) == _signals(alike, x, 400)
    assert _signals(pushed, x, 400) != _signals(replace(pushed, injected=None), x, 400)

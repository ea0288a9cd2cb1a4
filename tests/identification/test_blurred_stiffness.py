"""A stiffness that a coarse encoder blurs is asked about far away: is an axis ten times as stiff seen as soft, too?"""

from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.strangers import make
from tests.identification.known_logs import STATED, log_of, slow_log

from bristle.core import Axis
from bristle.friction import find
from bristle.identification import identify
from bristle.identification.settings import DEFAULT
from bristle.identification.uncertainty import NEARLY, _blurred
from bristle.report.messages import warnings_of

AXIS = Axis(kind="rotational", seeks_delay=False, cutoff=100.0, method="inverse_dynamics")


@pytest.mark.slow
def test_a_stiff_axis_that_the_encoder_shows_as_soft_is_not_identified():
    # Friction builds up over half a step of the encoder; along what the encoder shows a fit finds nine.
    truth, record = make(40009, "lugre", "multisine")
    assert truth.friction.F_C[1] / truth.friction.sigma_0 < 0.6 * truth.encoder.resolution
    motion = type("Recorded", (), {"time": np.asarray(record.t), "position": np.asarray(record.position)})
    effort = record.effort * truth.recording.force_per_effort
    fit = identify(log_of(motion, effort, kind="rotational"), "lugre", axis=AXIS, blocks=0, draws=20).best
    stiffness = fit.parameters["sigma_0"]
    assert stiffness.interval[1] < 0.1 * truth.friction.sigma_0
    assert (stiffness.status, stiffness.reason.code) == ("unidentifiable", "as_soft")
    message = stiffness.reason.numbers
    assert message["times"] == pytest.approx(10.0, rel=0.05)
    assert 1 <= message["alike"] < message["fits"]
    assert f"in {message['alike']} of {message['fits']} logs drawn of the same motion" in " ".join(warnings_of(fit))
    assert fit.parameters["sigma_1"].reason.code == "as_soft"


@pytest.mark.slow
@pytest.mark.parametrize(("times", "status"), [(10.0, "identified"), (1.03, "unidentifiable"), (1.01, "identified")])
def test_one_of_eight_steps_is_told_unless_a_stiffer_axis_is_seen_as_it(monkeypatch, times, status):
    # What is no stiffer than the end of the interval asks nothing that the interval does not say.
    monkeypatch.setattr("bristle.identification.uncertainty.STIFFER", times)
    model = find("lugre")(F_C=8.0, F_S=11.0, v_S=2e-3, sigma_0=5e5, sigma_1=600.0, sigma_2=30.0)
    fit = identify(slow_log(model, step=2e-6, duration=10.0), "lugre", axis=STATED, blocks=0, draws=20).best
    assert fit.parameters["sigma_0"].status == status


def asked_about(status="identified", *, counts, noise=1.0, simulates=False, lost=()):
    """What is asked about, of pre-sliding over so many times the shortest that is told."""
    least = DEFAULT.zone_counts * 1e-7
    dataset = SimpleNamespace(resolution=1e-7, noise=noise * least / DEFAULT.zone_noise)
    # A level that is held says how far pre-sliding goes as well.
    parameters = SimpleNamespace(variables=find("lugre").variables, complete=lambda free: {"F_C": 8.0} | free)
    values = {"sigma_0": 8.0 / (counts * least)}
    solution = SimpleNamespace(values=values, space=SimpleNamespace(names=tuple(values), linear=False))
    estimation = SimpleNamespace(simulates=simulates, resampled=(SimpleNamespace(parameters=parameters, dataset=dataset), solution))
    estimates = [SimpleNamespace(name=name, status=status) for name in values]
    return _blurred(estimates, lost, estimation, DEFAULT)


def test_only_what_seems_identified_over_a_few_steps_along_a_measured_motion_is_asked_about():
    short, long = 0.99 * NEARLY, 1.01 * NEARLY
    assert asked_about(counts=short) == ["sigma_0"]
    assert asked_about(counts=long) == []
    assert asked_about(counts=long, noise=1.1) == ["sigma_0"]
    assert asked_about("at_edge", counts=short) == []
    assert asked_about(counts=short, lost=("sigma_0",)) == []
    assert asked_about(counts=short, simulates=True) == []

"""The compensator of the virtual rig, from a minute of the motion that `bristle excite` designs, and nothing else."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from bristle.core import Axis
from bristle.excitation import excite
from bristle.files.experiment import read_experiment
from bristle.identification.compensator import identify_compensator
from bristle.logs.legs import graininess
from bristle.logs.passages import passages_along
from bristle.references import recorded
from bristle.simulation import simulate

FOLDER = files("bristle.paper") / "experiments"
AXIS = Axis(
    presliding=7e-6,
    resolution=0.125e-6,
    sample_time=0.5e-3,
    mass=631.65,
    effort_limit=500.0,
    velocity_limit=0.1,
    acceleration_limit=1.0,
    stroke=(-0.05, 0.05),
)


@pytest.fixture(scope="module")
def recording():
    """Encoder and effort command of the rig along the loops before sliding, with the motion and its delay."""
    motion = excite(AXIS, duration="60 s", rehearsed=False).motion
    last = max(k for k, one in enumerate(motion.pieces) if one.purpose == "presliding")
    span = motion.time < motion.begins[last] + motion.pieces[last].duration
    log = read_experiment(FOLDER / "set_a_log.toml")
    variant = log.variants[0]
    run = replace(variant.run, duration=motion.sample_time * int(span.sum()))
    assert run.sample_time == motion.sample_time
    reference = recorded(position=motion.position[span], sample_time=motion.sample_time)
    result = simulate(replace(log, variants=(replace(variant, reference=reference, run=run),))).variants[variant.name]
    command = np.append(result.effort[run.delay :], np.full(run.delay, result.effort[-1]))
    delay = (run.delay + 0.5) * run.sample_time + run.current_lag
    return motion, result.measured, command, delay


@pytest.fixture(scope="module")
def compensator(recording):
    motion, position, effort, delay = recording
    return identify_compensator(position, effort, motion.sample_time, mass=AXIS.mass, delay=delay)


def test_the_loops_are_found_in_a_log_with_noise_of_a_loop_that_follows_loosely(recording):
    motion, position, effort, _ = recording
    found = passages_along(motion.time[: position.size], position, effort, graininess(position, AXIS.resolution))
    pairs = [k for k, one in enumerate(motion.pieces) if one.name == "triangles"]
    begin, end = motion.begins[pairs[2]], motion.begins[pairs[-1]] + motion.pieces[pairs[-1]].duration
    inside = sum(max(min(one.end, end) - max(one.begin, begin), 0.0) for one in found if one.kind == "loops")
    assert inside > 0.85 * (end - begin)
    assert not [one for one in found if one.kind == "constant_velocity" and begin < one.begin < one.end < end]


def following_error(experiment, variant, compensator, **run):
    """Following error peak to peak [µm] with the compensator fed forward."""
    whole = read_experiment(FOLDER / f"{experiment}.toml")
    one = next(each for each in whole.variants if each.name == variant)
    one = replace(
        one, feedforward=replace(one.feedforward, friction=compensator), run=replace(one.run, **run)
    )  # fmt: skip
    return 1e6 * simulate(replace(whole, variants=(one,))).variants[variant].following_error.peak_to_peak


def test_with_the_law_of_the_paper(compensator):
    assert following_error("set_a", "identified", compensator, seeds=3) <= 0.45


@pytest.mark.parametrize(("frequency", "most"), [(1, 0.40), (2, 0.40), (4, 0.42)])
def test_with_an_observer_at_faster_references(compensator, frequency, most):
    assert following_error("faster_a", f"observer_feedforward_{frequency}hz", compensator) <= most

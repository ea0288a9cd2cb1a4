"""Controllers and compensators past the paper: a cheap part of ``python -m benchmarks.compensation``."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
from benchmarks.compensation import file_of

from bristle.files import read_experiment, read_model
from bristle.paper.rig import SETS, compensator_from_log
from bristle.simulation import simulate

pytestmark = pytest.mark.slow

FOLDER = files("bristle.paper") / "experiments"


def some(name, *variants, seeds=2, **run):
    whole = read_experiment(file_of(name))
    chosen = tuple(
        replace(whole_one, run=replace(whole_one.run, seeds=seeds, **run)) for whole_one in whole.variants if whole_one.name in variants
    )
    assert len(chosen) == len(variants)
    return simulate(replace(whole, variants=chosen)).variants


def peaks(results):
    return {name: 1e6 * item.following_error.peak_to_peak for name, item in results.items()}


@pytest.mark.parametrize(
    ("name", "seeds", "errors", "tolerance"),
    [
        ("past_a", 2, {"mismatched_measured": 0.70, "fitted": 0.48, "pd": 1.50, "observer": 0.37, "super_twisting": 0.65}, 0.12),
        ("past_b", 2, {"fitted_measured": 0.73, "pd_mismatched": 0.72, "observer_mismatched": 0.65}, 0.12),
        # At low gain friction along the measured motion is positive feedback.
        ("low_gain", 2, {"desired": 6.8, "measured": 14.3}, 0.12),
        (
            "baselines",
            1,
            {"gms_feedforward": 0.84, "lugre_observer": 0.88, "adaptive_hysteresis": 0.69, "observer_and_feedforward": 0.42},
            0.16,
        ),
    ],
)
def test_errors_of_improved_loops(name, seeds, errors, tolerance):
    assert peaks(some(name, *errors, seeds=seeds)) == pytest.approx(errors, rel=tolerance)


def test_five_trials_learn_only_the_repeated_error():
    (learned,) = some("past_a", "learning", seeds=1).values()
    trials = 1e6 * np.array(learned.trials)
    assert trials.size == 5
    assert trials[0] == pytest.approx(1.39, rel=0.12)
    assert trials[-1] == pytest.approx(0.38, rel=0.12)
    assert learned.following_error.peak_to_peak == learned.trials[-1]


def test_a_faster_reference_raises_the_value_of_the_model_with_an_observer():
    names = ("none", "observer", "observer_feedforward")
    result = peaks(some("faster_a", *(f"{name}_{f}hz" for f in (1, 4) for name in names)))
    assert result["observer_1hz"] == pytest.approx(0.49, rel=0.12)
    assert result["observer_4hz"] == pytest.approx(0.91, rel=0.12)
    assert result["observer_feedforward_1hz"] <= 0.40
    assert result["observer_feedforward_4hz"] <= 0.45
    for frequency in (1, 4):
        assert result[f"observer_feedforward_{frequency}hz"] <= 0.30 * result[f"none_{frequency}hz"]


def test_refining_the_step_of_the_plant_changes_little():
    coarse = peaks(some("set_a", "none", "paper", seeds=3))
    fine = peaks(some("set_a", "none", "paper", seeds=3, substeps=100))
    assert fine == pytest.approx(coarse, rel=0.05)


@pytest.mark.parametrize("name", sorted(SETS))
def test_the_files_contain_the_identified_model_of_the_rig(name):
    stored = read_model(FOLDER / f"{name}_identified.toml").friction
    again = compensator_from_log(FOLDER / f"{name}_log.toml")
    travel = 6.8e-6 * np.linspace(0.0, 1.0, 50)
    force, force_again = (_virgin_force(item, travel) for item in (stored, again))
    # A quantised loop is chaotic in its last digits: another processor finds another record of the same contact.
    assert force_again == pytest.approx(force, abs=0.02 * np.max(force))


def _virgin_force(model, travel):
    v = model.values
    reach = v["nu_i"] * v["F_C"] / v["k_i"]
    return np.minimum(travel[:, None], reach) @ v["k_i"] + v["offset"]


def test_learned_friction_is_near_the_identified_from_the_first_period():
    from benchmarks.baselines import learning_time

    result = some("baselines", "adaptive_hysteresis", "maxwell_slip_feedforward", seeds=1, settle=0.0)
    start, by_period = learning_time(result)
    assert start == 0.0
    assert by_period[0, 0] > 1.5 * by_period[0, -2]

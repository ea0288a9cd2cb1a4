"""Sets A and B: the numbers of the paper, through the experiment files, and past them."""

import re
from dataclasses import replace
from importlib.resources import files

import pytest

from bristle.files.experiment import read_experiment
from bristle.paper import write_experiments
from bristle.simulation import on_another_rig, simulate

FOLDER = files("bristle.paper") / "experiments"


@pytest.fixture(scope="module")
def set_a(simulated):
    return simulated("set_a.toml").variants


@pytest.fixture(scope="module")
def set_b(simulated):
    return simulated("set_b.toml").variants


def um(number):
    return 1e6 * number


def test_set_a_has_the_errors_of_the_paper(set_a):
    none, paper = set_a["none"], set_a["paper"]
    assert um(none.following_error.peak_to_peak) == pytest.approx(1.45, abs=0.05)
    assert um(paper.following_error.peak_to_peak) == pytest.approx(0.69, abs=0.05)
    reduction = 1.0 - paper.following_error.peak_to_peak / none.following_error.peak_to_peak
    assert 0.50 <= reduction <= 0.55
    assert um(none.true_error.peak_to_peak) == pytest.approx(1.35, abs=0.05)
    assert um(paper.true_error.peak_to_peak) == pytest.approx(0.60, abs=0.05)


def test_set_a_has_the_distribution_of_the_paper(set_a):
    none, paper = set_a["none"].following_error, set_a["paper"].following_error
    assert (um(none.mean), um(paper.mean)) == pytest.approx((0.22, 0.155), abs=0.03)
    assert (um(none.std), um(paper.std)) == pytest.approx((0.395, 0.138), abs=0.03)


@pytest.mark.slow
def test_set_b_reaches_them_from_another_cause(set_b):
    assert um(set_b["none"].following_error.peak_to_peak) == pytest.approx(1.52, abs=0.06)
    assert um(set_b["paper"].following_error.peak_to_peak) == pytest.approx(0.76, abs=0.06)


def test_a_compensator_from_encoder_and_effort_goes_past_the_paper(set_a):
    before = set_a["none"].following_error.peak_to_peak
    assert um(set_a["identified"].following_error.peak_to_peak) <= 0.45
    best = set_a["observer_feedforward"].following_error.peak_to_peak
    assert um(best) <= 0.40
    assert best <= 0.30 * before


@pytest.mark.parametrize("variant", ["paper", "identified", "observer", "observer_feedforward"])
def test_compensation_costs_less_than_five_percent_of_effort(set_a, variant):
    assert 1.0 < set_a[variant].effort_rms / set_a["none"].effort_rms < 1.05


def test_the_numbers_are_means_over_runs_with_their_spread(set_a):
    message = set_a["none"].as_dict()
    assert message["runs"] in (2, 6)
    error = message["following_error"]
    assert 0.0 < error["peak_to_peak_spread"] < 0.1 * error["peak_to_peak"]
    assert message["effort"]["rms_spread"] > 0.0


def test_set_c_the_faster_the_motion_the_more_the_model_is_worth():
    whole = read_experiment(FOLDER / "set_c_faster.toml")
    observed = (replace(each, run=replace(each.run, seeds=1)) for each in whole.variants if each.name.startswith("observer"))
    peak = {name: item.following_error.peak_to_peak for name, item in simulate(replace(whole, variants=tuple(observed))).variants.items()}
    for speed in ("1hz", "2hz", "4hz"):
        assert peak[f"observer_feedforward_{speed}"] <= 0.5 * peak[f"observer_{speed}"]
    gains = [peak[f"observer_{speed}"] / peak[f"observer_feedforward_{speed}"] for speed in ("1hz", "2hz", "4hz")]
    assert gains == sorted(gains)


def test_a_compensator_knows_the_rig_that_it_was_identified_on(tmp_path):
    folder = tmp_path / "mine"
    write_experiments(folder)
    assert on_another_rig(read_experiment(folder / "set_c.toml")) == {}
    rig = folder / "set_a_rig.toml"
    rig.write_text(re.sub(r"seed = 1\b", "seed = 2", rig.read_text(encoding="utf-8")), encoding="utf-8")
    assert on_another_rig(read_experiment(folder / "set_c.toml")) == {}  # the same rig, on another day
    rig.write_text(re.sub(r"scatter = 0.05", "scatter = 0.08", rig.read_text(encoding="utf-8")), encoding="utf-8")
    assert sorted(on_another_rig(read_experiment(folder / "set_c.toml"))) == ["identified", "observer_feedforward"]

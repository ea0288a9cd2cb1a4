"""Sets A and B: the numbers of the paper, through the experiment files, and past them."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from benchmarks.compensation import file_of
from scipy.optimize import brentq
from scipy.signal import cont2discrete
from tests.docs.conftest import ROOT

from bristle.apps.design import assess, error_budget
from bristle.apps.paper import EXPERIMENTS, tracking, write_experiments
from bristle.apps.paper.rig import SETS, compensator_from_log
from bristle.files import read_experiment, read_model
from bristle.simulation import on_another_rig, simulate


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


@pytest.mark.slow
def test_set_c_the_faster_the_motion_the_more_the_model_is_worth():
    whole = read_experiment(EXPERIMENTS / "set_c_faster.toml")
    observed = (
        replace(each, run=replace(each.run, seeds=1))
        for each in whole.variants
        if each.name.startswith("observer")
    )
    peak = {
        name: item.following_error.peak_to_peak
        for name, item in simulate(replace(whole, variants=tuple(observed))).variants.items()
    }
    for speed in ("1hz", "2hz", "4hz"):
        assert peak[f"observer_feedforward_{speed}"] <= 0.5 * peak[f"observer_{speed}"]
    gains = [
        peak[f"observer_{speed}"] / peak[f"observer_feedforward_{speed}"]
        for speed in ("1hz", "2hz", "4hz")
    ]
    assert gains == sorted(gains)


def test_a_compensator_knows_the_rig_that_it_was_identified_on(tmp_path):
    folder = tmp_path / "mine"
    write_experiments(folder)
    assert on_another_rig(read_experiment(folder / "set_c.toml")) == {}
    rig = folder / "set_a_rig.toml"
    rig.write_text(
        re.sub(r"seed = 1\b", "seed = 2", rig.read_text(encoding="utf-8")), encoding="utf-8"
    )
    # The same rig, on another day.
    assert on_another_rig(read_experiment(folder / "set_c.toml")) == {}
    rig.write_text(
        re.sub(r"scatter = 0.05", "scatter = 0.08", rig.read_text(encoding="utf-8")),
        encoding="utf-8",
    )
    assert sorted(on_another_rig(read_experiment(folder / "set_c.toml"))) == [
        "identified",
        "observer_feedforward",
    ]


# --- The loop of Set A designed: its margins, what is refused, what limits it, and what goes past it


SET_A = EXPERIMENTS / "set_a.toml"


@cache
def loops():
    return {variant.name: variant for variant in read_experiment(SET_A).variants}


def delayed(delay, name="paper"):
    return replace(loops()[name], run=replace(loops()[name].run, delay=delay))


@pytest.mark.slow
def test_the_page_on_design_states_these_margins():
    page = (ROOT / "docs" / "how-to" / "design-a-loop.md").read_text().replace("−", "-")
    rows = re.findall(r"^\| (\d) \| (-?[\d.]+)° \| (-?[\d.]+)° \| ([\d.]+) \|", page, re.MULTILINE)
    assert len(rows) == 4
    for delay, *text in rows:
        small, large = assess(delayed(int(delay))).bare
        result = (large.margins.phase, small.margins.phase, small.loop.spectral_radius)
        assert [round(result[0], 1), round(result[1], 1), round(result[2], 3)] == [
            float(item) for item in text
        ]


def margins_by_transfer_functions(g):
    """Phase margin [deg] and gain margin of set C, by transfer functions: a free mass, drive and delay."""
    T, M, rate, lag, cutoff = 0.5e-3, 631.65, 150.0, 0.2e-3, 400.0
    numerator, denominator, _ = cont2discrete(([1.0], [M * lag, M, 0.0, 0.0]), T)
    kept, fades = np.exp(-2.0 * np.pi * cutoff * T), np.exp(-g * T)

    def open_loop(omega):
        z = np.exp(1j * omega * T)
        plant = np.polyval(numerator[0], z) / np.polyval(denominator, z) / z
        speed = (1.0 - kept) / (1.0 - kept / z) * (1.0 - 1.0 / z) / T
        by_itself = M * (2.0 * rate * speed + rate**2)
        # Of what is commanded, and of the momentum times g.
        seen = (1.0 - fades) / (1.0 - fades / z)
        return plant * (by_itself + g * M * speed * (1.0 - seen)) / (1.0 - seen / z)

    crossover = brentq(lambda w: abs(open_loop(w)) - 1.0, 150.0, 1500.0)
    turn = brentq(lambda w: open_loop(w).imag, 600.0, 3000.0)
    return np.degrees(np.angle(-open_loop(crossover))), -1.0 / open_loop(turn).real


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "g", "told"), [("none", 0.0, (51.9, 3.99)), ("observer", 60.0, (43.4, 3.30))]
)
def test_margins_of_set_c(name, g, told):
    sound = tracking.Sound(
        tracking.Tracked(EXPERIMENTS / "set_c.toml"),
        tracking.Tracked(EXPERIMENTS / "set_a_break_away.toml"),
    )
    # The least of the free mass, of one that is stuck and of one that slides: that of the free one.
    phase, gain = sound.margins[name]
    assert (phase, gain) == pytest.approx(margins_by_transfer_functions(g), rel=1e-4)
    assert (round(phase, 1), round(gain, 2)) == told
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert "at least 43° of phase and 3.3 of gain" in readme


@pytest.mark.slow
def test_two_samples_of_delay_degrade_and_three_diverge_as_their_poles_say():
    # Past the refusal: what is named before the simulation is what the simulation does.
    actual = {}
    for delay in (1, 2, 3):
        item = delayed(delay, "identified")
        actual[delay] = replace(
            item, name=str(delay), run=replace(item.run, duration=10.0, seeds=1)
        )
    result = simulate(replace(read_experiment(SET_A), variants=tuple(actual.values())))
    error = [result.variants[str(delay)].following_error.peak_to_peak for delay in (1, 2, 3)]
    assert 1.8 * error[0] < error[1]
    assert 10.0 * error[1] < error[2] or not error[2] < 1.0


@pytest.mark.slow
def test_the_error_budget_of_the_paper_s_compensator():
    budget = error_budget(
        replace(loops()["paper"], run=replace(loops()["paper"].run, duration=12.0, seeds=1))
    )
    alone = {entry.cause: entry.alone.peak_to_peak for entry in budget.entries}
    assert set(alone) == {"amplitude", "shape", "asymmetry", "irregularity", "encoder", "delay"}
    # Amplitude and encoder dominate; the shape of the loops hardly matters.
    assert min(alone["amplitude"], alone["encoder"]) > 1.5 * max(
        alone["shape"], alone["irregularity"], alone["delay"]
    )
    assert budget.no_cause.peak_to_peak < 0.01e-6


# --- Controllers and compensators past the paper: a cheap part of ``python -m benchmarks.compensation``


def some(name, *variants, seeds=2, **run):
    whole = read_experiment(file_of(name))
    chosen = tuple(
        replace(whole_one, run=replace(whole_one.run, seeds=seeds, **run))
        for whole_one in whole.variants
        if whole_one.name in variants
    )
    assert len(chosen) == len(variants)
    return simulate(replace(whole, variants=chosen)).variants


def peaks(results):
    return {name: 1e6 * item.following_error.peak_to_peak for name, item in results.items()}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seeds", "errors", "tolerance"),
    [
        (
            "past_a",
            2,
            {
                "mismatched_measured": 0.70,
                "fitted": 0.48,
                "pd": 1.50,
                "observer": 0.37,
                "super_twisting": 0.65,
            },
            0.12,
        ),
        (
            "past_b",
            2,
            {"fitted_measured": 0.73, "pd_mismatched": 0.72, "observer_mismatched": 0.65},
            0.12,
        ),
        # At low gain friction along the measured motion is positive feedback.
        ("low_gain", 2, {"desired": 6.8, "measured": 14.3}, 0.12),
        (
            "baselines",
            1,
            {
                "gms_feedforward": 0.84,
                "lugre_observer": 0.88,
                "adaptive_hysteresis": 0.69,
                "observer_and_feedforward": 0.42,
            },
            0.16,
        ),
    ],
)
def test_errors_of_improved_loops(name, seeds, errors, tolerance):
    assert peaks(some(name, *errors, seeds=seeds)) == pytest.approx(errors, rel=tolerance)


@pytest.mark.slow
def test_five_trials_learn_only_the_repeated_error():
    (learned,) = some("past_a", "learning", seeds=1).values()
    trials = 1e6 * np.array(learned.trials)
    assert (trials.size, trials[0], trials[-1]) == (
        5,
        pytest.approx(1.39, rel=0.12),
        pytest.approx(0.38, rel=0.12),
    )
    assert learned.following_error.peak_to_peak == learned.trials[-1]


@pytest.mark.slow
def test_a_faster_reference_raises_the_value_of_the_model_with_an_observer():
    names = ("none", "observer", "observer_feedforward")
    result = peaks(some("faster_a", *(f"{name}_{f}hz" for f in (1, 4) for name in names)))
    assert result["observer_1hz"] == pytest.approx(0.49, rel=0.12)
    assert result["observer_4hz"] == pytest.approx(0.91, rel=0.12)
    assert result["observer_feedforward_1hz"] <= 0.40
    assert result["observer_feedforward_4hz"] <= 0.45
    for frequency in (1, 4):
        assert result[f"observer_feedforward_{frequency}hz"] <= 0.30 * result[f"none_{frequency}hz"]


@pytest.mark.slow
def test_refining_the_step_of_the_plant_changes_little():
    coarse = peaks(some("set_a", "none", "paper", seeds=3))
    fine = peaks(some("set_a", "none", "paper", seeds=3, substeps=100))
    assert fine == pytest.approx(coarse, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SETS))
def test_the_files_contain_the_identified_model_of_the_rig(name):
    stored = read_model(EXPERIMENTS / f"{name}_identified.toml").friction
    again = compensator_from_log(EXPERIMENTS / f"{name}_log.toml")
    travel = 6.8e-6 * np.linspace(0.0, 1.0, 50)
    force, force_again = (_virgin_force(item, travel) for item in (stored, again))
    # A quantised loop is chaotic in its last digits: another processor finds another record of the same contact.
    assert force_again == pytest.approx(force, abs=0.02 * np.max(force))


def _virgin_force(model, travel):
    v = model.values
    reach = v["nu_i"] * v["F_C"] / v["k_i"]
    return np.minimum(travel[:, None], reach) @ v["k_i"] + v["offset"]


@pytest.mark.slow
def test_learned_friction_is_near_the_identified_from_the_first_period():
    from benchmarks.baselines import learning_time

    result = some(
        "baselines", "adaptive_hysteresis", "maxwell_slip_feedforward", seeds=1, settle=0.0
    )
    start, by_period = learning_time(result)
    assert start == 0.0
    assert by_period[0, 0] > 1.5 * by_period[0, -2]

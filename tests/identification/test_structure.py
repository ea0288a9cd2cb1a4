"""A missing force is reported by name with the model to try next; a right structure is not reported."""

import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort

from bristle.core.errors import InputError
from bristle.identification import identify
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import _LowPass, _no_chance
from bristle.identification.missing_rows import Rows, Weighed
from bristle.identification.settings import Settings
from bristle.report.identification import why_only_similar
from bristle.report.judgement import judged
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import parameter_table

pytestmark = pytest.mark.usefixtures("of_one_mass")

LEVEL = 8.0  # [N], of the sliding effort


@pytest.fixture(scope="module")
def motion():
    return sines(20.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))


def with_scatter(motion, force, seed=0, share=0.02):
    """Effort of the axis with a force, all friction at another level after each reversal."""
    generator = np.random.default_rng(seed)
    side = np.sign(motion.velocity)
    turn = np.cumsum(np.abs(np.diff(side, prepend=side[0])) > 0)
    level = 1.0 + share * generator.standard_normal(turn[-1] + 1)
    plain = sliding_effort(motion, seed, F_C=0.0)
    return plain + (LEVEL * side + force) * level[turn]


def forces(motion, cause):
    side, v = np.where(motion.velocity < 0.0, -1.0, 1.0), motion.velocity
    speed = np.abs(v) / np.max(np.abs(v))
    return {
        "nothing": 0.0 * v,
        "speed": LEVEL * side * 0.5 * np.sqrt(speed),
        "direction": 1.5 * v / np.max(np.abs(v)) * side,
        "ripple": 0.1 * LEVEL * np.sin(2.0 * np.pi * motion.position / 0.01 + 1.0),
        "position": 0.1 * LEVEL * motion.position / np.ptp(motion.position) * side,
        "lag": -0.4 * LEVEL * motion.acceleration / np.max(np.abs(motion.acceleration)) * np.exp(-speed / 0.1),
    }[cause]


def best_of(motion, cause, model="coulomb_viscous", seed=0, **settings):
    log = log_of(motion, with_scatter(motion, forces(motion, cause), seed), step=1e-7)
    return identify(log, model, axis=STATED, blocks=0, draws=0, settings=settings)


@pytest.fixture(scope="module")
def rippling(motion):
    """The result of a model that lacks a ripple."""
    return best_of(motion, "ripple")


def diagnostic_of(fit, code):
    return next(diagnostic for diagnostic in fit.diagnostics if diagnostic.code == code)


def causes_in(fit):
    return next((diagnostic.numbers["causes"] for diagnostic in fit.diagnostics if diagnostic.code == "structure"), ())


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("cause", "following"),
    [
        ("speed", "stribeck_free"),
        ("direction", "coulomb_viscous+asymmetry"),
        ("ripple", "coulomb_viscous+periodic"),
        ("position", "coulomb_viscous+position"),
        ("lag", "gms"),
    ],
)
def test_a_missing_force_is_named_with_the_model_that_has_it(motion, cause, following):
    fit = best_of(motion, cause).best
    # What lags behind a static model builds up after reversals, too.
    assert causes_in(fit)[0] == ("presliding" if cause == "lag" else cause)
    named = next(diagnostic for diagnostic in fit.diagnostics if diagnostic.code == f"missing_{cause}")
    assert named.numbers["model"] == following
    assert any(f"`{following}`" in diagnostic for diagnostic in warnings_of(fit))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cause", "compared"),
    [("speed", "stribeck_free"), ("direction", "coulomb_viscous+asymmetry"), ("ripple", "coulomb_viscous+periodic"), ("lag", "gms")],
)
def test_a_compared_model_is_not_suggested(motion, cause, compared):
    result = best_of(motion, cause, f"coulomb_viscous,{compared}", same_error=1e3)
    assert [fit.name for fit in result.fits] == ["coulomb_viscous", compared]
    named = next(diagnostic for diagnostic in result.best.diagnostics if diagnostic.code == f"missing_{cause}")
    assert (named.numbers["model"], named.numbers["compared"]) == ("", compared)
    assert message(named).endswith(f". bristle also compared `{compared}`, but its error is no smaller")


def test_a_negligible_force_makes_parameters_effective_without_a_warning(motion):
    result = best_of(motion, "position", missing_force=0.5)
    assert causes_in(result.best) == ("position",)
    assert "F_C" in result.best.effective
    assert {diagnostic.severity for diagnostic in result.best.diagnostics if diagnostic.code in ("structure", "missing_position")} == {
        "note"
    }
    assert judged(result.best, Settings()).level == "usable"
    assert judged(best_of(motion, "position").best, Settings()).level == "with_care"


def test_a_ripple_has_its_period_and_amplitude(motion):
    numbers = next(diagnostic for diagnostic in best_of(motion, "ripple").best.diagnostics if diagnostic.code == "missing_ripple").numbers
    assert numbers["period"] == pytest.approx(0.01, rel=0.01)
    assert numbers["amplitude"] == pytest.approx(0.1 * LEVEL, rel=0.15)


@pytest.mark.parametrize(
    ("turning", "pulls", "following"), [(False, "alike", "coulomb_viscous+periodic"), (True, "turning", "coulomb_viscous+ripple")]
)
def test_a_ripple_has_its_direction_dependence_and_a_model(motion, turning, pulls, following):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0) if turning else 1.0
    numbers, text = ripple_of(motion, with_scatter(motion, side * forces(motion, "ripple"), share=0.0))
    assert (numbers["pulls"], numbers["model"]) == (pulls, following)
    assert ("[[cogging]]" in text) is not turning
    assert f"`{following}`" in text


def ripple_of(motion, effort, lead=None):
    axis = replace(STATED, pitch=lead)
    fit = identify(log_of(motion, effort, step=1e-7), "coulomb_viscous", axis=axis, blocks=0, draws=0).best
    result = next(diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "missing_ripple")
    return result.numbers, message(result)


def test_cogging_is_named_as_in_the_axis_file(motion):
    overtone = 0.05 * LEVEL * np.cos(4.0 * np.pi * motion.position / 0.01)
    effort = with_scatter(motion, forces(motion, "ripple") + overtone, share=0.0)
    numbers, text = ripple_of(motion, effort)
    assert numbers["harmonics"] == (1, 2)
    assert numbers["period"] == pytest.approx(0.01, rel=2e-3)
    assert '`turn = "motor"` and `harmonics = [1, 2]`' in text
    assert re.search(r'`lead = "(10|9\.9\d+|10\.0\d*) mm"` under `\[transmission\]`', text)
    numbers, text = ripple_of(motion, effort, 0.03)
    assert '`turn = "screw"` and `harmonics = [3, 6]`' in text
    assert "lead" not in text


WEIGHT = 30.0  # [N*m], that a link pulls with at most


def of_a_link(motion, force):
    """What is said of an arm on a motion of a radian or two, beside friction."""
    effort = with_scatter(motion, 0.0 * motion.position, share=0.0) + force
    fit = identify(log_of(motion, effort, step=1e-6, kind="rotational"), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    return {diagnostic.code: diagnostic for diagnostic in fit.diagnostics}


def swinging(duration=20.0):
    return sines(duration, amplitudes=(1.2, 0.4, 0.05), frequencies=(0.31, 0.83, 2.3))


def test_gravity_of_a_link_is_preferred_and_named_as_in_the_axis_file():
    motion = swinging()
    text = of_a_link(motion, WEIGHT * np.sin(motion.position - 0.4))
    assert text["structure"].numbers["causes"][0] == "gravity"
    assert text["missing_gravity"].numbers["amplitude"] == pytest.approx(WEIGHT, rel=0.02)
    assert '`gravity = "link"` under `[plant]`' in message(text["missing_gravity"])
    assert "missing_position" not in text
    assert "missing_ripple" not in text


@pytest.mark.parametrize("power", [1, 2])
def test_a_cable_is_not_taken_for_gravity_of_a_link(power):
    motion = swinging()
    text = of_a_link(motion, WEIGHT * motion.position**power)
    assert "missing_position" in text
    assert "missing_gravity" not in text


def test_an_axis_that_moves_along_a_line_has_no_link():
    motion = swinging()
    effort = with_scatter(motion, LEVEL * np.sin(motion.position), share=0.0)
    fit = identify(log_of(motion, effort, step=1e-6), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert causes_in(fit)
    assert "gravity" not in causes_in(fit)


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("seed", range(6))
def test_a_right_structure_with_a_scattering_level_has_no_missing_force(motion, seed):
    assert causes_in(best_of(motion, "nothing", seed=seed).best) == ()


def test_a_small_ripple_is_found_despite_larger_scatter_of_the_level(motion):
    effort = with_scatter(motion, 0.3 * forces(motion, "ripple"), share=0.06)
    fit = identify(log_of(motion, effort, step=1e-7), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert causes_in(fit) == ("ripple",)


def test_a_small_force_is_found_with_a_large_force(motion):
    effort = with_scatter(motion, 2.0 * forces(motion, "position") + 0.2 * forces(motion, "ripple"))
    fit = identify(log_of(motion, effort, step=1e-7), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert causes_in(fit) == ("position", "ripple")


def test_a_small_ripple_is_found_despite_noise_of_slow_motion(motion):
    slow = np.abs(motion.velocity) < 0.03 * np.max(np.abs(motion.velocity))
    noise = np.where(slow, 20.0, 0.0) * np.random.default_rng(5).standard_normal(slow.size)
    effort = with_scatter(motion, 0.3 * forces(motion, "ripple")) + noise
    fit = identify(log_of(motion, effort, step=1e-7), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert causes_in(fit) == ("ripple",)


def test_a_force_around_reversals_has_no_other_name(motion):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    turned = np.diff(side, prepend=side[0]) != 0.0
    place = np.r_[motion.position[0], motion.position[turned]][np.cumsum(turned)]
    building_up = -2.0 * LEVEL * side * np.exp(-np.abs(motion.position - place) / 5e-5)
    fit = identify(log_of(motion, with_scatter(motion, building_up), step=1e-7), "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
    assert causes_in(fit) == ("presliding",)


def test_a_force_only_in_the_fitted_half_cycles_does_not_count():
    motion = sines(5.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    result = [best_of(motion, "nothing", seed=seed, missing_evidence=0.0) for seed in range(4)]
    assert not any(causes_in(item.best) for item in result)


def test_the_named_model_has_the_force(motion):
    assert causes_in(best_of(motion, "ripple", "coulomb_viscous+periodic").best) == ()


def test_parameters_of_a_model_that_lacks_a_force_are_effective(motion):
    result = best_of(motion, "ripple")
    assert set(result.best.effective) == {"M", "F_v", "F_C", "offset"}
    assert {row[-1] for row in parameter_table(result.best).rows} == {"effective"}
    assert "effective" in why_only_similar(result.best)
    assert not best_of(motion, "nothing").best.effective


@pytest.mark.slow
@pytest.mark.parametrize("cause", ["ripple", "lag"])
def test_thresholds_decide_the_diagnostics(motion, cause):
    assert causes_in(best_of(motion, cause, missing_evidence=0.5).best) == ()


def test_all_models_include_slots_suggested_by_the_residual(motion, monkeypatch):
    import bristle.identification.request as request

    monkeypatch.setattr(request, "MODELS", {name: request.MODELS[name] for name in ("coulomb", "coulomb_viscous")})
    log = log_of(motion, with_scatter(motion, forces(motion, "ripple")), step=1e-7)
    names = [fit.name for fit in identify(log, "all", axis=STATED, blocks=3, draws=0).fits]
    assert names[0] == "coulomb_viscous+periodic"
    assert {"coulomb", "coulomb_viscous", "coulomb_viscous+asymmetry"} < set(names)
    assert [fit.rank for fit in identify(log, "coulomb,coulomb_viscous", axis=STATED, blocks=3, draws=0).fits] == [1, 2]


def test_slots_that_cannot_be_fitted_are_omitted_and_the_comparison_is_not(motion, monkeypatch):
    # The function of that name hides its module.
    module = import_module("bristle.identification.identify")
    request = import_module("bristle.identification.request")
    fit = module.fit

    def refusing(context, component, *rest):
        if "+" in component.name:
            raise InputError("cannot be fitted", path="model", value=component.name)
        return fit(context, component, *rest)

    monkeypatch.setattr(module, "fit", refusing)
    monkeypatch.setattr(request, "MODELS", {"coulomb_viscous": request.MODELS["coulomb_viscous"]})
    log = log_of(motion, with_scatter(motion, forces(motion, "ripple")), step=1e-7)
    identification = identify(log, "all", axis=STATED, blocks=3, draws=0, settings={"lines_gain": 1.0})
    assert [item.name for item in identification.fits] == ["coulomb_viscous"]
    assert set(identification.left_out) == {"coulomb_viscous+asymmetry", "coulomb_viscous+periodic"}


def test_effects_of_the_parameters_are_not_a_missing_force():
    generator = np.random.default_rng(7)
    sure = generator.standard_normal(400)
    like_it = sure + 1e-3 * generator.standard_normal(400)
    nothing, ones = np.zeros(400), np.ones(400)
    rows = Rows(
        np.arange(400) * 1e-3,
        nothing,
        ones,
        nothing,
        nothing,
        sure,
        nothing[:, None],
        nothing,
        ones,
        ones,
        Groups(np.arange(400) // 40),
        {},
        100.0,
        "translational",
        ones,
        12.5,
    )
    weighed = Weighed(rows, ones, np.zeros(10), np.arange(400) // 40)
    _, coefficients = weighed._fitted(np.column_stack([sure, like_it]), 1)
    assert coefficients == pytest.approx([1.0, 0.0], abs=0.05)


def told_of(motion, force, model="coulomb_viscous", step=1e-5, seed=0, axis=STATED, **settings):
    """What is said of a force on friction, behind an encoder whose steps make more noise than the force."""
    log = log_of(motion, with_scatter(motion, force, seed), step=step)
    fit = identify(log, model, axis=axis, blocks=0, draws=0, settings=settings).best
    return causes_in(fit), fit


def lagging(motion, lag):
    """Friction that falls with the speed behind a first-order lag [s], beside the level [N]."""
    speed, step = np.abs(motion.velocity), motion.time[1] - motion.time[0]
    seen = speed if not lag else lfilter([step / (lag + step)], [1.0, -lag / (lag + step)], speed)
    return np.where(motion.velocity < 0.0, -1.0, 1.0) * 0.5 * LEVEL * np.exp(-((seen / 0.03) ** 2))


def knocking(motion, size):
    """What rings after each change of sides of the force on the load, one side as likely as the other [N]."""
    effort = sliding_effort(motion, noise=0.0)
    changes = np.flatnonzero(np.diff(np.sign(effort))) + 1
    pulses = np.zeros(effort.size)
    pulses[changes] = np.random.default_rng(3).choice([-size, size], changes.size)
    after = np.arange(0.0, 0.05, motion.time[1] - motion.time[0])
    return np.convolve(pulses, np.exp(-after / 0.012) * np.sin(2.0 * np.pi * 45.0 * after))[: effort.size]


@pytest.mark.slow
@pytest.mark.parametrize(("cause", "size"), [("speed", 0.6), ("ripple", 0.3)])
def test_a_force_hidden_by_noise_of_single_rows_is_reported(motion, cause, size):
    assert told_of(motion, size * forces(motion, cause))[0] == (cause,)
    assert told_of(motion, size * forces(motion, cause), missing_evidence=0.5)[0] == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_noise_of_single_rows_is_not_a_force(motion, seed):
    assert told_of(motion, forces(motion, "nothing"), seed=seed, axis=None)[0] == ()


def test_a_slow_force_is_reported_from_its_threshold(motion):
    ripple = 0.3 * forces(motion, "ripple")
    assert told_of(motion, ripple, missing_evidence=0.5)[0] == ()


def test_friction_that_lags_behind_the_speed_is_reported_and_other_friction_is_not(motion):
    text, fit = told_of(motion, lagging(motion, 0.02), "stribeck", step=1e-7)
    assert text[0] == "lag"
    assert next(diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "missing_lag").numbers["model"] == "gms"
    assert told_of(motion, lagging(motion, 0.0), "stribeck", step=1e-7)[0] == ()


def test_a_drive_that_knocks_from_flank_to_flank_has_play(motion):
    printed, fit = told_of(motion, knocking(motion, 6.0), step=1e-7)
    assert printed == ("play",)
    text = next(diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "missing_play")
    assert text.numbers["ratio"] > 3.0
    assert "play" in message(text)
    assert told_of(motion, knocking(motion, 6.0), step=1e-7, missing_evidence=50.0)[0] == ()
    assert told_of(motion, np.roll(knocking(motion, 6.0), 150), step=1e-7)[0] == ()


def test_all_shocks_count_if_no_single_one_dominates(motion, monkeypatch):
    def ratio():
        fit = told_of(motion, knocking(motion, 6.0), step=1e-7)[1]
        return next(diagnostic.numbers["ratio"] for diagnostic in fit.diagnostics if diagnostic.code == "missing_play")

    usual = ratio()
    monkeypatch.setattr("bristle.identification.play.MOST_OF_ONE", np.inf)
    assert usual == ratio()


def test_one_jolt_is_not_play(motion):
    effort = sliding_effort(motion, noise=0.0)
    change = (np.flatnonzero(np.diff(np.sign(effort))) + 1)[20]
    jolt = np.zeros(effort.size)
    jolt[change : change + 30] = 60.0
    assert told_of(motion, jolt, step=1e-7)[0] == ()


def rows_of(columns, residual, cycles=40, narrow=20.0):
    """Rows of an axis to and fro, 5 ms apart, with this residual and what was fitted."""
    count = residual.size
    nothing, time = np.zeros(count), 5e-3 * np.arange(count)
    turn = np.arange(count) * cycles // count
    velocity = np.where(turn % 2, -1.0, 1.0) * (1.0 + 0.5 * np.sin(9.0 * time))
    return Rows(
        time,
        np.cumsum(velocity) * 5e-3,
        velocity,
        nothing,
        residual + velocity,
        residual,
        columns,
        velocity,
        velocity,
        nothing,
        Groups(turn),
        {},
        100.0,
        "translational",
        np.full(count, np.inf),
        narrow,
    )


def test_a_filter_on_both_sides_removes_noise_and_changes_no_coefficient():
    generator = np.random.default_rng(1)
    columns = generator.standard_normal((2000, 3))
    rows = rows_of(columns, columns @ [1.0, -2.0, 0.5])
    rows = rows.at(np.arange(2000) % 400 < 380)  # stretches, each on its own
    passed = _LowPass.of(rows)
    assert passed(rows.residual) == pytest.approx(passed(rows.jacobian) @ [1.0, -2.0, 0.5])
    assert passed(np.ones(rows.time.size)) == pytest.approx(1.0)
    assert np.std(passed(generator.standard_normal(rows.time.size))) < 0.5
    slow = np.sin(2.0 * np.pi * 20.0 * rows_of(columns, columns[:, 0]).time)
    halved = _LowPass.of(rows_of(columns, slow))(slow)[200:-200]
    assert np.sqrt(np.mean(halved**2) / np.mean(slow**2)) == pytest.approx(0.5**0.5, rel=0.02)


def test_an_effect_over_a_half_cycle_counts_once_for_each():
    generator = np.random.default_rng(2)
    level = np.repeat(generator.standard_normal((40, 2)), 50, axis=0)
    chance = []
    for column in generator.standard_normal((40, 100)):
        rows = rows_of(np.ones((2000, 1)), level[:, 0] + 0.1 * generator.standard_normal(2000))
        weighed = Weighed(rows, np.ones(2000), np.zeros(40), rows.cycles.index % 10)
        chance.append(_no_chance(weighed, np.ones((2000, 1)), np.repeat(column[:40], 50)[:, None], 0.95))
    assert np.mean(chance) < 0.15
    assert _no_chance(weighed, np.ones((2000, 1)), level[:, :1], 0.95)


def test_rows_with_trembling_velocity_are_not_far_from_reversals():
    rows = rows_of(np.ones((2000, 1)), np.ones(2000))
    trembling = np.where(np.arange(2000) < 1000, 0.0, np.inf)
    assert np.any(rows.far[:1000])
    assert not np.any(replace(rows, turned=trembling).far[:1000])
    assert np.array_equal(replace(rows, turned=trembling).far[1000:], rows.far[1000:])

"""A force that the model has no place for is told by name, with the model to try next; a right structure is not."""

import re
from importlib import import_module

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort

from bristle.core import Axis
from bristle.core.errors import InputError
from bristle.identification import identify
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import Rows, _Weighed
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import parameter_table
from bristle.report.verdict import sentences

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
    return identify(log, model, blocks=0, draws=0, settings=settings)


def causes_in(fit):
    return next((one.numbers["causes"] for one in fit.diagnostics if one.code == "structure"), ())


@pytest.mark.parametrize(
    ("cause", "following"),
    [
        ("speed", "stribeck_free"), ("direction", "coulomb_viscous+asymmetry"), ("ripple", "coulomb_viscous+periodic"),
        ("position", "coulomb_viscous+position"), ("lag", "gms"),
    ],
)  # fmt: skip
def test_a_missing_force_is_named_with_the_model_that_has_it(motion, cause, following):
    fit = best_of(motion, cause).best
    assert causes_in(fit)[0] == cause
    named = next(one for one in fit.diagnostics if one.code == f"missing_{cause}")
    assert named.numbers["model"] == following
    assert any(f"`{following}`" in one for one in warnings_of(fit))


def test_a_ripple_has_its_period_and_amplitude(motion):
    numbers = next(one for one in best_of(motion, "ripple").best.diagnostics if one.code == "missing_ripple").numbers
    assert numbers["period"] == pytest.approx(0.01, rel=0.01)
    assert numbers["amplitude"] == pytest.approx(0.1 * LEVEL, rel=0.15)


@pytest.mark.parametrize(
    ("turning", "pulls", "following"),
    [(False, "alike", "coulomb_viscous+periodic"), (True, "turning", "coulomb_viscous+ripple")],
)
def test_a_ripple_says_whether_it_turns_with_the_motion_and_what_has_it(motion, turning, pulls, following):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0) if turning else 1.0
    numbers, text = ripple_of(motion, with_scatter(motion, side * forces(motion, "ripple"), share=0.0))
    assert (numbers["pulls"], numbers["model"]) == (pulls, following)
    assert ("[[cogging]]" in text) is not turning
    assert f"`{following}`" in text


def ripple_of(motion, effort, lead=None):
    axis = Axis(pitch=lead)
    fit = identify(log_of(motion, effort, step=1e-7), axis=axis, blocks=0, draws=0).best
    found = next(one for one in fit.diagnostics if one.code == "missing_ripple")
    return found.numbers, message(found)


def test_cogging_is_named_as_it_is_typed(motion):
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
    fit = identify(log_of(motion, effort, step=1e-6, kind="rotational"), blocks=0, draws=0).best
    return {one.code: one for one in fit.diagnostics}


def swinging():
    return sines(20.0, amplitudes=(1.2, 0.4, 0.05), frequencies=(0.31, 0.83, 2.3))


def test_the_gravity_of_a_link_is_named_before_a_place_and_as_it_is_typed():
    motion = swinging()
    said = of_a_link(motion, WEIGHT * np.sin(motion.position - 0.4))
    assert said["structure"].numbers["causes"][0] == "gravity"
    assert said["missing_gravity"].numbers["amplitude"] == pytest.approx(WEIGHT, rel=0.02)
    assert '`gravity = "link"` under `[plant]`' in message(said["missing_gravity"])
    assert "missing_position" not in said
    assert "missing_ripple" not in said


@pytest.mark.parametrize("power", [1, 2])
def test_a_cable_is_not_called_the_gravity_of_a_link(power):
    motion = swinging()
    said = of_a_link(motion, WEIGHT * motion.position**power)
    assert "missing_position" in said
    assert "missing_gravity" not in said


def test_an_axis_that_moves_along_a_line_has_no_link():
    motion = swinging()
    effort = with_scatter(motion, LEVEL * np.sin(motion.position), share=0.0)
    fit = identify(log_of(motion, effort, step=1e-6), blocks=0, draws=0).best
    assert causes_in(fit)
    assert "gravity" not in causes_in(fit)


@pytest.mark.parametrize("seed", range(6))
def test_a_right_structure_is_left_alone_though_its_level_scatters(motion, seed):
    assert causes_in(best_of(motion, "nothing", seed=seed).best) == ()


def test_a_small_ripple_is_seen_through_a_level_that_scatters_more(motion):
    effort = with_scatter(motion, 0.3 * forces(motion, "ripple"), share=0.06)
    fit = identify(log_of(motion, effort, step=1e-7), blocks=0, draws=0).best
    assert causes_in(fit) == ("ripple",)


def test_a_small_force_is_seen_beside_a_large_one(motion):
    effort = with_scatter(motion, 2.0 * forces(motion, "position") + 0.2 * forces(motion, "ripple"))
    fit = identify(log_of(motion, effort, step=1e-7), blocks=0, draws=0).best
    assert causes_in(fit) == ("position", "ripple")


def test_a_small_ripple_is_seen_through_noise_of_slow_motion(motion):
    slow = np.abs(motion.velocity) < 0.03 * np.max(np.abs(motion.velocity))
    noise = np.where(slow, 20.0, 0.0) * np.random.default_rng(5).standard_normal(slow.size)
    effort = with_scatter(motion, 0.3 * forces(motion, "ripple")) + noise
    fit = identify(log_of(motion, effort, step=1e-7), blocks=0, draws=0).best
    assert causes_in(fit) == ("ripple",)


def test_what_acts_around_reversals_is_named_nothing_else(motion):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    turned = np.diff(side, prepend=side[0]) != 0.0
    place = np.r_[motion.position[0], motion.position[turned]][np.cumsum(turned)]
    building_up = -2.0 * LEVEL * side * np.exp(-np.abs(motion.position - place) / 5e-5)
    fit = identify(log_of(motion, with_scatter(motion, building_up), step=1e-7), blocks=0, draws=0).best
    assert causes_in(fit) == ("play",)


def test_what_only_the_fitted_half_cycles_show_is_nothing():
    motion = sines(5.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    least = dict.fromkeys(("missing_share", "missing_share_around"), 0.08)
    found = [best_of(motion, "nothing", seed=seed, missing_force=0.0, missing_effort=0.0, **least) for seed in range(4)]
    assert not any(causes_in(one.best) for one in found)


def test_the_model_that_is_named_has_it(motion):
    assert causes_in(best_of(motion, "ripple", "coulomb_viscous+periodic").best) == ()


def test_parameters_of_a_model_that_lacks_a_force_are_effective(motion):
    found = best_of(motion, "ripple")
    assert set(found.best.effective) == {"M", "F_v", "F_C", "offset"}
    assert {row[-1] for row in parameter_table(found.best).rows} == {"effective"}
    assert any("effective" in one for one in sentences(found, "axis", None, None))
    assert not best_of(motion, "nothing").best.effective


def test_thresholds_decide_what_is_said(motion):
    assert causes_in(best_of(motion, "ripple", missing_share=0.999).best) == ()
    assert causes_in(best_of(motion, "ripple", missing_force=0.5).best) == ()
    assert causes_in(best_of(motion, "ripple", missing_effort=0.5).best) == ()
    assert causes_in(best_of(motion, "lag", missing_share_around=0.999).best) == ()


def test_all_models_include_the_slots_that_the_residual_names(motion, monkeypatch):
    import bristle.identification.request as request

    monkeypatch.setattr(request, "MODELS", {name: request.MODELS[name] for name in ("coulomb", "coulomb_viscous")})
    log = log_of(motion, with_scatter(motion, forces(motion, "ripple")), step=1e-7)
    names = [fit.name for fit in identify(log, "all", blocks=3, draws=0).fits]
    assert names[0] == "coulomb_viscous+periodic"
    assert {"coulomb", "coulomb_viscous", "coulomb_viscous+asymmetry"} < set(names)
    assert [fit.rank for fit in identify(log, "coulomb,coulomb_viscous", blocks=3, draws=0).fits] == [1, 2]


def test_slots_that_the_log_cannot_bear_are_left_out_not_the_comparison(motion, monkeypatch):
    # The function of that name hides its module.
    module = import_module("bristle.identification.identify")
    request = import_module("bristle.identification.request")
    fit = module.fit

    def refusing(context, component, *others):
        if "+" in component.name:
            raise InputError("cannot be fitted", path="model", value=component.name)
        return fit(context, component, *others)

    monkeypatch.setattr(module, "fit", refusing)
    monkeypatch.setattr(request, "MODELS", {"coulomb_viscous": request.MODELS["coulomb_viscous"]})
    log = log_of(motion, with_scatter(motion, forces(motion, "ripple")), step=1e-7)
    found = identify(log, "all", blocks=3, draws=0)
    assert [one.name for one in found.fits] == ["coulomb_viscous"]
    assert set(found.left_out) == {"coulomb_viscous+asymmetry", "coulomb_viscous+periodic"}


def test_what_the_parameters_may_take_is_theirs_before_it_is_a_missing_force():
    generator = np.random.default_rng(7)
    sure = generator.standard_normal(400)
    like_it = sure + 1e-3 * generator.standard_normal(400)
    nothing, ones = np.zeros(400), np.ones(400)
    rows = Rows(
        np.arange(400) * 1e-3, nothing, ones, nothing, nothing, sure, nothing[:, None], nothing, ones, ones,
        Groups(np.arange(400) // 40), {}, 100.0, "translational",
    )  # fmt: skip
    weighed = _Weighed(rows, ones, np.zeros(10), np.arange(400) // 40)
    _, coefficients = weighed._fitted(np.column_stack([sure, like_it]), 1)
    assert coefficients == pytest.approx([1.0, 0.0], abs=0.05)

"""A missing force is reported by name with the model to try next; a right structure is not reported."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort
from tests.identification.rigid import IDENTIFYING, identify

from bristle import friction
from bristle.core import Axis, InputError
from bristle.engine import force_along
from bristle.identification import fits
from bristle.identification.half_cycles import Groups
from bristle.identification.missing_force import _LowPass, _no_chance
from bristle.identification.missing_rows import Rows, Weighed
from bristle.identification.settings import Settings
from bristle.report.identification import why_only_similar
from bristle.report.judgement import judged
from bristle.report.messages import message, warnings_of
from bristle.report.model_tables import parameter_table

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
        "lag": -0.4
        * LEVEL
        * motion.acceleration
        / np.max(np.abs(motion.acceleration))
        * np.exp(-speed / 0.1),
    }[cause]


def result_of(
    motion,
    force,
    model="coulomb_viscous",
    *,
    seed=0,
    share=0.02,
    step=1e-7,
    axis=STATED,
    kind="translational",
    **settings,
):
    log = log_of(motion, with_scatter(motion, force, seed, share), step=step, kind=kind)
    return identify(log, model, axis=axis, blocks=0, draws=0, settings=settings)


def fit_of(motion, force, *model, **changes):
    return result_of(motion, force, *model, **changes).best


@pytest.fixture(scope="module")
def lacking(motion):
    """The result of a model that lacks a force."""
    return result_of(motion, forces(motion, "direction"))


def causes_in(fit):
    return next(
        (
            diagnostic.numbers["causes"]
            for diagnostic in fit.diagnostics
            if diagnostic.code == "structure"
        ),
        (),
    )


def about(fit, cause):
    return next(
        diagnostic for diagnostic in fit.diagnostics if diagnostic.code == f"missing_{cause}"
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    ("cause", "following"),
    [("speed", "stribeck_free"), ("direction", "coulomb_viscous+asymmetry"), ("lag", "gms")],
)
def test_a_missing_force_is_named_with_the_model_that_has_it(motion, cause, following):
    fit = fit_of(motion, forces(motion, cause))
    # What lags behind a static model builds up after reversals, too.
    assert causes_in(fit)[0] == ("presliding" if cause == "lag" else cause)
    assert about(fit, cause).numbers["model"] == following
    assert any(f"`{following}`" in diagnostic for diagnostic in warnings_of(fit))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cause", "compared"),
    [("speed", "stribeck_free"), ("direction", "coulomb_viscous+asymmetry"), ("lag", "gms")],
)
def test_a_compared_model_is_not_suggested(motion, cause, compared):
    result = result_of(motion, forces(motion, cause), f"coulomb_viscous,{compared}", same_error=1e3)
    assert [fit.name for fit in result.fits] == ["coulomb_viscous", compared]
    named = about(result.best, cause)
    assert (named.numbers["model"], named.numbers["compared"]) == ("", compared)
    assert message(named).endswith(
        f". bristle also compared `{compared}`, but its error is no smaller"
    )


@pytest.mark.parametrize(
    ("least", "severity", "level"), [(0.5, "note", "usable"), (None, "warning", "with_care")]
)
def test_a_negligible_force_makes_parameters_effective_without_a_warning(
    motion, least, severity, level
):
    fit = fit_of(
        motion, forces(motion, "direction"), **({} if least is None else {"missing_force": least})
    )
    assert causes_in(fit) == ("direction",)
    assert "F_C" in fit.effective
    assert {
        diagnostic.severity
        for diagnostic in fit.diagnostics
        if diagnostic.code in ("structure", "missing_direction")
    } == {severity}
    assert judged(fit, Settings()).level == level


def test_parameters_of_a_model_that_lacks_a_force_are_effective(lacking):
    assert [fit.name for fit in lacking.fits] == ["coulomb_viscous"]
    assert set(lacking.best.effective) == {"M", "F_v", "F_C", "offset"}
    assert {row[-1] for row in parameter_table(lacking.best).rows} == {"effective"}
    assert "effective" in why_only_similar(lacking.best)


WEIGHT = 30.0  # [N*m], that a link pulls with at most


def swinging(duration=20.0):
    return sines(duration, amplitudes=(1.2, 0.4, 0.05), frequencies=(0.31, 0.83, 2.3))


def lagging(motion, lag):
    """Friction that falls with the speed behind a first-order lag [s], beside the level [N]."""
    speed, step = np.abs(motion.velocity), motion.time[1] - motion.time[0]
    seen = speed if not lag else lfilter([step / (lag + step)], [1.0, -lag / (lag + step)], speed)
    return np.where(motion.velocity < 0.0, -1.0, 1.0) * 0.5 * LEVEL * np.exp(-((seen / 0.03) ** 2))


def turns_of_force(motion):
    effort = sliding_effort(motion, noise=0.0)
    return np.flatnonzero(np.diff(np.sign(effort))) + 1


def knocking(motion, size):
    """What rings after each change of sides of the force on the load, one side as likely as the other [N]."""
    changes, pulses = turns_of_force(motion), np.zeros(motion.time.size)
    pulses[changes] = np.random.default_rng(3).choice([-size, size], changes.size)
    after = np.arange(0.0, 0.05, motion.time[1] - motion.time[0])
    return np.convolve(pulses, np.exp(-after / 0.012) * np.sin(2.0 * np.pi * 45.0 * after))[
        : pulses.size
    ]


def jolted(motion):
    jolt, change = np.zeros(motion.time.size), turns_of_force(motion)[20]
    jolt[change : change + 30] = 60.0
    return jolt


def around_reversals(motion):
    side = np.where(motion.velocity < 0.0, -1.0, 1.0)
    turned = np.diff(side, prepend=side[0]) != 0.0
    place = np.r_[motion.position[0], motion.position[turned]][np.cumsum(turned)]
    return -2.0 * LEVEL * side * np.exp(-np.abs(motion.position - place) / 5e-5)


@pytest.mark.fast_cases(5)
@pytest.mark.parametrize(
    ("force", "changes", "causes"),
    [
        pytest.param(around_reversals, {}, ("presliding",), id="around reversals"),
        pytest.param(
            lambda motion: 0.3 * forces(motion, "direction"),
            {"step": 1e-5, "missing_evidence": 0.5},
            (),
            id="slow force below its threshold",
        ),
        pytest.param(
            lambda motion: lagging(motion, 0.0),
            {"model": "stribeck"},
            (),
            id="fall that does not lag",
        ),
        pytest.param(
            lambda motion: np.roll(knocking(motion, 6.0), 150),
            {},
            (),
            id="knocks away from the changes of sides",
        ),
        pytest.param(
            lambda motion: knocking(motion, 6.0),
            {"missing_evidence": 50.0},
            (),
            id="knocks below the threshold",
        ),
        pytest.param(jolted, {}, (), id="one jolt is no play"),
        pytest.param(
            lambda motion: forces(motion, "direction"),
            {"model": "coulomb_viscous+asymmetry"},
            (),
            id="the named model has it",
        ),
    ],
)
def test_a_force_has_its_causes_and_no_other(motion, force, changes, causes):
    assert causes_in(fit_of(motion, force(motion), **changes)) == causes


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("seed", range(6))
def test_a_right_structure_with_a_scattering_level_has_no_missing_force(motion, seed):
    fit = fit_of(motion, forces(motion, "nothing"), seed=seed)
    assert causes_in(fit) == fit.effective == ()


def test_a_force_only_in_the_fitted_half_cycles_does_not_count():
    motion = sines(5.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    fits = [
        fit_of(motion, forces(motion, "nothing"), seed=seed, missing_evidence=0.0)
        for seed in range(3)
    ]
    assert not any(map(causes_in, fits))


@pytest.mark.slow
@pytest.mark.parametrize("cause", ["direction", "lag"])
def test_thresholds_decide_the_diagnostics(motion, cause):
    assert causes_in(fit_of(motion, forces(motion, cause), missing_evidence=0.5)) == ()


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize("refused", [False, True])
def test_all_models_include_slots_for_found_terms_that_can_be_fitted(monkeypatch, refused):
    motion = sines(8.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    request = IDENTIFYING.request
    fit, suggested = fits.fit, {"coulomb_viscous+asymmetry", "coulomb_viscous+position"}

    def refusing(context, component, *rest):
        if refused and "+" in component.name:
            raise InputError("cannot be fitted", path="model", value=component.name)
        return fit(context, component, *rest)

    monkeypatch.setattr(fits, "fit", refusing)
    monkeypatch.setattr(request, "MODELS", {"coulomb_viscous": request.MODELS["coulomb_viscous"]})
    log = log_of(motion, with_scatter(motion, 2.0 * forces(motion, "position")), step=1e-7)
    result = identify(log, "all", axis=STATED, blocks=2, draws=0)
    expected = {"coulomb_viscous"} if refused else {"coulomb_viscous", *suggested}
    assert {fit.name for fit in result.fits} - {"coulomb_viscous+position+asymmetry"} == expected
    assert set(result.left_out) == (suggested if refused else set())
    assert result.best.name == ("coulomb_viscous" if refused else "coulomb_viscous+position")


def test_effects_of_the_parameters_are_not_a_missing_force():
    generator = np.random.default_rng(7)
    sure = generator.standard_normal(400)
    like_it = sure + 1e-3 * generator.standard_normal(400)
    rows = rows_of(np.zeros((400, 1)), sure, cycles=10)
    weighed = Weighed(rows, np.ones(400), np.zeros(10), rows.cycles.index)
    _, coefficients = weighed._fitted(np.column_stack([sure, like_it]), 1)
    assert coefficients == pytest.approx([1.0, 0.0], abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(("cause", "size"), [("speed", 0.6), ("direction", 0.3)])
def test_a_force_hidden_by_noise_of_single_rows_is_reported(motion, cause, size):
    force = size * forces(motion, cause)
    assert causes_in(fit_of(motion, force, step=1e-5)) == (cause,)
    assert causes_in(fit_of(motion, force, step=1e-5, missing_evidence=0.5)) == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_noise_of_single_rows_is_not_a_force(motion, seed):
    assert (
        causes_in(fit_of(motion, forces(motion, "nothing"), step=1e-5, seed=seed, axis=None)) == ()
    )


def test_friction_that_lags_behind_the_speed_is_reported(motion):
    fit = fit_of(motion, lagging(motion, 0.02), "stribeck")
    assert causes_in(fit)[0] == "lag"
    assert about(fit, "lag").numbers["model"] == "gms"


def test_a_drive_that_knocks_from_flank_to_flank_has_play_and_all_shocks_count(motion, monkeypatch):
    fit = fit_of(motion, knocking(motion, 6.0))
    assert causes_in(fit) == ("play",)
    told = about(fit, "play")
    assert told.numbers["ratio"] > 3.0
    assert "play" in message(told)
    # No single one dominates.
    monkeypatch.setattr("bristle.identification.play.MOST_OF_ONE", np.inf)
    assert (
        about(fit_of(motion, knocking(motion, 6.0)), "play").numbers["ratio"]
        == told.numbers["ratio"]
    )


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
        100.0,
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
        chance.append(
            _no_chance(weighed, np.ones((2000, 1)), np.repeat(column[:40], 50)[:, None], 0.95)
        )
    assert np.mean(chance) < 0.15
    assert _no_chance(weighed, np.ones((2000, 1)), level[:, :1], 0.95)


def test_rows_with_trembling_velocity_are_not_far_from_reversals():
    rows = rows_of(np.ones((2000, 1)), np.ones(2000))
    trembling = np.where(np.arange(2000) < 1000, 0.0, np.inf)
    assert np.any(rows.far[:1000])
    assert not np.any(replace(rows, turned=trembling).far[:1000])
    assert np.array_equal(replace(rows, turned=trembling).far[1000:], rows.far[1000:])


@pytest.mark.slow
@pytest.mark.parametrize("model", ["maxwell_slip", "gms"])
def test_a_spring_is_no_friction_of_elements(model):
    pulled, axis = (
        sines(12.0, amplitudes=(0.2, 0.05), frequencies=(0.31, 0.83), phases=(0, 1)),
        Axis(seeks_delay=False, resolution=1e-7),
    )
    effort = sliding_effort(pulled, M=34.6, F_C=0.0, F_v=40.0) + 31.0 * pulled.position
    effort += force_along(friction.dahl(F_C=22.0, sigma_0=4e6), pulled.velocity, 1e-3)
    best = identify(log_of(pulled, effort, step=1e-7), model, axis=axis, draws=0).best
    assert best.parameters["F_C"].value == pytest.approx(22.0, rel=0.01)
    assert best.plant.values["spring_1"] == pytest.approx(31.0, rel=0.02)

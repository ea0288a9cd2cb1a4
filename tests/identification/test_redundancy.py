"""Confounded parameters, directions, slots and relations between parameters."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    Motion,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
    slow_log,
)
from tests.identification.own_models import own_model
from tests.identification.rigid import identify

from bristle import friction
from bristle.core import Axis, InputError, Relation, Variable, kernel
from bristle.core.mathematics import decay, direction
from bristle.files import read_model, write_model
from bristle.identification.settings import DEFAULT
from bristle.models.friction import find, slotted
from bristle.models.friction.slots import by_direction, directional
from bristle.report.judgement import judged
from bristle.report.messages import assumptions_of, message, note_of, warnings_of
from bristle.report.model_tables import WITH_CONSTANT, parameter_table


def one_way(forward: bool = True) -> Motion:
    t = 1e-3 * np.arange(10_000)
    w = 2.0 * np.pi
    q, v, a = (
        0.1 * t + 0.01 * np.sin(w * t),
        0.1 + 0.01 * w * np.cos(w * t),
        -0.01 * w * w * np.sin(w * t),
    )
    side = 1.0 if forward else -1.0
    return Motion(t, side * q, side * v, side * a)


def test_offset_is_fixed_with_asymmetry_and_reported():
    log = sliding_log()
    at_zero = identify(log, "coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0).best
    assert at_zero.parameters["offset"].status == "held"
    assert at_zero.parameters["offset"].value == 0.0
    assert any("F_C_pos and F_C_neg" in sentence for sentence in assumptions_of(at_zero))
    at_known = identify(
        log, "coulomb_viscous+asymmetry", axis=replace(STATED, offset=1.5), blocks=0, draws=0
    ).best
    assert at_known.parameters["offset"].value == 1.5
    # Sliding shows two levels only: whatever the offset is held at, they are the same, and so is the fit.
    for side, sign in (("F_C_pos", 1.0), ("F_C_neg", -1.0)):
        level = at_zero.parameters[side].value
        assert at_known.parameters[side].value + sign * 1.5 == pytest.approx(level, rel=1e-9)
    assert at_known.force_error_percent == pytest.approx(at_zero.force_error_percent, rel=1e-9)


@pytest.mark.parametrize("forward", [True, False])
def test_one_direction_fixes_the_offset(forward):
    motion = one_way(forward)
    fit = identify(
        log_of(motion, sliding_effort(motion, offset=0.0)),
        "coulomb_viscous",
        axis=STATED,
        blocks=0,
        draws=0,
    ).best
    assert fit.parameters["offset"].status == "held"
    assert ("forward only" if forward else "backward only") in note_of(fit.parameters["offset"])
    assert fit.parameters["F_C"].value == pytest.approx(8.0, rel=0.02)


def test_one_direction_leaves_the_offset_to_a_model_without_a_level():
    motion = one_way()
    fit = identify(
        log_of(motion, sliding_effort(motion, F_C=0.0)), "viscous", axis=STATED, blocks=0, draws=0
    ).best
    assert fit.parameters["offset"].value == pytest.approx(
        1.5, abs=4.0 * fit.parameters["offset"].std
    )


def test_one_direction_does_not_show_the_other():
    motion = one_way()
    with pytest.raises(InputError, match="only forward motion") as caught:
        identify(
            log_of(motion, sliding_effort(motion)),
            "coulomb_viscous+asymmetry",
            axis=STATED,
            draws=0,
        )
    assert "drop +asymmetry" in caught.value.mend


@pytest.mark.parametrize(
    "known", [{}, {"mass": 12.0}, {"mass": 12.0, "offset": 0.0}, {"axis": Axis(mass=12.0)}]
)
def test_a_reversed_effort_is_detected_for_any_prior_knowledge(known):
    motion = sines(5.0)
    fit = identify(
        log_of(motion, -sliding_effort(motion)), "coulomb_viscous", blocks=0, draws=0, **known
    ).best
    (text,) = [diagnostic for diagnostic in fit.diagnostics if diagnostic.code == "sign_reversed"]
    assert text.severity == "error"
    assert "sign = -1" in message(text)


def test_unidentifiably_small_friction_is_not_a_reversed_effort():
    motion = sines(5.0)
    for seed in range(3):
        log = log_of(motion, sliding_effort(motion, seed, noise=0.3, F_C=0.0, F_v=0.0))
        fit = identify(log, "coulomb_viscous", axis=STATED, blocks=0, draws=0).best
        assert fit.parameters["M"].value == pytest.approx(12.0, rel=0.01)
        assert "sign_reversed" not in {diagnostic.code for diagnostic in fit.diagnostics}


@pytest.mark.parametrize(
    ("length", "force"), [(1.0, 1.0), (2.0**10, 2.0**-10), (2.0**-10, 2.0**10)]
)
def test_friction_that_adds_energy_is_reported_for_any_magnitude(length, force):
    moved = sines(4.0)
    motion = Motion(moved.time, *(length * item for item in moved[1:]))
    # The inertia has its sign, which is no excuse.
    effort = 500.0 * moved.position + sliding_effort(moved, F_C=-8.0, F_v=-30.0, offset=0.0)
    fit = identify(
        log_of(motion, force * effort),
        "coulomb_viscous",
        axis=Axis(plant="oscillator"),
        blocks=0,
        draws=0,
    ).best
    assert "sign_reversed" in [diagnostic.code for diagnostic in fit.diagnostics]


def test_an_effort_of_zero_is_rejected():
    motion = sines()
    with pytest.raises(InputError, match="zero throughout"):
        identify(
            log_of(motion, np.zeros(motion.time.size)), "coulomb_viscous", axis=STATED, draws=0
        )


def test_a_log_without_effort_is_rejected():
    motion = sines()
    log = log_of(motion, sliding_effort(motion))
    bare = type(log)(log.time, log.position, sample_time=log.sample_time, segments=log.segments)
    with pytest.raises(InputError, match="no effort"):
        identify(bare, "coulomb_viscous", axis=STATED, draws=0)


@pytest.fixture(scope="module")
def driven_log():
    """A log whose friction has the sign of the motion: as where the effort is turned and the inertia is known."""
    motion = sines()
    return log_of(motion, sliding_effort(motion, noise=0.05, F_C=-8.0, F_v=0.0, offset=0.0))


@pytest.mark.parametrize("model", ["coulomb_viscous", "maxwell_slip"])
def test_an_effort_of_the_other_sign_is_fitted_and_its_causes_are_named(driven_log, model):
    fit = identify(driven_log, model, mass=12.0, draws=0, blocks=0).best
    estimate = fit.parameters["F_C"]
    assert (estimate.status, estimate.reason.code) == ("at_edge", "no_friction")
    assert fit.friction.values["F_C"] < 1e-3 * driven_log.effort.values.std()
    warnings = " ".join(warnings_of(fit))
    for cause in ("no force opposes the motion", "gravity", "reversed sign of the effort"):
        assert cause in warnings


def test_with_positive_damping_no_cause_is_sought_in_the_sign():
    motion = sines(5.0)
    effort = sliding_effort(motion, noise=0.05, F_C=-2.0, F_v=60.0, offset=0.0)
    estimate = identify(
        log_of(motion, effort), "coulomb_viscous", mass=12.0, draws=0, blocks=0
    ).best.parameters["F_C"]
    assert (estimate.status, estimate.reason.code) == ("at_edge", "edge_of_model")


def against(state, memory, motion, dt, p):
    return p.F_neg * direction(motion.v), state


LEVEL = Variable("force", "level against the motion", min=0.0, excitation="sliding")
# A level whose name ends as one of a direction.
OWN = own_model(against, {"F_neg": LEVEL}, "against", linear=True)


def test_a_level_named_like_a_directional_level_does_not_fix_the_offset():
    fit = identify(
        slow_log(find("coulomb_viscous")(F_C=5.0, F_v=0.0, offset=1.5), duration=6.0),
        OWN,
        axis=STATED,
        blocks=0,
        draws=0,
    ).best
    assert fit.parameters["offset"].status == "identified"
    assert fit.parameters["offset"].value == pytest.approx(1.5, abs=0.1)


@pytest.mark.parametrize("name", ["stribeck", "stribeck+position+asymmetry", "gms+asymmetry"])
def test_a_component_names_its_parameters_by_direction(name):
    component, sided = find(name), "asymmetry" in name
    assert by_direction(component, "F_S") == (("F_S_pos", "F_S_neg") if sided else ("F_S",))
    assert (by_direction(component, "v_S"), by_direction(component, "offset")) == (
        ("v_S",),
        ("offset",),
    )
    assert set(directional(component)) == {
        key for key in component.variables if key[-4:] in ("_pos", "_neg")
    }
    assert directional(slotted(OWN, asymmetry=False)) == directional(OWN) == ()


@pytest.mark.parametrize(
    ("offset", "code"), [(3.0, "held_levels"), (-12.0, "held_constant"), (12.0, "held_constant")]
)
def test_a_weight_larger_than_friction_makes_no_level_negative(offset, code):
    truth = find("coulomb_viscous+asymmetry")(
        F_C_pos=5.0, F_C_neg=4.0, F_v_pos=0.0, F_v_neg=0.0, offset=offset
    )
    fit = identify(
        slow_log(truth, duration=6.0), "coulomb_viscous+asymmetry", axis=STATED, blocks=0, draws=0
    ).best
    result = {name: item.value for name, item in fit.parameters.items()}
    assert fit.parameters["offset"].reason.code == code
    assert result["F_C_pos"] + result["offset"] == pytest.approx(5.0 + offset, abs=0.1)
    assert result["F_C_neg"] - result["offset"] == pytest.approx(4.0 - offset, abs=0.1)
    assert {fit.parameters[name].status for name in ("F_C_pos", "F_C_neg")} == {"identified"}
    remarks = {row[0]: row[-1] for row in parameter_table(fit).rows}
    assert [name for name, remark in remarks.items() if remark == WITH_CONSTANT] == [
        "F_C_pos",
        "F_C_neg",
    ]
    assert any("which bristle guessed" in text for text in warnings_of(fit)) is (
        code == "held_constant"
    )


def notes_of(identification, *ranked):
    """Notes about the offset where these models rank so."""
    fits = {fit.name: fit for fit in identification.fits}
    return [
        note
        for note in replace(identification, fits=tuple(fits[name] for name in ranked)).notes
        if "offset" in note
    ]


@pytest.mark.slow
def test_a_constant_force_is_compared_with_the_level_not_with_break_away():
    """It is reported from a quarter of the level: 2.2 N of 6 N, for any break-away force."""
    log = slow_log(
        find("stribeck")(F_C=6.0, F_S=12.0, v_S=2e-3, F_v=30.0, offset=2.2), duration=6.0
    )
    assert notes_of(
        identify(log, ["stribeck+asymmetry", "stribeck"], axis=STATED, blocks=0, draws=0),
        "stribeck+asymmetry",
        "stribeck",
    )


def test_break_away_by_direction_is_valid_with_the_offset():
    shape = {"v_S": 2e-3, "F_v_pos": 30.0, "F_v_neg": 30.0, "offset": 12.0}
    truth = find("stribeck+asymmetry")(F_C_pos=8.0, F_C_neg=6.0, F_S_pos=11.0, F_S_neg=9.0, **shape)
    fit = identify(
        slow_log(truth, duration=6.0), "stribeck+asymmetry", axis=STATED, blocks=0, draws=0
    ).best
    assert fit.with_constant == ("F_C_pos", "F_C_neg", "F_S_pos", "F_S_neg")
    (message,) = (text for text in warnings_of(fit) if "which bristle guessed" in text)
    assert "F_C_pos, F_C_neg, F_S_pos, F_S_neg are valid only with an offset of 1" in message
    judgement = judged(fit, DEFAULT)
    assert judgement.level != "usable"
    assert any("a guessed weight" in reason for reason in judgement.reasons)


@pytest.mark.parametrize(("offset", "told"), [(3.0, True), (0.6, False), (0.0, False)])
def test_a_constant_force_found_by_another_model_is_named(offset, told):
    log = slow_log(find("coulomb_viscous")(F_C=5.0, F_v=0.0, offset=offset), duration=6.0)
    split, plain = "coulomb_viscous+asymmetry", "coulomb_viscous"
    identification = identify(log, [split, plain], axis=STATED, blocks=0, draws=0)
    named = notes_of(identification, split, plain)
    assert bool(named) is told
    if told:
        assert re.search(
            r'coulomb_viscous identified offset = (3|2\.9).*offset = "(3|2\.9)\d*\.?\d* N" under \[plant\]',
            named[0],
        )
    assert notes_of(identification, plain, split) == notes_of(identification, split) == []


PITCH = 2.5e-3


def screw_log(**changes):
    motion = sines(10.0)
    angle = 2.0 * np.pi * motion.position / PITCH
    wave = 0.8 * np.cos(angle) - 0.5 * np.sin(angle)
    return log_of(motion, sliding_effort(motion, noise=0.2) + wave, **changes)


def test_the_pitch_is_found_and_the_wave_with_it():
    fit = identify(screw_log(), "coulomb_viscous+periodic", axis=STATED, blocks=0, draws=0).best
    assert fit.parameters["pitch"].value == pytest.approx(PITCH, rel=2e-3)
    known = identify(
        screw_log(),
        "coulomb_viscous+periodic",
        axis=replace(STATED, pitch=PITCH),
        blocks=0,
        draws=0,
    ).best
    assert known.parameters["pitch"].value == PITCH
    assert known.parameters["c_1"].value == pytest.approx(0.8, abs=0.03)
    assert known.parameters["s_1"].value == pytest.approx(-0.5, abs=0.03)
    assert known.parameters["F_C"].value == pytest.approx(TRUTH["F_C"], rel=0.02)
    assert {known.parameters[name].status for name in ("c_1", "s_1")} == {"identified"}


def test_the_pitch_of_a_level_that_reverses_with_the_motion_is_found():
    motion = sines(10.0)
    level = 0.8 * np.cos(2.0 * np.pi * motion.position / PITCH) * np.sign(motion.velocity)
    fit = identify(
        log_of(motion, sliding_effort(motion, noise=0.2) + level),
        "coulomb_viscous+ripple",
        axis=STATED,
        blocks=0,
        draws=0,
    ).best
    assert fit.parameters["pitch"].value == pytest.approx(PITCH, rel=2e-3)
    assert fit.parameters["h_c1"].value == pytest.approx(0.8, abs=0.05)


def test_a_search_fits_slots():
    fit = identify(
        screw_log(),
        "coulomb_viscous+periodic+position",
        axis=replace(STATED, pitch=PITCH),
        blocks=0,
        draws=0,
    ).best
    assert np.hypot(fit.parameters["c_1"].value, fit.parameters["s_1"].value) == pytest.approx(
        0.943, abs=0.05
    )
    for name in ("p_1", "p_2", "a_1", "a_2"):
        assert abs(fit.parameters[name].value) < 0.2, name


def test_a_range_of_less_than_three_turns_does_not_show_a_pitch():
    motion = sines(10.0, amplitudes=(2e-3, 0.0, 0.0))
    with pytest.raises(InputError, match="covers too few turns to find the pitch"):
        identify(
            log_of(motion, sliding_effort(motion)), "coulomb_viscous+periodic", cutoff=2.0, draws=0
        )


def test_the_share_of_the_range_goes_from_end_to_end():
    # Not about the zero of the axis, and in two parts, of which one has not been to the ends.
    motion = sines(6.0)
    aside = motion._replace(position=motion.position + 0.07)
    log = log_of(aside, sliding_effort(motion), segments=(slice(0, 1000), slice(1000, 6000)))
    fit = identify(log, "coulomb_viscous+position", axis=STATED, blocks=0, draws=0).best
    x_0, x_L = (fit.parameters[name].value for name in ("x_0", "x_L"))
    ends = (log.position.values.min(), log.position.values.max())
    assert [(x - x_0) / x_L for x in ends] == pytest.approx([-1.0, 1.0], abs=1e-3)


def test_a_wave_along_the_screw_has_the_position_of_the_samples():
    motion = sines(6.0, 2e-3, (0.02, 0.006), (0.5, 1.3), (0, 1))
    angle = 2.0 * np.pi * motion.position / PITCH
    log = log_of(
        motion, sliding_effort(motion, noise=0.0) + 0.8 * np.cos(angle) - 0.5 * np.sin(angle)
    )
    fit = identify(
        log,
        "coulomb_viscous+periodic",
        axis=Axis(pitch=PITCH, settings={"lines_gain": 1.0}),
        cutoff=200.0,
        decimation=1,
        blocks=0,
        draws=0,
    ).best
    assert fit.parameters["c_1"].value == pytest.approx(0.8, abs=3e-3)
    assert fit.parameters["s_1"].value == pytest.approx(-0.5, abs=3e-3)
    # At up to 110 mm/s half a sample is a quarter of a radian, and leaves 1 %.
    assert fit.force_error_percent < 0.1


@kernel
def trial(state, memory, motion, dt, p):
    ratio = motion.v / 4e-3
    share = decay(ratio * ratio)
    return (p.F_S * share + p.F_C * (1.0 - share)) * direction(motion.v), state


def two_levels(condition, holds, static=LEVEL, **changes):
    relations = (Relation(condition, holds, "Lower F_C"),)
    return own_model(
        trial, {"F_S": static, "F_C": LEVEL}, "two_levels", relations=relations, **changes
    )


@pytest.fixture(scope="module")
def rising():
    """A log of friction that rises with speed, against the relation F_S >= F_C."""
    return slow_log(
        friction.stribeck(F_C=8.0, F_S=5.0, v_S=4e-3, F_v=0.0, validate=False), duration=10.0
    )


@pytest.mark.parametrize("linear", [False, True])
def test_a_relation_is_satisfied_for_any_order_of_the_parameters(rising, linear):
    model = two_levels("F_S >= F_C", lambda p: p.F_S >= p.F_C, linear=linear)
    fit = identify(rising, model, axis=STATED, blocks=0, draws=0).best
    values = fit.friction.values
    assert values["F_S"] >= values["F_C"]
    assert values["F_S"] == pytest.approx(values["F_C"], rel=1e-3)
    assert model(**{name: values[name] for name in ("F_S", "F_C")}).values["F_C"] == values["F_C"]


def test_a_strict_relation_is_satisfied_with_a_margin(rising):
    model = two_levels("F_S > F_C", lambda p: p.F_S > p.F_C)
    values = identify(rising, model, axis=STATED, blocks=0, draws=0).best.friction.values
    assert values["F_S"] > 1.02 * values["F_C"]


def test_a_relation_with_one_directional_side_is_satisfied_in_both_directions(rising):
    model = slotted(
        two_levels("F_S >= F_C", lambda p: p.F_S >= p.F_C, replace(LEVEL, directional=True)),
        asymmetry=True,
    )
    values = identify(rising, model, axis=STATED, blocks=0, draws=0).best.friction.values
    assert min(values["F_S_pos"], values["F_S_neg"]) >= values["F_C"]


def test_a_relation_that_no_search_can_satisfy_is_rejected(rising):
    model = two_levels("F_C within F_S", lambda p: p.F_C <= p.F_S)
    with pytest.raises(InputError, match="has values that the model does not allow") as caught:
        identify(rising, model, axis=STATED, blocks=0, draws=0)
    assert caught.value.path == "model"
    assert "F_C within F_S" in caught.value.message
    assert "another model" in caught.value.mend


def test_a_model_with_an_impossible_relation_is_omitted_and_reported(rising):
    model = two_levels("F_C within F_S", lambda p: p.F_C <= p.F_S)
    identification = identify(rising, [model, "coulomb_viscous"], axis=STATED, blocks=0, draws=0)
    assert [fit.name for fit in identification.fits] == ["coulomb_viscous"]
    assert (
        "two_levels is omitted: the best fit of two_levels has values that the model does not allow"
        in identification.notes[-1]
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(
    "name",
    [
        "viscous",
        "coulomb_viscous+asymmetry",
        "stribeck",
        "stribeck+asymmetry",
        "dahl",
        "lugre",
        "lugre+asymmetry",
    ],
)
def test_an_identified_model_can_be_loaded(tmp_path, name):
    best = identify(sliding_log(F_v=-2.0), name, axis=STATED, blocks=0, draws=0).best
    write_model(tmp_path / "model.toml", best.plant, best.friction, estimates=best.estimates)
    assert read_model(tmp_path / "model.toml").friction.values == best.friction.values

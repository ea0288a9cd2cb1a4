"""Forces over the position that a log shows become lines of the axis, and the models are fitted with them."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from tests.identification.known_logs import log_of, sines, sliding_effort
from tests.identification.rigid import identify
from tests.identification.test_structure import WEIGHT, swinging, with_scatter

import bristle as br
from bristle.core import Axis, Diagnostic
from bristle.core.axis import KnownColumn
from bristle.files import axis_text, read_axis
from bristle.identification import HeldOut, ProposedLine, fits, intervals
from bristle.identification.axis_lines import axis_with, proposed_lines
from bristle.logs import Channel
from bristle.report.brief import brief
from bristle.report.messages import message, terms_in

AMPLITUDE, TURN = 5.0, 0.01
AXIS = Axis(seeks_delay=False, offset=0.0, resolution=1e-7)


@pytest.fixture(scope="module")
def cogged():
    """A log of a sliding axis with cogging of one period per turn."""
    motion = sines(12.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    ripple = AMPLITUDE * np.sin(2.0 * np.pi * motion.position / TURN + 1.0)
    return log_of(motion, sliding_effort(motion, 0) + ripple, step=1e-7)


@pytest.fixture(scope="module")
def taken(cogged):
    return br.identify(cogged, "coulomb_viscous", axis=AXIS, draws=0)


@pytest.fixture
def fitted(monkeypatch):
    """The names of the fitted models, in order."""
    names, original = [], fits.fit
    monkeypatch.setattr(
        fits,
        "fit",
        lambda context, model, *rest: names.append(model.name) or original(context, model, *rest),
    )
    return names


def test_cogging_is_taken_with_its_amplitude_and_the_held_out_error_falls(taken, cogged):
    single = identify(
        cogged, "coulomb_viscous", axis=AXIS, draws=0, settings={"lines_gain": 1.0}
    ).best
    assert taken.best.held_out.mean_percent < 0.6 * single.held_out.mean_percent
    second = taken.second_pass
    assert second.taken
    assert second.error_with < 0.6 * second.error_without
    wave = np.hypot(*(taken.parameters[name].value for name in ("motor_1_cos", "motor_1_sin")))
    assert wave == pytest.approx(AMPLITUDE, rel=0.1)
    assert taken.axis.cogging[0].turn == pytest.approx(TURN, rel=2e-3)
    assert not any(diagnostic.code == "missing_ripple" for diagnostic in taken.best.diagnostics)


def test_result_and_summary_state_both_errors_and_the_lines(taken):
    second, text = taken.second_pass, terms_in(taken.best)
    assert text.startswith(("bristle took cogging (turn 10", "bristle took cogging (turn 9.99"))
    assert f"{second.error_with:.3g} % instead of {second.error_without:.3g} %" in text
    assert '`turn = "motor"` and `harmonics = [1]` under `[[cogging]]`' in text
    assert text in [line.text for line in brief(taken, None, None)]
    proposals = [
        entry for entry in taken.outcome.summary["proposals"] if entry["section"] == "cogging"
    ]
    assert {entry["key"] for entry in proposals} == {"turner", "harmonics", "travel"}
    for entry in proposals:
        assert entry["taken"] is True
        assert (entry["error_without"], entry["error_with"]) == (
            second.error_without,
            second.error_with,
        )


def test_the_written_axis_file_has_the_lines_and_has_nothing_to_add(taken, cogged, fitted):
    again = identify(
        cogged, "coulomb_viscous", axis=read_axis(axis_text(taken.axis, cogged)), draws=0
    )
    assert (again.second_pass, fitted) == (None, ["coulomb_viscous"])
    assert again.best.held_out.mean_percent == pytest.approx(
        taken.best.held_out.mean_percent, rel=1e-6
    )


@pytest.mark.parametrize("gain", [0.99, 1.0])
def test_lines_whose_gain_is_not_enough_are_not_taken(cogged, fitted, gain):
    settings = {"lines_gain": gain}
    result = identify(cogged, "coulomb_viscous", axis=AXIS, draws=0, settings=settings)
    assert (result.second_pass, fitted) == (None, ["coulomb_viscous"])


def test_lines_are_taken_without_held_out_blocks(cogged):
    result = identify(cogged, "coulomb_viscous", axis=AXIS, draws=0, blocks=0)
    assert result.second_pass.taken


def test_a_log_without_a_missing_force_is_fitted_once(fitted):
    motion = sines(4.0)
    assert (
        identify(
            log_of(motion, sliding_effort(motion)), "coulomb_viscous", axis=AXIS, draws=0
        ).second_pass
        is None
    )
    assert fitted == ["coulomb_viscous"]


@pytest.mark.slow
def test_intervals_are_computed_once_for_the_returned_result(cogged, monkeypatch):
    seen, original = [], intervals.with_uncertainty
    monkeypatch.setattr(
        intervals,
        "with_uncertainty",
        lambda fit, *rest: seen.append(fit.plant.values) or original(fit, *rest),
    )
    axis = replace(AXIS, method="inverse_dynamics")
    shares = list[float]()
    result = identify(
        cogged,
        "coulomb_viscous",
        axis=axis,
        draws=20,
        progress=lambda share, _: shares.append(share),
    )
    assert [list(values) for values in seen] == [list(result.best.plant.values)]
    assert "motor_1_sin" in seen[0]
    assert "motor_1_sin" in result.best.resampling.bands.draws
    assert shares[-1] == 1.0


@pytest.mark.slow
def test_gravity_of_a_link_is_taken():
    motion = swinging(6.0)
    effort = with_scatter(motion, 0.0 * motion.position, share=0.0) + WEIGHT * np.sin(
        motion.position - 0.4
    )
    axis = Axis(kind="rotational", seeks_delay=False, offset=0.0, resolution=1e-6)
    result = identify(
        log_of(motion, effort, step=1e-6, kind="rotational"),
        "coulomb_viscous",
        axis=axis,
        blocks=2,
        draws=0,
        by=br.identify,
    )
    assert result.axis.gravity
    assert np.hypot(
        result.parameters["g_sin"].value, result.parameters["g_cos"].value
    ) == pytest.approx(WEIGHT, rel=0.04)
    assert "the gravity of a link" in terms_in(result.best)


def test_a_joint_with_the_bodies_of_an_arm_has_no_second_gravity():
    motion = swinging(6.0)
    bodies = 0.3 * WEIGHT * np.sin(2.0 * motion.position)
    effort = (
        with_scatter(motion, 0.0 * motion.position, share=0.0)
        + WEIGHT * np.sin(motion.position - 0.4)
        + bodies
    )
    log = replace(
        log_of(motion, effort, step=1e-6, kind="rotational"),
        regressors=(Channel(bodies, "1", "arm"),),
    )
    known = KnownColumn("arm", "arm", coefficient=1.0, log="0" * 64)
    axis = Axis(
        kind="rotational", seeks_delay=False, offset=0.0, resolution=1e-6, regressors=(known,)
    )
    result = identify(log, "coulomb_viscous", axis=axis, draws=0, by=br.identify)
    codes = [diagnostic.code for diagnostic in result.best.diagnostics]
    assert "bodies_differ" in codes
    assert "missing_gravity" not in codes
    assert not result.axis.gravity
    assert "identify the arm again" in message(
        result.best.diagnostics[codes.index("bodies_differ")]
    )


@dataclass(frozen=True)
class Fit:
    """What of a fit proposes and judges lines."""

    held_out: HeldOut | None = None
    diagnostics: tuple = ()


def proposing(*diagnostics):
    return Fit(diagnostics=diagnostics)


COGGING = (
    ProposedLine("cogging", "turner", "screw", "second_pass"),
    ProposedLine("cogging", "harmonics", (1, 2), "second_pass"),
    ProposedLine("cogging", "travel", 0.01, "second_pass"),
)
GRAVITY = ProposedLine("plant", "gravity", "link", "second_pass")
WEIGHT_GUESSED = Diagnostic("weight_guessed", numbers={"weight": -19.0})


def test_lines_are_applied():
    (weight,) = proposed_lines(proposing(WEIGHT_GUESSED), Axis())
    axis = axis_with(Axis(), (*COGGING, GRAVITY, weight))
    (cogging,) = axis.cogging
    assert (cogging.turner, cogging.turn, cogging.harmonics) == ("screw", 0.01, (1, 2))
    assert (axis.offset, axis.gravity) == (-19.0, True)
    assert proposed_lines(proposing(WEIGHT_GUESSED), axis) == ()


def test_a_stated_offset_of_zero_is_kept():
    assert proposed_lines(proposing(WEIGHT_GUESSED), Axis(offset=0.0)) == ()


PLAIN = """# my axis
schema = 1
kind = "translational"
[columns]
position = { column = "x", unit = "m" }
[plant] # known
mass = 3.0
"""


# Without a lead, the turning part is the motor.
@pytest.mark.parametrize(("turner", "lead"), [("screw", "7 mm"), ("motor", "")])
def test_lines_enter_the_text_of_an_axis_file_and_keep_its_comments(turner, lead):
    axis = read_axis((PLAIN + (f'[transmission]\nlead = "{lead}"\n' if lead else "")).encode())
    weight = proposed_lines(proposing(WEIGHT_GUESSED), axis)
    of_turner = COGGING[0]._replace(value=turner)
    travel = COGGING[2]._replace(value=axis.pitch or 0.007)
    changed = axis_with(axis, (of_turner, COGGING[1], travel, *weight))
    text = axis_text(changed)
    assert read_axis(text) == changed
    assert text.startswith(b"# my axis")
    assert text.count(b"[plant]") == text.count(b"[transmission]") == 1


def test_an_axis_file_in_another_notation_is_written_anew():
    text = PLAIN.replace("[plant] # known\nmass = 3.0\n", "").replace(
        "[columns]", 'plant = { mass = 3.0, offset = "identify" }\n[columns]'
    )
    axis = read_axis(text.encode())
    changed = axis_with(axis, proposed_lines(proposing(WEIGHT_GUESSED), axis))
    written = axis_text(changed)
    assert read_axis(written) == changed
    assert (changed.offset, changed.mass) == (-19.0, 3.0)


@pytest.mark.slow
def test_a_spring_is_not_taken_for_gravity():
    motion = swinging()
    noise = 0.5 * np.random.default_rng(3).normal(size=motion.time.size)
    effort = (
        with_scatter(motion, 0.0 * motion.position, share=0.0)
        + WEIGHT * (motion.position + 0.3 * motion.position**3)
        + noise
    )
    axis = Axis(kind="rotational", seeks_delay=False, offset=1.5, resolution=1e-6)
    result = identify(
        log_of(motion, effort, step=1e-6, kind="rotational"),
        "coulomb_viscous",
        axis=axis,
        draws=0,
        by=br.identify,
    )
    assert [line.key for line in result.second_pass.lines] == ["spring"]
    assert result.parameters["spring_3"].value == pytest.approx(0.3 * WEIGHT, rel=0.03)

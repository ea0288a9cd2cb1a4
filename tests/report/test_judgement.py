"""The verdict of an identification, and the first page that it stands on."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.known_logs import TRUTH, log_of, sines, sliding_effort, sliding_log

from bristle.core.diagnostic import Diagnostic
from bristle.core.symbols import symbolic
from bristle.identification import identify
from bristle.identification.settings import Settings
from bristle.prediction.drive_table import level_values
from bristle.prediction.following import Following
from bristle.report.identification import answers
from bristle.report.judgement import DOUBTS, WRITTEN_BY, judged
from bristle.report.messages import warnings_of
from bristle.report.page import worded
from bristle.report.sentences import SENTENCES
from bristle.simulation.result import statistics_of

USUAL = Settings()


@pytest.fixture(scope="module")
def actual():
    return identify(sliding_log(), "coulomb_viscous", draws=0, blocks=3)


def doubted(fit, *diagnostics):
    return replace(fit, diagnostics=diagnostics)


def test_a_sound_log_is_usable(actual):
    assert judged(actual.best, USUAL) == ("usable", "Usable", ())


@pytest.mark.parametrize("code", DOUBTS)
def test_every_doubt_asks_for_care_and_says_why(actual, code):
    level, _, reasons = judged(doubted(actual.best, Diagnostic(code, severity="warning")), USUAL)
    assert level == "with_care"
    assert reasons == (SENTENCES[code].means,)


def test_a_note_asks_for_nothing(actual):
    assert judged(doubted(actual.best, Diagnostic("structure", severity="note")), USUAL).level == "usable"


def test_a_contradiction_asks_for_another_log(actual):
    level, _, reasons = judged(doubted(actual.best, Diagnostic("sign_reversed", severity="error")), USUAL)
    assert level == "measure_again"
    assert reasons == (SENTENCES["sign_reversed"].means,)


def test_open_parameters_ask_for_care_and_half_of_them_for_another_log(actual):
    fit = doubted(actual.best)
    levels = []
    for count in range(len(fit.estimates) + 1):
        open_ = [replace(estimate, status="unidentifiable") for estimate in fit.estimates[:count]]
        levels.append(judged(replace(fit, estimates=(*open_, *fit.estimates[count:])), USUAL).level)
    assert levels == ["usable", "with_care", "measure_again", "measure_again", "measure_again"]


def test_nothing_is_typed_in_where_the_axis_is_to_be_measured_again(actual):
    reversed_ = doubted(actual.best, Diagnostic("sign_reversed", severity="error"))
    again = dict(answers(replace(actual, fits=(reversed_,)), None, None, usable=False))
    assert again["What to type in"][0] == "nothing yet: measure again first"
    assert again["What next"] == [SENTENCES["sign_reversed"].advice]
    assert not any("nothing yet" in line for line in dict(answers(actual, None, None))["What to type in"])


def test_parameters_that_one_motion_serves_share_its_line(actual, monkeypatch):
    by_excite = [(name, f"Move slowly.{WRITTEN_BY}`bristle excite AXIS.toml --for stribeck`") for name in ("F_S", "v_S")]
    monkeypatch.setattr("bristle.report.identification.next_measurements", lambda fit: by_excite)
    message = dict(answers(actual, None, None))["What next"]
    assert message == ["for F_S, v_S: `bristle excite AXIS.toml --for stribeck`, which writes the motion"]


def test_the_error_that_friction_takes_decides(actual):
    error = actual.best.friction_alone_error_percent
    for usable, useless, level in ((1.1, 2.0, "usable"), (0.9, 2.0, "with_care"), (0.5, 0.9, "measure_again")):
        settings = Settings.of({"usable_error": usable * error, "useless_error": useless * error})
        assert judged(doubted(actual.best), settings).level == level


def test_a_loop_that_follows_otherwise_asks_for_care(actual):
    nothing = statistics_of(np.zeros(2))
    following = Following(np.zeros(2), np.zeros(2), nothing, contradiction=Diagnostic("loop_contradicts"))
    assert judged(doubted(actual.best), USUAL, following).level == "with_care"


def test_levels_are_those_of_each_direction_without_the_weight():
    motion = sines(20.0, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    effort = sliding_effort(motion, F_C=8.0) + np.where(motion.velocity > 0.0, 1.5, 0.0) + 20.0
    levels = level_values(identify(log_of(motion, effort), "coulomb+asymmetry", draws=0, offset=20.0).best)
    viscous = TRUTH["F_v"] * np.max(np.abs(motion.velocity))
    assert levels.constant == 20.0
    assert levels.inertia == pytest.approx(TRUTH["M"], rel=0.01)
    assert levels.forward - levels.backward == pytest.approx(1.5 + 2.0 * TRUTH["offset"], abs=0.25)
    assert 8.0 < levels.backward + TRUTH["offset"] < 8.0 + viscous
    assert levels.deviation == pytest.approx(0.0, abs=1e-9)


def test_the_five_questions_are_answered(actual, monkeypatch):
    monkeypatch.setattr("bristle.report.identification.next_measurements", lambda fit: [("F_S", "move slowly")])
    message = dict(answers(actual, None, None))
    assert list(message) == ["Is it good?", "What to type in", "What it gains, and costs", "Can it be trusted?", "What next"]
    assert all(message.values())
    mass = actual.best.parameters["M"]
    assert message["What to type in"][0] == f"mass {mass.value:.3g}\u00a0kg"
    assert f"M ± {mass.interval_percent:.2g}\u00a0%" in message["Can it be trusted?"][1]
    assert message["What next"] == ["for F_S: move slowly"]
    assert "effective" not in " ".join(message["Can it be trusted?"])


def test_what_was_not_identified_is_not_to_be_typed_in(actual):
    fit = actual.best

    def typed(*names):
        estimates = tuple(replace(estimate, status="unidentifiable") if estimate.name in names else estimate for estimate in fit.estimates)
        return dict(answers(replace(actual, fits=(replace(fit, estimates=estimates),)), None, None))["What to type in"]

    assert typed("M")[0] == "mass: not identified"
    assert typed(*fit.parameters) == ["nothing: no parameter was identified"]


def test_an_error_is_told_before_what_follows_from_it(actual):
    fit = doubted(actual.best, Diagnostic("delay_unknown", severity="warning"), Diagnostic("sign_reversed", "", "error", {"percent": 73.0}))
    assert "sign of effort" in warnings_of(fit)[0]


@pytest.mark.parametrize(
    ("text", "symbol"),
    [
        ("F_C_neg", "<i>F</i><sub>C\u2212</sub>"),
        ("sigma_0", "<i>σ</i><sub>0</sub>"),
        ("`F_S`", "`F_S`"),
        ("stribeck_free", "stribeck_free"),
        ("a < b", "a &lt; b"),
        ("M ± 2 %", "<i>M</i> ± 2 %"),
        ("F+ 30 N", "<i>F</i><sub>+</sub> 30 N"),
    ],
)
def test_names_of_parameters_are_symbols(text, symbol):
    assert symbolic(text) == symbol


def test_what_is_to_be_typed_is_left_as_it_is_typed():
    assert worded('F_C: `F_C = "2 N*m"`, not 2 N*m < 3') == ("<i>F</i><sub>C</sub>: <code>F_C = &#34;2 N*m&#34;</code>, not 2 N·m &lt; 3")

"""Which of the texts of a code is told follows from its numbers."""

import pytest

from bristle.core.diagnostic import Diagnostic
from bristle.report.messages import clause, message
from bristle.report.sentences import SENTENCES
from bristle.report.sentences.loops import counted
from bristle.report.sentences.sentence import Sentence, cause, held, says, where

SPEEDS = {"slow_samples": 1, "samples": 9, "speed": 2e-3}
ZONE = {"zone": 1e-5, "samples": 3.0, "filter_samples": 8.0}
RIPPLE = {"period": 5e-3, "amplitude": 2.0, "percent": 12.0, "compared": "", "model": ""}
MOTORS = {"pulls": "alike", "harmonics": (1.0, 2.0), "turner": "motor", "travel": 5e-3}
FORCE = {"force": 2.0, "percent": 12.0, "share_percent": 50.0, "compared": "", "model": ""}
FILTER = {"cutoff": 60.0, "dropped": 5, "decimation": 1}
LOOP = {"radius": 1.2, "why": "gains"}
MARGIN = {"phase": 15.0, "enough": 30.0, "motions": "all"}
FOLLOWS = {"simulated": 2e-6, "simulated_rms": 1e-6, "measured": 4e-6, "measured_rms": 3e-6, "suspects": (), "factors": ()}
STRUCTURE = {"missing": 2.0, "percent": 12.0, "chance": 0.1, "names": (), "small": False, "causes": ()}
RISE = {"first": 1.0, "level": 2.0, "speed": 0.01}
DELAY = {"delay": 1e-3, "samples": 1.0, "half_width": 1e-5}

# A code, its numbers, and the words that only this one of its texts has.
CHOSEN = [
    ("resampled", {"column": "u", "own_sample_time": 1e-3, "sample_time": 1e-2, "percent": 9.0, "error_percent": 1.0}, "column u was"),
    ("resampled", {"percent": 9.0, "largest": 20.0, "sample_time": 1e-3, "position_error": 1e-6}, "errs by about 1 µm in the position ("),
    ("resampled", {"percent": 9.0, "largest": 20.0, "sample_time": 1e-3, "position_error": 1e-6, "effort_error": 2.0}, "and 2 N in the"),
    ("velocity_contradicts", {"delay": 2e-3, "ratio": 1.0, "correlation": 0.9}, "is 2 ms later than that"),
    ("velocity_contradicts", {"delay": 0.0, "ratio": 1.5, "correlation": 0.9}, "is 1.5 times that of the position"),
    ("resolution_contradicts", {"step": 1e-6, "times": 57.3, "resolution": 1e-6, "degrees": True}, "57.3 is degrees"),
    ("clipped", {"level": 9.0, "samples": 5, "time": 1.0, "all": 7, "names": ("M",)}, "; M make up for"),
    ("one_direction", {"direction": "forward", "percent": 0.05}, "for no more than 0.1 % of its way"),
    (
        "one_direction",
        {"direction": "forward", "percent": 0.04, "names": ("F_C",)},
        "moves forward only: a constant force and friction are one",
    ),
    ("one_speed", {"slowest": 0.01, "fastest": 0.02}, "one speed, 10 mm/s to 20 mm/s: move"),
    ("one_speed", {"slowest": 0.01, "fastest": 0.010001, "names": ("F_C",)}, "one speed, 10 mm/s: move"),
    ("few_cycles", {"cycles": 3}, "one side has only 3 cycles"),
    ("few_cycles", {"cycles": ""}, "one cycle tells no scatter"),
    ("friction_not_told", {"why": ""}, "friction is not told: no speed"),
    ("friction_not_told", {"why": "no filter"}, "friction is not told: no filter"),
    ("rising_friction", RISE | {"direction": ""}, "over the first 10 mm/s: no Stribeck"),
    ("rising_friction", RISE | {"direction": "backward"}, "over the first 10 mm/s, moving backward: no Stribeck"),
    ("filtered", FILTER | {"percent": 3.0, "decimation": 4}, "one row for 4 samples has hardly any"),
    ("filtered", FILTER | {"wanted": 60.0}, "sampled too slowly"),
    ("filtered", FILTER, "5 samples dropped at each edge, a row for each sample"),
    ("filtered", FILTER | {"decimation": 4}, "5 samples dropped at each edge, one row for 4 samples"),
    ("filtered", {"cutoff": 60.0, "decimation": 1}, "effort and motion are filtered at 60 Hz"),
    ("filtered", {"cutoff": 60.0, "decimation": 4}, "effort and motion are filtered at 60 Hz, and one row is kept for 4 samples"),
    ("delay_found", DELAY, "the effort lags the position by 1 ms (1.00 samples; 95 % interval ±10 µs)"),
    ("delay_found", DELAY | {"delay": 0.0, "samples": 0.0}, "the effort lags the position by 0 s"),
    ("delay_found", DELAY | {"delay": -6e-4, "samples": -0.6}, "(0.60 samples, as where a controller holds"),
    ("delay_found", DELAY | {"delay": -4e-4, "samples": -0.4}, "(0.40 samples, as where a controller holds"),
    ("delay_found", DELAY | {"delay": -6.1e-4, "samples": -0.61}, "ahead of the position by 610 µs (0.61 samples; 95 %"),
    ("delay_rough", DELAY, "lags the position by 1 ms (1.0 samples"),
    ("delay_rough", DELAY | {"delay": 0.0, "samples": 0.0}, "lags the position by 0 s (0.0 samples"),
    ("delay_rough", DELAY | {"delay": -2e-3, "samples": -2.0}, "runs ahead of the position by 2 ms (2.0"),
    ("delay_or_filter", {"delay": 1e-3, "names": ("M", "F_v")}, "taken out as a delay. M and F_v depend on it"),
    ("filter_suspect", {"lag": 1e-3, "channel": "effort"}, "effort passed a filter of 1 ms more than position"),
    ("filter_suspect", {"lag": 1e-3, "channel": "position"}, "position passed a filter of 1 ms more than effort"),
    ("filter_suspect", {"lag": 1e-3, "channel": "command"}, "the recorded effort is a command"),
    ("rests", {"percent": 3.0}, "3 % of the samples are at rest"),
    ("rests", {"resolution": 1e-6}, "encoder steps of 1 µm; all"),
    ("worse_than_none", {"percent": 120.0, "signal": "position"}, "a position of zero would be nearer"),
    ("worse_than_none", {"percent": 120.0, "signal": "effort"}, "an effort of zero would be nearer"),
    ("start_of_contact", {"percents": (10.0, -20.0)}, "began at 10 %, −20 % of the way"),
    ("start_of_contact", {"periods": 1}, "the log is one period"),
    ("start_of_contact", {"periods": 3}, "the log is 3 equal periods"),
    ("start_of_contact", {}, "the motion begins at rest"),
    ("loop_diverges", LOOP | {"largest_gain_percent": 50.0}, "stable with its gains at 50 % at most"),
    ("loop_diverges", LOOP | {"longest_delay": 2}, "gains too high for the sample time. It is stable with two samples of delay at most"),
    ("loop_diverges", LOOP | {"longest_delay": 0, "largest_gain_percent": 50.0}, "with no samples of delay or with its gains at 50"),
    ("loop_diverges", LOOP, "Look at the signs of its gains"),
    ("loop_diverges", LOOP | {"mend": "raise_gains", "longest_delay": 2}, "Raise the gains or feed the friction forward"),
    ("loop_oscillates", LOOP | {"motions": "small"}, "oscillates: for small motions the sampled"),
    ("loop_oscillates", LOOP | {"motions": "small"}, "What is a small motion grows"),
    ("loop_oscillates", LOOP | {"motions": "large"}, "It does not settle there. Look"),
    ("small_margin", MARGIN, "the phase margin is 15° (at least 30° is usual): what excites"),
    ("small_margin", MARGIN | {"gain": 1.5}, "is usual), 1.50 times the gain makes it unstable"),
    ("loop_contradicts", FOLLOWS, "its following error is 2 µm peak to peak"),
    ("loop_contradicts", FOLLOWS, "No one number explains it"),
    ("loop_contradicts", {name: FOLLOWS[name] for name in FOLLOWS if "sim" not in name}, "runs away, and the axis did not"),
    ("no_fall", SPEEDS | {"slowest": 0.01, "fastest": 0.02}, "slides steadily at 10 mm/s to 20 mm/s)"),
    ("no_fall", SPEEDS | {"slowest": 0.01, "fastest": 0.010001}, "slides steadily at 10 mm/s)"),
    ("no_fall", SPEEDS, "none of its motion is a slide"),
    ("few_reversals", {}, "the log has no reversal"),
    ("few_reversals", {"reversals": 1}, "the log has only 1 reversal"),
    ("few_reversals", {"reversals": 2}, "the log has only 2 reversals"),
    ("few_reversals", ZONE | {"reversals": 1}, "the log has only 1 reversal, each crosses"),
    ("few_reversals", ZONE | {"reversals": 20}, "the log has only 20 reversals, each crosses"),
    ("few_reversals", ZONE | {"reversals": 21}, "each of 21 reversals crosses"),
    ("few_reversals", ZONE | {"reversals": 21, "samples": 8.0}, "its reversals (21) cross"),
    ("few_strokes", {"reversals": 2, "stroke": 0.1}, "the log holds 2 reversals"),
    ("few_strokes", {"stroke": 0.1}, "does not show the force bend"),
    ("structure", STRUCTURE, "does not hold: 2 N"),
    ("structure", STRUCTURE | {"small": True, "names": ("M",)}, "leaves a small force: 2 N"),
    ("structure", STRUCTURE | {"names": ("M", "F_C")}, "Parameters are effective: M, F_C hold"),
    ("missing_speed", FORCE, "no model of bristle has another one"),
    ("missing_speed", FORCE | {"model": "lugre"}, "Next: `lugre`"),
    ("missing_speed", FORCE | {"model": "stribeck_free"}, "`stribeck_free`, of which the exponent"),
    ("missing_speed", FORCE | {"compared": "lugre", "model": "x"}, "`lugre`, which was compared, is no better"),
    ("missing_play", FORCE | {"ratio": 3.0, "model": "x"}, "3 times as large where"),
    ("missing_direction", FORCE | {"compared": "x"}, "`x`, which was compared, is no better"),
    ("missing_direction", FORCE, "a set of parameters for each already"),
    ("missing_ripple", RIPPLE, "as cogging or a screw does; this model has one period already"),
    ("missing_ripple", RIPPLE | {"model": "x"}, "as cogging or a screw does. Next: `x`"),
    ("missing_ripple", RIPPLE | {"compared": "x"}, "as cogging or a screw does. `x`, which was compared"),
    ("missing_ripple", RIPPLE | {"pulls": "turning", "model": "x"}, "with the turns of a screw. Next: `x`"),
    ("missing_ripple", RIPPLE | {"pulls": "turning", "compared": "x"}, "with the turns of a screw. `x`, which"),
    ("missing_ripple", RIPPLE | MOTORS, 'harmonics = [1, 2]` into the axis file, and `lead = "5.000 mm"` under'),
    ("missing_ripple", RIPPLE | MOTORS | {"turner": "load", "model": "x"}, "into the axis file; or `x`"),
    ("missing_ripple", RIPPLE | MOTORS | {"turner": "load", "compared": "x"}, "into the axis file. `x`, which"),
]


@pytest.mark.parametrize(("code", "numbers", "words"), CHOSEN, ids=[f"{code} {place}" for place, (code, *_) in enumerate(CHOSEN)])
def test_the_text_of_a_code_follows_the_numbers(code, numbers, words):
    assert words in clause(Diagnostic(code, "F_C", "note", numbers))


def test_absent_numbers_leave_their_clauses_out():
    assert "make up" not in clause(Diagnostic("clipped", "", "note", {"level": 9.0, "samples": 5, "time": 1.0, "all": 7}))
    numbers = {"step": 1e-6, "times": 2.0, "resolution": 1e-6, "degrees": False}
    assert "57.3" not in clause(Diagnostic("resolution_contradicts", "", "note", numbers))
    assert "depend on it" not in clause(Diagnostic("delay_or_filter", "", "note", {"delay": 1e-3, "names": ()}))
    assert "at most" not in clause(Diagnostic("loop_diverges", "", "note", LOOP | {"longest_delay": 0}))
    assert "effective" not in clause(Diagnostic("structure", "", "note", STRUCTURE))


def test_each_suspect_of_a_loop_has_the_own_factor():
    numbers = FOLLOWS | {"suspects": ("k_p", "delay", "reference_later"), "factors": (1.2, 2, 3e-3)}
    assert clause(Diagnostic("loop_contradicts", "", "note", numbers)).endswith(
        "It would follow as recorded with the position gain 1.20 times as large as the axis file says or a delay of two samples in the "
        "loop or a reference that acts 3 ms later than it is recorded"
    )


def test_intervals_of_a_loop_are_reported_with_the_steps_in_the_loop():
    numbers = {"draws": 20, "noise": 1.0, "resolution": 1e-6, "scatter_percent": 2.0, "half_cycles": 30, "unexplained": 0.5}
    assert "noise of 1 N, encoder steps of 1 µm, friction" in clause(Diagnostic("intervals", "", "note", numbers))
    assert "encoder steps of 1 µm in the loop, friction" in clause(Diagnostic("intervals", "", "note", numbers | {"loop": True}))


def test_a_reason_ends_with_the_standard_error_where_known():
    sure = Diagnostic("low_speed", "F_v", "warning", {"speed": 0.5})
    unsure = Diagnostic("low_speed", "F_v", "warning", {"speed": 0.5, "std_percent": 40.0})
    assert message(sure) == "F_v cannot be identified: the log never exceeds 500 mm/s"
    assert message(unsure) == message(sure) + "; standard error 40 %, with residuals correlated over time"


@pytest.mark.parametrize(
    ("numbers", "text"),
    [({"a": 1}, "first"), ({"a": 0}, "first"), ({"a": None, "b": 2}, "second"), ({"a": "", "b": ()}, "last"), ({}, "last")],
)
def test_the_first_number_that_is_there_chooses_the_text(numbers, text):
    assert where("a", "b")(("first", "second", "last"), numbers) == text


def test_short_forms_are_sentences_of_their_kind():
    assert says("a", "b") == Sentence(("a",), "b", "nothing")
    assert held("a", "b", "c") == Sentence(("a",), "b", "c", "parameter")
    assert held("a", "b").advice == "nothing"
    reason = cause("means", "advice", "text")
    assert (reason.means, reason.advice, reason.about, reason.texts[0]) == ("means", "advice", "parameter", "text")
    assert reason.template({}) == "text"


@pytest.mark.parametrize(
    ("count", "words"), [(0, "no samples"), (1, "one sample"), (2, "two samples"), (10, "ten samples"), (11, "11 samples")]
)
def test_samples_are_counted_in_words_up_to_ten(count, words):
    assert counted(count) == words


def test_a_refused_loop_has_a_cause_for_each_reason():
    assert SENTENCES["loop_diverges"].also == SENTENCES["loop_oscillates"].also
    assert "one sample of delay" in clause(Diagnostic("loop_diverges", "", "note", LOOP | {"why": "delay", "delay": 1}))

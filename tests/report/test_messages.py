"""Every diagnostic has a sentence with its numbers, and every sentence has a diagnostic."""

import ast
import pickle
import re
from functools import cache
from pathlib import Path
from string import Formatter
from types import SimpleNamespace

import pytest
from tests.identification.known_logs import STATED, log_of, sines, sliding_effort, slow_log
from tests.report import known

import bristle
from bristle import friction
from bristle.core.diagnostic import Diagnostic
from bristle.core.dimensions import exponents_of
from bristle.identification import identify
from bristle.identification.result import LACKING
from bristle.report.messages import (
    _Words,
    as_data,
    assumptions_of,
    clause,
    fields_of,
    message,
    note_of,
    notes_of,
    picked,
    warnings_of,
    whole_sentence,
    why_effective,
)
from bristle.report.sentences import SENTENCES, loops
from bristle.report.sentences.sentence import Sentence, cause, held, says, where

PACKAGE = Path(bristle.__file__).parent
# Filled in by what writes the sentence, not by what makes the diagnostic.
WRITTEN = {"cause"}


@cache
def trees():
    """The text of every file of the package."""
    return {file: ast.parse(file.read_text(encoding="utf-8")) for file in PACKAGE.rglob("*.py")}


def calls():
    """Every call of the package that creates a diagnostic or the reason of a constant parameter."""
    for file, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, (ast.Name, ast.Attribute)):
                name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
                place = {"Diagnostic": 0, "Fixed": 1}.get(name)
                if place is not None and len(node.args) > place:
                    yield file, node.args[place]


def strings():
    """Every string of the package outside the sentences."""
    return {
        node.value
        for file, tree in trees().items()
        if file.parent.name != "sentences"
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


@pytest.mark.slow
def test_codes_and_sentences_match():
    made = {item.value for _, item in calls() if isinstance(item, ast.Constant)}
    assert len(made) >= 40
    assert made <= set(SENTENCES)
    assert set(SENTENCES) <= strings()


def test_codes_are_lower_case_identifiers_with_a_meaning():
    for code, item in SENTENCES.items():
        assert re.fullmatch(r"[a-z]+(_[a-z]+)*", code), code
        assert all((item.means, item.advice)), code


@pytest.fixture(scope="module")
def fits():
    motion = sines(10.0, amplitudes=(2e-4,), frequencies=(0.5,), phases=(0.0,))
    slow = log_of(motion, sliding_effort(motion, noise=3.0))
    flat = slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0))
    result = identify(
        slow, "coulomb_viscous,lugre,bouc_wen_classic", axis=STATED, blocks=0, draws=20
    ).fits
    return (*result, *identify(flat, "stribeck", axis=STATED, draws=0).fits)


@pytest.mark.slow
def test_diagnostics_have_the_numbers_of_their_sentences(fits):
    seen = set()
    for item in (each for fit in fits for each in fit.diagnostics):
        needed = (
            {
                name
                for _, name, _, _ in Formatter().parse(SENTENCES[item.code].template(item.numbers))
                if name
            }
            - {"parameter"}
            - WRITTEN
        )
        if "cause" not in item.numbers:
            assert needed <= set(item.numbers), item
            assert set(item.numbers) - set(fields_of(item.code)) <= {
                "value",
                "unit",
                "std_percent",
                "slowest",
                "fastest",
                "direction",
            }, item
        seen.add(item.code)
    assert {
        "low_speed",
        "low_acceleration",
        "filtered",
        "intervals",
        "held_default",
        "redundant",
    } <= seen


@pytest.mark.slow
def test_diagnostic_survives_pickle_and_json_has_its_sentence(fits):
    every = fits[0].diagnostics
    assert pickle.loads(pickle.dumps(every)) == every
    data = as_data(every)
    assert [item["message"] for item in data if item["severity"] == "warning"] == list(
        warnings_of(fits[0])
    )
    assert all(
        set(item) == {"code", "parameter", "severity", "numbers", "message"} for item in data
    )


def test_units_follow_the_kind_of_axis():
    turning = Diagnostic("low_speed", "F_v", numbers={"speed": 2.0}, kind="rotational")
    assert (
        message(turning)
        == f"F_v cannot be identified: {clause(turning)}"
        == "F_v cannot be identified: the log never exceeds 2 rad/s"
    )
    assert all(
        exponents_of(spec) for spec in fields_of("few_reversals").values() if "length" in spec
    )


@pytest.mark.slow
def test_redundant_parameter_is_held_constant_and_not_identified(fits):
    fit = next(diagnostic for diagnostic in fits if diagnostic.name == "bouc_wen_classic")
    text = [message(diagnostic) for diagnostic in fit.diagnostics if diagnostic.code == "redundant"]
    assert [diagnostic.split(":")[0].split(" at ")[0] for diagnostic in text] == [
        "parameter beta cannot be identified",
        "parameter beta is held constant",
    ]
    assert note_of(fit.parameters["beta"]) in text[0]


def test_edge_names_its_cause():
    cause = {"cause": "low_speed", "speed": 0.5, "value": 1.0, "unit": "N", "edge": "largest"}
    text = message(Diagnostic("edge_of_search", "F_v", numbers=cause))
    assert text == (
        "F_v has no standard error: the search ended at the largest value that this log could show, 1 N, "
        "because the log never exceeds 500 mm/s"
    )


@pytest.mark.parametrize(
    ("samples", "held"), [(0.48, False), (-0.48, True), (-0.55, True), (-0.3, False), (-1.5, False)]
)
def test_lead_of_half_a_sample_is_explained_by_a_zero_order_hold(samples, held):
    numbers = {"delay": samples * 1e-3, "samples": samples, "half_width": 1e-5}
    words = message(Diagnostic("delay_found", "", "note", numbers))
    assert ("zero-order hold of a controller" in words) is held
    assert ("leads" in words) is (samples < 0.0)


@pytest.mark.parametrize(
    ("template", "value", "text"),
    [
        ("{a:list}", ("a", "b"), "a, b"),
        ("{a:and}", ("a", "b"), "a and b"),
        ("{a:whole numbers}", (1.0, 3.0), "1, 3"),
        ("{a:lead}", 5e-3, "5.000 mm"),
        ("{a:unit}", 2e-3, "2 mm"),
        ("{a:unit}", "coulomb", "coulomb"),
        ("{a:percents}", (12.3, -40.0), "12 %, −40 %"),
        ("{a:samples}", 2.0, "two samples"),
        ("{a:stiffness of an axis}", 5e7, "50.0 N/µm"),
        ("{a:2 digits}", 12.345, "12"),
        ("{a:length/time}", 628e-6, "628 µm/s"),
        ("{a:force*time/length}", 12.0, "12 N·s/m"),
        ("{a:time}", (1e-3, 2.0), "1 ms, 2 s"),
        ("{a:.2g}", 320.0, "320"),
        ("{a:.2g}", 1.234, "1.2"),
        ("{a:.2g}", 1e300, "1e+300"),
        ("{a:.0f}", 12.6, "13"),
        ("{a:+.0f}", -12.6, "-13"),
        ("{a!m:.1f}", -2.0, "2.0"),  # a magnitude
        ("{a!r}", "x", "'x'"),
    ],
)
def test_number_follows_its_format(template, value, text):
    assert _Words("translational", "m").vformat(template, (), {"a": value}) == text


def test_sentence_begins_with_a_capital_and_ends_with_a_full_stop():
    assert (
        whole_sentence(Diagnostic("low_speed", "F_v", numbers={"speed": 1.0}))
        == "F_v cannot be identified: the log never exceeds 1 m/s."
    )
    assert whole_sentence(Diagnostic("switching_law", "", "note")).startswith(
        "The control law chatters"
    )


@pytest.mark.parametrize(
    ("diagnostic", "words"),
    [
        (
            Diagnostic("held_known", "M", "note", {"value": 12.0, "unit": "kg"}),
            "M is held constant at 12 kg: given as known",
        ),
        (
            Diagnostic("held_known", "M", "warning", {"value": 12.0, "unit": "kg"}),
            "M cannot be identified: given as known",
        ),
        (
            Diagnostic("edge_no_fall", "F_S", "note", {"value": 1.0, "unit": "N"}),
            "in this log friction does not fall",
        ),
    ],
)
def test_head_of_a_sentence_follows_the_status_of_the_parameter(diagnostic, words):
    assert message(diagnostic).startswith(words)


def fit_with(*diagnostics):
    return known.fit(diagnostics=diagnostics)


def test_warnings_list_errors_first_and_no_notes():
    note, warning = (
        Diagnostic("switching_law", "", "note"),
        Diagnostic("one_recording", "", "warning"),
    )
    error = Diagnostic("sign_reversed", "", "error", {"percent": 90.0})
    fit = fit_with(note, warning, error)
    assert warnings_of(fit) == (message(error), message(warning))
    assert assumptions_of(fit) == (message(note),)
    assert notes_of(fit) == (
        message(note),
        f"warning: {message(warning)}",
        f"error: {message(error)}",
    )


FORCE_LACKS = "the model lacks a force"


@pytest.mark.parametrize(
    ("codes", "reason"),
    [
        ((), FORCE_LACKS),
        (LACKING[:1], FORCE_LACKS),
        (LACKING[1:2], SENTENCES[LACKING[1]].means),
        (LACKING[1::-1], f"{SENTENCES[LACKING[1]].means} and {FORCE_LACKS}"),
    ],
)
def test_reason_of_effective_parameters_is_model_or_log(codes, reason):
    assert why_effective(fit_with(*map(Diagnostic, codes))) == reason


def test_fields_of_a_sentence_have_their_formats():
    formats = {
        "low_speed": {"speed": "length/time", "std_percent": ".0f"},
        "held_levels": {"levels": ""},
    }
    formats |= {"filter_suspect": {"lag": "time", "channel": "", "half_width": ""}}
    assert {code: fields_of(code) for code in formats} == formats
    assert "parameter" not in fields_of("noisy_acceleration")


def test_a_note_is_the_reason_of_a_parameter():
    assert picked(SimpleNamespace(a=1, b=2, c=3), "a", "c") == {"a": 1, "c": 3}
    assert note_of(SimpleNamespace(reason=None)) == ""
    assert (
        note_of(SimpleNamespace(reason=Diagnostic("low_speed", "F_v", numbers={"speed": 1.0})))
        == "the log never exceeds 1 m/s"
    )


@pytest.mark.parametrize(
    ("name", "head"),
    [("give", "parameter give"), ("n", "n"), ("F_C", "F_C"), ("give_pos", "give_pos")],
)
def test_a_parameter_whose_name_is_a_word_is_called_a_parameter(name, head):
    text = message(Diagnostic("few_strokes", name, "warning", {"stroke": 0.1}))
    assert text.startswith(f"{head} cannot be identified: ")
    assert message(Diagnostic("held_known", name, "note", {"value": 1.0, "unit": "kg"})).startswith(
        f"{head} is held constant at 1 kg"
    )


# --- The numbers of a diagnostic choose the text of its code


SPEEDS = {"slow_samples": 1, "samples": 9, "speed": 2e-3}
ZONE = {"zone": 1e-5, "samples": 3.0, "filter_samples": 8.0}
FORCE = {"force": 2.0, "percent": 12.0, "share_percent": 50.0, "compared": "", "model": ""}
FILTER = {"cutoff": 60.0, "dropped": 5, "decimation": 1}
LOOP = {"radius": 1.2, "why": "gains"}
MARGIN = {"phase": 15.0, "enough": 30.0, "motions": "all"}
FOLLOWS = {
    "simulated": 2e-6,
    "simulated_rms": 1e-6,
    "measured": 4e-6,
    "measured_rms": 3e-6,
    "suspects": (),
    "factors": (),
}
STRUCTURE = {
    "missing": 2.0,
    "percent": 12.0,
    "chance": 0.1,
    "names": (),
    "small": False,
    "causes": (),
}
RISE = {"first": 1.0, "level": 2.0, "speed": 0.01}
DELAY = {"delay": 1e-3, "samples": 1.0, "half_width": 1e-5}

# A code, its numbers, and the words that only this one of its texts has.
CHOSEN = [
    (
        "resampled",
        {
            "column": "u",
            "own_sample_time": 1e-3,
            "sample_time": 1e-2,
            "percent": 9.0,
            "error_percent": 1.0,
        },
        "column u was",
    ),
    (
        "resampled",
        {"percent": 9.0, "largest": 20.0, "sample_time": 1e-3, "position_error": 1e-6},
        "error is about 1 µm in the position (",
    ),
    (
        "resampled",
        {
            "percent": 9.0,
            "largest": 20.0,
            "sample_time": 1e-3,
            "position_error": 1e-6,
            "effort_error": 2.0,
        },
        "and 2 N in the",
    ),
    (
        "velocity_contradicts",
        {"delay": 2e-3, "ratio": 1.0, "correlation": 0.9},
        "lags the derivative of the position by 2 ms",
    ),
    (
        "velocity_contradicts",
        {"delay": 0.0, "ratio": 1.5, "correlation": 0.9},
        "is 1.5 times the derivative of the position",
    ),
    (
        "resolution_contradicts",
        {"step": 1e-6, "times": 57.3, "resolution": 1e-6, "degrees": True},
        "One radian has 57.3 degrees",
    ),
    (
        "clipped",
        {"level": 9.0, "samples": 5, "time": 1.0, "all": 7, "names": ("M",)},
        ". The missing effort biases M",
    ),
    ("one_direction", {"direction": "forward", "percent": 0.05}, "for all but 0.1 % of its travel"),
    (
        "one_direction",
        {"direction": "forward", "percent": 0.04, "names": ("F_C",)},
        "moves forward only, so a constant force and friction are confounded",
    ),
    ("one_speed", {"slowest": 0.01, "fastest": 0.02}, "one speed, 10 mm/s to 20 mm/s. Move"),
    (
        "one_speed",
        {"slowest": 0.01, "fastest": 0.010001, "names": ("F_C",)},
        "one speed, 10 mm/s. Move",
    ),
    ("few_cycles", {"cycles": 3}, "one side has only 3 cycles"),
    ("few_cycles", {"cycles": ""}, "a single cycle shows no scatter"),
    ("friction_not_told", {"why": ""}, "bristle does not compare friction: no speed"),
    ("friction_not_told", {"why": "no filter"}, "bristle does not compare friction: no filter"),
    (
        "rising_friction",
        RISE | {"direction": ""},
        "over the first 10 mm/s. The log shows no Stribeck",
    ),
    (
        "rising_friction",
        RISE | {"direction": "backward"},
        "over the first 10 mm/s, moving backward. The log shows no Stribeck",
    ),
    (
        "filtered",
        FILTER | {"percent": 3.0, "decimation": 4},
        "kept one row for 4 samples, to suppress noise",
    ),
    ("filtered", FILTER | {"wanted": 60.0}, "sampled too slowly"),
    ("filtered", FILTER, "dropped 5 samples at each edge, and kept one row for each sample"),
    (
        "filtered",
        FILTER | {"decimation": 4},
        "dropped 5 samples at each edge, and kept one row for 4 samples",
    ),
    ("filtered", {"cutoff": 60.0, "decimation": 1}, "filtered effort and motion at 60 Hz"),
    (
        "filtered",
        {"cutoff": 60.0, "decimation": 4},
        "filtered effort and motion at 60 Hz, and kept one row for 4 samples",
    ),
    (
        "delay_found",
        DELAY,
        "the effort lags the position by 1 ms (1.00 samples; 95 % interval ±10 µs)",
    ),
    ("delay_found", DELAY | {"delay": 0.0, "samples": 0.0}, "the effort lags the position by 0 s"),
    (
        "delay_found",
        DELAY | {"delay": -6e-4, "samples": -0.6},
        "(0.60 samples, typical of the zero-order hold",
    ),
    (
        "delay_found",
        DELAY | {"delay": -4e-4, "samples": -0.4},
        "(0.40 samples, typical of the zero-order hold",
    ),
    (
        "delay_found",
        DELAY | {"delay": -6.1e-4, "samples": -0.61},
        "leads the position by 610 µs (0.61 samples; 95 %",
    ),
    ("delay_rough", DELAY, "lags the position by roughly 1 ms (1.0 samples"),
    (
        "delay_rough",
        DELAY | {"delay": 0.0, "samples": 0.0},
        "lags the position by roughly 0 s (0.0 samples",
    ),
    (
        "delay_rough",
        DELAY | {"delay": -2e-3, "samples": -2.0},
        "leads the position by roughly 2 ms (2.0",
    ),
    (
        "delay_or_filter",
        {"delay": 1e-3, "names": ("M", "F_v")},
        "removed it as a delay. M and F_v depend on this choice",
    ),
    (
        "filter_suspect",
        {"lag": 1e-3, "channel": "effort"},
        "the effort passed a filter with 1 ms more lag",
    ),
    (
        "filter_suspect",
        {"lag": 1e-3, "channel": "position"},
        "the position passed a filter with 1 ms more lag",
    ),
    (
        "filter_suspect",
        {"lag": 1e-3, "channel": "command"},
        "the recorded effort is probably a command",
    ),
    ("rests", {"percent": 3.0}, "left out 3 % of the samples"),
    ("rests", {"resolution": 1e-6}, "encoder steps of 1 µm. bristle fitted all"),
    (
        "worse_than_none",
        {"percent": 120.0, "signal": "position"},
        "worse than a constant position of zero",
    ),
    (
        "worse_than_none",
        {"percent": 120.0, "signal": "effort"},
        "worse than a constant effort of zero",
    ),
    ("start_of_contact", {"percents": (10.0, -20.0)}, "deflected by 10 %, −20 % of the distance"),
    ("start_of_contact", {"periods": 1}, "the log is one period"),
    ("start_of_contact", {"periods": 3}, "the log is 3 equal periods"),
    ("start_of_contact", {}, "the motion begins at rest"),
    (
        "loop_diverges",
        LOOP | {"largest_gain_percent": 50.0},
        "stable with its gains lowered to 50 % or less",
    ),
    (
        "loop_diverges",
        LOOP | {"longest_delay": 2},
        "gains too high for the sample time. The loop is stable with at most two samples of delay",
    ),
    (
        "loop_diverges",
        LOOP | {"longest_delay": 0, "largest_gain_percent": 50.0},
        "with no samples of delay or with its gains lowered to 50",
    ),
    ("loop_diverges", LOOP, "Check the signs of the gains"),
    (
        "loop_diverges",
        LOOP | {"mend": "raise_gains", "longest_delay": 2},
        "Raise the gains, or add friction feedforward",
    ),
    ("loop_oscillates", LOOP | {"motions": "small"}, "oscillates: for small motions the sampled"),
    ("loop_oscillates", LOOP | {"motions": "small"}, "Small motions grow"),
    ("loop_oscillates", LOOP | {"motions": "large"}, "The loop never settles. Check"),
    ("small_margin", MARGIN, "the phase margin is only 15° (usual: 30° or more). The loop rings"),
    (
        "small_margin",
        MARGIN | {"gain": 1.5},
        "or more), and 1.50 times the gain makes the loop unstable",
    ),
    ("loop_contradicts", FOLLOWS, "Its following error is 2 µm peak to peak"),
    ("loop_contradicts", FOLLOWS, "No single wrong gain"),
    (
        "loop_contradicts",
        {name: FOLLOWS[name] for name in FOLLOWS if "sim" not in name},
        "runs away, and the recorded loop does not. The recorded following error",
    ),
    (
        "no_fall",
        SPEEDS | {"slowest": 0.01, "fastest": 0.02},
        "the constant speeds are 10 mm/s to 20 mm/s",
    ),
    (
        "no_fall",
        SPEEDS | {"slowest": 0.01, "fastest": 0.010001},
        "the only constant speed is 10 mm/s",
    ),
    ("no_fall", SPEEDS, "the log has no constant-velocity segment"),
    ("few_reversals", {}, "the log has no reversal"),
    ("few_reversals", {"reversals": 1}, "the log has only 1 reversal"),
    ("few_reversals", {"reversals": 2}, "the log has only 2 reversals"),
    ("few_reversals", ZONE | {"reversals": 1}, "the log has only 1 reversal. It crosses"),
    (
        "few_reversals",
        ZONE | {"reversals": 20},
        "the log has only 20 reversals. Each reversal crosses",
    ),
    ("few_reversals", ZONE | {"reversals": 21}, "each of 21 reversals crosses"),
    (
        "few_reversals",
        ZONE | {"reversals": 21, "samples": 8.0},
        "the effect on the 21 reversals of the log is smaller",
    ),
    (
        "few_strokes",
        {"reversals": 2, "stroke": 0.1},
        "the log does not separate this force from other forces. It has 2 reversals over",
    ),
    ("few_strokes", {"stroke": 0.1}, "the force is a straight line over the stroke"),
    ("structure", STRUCTURE, "the model lacks a force. 2 N"),
    (
        "structure",
        STRUCTURE | {"small": True, "names": ("M",)},
        "a force, too small to matter in use. 2 N",
    ),
    (
        "structure",
        STRUCTURE | {"names": ("M", "F_C")},
        "M, F_C are effective: valid for this model",
    ),
    ("missing_speed", FORCE, "No model of bristle has a better curve"),
    ("missing_speed", FORCE | {"model": "lugre"}, "Next: try `lugre`"),
    (
        "missing_speed",
        FORCE | {"model": "stribeck_free"},
        "`stribeck_free`, also with its exponent",
    ),
    (
        "missing_speed",
        FORCE | {"compared": "lugre", "model": "x"},
        "bristle also compared `lugre`, but its error is no smaller",
    ),
    ("missing_direction", FORCE | {"model": "x", "percent": 318.0}, "318 %"),
    ("missing_direction", FORCE | {"model": "x"}, "Next: try `x`"),
    (
        "terms_beside",
        {"terms": ("cable (3 %)",), "model": "x"},
        "means over the log. Next: try `x`",
    ),
    ("terms_beside", {"terms": ("cable (3 %)",), "model": ""}, "bristle took it out of the effort"),
    ("missing_play", FORCE | {"ratio": 3.0, "model": "x"}, "3 times larger than in the rest"),
    (
        "missing_direction",
        FORCE | {"compared": "x"},
        "bristle also compared `x`, but its error is no smaller",
    ),
    ("missing_direction", FORCE, "already has separate parameters for each direction"),
]


@pytest.mark.parametrize(
    ("code", "numbers", "words"),
    CHOSEN,
    ids=[f"{code} {place}" for place, (code, *_) in enumerate(CHOSEN)],
)
def test_text_of_a_code_follows_the_numbers(code, numbers, words):
    assert words in clause(Diagnostic(code, "F_C", "note", numbers))


@pytest.mark.parametrize(
    ("code", "numbers", "words"),
    [
        ("clipped", {"level": 9.0, "samples": 5, "time": 1.0, "all": 7}, "biases"),
        (
            "resolution_contradicts",
            {"step": 1e-6, "times": 2.0, "resolution": 1e-6, "degrees": False},
            "57.3",
        ),
        ("delay_or_filter", {"delay": 1e-3, "names": ()}, "depend on this choice"),
        ("loop_diverges", LOOP | {"longest_delay": 0}, "at most"),
        ("structure", STRUCTURE, "effective"),
    ],
)
def test_missing_numbers_omit_their_clauses(code, numbers, words):
    assert words not in clause(Diagnostic(code, "", "note", numbers))


def test_each_suspect_of_a_loop_has_its_factor():
    numbers = FOLLOWS | {"suspects": ("k_p", "delay", "reference_later"), "factors": (1.2, 2, 3e-3)}
    assert clause(Diagnostic("loop_contradicts", "", "note", numbers)).endswith(
        "The loop would match with a position gain of 1.20 times the value in the axis file or a delay of two samples in the loop or a "
        "reference that acts 3 ms later than recorded"
    )


def test_intervals_of_a_loop_name_encoder_steps_in_the_loop():
    numbers = {
        "draws": 20,
        "noise": 1.0,
        "resolution": 1e-6,
        "scatter_percent": 2.0,
        "half_cycles": 30,
        "unexplained": 0.5,
    }
    assert "noise of 1 N, encoder steps of 1 µm, and friction" in clause(
        Diagnostic("intervals", "", "note", numbers)
    )
    assert "encoder steps of 1 µm in the loop and friction" in clause(
        Diagnostic("intervals", "", "note", numbers | {"loop": True})
    )


def test_reason_ends_with_a_known_standard_error():
    sure = Diagnostic("low_speed", "F_v", "warning", {"speed": 0.5})
    unsure = Diagnostic("low_speed", "F_v", "warning", {"speed": 0.5, "std_percent": 40.0})
    assert message(sure) == "F_v cannot be identified: the log never exceeds 500 mm/s"
    assert (
        message(unsure)
        == message(sure)
        + ". The standard error of F_v is 40 %, which allows for residuals correlated over time"
    )


def test_short_forms_build_sentences():
    sentences = [says("a", "b"), held("a", "b", "c"), held("a", "b")]
    assert sentences == [
        Sentence(("a",), "b", "nothing"),
        *(Sentence(("a",), "b", advice, "parameter") for advice in ("c", "nothing")),
    ]
    reason = cause("means", "advice", "text")
    assert (reason.means, reason.advice, reason.about, reason.texts[0]) == (
        "means",
        "advice",
        "parameter",
        "text",
    )
    assert reason.template({}) == "text"


FIRST_KNOWN = where("a", "b")
TEXTS = ("first", "second", "last")


@pytest.mark.parametrize(
    ("told", "given", "words"),
    [
        # The first number that is present chooses the text.
        (FIRST_KNOWN, (TEXTS, {"a": 1}), "first"),
        (FIRST_KNOWN, (TEXTS, {"a": 0}), "first"),
        (FIRST_KNOWN, (TEXTS, {"a": None, "b": 2}), "second"),
        (FIRST_KNOWN, (TEXTS, {"a": "", "b": ()}), "last"),
        (FIRST_KNOWN, (TEXTS, {}), "last"),
        # Samples are counted in words up to ten.
        (loops.counted, (0,), "no samples"),
        (loops.counted, (1,), "one sample"),
        (loops.counted, (2,), "two samples"),
        (loops.counted, (10,), "ten samples"),
        (loops.counted, (11,), "11 samples"),
    ],
)
def test_words_follow_the_known_numbers(told, given, words):
    assert told(*given) == words


def test_refused_loop_has_a_cause_for_each_reason():
    assert SENTENCES["loop_diverges"].also == SENTENCES["loop_oscillates"].also
    assert "one sample of delay" in clause(
        Diagnostic("loop_diverges", "", "note", LOOP | {"why": "delay", "delay": 1})
    )

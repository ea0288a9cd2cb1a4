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
from bristle.report.sentences import SENTENCES

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
        assert item.means, code
        assert item.advice, code


@pytest.fixture(scope="module")
def fits():
    motion = sines(10.0, amplitudes=(2e-4,), frequencies=(0.5,), phases=(0.0,))
    slow = log_of(motion, sliding_effort(motion, noise=3.0))
    flat = slow_log(friction.coulomb_viscous(F_C=8.0, F_v=30.0))
    result = identify(slow, "coulomb_viscous,lugre,bouc_wen_classic", axis=STATED, blocks=0, draws=20).fits
    return (*result, *identify(flat, "stribeck", axis=STATED, draws=0).fits)


@pytest.mark.slow
def test_diagnostics_have_the_numbers_of_their_sentences(fits):
    seen = set()
    for item in (each for fit in fits for each in fit.diagnostics):
        needed = (
            {name for _, name, _, _ in Formatter().parse(SENTENCES[item.code].template(item.numbers)) if name} - {"parameter"} - WRITTEN
        )
        if "cause" not in item.numbers:
            assert needed <= set(item.numbers), item
            assert set(item.numbers) - set(fields_of(item.code)) <= {"value", "unit", "std_percent", "slowest", "fastest", "direction"}, (
                item
            )
        seen.add(item.code)
    assert {"low_speed", "low_acceleration", "filtered", "intervals", "held_default", "redundant"} <= seen


@pytest.mark.slow
def test_diagnostic_survives_pickle_and_json_has_its_sentence(fits):
    every = fits[0].diagnostics
    assert pickle.loads(pickle.dumps(every)) == every
    data = as_data(every)
    assert [item["message"] for item in data if item["severity"] == "warning"] == list(warnings_of(fits[0]))
    assert all(set(item) == {"code", "parameter", "severity", "numbers", "message"} for item in data)


def test_units_follow_the_kind_of_axis():
    turning = Diagnostic("low_speed", "F_v", numbers={"speed": 2.0}, kind="rotational")
    assert message(turning) == "F_v cannot be identified: the log never exceeds 2 rad/s"
    assert clause(turning) == "the log never exceeds 2 rad/s"
    assert all(exponents_of(spec) for spec in fields_of("few_reversals").values() if "length" in spec)


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


@pytest.mark.parametrize(("samples", "held"), [(0.48, False), (-0.48, True), (-0.55, True), (-0.3, False), (-1.5, False)])
def test_lead_of_half_a_sample_is_explained_by_a_zero_order_hold(samples, held):
    numbers = {"delay": samples * 1e-3, "samples": samples, "half_width": 1e-5}
    words = message(Diagnostic("delay_found", "", "note", numbers))
    assert ("zero-order hold of a controller" in words) is held
    assert ("leads" in words) is (samples < 0.0)


@pytest.mark.parametrize(
    ("spec", "value", "text"),
    [
        ("list", ("a", "b"), "a, b"),
        ("and", ("a", "b"), "a and b"),
        ("whole numbers", (1.0, 3.0), "1, 3"),
        ("lead", 5e-3, "5.000 mm"),
        ("unit", 2e-3, "2 mm"),
        ("unit", "coulomb", "coulomb"),
        ("percents", (12.3, -40.0), "12 %, −40 %"),
        ("samples", 2.0, "two samples"),
        ("stiffness of an axis", 5e7, "50.0 N/µm"),
        ("2 digits", 12.345, "12"),
        ("length/time", 628e-6, "628 µm/s"),
        ("force*time/length", 12.0, "12 N·s/m"),
        ("time", (1e-3, 2.0), "1 ms, 2 s"),
        (".2g", 320.0, "320"),
        (".2g", 1.234, "1.2"),
        (".2g", 1e300, "1e+300"),
        (".0f", 12.6, "13"),
        ("+.0f", -12.6, "-13"),
    ],
)
def test_number_follows_its_format(spec, value, text):
    assert _Words("translational", "m").format_field(value, spec) == text


def test_magnitude_has_no_sign():
    assert _Words("translational", "1").vformat("{a!m:.1f} {b!r}", (), {"a": -2.0, "b": "x"}) == "2.0 'x'"


def test_sentence_begins_with_a_capital_and_ends_with_a_full_stop():
    assert (
        whole_sentence(Diagnostic("low_speed", "F_v", numbers={"speed": 1.0})) == "F_v cannot be identified: the log never exceeds 1 m/s."
    )
    assert whole_sentence(Diagnostic("switching_law", "", "note")).startswith("The control law chatters")


def test_head_of_a_sentence_follows_the_status_of_the_parameter():
    held = Diagnostic("held_known", "M", "note", {"value": 12.0, "unit": "kg"})
    assert message(held) == "M is held constant at 12 kg: given as known"
    assert message(Diagnostic("held_known", "M", "warning", {"value": 12.0, "unit": "kg"})) == "M cannot be identified: given as known"
    assert message(Diagnostic("edge_no_fall", "F_S", "note", {"value": 1.0, "unit": "N"})).startswith("in this log friction does not fall")


def fit_with(*diagnostics):
    return known.fit(diagnostics=diagnostics)


def test_warnings_list_errors_first_and_no_notes():
    note, warning = Diagnostic("switching_law", "", "note"), Diagnostic("one_recording", "", "warning")
    error = Diagnostic("sign_reversed", "", "error", {"percent": 90.0})
    fit = fit_with(note, warning, error)
    assert warnings_of(fit) == (message(error), message(warning))
    assert assumptions_of(fit) == (message(note),)
    assert notes_of(fit) == (message(note), f"warning: {message(warning)}", f"error: {message(error)}")


def test_reason_of_effective_parameters_is_model_or_log():
    first, second = LACKING[:2]
    assert why_effective(fit_with()) == "the model lacks a force"
    assert why_effective(fit_with(Diagnostic(first))) == "the model lacks a force"
    assert why_effective(fit_with(Diagnostic(second))) == SENTENCES[second].means
    assert why_effective(fit_with(Diagnostic(second), Diagnostic(first))) == f"{SENTENCES[second].means} and the model lacks a force"


def test_fields_of_a_sentence_have_their_formats():
    assert fields_of("low_speed") == {"speed": "length/time", "std_percent": ".0f"}
    assert fields_of("filter_suspect") == {"lag": "time", "channel": "", "half_width": ""}
    assert "parameter" not in fields_of("noisy_acceleration")
    assert fields_of("held_levels") == {"levels": ""}
    assert picked(SimpleNamespace(a=1, b=2, c=3), "a", "c") == {"a": 1, "c": 3}
    assert note_of(SimpleNamespace(reason=None)) == ""
    assert note_of(SimpleNamespace(reason=Diagnostic("low_speed", "F_v", numbers={"speed": 1.0}))) == "the log never exceeds 1 m/s"


@pytest.mark.parametrize(("name", "head"), [("give", "parameter give"), ("n", "n"), ("F_C", "F_C"), ("give_pos", "give_pos")])
def test_a_parameter_whose_name_is_a_word_is_called_a_parameter(name, head):
    text = message(Diagnostic("few_strokes", name, "warning", {"stroke": 0.1}))
    assert text.startswith(f"{head} cannot be identified: ")
    assert message(Diagnostic("held_known", name, "note", {"value": 1.0, "unit": "kg"})).startswith(f"{head} is held constant at 1 kg")

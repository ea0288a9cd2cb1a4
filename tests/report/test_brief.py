"""An identification in brief: what a terminal shows of it."""

from dataclasses import replace
from types import SimpleNamespace as Some

import pytest
from tests.identification.known_logs import STATED, sliding_log

from bristle import controllers
from bristle.cli.terminal import show_lines
from bristle.core import Axis, Diagnostic
from bristle.identification import identify
from bristle.report import brief as module
from bristle.report.brief import Line, brief
from bristle.report.compensation import Errors, Gain
from bristle.report.page import Ruling
from bristle.report.sentences import SENTENCES

CODES = ("few_speeds", "one_direction", "clipped", "level_drifts", "structure")


@pytest.fixture(scope="module")
def identification():
    return identify(sliding_log(), "coulomb_viscous", axis=STATED, blocks=0, draws=0)


def with_diagnostics(identification, *codes, severity="warning"):
    found = tuple(Diagnostic(code, "", severity, {"causes": ("speed",)}, "translational") for code in codes)
    return replace(identification, fits=(replace(identification.best, diagnostics=found),))


def texts(lines, label):
    """The lines with a label, and those without any behind it."""
    start = next((place for place, line in enumerate(lines) if line.label == label), len(lines))
    end = next((place for place in range(start + 1, len(lines)) if lines[place].label), len(lines))
    return [line.text for line in lines[start:end]]


def test_the_verdict_is_the_last_line_and_has_its_level(identification):
    *_, last = brief(identification, None, None)
    assert (last.label, last.level) == ("Verdict", "usable")
    assert last.text.startswith("Usable")


def test_mass_and_level_of_friction_come_with_half_widths_and_in_the_unit_of_the_drive(identification):
    mass, friction, *_ = texts(brief(identification, None, None), "Type in")
    fit = identification.best
    assert mass.startswith(f"mass {fit.plant.values['M']:.3g}")
    assert "±" in mass
    assert "forward" in friction
    assert "backward ±" in friction


@pytest.mark.parametrize(("status", "is_shown"), [("identified", True), ("held", True), ("unidentifiable", False)])
def test_a_constant_force_is_to_be_typed_in_only_if_it_is_known(identification, monkeypatch, status, is_shown):
    fit = identification.best
    offset = replace(fit.estimates[1], name="offset", value=5.0, status=status)
    monkeypatch.setattr(module, "level_values", lambda fit: Some(forward=8.0, backward=8.0, constant=5.0, inertia=12.0))
    friction = module._to_type_in(replace(fit, estimates=(*fit.estimates, offset)), None)[1].text
    assert ("constant force 5" in friction) is is_shown


def test_a_log_in_one_direction_has_no_value_to_type_in(identification, monkeypatch):
    monkeypatch.setattr("bristle.report.judgement.level_values", lambda fit: Some(forward=8.0, backward=None))
    lines = brief(identification, Some(), None)
    assert {line.label for line in lines} & {"Gain", "Type in"} == set()
    assert lines[-1].text.startswith(f"Measure again: {SENTENCES['one_direction'].means}")


def test_a_faulty_log_is_to_be_recorded_again(identification, monkeypatch):
    assert module.advice_to_record(identification.best) == ""
    faulty = with_diagnostics(identification, "effort_unsigned", severity="error").best
    assert module.advice_to_record(faulty).lower().startswith(SENTENCES["effort_unsigned"].advice.lower())
    monkeypatch.setattr("bristle.report.judgement.level_values", lambda fit: Some(forward=8.0, backward=None))
    assert SENTENCES["one_direction"].advice.lower() in module.advice_to_record(identification.best).lower()


def test_the_three_gravest_warnings_are_named_with_their_codes(identification):
    lines = texts(brief(with_diagnostics(identification, *CODES), None, None), "Warnings")
    assert [line.rpartition("[")[2].rstrip("]") for line in lines[:3]] == ["structure", "clipped", "level_drifts"]
    assert lines[3].startswith("2 more: -v")
    assert texts(brief(with_diagnostics(identification), None, None), "Warnings") == []


def test_the_first_model_that_the_residual_asks_for_is_proposed(identification):
    found = [Diagnostic("missing_position", "", "warning", {"model": name}, "translational") for name in ("a+position", "b", "a+position")]
    lines = brief(replace(identification, fits=(replace(identification.best, diagnostics=tuple(found)),)), None, None)
    assert texts(lines, "Try") == ["--model a+position"]
    assert texts(brief(with_diagnostics(identification), None, None), "Try") == []


def test_an_error_is_named_before_every_warning(identification):
    found = with_diagnostics(identification, "structure")
    error = Diagnostic("few_speeds", "", "error", {}, "translational")
    found = replace(found, fits=(replace(found.best, diagnostics=(*found.best.diagnostics, error)),))
    assert "[few_speeds]" in texts(brief(found, None, None), "Warnings")[0]


def test_a_log_to_be_measured_again_has_no_values_to_type_in(identification):
    lines = brief(with_diagnostics(identification, "one_direction", severity="error"), None, None)
    assert lines[-1].level == "measure_again"
    assert not {"Type in", "Gain"} & {line.label for line in lines}


def gained(monkeypatch, before, after):
    steps = (Errors("feedforward", before, before, 0.0, 0.0), Errors("compensated", after, after, 0.0, 0.0))
    monkeypatch.setattr(module, "gain_of", lambda simulation: Gain(steps, "translational", "caveat"))
    return module._gain(Some(), None, None)[0].text


def test_the_gain_is_the_following_error_without_and_with_friction_feedforward(monkeypatch):
    assert gained(monkeypatch, 203e-6, 7e-6).replace("\u00a0", " ") == "Friction feedforward: 203 → 7 µm peak to peak, ×29"
    assert gained(monkeypatch, 203e-6, 195e-6).endswith("no improvement")
    assert gained(monkeypatch, 203e-6, 190e-6).endswith("×1.1")
    assert module._gain(Some(), Some(contradiction=Diagnostic("loop_contradicts")), None)[0].text.startswith("not predicted")
    in_a_loop = Axis(controller=controllers.cascade(k_p=60.0, k_v=9e4))
    for axis in (None, Axis()):
        assert module._gain(None, None, axis)[0].text == "not simulated: the axis file has no controller"
    assert module._gain(None, None, in_a_loop)[0].text == "not simulated: the log has no reference of a loop"


def test_a_command_to_copy_is_on_one_line_of_its_own_and_no_word_is_cut(capsys, monkeypatch):
    monkeypatch.setattr("bristle.cli.terminal.PIPE_WIDTH", 40)
    command = "bristle run results/experiment.toml --out results_loop"
    show_lines([Line("Next", "Simulate the loop:", command=command), Line("Try", f"--model {60 * 'x'}")])
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == ["Next        Simulate the loop:", f"  {command}"]
    assert lines[-1].split() == [60 * "x"]


def test_many_parameters_are_cut_to_those_that_take_most_of_the_force(identification):
    fit = identification.best
    more = [replace(fit.estimates[1], name=f"p{place}", value=1.0 + place, effect=0.01 * place) for place in range(9)]
    lines = module._parameters(replace(fit, estimates=(*fit.estimates, *more)))
    assert len(lines) == module.PARAMETERS + 1
    assert lines[-1].text.endswith("more: -v)")
    shown = [line.text.split()[0] for line in lines[:-1]]
    assert shown[0] == "M"
    assert shown[-1] == "p8"
    assert "p0" not in shown


def test_a_verdict_with_many_reasons_is_cut_to_three():
    line = module.verdict(Ruling("with_care", "Use with care", tuple("abcde")))
    assert line == Line("Verdict", "Use with care: a; b; c; 2 more reasons (-v).", "with_care")


def test_lines_are_wrapped_behind_their_labels(capsys, monkeypatch):
    monkeypatch.setattr("bristle.cli.terminal.PIPE_WIDTH", 40)
    show_lines([Line("Model", 12 * "word "), Line("", "  indented"), Line("Verdict", "Usable.", "usable")])
    assert capsys.readouterr().out.splitlines() == [
        "Model       word word word word word",
        "            word word word word word",
        "            word word",
        "              indented",
        "Verdict     Usable.",
    ]

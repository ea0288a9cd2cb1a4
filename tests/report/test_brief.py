"""An identification in brief: what a terminal shows of it."""

import re
from dataclasses import replace
from importlib import import_module
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.known_logs import STATED, sliding_log

from bristle import controllers
from bristle.cli.terminal import show_lines
from bristle.core import Axis, Diagnostic, example_of
from bristle.identification import identify
from bristle.models.friction import MODELS
from bristle.prediction import drive_units, fit_at_samples, level_values, reversal_distance
from bristle.report import brief as module, compensation, page
from bristle.report.cards import Card, Step, cards_of, distance_card, no_gain, quantity_text
from bristle.report.sentences import SENTENCES

CODES = ("few_speeds", "one_direction", "clipped", "level_drifts", "structure")


@pytest.fixture(scope="module")
def identification():
    return identify(sliding_log(), "coulomb_viscous", axis=STATED, blocks=0, draws=0)


def with_diagnostics(identification, *codes, severity="warning"):
    found = tuple(
        Diagnostic(code, "", severity, {"causes": ("speed",)}, "translational") for code in codes
    )
    return replace(identification, fits=(replace(identification.best, diagnostics=found),))


def texts(lines, label):
    """The lines with a label, and those without any behind it."""
    start = next((place for place, line in enumerate(lines) if line.label == label), len(lines))
    end = next((place for place in range(start + 1, len(lines)) if lines[place].label), len(lines))
    return [line.text for line in lines[start:end]]


def test_the_verdict_is_the_last_line_and_has_its_level(identification):
    *_, last = module.brief(identification, None, None)
    assert (last.label, last.level, last.text[:6]) == ("Verdict", "usable", "Usable")


def test_mass_and_level_of_friction_come_with_half_widths_and_in_the_unit_of_the_drive(
    identification,
):
    mass, friction, *_ = texts(module.brief(identification, None, None), "Type in")
    assert re.match(f"mass {identification.best.plant.values['M']:.3g}.*±", mass)
    assert re.search("forward.*backward ±", friction)


@pytest.mark.parametrize(
    ("status", "is_shown"), [("identified", True), ("held", True), ("unidentifiable", False)]
)
def test_a_constant_force_is_to_be_typed_in_only_if_it_is_known(
    identification, monkeypatch, status, is_shown
):
    fit = identification.best
    offset = replace(fit.estimates[1], name="offset", value=5.0, status=status)
    monkeypatch.setattr(
        module,
        "level_values",
        lambda fit: Some(forward=8.0, backward=8.0, constant=5.0, inertia=12.0),
    )
    friction = module._to_type_in(replace(fit, estimates=(*fit.estimates, offset)), None)[1].text
    assert ("constant force 5" in friction) is is_shown


def test_a_log_in_one_direction_has_no_value_to_type_in(identification, monkeypatch):
    monkeypatch.setattr(
        "bristle.report.judgement.level_values", lambda fit: Some(forward=8.0, backward=None)
    )
    lines = module.brief(identification, Some(), None)
    assert {line.label for line in lines} & {"Gain", "Type in"} == set()
    assert lines[-1].text.startswith(f"Measure again: {SENTENCES['one_direction'].means}")


def test_a_faulty_log_is_to_be_recorded_again(identification, monkeypatch):
    assert module.advice_to_record(identification.best) == ""
    faulty = with_diagnostics(identification, "effort_unsigned", severity="error").best
    assert (
        module.advice_to_record(faulty)
        .lower()
        .startswith(SENTENCES["effort_unsigned"].advice.lower())
    )
    monkeypatch.setattr(
        "bristle.report.judgement.level_values", lambda fit: Some(forward=8.0, backward=None)
    )
    assert (
        SENTENCES["one_direction"].advice.lower()
        in module.advice_to_record(identification.best).lower()
    )


def test_the_three_gravest_warnings_are_named_with_their_codes(identification):
    lines = texts(module.brief(with_diagnostics(identification, *CODES), None, None), "Warnings")
    assert [line.rpartition("[")[2].rstrip("]") for line in lines[:3]] == [
        "structure",
        "clipped",
        "level_drifts",
    ]
    assert lines[3].startswith("2 more: -v")
    assert texts(module.brief(with_diagnostics(identification), None, None), "Warnings") == []


def test_the_first_model_that_the_residual_asks_for_is_proposed(identification):
    found = [
        Diagnostic("missing_direction", "", "warning", {"model": name}, "translational")
        for name in ("a+position", "b", "a+position")
    ]
    lines = module.brief(
        replace(identification, fits=(replace(identification.best, diagnostics=tuple(found)),)),
        None,
        None,
    )
    assert texts(lines, "Try") == [f"--model {identification.best.name},a+position"]
    assert texts(module.brief(with_diagnostics(identification), None, None), "Try") == []


def test_an_error_is_named_before_every_warning(identification):
    found = with_diagnostics(identification, "structure")
    error = Diagnostic("few_speeds", "", "error", {}, "translational")
    found = replace(
        found, fits=(replace(found.best, diagnostics=(*found.best.diagnostics, error)),)
    )
    assert "[few_speeds]" in texts(module.brief(found, None, None), "Warnings")[0]


def test_a_log_to_be_measured_again_has_no_values_to_type_in(identification):
    lines = module.brief(
        with_diagnostics(identification, "one_direction", severity="error"), None, None
    )
    assert lines[-1].level == "measure_again"
    assert not {"Type in", "Gain"} & {line.label for line in lines}


def gained(monkeypatch, before, after):
    steps = (
        compensation.Errors("feedforward", before, before, 0.0, 0.0),
        compensation.Errors("compensated", after, after, 0.0, 0.0),
    )
    monkeypatch.setattr(
        module, "gain_of", lambda simulation: compensation.Gain(steps, "translational", "caveat")
    )
    return module._gain(Some(), None, None)[0].text


def test_the_gain_is_the_following_error_without_and_with_friction_feedforward(monkeypatch):
    assert (
        gained(monkeypatch, 203e-6, 7e-6).replace("\u00a0", " ")
        == "Friction feedforward: 203 → 7 µm peak to peak, ×29"
    )
    assert gained(monkeypatch, 203e-6, 195e-6).endswith("no improvement")
    assert gained(monkeypatch, 203e-6, 190e-6).endswith("×1.1")


@pytest.mark.parametrize(
    ("simulation", "following", "axis", "text"),
    [
        (Some(), Some(contradiction=Diagnostic("loop_contradicts")), None, "not predicted"),
        (None, None, None, "not simulated: the axis file has no controller"),
        (None, None, Axis(), "not simulated: the axis file has no controller"),
        (
            None,
            None,
            Axis(controller=controllers.cascade(k_p=60.0, k_v=9e4)),
            "not simulated: the log has no reference of a loop",
        ),
    ],
)
def test_an_unknown_gain_has_a_reason(monkeypatch, simulation, following, axis, text):
    monkeypatch.setattr(
        module,
        "gain_of",
        lambda simulation: simulation and compensation.Gain((), "translational", ""),
    )
    assert module._gain(simulation, following, axis)[0].text.startswith(text)


def test_a_command_to_copy_is_on_one_line_of_its_own_and_no_word_is_cut(capsys, monkeypatch):
    monkeypatch.setattr("bristle.cli.terminal.PIPE_WIDTH", 40)
    command = "bristle run results/experiment.toml --out results_loop"
    show_lines(
        [
            module.Line("Next", "Simulate the loop:", command=command),
            module.Line("Try", f"--model {60 * 'x'}"),
        ]
    )
    lines = capsys.readouterr().out.splitlines()
    assert [*lines[:2], lines[-1].split()] == [
        "Next        Simulate the loop:",
        f"  {command}",
        [60 * "x"],
    ]


def test_many_parameters_are_cut_to_those_that_take_most_of_the_force(identification):
    fit = identification.best
    more = [
        replace(fit.estimates[1], name=f"p{place}", value=1.0 + place, effect=0.01 * place)
        for place in range(9)
    ]
    *lines, last = module._parameters(replace(fit, estimates=(*fit.estimates, *more)))
    assert last.text.endswith("more: -v)")
    shown = [line.text.split()[0] for line in lines]
    assert (len(shown), shown[0], shown[-1], "p0" in shown) == (module.PARAMETERS, "M", "p8", False)


def test_a_verdict_with_many_reasons_is_cut_to_three():
    line = module.verdict(page.Ruling("with_care", "Use with care", tuple("abcde")))
    assert line == module.Line(
        "Verdict", "Use with care: a; b; c; 2 more reasons (-v).", "with_care"
    )


def test_lines_are_wrapped_behind_their_labels(capsys, monkeypatch):
    monkeypatch.setattr("bristle.cli.terminal.PIPE_WIDTH", 40)
    show_lines(
        [
            module.Line("Model", 12 * "word "),
            module.Line("", "  indented"),
            module.Line("Verdict", "Usable.", "usable"),
        ]
    )
    assert capsys.readouterr().out.splitlines() == [
        "Model       word word word word word",
        "            word word word word word",
        "            word word",
        "              indented",
        "Verdict     Usable.",
    ]


# --- The cards of the first screen: numbers with their intervals in the units of the drive, and the next step


def by_label(cards):
    return {card.label: card for card in cards}


def numbers(text):
    return [float(number) for number in re.findall(r"[\d.]+", text.replace("\u00a0", " "))]


def repeated(command):
    return Step.of("try a model with the missing force: `--model gms`").in_full(command).command


COMPARE = (
    "enter the values on the machine, record again, and measure the gain with `bristle compare a b`"
)


@pytest.mark.parametrize(
    ("told", "given", "words"),
    [
        # Digits follow the interval.
        (quantity_text, (28.0312, 0.22, "kg"), "28.03\u00a0kg"),
        (quantity_text, (28.0312, 2.2, "kg"), "28.0\u00a0kg"),
        (quantity_text, (28.0312, 20.0, "kg"), "28\u00a0kg"),
        (quantity_text, (28.0312, None, "kg"), "28.0\u00a0kg"),
        (quantity_text, (2.8412, 1.1, "kg"), "2.84\u00a0kg"),
        # A step separates sentence and command.
        (
            Step.of,
            (COMPARE,),
            ("Enter the values on the machine, record again", "bristle compare a b"),
        ),
        (Step.of, ("weigh the axis",), ("Weigh the axis", "")),
        # A step repeats the command with its option: results stay, and names with blanks stay whole.
        (
            repeated,
            ("bristle identify log.csv --model lugre --axis a.toml",),
            "bristle identify log.csv --axis a.toml --model gms",
        ),
        (repeated, ("bristle.identify(log)",), "--model gms"),
        (
            repeated,
            ("bristle identify 'my log.csv' --model lugre --out 'a b' --force",),
            "bristle identify 'my log.csv' --model gms --out 'a b_2'",
        ),
    ],
)
def test_numbers_and_steps_of_a_card_are_told(told, given, words):
    assert told(*given) == words


def test_cards_are_the_numbers_of_the_fit(workbench):
    fit, axis = workbench.identified.best, workbench.axis
    cards = by_label(cards_of(fit, axis, usable=True))
    mass = cards["Inertia" if fit.plant.kind == "rotational" else "Mass"]
    at_motor = [unit.of(fit.inertia.value) for unit in drive_units(axis, fit.plant.kind).inertias]
    assert mass.half == pytest.approx(fit.inertia.interval_percent)
    if not at_motor:
        ratio = numbers(mass.value)[0] / fit.inertia.value
        assert ratio == pytest.approx(10.0 ** round(np.log10(ratio)), rel=1e-2)
    levels = level_values(fit)
    friction = cards["Lowest sliding friction"]
    in_si = friction.value if "(" not in friction.remark else friction.remark.partition("(")[2]
    ratio = numbers(in_si)[0] / levels.forward
    assert ratio == pytest.approx(10.0 ** round(np.log10(ratio)), rel=6e-3)
    assert numbers(in_si)[1] == pytest.approx(ratio * levels.backward, rel=6e-3)
    halves = [
        estimate.interval_percent
        for estimate in fit.estimates
        if estimate.name in fit.levels and estimate.status == "identified"
    ]
    assert friction.half == pytest.approx(max(halves))
    error = cards["Model error"]
    assert numbers(error.value)[0] == pytest.approx(fit.error_percent, rel=6e-3)
    assert numbers(error.remark)[0] == pytest.approx(fit.held_out.mean_percent, rel=6e-3)


def test_the_drive_comes_first(stage):
    fit = stage.identified.best
    unit = Some(name="A", of=lambda value: value / 50.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "bristle.report.cards.drive_units",
            lambda axis, kind: Some(efforts=(unit,), inertias=(), lengths=()),
        )
        card = by_label(cards_of(fit, Axis(), usable=True))["Lowest sliding friction"]
    assert card.value.endswith("A")
    assert numbers(card.value)[0] == pytest.approx(level_values(fit).forward / 50.0, rel=6e-3)
    assert f"({numbers(card.remark)[0]:g}" in card.remark.replace("\u00a0", " ")


def test_no_number_to_type_in_where_the_log_must_be_recorded_again(workbench):
    cards = cards_of(workbench.identified.best, workbench.axis, usable=False)
    assert [(card.value, card.remark, card.open, card.half) for card in cards[:2]] == [
        ("–", "measure again", True, None)
    ] * 2


def test_the_distance_has_the_scatter_of_the_replicates(stage):
    model = example_of(MODELS["dahl"])
    drawn = [
        model.with_values(sigma_0=share * model.sigma_0) for share in np.linspace(0.8, 1.2, 16)
    ]
    fit = replace(
        stage.identified.best,
        friction=model,
        resampling=Some(bands=Some(models=lambda model, most: drawn[:most])),
    )
    fastest = float(np.max(np.abs(fit.traces.velocity)))
    distances = np.array([reversal_distance(each, fastest) for each in drawn])
    middle = reversal_distance(model, fastest)
    card = distance_card(fit, None)
    assert card.half == pytest.approx(
        100.0 * 1.959964 * 1.482602 * np.median(np.abs(distances - middle)) / middle, rel=1e-4
    )
    assert numbers(card.value)[0] * 1e-6 == pytest.approx(middle, rel=0.05)
    wild = replace(
        fit,
        resampling=Some(
            bands=Some(
                models=lambda model, most: [model.with_values(sigma_0=model.sigma_0 / 50.0)] * 4
            )
        ),
    )
    assert (distance_card(wild, None).half, distance_card(wild, None).open) == (None, True)
    assert distance_card(replace(fit, friction=example_of(MODELS["coulomb"])), None) is None


def test_a_bar_ends_at_thirty_percent():
    assert [Card("", "", half=half).reach for half in (3.0, 30.0, 300.0, 0.01)] == pytest.approx(
        [5.0, 50.0, 50.0, 1.0]
    )
    assert Card("", "").reach == 0.0


@pytest.mark.parametrize(
    ("simulation", "following", "usable", "remark"),
    [
        (None, None, True, "the axis file has no controller"),
        (Some(), Some(contradiction=1), True, "the simulated loop does not match the log"),
        (Some(), None, True, "a simulated loop is unstable"),
        (Some(), Some(contradiction=1), False, "measure again"),
    ],
)
def test_card_of_an_unknown_gain_has_its_reason(simulation, following, usable, remark):
    assert no_gain(simulation, following, None, usable=usable).remark == remark


@pytest.mark.parametrize(
    ("status", "is_shown"), [("held", True), ("identified", True), ("unidentifiable", False)]
)
def test_a_constant_force_is_on_the_card_only_if_it_is_known(stage, monkeypatch, status, is_shown):
    best = stage.identified.best
    levels = level_values(best)._replace(constant=2.0)
    monkeypatch.setattr("bristle.report.cards.level_values", lambda fit: levels)
    offset = replace(best.estimates[-1], name="offset", status=status)
    card = by_label(
        cards_of(replace(best, estimates=(*best.estimates[:-1], offset)), None, usable=True)
    )["Lowest sliding friction"]
    assert ("constant 2" in card.remark) is is_shown


def test_samples_of_a_fit_are_not_decimated(stage):
    best, treatment = stage.identified.best, stage.identified.treatment
    fine = fit_at_samples(best, stage.log, stage.axis, treatment)
    assert fine.traces.time.size > 0.8 * treatment["decimation"] * best.traces.time.size
    near = np.searchsorted(fine.traces.time, best.traces.time - 1e-9)
    # Decimation filters once more, which shows at reversals only.
    apart = np.abs(fine.traces.predicted[near] - best.traces.predicted)
    assert np.median(apart) < 0.01 * np.max(np.abs(best.traces.predicted))
    few = dict(treatment) | {"decimation": 1.0}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            import_module("bristle.prediction.predict"), "MOST_SAMPLES", len(stage.log) // 3
        )
        assert (
            fit_at_samples(best, stage.log, stage.axis, treatment).traces.time.size
            < 0.5 * fine.traces.time.size
        )
        assert (
            fit_at_samples(best, stage.log, stage.axis, few).traces.time.size
            > 0.5 * fine.traces.time.size
        )

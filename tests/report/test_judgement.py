"""The verdict on an identification and its first page."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.examples import data
from tests.identification.known_logs import (
    STATED,
    TRUTH,
    log_of,
    sines,
    sliding_effort,
    sliding_log,
)
from tests.report import known
from tests.report.known import estimate
from tests.report.pages import Page, plain
from tests.report.test_pages import identification_page

from bristle.core import Diagnostic, symbolic
from bristle.files import read_axis
from bristle.identification import Settings, identify, structure
from bristle.identification.estimate import MATTERS
from bristle.logs import Log, read_log
from bristle.models.friction import MODELS, find
from bristle.prediction import Following, drive_table, following_of, level_values, loop_of, predict
from bristle.prediction.claims import claims_for
from bristle.report import judgement, messages, model_tables, page
from bristle.report.brief import brief
from bristle.report.identification import (
    _correlations,
    identification_report,
    next_steps,
    why_only_similar,
)
from bristle.report.judgement import (
    ADVICE,
    DOUBTS,
    LACKING,
    WRITTEN_BY,
    _error,
    feedforward_of,
    judged,
    misfit,
    next_measurements,
    ruling_of,
)
from bristle.report.sentences import SENTENCES
from bristle.simulation import simulate, statistics_of

USUAL = Settings()


@pytest.fixture(scope="module")
def actual():
    return identify(sliding_log(), "coulomb_viscous", draws=0, blocks=3)


def doubted(fit, *diagnostics):
    return replace(fit, diagnostics=diagnostics)


def test_clean_log_is_usable(actual):
    assert judged(actual.best, USUAL) == ("usable", "Usable", ())


@pytest.mark.parametrize(
    ("code", "severity", "level"),
    [
        *((code, "warning", "with_care") for code in DOUBTS),
        ("structure", "note", "usable"),
        ("sign_reversed", "error", "measure_again"),
    ],
)
def test_severity_of_a_diagnostic_decides_with_its_reason(actual, code, severity, level):
    ruling = judged(doubted(actual.best, Diagnostic(code, severity=severity)), USUAL)
    assert (ruling.level, ruling.reasons) == (
        level,
        () if severity == "note" else (SENTENCES[code].means,),
    )


def with_open(fit, count, **changes):
    """Return a fit whose first parameters are not identified."""
    open_ = [
        replace(estimate, status="unidentifiable", **changes) for estimate in fit.estimates[:count]
    ]
    return replace(fit, estimates=(*open_, *fit.estimates[count:]))


def test_unidentified_parameters_ask_for_care_and_levels_for_another_log(actual):
    fit = doubted(actual.best)
    assert [estimate.name for estimate in fit.estimates] == ["M", "F_v", "F_C", "offset"]
    levels = [judged(with_open(fit, count), USUAL).level for count in range(5)]
    assert levels == ["usable", "with_care", "with_care", "measure_again", "measure_again"]


def test_zero_level_needs_no_other_log(actual):
    fit = doubted(actual.best)
    estimates = tuple(
        replace(item, value=0.0, status="at_edge") if item.name == "F_C" else item
        for item in fit.estimates
    )
    level, _, reasons = judged(replace(fit, estimates=estimates), USUAL)
    assert (level, reasons) == (
        "usable",
        ("not identified, but with little effect on the force: F_C",),
    )


@pytest.mark.parametrize(("takes", "level"), [(0.9, "usable"), (1.1, "with_care")])
def test_unidentified_parameter_of_little_effect_is_only_named(actual, takes, level):
    fit = doubted(actual.best)
    ruling = judged(
        with_open(fit, 1, effect=takes * MATTERS / abs(fit.parameters["M"].value)), USUAL
    )
    assert (ruling.level, ruling.reasons[-1][-1]) == (level, "M")


@pytest.mark.parametrize(
    ("half", "effect", "level", "reasons"),
    [
        (0.4, 1.0, "usable", ()),
        (0.6, 1.0, "with_care", ("roughly identified: F_v",)),
        (0.6, 1e-6, "usable", ()),
    ],
)
def test_wide_interval_asks_for_care_if_the_parameter_matters(actual, half, effect, level, reasons):
    fit = doubted(actual.best)
    viscous = fit.parameters["F_v"]
    wide = replace(
        viscous,
        interval=(viscous.value * (1.0 - half), viscous.value * (1.0 + half)),
        effect=effect,
    )
    estimates = tuple(wide if estimate is viscous else estimate for estimate in fit.estimates)
    ruling = judged(replace(fit, estimates=estimates), USUAL)
    assert (ruling.level, ruling.reasons) == (level, reasons)


def test_grave_faults_come_first_among_the_next_steps(actual):
    reversed_ = doubted(actual.best, Diagnostic("sign_reversed", severity="error"))
    assert next_steps(reversed_, usable=False) == [SENTENCES["sign_reversed"].advice]


def test_parameters_with_the_same_motion_share_a_line(actual, monkeypatch):
    by_excite = [
        (name, f"Move slowly.{WRITTEN_BY}`bristle excite AXIS.toml --for stribeck`")
        for name in ("F_S", "v_S")
    ]
    monkeypatch.setattr("bristle.report.identification.next_measurements", lambda fit: by_excite)
    message = next_steps(actual.best, usable=True)
    assert message == [
        "for F_S, v_S: generate a motion with `bristle excite AXIS.toml --for stribeck`"
    ]


def test_error_relative_to_friction_decides(actual):
    error = actual.best.friction_alone_error_percent
    for usable, useless, level in (
        (1.1, 2.0, "usable"),
        (0.9, 2.0, "with_care"),
        (0.5, 0.9, "measure_again"),
    ):
        settings = Settings.of({"usable_error": usable * error, "useless_error": useless * error})
        assert judged(doubted(actual.best), settings).level == level


def test_contradicted_loop_asks_for_care(actual):
    nothing = statistics_of(np.zeros(2))
    following = Following(
        np.zeros(2), np.zeros(2), nothing, contradiction=Diagnostic("loop_contradicts")
    )
    assert judged(doubted(actual.best), USUAL, following).level == "with_care"


@pytest.mark.slow
def test_levels_are_by_direction_without_the_weight():
    motion = sines(20.0, 2e-3, amplitudes=(0.03, 0.012, 0.004), frequencies=(0.31, 0.83, 2.3))
    effort = sliding_effort(motion, F_C=8.0) + np.where(motion.velocity > 0.0, 1.5, 0.0) + 20.0
    levels = level_values(
        identify(
            log_of(motion, effort), "coulomb+asymmetry", draws=0, blocks=0, cutoff=60.0, offset=20.0
        ).best
    )
    viscous = TRUTH["F_v"] * np.max(np.abs(motion.velocity))
    assert (levels.constant, levels.inertia) == pytest.approx((20.0, TRUTH["M"]), rel=0.01)
    assert levels.forward - levels.backward == pytest.approx(1.5 + 2.0 * TRUTH["offset"], abs=0.25)
    assert 8.0 < levels.backward + TRUTH["offset"] < 8.0 + viscous
    assert levels.deviation == pytest.approx(0.0, abs=1e-9)


def test_errors_come_before_warnings(actual):
    fit = doubted(
        actual.best,
        Diagnostic("delay_unknown", severity="warning"),
        Diagnostic("sign_reversed", "", "error", {"percent": 73.0}),
    )
    assert "sign of the effort" in messages.warnings_of(fit)[0]


@pytest.mark.parametrize(
    ("written", "text", "symbol"),
    [
        (symbolic, "F_C_neg", "<i>F</i><sub>C\u2212</sub>"),
        (symbolic, "sigma_0", "<i>σ</i><sub>0</sub>"),
        (symbolic, "`F_S`", "`F_S`"),
        (symbolic, "stribeck_free", "stribeck_free"),
        (symbolic, "a < b", "a &lt; b"),
        (symbolic, "M ± 2 %", "<i>M</i> ± 2 %"),
        (symbolic, "F+ 30 N", "<i>F</i><sub>+</sub> 30 N"),
        (
            page.worded,
            'F_C: `F_C = "2 N*m"`, not 2 N*m < 3',
            "<i>F</i><sub>C</sub>: <code>F_C = &#34;2 N*m&#34;</code>, not 2 N·m &lt; 3",
        ),
    ],
)
def test_parameter_names_are_symbols_and_code_is_not_typeset(written, text, symbol):
    assert written(text) == symbol


KIND = SimpleNamespace(kind="translational")


def measured(**changes):
    """A fit with model errors of 5 % of the effort and 12 % of friction, and a held-out error of 6 %."""
    known = {"plant": KIND, "levels": ("F_C",), "position_rmse": None, "loop_rmse": None}
    known |= {
        "force_error_percent": 5.0,
        "friction_alone_error_percent": 12.0,
        "missed_percent": 11.0,
        "error_percent": 5.0,
    }
    known |= {"held_out": SimpleNamespace(of="time blocks", mean_percent=6.0)}
    return SimpleNamespace(**known | changes)


HELD_OUT = "held-out error 6.00 %, over time blocks"
OF_EFFORT = "model error 5.00 % of the effort, 12.0 % of the friction"


@pytest.mark.parametrize(
    ("changes", "lines"),
    [
        ({}, [OF_EFFORT, HELD_OUT]),
        (
            {"position_rmse": 4e-7, "loop_rmse": 1.0},
            ["model error 0.400 µm of the position", HELD_OUT],
        ),
        ({"loop_rmse": 0.25}, ["model error 250 mN of the effort in the loop", HELD_OUT]),
        ({"held_out": None}, [OF_EFFORT, "no held-out stretches"]),
    ],
)
def test_model_error_is_in_the_quantity_of_the_fit(changes, lines):
    assert plain(misfit(measured(**changes))) == lines


@pytest.mark.parametrize(("percent", "larger"), [(6.2, False), (6.25, False), (6.3, True)])
def test_held_out_error_is_clearly_larger_above_a_quarter(percent, larger):
    text = misfit(measured(held_out=SimpleNamespace(of="time blocks", mean_percent=percent)))[1]
    assert ("clearly larger" in text) is larger


@pytest.mark.parametrize(
    ("changes", "percent"), [({}, 11.0), ({"position_rmse": 1e-6}, 5.0), ({"loop_rmse": 1.0}, 5.0)]
)
def test_error_of_the_simulation_decides_for_simulated_loops(changes, percent):
    assert _error(measured(**changes)) == percent


@pytest.mark.parametrize(
    ("error", "level"),
    [(20.0, "usable"), (20.1, "with_care"), (60.0, "with_care"), (60.1, "measure_again")],
)
def test_verdict_follows_the_error_limits_of_the_settings(error, level, monkeypatch):
    monkeypatch.setattr("bristle.report.judgement.level_values", lambda fit: None)
    ruling = judged(measured(missed_percent=error, diagnostics=(), estimates=()), USUAL)
    assert (ruling.level, len(ruling.reasons)) == (level, level != "usable")
    assert all(reason.startswith(f"the model error is {error:.3g} %") for reason in ruling.reasons)


def test_reasons_name_causes_and_unidentified_parameters(actual):
    fit = doubted(actual.best, Diagnostic("structure", "", "warning", {"causes": ("lag", "play")}))
    assert judged(fit, USUAL).reasons == (
        f"{SENTENCES['structure'].means}: friction that lags the speed, play of the drive",
    )
    first, second, third, *rest = fit.estimates
    edge = replace(doubted(fit), estimates=(replace(first, status="at_edge"), second, third, *rest))
    assert judged(edge, USUAL).reasons == (f"not identified: {first.name}",)
    held_fit = replace(
        doubted(fit), estimates=tuple(replace(item, status="held") for item in fit.estimates)
    )
    assert judged(held_fit, USUAL).reasons == ()
    twice = doubted(fit, *[Diagnostic("sign_reversed", "", "error", {"percent": 90.0})] * 2)
    assert judged(twice, USUAL).reasons == (SENTENCES["sign_reversed"].means,)


def test_next_motion_excites_the_unidentified_parameters():
    def variable(excitation):
        return SimpleNamespace(excitation=excitation)

    plant = SimpleNamespace(component=SimpleNamespace(variables={"M": variable("acceleration")}))
    contact = {
        "F_C": variable("sliding"),
        "v_S": variable("stribeck"),
        "k": variable("displacement"),
        "q": variable("nothing"),
    }
    friction = SimpleNamespace(component=SimpleNamespace(variables=contact))
    names = {
        "M": "at_edge",
        "F_C": "unidentifiable",
        "v_S": "identified",
        "k": "unidentifiable",
        "q": "at_edge",
        "far": "at_edge",
    }
    estimates = [
        SimpleNamespace(name=name, status=status, reason=None) for name, status in names.items()
    ]
    reported = next_measurements(
        SimpleNamespace(plant=plant, friction=friction, estimates=estimates)
    )
    assert [(item, WRITTEN_BY in motion) for item, motion in reported] == [
        ("M", True),
        ("F_C", True),
        ("k", False),
    ]
    assert reported[1][1].endswith(f"{WRITTEN_BY}`bristle excite AXIS.toml --for stribeck`")


def trusted(*halves, diagnostics=(), others=()):
    estimates = [estimate(f"p{k}", half=half) for k, half in enumerate(halves)]
    return known.fit(*estimates, estimate("M", status="held"), *others, diagnostics=diagnostics)


def test_effective_values_state_their_cause():
    lacking = Diagnostic("structure", numbers={"names": ("p0",)})
    assert why_only_similar(trusted(2.0, diagnostics=(lacking,))).startswith(
        "These are effective values, valid only for similar motions, because the model lacks a force"
    )
    assert why_only_similar(trusted(2.0)) == ""


def test_correlations_are_listed_strongest_first_without_zeros():
    values = np.array([[1.0, 0.004, -0.9], [0.004, 1.0, 0.5], [-0.9, 0.5, 1.0]])
    fit = SimpleNamespace(correlation=values, correlation_names=("a", "b", "c"))
    assert _correlations(fit).rows == [("a", "c", "−0.90"), ("b", "c", "+0.50")]
    values[0, 1], values[0, 2] = 0.0051, np.nan
    assert _correlations(fit).rows == [("b", "c", "+0.50"), ("a", "b", "+0.01")]
    many = SimpleNamespace(correlation=np.full((8, 8), 0.5), correlation_names="abcdefgh")
    assert len(_correlations(many).rows) == 20


def test_next_steps_are_errors_then_missing_models(actual):
    grave = Diagnostic("sign_reversed", "", "error", {"percent": 90.0})
    lacking = [
        Diagnostic("missing_lag", "", "warning", {"model": model})
        for model in ("lugre", "dahl", "lugre", "")
    ]
    fit = doubted(actual.best, grave, *lacking)
    tried = f"try a model with the missing force: `--model {fit.name},lugre,dahl`"
    assert next_steps(fit, usable=True) == [SENTENCES["sign_reversed"].advice, tried]
    assert next_steps(doubted(fit), usable=True) == [
        "enter the values on the machine, record again, and measure the gain with `bristle compare before.csv after.csv --axis axis.toml`"
    ]
    assert next_steps(doubted(fit), usable=False) == [
        "record the axis again, in both directions and at several speeds"
    ]


def test_every_cause_of_a_missing_force_has_words_of_its_own(actual):
    assert set(LACKING) == set(structure.CODES)
    fit = doubted(actual.best, Diagnostic("structure", "", "warning", {"causes": ("lag", "play")}))
    assert (
        judged(fit, USUAL).reasons[0].endswith(": friction that lags the speed, play of the drive")
    )


HELPS = "safe to try at gain 0.9; beside acceleration feedforward it helps quick moves of"


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({}, f"{HELPS} 3\u00a0mm or more with rests up to 0.3 s"),
        (
            {"claims": claims_for(1e-3) + claims_for(1.0)},
            f"{HELPS} 3\u00a0mm or more with rests up to 0.3 s; quick moves of 3\u00a0m or more with rests up to 0.3 s",
        ),
        ({"claims": ()}, "safe to try at gain 0.25"),
        (
            {"friction_alone_error_percent": 63.0},
            "do not try it: the model error is 63 % of the friction",
        ),
        (
            {"diagnostics": (Diagnostic("sign_reversed", severity="error"),)},
            f"do not try it: {SENTENCES['sign_reversed'].means}",
        ),
        (
            {"diagnostics": (Diagnostic("one_direction"),)},
            f"do not try it: {SENTENCES['one_direction'].means}",
        ),
        ({"position_rmse": 1e-6}, "not judged, because the model was fitted to the position"),
    ],
)
def test_a_feedforward_is_judged_by_the_model_and_the_log_and_not_by_open_parameters(
    changes, text, monkeypatch
):
    facts = {
        "diagnostics": (Diagnostic("structure"),),
        "friction_alone_error_percent": 20.0,
        "position_rmse": None,
        "estimates": (),
    }
    facts |= {
        "friction": SimpleNamespace(kind="translational"),
        "claims": claims_for(1e-3),
    } | changes
    monkeypatch.setattr(
        judgement,
        "compensation_of",
        lambda *_: SimpleNamespace(rule=SimpleNamespace(gain=0.9), claims=facts["claims"]),
    )
    assert feedforward_of(SimpleNamespace(best=SimpleNamespace(**facts), treatment={})) == text


def test_a_log_to_measure_again_may_give_a_feedforward(actual):
    fit = with_open(doubted(actual.best, Diagnostic("structure")), 4)
    again = replace(actual, fits=(fit,))
    assert judged(fit, USUAL).level == "measure_again"
    line = next(line for line in brief(again, None, None) if line.label == "Feedforward")
    assert line.text == feedforward_of(again) == "safe to try at gain 0.25"


def test_the_verdict_of_two_encoders_is_that_of_both_sides(actual):
    bad = SimpleNamespace(
        best=doubted(actual.best, Diagnostic("sign_reversed", severity="error")), settings=USUAL
    )
    good = SimpleNamespace(best=actual.best, settings=USUAL)
    sides = {"motor": good, "load": good}
    whole = SimpleNamespace(**vars(bad), two_masses=SimpleNamespace(load=good, sides=sides))
    assert ruling_of(whole) == judged(good.best, USUAL)
    sides["load"] = bad
    reasons = (f"friction of the load: {SENTENCES['sign_reversed'].means}",)
    assert ruling_of(whole)[::2] == ("measure_again", reasons)
    whole.two_masses.load = None  # one encoder
    assert ruling_of(whole) == judged(bad.best, USUAL)


def test_a_contradicted_loop_asks_for_care_with_two_encoders(actual):
    good = SimpleNamespace(best=actual.best, settings=USUAL)
    whole = SimpleNamespace(
        **vars(good), two_masses=SimpleNamespace(load=good, sides={"motor": good, "load": good})
    )
    code = next(iter(SENTENCES))
    contradicted = SimpleNamespace(contradiction=Diagnostic(code))
    assert ruling_of(whole).level == "usable"
    assert ruling_of(whole, contradicted) == (
        "with_care",
        "Use with care",
        (SENTENCES[code].means,),
    )


def test_the_feedforward_of_a_plant_with_two_masses_is_that_of_one_mass(actual):
    text = feedforward_of(actual)
    for masses, expected in ((None, text), (SimpleNamespace(), f"of one mass: {text}")):
        facts = {"best": actual.best, "two_masses": masses, "treatment": actual.treatment}
        assert feedforward_of(SimpleNamespace(**facts)) == expected


# --- The report of an identification


pytestmark = pytest.mark.usefixtures("undrawn")


def moved_by(shift):
    """A log whose effort is late by this many samples."""
    log = sliding_log()
    part = slice(50, 4050)
    effort = np.roll(log.effort.values, shift)[part]
    return Log(
        time=log.time.values[part],
        position=log.position.values[part],
        effort=effort,
        sample_time=1e-3,
    )


def told_of(log, **options):
    return " ".join(
        messages.assumptions_of(identify(log, "coulomb_viscous", draws=0, blocks=0, **options).best)
    )


@pytest.mark.fast_cases(1)
@pytest.mark.parametrize(("shift", "stands"), [(3, "lags"), (-3, "leads")])
def test_removed_delay_is_reported(shift, stands):
    words = (
        rf"the effort {stands} the position by \d\.\d+ ms \(\d\.\d\d samples; .*, and removed it"
    )
    assert re.search(words, told_of(moved_by(shift)))


@pytest.mark.slow
@pytest.mark.parametrize("options", [{"settings": {"delay_rough": 0.0}}, {"axis": STATED}])
def test_a_delay_that_hardly_shows_or_was_stated_is_not_told(options):
    assert ", and removed it" not in told_of(moved_by(3), **options)


def test_interval_of_the_table_uses_the_larger_error(workbench):
    fit = workbench.identified.best
    wider = tuple(replace(item, robust_std=item.std and 3.0 * item.std) for item in fit.estimates)
    table = model_tables.parameter_table(replace(fit, estimates=wider))
    shown = [row[table.heads.index("95 % interval [%]")] for row in table.rows]
    # Of what was found before any model, the interval itself is known.
    percents = [
        item.interval_percent if item.interval else 3.0 * 1.96 * item.relative_std_percent
        for item in fit.estimates
        if item.std
    ]
    assert [float(cell.removeprefix("± ")) for cell in shown if cell != "–"] == pytest.approx(
        percents, rel=0.06
    )


def test_unidentified_parameter_has_advice_to_measure(workbenches):
    bench = workbenches["rotational"]
    richer_first = replace(bench.identified, fits=bench.identified.fits[::-1])
    bench = replace(bench, identified=richer_first)
    unknown = [
        estimate.name
        for estimate in bench.identified.best.estimates
        if estimate.status == "unidentifiable"
    ]
    assert unknown
    words = Page(identification_page(bench)).words
    assert all(
        Page(page.worded(warning)).words in words
        for warning in messages.warnings_of(bench.identified.best)
    )
    for names, motion in next_measurements(bench.identified.best):
        assert Page(page.worded(f"{names}: {motion}")).words in words


def test_every_excitation_has_advice():
    requested = {
        variable.excitation for model in MODELS.values() for variable in model.variables.values()
    }
    assert requested - {""} <= set(ADVICE)


def test_report_has_assumptions_and_provenance(stage):
    words = Page(identification_page(stage)).words
    assert all(
        Page(page.worded(item)).words in words
        for item in messages.assumptions_of(stage.identified.best)
    )
    assert all(
        fact in words
        for fact in (
            "stage.csv",
            "0" * 64,
            "1 ms (1000 Hz)",
            "6 s",
            "made by a simulation",
            "column q",
        )
    )


def test_report_has_the_assumptions_of_the_prediction(stage):
    axis = replace(stage.axis, presliding=2e-6)
    best = stage.identified.best
    predicted = predict(best.plant, best.friction, stage.log, axis, "closed-loop")
    assumed = Page(identification_page(stage, prediction=predicted)).words.split("Assumptions")[-1]
    assert (
        "closed-loop prediction: bristle simulated the static friction with the pre-sliding distance of the axis file, 2 µm"
        in assumed
    )


@pytest.mark.slow
def test_parameters_at_an_edge_or_infinite_are_reported(stage):
    lugre = identify(stage.log, find("lugre"), axis=stage.axis, blocks=0, draws=0)
    assert (
        "∞"
        in Page(
            identification_page(stage, identification=lugre, simulation=None, prediction=None)
        ).words
    )
    assert [estimate.name for estimate in lugre.best.estimates if math.isinf(estimate.value)] == [
        "v_d"
    ]


@pytest.mark.slow
@pytest.mark.measured
def test_the_report_of_a_measured_axis():
    axis = read_axis(Path(__file__).parents[2] / "examples" / "emps" / "axis.toml")
    log = read_log(data.measured("emps", "DATA_EMPS.mat"), axis)
    identification = identify(log, "coulomb_viscous,coulomb_viscous+asymmetry", axis=axis, draws=0)
    best = identification.best
    loop = simulate(loop_of(best.plant, best.friction, log, axis))
    text = identification_report(
        identification,
        prediction=predict(best.plant, best.friction, log, axis, "closed-loop"),
        simulation=loop,
        table=drive_table(best),
        command="bristle identify",
        axis_name=axis.name,
        provenance={},
    )
    words = Page(text).words
    for told in (
        "model coulomb_viscous+asymmetry",
        "Values to enter into the drive",
        "lowers the following error",
    ):
        assert told in words


def test_unidentified_parameters_are_named_once_on_the_first_page(workbenches):
    bench = workbenches["rotational"]
    fit = bench.identified.best
    open_ = tuple(replace(estimate, status="unidentifiable") for estimate in fit.estimates)
    text = identification_page(
        bench, identification=replace(bench.identified, fits=(replace(fit, estimates=open_),))
    )
    assert (
        "the level of friction is not identified"
        in Page(text.partition('<div class="tabs">')[0]).words
    )
    assert "Values to enter" not in Page(text).words
    assert Page(text).words.count("not identified: M") == 1


def test_without_simulation_the_following_error_is_measured(stage):
    words = Page(
        identification_page(stage, simulation=None, following=following_of(stage.log))
    ).words
    assert [
        told in words for told in ("Following error in the log", "without and with compensation")
    ] == [True, False]

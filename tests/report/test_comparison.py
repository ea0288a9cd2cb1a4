"""Sentences and rows of a comparison, from changes with known numbers."""

import json
import pickle
from types import SimpleNamespace as Some

import pytest
from tests.prediction.comparison.machine import log, sine
from tests.report.pages import Page, seen_by

import bristle as br
from bristle.core import Diagnostic, InputError
from bristle.identification import identify as fitted
from bristle.prediction.comparison import Change, Comparison
from bristle.report import compared as sides_module, comparison as report, identified
from bristle.report.figures import as_csv, numbers_of

RMS = "following_error.rms"


def change(name=RMS, before=2e-5, after=1e-5, interval=(-1.2e-5, -0.8e-5)):
    return Change(
        name,
        "force" if name.startswith(("effort", "friction")) else "length",
        before,
        after,
        interval,
    )


def compared(*changes, diagnostics=(), turns=(), curve=(), logs=2, **shared):
    known = {
        "motions": 1,
        "paired": True,
        "cycles_before": 8,
        "cycles_after": 9,
        "complete": True,
        "before_percent": 100.0,
    }
    log = Some(
        source=Some(name="<a.csv>"),
        origin=Some(name="a.csv"),
        sample_time=1e-3,
        duration=4.0,
        notes=(),
    )

    return Some(
        kind="translational",
        changes={item.name: item for item in changes},
        diagnostics=diagnostics,
        shared=Some(**known | {"after_percent": 100.0} | shared),
        window=0.15,
        turns=turns,
        friction_curve=curve,
        helped=True,
        logs_before=[log] * logs,
        logs_after=[log] * logs,
    )


HIGHER = change(after=3e-5, interval=(0.8e-5, 1.2e-5))
OPEN = change(interval=(-2e-5, 1e-6))
ONCE = change(interval=None)
HARDLY = change(after=1.92e-5, interval=(-1.2e-6, -0.4e-6))


@pytest.mark.parametrize(
    ("item", "level", "words", "sentence"),
    [
        (change(), "usable", "It helped", "It helped: the following error is lower."),
        # From five percent on.
        (
            change(after=1.89e-5, interval=(-1.2e-6, -0.4e-6)),
            "usable",
            "It helped",
            "It helped: the following error is lower.",
        ),
        (
            HARDLY,
            "with_care",
            "It hardly helped",
            "It hardly helped: the following error is lower, by less than 5 %.",
        ),
        (HIGHER, "no", "It did not help", "It did not help: the following error is higher."),
        (
            OPEN,
            "with_care",
            "No clear change",
            "These logs do not show whether the change helped: the 95 % interval of the change in following error contains zero.",
        ),
        (
            ONCE,
            "with_care",
            "Effect unknown",
            "These logs do not show whether the change helped: a single cycle gives no interval.",
        ),
    ],
)
def test_verdict_follows_the_change_of_the_following_error(item, level, words, sentence):
    ruling = report.comparison_ruling(compared(item))
    assert (ruling.level, ruling.words) == (level, words)
    assert report.comparison_sentences(compared(item))[0] == sentence
    assert len(ruling.reasons) == (2 if item in (OPEN, ONCE) else 1)


def test_verdict_has_the_numbers_of_the_change():
    (reason,) = report.comparison_ruling(compared(change())).reasons
    assert (
        reason.replace("\u00a0", " ")
        == "following error, root mean square: 10 µm instead of 20 µm, −50 % (95 % interval −60 to −40 %)"
    )


DOUBT, NOTE = (
    Diagnostic("few_cycles", "", "warning", {"cycles": 3}),
    Diagnostic("one_recording", "", "note"),
)
FEW = "the cycles are too few to estimate their scatter"


@pytest.mark.parametrize(
    ("item", "diagnostics", "level", "reasons"),
    [
        (change(), (NOTE,), "usable", ()),
        (change(), (DOUBT, NOTE), "with_care", (FEW,)),
        (HIGHER, (DOUBT,), "no", (FEW,)),
        (change("effort.rms", 9.0, 8.0, (-1.5, -0.5)), (DOUBT,), "with_care", (FEW,)),
    ],
)
def test_warning_lowers_the_verdict_to_care(item, diagnostics, level, reasons):
    ruling = report.comparison_ruling(compared(item, diagnostics=diagnostics))
    assert (ruling.level, ruling.reasons[1:]) == (level, reasons)


def test_without_a_reference_the_effect_is_unknown():
    untold = report.comparison_ruling(compared(change("effort.rms", 9.0, 8.0, (-1.5, -0.5))))
    assert untold.reasons == ("without a reference, the following error is unknown",)
    assert (
        report.comparison_sentences(compared())[0]
        == "Without a reference, the effect on the following error is unknown."
    )


def test_each_quantity_has_its_interval():
    effort = change("effort.rms", 8.0, 9.0, (0.5, 1.5))
    level = change("friction.level", 5.0, 5.1, (-0.2, 0.4))
    peak = change("following_error.peak", 4e-5, 3e-5, None)
    assert report.comparison_sentences(compared(effort, level, peak))[1:] == [
        "Effort, root mean square: higher, 9 N instead of 8 N, +12.5 % (95 % interval +6.2 to +18.8 %).",
        "Friction level: no clear change, 5 N before and 5.1 N after, +2.0 % (95 % interval −4.0 to +8.0 %).",
        "Following error, largest in a cycle: 40 µm before, 30 µm after, with unknown uncertainty.",
    ]
    assert report.change_table(compared(effort, level, peak)).rows == [
        ("Effort, root mean square", "8 N", "9 N", "+12.5 %", "+6.2 to +18.8 %", "higher"),
        ("Friction level", "5 N", "5.1 N", "+2.0 %", "−4.0 to +8.0 %", "no clear change"),
        ("Following error, largest in a cycle", "40 µm", "30 µm", "−25 %", "–", "no interval"),
    ]


NARROW = change(interval=(-1e-5, -1e-5 + 1e-12))


@pytest.mark.parametrize(
    ("percent", "item", "text"),
    [
        (12.3, ONCE, "+12"),
        (-12.3, ONCE, "−12"),
        (0.0, ONCE, "0"),
        (12.3, NARROW, "+12.30"),
        (-12.3, NARROW, "−12.30"),
        (0.0, NARROW, "0.00"),
    ],
)
def test_percentage_has_its_sign(percent, item, text):
    assert report._signed(percent, item) == text


@pytest.mark.parametrize(
    ("shared", "turns", "words"),
    [
        (
            {},
            (),
            "bristle compared 8 cycles before and 9 after, of one motion. The intervals resample them in pairs",
        ),
        (
            {"motions": 3, "paired": False, "complete": False},
            (1,),
            "bristle compared 8 pieces before and 9 after, of 3 motions. The intervals resample them separately for each side. "
            "The window after a reversal is 150 ms",
        ),
    ],
)
def test_compared_cycles_are_listed_between_warnings_and_notes(shared, turns, words):
    remarks = report.remarks_of(
        compared(change(), diagnostics=(NOTE, DOUBT), turns=turns, **shared)
    )
    assert remarks[0].startswith("warning: one side has only 3 cycles")
    assert remarks[1] == words
    assert remarks[2].startswith("one side has a single log")


def front(item, files=None, **options):
    return report._front(
        compared(*item, **options), "axis", files or {"before": "a.csv", "after": ""}
    )


def test_first_page_has_gain_and_uncertainty():
    turn = change("reversals.forward_to_backward", 4e-5, 3e-5, (-2e-5, 1e-5))
    effort = change("effort.rms", 8.0, 9.0, (0.5, 1.5))
    page = front((change(), turn, effort))
    assert page.facts.endswith("8 and 9 cycles")
    title = "Following error: 20 → 10\u00a0µm rms, ×2.0"
    assert (page.heading, page.title, page.basis) == ("axis: before and after", title, "(a.csv)")
    assert [(card.label, card.value, card.remark) for card in page.cards] == [
        ("Following error, rms", "−50 %", "95 %: −60 to −40 %"),
        ("Forward to backward", "no clear change", "95 %: −50 to +25 %"),
        ("Effort, rms", "+12.5 %", "95 %: +6.2 to +18.8 %"),
    ]
    assert (page.next.text, page.next.command[:14]) == (
        "Keep the change, and identify the remaining friction",
        "bristle identi",
    )


def test_worse_change_advises_the_old_values():
    page = front((HIGHER,), logs=1)
    assert page.title == "Following error: 20 → 30\u00a0µm rms: no improvement"
    assert page.next == ("Undo the change, then", "bristle identify BEFORE --axis axis.toml")


@pytest.mark.parametrize(
    ("item", "also"), [((OPEN,), ""), ((ONCE,), ""), ((), ", with the reference")]
)
def test_unclear_change_asks_for_more_cycles(item, also):
    assert front(item).next.text == f"Record ten cycles or more of one motion on each side{also}"


@pytest.mark.parametrize(
    ("shared", "words"),
    [
        ({"before_percent": 98.0}, ["motion common to both: 98.0 % before, 100 % after"]),
        ({"after_percent": 98.9}, ["motion common to both: 100 % before, 98.9 % after"]),
        ({"after_percent": 99.0}, []),
    ],
)
def test_basis_has_the_motion_common_to_both(monkeypatch, shared, words):
    seen = seen_by(monkeypatch, report)
    monkeypatch.setattr(report, "log_facts", lambda *logs: [])
    report.comparison_report(compared(change(), **shared), name="axis")
    _, lines = seen["sections"][1].blocks
    assert [line.replace("\u00a0", " ") for line in lines.content[1:]] == words


def test_summary_of_a_comparison_is_grouped_by_quantity(monkeypatch):
    turn, level = (
        change("reversals.forward_to_backward"),
        change("friction.level", 5.0, 5.1, (-0.2, 0.4)),
    )
    monkeypatch.setattr(report, "_logs", len)
    summary = report.comparison_summary(
        compared(change(), turn, level, curve=((0.01, level),)), name="axis", provenance={}
    )
    assert (
        summary["following_error"]["rms"]["before"],
        summary["friction"]["at_speeds"][0]["speed"],
    ) == (2e-5, 0.01)
    assert (list(summary["reversals"]), summary["reversals"]["window"]) == (
        ["window", "forward_to_backward"],
        0.15,
    )
    expected = {
        "effort": None,
        "error_unit": "m",
        "effort_unit": "N",
        "logs": {"before": 2, "after": 2},
    }
    assert {name: summary[name] for name in expected} == expected
    bare = report.comparison_summary(compared(change()), name="axis", provenance={})
    assert (bare["reversals"], bare["friction"]) == (None, None)


# --- The result of a comparison: card, data, report and folder


@pytest.fixture(scope="module")
def result():
    return br.compare(log(1, sine(9)), log(2, sine(8), gain=0.7, friction=7.0))


def test_card_has_the_verdict_first(result):
    lines = repr(result).splitlines()
    assert len(lines) <= 30
    assert "It helped: the following error is lower." in lines[0]
    assert [line for line in lines if "Friction level" in line and line.endswith("lower")]
    assert "<table>" in result._repr_html_()


def test_comparison_is_plain_data(result):
    message = json.loads(json.dumps(result.to_dict(), allow_nan=False))
    rms = message["following_error"]["rms"]
    assert rms["change"] == pytest.approx(rms["after"] - rms["before"])
    assert rms["interval"][0] < rms["change"] < rms["interval"][1] < 0.0
    assert rms["interval_percent"][0] == pytest.approx(100.0 * rms["interval"][0] / rms["before"])
    assert message["helped"] is True
    assert message["reversals"]["window"] == result.window
    assert message["shared"]["cycles_before"] == 8
    assert [diagnostic["code"] for diagnostic in message["diagnostics"]] == [
        diagnostic.code for diagnostic in result.diagnostics
    ]


def test_data_frame_has_a_row_for_each_quantity(result):
    frame = result.to_dataframe()
    assert list(frame["quantity"]) == list(result.changes)
    assert ((frame["low"] <= frame["change"]) & (frame["change"] <= frame["high"])).all()
    assert set(frame["unit"]) == {"m", "N"}


def test_small_reduction_hardly_helped():
    message = br.compare(log(1, sine(12), scatter=0.0), log(2, sine(12), scatter=0.0, gain=0.97))
    assert message.changes["following_error.rms"].verdict == "lower"
    assert (
        message.sentences[0] == "It hardly helped: the following error is lower, by less than 5 %."
    )


@pytest.mark.usefixtures("undrawn")
def test_report_of_a_comparison_has_verdict_changes_and_command(result, tmp_path):
    page = Page(result.report(tmp_path / "report.html").read_text(encoding="utf-8"))
    assert not page.unbalanced
    for told in (
        "It helped",
        "bristle.compare('before', 'after')",
        "lower",
        "95 % interval",
        "Friction at the same speeds",
    ):
        assert told in page.words


@pytest.mark.slow
@pytest.mark.parametrize("left_out", ["reference", "effort"])
def test_report_without_reference_or_effort_has_a_figure(left_out, tmp_path):
    message = br.compare(log(1, sine(9), **{left_out: None}), log(2, sine(9), **{left_out: None}))
    page = Page(message.report(tmp_path / "report.html").read_text(encoding="utf-8"))
    assert page.named("svg")
    assert not page.unbalanced


def test_comparison_is_saved_once(result, tmp_path):
    folder = result.save(tmp_path / "compared")
    assert json.loads((folder / "summary.json").read_text()) == result.to_dict()
    assert (folder / "report.html").is_file()
    with pytest.raises(InputError):
        result.save(folder)


def test_comparison_survives_pickle(result):
    assert pickle.loads(pickle.dumps(result)).to_dict() == result.to_dict()


def test_figure_draws_the_numbers_of_the_changes(result):
    drawn = [as_csv(panel) for panel in numbers_of(result.plot())]
    assert len(drawn) == 6
    rows = [line for line in drawn[-1].splitlines() if ",change,points," in line]
    assert [float(row.split(",")[5]) for row in rows] == pytest.approx(
        [change.change_percent for change in result.changes.values()]
    )


# --- The call that repeats a result, with the names of its logs and models, and its options


def log_named(name="", source="<columns>"):
    return Some(origin=Some(name=name), source=Some(name=source))


@pytest.mark.parametrize(
    ("logs", "model", "axes", "options", "call"),
    [
        ([log_named("a.csv")], "lugre", [None], {}, "bristle.identify('a.csv', 'lugre')"),
        (
            [log_named("a.csv"), log_named("b.csv")],
            ["dahl", Some(name="own")],
            [None, 1],
            {},
            "bristle.identify(['a.csv', 'b.csv'], 'dahl,own', axis=axis)",
        ),
        (
            [log_named()],
            "lugre",
            [1],
            {"draws": 0},
            "bristle.identify('columns', 'lugre', axis=axis, draws=0)",
        ),
        (
            [log_named(source="<>")],
            "lugre",
            [None],
            {"draws": 1000},
            "bristle.identify('log', 'lugre')",
        ),
    ],
)
def test_call_of_an_identification_has_the_non_default_options(logs, model, axes, options, call):
    parameters = identified.signature(fitted)
    usual = parameters.parameters["draws"].default
    options = {name: usual if value == 1000 else value for name, value in options.items()}
    assert identified._call(logs, model, axes, options, parameters) == call


def test_models_have_their_names_in_the_call():
    assert identified._model_name(("a", Some(name="b"), ["c"])) == "a,b,c"
    assert identified._model_name(3) == "3"


@pytest.fixture
def sides(monkeypatch):
    """Comparisons of logs that are not read."""
    fields = dict.fromkeys(Comparison.__dataclass_fields__)
    seen = []
    monkeypatch.setattr(
        sides_module, "sides_compared", lambda *arguments: seen.append(arguments) or Some(**fields)
    )
    monkeypatch.setattr(sides_module, "axes_for", lambda axis, count: [axis] * count)
    monkeypatch.setattr(
        sides_module,
        "logs_and_axes",
        lambda logs, axes, size_limit: list(zip(logs, axes, strict=True)),
    )
    return seen


def test_call_of_a_comparison_has_both_sides(sides):
    first, second, third = log_named("a.csv"), log_named("b.csv"), log_named(source="<c.csv>")
    whole = sides_module.compared_as([first, second], third, axis=Some(name="stage"), window=0.1)
    assert whole.call == "bristle.compare(['a.csv', 'b.csv'], 'c.csv', axis=axis, window=0.1)"
    assert whole.axis_name == "stage"
    before, after, window = sides[0]
    assert ([item for item, _ in before], [item for item, _ in after], window) == (
        [first, second],
        [third],
        0.1,
    )
    plain = sides_module.compared_as(first, log_named(source="<>"))
    assert plain.call == "bristle.compare('a.csv', 'after')"
    assert (plain.axis_name, plain.read, plain.figures) == ("columns", {}, ())
    named_call = sides_module.compared_as(
        first, third, call="mine", name="press", read={"axis": 1}, figures=[1]
    )
    assert (named_call.call, named_call.axis_name, named_call.read, named_call.figures) == (
        "mine",
        "press",
        {"axis": 1},
        (1,),
    )


def test_unreadable_log_names_its_side(sides, monkeypatch):
    def fails(logs, axes, size_limit):
        raise InputError("is wrong", path=logs[0])

    monkeypatch.setattr(sides_module, "logs_and_axes", fails)
    for path, reported in (("log", "before: is wrong"), ("a.csv", "a.csv: is wrong")):
        with pytest.raises(InputError, match=reported):
            sides_module.compared_as([path], [path])


def test_axis_file_is_written_once(monkeypatch):
    texts = {"a": b"one", "b": b"one", "c": b"two", "d": None}
    monkeypatch.setattr("bristle.report.identified.axis_text", lambda axis, log: texts[axis])
    identification = Some(log=1, further_logs=(2, 3, 4), axes=("a", "b", "c", "d"))
    fields = dict.fromkeys(identified.Outcome.__dataclass_fields__)
    assert identified.Outcome(**fields | {"identification": identification})._axis_texts == (
        b"one",
        b"two",
    )

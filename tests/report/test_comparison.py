"""Sentences and rows of a comparison, from changes with known numbers."""

from types import SimpleNamespace as Some

import pytest

from bristle.comparison import Change
from bristle.core.diagnostic import Diagnostic
from bristle.report import comparison as report
from bristle.report.comparison import change_table, comparison_ruling, comparison_sentences, comparison_summary, remarks_of

RMS = "following_error.rms"


def change(name=RMS, before=2e-5, after=1e-5, interval=(-1.2e-5, -0.8e-5)):
    return Change(name, "force" if name.startswith(("effort", "friction")) else "length", before, after, interval)


def compared(*changes, diagnostics=(), turns=(), curve=(), logs=2, **shared):
    known = {"motions": 1, "paired": True, "cycles_before": 8, "cycles_after": 9, "complete": True, "before_percent": 100.0}
    log = Some(source=Some(name="<a.csv>"), origin=Some(name="a.csv"), sample_time=1e-3, duration=4.0, notes=())

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
        (HARDLY, "with_care", "It hardly helped", "It hardly helped: the following error is lower, by less than 5 %."),
        (HIGHER, "no", "It did not help", "It did not help: the following error is higher."),
        (
            OPEN,
            "with_care",
            "No clear change",
            "These logs do not show whether the change helped: the 95 % interval of the change in following error contains zero.",
        ),
        (ONCE, "with_care", "Effect unknown", "These logs do not show whether the change helped: a single cycle gives no interval."),
    ],
)
def test_verdict_follows_the_change_of_the_following_error(item, level, words, sentence):
    ruling = comparison_ruling(compared(item))
    assert (ruling.level, ruling.words) == (level, words)
    assert comparison_sentences(compared(item))[0] == sentence
    assert len(ruling.reasons) == (2 if item in (OPEN, ONCE) else 1)


def test_change_of_five_percent_helped():
    assert comparison_ruling(compared(change(after=1.89e-5, interval=(-1.2e-6, -0.4e-6)))).words == "It helped"


def test_verdict_has_the_numbers_of_the_change():
    (reason,) = comparison_ruling(compared(change())).reasons
    assert reason.replace("\u00a0", " ") == "following error, root mean square: 10 µm instead of 20 µm, −50 % (95 % interval −60 to −40 %)"


DOUBT, NOTE = Diagnostic("few_cycles", "", "warning", {"cycles": 3}), Diagnostic("one_recording", "", "note")
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
    ruling = comparison_ruling(compared(item, diagnostics=diagnostics))
    assert (ruling.level, ruling.reasons[1:]) == (level, reasons)


def test_without_a_reference_the_effect_is_unknown():
    untold = comparison_ruling(compared(change("effort.rms", 9.0, 8.0, (-1.5, -0.5))))
    assert untold.reasons == ("without a reference, the following error is unknown",)
    assert comparison_sentences(compared())[0] == "Without a reference, the effect on the following error is unknown."


def test_each_quantity_has_its_interval():
    effort = change("effort.rms", 8.0, 9.0, (0.5, 1.5))
    level = change("friction.level", 5.0, 5.1, (-0.2, 0.4))
    peak = change("following_error.peak", 4e-5, 3e-5, None)
    assert comparison_sentences(compared(effort, level, peak))[1:] == [
        "Effort, root mean square: higher, 9 N instead of 8 N, +12.5 % (95 % interval +6.2 to +18.8 %).",
        "Friction level: no clear change, 5 N before and 5.1 N after, +2.0 % (95 % interval −4.0 to +8.0 %).",
        "Following error, largest in a cycle: 40 µm before, 30 µm after, with unknown uncertainty.",
    ]
    assert change_table(compared(effort, level, peak)).rows == [
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
        ({}, (), "bristle compared 8 cycles before and 9 after, of one motion. The intervals resample them in pairs"),
        (
            {"motions": 3, "paired": False, "complete": False},
            (1,),
            "bristle compared 8 pieces before and 9 after, of 3 motions. The intervals resample them separately for each side. "
            "The window after a reversal is 150 ms",
        ),
    ],
)
def test_compared_cycles_are_listed_between_warnings_and_notes(shared, turns, words):
    remarks = remarks_of(compared(change(), diagnostics=(NOTE, DOUBT), turns=turns, **shared))
    assert remarks[0].startswith("warning: one side has only 3 cycles")
    assert remarks[1] == words
    assert remarks[2].startswith("one side has a single log")


def front(item, files=None, **options):
    return report._front(compared(*item, **options), "axis", files or {"before": "a.csv", "after": ""})


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
    assert (page.next.text, page.next.command[:14]) == ("Keep the change, and identify the remaining friction", "bristle identi")


def test_worse_change_advises_the_old_values():
    page = front((HIGHER,), logs=1)
    assert page.title == "Following error: 20 → 30\u00a0µm rms: no improvement"
    assert page.next == ("Undo the change, then", "bristle identify BEFORE --axis axis.toml")


@pytest.mark.parametrize("item", [(OPEN,), (ONCE,), ()])
def test_unclear_change_asks_for_more_cycles(item):
    assert front(item).next.text == "Record ten cycles or more of one motion on each side, with the reference"


@pytest.mark.parametrize(
    ("shared", "words"),
    [
        ({"before_percent": 98.0}, ["motion common to both: 98.0 % before, 100 % after"]),
        ({"after_percent": 98.9}, ["motion common to both: 100 % before, 98.9 % after"]),
        ({"after_percent": 99.0}, []),
    ],
)
def test_basis_has_the_motion_common_to_both(monkeypatch, shared, words):
    seen = {}
    monkeypatch.setattr(report, "report_page", lambda kind, facts, front, sections, **options: seen.update(sections=sections) or "")
    monkeypatch.setattr(report, "log_facts", lambda *logs: [])
    report.comparison_report(compared(change(), **shared), name="axis")
    _, lines = seen["sections"][1].blocks
    assert [line.replace("\u00a0", " ") for line in lines.content[1:]] == words


def test_summary_of_a_comparison_is_grouped_by_quantity(monkeypatch):
    turn, level = change("reversals.forward_to_backward"), change("friction.level", 5.0, 5.1, (-0.2, 0.4))
    monkeypatch.setattr(report, "_logs", len)
    summary = comparison_summary(compared(change(), turn, level, curve=((0.01, level),)), name="axis", provenance={})
    assert (summary["following_error"]["rms"]["before"], summary["friction"]["at_speeds"][0]["speed"]) == (2e-5, 0.01)
    assert (list(summary["reversals"]), summary["reversals"]["window"]) == (["window", "forward_to_backward"], 0.15)
    expected = {"effort": None, "error_unit": "m", "effort_unit": "N", "logs": {"before": 2, "after": 2}}
    assert {name: summary[name] for name in expected} == expected
    bare = comparison_summary(compared(change()), name="axis", provenance={})
    assert (bare["reversals"], bare["friction"]) == (None, None)

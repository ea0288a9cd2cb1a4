"""The report of a log, from passages and channels with known numbers."""

import json
from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest
from tests.identification.known_logs import sliding_log
from tests.report import known

from bristle.core import InputError
from bristle.identification import result, simulated_bands
from bristle.logs import BreakAway, Passage
from bristle.report import exported, log as report, log_tables


def passage(kind, begin=0.0, end=1.0, **changes):
    known = {
        "kind": kind,
        "begin": begin,
        "end": end,
        "legs": 0,
        "amplitudes": (1e-3, 2e-3),
        "speeds": (0.01, 0.02),
    }
    return known | {"frequencies": (), "depth": 0, "levels": 0} | changes


def test_passages_of_a_kind_share_a_row():
    table = log_tables.passage_table(
        [
            passage("moves", 1.0, 3.0),
            passage("rest", 3.0, 4.0),
            passage("moves", 4.5, 5.0, speeds=(0.04,)),
        ],
        "translational",
    )
    assert table.heads == [
        "Passages",
        "Count",
        "Total time [s]",
        "First begins at [s]",
        "Amplitude",
        "Speed",
    ]
    assert table.rows == [
        ["ordinary moves", "2", "2.5", "1", "1 mm to 2 mm", "10 mm/s to 40 mm/s"],
        ["rest", "1", "1", "3", "", ""],
    ]


def test_kinds_of_passages_have_a_fixed_order():
    table = log_tables.passage_table(
        [passage(kind) for kind in reversed(log_tables.KINDS)], "rotational"
    )
    assert [row[0] for row in table.rows] == list(log_tables.KINDS.values())
    assert "mrad" in table.rows[0][table.heads.index("Amplitude")]


@pytest.mark.parametrize(
    ("depth", "levels", "remark"),
    [
        (2, 1, "1 amplitude, not nested"),
        (3, 4, "4 amplitudes, nested 3 deep"),
        (0, 0, "0 amplitudes, not nested"),
    ],
)
def test_loops_are_reported_with_their_depth(depth, levels, remark):
    loops = passage("loops", legs=8, depth=depth, levels=levels)
    table = log_tables.passage_table([loops, passage("loops", legs=2)], "translational")
    row = dict(zip(table.heads, table.rows[0], strict=True))
    assert (row["Remark"], row["Legs"], row["Count"]) == (remark, "10", "2")


@pytest.mark.parametrize(
    ("passages", "remarks"),
    [
        (
            [
                passage("chirp", frequencies=(1.0, 9.0)),
                passage("oscillation"),
                passage("moves", frequencies=(3.0,)),
            ],
            ["1 Hz to 9 Hz", "", ""],
        ),
        ([passage("oscillation", frequencies=(2.0,))], ["2 Hz"]),
    ],
)
def test_oscillations_are_reported_with_their_frequencies(passages, remarks):
    assert [row[-1] for row in log_tables.passage_table(passages, "translational").rows] == remarks


def test_treatment_of_a_log_has_units():
    treatment = {
        "cutoff": 60.0,
        "decimation": 7.0,
        "delay": 1.234e-3,
        "rest_percent": 3.456,
        "velocity_max": 0.25,
        "other": 1.0,
    }
    assert log_tables.treatment_facts(treatment, "translational") == [
        ("Cut-off of the zero-phase filter", "60 Hz"),
        ("Samples for one row of the regression", "7"),
        ("Delay of the effort, identified", "0.00123 s"),
        ("Samples at rest, left out", "3.46 %"),
        ("Largest speed of the rows", "250 mm/s"),
    ]
    assert log_tables.treatment_facts({}, "translational") == []


def test_scatter_of_friction_is_in_percent():
    def scattering(share, kind="translational"):
        bands, scatter = (
            simulated_bands.Bands({}, share, 0.05, 1.5),
            result.Scatter(share, 0.02, 0.041),
        )
        return known.fit(
            kind=kind, resampling=result.Resampling(bands, scatter, 30, 1e-6, True, {})
        )

    assert log_tables.scatter_facts(scattering(0.0312)) == [
        ("Noise of the effort, sample by sample", "50 mN"),
        (
            "Scatter of friction from reversal to reversal",
            "3.1 %, 95 % interval 2.0 to 4.1 %, 30 half-cycles",
        ),
        ("Residual without noise, encoder steps and scatter", "1.5 N, root mean square"),
    ]
    assert log_tables.scatter_facts(scattering(0.0, "rotational")) == [
        ("Noise of the effort, sample by sample", "50 mN·m"),
        ("Residual without noise, encoder steps and scatter", "1.5 N·m, root mean square"),
    ]
    assert log_tables.scatter_facts(known.fit()) == []


def test_break_away_is_listed_by_rate_with_intervals():
    slow = BreakAway(1e-4, 4, 9.5, (9.0, 10.0), 2e-6, None)
    fast = BreakAway(1e-3, 5, 8.0, None, 1e-6, (1e-6, 1e-6))
    outcome = result.Identification((known.fit(),), sliding_log())
    assert log_tables.break_away_table(outcome) is None
    table = log_tables.break_away_table(replace(outcome, break_aways=(slow, fast)))
    assert table.heads == [
        "Rate [mm/s]",
        "Legs",
        "Force [N]",
        "95 % interval of the force",
        "Distance [µm]",
        "95 % interval of the distance",
    ]
    assert table.rows == [
        ["0.10", "4", "9.50", "9.00 to 10.00", "2.00", "–"],
        ["1.00", "5", "8.00", "–", "1.00", "1.00, to the last digit"],
    ]


def channel(values, unit, column):
    return Some(values=np.array(values), unit=unit, column=column)


def recorded(**changes):
    time, position, effort = (
        channel(np.arange(4) * 1e-3, "s", "t"),
        channel([0.0, 1e-3, 3e-3, 2e-3], "m", "x"),
        channel([1.0, -2.0, 3.0, 0.0], "N", "u"),
    )
    known = {
        "time": time,
        "position": position,
        "effort": effort,
        "reference": None,
        "kind": "translational",
        "sample_time": 1e-3,
    }
    known |= {
        "velocity": None,
        "origin": Some(name="a.csv", checksum="0f"),
        "source": Some(name="<a.csv>"),
        "segments": (slice(0, 4),),
    }
    known |= changes
    known["channels"] = lambda: [
        (name, known[name]) for name in ("time", "position", "effort") if known[name] is not None
    ]

    class Log(Some):
        def __len__(self):
            return 4

    return Log(**known)


def test_facts_of_a_log_are_file_samples_and_channels():
    assert log_tables.log_facts(recorded()) == [
        ("File", "a.csv"),
        ("SHA-256", "0f"),
        ("Samples", "4 in 1 stretch"),
        ("Sample time", "1 ms (1000 Hz)"),
        ("Duration", "4 ms"),
        ("Position", "column x, 0.000 to 3.000 mm"),
        ("Effort", "column u, −2.000 to 3.000 N"),
    ]
    odd = dict(log_tables.log_facts(recorded(sample_time=1.23456e-3)))
    assert (odd["Sample time"], odd["Duration"]) == ("1.235 ms (810.0 Hz)", "4.938 ms")
    facts = dict(
        log_tables.log_facts(
            recorded(segments=(1, 2)), [recorded(), recorded(origin=Some(name="b.csv"))]
        )
    )
    assert (facts["Samples"], facts["Further logs"]) == ("4 in 2 stretches", "a.csv, b.csv")


def diagnosed(code, severity):
    return {"code": code, "severity": severity, "message": code}


@pytest.mark.parametrize(
    ("severities", "effort", "level", "words", "reasons"),
    [
        ((), True, "usable", "The log can be identified", 0),
        (("note",), True, "usable", "The log can be identified", 0),
        (("warning", "warning"), True, "with_care", "Use with care", 1),
        (("warning", "error"), True, "no", "Correct the log first", 1),
        ((), False, "no", "Correct the log first", 1),
    ],
)
def test_errors_or_missing_effort_ask_to_correct_the_log(severities, effort, level, words, reasons):
    log = recorded() if effort else recorded(effort=None)
    ruling = report.log_ruling(log, [diagnosed("clipped", severity) for severity in severities])
    assert (ruling.level, ruling.words, len(ruling.reasons)) == (level, words, reasons)
    if not effort:
        assert ruling.reasons[0] == "the log has no effort, so friction is unknown"


def front_of(log, segments=(), diagnostics=()):
    return report._front(log, report.log_ruling(log, diagnostics), segments, "axis")


def test_first_page_of_a_log_has_durations_of_passages():
    segments = [
        Passage("moves", slice(0, 1), 0.0, 1.0),
        Passage("rest", slice(1, 2), 1.0, 3.0),
        Passage("moves", slice(2, 3), 3.0, 3.5),
    ]
    front = front_of(recorded(), segments)
    assert (front.title.replace("\u00a0", " "), front.basis) == (
        "Rest 2 s, ordinary moves 1.5 s",
        "(a.csv)",
    )
    assert [
        (card.label, card.value.replace("\u00a0", " "), card.remark) for card in front.cards
    ] == [
        ("Stroke", "3 mm", ""),
        ("Largest speed", "1.5 m/s", ""),
        ("Effort, span", "5 N", "column u"),
        ("Sample time", "1 ms", "4 samples"),
    ]
    assert front.facts.replace("\u00a0", " ").endswith("log a.csv, 4 ms · no reference")
    assert front.next.command == "bristle identify a.csv --axis axis.toml --out results"
    assert front_of(recorded()).title == "Motion without a known pattern"
    assert (
        front_of(recorded(position=channel([1.0] * 4, "m", "x"))).title == "The axis does not move"
    )


def test_first_page_of_a_log_lists_corrections():
    log = recorded(effort=None, reference=1, segments=(1, 2))
    doubts = [
        diagnosed("clipped", "warning"),
        diagnosed("resampled", "note"),
        diagnosed("clipped", "error"),
    ]
    front = front_of(log, (), doubts)
    assert report._advice(doubts) == ["Lower the acceleration, or widen the range of the channel"]
    assert (front.cards[2].value, front.cards[2].open, front.ruling.level) == ("–", True, "no")
    assert (front.next.text, front.next.command) == (
        "Correct the cause, then check the log again:",
        "bristle log a.csv --axis axis.toml",
    )
    assert "no reference" not in front.facts


@pytest.mark.slow
def test_page_is_written_only_for_a_readable_log(tmp_path):
    written = {}
    folder = Some(write=lambda name, text: written.update({name: text}))
    log, summary = (
        sliding_log(),
        {"file": "press.csv", "provenance": {"bristle": "0"}, "diagnostics": []},
    )
    report.Inspected.write(
        Some(log=log, axis=None, passages=(), summary=summary), folder, "bristle log press.csv"
    )
    assert set(written) == {"summary.json", "report.html"}
    assert "press: a log" in written["report.html"]
    written.clear()
    report.Inspected.write(Some(log=None, summary=summary), folder, "")
    assert set(written) == {"summary.json"}


# --- Files of an export for a target, and the loop in the folder of the model file


def written(effect=None, beside=(), error=None):
    product = Some(
        files={"a.c": "int a;", "a.h": b"h"}, effect=effect, notes=("one note",), error=error
    )
    return exported.ExportedModel("c", product, "lugre", {"bristle": "0"}, beside)


def test_export_is_reported_with_files_and_notes():
    assert written(beside=("another",)).summary == {
        "target": "c",
        "model": "lugre",
        "files": ["a.c", "a.h"],
        "notes": ["one note", "another"],
        "effect": None,
        "provenance": {"bristle": "0"},
    }
    assert written(Some(as_data=lambda: {"gain": 2.0})).summary["effect"] == {"gain": 2.0}
    assert written(error={"rms_percent": 3.0}).summary["error"] == {"rms_percent": 3.0}


def test_export_writes_files_and_summary():
    folder = {}
    written().write(Some(write=folder.__setitem__))
    assert list(folder) == ["a.c", "a.h", "summary.json"]
    assert json.loads(folder["summary.json"])["target"] == "c"


def test_loop_of_the_folder_uses_the_model_as_feedforward(tmp_path, monkeypatch):
    file, axis = tmp_path / "experiment.toml", Some(controller="law")
    variants = [Some(feedforward=Some(friction=friction)) for friction in (None, "lugre", "dahl")]
    monkeypatch.setattr("bristle.files.read_experiment", lambda file: Some(variants=variants))
    assert exported._loop_beside(file, "dahl", axis) == (None, ())  # there is no such file
    file.write_text("")
    assert exported._loop_beside(file, "dahl", axis) == (variants[2], ())
    for model, other in (("other", axis), ("dahl", None), ("dahl", Some(controller=None))):
        assert exported._loop_beside(file, model, other) == (None, ())


def test_unreadable_loop_gives_a_remark(tmp_path, monkeypatch):
    def fails(file):
        raise InputError("is broken")

    monkeypatch.setattr("bristle.files.read_experiment", fails)
    file = tmp_path / "experiment.toml"
    file.write_text("")
    remark = "bristle did not simulate the loop of experiment.toml: is broken"
    assert exported._loop_beside(file, "dahl", Some(controller="law")) == (None, (remark,))


@pytest.mark.parametrize("holds_operator", [True, False])
def test_operator_is_exported_with_its_constant_and_models_if_admitted(holds_operator, monkeypatch):
    admitted = []
    monkeypatch.setattr("bristle.files.holds_operator", lambda file: holds_operator)
    monkeypatch.setattr("bristle.files.read_operator", lambda file: ("operator", 2.0, None))
    monkeypatch.setattr(
        "bristle.files.read_model",
        lambda file, allow_code: ("plant", "friction", {"known": allow_code}),
    )
    monkeypatch.setattr(
        "bristle.models.hysteresis.with_constant", lambda operator, offset: (operator, offset)
    )
    monkeypatch.setattr("bristle.contract.admit", admitted.append)
    of_operator = (None, ("operator", 2.0), {"uncertainty": {}, "treatment": {}})
    assert exported._read("file", allow_code=True) == (
        of_operator if holds_operator else ("plant", "friction", {"known": True})
    )
    assert admitted == ([] if holds_operator else ["friction"])

"""The report of a log: verdict, its experiments and its problems."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bristle.core import SIZE_LIMIT, Axis, Diagnostic, InputError, Readable, unit_of
from bristle.files import SUMMARY, Inspection, Results, as_json
from bristle.identification import Explanation, explain
from bristle.logs import Log, Passage
from bristle.report.cards import Card, Step
from bristle.report.explained import tables_of
from bristle.report.log_tables import KINDS, log_facts, passage_table
from bristle.report.messages import advice_of, as_data
from bristle.report.page import Block, Front, Ruling, Section, about, report_page
from bristle.report.results import write_report
from bristle.report.sentences import SENTENCES
from bristle.report.table import capital, fixed


@dataclass(frozen=True)
class Inspected(Inspection):
    """The contents of a log, the explanation of its effort if asked for, and its report."""

    explanation: Explanation | None = None

    def write(self, folder: Results, command: str) -> None:
        """Write the numbers, and the report of a usable log, into a folder of results."""
        if self.log is None:
            folder.write(SUMMARY, as_json(self.summary))
            return
        page = log_report(
            self.log,
            self.passages,
            name=self.axis.name if self.axis else Path(self.summary["file"]).stem,
            command=command,
            provenance=self.summary["provenance"],
            diagnostics=self.summary["diagnostics"],
            explanation=self.explanation,
        )
        write_report(folder, page, self.summary)


def inspect_log(
    log: Readable,
    axis: Axis | None = None,
    *,
    size_limit: int = SIZE_LIMIT,
    with_explanation: bool = False,
) -> Inspected:
    """Return the contents of a log, with the explanation of its effort if asked for; without an axis also a proposed axis file."""
    inspected = Inspected.of(log, axis, size_limit=size_limit)
    data, proposal = inspected.summary, inspected.proposal
    diagnostics = [Diagnostic(**entry, kind=data["kind"]) for entry in data["diagnostics"]]
    if proposal is not None and {"columns.position.unit", "columns.velocity.unit"} & set(
        proposal.missing
    ):
        # Without a unit the size is unknown.
        diagnostics = [
            diagnostic
            for diagnostic in diagnostics
            if not (diagnostic.code == "unit_suspect" and "speed" in diagnostic.numbers)
        ]
    summary = data | {
        "diagnostics": as_data(diagnostics),
        "proposal": {"text": None, "missing": []},
        "explanation": None,
    }
    if proposal is not None:
        summary["proposal"] = {"text": proposal.text, "missing": list(proposal.missing)}
        if proposal.roles:
            summary["proposal"]["roles"] = [asdict(entry) for entry in proposal.roles]
        summary["notes"] = [*proposal.notes, *summary["notes"]]
    if not with_explanation:
        return replace(inspected, summary=summary)
    if inspected.log is None and summary["problems"]:
        return replace(inspected, summary=summary)
    explanation = explanation_of(inspected)
    summary["explanation"] = explanation.as_data()
    return replace(inspected, summary=summary, explanation=explanation)


def explanation_of(inspected: Inspected) -> Explanation:
    """Return the explanation of the effort of a log; refuse a log in unknown units."""
    if inspected.log is None:
        raise InputError(
            "cannot be explained, because units of its columns are unknown",
            path=inspected.summary["file"],
            mend="Describe its columns in an axis file: --write AXIS.toml proposes one",
        )
    return explain(inspected.log, inspected.axis)


def log_report(
    log: Log,
    segments: Sequence[Passage],
    *,
    name: str,
    diagnostics: Sequence[Mapping[str, Any]] = (),
    explanation: Explanation | None = None,
    **options: Any,
) -> str:
    """Return the report of a log as an HTML page; options as of `report_page`."""
    ruling = log_ruling(log, diagnostics)
    remarks = [
        Block("items", lines)
        for lines in (
            ruling.reasons,
            _advice(diagnostics),
            [entry["message"] for entry in diagnostics],
        )
    ]
    sections = [
        Section(
            "summary",
            "Summary",
            remarks if diagnostics or ruling.reasons else ["bristle found no problem in this log."],
        ),
        Section(
            "passages",
            "Contents",
            [passage_table([segment.as_data() for segment in segments], log.kind)],
        ),
        Section(
            "log",
            "The log",
            [Block("facts", log_facts(log), ("Recorded channels",)), Block("items", log.notes)],
        ),
    ]
    if explanation is not None:
        parts = [explanation.verdict, *tables_of(explanation), *explanation.notes]
        sections.insert(1, Section("explanation", "Forces", parts))
    facts = {
        "log": log,
        "passages": segments,
        "log_name": log.source.name.strip("<>"),
        "explanation": explanation,
    }
    return report_page("log", facts, _front(log, ruling, segments, name), sections, **options)


def log_ruling(log: Log, diagnostics: Sequence[Mapping[str, Any]]) -> Ruling:
    """Return the verdict on a log, with its reasons."""
    grave, doubts = (
        [
            SENTENCES[diagnostic["code"]].means
            for diagnostic in diagnostics
            if diagnostic["severity"] == severity
        ]
        for severity in ("error", "warning")
    )
    if log.effort is None:
        grave.insert(0, "the log has no effort, so friction is unknown")
    reasons = tuple(dict.fromkeys([*grave, *doubts]))
    if grave:
        return Ruling("no", "Correct the log first", reasons)
    return (
        Ruling("with_care", "Use with care", reasons)
        if doubts
        else Ruling("usable", "The log can be identified")
    )


def _advice(diagnostics: Sequence[Mapping[str, Any]]) -> list[str]:
    return [
        capital(line)
        for line in advice_of(entry["code"] for entry in diagnostics if entry["severity"] != "note")
    ]


def _front(log: Log, ruling: Ruling, segments: Sequence[Passage], name: str) -> Front:
    source, kind = log.source.name.strip("<>"), log.kind
    times: dict[str, float] = {}
    for segment in segments:
        times[segment.kind] = times.get(segment.kind, 0.0) + segment.end - segment.begin
    longest = sorted(times.items(), key=lambda entry: -entry[1])[:2]
    contents = ", ".join(f"{KINDS[kind]} {fixed(time, 's')}" for kind, time in longest)
    contents = contents or (
        "motion without a known pattern"
        if np.ptp(log.position.values)
        else "the axis does not move"
    )
    speed = (
        np.gradient(log.position.values, log.time.values)
        if log.velocity is None
        else log.velocity.values
    )
    cards = [
        Card("Stroke", fixed(float(np.ptp(log.position.values)), unit_of("length", kind))),
        Card("Largest speed", fixed(float(np.max(np.abs(speed))), unit_of("length/time", kind))),
        Card("Effort", "–", "not recorded", open=True),
        Card("Sample time", fixed(log.sample_time, "s"), f"{len(log)} samples"),
    ]
    if log.effort is not None:
        cards[2] = Card(
            "Effort, span",
            fixed(float(np.ptp(log.effort.values)), unit_of("force", kind)),
            f"column {log.effort.column}",
        )
    step = Step(
        "Identify the friction:",
        f"bristle identify {source or 'log.csv'} --axis axis.toml --out results",
    )
    if ruling.level == "no":
        step = Step(
            "Correct the cause, then check the log again:",
            f"bristle log {source or 'log.csv'} --axis axis.toml",
        )
    facts = about(
        f"log {source}, {fixed(len(log) * log.sample_time, 's')}",
        "" if log.reference is not None else "no reference",
    )
    return Front(
        f"{name}: a log",
        facts,
        ruling,
        title=capital(contents),
        basis=f"({source})" if source else "",
        cards=cards,
        next=step,
    )

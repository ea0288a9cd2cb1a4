"""``bristle paper --robust``: compensation on other frictions and under changed conditions."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

from bristle.cli.options import Figures
from bristle.cli.terminal import complain, progress, say, show_table

__all__ = ["Request", "try_robustness"]

USUAL_PLACE, USUAL_SEEDS = Path("bristle-robust"), 20


class Request(NamedTuple):
    """What is to be tried: truths by name or file, runs of each loop, axis file of a log, where results go."""

    truths: list[str]
    seeds: int | None
    axis: Path | None
    out: Path | None
    allow_code: bool


def try_robustness(command: str, request: Request, figures: Figures, *, as_json: bool) -> None:
    """Run the trial, write its report, and show its first tables."""
    from bristle.files.summary import as_json as json_text
    from bristle.files.summary import provenance
    from bristle.paper.robust.findings import best_table, claim_table
    from bristle.paper.robust.page import robust_report, robust_summary, words_of
    from bristle.paper.robust.trial import Plan, opened, run_trial
    from bristle.paper.robust.truths import truths_named
    from bristle.report.figure_files import figure_files
    from bristle.report.results import write_report
    from bristle.testing import admit

    truths = truths_named(_separated(request.truths), request.axis, allow_code=request.allow_code)
    for truth in truths:
        admit(truth.friction.component.inner)
    out, plan = request.out or USUAL_PLACE, Plan(tuple(truths), request.seeds or USUAL_SEEDS)
    with opened(out) as store, progress("beginning") as report, figure_files(store, *figures):
        try:
            trial = run_trial(plan, store, report)
        except KeyboardInterrupt:
            complain(f"{out} keeps the runs that are done; the same command goes on")
            raise
        report(1.0, "writing the report")
        made_from = provenance(command, **{truth.name: [truth.origin] for truth in truths})
        summary = robust_summary(trial, provenance=made_from)
        write_report(store, robust_report(trial, command=command, provenance=made_from), summary)
    if as_json:
        sys.stdout.write(json_text(summary))
        return
    show_table(claim_table(trial))
    show_table(best_table(trial))
    for sentence in words_of(trial):
        say(sentence)
    complain(f"wrote {out}; open {out / 'report.html'} in a browser")


def _separated(texts: list[str]) -> list[str]:
    """Return names that were typed with commas between them one by one; the name of a file may hold one."""
    return [name for text in texts for name in ([text] if Path(text).is_file() else text.split(","))]

"""The fleet on the command line: `identify --each`, and each joint of an arm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bristle.apps.arm.command import along_the_log, identified_arm, write_arm
from bristle.apps.study.command import exit_code, interruptible
from bristle.cli.options import Output, code_in, refuse, size_limit
from bristle.cli.terminal import progress, show_lines

if TYPE_CHECKING:
    from bristle.core import Axis, Content
    from bristle.report.page import Section


def identify_each(
    logs: Sequence[Path],
    axes: Sequence[Content],
    options: Mapping[str, Any],
    output: Output,
    *,
    readers: Sequence[Path],
    workers: int | None,
    robot: Path | None,
) -> int:
    """Identify each of many logs separately, or each axis of one log."""
    from bristle.apps.arm.report import arm_sections, arm_sentence, arm_summary
    from bristle.apps.study.fleet.identify import FleetStore, Identifier, fleet_of
    from bristle.apps.study.fleet.report import (
        failed_logs_table,
        fleet_report,
        fleet_ruling,
        fleet_sentences,
        fleet_summary,
        logs_table,
        parameters_table,
    )
    from bristle.apps.study.run import run_within
    from bristle.apps.study.store import opened, runs_in
    from bristle.core import content_of
    from bristle.files import axes_in, provenance
    from bristle.report.brief import verdict
    from bristle.report.cards import labelled
    from bristle.report.judgement import level_of
    from bristle.report.results import write_report

    refuse(
        {"bristle identify --each": output.out is None},
        "needs a folder to write into",
        "Add --out DIR",
    )
    assert output.out is not None
    options = dict(options)
    with progress("beginning") as report:
        if robot is None:
            arm = None
            described = _axes_of_joints(axes)
        else:
            arm = identified_arm(logs, axes, content_of(robot), report)
            described = arm.axes(output.out)
        fleet = fleet_of(
            logs,
            model=options.pop("model"),
            axes=described,
            name=output.out.name,
            options=options,
            size_limit=size_limit(),
            readers=[code_in(file) for file in readers],
        )
        source = provenance(output.command, axis=axes, reader=fleet.readers)
        with opened(output.out, fleet, source, FleetStore) as store:
            if arm:
                for name, text in arm.files.items():
                    store.grown.write(name, text)
            identifier = partial(Identifier, level_of=level_of)
            of_joints = any(map(axes_in, axes))
            if of_joints:
                identifier = partial(identifier, models=store.folder)
            with interruptible(output.out, "logs"):
                ran = run_within(store, workers=workers, progress=report, simulator=identifier)
            report(1.0, "writing the report")
            runs = runs_in(store.folder)
            summary = fleet_summary(runs, provenance=runs.described["provenance"])
            predictions = None
            further: Sequence[Section] = ()
            if arm:
                summary["arm"] = arm_summary(arm)
                predictions = along_the_log(store.folder, logs[0])
                further = arm_sections(arm)
            page = fleet_report(
                runs, summary, command=output.command, further=further, joints=predictions
            )
            write_report(store.grown, page, summary)
            if arm:
                write_arm(arm, store.grown)
    if of_joints:
        table = logs_table(runs, summary, brief=True)
        sentences = fleet_sentences(summary, "axes")
    else:
        table = parameters_table(summary)
        sentences = fleet_sentences(summary, "logs")
    if arm:
        sentences.append(arm_sentence(arm))
    if of_joints and not (output.as_json or output.quiet):
        show_lines([verdict(fleet_ruling(runs)), *labelled("Axes", sentences)])
    output.tell(summary, table, failed_logs_table(summary), *(() if of_joints else sentences))
    return exit_code(ran, summary)


def _axes_of_joints(axes: Sequence[Content]) -> list[Axis]:
    """Return the axes in some axis files, each file with one axis or with a table for each joint."""
    from bristle.files import axes_in, read_axis

    return [axis for file in axes for axis in list(axes_in(file).values()) or [read_axis(file)]]

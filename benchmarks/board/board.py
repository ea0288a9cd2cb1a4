"""The score board: results in numbers, as tables, and as a page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmarks.board.child import ABSENT
from benchmarks.board.run import Bench
from benchmarks.board.scores import OK, Score, over_cases
from benchmarks.board.task import SCORES
from bristle.core import number
from bristle.report.table import Table

PAGE, DATA = "score-board.md", "score-board.json"
ENTER = """## Enter a competitor

A competitor is one Python file, like [this example](../../examples/bench_competitor.py).
Run the board at the root of the source tree. With a named rival the table is there in a minute. A file alone meets all built-in
competitors:

```sh
python -m benchmarks board my_competitor.py stribeck --task known_axis
python -m benchmarks board my_competitor.py --task known_axis
```

| Function | Returns | Scores |
| --- | --- | --- |
| `fit(train)` | any object, from a list of records | |
| `predict(fitted, motion)` | effort at each sample, shape (sample,) | `force`, `reversals`, `loop` |
| `feedforward(fitted, reference)` | friction along the desired motion, or a controller, or both as a pair | `compensation` |
| `parameters(fitted)` | a dictionary with any of `M`, `F_C`, `F_S`, `v_S`, `sigma_0`, `sigma_2` | `parameters` |
| `fit_arm(train)`, `predict_arm(fitted, motion)` | efforts of all joints, shape (sample, joint) | `force` of an arm |

Only `fit` is necessary. Without the last two functions, `fit` and `predict` serve each joint of an arm. A record has `time`, `position`,
`velocity`, `acceleration`, `effort`, `sample_time`, `kind` and `axis`, in SI. In records to predict, `effort` is `None`.
`benchmarks.board.log_of(record)` returns a log for `bristle.identify`. `NEEDS = ("sklearn",)` names required libraries. The first line of
the docstring describes the competitor. `reference.axis.controller` is the law that a controller replaces.

A competitor runs in a separate process without the efforts of the tests, for at most 150 s of processor time and 630 s of waiting. The
process does not isolate hostile code: run only code that you trust. A result counts until the file of its competitor or task changes.
"""


def board(
    bench: Bench, finished: Mapping[str, Any], *, provenance: Mapping[str, str]
) -> dict[str, Any]:
    """Return the scores in percent, by score, task and competitor, with their 95 % intervals."""
    scores = dict[str, Any]()
    for score, description in SCORES.items():
        tasks: dict[str, Any] = {
            task.name: {} for task in bench.tasks if score in task.scores and not task.missing
        }
        for task, results in tasks.items():
            for competitor in bench.entered(score):
                units = [
                    unit
                    for unit in bench.units
                    if unit.task.name == task and unit.competitor == competitor
                ]
                cases = [
                    finished[unit.file]["scores"][score] for unit in units if unit.file in finished
                ]
                results[competitor.name] = _over_cases(cases, bench.seed)
        if tasks:
            scores[score] = {"description": description, "tasks": tasks}
    return {
        "date": bench.date,
        "seed": bench.seed,
        "bristle": version("bristle"),
        "scores": scores,
        "tasks": {task.name: task.title for task in bench.tasks},
        "competitors": {
            competitor.name: competitor.description for competitor in bench.competitors
        },
        "skipped": bench.skipped,
        "provenance": dict(provenance),
    }


def _over_cases(cases: Sequence[Mapping[str, Any]], seed: int) -> dict[str, Any]:
    """Return the score of a competitor on a task; a failed case is a failure on the task."""
    failed = [case for case in cases if case["status"] != OK]
    if not cases or failed:
        first = failed[0] if failed else {"status": ABSENT, "reason": ""}
        result = Score(status=first["status"], reason=first["reason"])._asdict()
    else:
        result = (
            dict(cases[0])
            if len(cases) == 1
            else over_cases([case["value"] for case in cases], seed)._asdict()
        )
    return result | {"cases": len(cases), "failed": len(failed)}


def ranks(tasks: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    """Return the mean rank of each competitor over the tasks of a score, the best first; a missing score ranks last."""
    places: dict[str, list[float]] = {}
    for results in tasks.values():
        values = {
            name: result["value"] if result["status"] == OK else np.inf
            for name, result in results.items()
        }
        for name, value in values.items():
            better, equal = (
                sum(map(compare, values.values())) for compare in (value.__gt__, value.__eq__)
            )
            places.setdefault(name, []).append(better + 0.5 * (equal + 1))
    means = {name: float(np.mean(listed)) for name, listed in places.items()}
    return dict(sorted(means.items(), key=lambda entry: entry[1]))


def verdicts(summary: Mapping[str, Any]) -> list[str]:
    """Return the best competitors of each score, in a sentence."""
    sentences = []
    for score, entry in summary["scores"].items():
        values_of = [
            {name: result["value"] for name, result in task.items() if result["status"] == OK}
            for task in entry["tasks"].values()
        ]
        best = Counter(min(values, key=values.__getitem__) for values in values_of if values)
        listed = (
            ", ".join(f"{name} ({count})" for name, count in best.most_common()) or "no competitor"
        )
        sentences.append(f"Smallest {score} score, by number of tasks: {listed}.")
    return sentences


def failures(summary: Mapping[str, Any]) -> list[str]:
    """Return each reason of a failure of a competitor, with its scores and tasks."""
    places: dict[tuple[str, str], list[str]] = {}
    for score, entry in summary["scores"].items():
        for task, results in entry["tasks"].items():
            for name, result in results.items():
                if result["failed"] and result["status"] != ABSENT:
                    places.setdefault((name, result["reason"] or result["status"]), []).append(
                        f"{score} on {task}"
                    )
    return [f"`{name}`, {', '.join(listed)}: {reason}" for (name, reason), listed in places.items()]


def tables(summary: Mapping[str, Any]) -> list[Table]:
    """Return a table for each score, the competitor with the best mean rank first."""
    listed = []
    for score, entry in summary["scores"].items():
        rows = [
            (
                name,
                *(_cell(results[name]) for results in entry["tasks"].values()),
                number(rank, resolution=0.1),
            )
            for name, rank in ranks(entry["tasks"]).items()
        ]
        caption = f"{score.capitalize()}: {entry['description']}, with 95 % interval"
        listed.append(Table(caption, ("Competitor", *entry["tasks"], "Mean rank"), rows))
    return listed


def _cell(result: Mapping[str, Any]) -> str:
    """Return a score with its interval as text, or the reason of a missing score."""
    if result["status"] != OK:
        return (
            f"{result['status']}, {result['failed']} of {result['cases']}"
            if result["cases"] > 1
            else result["status"]
        )
    value, lower, upper = (number(result[name], digits=3) for name in ("value", "lower", "upper"))
    return f"{value} ({lower} to {upper})"


def page(summary: Mapping[str, Any]) -> str:
    """Return the score board as a page in Markdown."""
    parts = [
        "# Score board",
        "<!-- Written by python -m benchmarks board. -->",
        f"`{summary['provenance']['command']}` made this page with bristle {summary['bristle']}. The date {summary['date']} is the "
        "seed of all simulated axes. Smaller scores are better. The intervals are a bootstrap over blocks of a record, or over simulated "
        "axes. [Enter a competitor](#enter-a-competitor) · [numbers](score-board.json)",
        "\n".join(f"- {sentence}" for sentence in verdicts(summary)),
    ]
    for table in tables(summary):
        rows = [table.heads, ["---"] * len(table.heads), *table.rows]
        head, _, text = table.caption.partition(": ")
        parts += [
            f"## {head}",
            f"{text[0].upper()}{text[1:]}.",
            "\n".join(f"| {' | '.join(row)} |" for row in rows),
        ]
    lists = {"Failures": [f"- {text}" for text in failures(summary)]} | {
        head: [f"- `{name}`: {text}" for name, text in summary[head.lower()].items()]
        for head in ("Skipped", "Tasks", "Competitors")
    }
    parts += [f"## {head}\n\n" + "\n".join(lines) for head, lines in lists.items() if lines]
    return "\n\n".join([*parts, ENTER])

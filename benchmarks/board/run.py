"""Run the tasks with all competitors: each result is stored whole in the folder, and a second run continues."""

from __future__ import annotations

import ast
import json
import threading
import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.board.child import ABSENT, NEEDED, SLOW, Fault, Orders, answers
from benchmarks.board.record import Data
from benchmarks.board.scores import ANSWER_OF, scored
from benchmarks.board.task import Task, tasks_named
from bristle.apps.study.run import in_words
from bristle.core import (
    Abreast,
    Content,
    InputError,
    Progress,
    content_of,
    core_count,
    did_you_mean,
)
from bristle.files import CODE_LIMIT, Growing, as_json

FOLDER = Path(__file__).with_name("competitors")
COMPETITORS = tuple(sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "__init__"))
LIMIT = 150.0  # [s] of processor time for one competitor on one case
SLOW_AXIS = "another simulated axis of this task took too long"
_LOCK = threading.Lock()


class Competitor(NamedTuple):
    """A competitor: its file, the names that this defines, its description, and a reason why it cannot run."""

    name: str
    content: Content
    defined: frozenset[str]
    description: str
    missing: str

    @property
    def is_file(self) -> bool:
        """Whether the competitor is a file of the user."""
        return self.content.source.parent != FOLDER

    def enters(self, score: str) -> bool:
        """Return whether the file defines the function behind a score."""
        return NEEDED[ANSWER_OF[score]] in self.defined


def competitors_named(names: Sequence[str]) -> tuple[Competitor, ...]:
    """Return competitors by the names of built-in ones, or by Python files, which come first; files alone meet all built-in ones."""
    files = [name for name in names if name.endswith(".py")]
    for name in names:
        if name not in COMPETITORS and name not in files:
            allowed, mend = (
                f"{', '.join(COMPETITORS)}, or a Python file",
                did_you_mean(name, COMPETITORS),
            )
            raise InputError(
                "is not a competitor", path="COMPETITOR", value=name, allowed=allowed, mend=mend
            )
    built_in = [name for name in COMPETITORS if name in names or len(files) == len(names)]
    entered = [
        _competitor(content_of(file, limit=CODE_LIMIT))
        for file in (*files, *(FOLDER / f"{name}.py" for name in built_in))
    ]
    titles = [competitor.name for competitor in entered]
    if twice := next((title for title in titles if titles.count(title) > 1), ""):
        raise InputError(
            "has the name of another competitor",
            path="COMPETITOR",
            value=twice,
            mend="Rename the file",
        )
    return tuple(entered)


def _competitor(content: Content) -> Competitor:
    """Read names, description and required libraries from the text of a file, without running it."""
    path = str(content.source)
    try:
        tree = ast.parse(content.data)
    except (SyntaxError, ValueError) as error:
        raise InputError(f"is not Python ({error})", path=path, mend="Correct the file") from None
    assigned = {
        node.id: part.value
        for part in tree.body
        if isinstance(part, ast.Assign)
        for node in ast.walk(part)
        if isinstance(node, ast.Name)
    }
    imported = (
        alias.asname or alias.name
        for part in tree.body
        if isinstance(part, ast.ImportFrom)
        for alias in part.names
    )
    defined = frozenset(
        (
            *assigned,
            *imported,
            *(part.name for part in tree.body if isinstance(part, ast.FunctionDef)),
        )
    )
    if "fit" not in defined or defined.isdisjoint({*NEEDED.values(), "fit_arm"}):
        lacking = "predict, feedforward or parameters" if "fit" in defined else "fit"
        raise InputError(
            f"defines no function {lacking}",
            path=path,
            mend="Write def fit(train), and def predict(fitted, motion)",
        )
    lacking = [
        name
        for name in ast.literal_eval(assigned.get("NEEDS", ast.Tuple([])))
        if find_spec(name) is None
    ]
    missing = f"{', '.join(lacking)} is not installed" if lacking else ""
    return Competitor(
        content.source.stem,
        content,
        defined,
        (ast.get_docstring(tree) or "").partition("\n")[0],
        missing,
    )


class Unit(NamedTuple):
    """One competitor on one case of a task."""

    task: Task
    case: str
    competitor: Competitor

    @property
    def file(self) -> str:
        """Name of the file of the result."""
        return f"{self.task.name}.{self.case.replace(' ', '-')}.{self.competitor.name}.json"

    @property
    def made_from(self) -> dict[str, str]:
        """Version and checksums behind a result."""
        return {
            "bristle": version("bristle"),
            "task": self.task.checksum,
            "competitor": self.competitor.content.checksum,
        }


Results = Generator[tuple[Unit, dict[str, Any]], None, None]


@dataclass(frozen=True)
class Bench:
    """Tasks and competitors of a run, and the date that draws the simulated axes."""

    tasks: tuple[Task, ...]
    competitors: tuple[Competitor, ...]
    date: str

    @property
    def seed(self) -> int:
        """Seed of all draws: the digits of the date."""
        return int(self.date.replace("-", ""))

    @property
    def skipped(self) -> dict[str, str]:
        """Tasks and competitors that cannot run here, with the reason."""
        listed = {"task": self.tasks, "competitor": self.competitors}
        return {
            f"{word} {part.name}": part.missing
            for word, parts in listed.items()
            for part in parts
            if part.missing
        }

    def entered(self, score: str) -> list[Competitor]:
        """Return the competitors with the function behind a score."""
        return [competitor for competitor in self.competitors if competitor.enters(score)]

    def further(self, folder: Growing) -> int:
        """Return the number of results of this date in the folder that do not belong to this run."""
        files = {f"{self.date}/{unit.file}" for unit in self.units}
        return sum(name.startswith(f"{self.date}/") and name not in files for name in folder.names)

    @property
    def units(self) -> list[Unit]:
        """Results of this run, those of one case together."""
        able = [competitor for competitor in self.competitors if not competitor.missing]
        cases = ((task, case) for task in self.tasks if not task.missing for case in task.cases)
        return [
            Unit(*pair, competitor)
            for pair in cases
            for competitor in able
            if any(map(competitor.enters, pair[0].scores))
        ]

    def run(
        self, folder: Growing, workers: int | None = None, progress: Progress | None = None
    ) -> dict[str, Any]:
        """Return the results by file; run only those that the folder lacks."""
        finished, missing = dict[str, Any](), list[Unit]()
        for unit in self.units:
            earlier = json.loads(folder.read(f"{self.date}/{unit.file}") or b"{}")
            if earlier.get("made_from") == unit.made_from:
                finished[unit.file] = earlier
            else:
                missing.append(unit)
        before, spent, threads = len(finished), 0.0, workers or core_count()
        result_of = partial(self._result, slow=set())
        with closing(_results(result_of, missing, threads)) as results:
            for unit, result in results:
                text = as_json(result)
                folder.write(f"{self.date}/{unit.file}", text)
                finished[unit.file], spent = json.loads(text), spent + result["seconds"]
                left = (
                    spent
                    / (len(finished) - before)
                    * (before + len(missing) - len(finished))
                    / threads
                )
                if progress is not None:
                    progress(
                        len(finished) / (before + len(missing)),
                        f"{len(finished)} of {before + len(missing)} results, {in_words(left)} left",
                    )
        return finished

    def _result(self, unit: Unit, slow: set[tuple[str, str]]) -> dict[str, Any]:
        """Return the scores of a competitor on a case, not tried if another case of the task was too slow; `slow` holds these."""
        import time

        task, case, competitor = unit
        functions = tuple(
            dict.fromkeys(ANSWER_OF[score] for score in task.scores if competitor.enters(score))
        )
        with _LOCK:
            data = _data(task.name, case, self.seed)
        began = time.monotonic()
        if (task.name, competitor.name) in slow:
            answered = dict.fromkeys(functions, Fault(SLOW, SLOW_AXIS))
        else:
            answered = answers(Orders.of(competitor.content, functions, data), LIMIT)
        if any(isinstance(answer, Fault) and answer.status == SLOW for answer in answered.values()):
            slow.add((task.name, competitor.name))
        replies = dict.fromkeys(ANSWER_OF.values(), Fault(ABSENT)) | answered
        scores = {
            name: score._asdict()
            for name, score in scored(task.scores, replies, data, self.seed).items()
        }
        return {"made_from": unit.made_from, "scores": scores, "seconds": time.monotonic() - began}


def _results(
    result_of: Callable[[Unit], dict[str, Any]], units: Sequence[Unit], threads: int
) -> Results:
    """Yield each unit with its result, as they finish."""
    if threads == 1:
        yield from ((unit, result_of(unit)) for unit in units)
        return
    # The filters of warnings are those of all threads: each thread would restore the filters of another.
    with warnings.catch_warnings(action="ignore"), Abreast(threads) as pool:
        futures = {pool.submit(result_of, unit): unit for unit in units}
        yield from ((futures[future], future.result()) for future in as_completed(futures))


@lru_cache(2)
def _data(task: str, case: str, seed: int) -> Data:
    """Return the data of a case, once for all competitors."""
    return tasks_named((task,))[0].data(case, seed)


def date_in(folder: Path) -> str:
    """Return the last date with results in a folder; empty without results."""
    return max((path.name for path in folder.glob("????-??-??") if path.is_dir()), default="")

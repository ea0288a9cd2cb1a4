"""Do alarms come in time, and how often for nothing? Lives of axes that wear, watched by `bristle.fleet`.

A small fleet is real from end to end: a stranger's simulator (`benchmarks.strangers`, which shares no code with the
package) makes the logs of two axes, one of which wears quickly; each is written, identified and watched. Lives of
hundreds of days have too many logs for that. Their friction is that of `benchmarks.lives`, and what an identification
makes of a log is drawn: error and interval together, from those of the small fleet, whose truth is known.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from benchmarks.coverage import Share
from benchmarks.lives import Errors, Life, lived, rows_of
from benchmarks.strangers import Truth, draw, make_record
from bristle.core.axis import Axis
from bristle.fleet.false_alarms import FalseAlarms
from bristle.fleet.identify import identify_each
from bristle.fleet.tracks import tracks_of
from bristle.fleet.watched import Verdict, verdict_on
from bristle.fleet.watched import watch as watched_over
from bristle.study.dataset import runs_in

__all__ = ["errors_of", "first_alarm", "fleet_made", "watch", "write_logs"]

RATE = FalseAlarms(1.0, 1000.0, "days")
LIVES, HEALTHY = 50, 100
DAYS, ONSETS = 320, (60.0, 110.0)
FLEET_DAYS, FLEET_ONSET = 30, 14.0
AXES = {"healthy": None, "worn": FLEET_ONSET}
OF_LEVEL = "friction.F_C"


def write_logs(folder: Path, days: int = FLEET_DAYS) -> dict[str, tuple[Truth, Life]]:
    """Write a log a day of two axes, in a folder each; return what is true of them."""
    truths = {}
    for number, (name, onset) in enumerate(AXES.items()):
        truth = draw(4 + number, "coulomb", "strokes", True)
        life = lived(40 + number, days, onset=onset, over=20.0)
        life = Life(*(values[::2] for values in vars(life).values()))
        truths[name] = truth, life
        (folder / name).mkdir()
        for log in range(life.time.size):
            _write(folder / name, truth, life, log)
    return truths


def worn(truth: Truth, life: Life, log: int) -> Truth:
    """Return what is true of an axis at one of its logs."""
    friction = truth.friction
    level, viscous = (
        {key: tuple(factor * side for side in getattr(friction, key)) for key in keys}
        for factor, keys in ((life.level[log], ("F_C", "F_S")), (life.viscous[log], ("F_v",)))
    )
    return replace(truth, seed=1000 * truth.seed + log, friction=replace(friction, **level, **viscous))


def _write(folder: Path, truth: Truth, life: Life, log: int) -> None:
    record = make_record(worn(truth, life, log))
    stamp = datetime.fromtimestamp(float(life.time[log]), UTC).strftime("%Y-%m-%dT%H-%M")
    rows = slice(0, 50) if life.fails[log] else slice(None)  # a recorder that stopped too early
    effort = record.effort * truth.recording.force_per_effort
    warm = np.full(record.t.size, life.temperature[log])
    np.savetxt(
        folder / f"{folder.name}_{stamp}.csv",
        np.column_stack((record.t, record.position, effort, warm))[rows],
        fmt=("%.6f", "%.9f", "%.6f", "%.3f"),
        delimiter=",",
        header="time [s],position [m],effort [N],temperature [K]",
        comments="",
    )


def fleet_made(folder: Path, days: int = FLEET_DAYS, **options: object) -> dict[str, tuple[Truth, Life]]:
    """Write logs and identify each of them into ``fleet`` in a folder; return what is true of the axes."""
    (folder / "logs").mkdir()
    truths = write_logs(folder / "logs", days)
    axis = Axis(columns=AXIS_COLUMNS)
    identify_each([folder / "logs"], folder / "fleet", axis=axis, **options)
    return truths


def _columns() -> dict[str, object]:
    from bristle.core.axis import Column

    units = {"time": "s", "position": "m", "effort": "N", "temperature": "K"}
    return {name: Column(name, "", unit) for name, unit in units.items()}


AXIS_COLUMNS = _columns()


def errors_of(fleet: Path, truths: dict[str, tuple[Truth, Life]]) -> Errors:
    """Return what the identifications of a fleet were off by."""
    columns = runs_in(fleet).columns
    good = np.flatnonzero(columns["status"] == "ok")
    at = np.array([np.sum(columns["folder"][:place] == name) for place, name in enumerate(columns["folder"])])
    true = {
        column: np.array([float(np.mean(getattr(worn(*truths[columns["folder"][place]], int(at[place])).friction, key))) for place in good])
        for column, key in ((OF_LEVEL, "F_C"), ("friction.F_v", "F_v"))
    }
    half = {name: 0.5 * (columns[f"{name}.upper"] - columns[f"{name}.lower"])[good] / true[name] for name in true}
    ends = np.column_stack([columns["scatter.lower"], columns["scatter.upper"]])[good]
    return Errors({name: columns[name][good] / true[name] - 1.0 for name in true}, half, columns["scatter"][good], ends)


def verdicts_on(lives: dict[str, Life], errors: Errors, seed: int) -> dict[str, list[Verdict]]:
    """Return what is said of each quantity of each axis."""
    tracks = tracks_of(rows_of(lives, errors, seed))
    found: dict[str, list[Verdict]] = {name: [] for name in lives}
    for track in tracks:
        found[track.axis].append(verdict_on(track, RATE, sum(track.axis == own.axis for own in tracks)))
    return found


def first_alarm(verdicts: list[Verdict]) -> float | None:
    """Return the day of the first alarm of an axis [days since 1970]; None where there is none."""
    return min((verdict.alarm.at for verdict in verdicts if verdict.alarm is not None), default=None)


def in_time(seed: int, errors: Errors) -> bool:
    """Whether the alarm comes after wear has begun and before a third of its ten percent."""
    onset = float(np.random.default_rng((seed, 1)).uniform(*ONSETS))
    life = lived(seed, DAYS, onset=onset)
    at = first_alarm(verdicts_on({"axis": life}, errors, seed)["axis"])
    if at is None:
        return False
    wear = abs(float(np.interp(at, life.time / 86400.0, life.wear)))
    return 0.0 < wear <= 0.1 / 3.0


def false_alarms(seeds: range, errors: Errors) -> tuple[int, float]:
    """Return how many false alarms healthy axes raise, and in how many axis-days until then."""
    alarms, exposed = 0, 0.0
    for seed in seeds:
        life = lived(seed, DAYS)
        at = first_alarm(verdicts_on({"axis": life}, errors, seed)["axis"])
        days = life.time / 86400.0
        alarms += at is not None
        exposed += float((days[-1] if at is None else at) - days[0])
    return alarms, exposed


def watch() -> Iterator[Share]:
    """Alarms of lives that wear, and false ones of healthy fleets, after a small fleet that is real to the end."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        truths = fleet_made(folder, draws=20)
        errors = errors_of(folder / "fleet", truths)
        watched = watched_over(folder / "fleet", false_alarms="1 in 1000 days")
        told = {verdict.track.axis for verdict in watched.alarms if verdict.track.quantity == OF_LEVEL}
    yield Share(
        "small fleet: axes told rightly",
        100.0 * ("worn" in told) * (told == {"worn"}),
        100.0,
        100.0,
        2,
        f"{errors.count} logs, level off by {100.0 * np.std(errors.error[OF_LEVEL]):.2g} %",
    )
    caught = [in_time(seed, errors) for seed in range(LIVES)]
    yield Share(
        "alarm before a third of the wear",
        100.0 * np.mean(caught),
        90.0,
        100.0,
        LIVES,
        f"10 % in 200 days, {errors.count} identifications drawn from",
    )
    alarms, exposed = false_alarms(range(1000, 1000 + HEALTHY), errors)
    yield Share(
        "false alarms, of those allowed",
        100.0 * 1000.0 * alarms / exposed,
        0.0,
        100.0,
        HEALTHY,
        f"{alarms} in {exposed:.0f} axis-days of healthy axes",
    )

"""The report of a watch over fleets: which axes changed, since when and by how much, and what the others look like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

import numpy as np

from bristle.core.typography import interval_text, number, with_unit
from bristle.report.page import Picture, picture, render
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.fleet.watched import Verdict, Watched

__all__ = ["alarms_table", "watch_report", "watch_sentences", "watch_summary"]

OK = "ok"
DRAWN_MOST = 8
FAILURES_SHOWN = 20


def watch_summary(watched: Watched, *, provenance: Mapping[str, str]) -> dict[str, Any]:
    """Return a watch in numbers, in SI, times as text where logs say them."""
    status = watched.rows.columns["status"]
    axes = np.array(watched.rows.axis)
    return {
        "alarm": bool(watched.alarms),
        "false_alarms": watched.false_alarms.words,
        "logs": len(status),
        "failed": int(np.sum(status != OK)),
        "axes": {
            axis: {
                "logs": int(np.sum(axes == axis)),
                "failed": int(np.sum((axes == axis) & (status != OK))),
                "quantities": {verdict.track.quantity: _verdict(verdict) for verdict in watched.verdicts if verdict.track.axis == axis},
            }
            for axis in dict.fromkeys(watched.rows.axis)
        },
        "provenance": dict(provenance),
    }


def _verdict(verdict: Verdict) -> dict[str, Any]:
    track, alarm = verdict.track, verdict.alarm
    values = np.exp(verdict.fitted) if track.is_logarithmic else verdict.fitted
    return {
        "unit": track.unit,
        "observations": track.time.size,
        "from": _date_of(verdict, track.time[0]),
        "until": _date_of(verdict, track.time[-1]),
        "level": float(values[-1]),
        "evidence": float(verdict.ratio[-1]),
        "threshold": verdict.threshold,
        "temperature_coefficient": verdict.temperature_coefficient,
        "temperature_interval": verdict.temperature_interval,
        "neighbours_alike": verdict.alike,
        "alarm": None
        if alarm is None
        else {
            "at": _date_of(verdict, alarm.at),
            "onset": _date_of(verdict, alarm.onset),
            "onset_interval": [_date_of(verdict, end) for end in alarm.onset_interval],
            "course": alarm.course,
            "before": alarm.before,
            "change": alarm.change,
            "change_interval": list(alarm.change_interval),
            "change_percent": alarm.change_percent,
        },
    }


def _date_of(verdict: Verdict, time: float) -> str | int:
    """Return a time of a track as text, or the number of the log where no dates are known."""
    if not verdict.track.is_dated:
        return int(time)
    return (datetime(1970, 1, 1, tzinfo=UTC) + timedelta(days=float(time))).strftime("%Y-%m-%d")


def _spoken(verdict: Verdict, time: float) -> str:
    date = _date_of(verdict, time)
    return date if isinstance(date, str) else f"log {date}"


def watch_sentences(watched: Watched) -> list[str]:
    """Return what a watch comes to, in sentences, alarms first."""
    axes = len(dict.fromkeys(watched.rows.axis))
    alarms = watched.alarms
    changed = len({verdict.track.axis for verdict in alarms})
    head = f"{changed} of {axes} axes changed" if changed else f"None of {axes} axes changed" if axes > 1 else "No change"
    lines = [f"{head}, at a rate of {watched.false_alarms.words} for false alarms."]
    lines += [_sentence(verdict) for verdict in alarms]
    failed = int(np.sum(watched.rows.columns["status"] != OK))
    if failed:
        lines.append(f"{failed} of {len(watched.rows.axis)} logs failed and tell nothing.")
    alike = [verdict for verdict in watched.verdicts if verdict.alike is not None]
    if alike:
        words = ", ".join(f"{_name(verdict)} ({verdict.alike:.2f})" for verdict in alike)
        lines.append(f"Neighbouring days are alike, so that false alarms are more frequent than said: {words}.")
    silent = [axis for axis in dict.fromkeys(watched.rows.axis) if axis not in {verdict.track.axis for verdict in watched.verdicts}]
    if silent:
        lines.append(f"Too few logs tell anything of {', '.join(silent)}.")
    return lines


def _sentence(verdict: Verdict) -> str:
    alarm = verdict.alarm
    if alarm is None:
        return ""
    way = {True: "rises", False: "falls"} if alarm.course == "drift" else {True: "rose at once", False: "fell at once"}
    return (
        f"{_name(verdict)} {way[alarm.change > 0.0]}: {_amount(verdict, alarm.change)} (95 % interval "
        f"{_interval(verdict)}) since {_spoken(verdict, alarm.onset)}; alarm on {_spoken(verdict, alarm.at)}."
    )


def _name(verdict: Verdict) -> str:
    return f"{verdict.track.axis}, {verdict.track.quantity}"


def _amount(verdict: Verdict, change: float) -> str:
    """Return a change as a person says it: in percent of the level before."""
    alarm = verdict.alarm
    percent = 100.0 * change / abs(alarm.before) if alarm is not None else 0.0
    return f"{number(percent, 0.1)}\u00a0%"


def _interval(verdict: Verdict) -> str:
    alarm = verdict.alarm
    if alarm is None:
        return ""
    low, high = (_amount(verdict, end) for end in alarm.change_interval)
    return interval_text(low, high)


def alarms_table(watched: Watched) -> Table | None:
    """Return the changes, the earliest alarm first."""
    rows = []
    for verdict in watched.alarms:
        alarm, track = verdict.alarm, verdict.track
        if alarm is None:
            continue
        rows.append(
            (
                track.axis,
                track.quantity,
                _spoken(verdict, alarm.at),
                _spoken(verdict, alarm.onset),
                " to ".join(_spoken(verdict, end) for end in alarm.onset_interval),
                alarm.course,
                with_unit(alarm.before, track.unit or "1"),
                _amount(verdict, alarm.change),
                _interval(verdict),
            )
        )
    heads = ("Axis", "Quantity", "Alarm", "Began", "95 % interval", "Course", "Before", "Change", "its 95 % interval")
    return Table("Alarms, the earliest first", heads, rows) if rows else None


def tracks_table(watched: Watched) -> Table:
    """Return each track in a line."""
    rows = []
    for verdict in watched.verdicts:
        track = verdict.track
        coefficient = verdict.temperature_coefficient
        level = float(np.exp(verdict.fitted[-1]) if track.is_logarithmic else verdict.fitted[-1])
        per_kelvin = None if coefficient is None else 100.0 * coefficient / (1.0 if track.is_logarithmic else abs(level))
        rows.append(
            (
                track.axis,
                track.quantity,
                str(track.time.size),
                with_unit(level, track.unit or "1"),
                "" if per_kelvin is None else f"{number(per_kelvin, 0.01)} %/K",
                number(float(verdict.ratio[-1]), 0.1),
                number(verdict.threshold, 0.1),
                "alarm" if verdict.alarm else "",
            )
        )
    heads = ("Axis", "Quantity", "Observations", "Level now", "By temperature", "Evidence [σ]", "Threshold [σ]", "Verdict")
    return Table("Every track", heads, rows).without_empty_columns()


def failed_table(watched: Watched) -> Table | None:
    """Return the logs that failed, with their reason."""
    columns = watched.rows.columns
    failed = np.flatnonzero(columns["status"] != OK)
    rows = [(watched.rows.axis[place], watched.rows.log[place], str(columns["reason"][place])) for place in failed]
    caption = "Logs that failed" + (" (the first of them)" if len(rows) > FAILURES_SHOWN else "")
    return Table(caption, ("Axis", "Log", "Reason"), rows[:FAILURES_SHOWN]) if rows else None


def watch_report(watched: Watched, summary: Mapping[str, Any], *, name: str, command: str) -> str:
    """Return the report of a watch as one HTML page."""
    axes = len(summary["axes"])
    facts = f"{summary['logs']} logs of {axes} {'axis' if axes == 1 else 'axes'}"
    return render(
        "watch.html",
        provenance=summary["provenance"],
        command=command,
        banner=None,
        name=name,
        facts=f"{facts} · false alarms {summary['false_alarms']}",
        sentences=watch_sentences(watched),
        alarms=alarms_table(watched),
        picture=_picture(watched),
        tracks=tracks_table(watched),
        failed=failed_table(watched),
    )


def _drawn(watched: Watched) -> Sequence[Verdict]:
    """Return what is drawn: what changed first, then what is nearest to an alarm."""
    rest = [verdict for verdict in watched.verdicts if verdict.alarm is None]
    rest.sort(key=lambda verdict: float(verdict.ratio[-1]) / verdict.threshold, reverse=True)
    return [*watched.alarms, *rest][:DRAWN_MOST]


def _picture(watched: Watched) -> Picture:
    from bristle.figures import fleet_tracks

    drawn = _drawn(watched)
    earliest = min(drawn, key=lambda verdict: float(verdict.track.time[0]))
    first = _spoken(earliest, float(np.floor(earliest.track.time[0]))) if earliest.track.is_dated else ""
    more = len(watched.verdicts) > len(drawn)
    return picture(
        "tracks",
        lambda: fleet_tracks(drawn, [_name(verdict) for verdict in drawn], first),
        "Quantities of the axes over time, and the evidence of a change",
        "Left, what the logs of a day say, the temperature taken off where there is one, and the level that goes with "
        "it; shaded is where a change began, by its 95 % interval. Right, the evidence of a change and the threshold "
        f"that it must exceed.{' What changed, and what is nearest to it.' if more else ''}",
    )

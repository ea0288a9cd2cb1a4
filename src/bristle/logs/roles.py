"""Recognise the channels among the columns of a file, from names, units and similar motion."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bristle.core import unbounded, units
from bristle.core.axis import LOAD_ENCODER
from bristle.logs.table import Table, axis_in, without_index
from bristle.logs.words import (
    Meaning,
    converts,
    is_of_load,
    is_of_motor,
    is_time,
    meaning_of,
    unit_in_name,
    unit_of_time,
    without_part,
    words_of,
)


@dataclass(frozen=True, eq=False)
class Candidate:
    """A column that can be a channel."""

    name: str
    values: np.ndarray
    unit: str
    unit_source: str
    meaning: Meaning
    axis: tuple[str, str] | None = None
    unknown: str = ""

    def is_apart_from(self, position: Candidate) -> bool:
        """Return whether the addresses of two signals name different axes."""
        return self.axis is not None and position.axis is not None and self.axis != position.axis

    def is_one_of(self, bases: Iterable[str]) -> bool:
        """Return whether its unit belongs to one of several quantities."""
        return bool(self.unit) and any(units.compatible(self.unit, base) for base in bases)

    def fits(self, role: str, bases: Iterable[str]) -> bool:
        """Return whether the column fits a role: by its unit if it has one, else by its name."""
        if self.unit:
            return self.is_one_of(bases) and self.meaning.role in ("", role, "status")
        return self.meaning.role == role


def candidate_of(table: Table, name: str, is_nameless: bool) -> Candidate | None:
    """Return a column as a candidate; None for times of other columns, short columns and text."""
    values = table.columns[name]
    if name in table.stamps.values() or values.size < 20:
        return None
    finite = np.isfinite(values)
    if not finite.any():
        return None
    filled = np.where(finite, values, np.median(values[finite]))
    unit, unit_source, unknown = table.units.get(name, ""), "header", table.unknown_unit(name)
    if not unit or unknown:
        unit, unit_source = unit_in_name(name), "name"
    about = table.about.get(name, "")
    meaning = Meaning() if is_nameless else meaning_of(name, about)
    if meaning.role == "velocity" and converts(unit, "Hz"):
        unit, unit_source = "rev/s", "Hz"
    axis = axis_in(name) or axis_in(about) or table.joints.get(name)
    return Candidate(name, filled, unit, unit_source if unit else "", meaning, axis, unknown)


def time_among(table: Table, columns: list[Candidate]) -> tuple[Candidate, str] | None:
    """Return the time column, and the reason; None if there is none, or each column has separate times."""
    if table.stamps:
        return None
    rises = {column.name: float(np.mean(np.diff(column.values) > 0.0)) for column in columns}
    rising = [
        column
        for column in columns
        if rises[column.name] > 0.5 and column.values[-1] > column.values[0]
    ]
    called = [
        column for column in columns if column.meaning.role == "time" and is_time(column.name)
    ]
    # Repeated stamps of a host rise with pauses.
    # At least 0.02 of the steps of a time rise.
    halting = [
        column
        for column in called
        if np.all(np.diff(column.values) >= 0.0) and rises[column.name] >= 0.02
    ]
    called = [column for column in called if column in rising or column in halting]
    named = [column for column in called if not column.unit or column.is_one_of(("s",))]
    named += [column for column in rising if column.is_one_of(("s",)) and column not in named]
    for column in rising if not named and table.sample_time is None else ():
        step = np.diff(column.values)
        # A time column without a usual name rises evenly; it also has no pause, unless it is the first column.
        even = np.quantile(np.abs(step - np.median(step)), 0.95) <= 0.05 * np.median(step)
        unnamed = (
            column.meaning.role in ("", "status")
            if column is columns[0]
            else not column.meaning.role and np.all(step > 0.0)
        )
        if even and unnamed and not column.unit and not column.unknown and not np.all(step == 1.0):
            named.append(column)
    return (named[0], "its name" if named[0] in called else "it rises evenly") if named else None


EDGE = 20


def rate_of(position: np.ndarray, times: np.ndarray | None) -> np.ndarray:
    """Return the smoothed rate of a signal over time, or over its samples if there is no time."""
    from scipy.ndimage import uniform_filter1d

    smooth = uniform_filter1d(position, int(np.clip(position.size // 2000, 3, 15)))
    if times is None or times.size != position.size:
        return np.gradient(smooth)
    steps = np.gradient(np.linspace(times[0], times[-1], times.size))
    # Of the unit of time, from sample to sample: smaller steps are no time.
    return np.gradient(smooth) / (steps if np.all(steps > 1e-15) else 1.0)


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Return the correlation of two signals, 0 if one of them is constant."""
    if first.size != second.size or first.size < EDGE:
        return 0.0
    about = (signal - signal.mean() for signal in (first, second))
    # Scaled to at most 1, so that squares neither overflow nor underflow.
    a, b = (signal / (float(np.max(np.abs(signal))) or 1.0) for signal in about)
    scale = float(np.sqrt(np.dot(a, a) * np.dot(b, b)))
    return float(np.dot(a, b)) / scale if scale > 0.0 else 0.0


def slope(first: np.ndarray, second: np.ndarray) -> float:
    """Return the factor from `first` to `second`, apart from a constant."""
    a, b = first - first.mean(), second - second.mean()
    scale = float(np.dot(a, a))
    return float(np.dot(a, b)) / scale if scale > 0.0 else 0.0


def roughness(values: np.ndarray) -> float:
    """Return the ratio of the second differences of a signal to its first differences."""
    first, second = np.diff(values), np.diff(values, 2)
    scale = float(np.std(first))
    return float(np.std(second)) / scale if scale > 0.0 else np.inf


def explained(effort: np.ndarray, position: np.ndarray) -> float:
    """Return the share of a signal that inertia, friction and a constant explain, given a motion."""
    return 1.0 - float(np.var(_left(effort, [*_moving(position), position]))) / (
        float(np.var(effort)) or 1.0
    )


def pulls_as_a_link(effort: np.ndarray, angle: np.ndarray) -> bool:
    """Return whether an effort follows sine and cosine of an angle [rad], better than a parabola of it."""
    # Over less than 1.0 [rad] the sine of an angle is nearly a straight line.
    if effort.size != angle.size or effort.size < 4 * EDGE or float(np.ptp(angle)) < 1.0:
        return False
    within = slice(EDGE, -EDGE)  # rates at the ends are invalid
    motion = [column[within] for column in _moving(angle)]
    effort, angle = effort[within], angle[within]
    place = angle - angle.mean()
    alone, parabola, link = (
        float(np.var(_left(effort, [*motion, *more])))
        for more in ((), (place, place**2), (np.sin(angle), np.cos(angle)))
    )
    # The angle must explain 0.25 of the effort that motion leaves unexplained, and more than a parabola does.
    return link < (1.0 - 0.25) * min(alone, parabola)


def _moving(position: np.ndarray) -> list[np.ndarray]:
    """Return the effects of inertia and friction along a motion."""
    velocity = rate_of(position, None)
    return [
        rate_of(velocity, None),
        velocity,
        np.sign(velocity) * (np.abs(velocity) > 0.02 * np.max(np.abs(velocity))),
    ]


def _left(effort: np.ndarray, columns: list[np.ndarray]) -> np.ndarray:
    """Return the residual of a signal after a fit of some columns and a constant."""
    scaled = [column / (np.std(column) or 1.0) for column in columns]
    design = np.column_stack([*scaled, np.ones(effort.size)])
    return effort - design @ unbounded(design, effort)


MOVEMENTS = ("m", "rad", "count")
SPEEDS = ("m/s", "rad/s", "count/s")
EFFORTS = ("N", "N*m", "A", "rated", "V")
ALIKE, ALMOST_SAME = 0.9, 0.995  # correlation of a velocity, or of a reference, with the position
WITHIN = 0.03  # of a factor between two units
GUESSED = 0.3  # share explained by the motion, for an effort without a usual name
PER_CENT, PER_MILLE = 300, 4000  # of rated: seldom exceeded, and never exceeded
RANGES = {"m": ("m", "mm", "um"), "rad": ("rad", "deg", "rev")}


@dataclass(frozen=True)
class Role:
    """A column in the role of a channel."""

    column: str
    unit: str
    unit_source: str
    reason: str
    unknown: str = ""


@dataclass(frozen=True)
class Roles:
    """Channels of a table."""

    channels: dict[str, Role] = field(default_factory=dict)
    rivals: tuple[str, ...] = ()


def roles_of(table: Table) -> Roles:
    """Return the column of each channel of a table."""
    # Columns that differ only in their index.
    is_matrix = len({without_index(name) for name in table.columns}) == 1
    columns = [
        column
        for name in table.columns
        if (column := candidate_of(table, name, is_matrix)) is not None
    ]
    channels: dict[str, Role] = {}
    if (of_time := time_among(table, columns)) is not None:
        chosen, reason = of_time
        unit = chosen.unit or ("" if chosen.unknown else unit_of_time(chosen.name, chosen.values))
        channels["time"] = Role(
            chosen.name,
            unit,
            chosen.unit_source or ("numbers" if unit else ""),
            reason,
            chosen.unknown,
        )
    time = channels.get("time")
    moving = [
        column
        for column in columns
        if np.ptp(column.values) > 0.0 and (time is None or column.name != time.column)
    ]
    position, rivals = _position(moving)
    if position is None:
        return Roles(channels | _without_position(table, moving))
    stamps = _stamps(table, position.name, time)
    load = _load_position(moving, position)
    moving = [column for column in moving if column is not load]
    left = [
        column for column in moving if column is not position and not column.is_apart_from(position)
    ]
    velocity = _velocity(left, position, stamps)
    reference = _reference([column for column in left if column is not velocity], position)
    if (
        reference is not None
        and position.values.size == reference.values.size
        and not position.meaning.role
    ):
        is_named = any(
            column.meaning.reference or column.meaning.actual for column in (position, reference)
        )
        # Of two otherwise equal columns, the rougher one is measured.
        if not is_named and roughness(reference.values) > roughness(position.values):
            position, reference = reference, position
    left = [
        column
        for column in left
        if all(column is not used for used in (position, velocity, reference))
    ]
    error = None
    if reference is None:
        fit = [
            column
            for column in left
            if column.meaning.role == "error" and (not column.unit or column.is_one_of(MOVEMENTS))
        ]
        fit = [column for column in fit if np.ptp(column.values) < np.ptp(position.values)]
        error = max(
            fit, key=lambda column: column.meaning.sure + _kinship(column, position), default=None
        )
    unit, unit_source = _unit_of_position(position, velocity, reference, stamps)
    channels["position"] = Role(
        position.name, unit, unit_source, _reason(position, "position"), position.unknown
    )
    if velocity is not None and velocity.unit:
        channels["velocity"] = Role(
            velocity.name, velocity.unit, velocity.unit_source, _reason(velocity, "velocity")
        )
    elif (
        velocity is not None and unit and stamps is not None and velocity.values.size == stamps.size
    ):
        own = _unit_of_velocity(velocity, position, unit, stamps)
        if own:
            channels["velocity"] = Role(
                velocity.name, own, "position", _reason(velocity, "velocity")
            )
    for name, column in (
        (LOAD_ENCODER, load),
        ("reference", reference),
        ("following_error", error),
    ):
        if column is not None and (column.unit or column.unknown in ("", position.unknown)):
            own, unit_source = (
                (column.unit, column.unit_source)
                if column.unit
                else (unit, "position" if unit else "")
            )
            channels[name] = Role(column.name, own, unit_source, _reason(column, name))
    channels |= _effort(table, [column for column in left if column is not error], position)
    return Roles(channels, rivals)


def _without_position(table: Table, moving: Sequence[Candidate]) -> dict[str, Role]:
    """Return velocity and effort by their names and units, of a table without a position."""
    fit = [
        column
        for column in moving
        if column.fits("velocity", SPEEDS) and not column.meaning.reference
    ]
    velocity = max(
        fit, key=lambda candidate: candidate.meaning.sure + candidate.meaning.actual, default=None
    )
    if velocity is None:
        return {}
    way = replace(velocity, values=np.cumsum(velocity.values))
    role = Role(
        velocity.name,
        velocity.unit,
        velocity.unit_source,
        _reason(velocity, "its unit"),
        velocity.unknown,
    )
    efforts = [
        column for column in moving if column is not velocity and not column.is_apart_from(way)
    ]
    return {"velocity": role} | _effort(table, efforts, way)


def _unit_of_velocity(
    velocity: Candidate, position: Candidate, unit: str, stamps: np.ndarray
) -> str:
    """Return the unit of the position over time that fits the numbers of the velocity; empty if none does."""
    factor = abs(slope(rate_of(position.values, stamps), velocity.values))
    for per, size in (("s", 1.0), ("min", 60.0)):
        if abs(factor / size - 1.0) < WITHIN:
            return "rpm" if (unit, per) == ("rev", "min") else f"{unit}/{per}"
    return ""


def facts_of_speeds(table: Table, roles: Roles) -> dict[str, str | float]:
    """Return what a second speed, on the other side of a gear or screw, shows: this column, the side of the motion, ratio or lead."""
    motion = next(
        roles.channels[name] for name in ("position", "velocity") if name in roles.channels
    )
    stamps, base = (
        _stamps(table, motion.column, roles.channels.get("time")),
        units.like(motion.unit, ("m", "rad", "m/s", "rad/s")),
    )
    if stamps is None or base is None:
        return {}
    steps = np.gradient(stamps)
    way = table.columns[motion.column] * units.factor(motion.unit, base)
    if base.endswith("/s"):
        way = np.cumsum(way * steps)
    ratios = dict[str, float]()
    for name in table.columns:
        column = candidate_of(table, name, is_nameless=False)
        if (
            column is None
            or column.meaning.reference
            or column.values.size != steps.size
            or not column.is_one_of(("rad/s",))
        ):
            continue
        turned = np.cumsum(column.values * steps) * units.factor(column.unit, "rad/s")
        # On a rotary axis the ratio of two speeds can be that of two units, unless a name says that one is the speed of the motor.
        is_named = base.startswith("m") or is_of_motor(f"{name} {motion.column}")
        if is_named and name != motion.column and abs(correlation(turned, way)) > ALMOST_SAME:
            ratios[name] = abs(1.0 / slope(turned, way))
    if not ratios:
        return {}
    second, ratio = max(ratios.items(), key=lambda entry: abs(np.log(entry[1])))
    if base.startswith("m"):
        return {"second": second, "transmission.lead": f"{2.0 * np.pi / ratio:.4g} m"}
    side = max((ratio, "load"), (1.0, "motor"))[1]
    return {
        "second": second,
        "side": side,
        "transmission.gear_ratio": float(f"{max(ratio, 1.0 / ratio):.4g}"),
    }


def _stamps(table: Table, position: str, time: Role | None) -> np.ndarray | None:
    """Return the times of the position [s]."""
    name = table.stamps.get(position) or (time.column if time else None)
    if name is None:
        return (
            None
            if table.sample_time is None
            else table.sample_time * np.arange(table.columns[position].size)
        )
    unit = time.unit if time else table.units.get(name) or unit_of_time(name, table.columns[name])
    return table.columns[name] * units.factor(unit, "s") if unit and units.is_unit(unit) else None


def _position(columns: list[Candidate]) -> tuple[Candidate | None, tuple[str, ...]]:
    fit = [column for column in columns if column.fits("position", MOVEMENTS)]
    measured = [column for column in fit if not column.meaning.reference] or fit
    if not measured:
        smooth = [
            column
            for column in columns
            if column.meaning.role in ("", "position") and not column.unit
        ]
        measured = sorted(smooth, key=lambda column: roughness(column.values))[:1]
        partners = [
            c
            for c in columns
            if measured and c is not measured[0] and c.values.size == measured[0].values.size
        ]
        if not any(explained(column.values, measured[0].values) > GUESSED for column in partners):
            return None, ()
    driven = {column.axis for column in columns if column.axis and column.fits("effort", EFFORTS)}

    def score(column: Candidate) -> float:
        named = column.meaning.sure if column.meaning.role == "position" else 0.0
        fits = 0.6 * column.is_one_of(MOVEMENTS) + 0.5 * (column.axis in driven)
        return named + 0.5 * column.meaning.actual - column.meaning.reference + fits

    chosen = max(measured, key=score)
    if is_of_load(chosen.name):
        of_motor = [
            column
            for column in measured
            if column.meaning.role == "position" and not is_of_load(column.name)
        ]
        of_motor = [
            column
            for column in of_motor
            if not column.meaning.reference and _moves_alike(column, chosen)
        ]
        chosen = max(of_motor, key=score, default=chosen)
    return chosen, tuple(
        column.name
        for column in measured
        if column is not chosen and score(column) >= score(chosen)
    )


def _moves_alike(column: Candidate, position: Candidate) -> bool:
    """Return whether a column can be a second encoder of the axis of a position."""
    alike = correlation(column.values, position.values) > ALMOST_SAME
    if column.unit:
        return alike and bool(position.unit) and units.compatible(column.unit, position.unit)
    return alike and abs(slope(position.values, column.values) - 1.0) < 0.1


def _load_position(columns: list[Candidate], position: Candidate) -> Candidate | None:
    """Return the encoder at the load, if the position is that of the motor."""
    fit = [
        column
        for column in columns
        if column is not position and is_of_load(column.name) and not column.meaning.reference
    ]
    fit = [
        column
        for column in fit
        if column.meaning.role in ("", "position", "effort") and not column.is_apart_from(position)
    ]
    fit = (
        []
        if is_of_load(position.name)
        else [column for column in fit if _moves_alike(column, position)]
    )
    return max(
        fit, key=lambda column: column.meaning.actual + _kinship(column, position), default=None
    )


def _kinship(column: Candidate, relative: Candidate) -> float:
    """Return the evidence that two signals belong to one axis, from their addresses or names."""
    (digits, named), (digits_there, named_there) = (
        (re.findall(r"\d+", name), set(re.findall(r"\b[A-Za-z]{1,3}\d{1,2}\b", name)))
        for name in (column.name, relative.name)
    )
    shorter = min(len(column.name), len(relative.name))
    common = next(
        (i for i, (a, b) in enumerate(zip(column.name, relative.name, strict=False)) if a != b),
        shorter,
    )
    is_one = (
        digits == digits_there
        or named & named_there
        or (column.axis and column.axis == relative.axis)
    )
    return (0.6 if is_one else 0.0) + min(0.3, 0.02 * common)


def _velocity(
    columns: list[Candidate], position: Candidate, stamps: np.ndarray | None
) -> Candidate | None:
    rate = rate_of(position.values, stamps)
    fit = [
        column
        for column in columns
        if column.fits("velocity", SPEEDS) and not column.meaning.reference
    ]
    fit = [
        candidate
        for candidate in fit
        if candidate.values.size != rate.size or abs(correlation(rate, candidate.values)) > ALIKE
    ]
    fit = fit or [
        column
        for column in columns
        if not column.unit
        and not column.meaning.role
        and abs(correlation(rate, column.values)) > ALMOST_SAME
    ]
    return max(
        fit,
        key=lambda candidate: (
            candidate.meaning.sure + candidate.meaning.actual + _kinship(candidate, position)
        ),
        default=None,
    )


def _reference(columns: list[Candidate], position: Candidate) -> Candidate | None:
    fit = [
        c
        for c in columns
        if c.meaning.role in ("", "position") and (not c.unit or c.is_one_of(MOVEMENTS))
    ]
    # 0 where they differ in size
    alike = [(column, correlation(column.values, position.values)) for column in fit]
    named = [column for column, likeness in alike if column.meaning.reference and likeness > ALIKE]
    stems = {
        id(column): without_part("".join(words_of(column.name))) for column in (*fit, position)
    }
    in_step = [column for column in fit if column.values.size == position.values.size]
    # The name of the position except for the word, in a different unit: a sticking axis correlates badly with its reference.
    called = [
        column
        for column in in_step
        if column.meaning.reference and column.unit and stems[id(column)] == stems[id(position)]
    ]
    close = [
        column
        for column, likeness in alike
        if not column.meaning.role
        and not column.unit
        and likeness > ALMOST_SAME
        and abs(slope(position.values, column.values) - 1.0) < 0.1
    ]
    elsewhere = [
        column
        for column in fit
        if column.meaning.reference and column.values.size != position.values.size
    ]
    return max(
        named or called or close or elsewhere,
        key=lambda column: column.meaning.sure + _kinship(column, position),
        default=None,
    )


def _effort(table: Table, columns: list[Candidate], position: Candidate) -> dict[str, Role]:
    """Return the effort by name and unit, else by correlation with the motion; empty if there is none."""
    fit = [column for column in columns if column.fits("effort", EFFORTS)]

    def moves(column: Candidate) -> float:
        return (
            explained(column.values, position.values)
            if column.values.size == position.values.size
            else 0.0
        )

    def score(column: Candidate) -> float:
        ranks = {"N": 0.8, "N*m": 0.8, "A": 0.6, "rated": 0.6, "V": 0.1}
        unit = next((rank for base, rank in ranks.items() if column.is_one_of((base,))), 0.2)
        named = column.meaning.sure if column.meaning.role == "effort" else 0.0
        meaning = named + unit + 0.3 * column.meaning.actual - 0.4 * column.meaning.reference
        return meaning + _kinship(column, position) + 0.5 * max(0.0, moves(column))

    effort = max(fit, key=score, default=None)
    if effort is None:
        effort = max(
            (column for column in columns if not column.meaning.role and not column.unit),
            key=moves,
            default=None,
        )
        if effort is None or moves(effort) <= GUESSED:
            return {}
    unit, unit_source = _unit_of_effort(effort, table.about.get(effort.name, ""))
    return {
        "effort": Role(effort.name, unit, unit_source, _reason(effort, "effort"), effort.unknown)
    }


def _reason(column: Candidate, channel: str) -> str:
    if column.meaning.role or column.meaning.reference or channel == LOAD_ENCODER:
        return "its name"
    reasons = {
        "effort": "it follows the motion",
        "velocity": "it is the rate of the position",
        "reference": "it moves like the position",
    }
    return reasons.get(channel, "its unit" if column.unit else "it is the smoothest")


def _unit_of_position(
    position: Candidate,
    velocity: Candidate | None,
    reference: Candidate | None,
    stamps: np.ndarray | None,
) -> tuple[str, str]:
    if position.unit:
        return position.unit, position.unit_source
    if reference is not None and reference.unit and not position.unknown:
        return reference.unit, "reference"
    if (
        velocity is not None
        and velocity.unit
        and stamps is not None
        and velocity.values.size == stamps.size
    ):
        # The recorded velocity in SI over the rate of the numbers: the unit of a number.
        base = next((base for base in SPEEDS if units.compatible(velocity.unit, base)), None)
        per = slope(rate_of(position.values, stamps), velocity.values)
        if base is not None and base != "count/s":
            per = abs(per) * units.factor(velocity.unit, base)
            for unit in RANGES[base.removesuffix("/s")]:
                if abs(per / units.factor(unit, base.removesuffix("/s")) - 1.0) < WITHIN:
                    return unit, "velocity"
    integral = bool(np.all(position.values == np.round(position.values)))
    if integral and not position.unknown and float(np.max(np.abs(position.values))) > 100.0:
        return "count", "numbers"
    return "", ""


def _unit_of_effort(effort: Candidate, about: str) -> tuple[str, str]:
    if effort.unit or effort.unknown:
        return effort.unit, effort.unit_source
    words = {*words_of(effort.name), "".join(words_of(effort.name))}
    for unit, names in (
        ("A", ("current", "strom", "iq", "isq", "motorstrom", "amps")),
        ("V", ("voltage", "spannung", "uq")),
    ):
        if words & set(names) or any(len(name) > 4 and name in "".join(words) for name in names):
            return unit, "its name"
    integral = bool(np.all(effort.values == np.round(effort.values)))
    largest = float(np.max(np.abs(effort.values)))
    stored = re.search(r"\bU?INT(8|16)\b", about) is not None
    # A drive stores integers in per mille; other programs may have converted them to per cent.
    if integral and (100.0 if stored else PER_CENT) < largest <= PER_MILLE:
        return "‰", "drive"
    if largest <= PER_MILLE and (stored or (integral and largest >= 8.0)):
        return "", "rated"
    return "", ""

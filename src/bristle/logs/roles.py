"""Which column of a file is what: told from names and units, and from what moves like what."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np

from bristle.core import units
from bristle.logs.candidates import Candidate, candidate_of, correlation, explained, rate_of, roughness, slope, time_among
from bristle.logs.table import Table, without_index
from bristle.logs.words import unit_of_time, without_part, words_of

__all__ = ["Role", "Roles", "roles_of"]

MOVEMENTS = ("m", "rad", "count")
SPEEDS = ("m/s", "rad/s", "count/s")
EFFORTS = ("N", "N*m", "A", "rated", "V")
ALIKE, ALMOST_SAME = 0.9, 0.995  # correlation of a velocity, or of a reference, with what it belongs to
WITHIN = 0.03  # of a factor between two units
GUESSED = 0.3  # of an effort is explained by its motion, where no name tells
MEASURED_IN = {"A": ("current", "strom", "iq", "isq", "motorstrom", "amps"), "V": ("voltage", "spannung", "uq")}
PER_CENT, PER_MILLE = 300, 4000  # of rated, that a drive seldom exceeds, and that none does
RANGES = {"m": ("m", "mm", "um"), "rad": ("rad", "deg", "rev")}


@dataclass(frozen=True)
class Role:
    """A column that is a channel."""

    column: str
    unit: str
    told_by: str
    reason: str
    unknown: str = ""


@dataclass(frozen=True)
class Roles:
    """The channels that a table has."""

    channels: dict[str, Role] = field(default_factory=dict)
    implied_time: bool = False
    rivals: tuple[str, ...] = ()


def roles_of(table: Table) -> Roles:
    """Return which column of a table is which channel."""
    one_matrix = len({without_index(name) for name in table.columns}) == 1  # its name tells its columns not apart
    columns = [column for name in table.columns if (column := candidate_of(table, name, one_matrix)) is not None]
    time = _time(table, columns)
    rest = [column for column in columns if time is None or column.name != time.column]
    moving = [column for column in rest if np.ptp(column.values) > 0.0]
    position, rivals = _position(moving)
    if position is None:
        channels = {"time": time} if time and not table.stamps else {}
        return Roles(channels | _of_speed(table, moving), bool(table.stamps))
    stamps = _stamps(table, position.name, time)
    left = [column for column in moving if column is not position and not _of_another_axis(column, position)]
    velocity = _velocity(left, position, stamps)
    reference = _reference([column for column in left if column is not velocity], position)
    if reference is not None and _measured_is_the_other(position, reference):
        position, reference = reference, position
        left = [column for column in left if column is not position]
    names_used = {column.name for column in (velocity, reference) if column is not None}
    error = _error([column for column in left if column.name not in names_used], position) if reference is None else None
    effort = _effort([column for column in left if column is not error and column.name not in names_used], position)
    channels = {"time": time} if time is not None and not table.stamps else {}
    unit, told_by = _unit_of_position(position, velocity, reference, stamps)
    channels["position"] = Role(position.name, unit, told_by, _reason(position, "position"), position.unknown)
    if velocity is not None and (role := _role_of_velocity(velocity, position, unit, stamps)) is not None:
        channels["velocity"] = role
    for name, column in (("reference", reference), ("following_error", error)):
        if column is not None and (column.unit or column.unknown in ("", position.unknown)):
            own, unit_source = (column.unit, column.told_by) if column.unit else (unit, "position" if unit else "")
            channels[name] = Role(column.name, own, unit_source, _reason(column, name))
    if effort is not None:
        channels["effort"] = _role_of_effort(effort, table)
    return Roles(channels, bool(table.stamps), rivals)


def _of_speed(table: Table, columns: list[Candidate]) -> dict[str, Role]:
    """Return velocity and effort of a log without a position, by their names and units."""
    fit = [column for column in columns if column.fits("velocity", SPEEDS) and not column.meaning.reference]
    velocity = max(fit, key=lambda candidate: candidate.meaning.sure + candidate.meaning.actual, default=None)
    if velocity is None:
        return {}
    way = replace(velocity, values=np.cumsum(velocity.values))
    effort = _effort([column for column in columns if column is not velocity and not _of_another_axis(column, way)], way)
    reason = _reason(velocity, "its unit")
    channels = {"velocity": Role(velocity.name, velocity.unit, velocity.told_by, reason, velocity.unknown)}
    return channels | ({} if effort is None else {"effort": _role_of_effort(effort, table)})


def _role_of_effort(effort: Candidate, table: Table) -> Role:
    unit, told_by = _unit_of_effort(effort, table.about.get(effort.name, ""))
    return Role(effort.name, unit, told_by, _reason(effort, "effort"), effort.unknown)


def _time(table: Table, columns: list[Candidate]) -> Role | None:
    if (of_time := time_among(table, columns)) is None:
        return None
    chosen, reason = of_time
    unit = chosen.unit or ("" if chosen.unknown else unit_of_time(chosen.name, chosen.values))
    return Role(chosen.name, unit, chosen.told_by or ("numbers" if unit else ""), reason, chosen.unknown)


def _stamps(table: Table, position: str, time: Role | None) -> np.ndarray | None:
    """Return the times of the position [s]."""
    name = table.stamps.get(position) or (time.column if time else None)
    if name is None:
        period = table.sample_time
        return None if period is None else period * np.arange(table.columns[position].size)
    unit = time.unit if time else table.units.get(name, "s")
    return table.columns[name] * units.factor(unit, "s") if unit and units.is_unit(unit) else None


def _of_another_axis(column: Candidate, position: Candidate) -> bool:
    """Return whether the addresses of two signals name two axes."""
    return column.axis is not None and position.axis is not None and column.axis != position.axis


def _position(columns: list[Candidate]) -> tuple[Candidate | None, tuple[str, ...]]:
    fit = [column for column in columns if column.fits("position", MOVEMENTS)]
    measured = [column for column in fit if not column.meaning.reference] or fit
    if not measured:
        smooth = [column for column in columns if column.meaning.role in ("", "position") and not column.unit]
        measured = sorted(smooth, key=lambda column: roughness(column.values))[:1]
        partner = [column for column in columns if measured and column is not measured[0]]
        if not any(
            explained(column.values, measured[0].values) > GUESSED for column in partner if column.values.size == measured[0].values.size
        ):
            return None, ()

    driven = {column.axis for column in columns if column.axis and column.fits("effort", EFFORTS)}

    def score(column: Candidate) -> float:
        meaning = column.meaning
        named = meaning.sure if meaning.role == "position" else 0.0
        fits = 0.6 * column.is_one_of(MOVEMENTS) + 0.5 * (column.axis in driven)
        return named + 0.5 * meaning.actual - meaning.reference + fits

    chosen = max(measured, key=score)
    rivals = tuple(column.name for column in measured if column is not chosen and score(column) >= score(chosen))
    return chosen, rivals


def _kinship(column: Candidate, relative: Candidate) -> float:
    """Return how much two signals look like those of one axis: by their addresses, or by their names."""
    (digits, named), (digits_there, named_there) = (
        (re.findall(r"\d+", name), set(re.findall(r"\b[A-Za-z]{1,3}\d{1,2}\b", name))) for name in (column.name, relative.name)
    )
    shorter = min(len(column.name), len(relative.name))
    letters = enumerate(zip(column.name, relative.name, strict=False))
    common = next((i for i, (a, b) in letters if a != b), shorter)
    is_one = digits == digits_there or named & named_there or (column.axis and column.axis == relative.axis)
    return (0.6 if is_one else 0.0) + min(0.3, 0.02 * common)


def _velocity(columns: list[Candidate], position: Candidate, stamps: np.ndarray | None) -> Candidate | None:
    rate = rate_of(position.values, stamps)
    fit = [column for column in columns if column.fits("velocity", SPEEDS) and not column.meaning.reference]
    fit = [candidate for candidate in fit if candidate.values.size != rate.size or abs(correlation(rate, candidate.values)) > ALIKE]
    fit = fit or [
        column for column in columns if not column.unit and not column.meaning.role and abs(correlation(rate, column.values)) > ALMOST_SAME
    ]
    return max(fit, key=lambda candidate: candidate.meaning.sure + candidate.meaning.actual + _kinship(candidate, position), default=None)


def _reference(columns: list[Candidate], position: Candidate) -> Candidate | None:
    fit = [
        column
        for column in columns
        if column.meaning.role in ("", "position")
        and (not column.unit or column.is_one_of(MOVEMENTS))
        and column.values.size == position.values.size
    ]
    named = [column for column in fit if column.meaning.reference and correlation(column.values, position.values) > ALIKE]
    alike = [
        column
        for column in fit
        if not column.meaning.role
        and not column.unit
        and correlation(column.values, position.values) > ALMOST_SAME
        and abs(slope(position.values, column.values) - 1.0) < 0.1
    ]
    elsewhere = [
        column
        for column in columns
        if column.meaning.reference
        and column.meaning.role in ("", "position")
        and column.values.size != position.values.size
        and (not column.unit or column.is_one_of(MOVEMENTS))
    ]
    called = [  # as the position is, but for the word, in a unit of its own: an axis that sticks follows it badly
        column for column in fit if column.meaning.reference and column.unit and _stem(column) == _stem(position)
    ]
    fit = named or called or alike or elsewhere
    return max(fit, key=lambda candidate: candidate.meaning.sure + _kinship(candidate, position), default=None)


def _stem(column: Candidate) -> str:
    """Return the letters of a name without the words for a reference and for what was measured."""
    return without_part("".join(words_of(column.name)))


def _measured_is_the_other(position: Candidate, reference: Candidate) -> bool:
    """Return whether, of two columns that nothing tells apart, the second is rougher, as what is measured is."""
    nameless = not any(column.meaning.reference or column.meaning.actual for column in (position, reference))
    comparable = position.values.size == reference.values.size and not position.meaning.role
    return nameless and comparable and roughness(reference.values) > roughness(position.values)


def _error(columns: list[Candidate], position: Candidate) -> Candidate | None:
    fit = [column for column in columns if column.meaning.role == "error" and (not column.unit or column.is_one_of(MOVEMENTS))]
    fit = [column for column in fit if np.ptp(column.values) < np.ptp(position.values)]
    return max(fit, key=lambda column: column.meaning.sure + _kinship(column, position), default=None)


def _effort(columns: list[Candidate], position: Candidate) -> Candidate | None:
    fit = [column for column in columns if column.fits("effort", EFFORTS)]
    if not fit:
        free = [column for column in columns if not column.meaning.role and not column.unit and column.values.size == position.values.size]
        best = max(free, key=lambda column: explained(column.values, position.values), default=None)
        return best if best is not None and explained(best.values, position.values) > GUESSED else None

    def score(column: Candidate) -> float:
        ranks = {"N": 0.8, "N*m": 0.8, "A": 0.6, "rated": 0.6, "V": 0.1}
        unit = next((rank for base, rank in ranks.items() if column.is_one_of((base,))), 0.2)
        named = column.meaning.sure if column.meaning.role == "effort" else 0.0
        moves = 0.0
        if column.values.size == position.values.size:
            moves = max(0.0, explained(column.values, position.values))
        kin = _kinship(column, position)
        return named + unit + 0.3 * column.meaning.actual - 0.4 * column.meaning.reference + kin + 0.5 * moves

    return max(fit, key=score)


def _reason(column: Candidate, channel: str) -> str:
    if column.meaning.role or column.meaning.reference:
        return "its name"
    reasons = {
        "effort": "it goes with the motion",
        "velocity": "it is the rate of the position",
        "reference": "it moves as the position does",
    }
    return reasons.get(channel, "its unit" if column.unit else "it is the smoothest")


def _unit_of_position(
    position: Candidate, velocity: Candidate | None, reference: Candidate | None, stamps: np.ndarray | None
) -> tuple[str, str]:
    if position.unit:
        return position.unit, position.told_by
    if reference is not None and reference.unit and not position.unknown:
        return reference.unit, "reference"
    if velocity is not None and velocity.unit and stamps is not None and velocity.values.size == stamps.size:
        # The recorded velocity in SI over the rate of the numbers: what one of them is.
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


def _role_of_velocity(velocity: Candidate, position: Candidate, unit: str, stamps: np.ndarray | None) -> Role | None:
    """Return the velocity as a channel; None where its unit is neither told nor that of the position over time."""
    if velocity.unit:
        return Role(velocity.name, velocity.unit, velocity.told_by, _reason(velocity, "velocity"))
    if not unit or stamps is None or velocity.values.size != stamps.size:
        return None
    factor = abs(slope(rate_of(position.values, stamps), velocity.values))
    for per, size in (("s", 1.0), ("min", 60.0)):
        if abs(factor / size - 1.0) < WITHIN:
            unit_source = "rpm" if (unit, per) == ("rev", "min") else f"{unit}/{per}"
            return Role(velocity.name, unit_source, "position", _reason(velocity, "velocity"))
    return None


def _unit_of_effort(effort: Candidate, about: str) -> tuple[str, str]:
    if effort.unit or effort.unknown:
        return effort.unit, effort.told_by
    words = {*words_of(effort.name), "".join(words_of(effort.name))}
    for unit, names in MEASURED_IN.items():
        if words & set(names) or any(len(name) > 4 and name in "".join(words) for name in names):
            return unit, "its name"
    integral = bool(np.all(effort.values == np.round(effort.values)))
    largest = float(np.max(np.abs(effort.values)))
    stored = re.search(r"\bU?INT(8|16)\b", about) is not None
    # A drive stores whole numbers in per mille; some other program may have made per cent of them since.
    if integral and (100.0 if stored else PER_CENT) < largest <= PER_MILLE:
        return "‰", "drive"
    if largest <= PER_MILLE and (stored or (integral and largest >= 8.0)):
        return "", "rated"
    return "", ""

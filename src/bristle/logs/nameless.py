"""Propose a role for each column of a log without usual names, for one axis or several, with the evidence for each role.

A column that equals the rate of another column is its velocity, and of two almost equal columns the earlier one is the
reference. An effort contains the friction of its own joint: after a regression on the motion of all joints, it depends on
the direction of this joint. Without recorded velocities, the smoothest columns are the positions.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from bristle.core.least_squares import apart_from
from bristle.logs.channel import clear_step
from bristle.logs.roles import (
    Candidate,
    Role,
    Roles,
    candidate_of,
    correlation,
    rate_of,
    roughness,
    slope,
    time_among,
)
from bristle.logs.table import Table
from bristle.logs.words import meaning_of

_NUMBER = re.compile(r"[\s_\[({]*\d+[\])}]*$")  # as in column_1, data[0]
_DIGITS = re.compile(r"\d+")
MOST_ROWS, MOST_COLUMNS = 6000, 60  # of the search
BLOCKS = (1, 3, 10)  # rows of a mean, for fine and for slow signals
# Correlation of a velocity with the rate of a position, and of a reference with its position.
RATE, EQUAL = (0.97, 0.95)
UNEQUAL = 0.1  # deviation of the ratio of a position to its reference from 1
REVERSED = "its sign is reversed"
GAP = 4.0  # ratio of roughness between the roughest position and the smoothest effort
# Least partial correlation of an effort with a direction, and its ratio to that with another joint.
FRICTION, CLEARER = (0.2, 1.5)


@dataclass(frozen=True)
class Proposed:
    """A column without a name: its range and step, proposed role and joint, and the evidence; the role is empty if it is open."""

    column: str
    low: float
    high: float
    step: float
    role: str = ""
    joint: int = 0
    evidence: str = "no relation to another column"


def is_nameless(table: Table) -> bool:
    """Return whether the columns of a table differ only in their number."""
    stems = {_NUMBER.sub("", name) for name in table.names}
    return len(table.names) > 1 and len(stems) == 1 and not meaning_of(*stems).role


def proposed_roles(table: Table) -> tuple[Proposed, ...]:
    """Return a role for each column of a table from the signals alone."""
    candidates = [
        column
        for name in table.columns
        if (column := candidate_of(table, name, is_nameless=True)) is not None
    ]
    described = {name: _described(name, values) for name, values in table.columns.items()}
    of_time = time_among(table, candidates)
    if of_time is not None:
        described[of_time[0].name] = replace(
            described[of_time[0].name], role="time", evidence=of_time[1]
        )
    moving = [
        c
        for c in candidates
        if np.ptp(c.values) > 0.0 and not described[c.name].role and not _counts(c.values)
    ][:MOST_COLUMNS]
    if len({column.values.size for column in moving}) == 1:
        time = None if of_time is None else of_time[0].values
        searches = [
            _Search.of(moving, time, block).roles()
            for block in BLOCKS
            if moving[0].values.size >= block * MOST_ROWS or block == 1
        ]
        for name, role, joint, evidence in max(
            searches, key=lambda roles: sum(role == "effort" for _, role, _, _ in roles)
        ):
            described[name] = replace(described[name], role=role, joint=joint, evidence=evidence)
    return tuple(described.values())


def numbered_roles(table: Table, roles: Roles) -> tuple[Proposed, ...]:
    """Return the roles of columns whose names contain the number of a joint, if the names of motion and effort show them; else empty."""
    columns = {
        channel: _numbered(role.column, table.names)
        for channel, role in roles.channels.items()
        if channel != "time"
    }
    joints = list(columns.get("position", columns.get("velocity", {})))
    columns = {channel: named for channel, named in columns.items() if set(named) == set(joints)}
    if len(joints) < 2 or "effort" not in columns:
        return ()
    place = {
        named[number]: (channel, joint)
        for channel, named in columns.items()
        for joint, number in enumerate(joints, start=1)
    }
    if len(place) < len(joints) * len(columns):  # two channels share columns
        return ()
    place |= {roles.channels["time"].column: ("time", 0)} if "time" in roles.channels else {}
    evidence = {
        name: f"its name, as that of joint {joint}" if joint else "its name"
        for name, (_, joint) in place.items()
    }
    described = {name: _described(name, values) for name, values in table.columns.items()}
    return tuple(
        replace(entry, role=place[name][0], joint=place[name][1], evidence=evidence[name])
        if name in place
        else entry
        for name, entry in described.items()
    )


def _numbered(name: str, names: Iterable[str]) -> dict[int, str]:
    """Return the columns whose names differ from a name in one of its numbers only, by this number; the largest such set."""
    sets = list[dict[int, str]]()
    for number in _DIGITS.finditer(name):
        pattern = re.compile(
            rf"{re.escape(name[: number.start()])}(\d+){re.escape(name[number.end() :])}"
        )
        sets.append(
            {
                int(match[1]): match[0]
                for match in map(pattern.fullmatch, names)
                if match is not None
            }
        )
    return max(sets, key=len, default={})


def joint_count(proposed: Iterable[Proposed]) -> int:
    """Return the number of joints among columns without names."""
    return max((entry.joint for entry in proposed), default=0)


def roles_of_joint(proposed: Iterable[Proposed], joint: int) -> Roles:
    """Return the channels of one joint, and the time, of columns without names."""
    return Roles(
        {
            entry.role: Role(entry.column, "", "", entry.evidence)
            for entry in proposed
            if entry.role and entry.joint in (0, joint)
        }
    )


def _described(name: str, values: np.ndarray) -> Proposed:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (np.nan, np.nan)
    evidence = (
        "it is constant"
        if low == high
        else "it counts the rows"
        if _counts(finite)
        else Proposed.evidence
    )
    return Proposed(name, low, high, clear_step(values) or 0.0, evidence=evidence)


def _counts(values: np.ndarray) -> bool:
    return values.size > 1 and bool(np.all(np.diff(values) == 1.0))


@dataclass(frozen=True)
class _Search:
    """Signals by name, in means over blocks of rows, with their rates and roughness."""

    signals: dict[str, np.ndarray]
    rates: dict[str, np.ndarray]
    rough: dict[str, float]

    @classmethod
    def of(cls, columns: list[Candidate], time: np.ndarray | None, block: int) -> _Search:
        """Return the signals of a stretch in the middle of the log."""
        size = columns[0].values.size
        count = min(size // block, MOST_ROWS)
        first = (size - count * block) // 2
        rows = slice(first, first + count * block)

        def means(values: np.ndarray) -> np.ndarray:
            return values[rows].reshape(count, block).mean(axis=1)

        stamps = None if time is None or time.size != size else means(time)
        signals = {column.name: means(column.values) for column in columns}
        rates = {name: rate_of(signal, stamps) for name, signal in signals.items()}
        return cls(signals, rates, {name: roughness(signal) for name, signal in signals.items()})

    def roles(self) -> list[tuple[str, str, int, str]]:
        """Return name, role, joint and evidence of each column with a role."""
        velocities, evidence = self._velocities()
        left = [
            name
            for name in self.signals
            if name not in velocities and name not in velocities.values()
        ]
        if not velocities:
            smooth, left, evidence = self._smooth(left)
            velocities = dict.fromkeys(smooth, "")
        references = self._references(velocities, left)
        for name, reference in references.items():
            evidence[name] = f"{evidence.get(name) or evidence[reference]}; it follows {reference}"
            velocities = {**velocities, name: velocities.get(name) or velocities.pop(reference, "")}
        positions = [
            name for name in self.signals if name in velocities and name not in references.values()
        ]
        efforts = self._efforts(
            positions, [name for name in left if name not in (*positions, *references.values())]
        )
        roles, joint = list[tuple[str, str, int, str]](), 0
        for name in positions:
            velocity, reference, effort = velocities[name], references.get(name), efforts.get(name)
            if not velocity and not effort:
                roles.append(
                    (
                        name,
                        "",
                        0,
                        f"{evidence[name]}, like a position, but no column depends on its direction",
                    )
                )
                continue
            joint += 1
            roles.append((name, "position", joint, evidence[name]))
            if reference:
                roles.append((reference, "reference", joint, f"it is almost {name}, and leads it"))
            if velocity:
                likeness = correlation(self.rates[name], self.signals[velocity])
                roles.append(
                    (
                        velocity,
                        "velocity",
                        joint,
                        f"it is the rate of {name} (correlation {likeness:.4f})",
                    )
                )
            if effort:
                roles.append((effort[0], "effort", joint, effort[1]))
        return roles

    def _references(self, positions: Iterable[str], left: list[str]) -> dict[str, str]:
        """Return the reference of each measured position that has one."""
        references = dict[str, str]()
        for name in positions:
            candidates = [
                candidate
                for candidate in self.signals
                if candidate != name and (candidate in positions or candidate in left)
            ]
            candidate = next(
                (candidate for candidate in candidates if self._alike(candidate, name)), ""
            )
            if candidate and not {name, candidate} & {*references, *references.values()}:
                # The reference exceeds the measured position in the direction of motion.
                leads = (
                    correlation(self.signals[name] - self.signals[candidate], self.rates[name])
                    > 0.0
                )
                references |= {candidate: name} if leads else {name: candidate}
        return references

    def _alike(self, name: str, candidate: str) -> bool:
        """Return whether two signals are equal except for a following error."""
        first, second = self.signals[name], self.signals[candidate]
        return correlation(first, second) > EQUAL and abs(slope(first, second) - 1.0) < UNEQUAL

    def _velocities(self) -> tuple[dict[str, str], dict[str, str]]:
        """Return the velocity of each position that has one, and the evidence for the positions."""
        pairs = [
            (correlation(self.rates[name], self.signals[rate]), name, rate)
            for name in self.signals
            for rate in self.signals
            if self.rough[name] < self.rough[rate]
        ]
        pairs = [pair for pair in pairs if pair[0] > RATE]
        rates, velocities = {rate for _, _, rate in pairs}, dict[str, str]()
        for _, name, rate in sorted(pairs, reverse=True):
            # The rate of a velocity is an acceleration, or an effort.
            if name not in (*rates, *velocities) and rate not in velocities.values():
                velocities[name] = rate
        return velocities, {name: f"{rate} is its rate" for name, rate in velocities.items()}

    def _smooth(self, names: list[str]) -> tuple[list[str], list[str], dict[str, str]]:
        """Return the columns that are smoother than the rest by a clear gap, the other columns, and the evidence."""
        ordered = sorted(names, key=self.rough.__getitem__)
        gaps = [
            self.rough[after] / max(self.rough[name], 1e-12) for name, after in pairwise(ordered)
        ]
        place = int(np.argmax(gaps)) + 1 if gaps else 0
        if not gaps or gaps[place - 1] < GAP:
            return [], names, {}
        return (
            ordered[:place],
            ordered[place:],
            dict.fromkeys(
                ordered[:place],
                f"it is smooth: the next column is {gaps[place - 1]:.0f} times as rough",
            ),
        )

    def _efforts(self, positions: list[str], candidates: list[str]) -> dict[str, tuple[str, str]]:
        """Return the effort of each position with the evidence: the column that depends on the direction of this joint."""
        from scipy.optimize import linear_sum_assignment

        if not positions or not candidates:
            return {}
        motion = [
            part
            for name in positions
            for part in (self.signals[name], self.rates[name], rate_of(self.rates[name], None))
        ]
        motion += [bend(self.signals[name]) for name in positions for bend in (np.sin, np.cos)]
        design = np.column_stack(
            [*(part / (np.std(part) or 1.0) for part in motion), np.ones(motion[0].size)]
        )
        basis = np.linalg.qr(design)[0]
        sides = [apart_from(basis, np.sign(self.rates[name])) for name in positions]
        left = [apart_from(basis, self.signals[name]) for name in candidates]
        shares = np.array([[correlation(side, rest) for rest in left] for side in sides])
        chosen = dict[str, tuple[str, str]]()
        for row, column in zip(*linear_sum_assignment(-np.abs(shares)), strict=True):
            share, rival = (
                abs(shares[row, column]),
                max((abs(s) for k, s in enumerate(shares[:, column]) if k != row), default=0.0),
            )
            if share > FRICTION and share > CLEARER * rival:
                sign = "" if shares[row, column] > 0.0 else f"; {REVERSED}"
                text = f"it depends on the direction of {positions[row]} (partial correlation {share:.2f}"
                chosen[positions[row]] = (
                    candidates[column],
                    f"{text}, of another joint at most {rival:.2f}){sign}",
                )
        return chosen

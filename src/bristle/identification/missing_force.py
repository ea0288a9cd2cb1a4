r"""Forces that a model has no place for, found in what its fit leaves over.

Each cause has a few columns: what friction would do with it, to first order. A cause is there where its columns,
fitted to most half-cycles, tell the residual of the others (cross-validation [1]_). Two things would hide it, and are
weighed first. Rows around reversals err by their sampling: what does not act there alone is looked for farther away,
and each band of distance from a reversal counts by what it leaves over. And friction has another level on each
half-cycle: with the share :math:`1 - \sqrt{v_k / (\tau^2 + v_k)}` of that level taken out, of a scatter :math:`\tau`
and an error :math:`v_k`, rows are as good as independent of it [2]_.

What the parameters of the model can take is no missing force, nor is what a wrong inertia, a delay or a filter of
a channel makes: their derivatives are fitted with each cause.

References
----------
.. [1] M. Stone, "Cross-validatory choice and assessment of statistical predictions", Journal of the Royal Statistical
   Society B 36(2), 1974. doi:10.1111/j.2517-6161.1974.tb00994.x
.. [2] W. A. Fuller, G. E. Battese, "Transformations for estimation of linear models with nested-error structure",
   Journal of the American Statistical Association 68(343), 1973. doi:10.1080/01621459.1973.10481414
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from bristle.friction.next_model import CHANNELS
from bristle.identification.missing_columns import columns_by_cause
from bristle.identification.missing_rows import FEWEST_ROWS, SMALLEST, Rows, Weighed
from bristle.identification.settings import Settings
from bristle.identification.waves import frequency_in, refined, waves

__all__ = ["ANYWHERE", "Missing", "force_of", "missing_forces", "ripple_in"]

MOST = 3  # causes
AS_GOOD = 1.05  # times what another cause leaves: gravity is what turns with an angle, before a parabola or a ripple
EVEN = 0.9  # of what a ripple tells, where it is alike in both directions, or not
OVERTONES = range(2, 7)  # of a ripple
OVERTONE = 0.1  # of the residual without the ripple, that one tells
ANYWHERE = ("speed", "direction", "position", "ripple", "gravity", *CHANNELS, "transmitted")
AROUND = ("lag", "play")
"""Causes that act everywhere, and those that act around reversals."""


class Missing(NamedTuple):
    """A force that the model lacks.

    Parameters
    ----------
    cause : str
        What it depends on: ``speed``, ``direction``, ``lag``, ``play``, ``position``, ``ripple``,
        ``gravity``, ``transmitted``, ``flanks``, or a channel of what surrounds the axis.
    share : float
        Of the weighted squares of the residual, what it tells on half-cycles that it was not fitted to.
    force : float
        Root mean square of it over all rows [N or N*m], without what the parameters of the model would take.
    period : float
        Of a ripple [m or rad].
    amplitude : float
        Of gravity [N*m].
    alike : bool or None
        Whether a ripple is the same in both directions; False where it changes its sign with the motion, None where it
        does a part of both, or the log tells neither.
    overtones : tuple of int
        Of a ripple that is: how often in a period it comes back, 1 first.
    ratio : float
        Of the residual where the force on the load changes its side, to that elsewhere.
    """

    cause: str
    share: float
    force: float
    period: float = 0.0
    amplitude: float = 0.0
    alike: bool | None = None
    overtones: tuple[int, ...] = ()
    ratio: float = 0.0


def missing_forces(rows: Rows, settings: Settings) -> tuple[tuple[Missing, ...], float]:
    """Return the forces that a model lacks, the one that tells most first, and what is left without them [N or N*m].

    A cause counts from the shares of the weighted squares, of friction and of the effort that the settings name.
    """
    if not rows.enough:
        return (), 0.0
    missing, left = list[Missing](), 0.0
    if np.count_nonzero(rows.far) >= FEWEST_ROWS and (away := rows.at(rows.far)).enough:
        missing, left = _search(away, away.explained, ANYWHERE, settings.missing_share, settings)
    explained = np.column_stack([rows.explained, *(_columns_of(rows, force) for force in missing)])
    around, of_all = _search(rows, explained, AROUND, settings.missing_share_around, settings)
    return (*missing, *around), left if missing else of_all


def _search(
    rows: Rows, explained: np.ndarray, names: Sequence[str], least_share: float, settings: Settings
) -> tuple[list[Missing], float]:  # fmt: skip
    """Return the causes of these names that tell something of rows, besides what is explained, and what is left."""
    friction, effort = (float(np.sqrt(np.mean(signal**2))) for signal in (rows.friction, rows.effort))
    least = max(settings.missing_force * friction, settings.missing_effort * effort)
    weighed, missing = Weighed.of(rows), list[Missing]()
    causes = {name: columns for name, columns in columns_by_cause(rows).items() if name in names}
    left = weighed.left(explained)
    while len(missing) < MOST:
        ripple, period = ripple_in(rows, weighed, explained, rows.cutoff) if "ripple" in names else (None, 0.0)
        tried = causes | ({} if ripple is None or any(force.period for force in missing) else {"ripple": ripple})
        forces = [force_of(weighed, name, columns, explained=explained, left=left) for name, columns in tried.items()]
        forces = [force for force in forces if force.share >= least_share and force.force >= least]
        if not forces:
            break
        best = _likeliest(forces, tried, partial(force_of, weighed, explained=explained, left=left))
        if best.cause == "ripple":
            best = _in_detail(best._replace(period=period), rows, weighed, explained, left, least)
        missing.append(best)
        explained = np.column_stack([explained, tried[best.cause]])
        causes.pop(best.cause, None)
        left = weighed.left(explained)
    return missing, float(np.sqrt(np.mean(left**2)))


def _columns_of(rows: Rows, force: Missing) -> np.ndarray:
    """Return what friction does by the cause of a force, shape (row, column)."""
    return waves(rows.position, rows.side, 1.0 / force.period) if force.period else columns_by_cause(rows)[force.cause]


def ripple_in(
    rows: Rows, weighed: Weighed, explained: np.ndarray, fastest: float
) -> tuple[np.ndarray | None, float]:  # fmt: skip
    """Return the waves over the position that take most of what is left, added to friction and in proportion to it.

    At the usual speed no faster ones than `fastest` [Hz] are looked for.
    """
    x, side = rows.position, rows.side
    most = float(np.ptp(x)) * fastest / float(np.median(np.abs(rows.velocity)))
    residual = weighed.without(explained)
    frequency = frequency_in(x, side, residual, most)
    frequency = None if frequency is None else refined(x, side, residual, frequency)
    return (None, 0.0) if frequency is None else (waves(x, side, frequency), 1.0 / frequency)


def force_of(weighed: Weighed, cause: str, columns: np.ndarray, *, explained: np.ndarray, left: np.ndarray) -> Missing:
    """Return the force that a model lacks by a cause, fitted beside what is explained.

    `left` is what that leaves of each part, fitted to the others.
    """
    after, force, coefficients = weighed.with_columns(explained, columns)
    share = 1.0 - float(after @ after) / max(float(left @ left), SMALLEST)
    amplitude = float(np.hypot(*coefficients)) if cause == "gravity" else 0.0
    return Missing(cause, share, float(np.sqrt(np.mean(force**2))), amplitude=amplitude)


def _likeliest(
    forces: Sequence[Missing], columns: Mapping[str, np.ndarray], tried: Callable[[str, np.ndarray], Missing]
) -> Missing:
    """Return the cause that tells most; gravity before a place or a ripple that tell no more, alike in both directions.

    The first two columns of either are those.
    """
    best = max(forces, key=lambda force: force.share)
    gravity = next((force for force in forces if force.cause == "gravity"), None)
    if gravity is None or best.cause not in ("position", "ripple"):
        return best
    alike = tried(best.cause, columns[best.cause][:, :2])
    return gravity if 1.0 - gravity.share <= AS_GOOD * (1.0 - alike.share) else best


def _in_detail(
    ripple: Missing, rows: Rows, weighed: Weighed, explained: np.ndarray, left: np.ndarray, least: float
) -> Missing:
    """Return a ripple with whether it is alike in both directions, and how often in its period it comes back."""
    columns = waves(rows.position, rows.side, 1.0 / ripple.period)
    even, odd = (
        force_of(weighed, "ripple", part, explained=explained, left=left).share >= EVEN * ripple.share
        for part in (columns[:, :2], columns[:, 2:])
    )
    if not even or odd:
        return ripple._replace(alike=False if odd and not even else None)
    overtones, explained = [1], np.column_stack([explained, columns])
    for times in OVERTONES:
        pair = waves(rows.position, rows.side, times / ripple.period)[:, :2]
        force = force_of(weighed, "ripple", pair, explained=explained, left=weighed.left(explained))
        if force.share >= OVERTONE and force.force >= least:
            overtones.append(times)
            explained = np.column_stack([explained, pair])
    return ripple._replace(alike=True, overtones=tuple(overtones))

"""Which of several fits comes first: by the error on held-out blocks, and by what that error tells apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bristle.identification.result import Fit
from bristle.identification.settings import DEFAULT, Settings

__all__ = ["in_order", "ranked"]


def in_order(fits: Sequence[Fit], settings: Settings = DEFAULT) -> list[Fit]:
    """Return fits to the same log, best first.

    One that was interrupted has nothing held out. It comes last, unless it already explains far more than the best of
    the others: then that one is what a person who could wait no longer came for.
    """
    rest = [fit for fit in fits if fit.unfinished]
    finished = ranked([fit for fit in fits if not fit.unfinished], settings)
    ahead = [fit for fit in rest if finished and fit.error_percent < settings.unfinished_error * _error(finished[0])]
    return [*ahead, *finished, *(fit for fit in rest if fit not in ahead)]


def ranked(fits: Sequence[Fit], settings: Settings = DEFAULT) -> list[Fit]:
    """Return fits to the same log, best first.

    The smallest held-out error leads. Before it comes the simplest model whose error exceeds it by no more than
    the standard error of their difference, block by block. A leader of which half the parameters or more could not be
    identified has no claim: it gives way to any simpler model that could be, within the spread of its own error
    over the blocks.

    Parameters
    ----------
    fits : sequence of Fit
        Each with the errors of the same blocks, or none of them with any.
    settings : Settings
        The thresholds.
    """
    left, in_rank = list(fits), []
    while left:
        in_rank.append(_first(left, settings))
        left.remove(in_rank[-1])
    return in_rank


def _first(fits: list[Fit], settings: Settings) -> Fit:
    leader = min(fits, key=_error)
    if _doubtful(leader, settings):
        spread = leader.held_out.std_percent if leader.held_out else 0.0
        sound = [
            fit
            for fit in fits
            if not _doubtful(fit, settings) and _size(fit) < _size(leader) and _error(fit) <= _error(leader) + spread
        ]
        leader = min(sound, key=_error, default=leader)
    return min((fit for fit in fits if _no_worse(fit, leader, settings)), key=lambda fit: (_size(fit), _error(fit)))


def _no_worse(fit: Fit, leader: Fit, settings: Settings) -> bool:
    """Return whether the blocks do not tell a fit from the leader, or it is better."""
    if _doubtful(fit, settings) and not _doubtful(leader, settings):
        return False
    margin = settings.same_error * _error(leader)
    if fit.held_out is not None and leader.held_out is not None:
        apart = np.subtract(fit.held_out.block_errors_percent, leader.held_out.block_errors_percent)
        margin = max(margin, float(np.std(apart, ddof=1)) / apart.size**0.5)
    return _error(fit) <= _error(leader) + margin


def _error(fit: Fit) -> float:
    return fit.held_out.mean_percent if fit.held_out is not None else fit.error_percent


def _size(fit: Fit) -> int:
    return len(fit.correlation_names) + fit.further


def _doubtful(fit: Fit, settings: Settings) -> bool:
    searched = [estimate for estimate in fit.estimates if estimate.status != "held"]
    return bool(searched) and sum(
        estimate.status != "identified" for estimate in searched
    ) >= settings.doubtful_share * len(searched)

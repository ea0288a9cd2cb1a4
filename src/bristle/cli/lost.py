"""Blocks of a study or a fleet that no worker lived through, told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.cli.terminal import complain

if TYPE_CHECKING:
    from bristle.study.run import Ran

__all__ = ["tell_lost"]


def tell_lost(ran: Ran) -> None:
    """Tell which runs are missing, and how the processes ended that had them."""
    for block, code in ran.lost:
        complain(
            f"runs {block.first} to {block.last - 1} are missing: each process that simulated them ended "
            f"({_ended(code)}). Is there enough memory? The same command tries again"
        )


def _ended(code: int | None) -> str:
    if code is None:
        return "as the cluster tells it"
    return f"by signal {-code}" if code < 0 else f"with code {code}"

"""What makes a report move: scripts and data that another part of bristle writes, and what they may do."""

from __future__ import annotations

from typing import NamedTuple

from markupsafe import Markup

__all__ = ["Living"]


class Living(NamedTuple):
    """A part of a report in which parameters are moved; without scripts it is not there."""

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup
    follows: bool

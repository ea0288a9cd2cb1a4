"""What makes a report move: scripts and data that another part of bristle writes, and what they may do."""

from __future__ import annotations

from typing import NamedTuple

from markupsafe import Markup

__all__ = ["Living"]


class Living(NamedTuple):
    """A part of a report in which parameters are moved; without scripts it is not there.

    Parameters
    ----------
    policy : str
        What the page may do.
    style, shared, script : Markup
        Its style, the script that a worker runs too, and the other one.
    data : Markup
        What they show, in JSON.
    follows : bool
        Whether the loop is shown.
    """

    policy: str
    style: Markup
    shared: Markup
    script: Markup
    data: Markup
    follows: bool

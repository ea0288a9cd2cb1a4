"""Slots over a log channel: each is a file of this folder with a `SLOT`, named below."""

from importlib import import_module

from bristle.core.slot import Slot

__all__ = ["CHANNEL_SLOTS"]

FILES = ("pressure",)
CHANNEL_SLOTS: dict[str, Slot] = {name: import_module(f"{__name__}.{name}").SLOT for name in FILES}
"""Every channel slot of bristle, by name, from the innermost to the outermost."""

"""Slots over a channel of a log: each is a file of this folder with a `SLOT`, and its name below."""

from importlib import import_module

from bristle.core.slot import Slot

__all__ = ["CHANNEL_SLOTS"]

FILES = ("pressure",)
CHANNEL_SLOTS: dict[str, Slot] = {name: import_module(f"{__name__}.{name}").SLOT for name in FILES}
"""Every such slot of bristle, by name, in the order in which one stands around the other."""

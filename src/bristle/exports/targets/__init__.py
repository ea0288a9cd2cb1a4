"""The targets of the export: each is a file of this folder with a `TARGET`, and its name below, as help lists them."""

from __future__ import annotations

from importlib import import_module

from bristle.exports.target import Target

__all__ = ["TARGETS"]

FILES = ("c", "wasm", "st", "cuda", "table", "tf5200", "ax8000", "sinumerik", "cogging", "mjcf", "draws", "fmu2", "fmu3")
TARGETS: dict[str, Target] = {name: import_module(f"{__name__}.{name}").TARGET for name in FILES}
"""Every target of bristle, by name."""

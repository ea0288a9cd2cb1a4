"""The thresholds of an identification as tables: those that a person changed, and all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bristle.core.variable import Kind
from bristle.identification.settings import thresholds
from bristle.report.table import Table

if TYPE_CHECKING:
    from bristle.identification.settings import Settings

__all__ = ["changed_settings", "settings_table"]

SPEEDS: dict[Kind, str] = {"translational": "m/s", "rotational": "rad/s"}


def settings_table(settings: Settings, kind: Kind) -> Table:
    """Return every threshold of such an axis with its value, default and meaning."""
    foreign = {unit for of, unit in SPEEDS.items() if of != kind}
    names = [threshold.name for threshold in thresholds() if threshold.unit not in foreign]
    return _table("Thresholds of what is said and doubted", settings, names)


def changed_settings(settings: Settings) -> Table | None:
    """Return those thresholds that differ from the default; None where there is none."""
    return _table("Thresholds that were changed", settings, list(settings.changed)) if settings.changed else None


def _table(caption: str, settings: Settings, names: list[str]) -> Table:
    rows = [
        (
            threshold.name,
            f"{getattr(settings, threshold.name):g}",
            f"{threshold.default:g}",
            threshold.unit if threshold.unit != "1" else "–",
            f"{threshold.meaning} ({threshold.source})" if threshold.source else threshold.meaning,
        )
        for threshold in thresholds()
        if threshold.name in names
    ]
    return Table(caption, ("Name", "Value", "Default", "Unit", "Meaning"), rows)

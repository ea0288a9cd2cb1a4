"""Stiffness and damping from sweeps of small amplitude in reports, compared with those of the fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.core import with_unit
from bristle.report.brief import Line
from bristle.report.table import Table, capital, short_text

if TYPE_CHECKING:
    from bristle.identification import Identification

HEADS = (
    "Quantity",
    "Sweep",
    "95 % interval of the sweep [%]",
    "Fit",
    "95 % interval of the fit [%]",
)
CAPTION = """Contact at the amplitude zero, from sweeps and without a friction model, compared with the fit. The damping is that of bristles
and viscous friction together."""


def sweep_table(identification: Identification) -> Table | None:
    """Return stiffness and damping from the sweeps and from the fit; None without sweeps."""
    if not (items := _items(identification)):
        return None
    rows = [
        (
            capital(item.name),
            *_cells(item, item.value, item.half_width),
            *_cells(item, item.fitted, item.fitted_half_width),
        )
        for item in items
    ]
    return Table(
        f"{CAPTION} {_contradiction(identification)}".strip().replace("\n", " "), HEADS, rows
    )


def sweep_lines(identification: Identification) -> list[Line]:
    """Return stiffness and damping for the terminal, or the reason against them; empty without sweeps."""
    if isinstance(identification.sweep, str):
        return [Line("Sweep", f"no stiffness: {identification.sweep}")]
    texts = [
        f"{item.name} {' '.join(_cells(item, item.value, item.half_width))} %"
        for item in _items(identification)
    ]
    lines = [Line("Sweep", ", ".join(texts)), Line("", _contradiction(identification))]
    return [line for line in lines if line.text]


def sweep_data(identification: Identification) -> dict[str, Any]:
    """Return the sweeps for JSON: an entry with numbers, or with the reason against them; empty without sweeps."""
    sweep = identification.sweep
    if sweep is None or isinstance(sweep, str):
        return {"sweep": {"reason": sweep}} if sweep else {}
    quantities = {
        item.name: item._asdict() | {"differs": item.differs} for item in _items(identification)
    }
    curves = {name: getattr(sweep, name) for name in ("amplitudes", "stiffnesses", "losses")}
    return {
        "sweep": {
            "quantities": quantities,
            **curves,
            "contradiction": _contradiction(identification) or None,
        }
    }


def _items(identification: Identification) -> tuple[Any, ...]:
    sweep = identification.sweep
    if sweep is None or isinstance(sweep, str):
        return ()
    best = identification.best
    return sweep.compared_with(best.plant, best.friction, best.estimates)


def _contradiction(identification: Identification) -> str:
    """Return the quantities about which sweep and fit disagree, as a sentence; empty if they agree."""
    names = [item.name for item in _items(identification) if item.differs]
    return (
        f"The fit contradicts the sweep in {' and '.join(names)}. Prefer the sweep" if names else ""
    )


def _cells(item: Any, value: float | None, half: float | None) -> tuple[str, str]:
    share = "–" if not value or half is None else f"± {short_text(100.0 * half / abs(value))}"
    return "–" if value is None else with_unit(value, item.unit), share

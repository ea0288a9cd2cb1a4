"""Stiffness and damping from sweeps of small amplitude in reports, beside those of the fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bristle.core import with_unit
from bristle.report.brief import Line
from bristle.report.table import Table, capital, short_text

if TYPE_CHECKING:
    from bristle.identification import Identification

CAPTION = """Contact from sweeps of small amplitude, without a friction model, beside the fit. Stiffness and damping are those at
the amplitude zero. The damping is that of bristles and viscous friction together"""


def sweep_table(identification: Identification) -> Table | None:
    """Return stiffness, damping and mass from the sweeps, and the stiffness over the amplitude; None without sweeps."""
    sweep, fit = identification.sweep, identification.best
    if sweep is None or isinstance(sweep, str):
        return None
    rows = [
        (
            capital(item.name),
            with_unit(item.value, item.unit),
            _share(item.half_width, item.value),
            "–" if item.fitted is None else with_unit(item.fitted, item.unit),
            "–" if item.fitted is None or item.fitted_half_width is None else _share(item.fitted_half_width, item.fitted),
        )
        for item in sweep.beside(fit)
    ]
    caption = " ".join(filter(None, (f"{CAPTION}.", _contradiction(identification))))
    heads = ("Quantity", "Sweep", "95 % interval of the sweep [%]", f"Fit of {fit.name}", "95 % interval of the fit [%]")
    return Table(caption.replace("\n", " "), heads, rows)


def sweep_lines(identification: Identification) -> list[Line]:
    """Return stiffness and damping for the terminal, or the reason against them; empty without sweeps."""
    sweep = identification.sweep
    if sweep is None:
        return []
    if isinstance(sweep, str):
        return [Line("Sweep", f"no stiffness: {sweep}")]
    items = sweep.beside(identification.best)[:2]
    texts = [f"{item.name} {with_unit(item.value, item.unit)} {_share(item.half_width, item.value)} %" for item in items]
    lines = [Line("Sweep", ", ".join(texts))]
    return lines + ([Line("", text)] if (text := _contradiction(identification)) else [])


def sweep_data(identification: Identification) -> dict[str, Any]:
    """Return the sweeps for JSON: an entry with numbers, or with the reason against them; empty without sweeps."""
    sweep = identification.sweep
    if sweep is None or isinstance(sweep, str):
        return {} if sweep is None else {"sweep": {"reason": sweep}}
    quantities = {item.name: item._asdict() | {"differs": item.differs} for item in sweep.beside(identification.best)}
    curve = {name: getattr(sweep, name) for name in ("amplitudes", "stiffnesses", "losses")}
    return {"sweep": {"quantities": quantities, **curve, "contradiction": _contradiction(identification) or None}}


def _contradiction(identification: Identification) -> str:
    """Return the quantities about which sweep and fit disagree, as a sentence; empty if they agree."""
    sweep = identification.sweep
    if sweep is None or isinstance(sweep, str):
        return ""
    names = [item.name for item in sweep.beside(identification.best) if item.differs]
    return f"The fit contradicts the sweep in {' and '.join(names)}. Prefer the sweep" if names else ""


def _share(half: float, value: float) -> str:
    return f"± {short_text(100.0 * half / abs(value))}" if value else "–"

"""Names and units of columns as this package writes them: printed, told apart, with a note where a file has others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from unicodedata import normalize

from bristle.core.typography import printable
from bristle.logs.table import Table, split_unit


def listed(text: str) -> tuple[str, ...]:
    """Entries of a list that is written with strokes between, or with blanks where there is none."""
    return tuple(text.split(" | " if " | " in text else None))


def spelt(units: Mapping[str, str]) -> dict[str, str]:
    """Spelling -> unit, of spellings that stand behind their unit."""
    return {spelling: unit for unit, spellings in units.items() for spelling in spellings.split(" | ")}


# How units are written on screens and in exports -> how this package writes them.
WRITTEN = spelt(
    {
        "rpm": "u/min | upm | 1/min | min-1 | min^-1 | min⁻¹ | r/min | rev/min | umdr/min | umin",
        "rev/s": "u/s | rps",
        "rev": "u | umdr | umdr. | umdrehungen | umdrehung | revs | revolutions | turns | r",
        "deg": "grad | degree | degrees | deg. | ° | º",
        "deg/s": "grad/s | degree/s | °/s | º/s | deg/sec | dps",
        "rad": "radian | radians",
        "rad/s": "rad/sec",
        "count": "inc | incr | inkr | inkr. | inkremente | increments | increment | counts | cnt | cnts | count | ticks | tick | pulse | "
        "pulses | lsb | digit | digits | digit(s) | lu | cts",
        "count/s": "inc/s | counts/s | cnt/s | cts/s | inc/sec",
        "‰": "%o | permille | per mille | promille | 0.1% | 0,1% | 0.1 % | 0,1 % | ‰ rated | 1/1000 | o/oo",
        "%": "percent | prozent | % rated | %rated | % mn | %mn | pct | % nenn",
        "N*m": "nm | n m | n.m | n-m | newtonmeter",
        "N": "newton | newtons",
        "mN*m": "mnm",
        "kN*m": "knm",
        "N*cm": "ncm | cnm",
        "N*mm": "nmm",
        "A": "arms | a_rms | a rms | aeff | a_eff | a eff | apk | amp | amps | ampere | a(rms)",
        "mA": "marms",
        "V": "volt | volts",
        "s": "sek | sec | secs | second | seconds | sekunde | sekunden | sec.",
        "ms": "msec | millisec | milliseconds | millisekunden",
        "us": "usec | microseconds",
        "m": "meter | metre | meters",
        "mm": "millimeter",
        "mm/s": "mm/sec",
        "m/s": "m/sec",
        "um": "micron | microns | mikrometer",
        "inch": "inch | in",
        "degC": "celsius | °c | deg c | degc",
        "mm/min": "mm/min.",
        "kg*m^2": "kgm²",
        "s^2": "s²",
        "m/s^2": "m/s²",
        "mm/s^2": "mm/s²",
    }
)
NO_UNIT = frozenset({"", "-", "--", "1", "none", "(none)", "n/a", "na", "unitless", "dimensionless", "ohne", "[]", "?"})
CASED = spelt(
    {
        "N*m": "Nm",
        "nm": "nm",
        "mN*m": "mNm",
        "MN*m": "MNm",
        "rev": "U | r | R",
        "": "u | a | v | n | k",
        "A": "A",
        "s": "s | S",
        "m": "m",
        "V": "V",
        "N": "N",
        "inch": "IN",
        "K": "K",
    }
)


def plain_unit(written: str) -> str:
    """Return a unit as this package writes it; empty where it is none that is known to be another's spelling."""
    text = normalize("NFC", written).strip().strip("[]").strip()
    text = text[1:-1].strip() if text.startswith("(") and text.endswith(")") and "(" not in text[1:] else text
    if text.lower() in NO_UNIT:
        return ""
    if text in CASED:
        return CASED[text]
    return WRITTEN.get(text.lower(), text)


def distinct(names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return names of which none stands twice, and a note for each that did; a letter has one spelling (NFC)."""
    unique = [normalize("NFC", name) for name in names]
    used, notes = set(unique), []
    counts: dict[str, int] = {}
    for index, name in enumerate(unique):
        counts[name] = counts.get(name, 0) + 1
        if counts[name] == 1:
            continue
        while (candidate := f"{name}_{counts[name]}") in used:
            counts[name] += 1
        used.add(candidate)
        unique[index] = candidate
        notes.append(f"column {index + 1} is called {name[:60]!r}, as one before it: it is taken as {candidate[:64]!r}")
    return unique, notes


def names_and_units(headers: Iterable[str], stated: Mapping[str, str]) -> tuple[list[str], dict[str, str], list[str]]:
    """Return names without their units, of which none stands twice; the unit of each that has one; notes.

    A column whose unit is stated keeps its name as it is; of another the brackets behind it are its unit.
    """
    parts = [(header, stated[header]) if header in stated else split_unit(header) for header in headers]
    names, notes = distinct(name for name, _ in parts)
    return names, {name: unit for name, (_, unit) in zip(names, parts, strict=True) if unit}, notes


def with_plain_names(table: Table) -> Table:
    """Return a table whose names and units can be printed: control characters do things to a terminal."""
    stated = {name: unit for name, written in table.units.items() if (unit := plain_unit(written))}  # some say that there is none
    odd = [name for name in (*table.names, *table.texts) if not name.isprintable()]
    units = {name: unit for name, unit in stated.items() if unit.isprintable() and len(unit) <= 80}
    if not odd and len(units) == len(stated):
        return replace(table, units=units)
    plain, _ = distinct(printable(name).strip() or "column" for name in table.names)
    called = dict(zip(table.names, plain, strict=True))
    notes = [
        f"the name of a column holds characters that cannot be printed: it is taken as {called[name]!r}" for name in odd if name in called
    ]
    notes += [f"column {called[name]!r} has a unit that cannot be read, which was left out" for name in stated if name not in units]
    return replace(
        table,
        columns={called[name]: values for name, values in table.columns.items()},
        units={called[name]: unit for name, unit in units.items()},
        names=tuple(plain),
        texts={printable(name): reason for name, reason in table.texts.items()},
        notes=(*table.notes, *notes),
        stamps={called[name]: called[time] for name, time in table.stamps.items()},
        about={called[name]: text for name, text in table.about.items()},
        numbers={number: called.get(name, name) for number, name in table.numbers.items()},
    )

"""What columns are called: the words of drives and of people, in English and German, and units as they are written."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple, TypeVar
from unicodedata import normalize

import numpy as np

from bristle.core import units
from bristle.core.typography import printable
from bristle.logs.table import Table, split_unit, without_index

__all__ = [
    "Meaning",
    "distinct",
    "is_time",
    "meaning_of",
    "names_and_units",
    "plain_unit",
    "unit_in_name",
    "unit_of_time",
    "with_plain_names",
    "without_part",
    "words_of",
]


def _words(text: str) -> tuple[str, ...]:
    """Words of a list that is written with blanks between."""
    return tuple(text.split())


# Words that mean a role. A long one counts within a compound as well: "lageistwert", "positionActual".
ROLES: dict[str, tuple[str, ...]] = {
    "time": _words("time zeit timestamp zeitstempel t stamp sec secs second seconds sekunden temps tiempo tempo abtastzeitpunkt elapsed"),
    "error": _words(
        "followingerror schlepp poserr positionerror lageabweichung regelabweichung regeldifferenz contouringerror trackingerror poslag "
        "posdiff ctrldev schleppabstand schleppfehler perr pe positioningerror lagefehler following fehler error err deviation"
    ),
    "effort": _words(
        "torque trq tau moment drehmoment momentenistwert nm force kraft effort current actcurr strom iq isq icmd ist_strom motorstrom "
        "amps ampere motorcurrent load thrust stellgroesse stellgrosse control voltage spannung u pwm vorschubkraft m f i couple "
        "stromsoll last auslastung duty"
    ),
    "velocity": _words("velocity vel speed geschwindigkeit geschw drehzahl rpm omega v qd dq nist nsoll rate spd n w vitesse xdot qdot"),
    "acceleration": ("acceleration", "accel", "acc", "beschleunigung", "beschl", "a", "qdd"),
    "temperature": ("temperature", "temperatur", "temp", "celsius"),
    "position": _words(
        "position pos lage weg ort winkel angle encoder enc hub travel displacement x q s y z phi theta strecke drehwinkel schlitten "
        "counts stroke pfb linearscale massstab lagegeber actpos xact location"
    ),
}
REFERENCE = _words(
    "set soll sollwert ref reference referenz cmd command commanded demand target desired goal setpoint sp setpos fuehrungsgroesse "
    "vorgabe ziel nominal kommando refpos dem des trajectory vcmd pcmd"
)
ACTUAL = _words("act actual ist istwert fbk feedback fb meas measured measurement real rbv current_position gemessen mess messwert state")
SHORTEST_PART = 3  # letters of a word for a reference that begins or ends a name
WITHIN = 4  # letters from which on a word counts within another one
# Parts of longer words that mean something else than they say.
NOT_WITHIN = {
    "last": ("elast", "plast", "blast"),
    "rate": ("rated", "acceler", "temperat", "operat", "gener"),
    "load": ("download", "upload"),
    "temp": ("tempo", "attempt"),
}
STATUS = _words(
    "status enable enabled trigger mode state modus freigabe flag index counter id error_code digital bit sample row number nr seq fault"
)


class Meaning(NamedTuple):
    """What the name of a column means."""

    role: str = ""
    reference: bool = False
    actual: bool = False
    sure: float = 0.0


def words_of(name: str) -> list[str]:
    """Return the words of a name, in small letters without accents.

    Examples
    --------
    >>> words_of("Axis1.fActPosition"), words_of("Lage_Istwert"), words_of("x-soll")
    (['axis', 'f', 'act', 'position'], ['lage', 'istwert'], ['x', 'soll'])
    """
    folded = name.replace("ß", "ss")
    for umlaut, plain in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("Ä", "Ae"), ("Ö", "Oe"), ("Ü", "Ue")):
        folded = normalize("NFC", folded).replace(umlaut, plain)
    folded = normalize("NFKD", folded).encode("ascii", "ignore").decode()
    split = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", folded)
    return [word.lower() for word in re.split(r"[^A-Za-z]+", split) if word]


@lru_cache(maxsize=2**16)
def meaning_of(name: str, about: str = "") -> Meaning:
    """Return what the name of a column means; what else is said of it counts where the name says nothing.

    Examples
    --------
    >>> meaning_of("Lageistwert").role, meaning_of("ActTorque").role, meaning_of("Schleppabstand").role
    ('position', 'effort', 'error')
    >>> meaning_of("positionssollwert")[:2], meaning_of("drehzahl_soll")[:2]
    (('position', True), ('velocity', True))
    """
    if name.lower().startswith("x_value"):  # of LabVIEW
        return Meaning("time", sure=1.0)
    name = without_index(name)
    head, stroke, unit = name.rpartition("/")
    if stroke and head and plain_unit(unit) in units.DECIMAL_UNITS:
        name = head
    last = re.split(r"::|[./\\\\|]", name.strip())[-1] or name
    best = _meaning(words_of(last))
    full = _meaning(words_of(name))
    if not best.role and full.role:
        best = full._replace(sure=0.8 * full.sure)
    if not best.role and about:
        best = _meaning(words_of(about))
        best = best._replace(sure=0.5 * best.sure)
    return best._replace(
        reference=best.reference or (full.reference and not best.actual), actual=best.actual or (full.actual and not best.reference)
    )


def _meaning(words: Sequence[str]) -> Meaning:
    if len(words) > 1 and words[-1] == NANOMETERS and (before := _meaning(words[:-1])).role in LENGTHS:
        return before
    reference, actual = _says(words, REFERENCE), _says(words, ACTUAL)
    joined = "".join(words)
    scores: dict[str, float] = {}
    for role, vocabulary in ROLES.items():
        exact = max((_weight(word) for word in words if word in vocabulary), default=0.0)
        inside = max((0.8 * _weight(word) for word in vocabulary if len(word) >= WITHIN and _within(word, joined)), default=0.0)
        scores[role] = max(exact, inside)
    if (
        scores["error"] > 0.5
        and (scores["position"] or scores["error"] > 0.75)
        and not _says(words, ("fehlercode", "code", "error_code", "id"))
    ):
        scores["error"] += 0.3
    if any(word in STATUS for word in words) and max(scores.values()) < 0.9:
        return Meaning("status", sure=0.5)
    role = max(scores, key=lambda role_name: scores[role_name])
    if not scores[role]:
        return Meaning(reference=reference, actual=actual)
    return Meaning(
        role, reference and not (actual and not _says(words, ("soll", "sollwert", "setpoint", "command"))), actual, min(scores[role], 1.0)
    )


def _weight(word: str) -> float:
    """Return how much a word tells: single letters mean many things."""
    return {1: 0.4, 2: 0.7}.get(len(word), 1.0)


def _within(word: str, text: str) -> bool:
    at = text.find(word)
    return at >= 0 and not any(longer in text for longer in NOT_WITHIN.get(word, ()))


def _says(words: Sequence[str], vocabulary: Sequence[str]) -> bool:
    joined = "".join(words)
    return (
        any(word in vocabulary for word in words)
        or any(len(word) >= WITHIN and word in joined for word in vocabulary)
        or any(
            joined.startswith(word) or joined.endswith(word)
            for word in vocabulary
            if len(word) == 3 and word in ("set", "act", "ist", "ref", "cmd")
        )
    )


def without_part(joined: str) -> str:
    """Return the letters of a name without the part that says whether it is a reference or was measured.

    Examples
    --------
    >>> without_part("sollweg"), without_part("wegist"), without_part("posactual"), without_part("poscmd")
    ('weg', 'weg', 'pos', 'pos')
    """
    for word in sorted((*REFERENCE, *ACTUAL), key=len, reverse=True):
        if len(word) >= SHORTEST_PART and len(word) < len(joined):
            for found in (joined.removeprefix(word), joined.removesuffix(word)):
                if found != joined:
                    return found
    return joined


def is_time(name: str) -> bool:
    """Return whether a column is called as times usually are.

    Examples
    --------
    >>> is_time("timestamp"), is_time("Zeit"), is_time("t_ms"), is_time("position")
    (True, True, True, False)
    """
    meaning = meaning_of(name)
    return meaning.role == "time" and meaning.sure >= 0.4 and not meaning.reference


# How units are written on screens and in exports -> how this package writes them.
WRITTEN = {
    "u/min": "rpm",
    "upm": "rpm",
    "1/min": "rpm",
    "min-1": "rpm",
    "min^-1": "rpm",
    "min⁻¹": "rpm",
    "r/min": "rpm",
    "rev/min": "rpm",
    "umdr/min": "rpm",
    "umin": "rpm",
    "u/s": "rev/s",
    "rps": "rev/s",
    "u": "rev",
    "umdr": "rev",
    "umdr.": "rev",
    "umdrehungen": "rev",
    "umdrehung": "rev",
    "revs": "rev",
    "revolutions": "rev",
    "turns": "rev",
    "r": "rev",
    "grad": "deg",
    "degree": "deg",
    "degrees": "deg",
    "grad/s": "deg/s",
    "degree/s": "deg/s",
    "deg.": "deg",
    "°": "deg",
    "º": "deg",
    "°/s": "deg/s",
    "º/s": "deg/s",
    "deg/sec": "deg/s",
    "dps": "deg/s",
    "radian": "rad",
    "radians": "rad",
    "rad/sec": "rad/s",
    "inc": "count",
    "incr": "count",
    "inkr": "count",
    "inkr.": "count",
    "inkremente": "count",
    "increments": "count",
    "increment": "count",
    "counts": "count",
    "cnt": "count",
    "cnts": "count",
    "count": "count",
    "ticks": "count",
    "tick": "count",
    "pulse": "count",
    "pulses": "count",
    "lsb": "count",
    "digit": "count",
    "digits": "count",
    "digit(s)": "count",
    "lu": "count",
    "inc/s": "count/s",
    "counts/s": "count/s",
    "cnt/s": "count/s",
    "cts": "count",
    "cts/s": "count/s",
    "inc/sec": "count/s",
    "%o": "‰",
    "permille": "‰",
    "per mille": "‰",
    "promille": "‰",
    "0.1%": "‰",
    "0,1%": "‰",
    "0.1 %": "‰",
    "0,1 %": "‰",
    "‰ rated": "‰",
    "1/1000": "‰",
    "o/oo": "‰",
    "percent": "%",
    "prozent": "%",
    "% rated": "%",
    "%rated": "%",
    "% mn": "%",
    "%mn": "%",
    "pct": "%",
    "% nenn": "%",
    "nm": "N*m",
    "n m": "N*m",
    "n.m": "N*m",
    "n-m": "N*m",
    "newtonmeter": "N*m",
    "newton": "N",
    "newtons": "N",
    "mnm": "mN*m",
    "knm": "kN*m",
    "ncm": "N*cm",
    "cnm": "N*cm",
    "nmm": "N*mm",
    "arms": "A",
    "a_rms": "A",
    "a rms": "A",
    "aeff": "A",
    "a_eff": "A",
    "a eff": "A",
    "apk": "A",
    "amp": "A",
    "amps": "A",
    "ampere": "A",
    "a(rms)": "A",
    "marms": "mA",
    "volt": "V",
    "volts": "V",
    "sek": "s",
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "sekunde": "s",
    "sekunden": "s",
    "msec": "ms",
    "millisec": "ms",
    "milliseconds": "ms",
    "millisekunden": "ms",
    "usec": "us",
    "microseconds": "us",
    "sec.": "s",
    "meter": "m",
    "metre": "m",
    "meters": "m",
    "millimeter": "mm",
    "mm/sec": "mm/s",
    "m/sec": "m/s",
    "micron": "um",
    "microns": "um",
    "mikrometer": "um",
    "inch": "inch",
    "in": "inch",
    "celsius": "degC",
    "°c": "degC",
    "deg c": "degC",
    "degc": "degC",
    "mm/min.": "mm/min",
    "kgm²": "kg*m^2",
    "s²": "s^2",
    "m/s²": "m/s^2",
    "mm/s²": "mm/s^2",
}
NO_UNIT = frozenset({"", "-", "--", "1", "none", "(none)", "n/a", "na", "unitless", "dimensionless", "ohne", "[]", "?"})
CASED = {
    "Nm": "N*m",
    "nm": "nm",
    "mNm": "mN*m",
    "MNm": "MN*m",
    "U": "rev",
    "u": "",
    "A": "A",
    "a": "",
    "s": "s",
    "S": "s",
    "m": "m",
    "V": "V",
    "v": "",
    "N": "N",
    "n": "",
    "r": "rev",
    "R": "rev",
    "IN": "inch",
    "K": "K",
    "k": "",
}


def plain_unit(written: str) -> str:
    """Return a unit as this package writes it; empty where it is none that is known to be another's spelling.

    Examples
    --------
    >>> plain_unit("U/min"), plain_unit("Nm"), plain_unit("(None)"), plain_unit("0,1 %"), plain_unit("mm/s")
    ('rpm', 'N*m', '', '‰', 'mm/s')
    """
    text = normalize("NFC", written).strip().strip("[]").strip()
    text = text[1:-1].strip() if text.startswith("(") and text.endswith(")") and "(" not in text[1:] else text
    if text.lower() in NO_UNIT:
        return ""
    if text in CASED:
        return CASED[text]
    return WRITTEN.get(text.lower(), text)


NANOMETERS, LENGTHS = "nm", ("position", "error")  # or newton meters; roles that are lengths
SLOWEST = 0.05  # s between samples of an axis
LONG_AGO = 1e8  # s
ENDINGS = {
    "s": "s",
    "sec": "s",
    "ms": "ms",
    "msec": "ms",
    "us": "us",
    "usec": "us",
    "ns": "ns",
    "m": "m",
    "mm": "mm",
    "um": "um",
    "nm": "N*m",
    "rad": "rad",
    "mrad": "mrad",
    "deg": "deg",
    "grad": "deg",
    "rev": "rev",
    "mms": "mm/s",
    "rpm": "rpm",
    "rads": "rad/s",
    "degs": "deg/s",
    "n": "N",
    "kn": "kN",
    "a": "A",
    "ma": "mA",
    "v": "V",
    "percent": "%",
    "pct": "%",
    "permille": "‰",
    "inc": "count",
    "counts": "count",
    "cnt": "count",
    "mps": "m/s",
    "dps": "deg/s",
    "mnm": "mN*m",
    "amps": "A",
    "umin": "rpm",
    "seconds": "s",
    "nanosec": "ns",
}


def unit_in_name(name: str) -> str:
    """Return the unit that a name ends with behind a stroke, a blank or an underscore; empty where it names none.

    Examples
    --------
    >>> unit_in_name("pos_mm"), unit_in_name("phi deg"), unit_in_name("speed_rad_s"), unit_in_name("torque")
    ('mm', 'deg', 'rad/s', '')

    Small letters of torque are those of nanometers as well: what stands before them tells.

    >>> unit_in_name("pos_nm"), unit_in_name("torque_nm"), unit_in_name("ref_nm")
    ('nm', 'N*m', '')
    """
    parts = [part for part in re.split(r"[\s_\-./\[\]()]+", name.strip()) if part]
    if len(parts) > 2 and parts[-1].lower() in ("s", "sec", "min") and parts[-2].lower() in ("mm", "m", "um", "rad", "deg", "rev", "u"):
        return f"{plain_unit(parts[-2])}/{parts[-1].lower()[:3].removesuffix('ec')}".replace("rev/min", "rpm")
    if len(parts) < 2 or len(parts[-1]) > 8:
        return ""
    if parts[-1] == NANOMETERS:
        before = _meaning(words_of(" ".join(parts[:-1])))
        return "nm" if before.role in LENGTHS else "" if before.reference and not before.role else ENDINGS[NANOMETERS]
    return "um" if parts[-1] in ("µm", "μm") else ENDINGS.get(parts[-1].lower(), "")


def unit_of_time(name: str, values: np.ndarray) -> str:
    """Return the unit of stamps that have none: that in their name, or in which they count since 1970 or from 0 on.

    No axis is sampled so seldom that steps of more than a twentieth could be seconds.
    """
    named = unit_in_name(name)
    if named in ("s", "ms", "us", "ns"):
        return named
    largest = float(np.max(np.abs(values))) if values.size else 0.0
    for bound, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")):
        if largest > bound:
            return unit
    step = float(np.nanmedian(np.abs(np.diff(values)))) if values.size > 1 else 0.0
    return "ms" if largest < LONG_AGO and step > SLOWEST else "s"


T = TypeVar("T")
LONGEST_UNIT_SHOWN = 80


def distinct(names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return names of which none stands twice, and a note for each that did; a letter has one spelling (NFC).

    Examples
    --------
    >>> distinct(["t", "q", "q"])
    (['t', 'q', 'q_2'], ["column 3 is called 'q', as one before it: it is taken as 'q_2'"])
    """
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

    Examples
    --------
    >>> names_and_units(["position [um]", "effort", "time"], {"effort": "N"})
    (['position', 'effort', 'time'], {'position': 'um', 'effort': 'N'}, [])
    """
    parts = [(header, stated[header]) if header in stated else split_unit(header) for header in headers]
    names, notes = distinct(name for name, _ in parts)
    return names, {name: unit for name, (_, unit) in zip(names, parts, strict=True) if unit}, notes


def with_plain_names(table: Table) -> Table:
    """Return a table whose names and units can be printed: control characters do things to a terminal."""
    table = replace(table, units=_plain_units(table.units))
    odd = [name for name in (*table.names, *table.texts) if not name.isprintable()]
    units = {name: unit for name, unit in table.units.items() if unit.isprintable() and len(unit) <= LONGEST_UNIT_SHOWN}
    if not odd and len(units) == len(table.units):
        return table
    plain, _ = distinct(printable(name).strip() or "column" for name in table.names)
    called = dict(zip(table.names, plain, strict=True))
    notes = [
        f"the name of a column holds characters that cannot be printed: it is taken as {called[name]!r}" for name in odd if name in called
    ]
    notes += [f"column {called[name]!r} has a unit that cannot be read, which was left out" for name in table.units if name not in units]
    return replace(
        table,
        columns=_called(table.columns, called),
        units=_called(units, called),
        names=tuple(plain),
        texts={printable(name): reason for name, reason in table.texts.items()},
        notes=(*table.notes, *notes),
        stamps={called[name]: called[time] for name, time in table.stamps.items()},
        about=_called(table.about, called),
        numbers={number: called.get(name, name) for number, name in table.numbers.items()},
    )


def _plain_units(units: Mapping[str, str]) -> dict[str, str]:
    """Return units as this package writes them; those that say that there is none are left out."""
    plain = {name: plain_unit(unit) for name, unit in units.items()}
    return {name: unit for name, unit in plain.items() if unit}


def _called(values: Mapping[str, T], called: Mapping[str, str]) -> dict[str, T]:
    return {called[name]: value for name, value in values.items()}

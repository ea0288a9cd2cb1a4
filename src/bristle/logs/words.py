"""Vocabulary of names of columns and units, of drives and of people, in English and German."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple
from unicodedata import normalize

import numpy as np

from bristle.core import printable, units
from bristle.logs.table import Table, split_unit, without_index


def listed(text: str) -> tuple[str, ...]:
    """Return the entries of a list separated by strokes, or by blanks if it has no stroke."""
    return tuple(text.split(" | " if " | " in text else None))


def spelt(units: str) -> dict[str, str]:
    """Return a mapping of spelling to unit, from spellings listed after their unit; a minus means no unit."""
    entries = (entry.split(": ") for entry in units.split("; "))
    return {
        spelling: unit.strip("-")
        for unit, spellings in entries
        for spelling in spellings.split(" | ")
    }


# Spellings of units on screens and in exports -> spelling of this package.
WRITTEN = spelt(
    "rpm: u/min | upm | 1/min | min-1 | min^-1 | min⁻¹ | r/min | rev/min | umdr/min | umin; rev/s: u/s | rps; "
    "rev: u | umdr | umdr. | umdrehungen | umdrehung | revs | revolutions | turns | r; deg: grad | degree | degrees | deg. | ° | º; "
    "deg/s: grad/s | degree/s | °/s | º/s | deg/sec | dps; rad: radian | radians; rad/s: rad/sec; "
    "count: inc | incr | inkr | inkr. | inkremente | increments | increment | counts | cnt | cnts | count | ticks | "
    "tick | pulse | pulses | lsb | digit | digits | digit(s) | lu | cts; "
    "count/s: inc/s | counts/s | cnt/s | cts/s | inc/sec; "
    "‰: %o | permille | per mille | promille | 0.1% | 0,1% | 0.1 % | 0,1 % | ‰ rated | 1/1000 | o/oo; "
    "%: percent | prozent | % rated | %rated | % mn | %mn | pct | % nenn; N*m: nm | n m | n.m | n-m | newtonmeter; "
    "N: newton | newtons; mN*m: mnm; kN*m: knm; N*cm: ncm | cnm; N*mm: nmm; "
    "A: arms | a_rms | a rms | aeff | a_eff | a eff | apk | amp | amps | ampere | a(rms); mA: marms; V: volt | volts; "
    "s: sek | sec | secs | second | seconds | sekunde | sekunden | sec.; ms: msec | millisec | milliseconds | millisekunden; "
    "us: usec | microseconds; m: meter | metre | meters; mm: millimeter; mm/s: mm/sec; m/s: m/sec; "
    "um: micron | microns | mikrometer; inch: inch | in; degC: celsius | °c | deg c | degc; mm/min: mm/min.; kg*m^2: kgm²; s^2: s²; "
    "m/s^2: m/s²; mm/s^2: mm/s²; Hz: s/s | sa/s | sps | sample/s | samples/s | samples per second; kHz: ks/s | ksa/s | ksps"
)
NO_UNIT = frozenset(
    {
        "",
        "-",
        "--",
        "1",
        "none",
        "(none)",
        "n/a",
        "na",
        "unitless",
        "dimensionless",
        "ohne",
        "[]",
        "?",
    }
)
CASED = spelt(
    "N*m: Nm; nm: nm; mN*m: mNm; MN*m: MNm; rev: U | r | R; -: u | a | v | n | k; A: A; s: s | S; m: m; V: V; N: N; inch: IN; K: K"
)


def converts(unit: str, base: str) -> bool:
    """Return whether a text is a unit of the quantity of another unit."""
    return bool(unit) and units.is_unit(unit) and units.compatible(unit, base)


def plain_unit(written: str) -> str:
    """Return a unit in the spelling of this package; empty for texts that mean "no unit"."""
    text = normalize("NFC", written).strip().strip("[]").strip()
    text = (
        text[1:-1].strip()
        if text.startswith("(") and text.endswith(")") and "(" not in text[1:]
        else text
    )
    if text.lower() in NO_UNIT:
        return ""
    if text in CASED:
        return CASED[text]
    return WRITTEN.get(text.lower(), text)


def distinct(names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return unique names, and a note for each duplicate; letters are normalised (NFC)."""
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
        both = f"columns {unique.index(name) + 1} and {index + 1} are called {name[:60]!r}"
        notes.append(
            f"{both}: bristle takes the first one by this name, and the other one by {candidate[:64]!r}"
        )
        unique[index] = candidate
    return unique, notes


def names_and_units(
    headers: Iterable[str], stated: Mapping[str, str]
) -> tuple[list[str], dict[str, str], list[str]]:
    """Return unique names without their units, the known units, and notes; a column with a stated unit keeps its name."""
    parts = [
        (header, stated[header]) if header in stated else split_unit(header) for header in headers
    ]
    names, notes = distinct(name for name, _ in parts)
    return names, {name: unit for name, (_, unit) in zip(names, parts, strict=True) if unit}, notes


def with_plain_names(table: Table) -> Table:
    """Return a table with printable names and units: control characters can change the state of a terminal."""
    # Some state that there is no unit.
    stated = {name: unit for name, written in table.units.items() if (unit := plain_unit(written))}
    odd = [name for name in (*table.names, *table.texts) if not name.isprintable()]
    units = {name: unit for name, unit in stated.items() if unit.isprintable() and len(unit) <= 80}
    if not odd and len(units) == len(stated):
        return replace(table, units=units)
    plain, _ = distinct(printable(name).strip() or "column" for name in table.names)
    called = dict(zip(table.names, plain, strict=True))
    notes = [
        f"the name of a column has unprintable characters: bristle calls it {called[name]!r}"
        for name in odd
        if name in called
    ]
    notes += [
        f"bristle ignores the unreadable unit of column {called[name]!r}"
        for name in stated
        if name not in units
    ]
    return replace(
        table,
        columns={called[name]: values for name, values in table.columns.items()},
        units={called[name]: unit for name, unit in units.items()},
        names=tuple(plain),
        texts={printable(name): reason for name, reason in table.texts.items()},
        notes=(*table.notes, *notes),
        stamps={called[name]: called[time] for name, time in table.stamps.items()},
        about={called[name]: text for name, text in table.about.items()},
        joints={called[name]: joint for name, joint in table.joints.items()},
        numbers={number: called.get(name, name) for number, name in table.numbers.items()},
    )


# Words that mean a role. Long words also count inside a compound: "lageistwert", "positionActual".
ROLES: dict[str, tuple[str, ...]] = {
    "time": listed(
        "time zeit timestamp zeitstempel t stamp sec secs second seconds sekunden temps tiempo tempo abtastzeitpunkt elapsed"
    ),
    "error": listed(
        "followingerror schlepp poserr positionerror lageabweichung regelabweichung regeldifferenz contouringerror trackingerror poslag "
        "posdiff ctrldev schleppabstand schleppfehler perr pe positioningerror lagefehler following fehler error err deviation"
    ),
    "effort": listed(
        "torque trq tau moment drehmoment momentenistwert nm force kraft effort current actcurr strom iq isq icmd ist_strom motorstrom "
        "amps ampere motorcurrent load thrust stellgroesse stellgrosse control voltage spannung u pwm vorschubkraft m f i couple "
        "stromsoll last auslastung duty"
    ),
    "velocity": listed(
        "velocity vel speed geschwindigkeit geschw drehzahl rpm omega v qd dq nist nsoll rate spd n w vitesse xdot qdot"
    ),
    "acceleration": ("acceleration", "accel", "acc", "beschleunigung", "beschl", "a", "qdd"),
    "temperature": ("temperature", "temperatur", "temp", "celsius"),
    "position": listed(
        "position pos lage weg ort winkel angle encoder enc hub travel displacement x q s y z phi theta strecke drehwinkel schlitten "
        "counts stroke pfb linearscale massstab lagegeber actpos xact location"
    ),
}
REFERENCE = listed(
    "set soll sollwert ref reference referenz cmd command commanded demand target desired goal setpoint sp setpos fuehrungsgroesse "
    "vorgabe ziel nominal kommando refpos dem des trajectory vcmd pcmd"
)
ACTUAL = listed(
    "act actual ist istwert fbk feedback fb meas measured measurement real rbv current_position gemessen mess messwert state"
)
OF_LOAD = listed(
    "load last table tisch scale massstab carriage schlitten slide abtrieb external extern"
)
WITHIN = 4  # shortest word that counts inside another word
# Parts of longer words with a different meaning.
NOT_WITHIN = {
    "last": ("elast", "plast", "blast"),
    "rate": ("rated", "acceler", "temperat", "operat", "gener"),
    "load": ("download", "upload"),
    "temp": ("tempo", "attempt"),
}
STATUS = listed(
    "status enable enabled trigger mode state modus freigabe flag index counter id error_code digital bit sample row number nr seq fault"
)


class Meaning(NamedTuple):
    """Meaning of the name of a column."""

    role: str = ""
    reference: bool = False
    actual: bool = False
    sure: float = 0.0


def words_of(name: str) -> list[str]:
    """Return the words of a name, in small letters without accents."""
    folded = name.replace("ß", "ss")
    for umlaut, plain in (
        ("ä", "ae"),
        ("ö", "oe"),
        ("ü", "ue"),
        ("Ä", "Ae"),
        ("Ö", "Oe"),
        ("Ü", "Ue"),
    ):
        folded = normalize("NFC", folded).replace(umlaut, plain)
    folded = normalize("NFKD", folded).encode("ascii", "ignore").decode()
    split = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", folded)
    return [word.lower() for word in re.split(r"[^A-Za-z]+", split) if word]


@lru_cache(maxsize=2**16)
def meaning_of(name: str, about: str = "") -> Meaning:
    """Return the meaning of the name of a column; its description counts if the name has no meaning."""
    if name.lower().startswith("x_value"):  # of LabVIEW
        return Meaning("time", sure=1.0)
    name = without_index(name)
    head, stroke, unit = name.rpartition("/")
    if stroke and head and units.is_decimal(plain_unit(unit)):
        name = head
    last = re.split(r"::|[./\\\\|]", name.strip())[-1] or name
    best, full = _meaning(words_of(last)), _meaning(words_of(name))
    if not best.role and full.role:
        best = full._replace(sure=0.8 * full.sure)
    if not best.role and about:
        best = _meaning(words_of(about))
        best = best._replace(sure=0.5 * best.sure)
    reference, actual = (
        best.reference or (full.reference and not best.actual),
        best.actual or (full.actual and not best.reference),
    )
    return best._replace(reference=reference, actual=actual)


def _meaning(words: Sequence[str]) -> Meaning:
    if (
        len(words) > 1
        and words[-1] in (NANOMETERS, "m")
        and (before := _meaning(words[:-1])).role in LENGTHS
    ):
        return before
    reference, actual = _says(words, REFERENCE), _says(words, ACTUAL)
    joined = "".join(words)
    scores: dict[str, float] = {}
    for role, vocabulary in ROLES.items():
        exact = max((_weight(word) for word in words if word in vocabulary), default=0.0)
        inside = [word for word in vocabulary if len(word) >= WITHIN and word in joined]
        inside = [
            word
            for word in inside
            if not any(longer in joined for longer in NOT_WITHIN.get(word, ()))
        ]
        scores[role] = max(exact, max((0.8 * _weight(word) for word in inside), default=0.0))
    is_error = scores["error"] > (0.5 if scores["position"] else 0.75)
    if is_error and not _says(words, ("fehlercode", "code", "error_code", "id")):
        scores["error"] += 0.3
    role = max(scores, key=lambda role_name: scores[role_name])
    if any(word in STATUS for word in words) and scores[role] < 0.9:
        return Meaning("status", sure=0.5)
    if not scores[role]:
        return Meaning(reference=reference, actual=actual)
    reference = reference and not (
        actual and not _says(words, ("soll", "sollwert", "setpoint", "command"))
    )
    return Meaning(role, reference, actual, min(scores[role], 1.0))


def _weight(word: str) -> float:
    """Return the weight of a word: single letters mean many things."""
    return {1: 0.4, 2: 0.7}.get(len(word), 1.0)


def _says(words: Sequence[str], vocabulary: Sequence[str]) -> bool:
    joined, short = "".join(words), ("set", "act", "ist", "ref", "cmd")
    return any(
        word in words
        or (len(word) >= WITHIN and word in joined)
        or (word in short and (joined.startswith(word) or joined.endswith(word)))
        for word in vocabulary
    )


def without_part(joined: str) -> str:
    """Return the letters of a name without the part for reference or measured."""
    for word in sorted((*REFERENCE, *ACTUAL), key=len, reverse=True):
        # Words of 3 letters for a reference count at the start or end of a name.
        if 3 <= len(word) < len(joined) and (joined.startswith(word) or joined.endswith(word)):
            return (
                joined.removeprefix(word) if joined.startswith(word) else joined.removesuffix(word)
            )
    return joined


def is_of_load(name: str) -> bool:
    """Return whether a name is that of the load side of a drive, such as a scale at the table."""
    words = words_of(name)
    joined = "".join(words)
    return any(
        word in words or joined.startswith(word) or joined.endswith(word) for word in OF_LOAD
    )


def is_of_motor(name: str) -> bool:
    """Return whether a name is that of the motor side of a gear."""
    words = words_of(name)
    return "motor" in "".join(words) or "mot" in words


def is_time(name: str) -> bool:
    """Return whether a column has a usual name of a time."""
    meaning = meaning_of(name)
    return meaning.role == "time" and meaning.sure >= 0.4 and not meaning.reference


NANOMETERS, LENGTHS = "nm", ("position", "error")  # or newton meters; roles that are lengths
ENDINGS = spelt(
    "s: s | sec | seconds; ms: ms | msec; us: us | usec; ns: ns | nanosec; m: m; mm: mm; um: um; N*m: nm; rad: rad; mrad: mrad; "
    "deg: deg | grad; rev: rev; mm/s: mms; rpm: rpm | umin; rad/s: rads; deg/s: degs | dps; N: n; kN: kn; A: a | amps; mA: ma; V: v; "
    "%: percent | pct; ‰: permille; count: inc | counts | cnt; m/s: mps; mN*m: mnm"
)


def unit_in_name(name: str) -> str:
    """Return the unit at the end of a name, after a slash, a blank or an underscore; empty if there is none."""
    parts = [part for part in re.split(r"[\s_\-./\[\]()]+", name.strip()) if part]
    if (
        len(parts) > 2
        and parts[-1].lower() in ("s", "sec", "min")
        and parts[-2].lower() in ("mm", "m", "um", "rad", "deg", "rev", "u")
    ):
        return plain_unit(f"{parts[-2].lower()}/{parts[-1].lower().removesuffix('ec')}")
    if len(parts) < 2 or len(parts[-1]) > 8:
        return ""
    if parts[-1] == NANOMETERS:
        before = _meaning(words_of(" ".join(parts[:-1])))
        return (
            "nm"
            if before.role in LENGTHS
            else ""
            if before.reference and not before.role
            else ENDINGS[NANOMETERS]
        )
    return "um" if parts[-1] in ("µm", "μm") else ENDINGS.get(parts[-1].lower(), "")


def other_unit_in(name: str, declared: str) -> str:
    """Return the unit at the end of a name if it differs from the declared one; else an empty text."""
    called = unit_in_name(name)
    if not called or not units.is_unit(declared):
        return ""
    same = units.compatible(called, declared) and np.isclose(
        units.factor(called, declared), 1.0, rtol=1e-9
    )
    return "" if same else called


def unit_of_time(name: str, values: np.ndarray) -> str:
    """Return the unit of stamps without a unit, from their name, or from counts since 1970 or from 0."""
    named = unit_in_name(name)
    if named in ("s", "ms", "us", "ns"):
        return named
    largest = float(np.max(np.abs(values))) if values.size else 0.0
    step = float(np.nanmedian(np.abs(np.diff(values)))) if values.size > 1 else 0.0
    for bound, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")):
        if largest > bound:
            return unit
    # No axis has samples more than 0.05 s apart.
    return "ms" if largest < 1e8 and step > 0.05 else "s"

"""What columns are called: the words of drives and of people, in English and German, and units as they are written."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple
from unicodedata import normalize

import numpy as np

from bristle.core import units
from bristle.logs.names import listed, plain_unit, spelt
from bristle.logs.table import without_index

# Words that mean a role. A long one counts within a compound as well: "lageistwert", "positionActual".
ROLES: dict[str, tuple[str, ...]] = {
    "time": listed("time zeit timestamp zeitstempel t stamp sec secs second seconds sekunden temps tiempo tempo abtastzeitpunkt elapsed"),
    "error": listed(
        "followingerror schlepp poserr positionerror lageabweichung regelabweichung regeldifferenz contouringerror trackingerror poslag "
        "posdiff ctrldev schleppabstand schleppfehler perr pe positioningerror lagefehler following fehler error err deviation"
    ),
    "effort": listed(
        "torque trq tau moment drehmoment momentenistwert nm force kraft effort current actcurr strom iq isq icmd ist_strom motorstrom "
        "amps ampere motorcurrent load thrust stellgroesse stellgrosse control voltage spannung u pwm vorschubkraft m f i couple "
        "stromsoll last auslastung duty"
    ),
    "velocity": listed("velocity vel speed geschwindigkeit geschw drehzahl rpm omega v qd dq nist nsoll rate spd n w vitesse xdot qdot"),
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
ACTUAL = listed("act actual ist istwert fbk feedback fb meas measured measurement real rbv current_position gemessen mess messwert state")
WITHIN = 4  # letters from which on a word counts within another one
# Parts of longer words that mean something else than they say.
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
    """What the name of a column means."""

    role: str = ""
    reference: bool = False
    actual: bool = False
    sure: float = 0.0


def words_of(name: str) -> list[str]:
    """Return the words of a name, in small letters without accents."""
    folded = name.replace("ß", "ss")
    for umlaut, plain in (("ä", "ae"), ("ö", "oe"), ("ü", "ue"), ("Ä", "Ae"), ("Ö", "Oe"), ("Ü", "Ue")):
        folded = normalize("NFC", folded).replace(umlaut, plain)
    folded = normalize("NFKD", folded).encode("ascii", "ignore").decode()
    split = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", folded)
    return [word.lower() for word in re.split(r"[^A-Za-z]+", split) if word]


@lru_cache(maxsize=2**16)
def meaning_of(name: str, about: str = "") -> Meaning:
    """Return what the name of a column means; what else is said of it counts where the name says nothing."""
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
    reference, actual = best.reference or (full.reference and not best.actual), best.actual or (full.actual and not best.reference)
    return best._replace(reference=reference, actual=actual)


def _meaning(words: Sequence[str]) -> Meaning:
    if len(words) > 1 and words[-1] == NANOMETERS and (before := _meaning(words[:-1])).role in LENGTHS:
        return before
    reference, actual = _says(words, REFERENCE), _says(words, ACTUAL)
    joined = "".join(words)
    scores: dict[str, float] = {}
    for role, vocabulary in ROLES.items():
        exact = max((_weight(word) for word in words if word in vocabulary), default=0.0)
        inside = [word for word in vocabulary if len(word) >= WITHIN and word in joined]
        inside = [word for word in inside if not any(longer in joined for longer in NOT_WITHIN.get(word, ()))]
        scores[role] = max(exact, max((0.8 * _weight(word) for word in inside), default=0.0))
    is_error = scores["error"] > (0.5 if scores["position"] else 0.75)
    if is_error and not _says(words, ("fehlercode", "code", "error_code", "id")):
        scores["error"] += 0.3
    role = max(scores, key=lambda role_name: scores[role_name])
    if any(word in STATUS for word in words) and scores[role] < 0.9:
        return Meaning("status", sure=0.5)
    if not scores[role]:
        return Meaning(reference=reference, actual=actual)
    reference = reference and not (actual and not _says(words, ("soll", "sollwert", "setpoint", "command")))
    return Meaning(role, reference, actual, min(scores[role], 1.0))


def _weight(word: str) -> float:
    """Return how much a word tells: single letters mean many things."""
    return {1: 0.4, 2: 0.7}.get(len(word), 1.0)


def _says(words: Sequence[str], vocabulary: Sequence[str]) -> bool:
    joined, short = "".join(words), ("set", "act", "ist", "ref", "cmd")
    return any(
        word in words or (len(word) >= WITHIN and word in joined) or (word in short and (joined.startswith(word) or joined.endswith(word)))
        for word in vocabulary
    )


def without_part(joined: str) -> str:
    """Return the letters of a name without the part that says whether it is a reference or was measured."""
    for word in sorted((*REFERENCE, *ACTUAL), key=len, reverse=True):
        # 3 letters of a word for a reference that begins or ends a name
        if 3 <= len(word) < len(joined) and (joined.startswith(word) or joined.endswith(word)):
            return joined.removeprefix(word) if joined.startswith(word) else joined.removesuffix(word)
    return joined


def is_time(name: str) -> bool:
    """Return whether a column is called as times usually are."""
    meaning = meaning_of(name)
    return meaning.role == "time" and meaning.sure >= 0.4 and not meaning.reference


NANOMETERS, LENGTHS = "nm", ("position", "error")  # or newton meters; roles that are lengths
ENDINGS = spelt(
    {
        "s": "s | sec | seconds",
        "ms": "ms | msec",
        "us": "us | usec",
        "ns": "ns | nanosec",
        "m": "m",
        "mm": "mm",
        "um": "um",
        "N*m": "nm",
        "rad": "rad",
        "mrad": "mrad",
        "deg": "deg | grad",
        "rev": "rev",
        "mm/s": "mms",
        "rpm": "rpm | umin",
        "rad/s": "rads",
        "deg/s": "degs | dps",
        "N": "n",
        "kN": "kn",
        "A": "a | amps",
        "mA": "ma",
        "V": "v",
        "%": "percent | pct",
        "‰": "permille",
        "count": "inc | counts | cnt",
        "m/s": "mps",
        "mN*m": "mnm",
    }
)


def unit_in_name(name: str) -> str:
    """Return the unit that a name ends with behind a stroke, a blank or an underscore; empty where it names none."""
    parts = [part for part in re.split(r"[\s_\-./\[\]()]+", name.strip()) if part]
    if len(parts) > 2 and parts[-1].lower() in ("s", "sec", "min") and parts[-2].lower() in ("mm", "m", "um", "rad", "deg", "rev", "u"):
        return f"{plain_unit(parts[-2])}/{parts[-1].lower()[:3].removesuffix('ec')}".replace("rev/min", "rpm")
    if len(parts) < 2 or len(parts[-1]) > 8:
        return ""
    if parts[-1] == NANOMETERS:
        before = _meaning(words_of(" ".join(parts[:-1])))
        return "nm" if before.role in LENGTHS else "" if before.reference and not before.role else ENDINGS[NANOMETERS]
    return "um" if parts[-1] in ("µm", "μm") else ENDINGS.get(parts[-1].lower(), "")


def other_unit_in(name: str, declared: str) -> str:
    """Return the unit that a name ends with where it is another one than that declared; else nothing."""
    called = unit_in_name(name)
    if not called or not units.is_unit(declared):
        return ""
    same = units.compatible(called, declared) and np.isclose(units.factor(called, declared), 1.0, rtol=1e-9)
    return "" if same else called


def unit_of_time(name: str, values: np.ndarray) -> str:
    """Return the unit of stamps that have none: that in their name, or in which they count since 1970 or from 0 on.

    No axis is sampled so seldom that steps of more than a twentieth could be seconds.
    """
    named = unit_in_name(name)
    if named in ("s", "ms", "us", "ns"):
        return named
    largest = float(np.max(np.abs(values))) if values.size else 0.0
    step = float(np.nanmedian(np.abs(np.diff(values)))) if values.size > 1 else 0.0
    for bound, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")):
        if largest > bound:
            return unit
    return "ms" if largest < 1e8 and step > 0.05 else "s"

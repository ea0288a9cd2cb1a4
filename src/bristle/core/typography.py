"""Numbers and units as people read them: a fitting multiple of the unit, digits that the uncertainty allows."""

import math
import re
from typing import Any, NamedTuple

# Multiples in use: symbol, the power of ten that it stands for, and the magnitude [SI] from which it is read best.
_METRE = (("{}", 0, 1.0), ("m{}", -3, 1e-3), ("µ{}", -6, 1e-6), ("n{}", -9, 1e-9))
_NEWTON = (("k{}", 3, 1e4), *_METRE[:3])
_MULTIPLES = dict.fromkeys(("m", "rad", "s"), _METRE) | dict.fromkeys(("N", "V", "A"), _NEWTON) | {"Hz": _NEWTON[:2]}
_WHOLE_UNITS = {"kg*m^2": (("kg*m^2", 0, 0.1), ("kg*cm^2", -4, 1e-5), ("g*cm^2", -7, 0.0)), "kg": (("kg", 0, 0.1), ("g", -3, 0.0))}
LARGEST_WRITTEN_OUT = 1e12  # what is larger is told by its power of ten


class Scale(NamedTuple):
    """A multiple of a unit: `factor` times a number in SI is a number in `unit`, which is set for reading."""

    factor: float
    unit: str

    def label(self, word: str) -> str:
        """Return a word with the unit behind it, as it stands at an axis or above a column."""
        return f"{word} [{self.unit}]" if self.unit else word


def escaped(text: str) -> str:
    """Return text that can be written: bytes of a file's name that are no letters stand there as their numbers."""
    return re.sub("[\udc80-\udcff]", lambda byte: f"\\x{ord(byte[0]) - 0xDC00:02x}", text)  # as `os.fsdecode` has them


def printable(text: str) -> str:
    """Return text in which everything can be printed; the name of a file or a column may hold anything."""
    return "".join(letter if letter.isprintable() else " " for letter in escaped(text))


def typeset(unit: str) -> str:
    """Return a unit set for reading; nothing for a plain number."""
    if unit == "1":
        return ""
    unit = re.sub(r"\bu(?=(m|rad|s|N)\b)", "µ", unit).replace("*", "·")
    return re.sub(r"\^2(?!\.)", "²", unit)


def scale_of(unit: str, magnitude: float) -> Scale:
    """Return the multiple of an SI unit in which a number of this magnitude is read best.

    Examples
    --------
    >>> scale_of("m", 7e-6), scale_of("N*m", 0.04), scale_of("kg*m^2", 4e-4)
    (Scale(factor=1000000.0, unit='µm'), Scale(factor=1000.0, unit='mN·m'), Scale(factor=10000.0, unit='kg·cm²'))
    """
    magnitude = abs(magnitude)
    if magnitude == 0.0 or not math.isfinite(magnitude):
        return Scale(1.0, typeset(unit))
    # A prefix before a power would be raised with it.
    symbol = re.match(r"(?:[A-Za-z]+(?![A-Za-z^]))?", unit)[0]  # type: ignore[index]
    steps = _WHOLE_UNITS.get(unit) or _MULTIPLES.get(symbol, _METRE[:1])
    pattern, power, _ = next((step for step in steps if magnitude >= step[2] * (1 - 1e-12)), steps[-1])
    return Scale(float(f"1e{-power}"), typeset(pattern.format(unit)))


def number(value: float, resolution: float | None = None, digits: int = 4) -> str:
    """Return a number to two digits of its resolution, such as a standard error, or to `digits` of its own."""
    if not math.isfinite(value):
        return "–" if math.isnan(value) else f"{value}".replace("inf", "∞").replace("-", "−")
    if resolution is not None and 0.0 < resolution < math.inf:
        decimals = 1 - math.floor(math.log10(resolution))
    elif value == 0.0:
        decimals = 0
    else:
        decimals = digits - 1 - math.floor(math.log10(abs(value)))
    if resolution is not None and decimals < 0:
        value = round(value, decimals)
    if decimals > 9 or abs(value) >= LARGEST_WRITTEN_OUT:
        return f"{value:.{digits - 1}e}".replace("-", "−")
    text = f"{value:.{max(decimals, 0)}f}".replace("-", "−")
    return text if any(digit in text for digit in "123456789") else text.removeprefix("−")


def typed(value: Any) -> str:
    """Return a value as one types it: a number in six digits, several in brackets, a name as it is."""
    if isinstance(value, str):
        return value
    if hasattr(value, "__len__"):
        return "[" + ", ".join(f"{number:.6g}" for number in value) + "]"
    return f"{value:.6g}"


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """Return a number in SI with a fitting multiple of its unit behind it, to `digits` at most."""
    scale = scale_of(unit, value)
    text = number(value * scale.factor, digits=digits)
    if "." in text and "e" not in text:
        text = text.rstrip("0").rstrip(".")
    return f"{text} {scale.unit}".rstrip()
